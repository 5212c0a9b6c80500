"""The wheel of this platform, with the compiled kernels of the folder that TOOLPACE_BUILT names (`make wheel`)."""

from __future__ import annotations

import os
import sys
import sysconfig
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompiledKernels(BuildHookInterface):
    """Takes compiled kernels into the wheel, and names it for the interpreter and platform that they are for."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Do nothing where no folder is named: the wheel is for every platform then, and its first run compiles."""
        folder = os.environ.get("TOOLPACE_BUILT")
        if not folder or version == "editable":
            return
        python = f"cp{sys.version_info.major}{sys.version_info.minor}"
        build_data["tag"] = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
        build_data["pure_python"] = False
        build_data["force_include"][folder] = "toolpace/kernels/built"

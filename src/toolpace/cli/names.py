"""Names of many programs in a table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path


def short_names(programs: Sequence[str]) -> list[str]:
    """The names without the folder in which all of them lie; as they are where some are relative and some not."""
    if len({Path(program).is_absolute() for program in programs}) != 1:
        return list(programs)
    folder = os.path.commonpath([Path(program).parent for program in programs])
    return [os.path.relpath(program, folder) if folder else program for program in programs]

"""The import of LinuxCNC's Python module `hal`."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

from toolpace.common.errors import UsageError

PLACES = (Path("/usr/lib/python3/dist-packages"),)
"""Where Debian has it."""


def hal_module(places: tuple[Path, ...] = PLACES) -> Any:
    """The module `hal`, from Python's own path or from where LinuxCNC is installed. Raises UsageError with the cure."""
    if "hal" in sys.modules:
        return sys.modules["hal"]
    found = [str(place) for place in places if (place / "hal.py").is_file()]
    # last, and for this import alone: the packages beside it are of the system's Python
    sys.path.extend(found)
    try:
        return importlib.import_module("hal")
    except ImportError as error:
        if found:
            raise UsageError(
                f"{found[0]}: LinuxCNC's module hal does not load in Python {sys.version.split()[0]} ({error}); run"
                " toolpace with the Python that LinuxCNC was built for, /usr/bin/python3"
            ) from None
        raise UsageError(
            "LinuxCNC's Python module hal was not found; install LinuxCNC (Debian: apt-get install linuxcnc-uspace), or"
            " name the folder of hal.py in PYTHONPATH"
        ) from None
    finally:
        for place in found:
            sys.path.remove(place)

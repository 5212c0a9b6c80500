"""Program files from a file, a folder or a pattern."""

from __future__ import annotations

import functools
import glob
import os
from pathlib import Path

from toolpace.common.files import is_folder
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.languages import SUFFIXES


@functools.cache
def suffixes() -> frozenset[str]:
    """With which names of programs end, in lower case."""
    built_in = (Controller.load(name).suffixes for name in Controller.names())
    return frozenset(SUFFIXES).union(*built_in)


def programs_in(named: str) -> list[str]:
    """The programs that a name stands for, in the order of their names; none where nothing fits.

    A file is itself, whatever it is called, and so is what is not there: whoever reads it says so. Of a folder it is
    the files whose names end like those of programs, of a pattern (*.ngc) those that fit.
    """
    path = Path(named)
    if is_folder(path):
        return sorted(str(each) for each in path.iterdir() if each.is_file() and _is_program(each))
    if os.path.lexists(path) or not glob.has_magic(named):
        return [named]
    # Not Path's: its ** stands for folders alone, and its * for hidden files too.
    return sorted(each for each in glob.glob(named, recursive=True) if Path(each).is_file())  # noqa: PTH207


def _is_program(path: Path) -> bool:
    return path.suffix.lower() in suffixes() and not path.name.startswith(".")

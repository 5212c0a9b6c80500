"""Names of many programs in a table, and of those with an error."""

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


def named_error(program: str, error: str) -> str:
    """What is wrong with a program, with its name before it where the error does not begin with it."""
    return error if error.startswith(program) else f"{program}: {error}"

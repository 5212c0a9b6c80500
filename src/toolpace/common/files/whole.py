"""Files written under a temporary name, then renamed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.common.files.signals import uninterrupted
from toolpace.common.files.temporary import Temporary, sweep


def reason(error: OSError | ValueError) -> str:
    """What the system says about a failed file operation, in lower case and without a number."""
    return (getattr(error, "strerror", None) or str(error)).lower()


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name beside `path`; rename it to `path` when the block ends well, remove it when
    not."""
    target = Path(path)
    try:
        if "\0" in str(target):
            raise ValueError("no name of a file has a zero byte")
        target.parent.mkdir(parents=True, exist_ok=True)
        sweep(target)
        with uninterrupted():
            temporary = Temporary(target, folder=False)
    except (OSError, ValueError) as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    try:
        yield temporary.path
        temporary.path.replace(target)
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    finally:
        with uninterrupted():
            temporary.remove()


def file_to_write(path: str | os.PathLike[str]) -> Path:
    """The place for a new file, found fit for it before any work is done: its folder is there and can be written to,
    and nothing is in the place but perhaps an empty file. Raises UsageError with the reason and the cure."""
    given, target = os.fspath(path), Path(path)
    try:
        if not given:
            raise UsageError("the name of the file is empty; give one")
        if target.is_dir():
            raise UsageError(f"{given}: is a folder; give the name of a file in it")
        if not target.parent.is_dir():
            raise UsageError(f"{given}: there is no folder {target.parent}; make it, or give another place")
        if os.path.lexists(target) and not (target.is_file() and target.stat().st_size == 0):
            raise UsageError(f"{given}: is there already; give another name")
        target.exists()
        # Only by making one is it known: rights, disks that take no writing.
        with uninterrupted():
            Temporary(target, folder=False).remove()
    except (OSError, ValueError) as error:
        raise UsageError(f"{given}: cannot be written: {reason(error)}; give another place") from None
    return target


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")

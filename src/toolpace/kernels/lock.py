"""A lock on a file, held by one process and released when it ends."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import TracebackType
from typing import IO, Any


class FileLock:
    """The lock on one file, which is made where it is not there."""

    def __init__(self, file: Path) -> None:
        """Take the file's name."""
        self._path = file
        self._file: IO[bytes] | None = None

    def take(self) -> bool:
        """Whether this process has the lock now; raises OSError where the system knows no locks."""
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("ab")
        try:
            if (posix := _module("fcntl")) is not None:
                posix.flock(self._file.fileno(), posix.LOCK_EX | posix.LOCK_NB)
            elif (windows := _module("msvcrt")) is not None:
                windows.locking(self._file.fileno(), windows.LK_NBLCK, 1)
            else:
                raise OSError("this system knows no locks")
        except (BlockingIOError, PermissionError):
            return False
        return True

    def __enter__(self) -> FileLock:
        """Nothing is locked before `take`."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Let go: a file that is closed is no longer locked."""
        if self._file is not None:
            self._file.close()


def _module(name: str) -> Any:
    """A module of one kind of system; None on the others."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None

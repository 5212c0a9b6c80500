"""A lock on a file, held by one process and released when it ends."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import TracebackType
from typing import IO, Any


class NoLocksError(OSError):
    """The system, or the file system, knows no locks."""


class FileLock:
    """The lock on one file, which is made where it is not there."""

    def __init__(self, file: Path) -> None:
        """Take the file's name."""
        self._path = file
        self._file: IO[bytes] | None = None

    def take(self) -> bool:
        """Whether this process has the lock now; raises NoLocksError where nothing can be locked."""
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("ab")
        posix, windows = _module("fcntl"), _module("msvcrt")
        if posix is None and windows is None:
            raise NoLocksError("this system knows no locks")
        try:
            if posix is not None:
                posix.flock(self._file.fileno(), posix.LOCK_EX | posix.LOCK_NB)
            else:
                windows.locking(self._file.fileno(), windows.LK_NBLCK, 1)
        except (BlockingIOError, PermissionError):
            return False
        except OSError as error:
            raise NoLocksError(error.errno, error.strerror) from error
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

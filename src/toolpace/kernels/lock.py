"""A lock on a file, held by one process and released when it ends."""

from __future__ import annotations

import sys
from pathlib import Path
from types import TracebackType
from typing import IO

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl


class FileLock:
    """The lock on one file, which is made where it is not there."""

    def __init__(self, file: Path) -> None:
        """Take the file's name."""
        self._path = file
        self._file: IO[bytes] | None = None

    def take(self) -> bool:
        """Whether this process has the lock now; raises OSError where the file system knows no locks."""
        if self._file is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("ab")
        try:
            if sys.platform == "win32":
                msvcrt.locking(self._file.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                fcntl.flock(self._file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
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

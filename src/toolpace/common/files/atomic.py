"""Files written completely or not at all, by renaming a temporary file; and binary files read, with one error.

A temporary file or folder is called `.toolpace-new-...` and lies beside what it will become, so that moving it is a
rename on one disk. Its maker holds a lock on it, which the system lets go when the process ends, however it ends. So
whoever comes next may remove what is not locked, and never takes anything from a run under way.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import re
import secrets
import shutil
import signal
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, BinaryIO, TypeVar

from toolpace.common.errors import UsageError
from toolpace.common.files.seal import foreign, read_seal

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that ask a process to end and leave it the time to clean up."""
_OURS = re.compile(r"\.toolpace-(?P<kind>new|old)-(?P<target>[0-9a-f]{8})-[0-9a-f]{8}(?:\.[A-Za-z0-9]{1,8})?")
TRIES = 100
"""Names that are tried before something else must be wrong."""
PATIENCE = 10.0
"""How long the lock on a folder of results is waited for [s]: a run holds it while it puts its own in the place."""
AGAIN = "plan again, into a new folder"
"""The cure for a binary file that cannot be read."""
Content = TypeVar("Content")


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
        raise _unwritten(target, error) from None
    try:
        yield temporary.path
        temporary.path.replace(target)
    except OSError as error:
        raise _unwritten(target, error) from None
    finally:
        with uninterrupted():
            temporary.remove()


def _unwritten(target: Path, error: OSError | ValueError) -> Exception:
    """What is raised where a file cannot be written: the error as it is where the file is one of a temporary folder, of
    which whoever made that tells whose place it was to take."""
    in_folder = isinstance(error, OSError) and _OURS.fullmatch(target.parent.name)
    return error if in_folder else UsageError(f"{target}: cannot write: {reason(error)}")


def file_to_write(path: str | os.PathLike[str]) -> Path:
    """The place for a new file, found fit for it before any work is done: its folder is there and can be written to,
    and nothing is in the place but perhaps an empty file. Raises UsageError with the reason and the cure."""
    shown, target = os.fspath(path), Path(path)
    try:
        if not shown:
            raise UsageError("the name of the file is empty; give one")
        if target.is_dir():
            raise UsageError(f"{shown}: is a folder; give the name of a file in it")
        if not target.parent.is_dir():
            raise UsageError(f"{shown}: there is no folder {target.parent}; make it, or give another place")
        if os.path.lexists(target) and not (target.is_file() and target.stat().st_size == 0):
            raise UsageError(f"{shown}: is there already; give another name")
        target.exists()
        # Only by making one is it known: rights, disks that take no writing.
        with uninterrupted():
            Temporary(target, folder=False).remove()
    except (OSError, ValueError) as error:
        raise UsageError(f"{shown}: cannot be written: {reason(error)}; give another place") from None
    return target


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def temporary_name(target: Path, kind: str = "new", suffix: str = "") -> Path:
    """A name that nobody else will use, as short as can be: that of its target may be as long as names are."""
    suffix = suffix if re.fullmatch(r"\.[A-Za-z0-9]{1,8}", suffix) else ""
    return target.parent / f".toolpace-{kind}-{_mark(target)}-{secrets.token_hex(4)}{suffix}"


class Temporary:
    """A temporary file or folder, and the lock on it."""

    def __init__(self, target: Path, *, folder: bool) -> None:
        """Make it beside the target, with the rights that new files have. Raises OSError."""
        for _ in range(TRIES):
            self.path = temporary_name(target, suffix="" if folder else target.suffix)
            if folder:
                self.path.mkdir()
            else:
                os.close(os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            try:
                self._handle = _locked(self.path)
            except (BlockingIOError, FileNotFoundError):
                # Somebody who cleans up came between the name and the lock, and removes it.
                continue
            if self._handle is None or _is_at(self._handle, self.path):
                return
            os.close(self._handle)
        raise OSError(f"{target.parent}: temporary files vanish as soon as they are made")

    def remove(self) -> None:
        """Remove whatever has its name, and let go of the lock."""
        _remove(self.path)
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold what is in a place while it is looked at and replaced: no other run replaces or sweeps it meanwhile.

    Nothing is held where nothing is there, where the system has no locks, or where somebody keeps it for too long.
    """
    handle, until = None, time.monotonic() + PATIENCE
    while handle is None and time.monotonic() < until:
        try:
            handle = _locked(folder)
        except BlockingIOError:
            time.sleep(0.005)
            continue
        except OSError:
            break
        if handle is None:
            break
        if not _is_at(handle, folder):
            os.close(handle)
            handle = None
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def sweep(target: Path) -> None:
    """Remove what killed runs have left beside a target; a folder that one of them had moved away comes back.

    What is locked belongs to a run under way; what is another user's, or holds what toolpace did not write, stays.
    """
    if sys.platform == "win32" or _locks() is None:
        return
    try:
        with os.scandir(target.parent) as entries:
            found = [Path(entry.path) for entry in entries if _OURS.fullmatch(entry.name)]
    except OSError:
        return
    for path in found:
        try:
            state = path.lstat()
            if state.st_uid != os.geteuid() or not (stat.S_ISDIR(state.st_mode) or stat.S_ISREG(state.st_mode)):
                continue
            handle = _locked(path)
        except OSError:
            continue
        if handle is None:
            continue
        try:
            match = _OURS.fullmatch(path.name)
            moved_away = match is not None and match["kind"] == "old" and match["target"] == _mark(target)
            if moved_away and not os.path.lexists(target):
                path.rename(target)
            elif _is_at(handle, path) and _only_ours(path):
                _remove(path)
        except OSError:
            continue
        finally:
            os.close(handle)


def _only_ours(path: Path) -> bool:
    """Whether nothing but what toolpace wrote is lost with it: a finished folder tells; others hold plain files."""
    if not path.is_dir():
        return True
    if read_seal(path) is not None:
        return foreign(path) == ""
    with os.scandir(path) as entries:
        return all(entry.is_file(follow_symlinks=False) for entry in entries)


def _mark(target: Path) -> str:
    return hashlib.sha256(os.fsencode(target.name)).hexdigest()[:8]


def _locks() -> Any:
    """The module of locks on open files; None where the system has none, as Windows."""
    try:
        return importlib.import_module("fcntl")
    except ImportError:
        return None


def _locked(path: Path) -> int | None:
    """A handle that holds the lock on a path, or None where the system has no such locks.

    Raises BlockingIOError where somebody else has it, OSError where the path cannot be opened.
    """
    locks = _locks()
    if sys.platform == "win32" or locks is None:
        return None
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        locks.flock(handle, locks.LOCK_EX | locks.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:
        os.close(handle)
        return None
    return handle


def _is_at(handle: int, path: Path) -> bool:
    """Whether a handle is of what the path names now."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except OSError:
        return False


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Run the block to its end; a signal that came meanwhile is raised again behind it.

    Python runs handlers in the main thread only: in others there is nothing to put off.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    before = {}
    try:
        for number in ENDING:
            handler = signal.getsignal(number)
            # None: a handler that Python did not set, and could not put back.
            if handler is not None:
                before[number] = handler
                signal.signal(number, note)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


def read_binary(
    path: str | os.PathLike[str], read: Callable[[BinaryIO], Content], missing: str, what: str
) -> Content:
    """What `read` makes of the open file.

    `missing` says where such a file comes from, `what` what it ought to be ("a trajectory"). Whatever a reader of
    damaged bytes may raise, and a UsageError of it, becomes a UsageError that begins with the file.
    """
    source = Path(path)
    try:
        with source.open("rb") as stream:
            return read(stream)
    except FileNotFoundError:
        raise UsageError(f"{source}: no such file; {missing}") from None
    except OSError as error:
        raise UsageError(f"{source}: cannot read: {reason(error)}") from None
    except UsageError as error:
        raise UsageError(f"{source}: {error}; {AGAIN}") from None
    except (ValueError, LookupError, TypeError, ArithmeticError, RecursionError):
        raise UsageError(f"{source}: damaged or not {what}; {AGAIN}") from None


def refuse_other_format(stream: BinaryIO, first_line: bytes) -> None:
    """Read the first line of a binary file, a name and the number of the format. Raises UsageError for another number,
    ValueError for another name."""
    line = stream.read(len(first_line))
    if line == first_line:
        return
    if line.startswith(first_line[: first_line.rindex(b" ") + 1]) and line.endswith(b"\n"):
        raise UsageError("is in a format of another version of toolpace, which this one does not read")
    raise ValueError

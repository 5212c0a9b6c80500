"""Folders of results: written beside their place, then put there in one step."""

from __future__ import annotations

import ctypes
import errno
import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.common.files.atomic import TRIES, Temporary, held, reason, sweep, temporary_name, uninterrupted
from toolpace.common.files.seal import foreign, read_seal, write_seal

finished: list[Path] = []
"""Folders that this process has put in their places, for whoever must say after an interrupt what was written."""
_FILLED = (errno.ENOTEMPTY, errno.EEXIST)
_HERE = -100
"""AT_FDCWD: relative paths start at the working directory."""
_EXCHANGE = 2
"""RENAME_EXCHANGE."""
_CANNOT = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)
"""What the kernel says where it, or the file system, has no exchange."""


def is_folder(path: str | os.PathLike[str]) -> bool:
    """Whether it is one; a name that no file can have, as one that is too long, is that of none."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def folder_to_write(folder: str | os.PathLike[str]) -> Path:
    """The place for a folder of results, links followed, found fit for it before any work is done.

    It is missing, empty, or as toolpace wrote it; new folders can be made beside it; what killed runs left there is
    removed. Raises UsageError with the reason and the cure.
    """
    shown = os.fspath(folder)
    try:
        if not shown:
            raise UsageError("the name of the folder is empty; give one like part-plan")
        target = Path(shown).resolve()
        with held(target):
            _refuse_taken(target, shown)
        # Only by making one is it known: rights, disks that take no writing, names that are too long.
        with uninterrupted():
            sweep(target)
            _made_beside(lambda: _nearest(target.parent) / target.name).remove()
        (target / ".toolpace-new-01234567-01234567.html").exists()
    except (OSError, ValueError, RuntimeError) as error:
        why = reason(error) if not isinstance(error, RuntimeError) else "its links go round in a circle"
        raise UsageError(f"{shown}: cannot be written: {why}; give another folder") from None
    return target


@contextmanager
def whole_folder(folder: str | os.PathLike[str], seal: str = "") -> Iterator[Path]:
    """Yield an empty temporary folder; put it in the place of `folder` when the block ends well, remove it when not.

    What was there before is replaced as a whole, and only where toolpace wrote all of it (UsageError otherwise): at
    every moment the one or the other is there, whole. `seal` names the JSON file in it by which it will be known.
    """
    target = folder_to_write(folder)
    _refuse_other_kind(target, os.fspath(folder), seal)
    made: list[Path] = []
    temporary: Temporary | None = None
    try:
        with uninterrupted():
            temporary = _made_beside(lambda: _with_parents(target, made))
        yield temporary.path
        if seal:
            write_seal(temporary.path, seal)
        for file in [*temporary.path.iterdir(), temporary.path]:
            _to_disk(file)
        with uninterrupted():
            _put(temporary.path, target, os.fspath(folder))
            made.clear()
            finished.append(target)
            temporary.remove()
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    finally:
        with uninterrupted():
            if temporary is not None:
                temporary.remove()
            for parent in reversed(made):
                _remove_empty(parent)


def _put(new: Path, target: Path, shown: str) -> None:
    """Put a folder in its place; what was there has the temporary name afterwards."""
    try:
        # Also where an empty folder is: the system puts the new one over it.
        new.rename(target)
        return
    except OSError as error:
        if error.errno not in _FILLED:
            raise
    with held(target):
        _exchange_whole(new, target, shown)


def _exchange_whole(new: Path, target: Path, shown: str) -> None:
    """Let a folder take the place of one that toolpace wrote, which is held meanwhile."""
    _refuse_taken(target, shown)
    new.chmod(stat.S_IMODE(target.stat().st_mode))
    old = new
    if not exchange(new, target):
        # The one moment in which neither is there; who finds the old one alone puts it back.
        old = temporary_name(target, "old")
        target.rename(old)
        try:
            new.rename(target)
        except OSError:
            old.rename(target)
            raise
        old.rename(new)
    if changed := foreign(new):
        # Somebody put something in since it was looked at: all as it was.
        aside = temporary_name(target)
        if not exchange(new, target):
            target.rename(aside)
            new.rename(target)
            aside.rename(new)
        raise UsageError(f"{shown}: is not replaced, since {changed}; move that away, or give another folder")


def _refuse_other_kind(target: Path, shown: str, seal: str) -> None:
    """Raise UsageError where a result of another kind is in the place: an export never replaces a plan."""
    found = read_seal(target)
    if seal and found is not None and found[0] != seal:
        raise UsageError(f"{shown}: holds another result of toolpace, {found[0]}; give another folder")


def _refuse_taken(target: Path, shown: str) -> None:
    """Raise UsageError where something is in the place that toolpace may not replace; OSError where none can tell."""
    here = Path.cwd()
    if target == here or target in here.parents:
        where = "the folder you are in" if target == here else "above the folder you are in"
        raise UsageError(f"{shown}: is {where}, and results replace a folder as a whole; give one like part-plan")
    if target == Path("~").expanduser().resolve():
        raise UsageError(f"{shown}: is your home folder; give a folder of its own, like part-plan")
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return
    except NotADirectoryError:
        raise UsageError(f"{shown}: a part of this path is a file; give a folder to write into") from None
    if not stat.S_ISDIR(mode):
        raise UsageError(f"{shown}: is a file; give a folder to write into")
    if os.path.ismount(target):
        raise UsageError(
            f"{shown}: is where a disk is mounted; give a folder on it, like {shown.rstrip('/')}/part-plan"
        )
    if changed := foreign(target):
        raise UsageError(
            f"{shown}: is not replaced, since {changed}; give another folder, or move what you want to keep out of it "
            "and remove it"
        )


def _made_beside(place: Callable[[], Path]) -> Temporary:
    """A temporary folder beside a place; another run that ends may remove the folder above it until it holds one."""
    for _ in range(TRIES):
        try:
            return Temporary(place(), folder=True)
        except FileNotFoundError:
            continue
    return Temporary(place(), folder=True)


def _nearest(folder: Path) -> Path:
    """The folder, or the nearest one above it that is there."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder


def _with_parents(target: Path, made: list[Path]) -> Path:
    """The target, the folders above it made."""
    _make_parents(target.parent, made)
    return target


def _make_parents(folder: Path, made: list[Path]) -> None:
    """Make a folder and those above it; `made` tells which were missing."""
    if not folder.is_dir():
        _make_parents(folder.parent, made)
        try:
            folder.mkdir()
            made.append(folder)
        except FileExistsError:
            if not folder.is_dir():
                raise


def _remove_empty(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError:
        # Somebody has put something there.
        return


def _to_disk(path: Path) -> None:
    """Have the system write it out: a name on the disk whose content is not would be half a result."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF):
            raise
    finally:
        os.close(handle)


def exchange(one: Path, other: Path) -> bool:
    """Let two existing paths of one disk change places in one step; False, and nothing done, where that cannot be.

    renameat2 of Linux (3.15, glibc 2.28). At every moment both names are there, each with one of the two.
    Raises OSError.
    """
    if sys.platform != "linux":
        return False
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    rename.argtypes = (ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint)
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in _CANNOT:
        return False
    raise OSError(code, os.strerror(code), str(other))

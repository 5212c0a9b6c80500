"""Files that are either whole or not there: written under a temporary name, then renamed."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolpace.errors import UsageError


def reason(error: OSError) -> str:
    """What the system says about a failed file operation, in lower case and without a number."""
    return (error.strerror or str(error)).lower()


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary name beside `path`; rename it to `path` when the block ends well, remove it when
    not."""
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=target.suffix, dir=target.parent)
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(target)
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


@contextmanager
def whole_folder(folder: str | os.PathLike[str], last: str = "") -> Iterator[Path]:
    """Yield an empty temporary folder; move its files into `folder` when the block ends well, remove it when
    not.

    Files of the same name are replaced, others stay; the file named `last` is moved after all others, so that with it
    they are there. A `folder` that did not exist is not made when the block fails.
    """
    target = Path(folder)
    try:
        if target.exists() and not target.is_dir():
            raise UsageError(f"{target}: is a file; give a folder to write into")
        target.parent.mkdir(parents=True, exist_ok=True)
        # Beside the files it will replace, so that moving them is a rename on the same disk.
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    try:
        yield temporary
        target.mkdir(exist_ok=True)
        for written in sorted(temporary.iterdir(), key=lambda file: (file.name == last, file.name)):
            written.replace(target / written.name)
    except OSError as error:
        raise UsageError(f"{target}: cannot write: {reason(error)}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _umask() -> int:
    """The mask of the process; the system has no way to ask for it but to set it."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask

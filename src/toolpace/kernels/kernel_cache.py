"""The folder of compiled kernels, one file a kernel and signature, and the interface by which numba uses it.

numba's own cache looks at the file of the function only: after an edit in another file that the function inlines,
stale machine code would run. It falls back to a folder beside the sources where its own cannot be written, and raises
where a file is damaged. Here the folder is named after a hash of all that the machine code depends on, a file that is
not whole is made anew, and where no folder can be written, each process compiles for itself. Each of these is told
once, in one line on standard error.

The folder lies in TOOLPACE_CACHE, XDG_CACHE_HOME or ~/.cache, the first of them that can be used. One that is complete
need not be writable: it may be made once for all users of a machine. Folders of other sources, unused for a month, are
removed when a new one is complete.

A wheel brings such folders with it, one for each baseline of the processor (`tools/wheel.py`). The fastest that fits is
read where the user's own folder lacks a kernel, and nothing is written there.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import os
import pickle
import platform
import shutil
import sys
import tempfile
import time
import uuid
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from llvmlite import binding
from numba.core import compiler, config, serialize
from numba.core.runtime import rtsys

from toolpace.kernels.baseline import baselines, processor, usable

COMPLETE = "complete"
"""A file that lists the others with their sizes: all kernels of a first run are there."""
SUFFIX = ".kernel"
DIGEST = 32
"""Bytes of the checksum that a file begins with."""
UNUSED = 30 * 86400.0
"""Age from which a folder of other sources is removed [s]."""
ABANDONED = 3600.0
"""Age from which nobody is writing a file any more [s]."""


BUILT = Path(__file__).parent / "built"
"""Where a wheel has its compiled kernels: a folder for each baseline; there is none beside sources."""
VERSIONS = "versions"
"""A file in each of these: one line a version that they were compiled with, then the key."""


def versions() -> str:
    """What compiles kernels here, in one line."""
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, NumPy {np.__version__}, {python}"


def key(target: str | None = None) -> str:
    """Hash of all that the machine code depends on: kernels, compiler, interpreter, processor, settings.

    target: the processor, name and features; the one of this process where it is None.
    """
    settings = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "ENABLE_AVX")
    parts = [versions(), platform.machine(), sys.platform, processor() if target is None else target]
    parts += [str(getattr(config, setting, None)) for setting in settings]
    digest = hashlib.sha256("\n".join(parts).encode())
    home = Path(__file__).parent
    for source in sorted(home.rglob("*.py")):
        digest.update(f"\n{source.relative_to(home).as_posix()}\n".encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


class Store:
    """A folder of compiled kernels; without one, nothing is found and nothing kept."""

    def __init__(self, folder: Path | None, kept: bool = True, built: Store | None = None) -> None:
        """Take the folder, whether it outlives this process, and one of a wheel to read what this one lacks."""
        self.folder, self.kept, self.built = folder, kept, built
        self.writable = folder is not None

    def load(self, file: str) -> bytes | None:
        """What was saved under a name, here or in the wheel; None where nothing was, or where it is not whole."""
        missing = self.built.load(file) if self.built else None
        if self.folder is None:
            return missing
        try:
            content = (self.folder / file).read_bytes()
        except FileNotFoundError:
            return missing
        except OSError as error:
            self.damaged(file, reason(error))
            return missing
        if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
            self.damaged(file, "damaged")
            return missing
        return content[DIGEST:]

    def save(self, file: str, data: bytes) -> None:
        """Keep some data under a name, whole or not at all, whoever else writes it; give up keeping where it fails."""
        if self.folder is None or not self.writable:
            return
        part = self.folder / f"{file}.{uuid.uuid4().hex[:12]}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            part.write_bytes(hashlib.sha256(data).digest() + data)
            part.replace(self.folder / file)
        except OSError as error:
            with contextlib.suppress(OSError):
                part.unlink()
            warn(f"compiled kernels cannot be kept in {self.folder} ({reason(error)}); the next run compiles again")
            self.writable = False

    def damaged(self, file: str, why: str) -> None:
        """Say that a file is of no use, and have it made anew."""
        warn(f"{file} in {self.folder} is {why}; compiled again")
        with contextlib.suppress(OSError):
            if self.folder is not None:
                (self.folder / file).unlink()

    def files(self) -> dict[str, int]:
        """Names of what is kept, with sizes [bytes]."""
        if self.folder is None:
            return {}
        try:
            return {each.name: each.stat().st_size for each in self.folder.glob(f"*{SUFFIX}")}
        except OSError:
            return {}

    def complete(self) -> bool:
        """Whether all that `mark_complete` found is there still, here or in the wheel."""
        if self.built and self.built.complete():
            return True
        if self.folder is None:
            return False
        try:
            rows = [line.split() for line in (self.folder / COMPLETE).read_text("ascii").splitlines()]
            listed = {file: int(size) for size, file in rows}
        except (OSError, ValueError):
            return False
        there = self.files()
        whole = bool(listed) and all(there.get(file) == size for file, size in listed.items())
        if whole:
            with contextlib.suppress(OSError):
                os.utime(self.folder / COMPLETE)
        return whole

    def mark_complete(self) -> None:
        """List what is there as all that a first run needs, and remove what other sources have left long ago."""
        if self.folder is None:
            return
        part = self.folder / f"{COMPLETE}.{uuid.uuid4().hex[:12]}"
        with contextlib.suppress(OSError):
            part.write_text("".join(f"{size} {file}\n" for file, size in sorted(self.files().items())), "ascii")
            part.replace(self.folder / COMPLETE)
        with contextlib.suppress(OSError):
            for other in self.folder.parent.iterdir():
                if other != self.folder and _is_unused(other):
                    shutil.rmtree(other, ignore_errors=True)
            for part in self.folder.glob(f"*{SUFFIX}.*"):  # of processes that were killed while they wrote
                if time.time() - part.stat().st_mtime > ABANDONED:
                    part.unlink()


def _is_unused(folder: Path) -> bool:
    """Whether a folder is one of compiled kernels, and nobody has used it for long."""
    name = folder.name
    if len(name) != 16 or not set(name) <= set("0123456789abcdef") or not folder.is_dir():
        return False
    used = [each.stat().st_mtime for each in (folder, folder / COMPLETE) if each.exists()]
    return time.time() - max(used) > UNUSED


@functools.cache
def store() -> Store:
    """The folder that this process takes, chosen when the first kernel is called for."""
    name, failed, of_wheel = key(), "", built_store()
    for base in bases():
        found = Store(base / "toolpace" / name, built=of_wheel)
        why = "" if found.complete() else _why_unusable(base / "toolpace" / name)
        if not why:
            if failed:
                warn(f"compiled kernels cannot be kept in {failed}; they are in {base}")
            return found
        failed = failed or f"{base} ({why})"
    warn(f"compiled kernels cannot be kept in {failed or 'any folder'}; every run compiles them again")
    try:
        base = Path(tempfile.mkdtemp(prefix="toolpace-"))
    except OSError:
        return Store(None, kept=False, built=of_wheel)
    atexit.register(_remove, base, os.getpid())
    return Store(base / "toolpace" / name, kept=False, built=of_wheel)


def built_store() -> Store | None:
    """The kernels of the wheel that was installed, if they are of these sources and versions and may run here."""
    if not BUILT.is_dir():
        return None
    compiled_with = ""
    for name in usable():
        try:
            compiled_with, of = (BUILT / name / VERSIONS).read_text("ascii").split("\n")[:2]
        except (OSError, ValueError):
            continue
        if of == key(f"{name} {baselines()[name]}"):
            return Store(BUILT / name)
    why = f"for {compiled_with}; here is {versions()}" if compiled_with else "for no processor such as this one"
    warn(f"the compiled kernels of this installation are {why}; compiled anew")
    return None


def write_built(folder: Path) -> None:
    """Copy the folder of this process, complete, to where a wheel is made of it. Raises OSError."""
    kept = store()
    if kept.folder is None or not kept.complete():
        raise OSError("the kernels are not all compiled")
    folder.mkdir(parents=True)
    for name in (COMPLETE, *kept.files()):
        shutil.copyfile(kept.folder / name, folder / name)
    (folder / VERSIONS).write_text(f"{versions()}\n{kept.folder.name}\n", "ascii")


def bases() -> list[Path]:
    """Folders to keep compiled kernels in, the first to be tried first."""
    named = [Path(named) for each in ("TOOLPACE_CACHE", "XDG_CACHE_HOME") if (named := os.environ.get(each))]
    with contextlib.suppress(RuntimeError):  # there may be no home
        named.append(Path.home() / ".cache")
    return [base.absolute() for base in named]


def _why_unusable(folder: Path) -> str:
    """Why nothing can be written into a folder; empty where something can."""
    part = folder / uuid.uuid4().hex[:12]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        part.write_bytes(bytes(1 << 16))
    except OSError as error:
        return reason(error)
    finally:
        with contextlib.suppress(OSError):
            part.unlink()
    return ""


def _remove(base: Path, owner: int) -> None:
    if os.getpid() == owner:
        shutil.rmtree(base, ignore_errors=True)


def reason(error: OSError) -> str:
    """What the system says of a failure, in a few words."""
    return (error.strerror or type(error).__name__).lower()


@functools.cache
def _warned() -> list[str]:
    return []


def warn(message: str) -> None:
    """Say on standard error, once a process, that something about the cache is not as it should be."""
    if not _warned():
        print(f"warning: {message}", file=sys.stderr, flush=True)
    _warned().append(message)


class KernelCache:
    """What numba asks for a kernel's code, and gives it to; in place of numba's own cache."""

    def __init__(self, name: str) -> None:
        """Take the kernel's name, unique among these sources."""
        self._name = name
        self.cache_path: str | None = None
        self._enabled = True

    def file(self, signature: Any) -> str:
        """Name of the file of one signature, a tuple of numba's types."""
        plain = "".join(c if c.isalnum() or c in "._" else "-" for c in self._name)
        return f"{plain}-{hashlib.sha256(f'{self._name} {signature}'.encode()).hexdigest()[:12]}{SUFFIX}"

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled function for a signature, or None."""
        if not self._enabled:
            return None
        data = store().load(self.file(signature))
        if data is None:
            return None
        # Machine code calls numba's functions for memory. What numba compiles with takes a quarter of a second to
        # set up and is not needed to load it; where something is to be compiled, numba's compiler sets it up.
        rtsys.initialize(target_context)
        try:
            return compiler.CompileResult._rebuild(target_context, *pickle.loads(data))
        except Exception as error:
            store().damaged(self.file(signature), f"unreadable, {type(error).__name__}")
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled function; whoever calls it is compiled with what is kept, like those that load it."""
        _as_loaded(compiled.library)
        if not self._enabled or compiled.lifted or compiled.library.has_dynamic_globals:
            return
        try:
            data = serialize.dumps(compiled._reduce())
        except Exception as error:
            warn(f"compiled kernels cannot be kept with this numba ({type(error).__name__}); every run compiles them")
            return
        store().save(self.file(signature), data)

    def enable(self) -> None:
        """Load and save."""
        self._enabled = True

    def disable(self) -> None:
        """Neither load nor save."""
        self._enabled = False

    def flush(self) -> None:
        """Forget nothing: what is kept is never stale."""


def _as_loaded(library: Any) -> None:
    """Give a library that was just compiled the form in which its callers would find it loaded.

    A caller's machine code holds that of its callees. From a module in memory the compiler made other code, by the last
    bit of its results, than from the same module written and read: uses of a value come in another order there.
    """
    if hasattr(library, "_shared_module") and hasattr(library, "_get_module_for_linking"):
        library._shared_module = binding.parse_bitcode(library._get_module_for_linking().as_bitcode())

"""The one decorator of all compiled functions, with a cache that knows when any kernel changed.

numba's own cache looks at the file of the function only: after an edit in another file that the function inlines,
stale machine code would run. The cache folder is therefore named after a hash of all kernel sources.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config


def cache_folder() -> Path:
    """The folder of the compiled code of exactly these sources."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    base = os.environ.get("TOOLPACE_CACHE") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "toolpace" / digest.hexdigest()[:16]


_CACHE = cache_folder()


def is_warm() -> bool:
    """Whether compiled code of these sources lies in the cache already."""
    return _CACHE.is_dir() and any(_CACHE.rglob("*.nbi"))


F = TypeVar("F", bound=Callable[..., Any])


def jit(*, reorder: bool = False, inline: bool = False) -> Callable[[F], F]:
    """Compile to machine code, cached on disk, free of the interpreter lock.

    `reorder` lets sums be reassociated and products fused, for loops that shall use vector instructions.
    A nan or an infinity is always seen: the flags that assume their absence are never set.
    `inline` is for the parts of a longer function: they are compiled as part of it only. A caller's machine code holds
    that of all it calls, so that otherwise each level of calls would compile what lies below it once more.
    """
    flags: Any = {"reassoc", "contract", "nsz", "arcp"} if reorder else False

    def decorate(function: F) -> F:
        before = config.CACHE_DIR
        config.CACHE_DIR = str(_CACHE)
        try:
            compiled: F = numba.njit(
                cache=True,
                nogil=True,
                fastmath=flags,
                error_model="numpy",
                inline="always" if inline else "never",
            )(function)
        finally:
            config.CACHE_DIR = before
        return compiled

    return decorate

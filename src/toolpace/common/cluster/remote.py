"""The work of a worker on one item: every exception comes back as text; freed memory is kept for the next item."""

from __future__ import annotations

import ctypes
import functools
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from toolpace.common.errors import ToolpaceError, printable
from toolpace.common.version import __version__
from toolpace.common.workers import interrupted

C = TypeVar("C")
T = TypeVar("T")
R = TypeVar("R")
LONGEST = 1000
"""Most characters of an error."""
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""Names of what is set, in <malloc.h> of the GNU C library."""
KEPT = 64_000_000
"""Free memory at the end of the heap up to which none is given back [bytes]."""
OWN_PAGES = 32_000_000
"""Size from which an array has pages of its own [bytes]; the library takes no more than 32 MiB."""


@dataclass(frozen=True)
class Held(Generic[C]):
    """What all items have in common: one opaque thing, which dask does not look into."""

    value: C


@dataclass(frozen=True)
class WorkItem(Generic[C, T, R]):
    """One item, with what is done with it and the version that asks for it."""

    work: Callable[[C, T], R]
    item: T
    version: str = __version__


def hold(held: Held[C]) -> Held[C]:
    """Hand it on: as the result of a task it is made anew where the worker that had it is gone."""
    return held


def do(task: WorkItem[C, T, R], held: Held[C]) -> tuple[R | None, str, float, str]:
    """Value, error, seconds and address of the worker, of one item on a worker of dask."""
    from distributed import get_worker

    from toolpace.kernels.ahead_of_time import ensure_warm

    address = get_worker().address
    if task.version != __version__:
        error = f"worker {address} has toolpace {__version__}, and toolpace {task.version} asks; install the same"
        return None, error, 0.0, address
    ensure_warm()
    keep_memory()
    return *attempt(task.work, held.value, task.item), address


def attempt(work: Callable[[C, T], R], common: C, item: T) -> tuple[R | None, str, float]:
    """Value, error in one line, and seconds, of one item; Ctrl-C goes on its way."""
    began = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            return work(common, item), "", time.perf_counter() - began
        except Exception as error:
            if interrupted(error):
                raise KeyboardInterrupt from None
            return None, error_in_words(error), time.perf_counter() - began


def error_in_words(error: Exception) -> str:
    """An error in one line."""
    if isinstance(error, ToolpaceError):
        text = str(error)
    elif isinstance(error, MemoryError):
        text = "out of memory; split the program, or give workers more memory"
    else:
        text = f"a fault in toolpace itself, {type(error).__name__}: {error}"
    text = printable(" ".join(text.split()))
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 2 :]}"


@functools.cache
def keep_memory() -> bool:
    """Keep it from now on; whether the C library of this process can."""
    try:
        set_option = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    return bool(set_option(TRIM_THRESHOLD, KEPT)) and bool(set_option(MMAP_THRESHOLD, OWN_PAGES))

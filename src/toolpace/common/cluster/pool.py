"""The interface of a pool of workers, the work of a worker on one item, and the simplest pool: this process."""

from __future__ import annotations

import ctypes
import functools
import time
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from toolpace.common import __version__
from toolpace.common.errors import ToolpaceError, printable
from toolpace.common.files.room import free_memory
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
class Outcome(Generic[T, R]):
    """What came of one item: a value, or an error."""

    number: int
    """Place of the item among all, from 0."""
    item: T
    value: R | None
    """None where there is an error."""
    error: str = ""
    """One line; empty where there is none."""
    worker: str = ""
    """Address of the worker that did it; empty in this process, and where none came to an end with it."""
    seconds: float = 0.0
    """Time the work took, there [s]."""


@dataclass(frozen=True)
class PoolWork(Generic[C, T, R]):
    """What is done with each of the items of a pool, as `Pool.each` has it."""

    do: Callable[[C, T], R]
    common: C
    memory: Callable[[T], float] | None
    avoid: Collection[str]
    ahead: int

    def need(self, item: T) -> float:
        """Memory that it takes [bytes]; 0 where that is not known."""
        return self.memory(item) if self.memory is not None else 0.0


class Pool(ABC):
    """Does the same work on many items."""

    where: str
    """In words, like "2 workers on this computer"."""
    dashboard: str = ""
    """Where dask shows what goes on, for a browser; empty where it does not."""
    note: str = ""
    """What is to be told of it; empty where nothing is."""

    def each(
        self,
        work: Callable[[C, T], R],
        common: C,
        items: Iterable[T],
        memory: Callable[[T], float] | None = None,
        avoid: Collection[str] = (),
        ahead: int = 1,
    ) -> Iterator[Outcome[T, R]]:
        """The outcome of `work(common, item)` for each item, as they are made; closing the iterator ends the work.

        work: a function of a module that workers can import. What it raises becomes the error of its outcome.
        common: what it needs for all items; sent to each worker once.
        items: taken from the iterable when there is room for them.
        memory: an estimate of what the work on an item takes [bytes]. Items are not begun beyond what a worker holds,
        where the workers tell (resource `memory`); what no worker holds is an error without being begun.
        avoid: addresses of workers that get no item while there are others; looked at before each.
        ahead: items that wait at each worker until it has done what it is at; 0 where an item takes long beside
        the some ten milliseconds for the next one to come.

        An item whose worker died is tried again, alone, when all others are done; where that worker dies too, this
        is its error. Raises ClusterError where the scheduler or all workers are gone.
        """
        return self.done(PoolWork(work, common, memory, avoid, ahead), items)

    @abstractmethod
    def done(self, work: PoolWork[C, T, R], items: Iterable[T]) -> Iterator[Outcome[T, R]]:
        """What `each` promises."""

    @abstractmethod
    def now(self) -> list[tuple[Any, str]]:
        """The items that are with workers now, each with the address of its worker; may be asked by another thread."""


class ThisProcess(Pool):
    """One item after the other, here."""

    def __init__(self, note: str = "") -> None:
        self.where, self.note = "this process, one after the other", note
        self._now: list[tuple[Any, str]] = []

    def done(self, work: PoolWork[C, T, R], items: Iterable[T]) -> Iterator[Outcome[T, R]]:
        """See `Pool.each`; an item that takes more memory than there is is not begun."""
        for number, item in enumerate(items):
            self._now = [(item, "")]
            need = work.need(item)
            if need > (free := free_memory()):
                yield Outcome(number, item, None, too_large(need, free, "there are"))
                continue
            value, error, seconds = attempt(work.do, work.common, item)
            self._now = []
            yield Outcome(number, item, value, error, "", seconds)

    def now(self) -> list[tuple[Any, str]]:
        """See `Pool.now`."""
        return self._now


def too_large(need: float, most: float, who: str) -> str:
    """Why an item was not begun: what it takes, and what there is [bytes]."""
    return (
        f"takes about {need / 1e9:.2g} GB of memory, and {who} {most / 1e9:.2g} GB; split the program, or give workers "
        "more memory"
    )


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

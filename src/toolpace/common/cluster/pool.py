"""The interface of a pool, and the simplest one: this process."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from toolpace.common.cluster.remote import attempt

C = TypeVar("C")
T = TypeVar("T")
R = TypeVar("R")


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
        from toolpace.common.files.room import free_memory

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

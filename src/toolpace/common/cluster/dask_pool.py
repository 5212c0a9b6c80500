"""A pool on a dask.distributed cluster, with a bounded number of items in flight."""

from __future__ import annotations

import contextlib
import time
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import cloudpickle
from distributed import KilledWorker

from toolpace.common import __version__
from toolpace.common.cluster.pool import Held, Outcome, Pool, PoolWork, WorkItem, do, hold, too_large
from toolpace.common.errors import ClusterError, printable

if TYPE_CHECKING:
    from distributed import Client, Future, Scheduler

C = TypeVar("C")
T = TypeVar("T")
R = TypeVar("R")

POLL_INTERVAL = 1.0
"""Time between two looks at who is there [s]."""
PATIENCE = 60.0
"""Time without any worker after which none is waited for [s]."""
SMALL = 16_384
"""Bytes up to which what items have in common goes with each of them: dask would rather have all where it lies."""
GATHER = 10.0
"""Time for an outcome to come from its worker, which may have died meanwhile [s]."""
OFTEN = 500
"""Tasks after which the scheduler's notes are thrown away.

What a task is called is looked up in a cache of 100 000 names, and the span that tasks belong to notes of every
submission which kind of collection it was, for as long as the scheduler runs: together some 500 bytes a task. The
scheduler's logs keep their last thousand entries, and so grow over the first thousands of tasks only.
"""


class DaskPool(Pool):
    """Does the work on the workers of a client's cluster."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._now: Callable[[], list[tuple[Any, str]]] = list
        self.dashboard = client.dashboard_link or ""

    def workers(self) -> int:
        """How many there are."""
        return len(self._client.nthreads())

    def done(self, work: PoolWork[C, T, R], items: Iterable[T]) -> Iterator[Outcome[T, R]]:
        """See `Pool.each`."""
        run = _Run(self._client, work)
        self._now = run.now
        try:
            for number, item in enumerate(items):
                while not run.has_room():
                    yield from run.outcomes()
                if (outcome := run.begin(number, item)) is not None:
                    yield outcome
            while run.flying or run.ready:
                yield from run.outcomes()
            yield from run.suspects_alone()
        finally:
            run.close()

    def now(self) -> list[tuple[Any, str]]:
        """See `Pool.now`."""
        return self._now()


@dataclass(frozen=True)
class _Flight(Generic[T]):
    """An item that is with the cluster."""

    item: T
    future: Future
    allowed: frozenset[str]
    """Addresses of the workers that may have it; all of them where it is empty."""
    need: float
    """Memory that it takes [bytes]."""
    begun: float
    """[s]"""


class _Run(Generic[C, T, R]):
    """One use of a pool: the items that are with the cluster, and what comes back."""

    def __init__(self, client: Client, work: PoolWork[C, T, R]) -> None:
        self.client, self.work = client, work
        # The first part of a key is all that the scheduler remembers: it is the same for all items of all runs.
        self.name = f"toolpace-{uuid.uuid4().hex}"
        self.flying: dict[int, _Flight[T]] = {}
        self.suspects: list[tuple[int, T]] = []
        self.ready: list[Outcome[T, R]] = []
        self.alone, self.tries = False, 0
        self.came: SimpleQueue[tuple[int, Future]] = SimpleQueue()
        self.looked = self.seen = time.monotonic()
        self.width, self.holds, self.declared = 0, 0.0, False
        self.there: frozenset[str] = frozenset()
        self.held: Held[C] | Future = Held(work.common)
        if len(cloudpickle.dumps(work.common)) > SMALL:
            self.held = self._submit(hold, self.held, key=f"{self.name}-common")
        self._poll()

    def has_room(self) -> bool:
        """Whether the cluster can take another item."""
        self._poll_again()
        return len(self.flying) < max(1, (1 + self.work.ahead) * self.width)

    def begin(self, number: int, item: T) -> Outcome[T, R] | None:
        """Hand an item to the cluster; its outcome where no worker holds it."""
        need = self.work.need(item)
        if self.holds and need > self.holds:
            return Outcome(number, item, None, too_large(need, self.holds, "the largest worker has"))
        allowed = self.there.difference(self.work.avoid) if self.work.avoid else frozenset()
        # Another try is another task: the scheduler still counts what happened to the first.
        self.tries += 1
        if self.tries % OFTEN == 0:
            self._tidy()
        future = self._submit(
            do,
            WorkItem(self.work.do, item),
            self.held,
            key=(self.name, number, self.tries),
            resources={"memory": need} if need and self.declared else None,
            workers=sorted(allowed) or None,
        )
        self.flying[number] = _Flight(item, future, allowed, need, time.monotonic())
        future.add_done_callback(lambda done: self.came.put((number, done)))
        return None

    def outcomes(self) -> Iterator[Outcome[T, R]]:
        """The next outcome; none where none came for a while, or an item must be tried again."""
        self._poll_again()
        while self.ready:
            yield self.ready.pop()
        try:
            number, future = self.came.get(timeout=POLL_INTERVAL)
        except Empty:
            return
        flight = self.flying.get(number)
        if flight is None or flight.future is not future:
            return
        try:
            value, wrong, seconds, worker = future.result(timeout=GATHER)
        except TimeoutError:
            # The worker that had it is gone; another one makes it again.
            future.add_done_callback(lambda done: self.came.put((number, done)))
            return
        except CancelledError as error:
            raise self._gone(str(error)) from None
        except KilledWorker as error:
            del self.flying[number]
            if self.alone:
                yield Outcome(number, flight.item, None, self._killed(error))
            else:
                self.suspects.append((number, flight.item))
            return
        except Exception as error:
            # Not of the work, whose errors come as words: it could not be sent, or not be read.
            del self.flying[number]
            message = f"the worker could not do it: {type(error).__name__}: {error}"
            if isinstance(error, ImportError):
                message = f"scheduler and workers need toolpace {__version__}, and all that the work imports: {error}"
            yield Outcome(number, flight.item, None, printable(" ".join(message.split())))
            return
        del self.flying[number]
        yield Outcome(number, flight.item, value, wrong, worker, seconds)

    def suspects_alone(self) -> Iterator[Outcome[T, R]]:
        """Those whose worker died, one after the other: whichever kills another one is told so."""
        self.alone = True
        while self.suspects:
            number, item = self.suspects.pop()
            if (outcome := self.begin(number, item)) is not None:
                yield outcome
            while self.flying or self.ready:
                yield from self.outcomes()

    def now(self) -> list[tuple[T, str]]:
        """See `Pool.now`."""
        if self.client.status != "running":
            return []
        try:
            keys = [(key, worker) for worker, keys in self.client.processing().items() for key in keys]
        except OSError:
            return []
        found = [(self.flying.get(key[1]), worker) for key, worker in keys if key[0] == self.name]
        return [(flight.item, worker) for flight, worker in found if flight is not None]

    def close(self) -> None:
        """Give up what is still with the cluster."""
        futures = [flight.future for flight in self.flying.values()]
        self.flying.clear()
        if futures and self.client.status == "running":
            self.client.cancel(futures, force=True)
        if not isinstance(self.held, Held):
            self.held.release()

    def _submit(self, *words: Any, **options: Any) -> Future:
        with warnings.catch_warnings():
            # A program of some megabytes is no mistake: it is what there is to do.
            warnings.filterwarnings("ignore", message="Sending large graph")
            return self.client.submit(*words, pure=False, **options)

    def _tidy(self) -> None:
        # One that takes no functions (distributed.scheduler.pickle: false), or is gone: the next look will tell.
        with contextlib.suppress(OSError, ValueError):
            self.client.run_on_scheduler(throw_away)

    def _poll_again(self) -> None:
        if time.monotonic() - self.looked >= POLL_INTERVAL:
            self._poll()

    def _poll(self) -> None:
        """Who is there, and what they hold. Raises ClusterError where nobody is, or was for long."""
        self.looked = time.monotonic()
        if self.client.status != "running":
            raise self._gone("no answer")
        try:
            found = self.client.scheduler_info(n_workers=-1)["workers"]
        except OSError as error:
            raise self._gone(str(error)) from None
        self.there, workers = frozenset(found), found.values()
        self.width = sum(each["nthreads"] for each in workers)
        self.declared = bool(workers) and all("memory" in each["resources"] for each in workers)
        self.holds = max((each["memory_limit"] or 0 for each in workers), default=0)
        for number, flight in list(self.flying.items()):
            if self.width and self._is_stuck(flight):
                del self.flying[number]
                flight.future.release()
                if (outcome := self.begin(number, flight.item)) is not None:
                    self.ready.append(outcome)
        if self.width:
            self.seen = self.looked
        elif self.looked - self.seen > PATIENCE:
            raise ClusterError(
                f"no worker has been at the scheduler for {PATIENCE:.0f} s; start some with `dask worker ADDRESS`"
            )

    def _is_stuck(self, flight: _Flight[T]) -> bool:
        """Whether all workers that might have an item are gone: dask would wait for them for ever."""
        if flight.allowed:
            return not flight.allowed & self.there
        return flight.need > self.holds > 0.0 and self.looked - flight.begun > PATIENCE

    def _gone(self, why: str) -> ClusterError:
        return ClusterError(f"the scheduler is gone ({why}); start it again")

    def _killed(self, error: KilledWorker) -> str:
        last = error.last_worker
        limit = f" (its memory limit is {last.memory_limit / 1e9:.3g} GB)" if last.memory_limit else ""
        return (
            f"the worker died each time it was tried, last alone on {last.address}{limit}: killed from outside, out of "
            "memory, or a crash; split the program, or give workers more memory"
        )


def throw_away(dask_scheduler: Scheduler) -> None:
    """Done in the scheduler: of notes that are alike one is kept, and of looked-up names none."""
    from dask.utils import key_split

    key_split.cache_clear()
    spans = getattr(dask_scheduler.extensions.get("spans"), "spans", {})
    for span in spans.values():
        kinds = (span.metadata or {}).get("collections", [])
        distinct: list[object] = []
        for kind in kinds:
            if kind not in distinct:
                distinct.append(kind)
        kinds[:] = distinct

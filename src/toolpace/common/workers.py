"""Parallel work on the cores of this computer, progress, and a lock for functions of callers."""

from __future__ import annotations

import operator
import os
import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

BREATH = 0.03
"""Time between two looks at others' work [s]: short beside what an eye sees, long beside what a look costs."""


class Stopped(Exception):
    """Others have failed, or the user has had enough: what is left of the work is of no use."""


class Progress:
    """Takes word of how far some work is, from 0 to 1, and passes it on."""

    def __init__(self, tell: Callable[[float], None] = lambda share: None) -> None:
        self._tell = tell

    def __call__(self, share: float) -> None:
        """Say that so much of the work is done."""
        self._tell(share)

    def pulse(self) -> None:
        """Pass on what other threads have said, where it must wait for the right one."""

    def part(self, low: float, high: float) -> Progress:
        """Of work that is the part from `low` to `high` of this."""
        return Progress(lambda share: self(low + (high - low) * share))

    def split(self, weights: Sequence[float]) -> list[Progress]:
        """Of pieces that are done in any order and each so much of the whole; their sum is what is passed on."""
        whole = sum(weights) or 1.0
        shares, done = [weight / whole for weight in weights], [0.0] * len(weights)

        def piece(k: int) -> Progress:
            def tell(share: float) -> None:
                # each piece has a place of its own, written by one thread at a time
                done[k] = max(done[k], min(share, 1.0))
                self(min(sum(map(operator.mul, done, shares)), 1.0))

            return Progress(tell)

        return [piece(k) for k in range(len(weights))]


UNTOLD = Progress()
"""Of work that nobody asks after."""


class CallersProgress(Progress):
    """Tells a caller how much is done: it never falls, and is told only in the thread that made this."""

    def __init__(self, tell: Callable[[float], None] | None) -> None:
        super().__init__(tell or (lambda share: None))
        self._done, self._told = 0.0, -1.0
        self._owner = threading.get_ident()
        self._lock = threading.Lock()

    def __call__(self, share: float) -> None:
        with self._lock:
            self._done = max(self._done, share)
        self.pulse()

    def pulse(self) -> None:
        if threading.get_ident() == self._owner and self._done > self._told:
            self._told = self._done
            self._tell(self._told)


class Helper:
    """A thread whose end can be waited for again after an interrupt, which Thread.join does not allow."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._done = threading.Event()
        self._work = work
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._work()
        finally:
            self._done.set()

    def wait(self, pulse: Callable[[], None] = lambda: None) -> None:
        """Wait for its end, with a pulse from time to time, and when it has come."""
        while not self._done.wait(BREATH):
            pulse()
        self._thread.join()
        pulse()


def interrupted(error: BaseException) -> bool:
    """Whether an error is Ctrl-C, met by compiled code in the main thread, which wraps it."""
    return isinstance(error, SystemError) and isinstance(error.__cause__, KeyboardInterrupt)


class Workers:
    """As many threads as there are cores, for work within work.

    Who asks for work to be done works too, and helpers join where they are free: pieces of one long run, or several
    short runs, take the cores they find. Once `stopped`, all come to a halt after the pieces they are at.
    """

    def __init__(self, progress: Progress | None = None) -> None:
        self._free = threading.Semaphore(max((os.cpu_count() or 1) - 1, 0))
        self._progress = progress or UNTOLD
        self.stopped = False

    def aside(self, work: Callable[[], R]) -> R:
        """What `work` returns, done in another thread, while this one passes on word of it and hears Ctrl-C."""
        out: list[R] = []
        failed: list[Exception] = []

        def go() -> None:
            try:
                out.append(work())
            except Exception as error:
                failed.append(error)

        worker = Helper(go)
        try:
            worker.wait(self._pulse)
        except BaseException:
            self.stopped = True
            worker.wait()
            raise
        if failed:
            raise failed[0]
        return out[0]

    def each(self, work: Callable[[T], R], pieces: Sequence[T], progress: Progress = UNTOLD) -> list[R]:
        """What `work` makes of each piece, in order. The first error is raised when all have come to a halt."""
        out: dict[int, R] = {}
        failed: dict[int, Exception] = {}
        queue = iter(range(len(pieces)))
        lock = threading.Lock()

        def go() -> None:
            while not self.stopped and not failed:
                with lock:
                    k = next(queue, None)
                if k is None:
                    return
                try:
                    out[k] = work(pieces[k])
                except Exception as error:
                    failed[k] = error
                    return
                progress(len(out) / len(pieces))

        def help_out() -> None:
            try:
                go()
            finally:
                self._free.release()

        helpers: list[Helper] = []
        try:
            while len(helpers) < len(pieces) - 1 and not self.stopped and self._free.acquire(blocking=False):
                helpers.append(Helper(help_out))
            go()
        except BaseException:
            self.stopped = True
            raise
        finally:
            for helper in helpers:
                helper.wait(self._pulse)
        if failed:
            first = failed[min(failed, key=lambda k: (isinstance(failed[k], Stopped), k))]
            if interrupted(first):
                raise KeyboardInterrupt from None
            raise first
        if self.stopped:
            raise Stopped
        return [out[k] for k in range(len(pieces))]

    def _pulse(self) -> None:
        self._progress.pulse()


def side_by_side(
    work: Callable[[int, Workers, Progress], R],
    weights: Sequence[float],
    progress: Callable[[float], None] | None = None,
) -> list[R]:
    """What `work` makes of each of several runs, in order, on all cores: the one loop over runs that there is.

    `work` is given the number of the run, the workers, for work within the run, and whom to tell how far it is. The
    `weights` say how much of the whole each run is. Where one fails, the others stop, and its error is raised.
    """
    reported = CallersProgress(progress)
    workers = Workers(reported)
    parts = reported.split(weights)

    def one(k: int) -> R:
        try:
            out = work(k, workers, parts[k])
        except BaseException:
            workers.stopped = True
            raise
        parts[k](1.0)
        return out

    out = workers.aside(lambda: workers.each(one, range(len(weights))))
    reported(1.0)
    return out


class Lock:
    """Held while a caller's function runs: it may remember what it was asked last, and is not asked twice at once.

    A copy has a lock of its own.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def __reduce__(self) -> tuple[type[Lock], tuple[()]]:
        return Lock, ()

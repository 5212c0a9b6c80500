"""Work on all cores, word of how far it is, and a lock for functions that callers give."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")
Tell = Callable[[float], None]
"""Takes the share of some work that is done, from 0 to 1."""

BREATH = 0.03
"""Time between two looks at others' work [s]."""


class Stopped(Exception):
    """Others have failed, or the user has had enough: what is left of the work is of no use."""


def untold(share: float) -> None:
    """Tell nobody."""


def part_of(tell: Tell, low: float, high: float) -> Tell:
    """Tells of work that is the part from `low` to `high` of some other."""
    return lambda share: tell(low + (high - low) * share)


class Tally:
    """How much of a plan is done: never falls, and is told only in the thread that asked for the plan."""

    def __init__(self, tell: Tell | None, shares: Sequence[float]) -> None:
        """Take who is to be told, and the share of each run of the whole."""
        self._tell, self._shares = tell or untold, shares
        self._done = [0.0] * len(shares)
        self._told = -1.0
        self._owner = threading.get_ident()

    def of(self, run: int) -> Tell:
        """Takes word of one run."""

        def tell(share: float) -> None:
            self._done[run] = max(self._done[run], min(share, 1.0))
            self.pulse()

        return tell

    def pulse(self) -> None:
        """Pass on what others have done."""
        if threading.get_ident() != self._owner:
            return
        now = min(sum(done * share for done, share in zip(self._done, self._shares)), 1.0)
        if now > self._told:
            self._told = now
            self._tell(now)


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


class Crew:
    """As many threads as there are cores, for work within work.

    Who asks for work to be done works too, and helpers join where they are free: pieces of one long run, or several
    short runs, take the cores they find. Once `stopped`, all come to a halt after the pieces they are at.
    """

    def __init__(self, tally: Tally | None = None) -> None:
        self._free = threading.Semaphore(max((os.cpu_count() or 1) - 1, 0))
        self._tally = tally
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

    def each(self, work: Callable[[T], R], pieces: Sequence[T], tell: Tell = untold) -> list[R]:
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
                tell(len(out) / len(pieces))

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
        if self._tally is not None:
            self._tally.pulse()


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

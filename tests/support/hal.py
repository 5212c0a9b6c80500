"""What the component sees of HAL: pins, a queue, and a servo thread that takes a row each period while it sleeps."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np


class Component(dict):
    """Pins by name."""

    def __init__(self, hal: FakeHal, name: str) -> None:
        if name in hal.taken:
            raise RuntimeError("duplicate component name")
        super().__init__()
        self.hal, self.gone, self.is_ready = hal, False, False
        hal.component_made = self

    def newpin(self, name: str, kind: object, direction: object) -> None:
        self[name] = 0

    def ready(self) -> None:
        self.is_ready = True

    def exit(self) -> None:
        self.gone = True


class Stream:
    """A queue of rows."""

    def __init__(self, hal: FakeHal) -> None:
        if hal.depth == 0:
            raise RuntimeError("no such stream")
        self.rows: deque[tuple[float, ...]] = deque()
        self.maxdepth, self.num_underruns = hal.depth, 0
        hal.queue = self

    @property
    def depth(self) -> int:
        return len(self.rows)

    def write(self, row: tuple[float, ...]) -> None:
        assert type(row) is tuple and len(row) == 5 and len(self.rows) < self.maxdepth
        self.rows.append(row)


class FakeHal:
    """The module `hal`; `sleep` stands for time.sleep: the servo thread goes on meanwhile."""

    HAL_BIT, HAL_FLOAT, HAL_U32, HAL_IN, HAL_OUT, streamer_base = range(6)

    def __init__(self, depth: int = 400, periods: int = 1, stalls: tuple[int, ...] = (), taken: str = "") -> None:
        """`periods`: how many pass at each sleep; `stalls`: sleeps in which all rows are taken."""
        self.depth, self.periods, self.stalls, self.taken = depth, periods, stalls, (taken,)
        self.queue: Any = None
        self.component_made: Any = None
        self.played: list[tuple[float, ...]] = []
        self.sleeps = 0
        self.script: Callable[[int, Component], None] = lambda period, pins: None

    def component(self, name: str) -> Component:
        return Component(self, name)

    def stream(self, component: Component, key: int, config: str) -> Stream:
        return Stream(self)

    def sleep(self, seconds: float) -> None:
        self.sleeps += 1
        pins = self.component_made
        if pins["playing"]:
            for _ in range(self.depth + 1 if self.sleeps in self.stalls else self.periods):
                self.take()
        self.script(len(self.played), pins)
        assert self.sleeps < 100_000, "it never ends"

    def take(self) -> None:
        """One servo period: where no row waits, the joints stand."""
        if self.queue.rows:
            self.played.append(self.queue.rows.popleft())
        else:
            self.queue.num_underruns += 1
            self.played.append(self.played[-1])

    @property
    def clock(self) -> SimpleNamespace:
        """Takes the place of the module `time`."""
        return SimpleNamespace(sleep=self.sleep, monotonic=lambda: 1e-3 * self.sleeps)

    @property
    def rows(self) -> np.ndarray:
        """(n, 5) played so far, standing for a while before and after."""
        rest = 5
        return np.array([self.played[0]] * rest + self.played + [self.played[-1]] * rest)

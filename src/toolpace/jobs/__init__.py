"""Jobs: from a program to a folder of results, in timed steps, without the terminal."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Tell = Callable[[float], None]
"""Takes the share of a step that is done."""


class Step:
    """One step under way."""

    def __init__(self) -> None:
        self.share: Tell = lambda share: None
        self.note = ""

    def __call__(self, share: float) -> None:
        """Say how much of the step is done, from 0 to 1."""
        self.share(share)


class TimedSteps:
    """Runs steps one after the other and keeps their times; shows nothing."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def say(self, text: str) -> None:
        """A line below that of a step."""

    @contextmanager
    def step(self, name: str, note: str = "") -> Iterator[Step]:
        """Run the block as a step; `note` is to be said before it."""
        began = time.perf_counter()
        yield Step()
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - began

"""Around the turns of the component: nothing interrupts one, neither a signal nor the collector."""

from __future__ import annotations

import gc
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Ending:
    """Whether a signal has asked to end; a second one ends at once."""

    asked = False

    def hear(self, number: int, frame: FrameType | None) -> None:
        """Note a signal: an exception would tear a set-point that was stepped from the row that it becomes."""
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@contextmanager
def asked_to_end() -> Iterator[Ending]:
    """Let signals ask for the end of the block; who ignores one (nohup) goes on doing so."""
    ending = Ending()
    heard = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, ending.hear) for number in heard}
    try:
        yield ending
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def without_pauses() -> Iterator[None]:
    """Nothing is collected meanwhile: among all that compiled kernels hold, that takes longer than the rows last, and
    what a turn makes is freed as it goes out of use."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()

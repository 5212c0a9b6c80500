"""What workers are given to do in tests: functions of a module that they can import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def added(common: int, item: int) -> int:
    """A sum, but for some items."""
    if item == 7:
        raise ValueError("seven\nin two lines")
    if item == 9:
        raise MemoryError
    return common + item


def slow(common: float, item: int) -> str:
    """Take some time; the process that did it."""
    time.sleep(common)
    return str(os.getpid())


def killing(common: str, item: int) -> int:
    """Kill the worker: item 5 each time, item 6 the first time alone."""
    first = Path(common)
    if item == 5 or (item == 6 and not first.exists()):
        first.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return item


def killing_with_much(common: tuple[str, bytes], item: int) -> int:
    """As `killing`, with more in common; how much."""
    killing(common[0], item)
    return len(common[1])


def scheduler_notes(dask_scheduler) -> tuple[int, int]:
    """What the scheduler that this runs in has noted: names of tasks, and kinds of collections in the fullest span."""
    from dask.utils import key_split

    spans = dask_scheduler.extensions["spans"].spans.values()
    return key_split.cache_info().currsize, max(len((span.metadata or {})["collections"]) for span in spans)

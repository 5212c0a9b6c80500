"""How the cost of some work grows with its size: counted calls, and ratios of CPU time where nothing can be counted.

No test asks how long something takes on a clock: a busy computer would decide whether it passes.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

ROUNDS = 3
"""Times that each size is measured; the least counts, since others' work only ever adds."""
NEARLY_LINEAR = 1.6
"""Orders of growth below it are those of n and n log n, with the noise of a busy computer; n^2 is well above."""


def python_calls(work: Callable[[], object]) -> int:
    """Calls of functions, of Python or of C, that the interpreter makes while the work is done in this thread.

    Compiled loops and array operations are one call however much they do.
    """
    calls = 0

    def count(frame: object, event: str, argument: Any) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(before)
    return calls


def order_of_growth(work: Callable[[Any], object], small: Any, large: Any, factor: float) -> float:
    """The p of CPU time ~ size^p between two inputs, the large one `factor` times the small one.

    Measured in turn, and once before for what is done but once.
    """
    work(small)
    seconds: dict[bool, list[float]] = {False: [], True: []}
    for _ in range(ROUNDS):
        for is_large, given in ((False, small), (True, large)):
            began = time.process_time()
            work(given)
            seconds[is_large].append(time.process_time() - began)
    return float(np.log(min(seconds[True]) / min(seconds[False])) / np.log(factor))

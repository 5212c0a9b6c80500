"""toolpace's second-order planner on a given mesh: velocity, feed and acceleration, no jerk."""

from __future__ import annotations

import numpy as np

from benchmarks.peers import Outcome, Stopwatch, failed
from toolpace.common.errors import ToolpaceError
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.second_order import Cells, peaks_in_cells, second_order_law


def solve(axis_path: AxisPath, limits: Limits, n: int, *, guard: bool = False, judge: bool = True) -> Outcome:
    """One thread over n even cells, limits at both ends of each; with `guard` everywhere in them."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    try:
        law = second_order_law(run, limits, nodes=np.linspace(run.s0, run.s1, n + 1), guard=guard)
    except ToolpaceError as error:
        return failed(watch(), str(error))
    seconds = watch()
    between = float(peaks_in_cells(run, limits, law).max()) if judge else np.nan
    return Outcome(law.duration, seconds, between=between, points=n + 1)


def passes(axis_path: AxisPath, limits: Limits, n: int) -> float:
    """CPU time of the two passes alone, path derivatives and limits being known [s]."""
    run = axis_path.runs[0]
    cells = Cells(run, limits, np.linspace(run.s0, run.s1, n + 1))
    watch = Stopwatch()
    cells.solve(0.0, 0.0)
    return watch()

"""toolpace itself, on a fixed mesh of n cells; `guarded` holds the limits between the nodes too."""

from __future__ import annotations

from benchmarks.peers import Outcome, Stopwatch, failed, usage_of_law
from toolpace.common.errors import ToolpaceError
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.optimal.planner import fastest_law


def solve(axis_path: AxisPath, limits: Limits, n: int, *, guard: bool = False, judge: bool = True) -> Outcome:
    """The planner in one thread: mesh, rows and solution, from the bare callable."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    try:
        law, points = fastest_law(run, limits, cells=n, guard=guard)
    except ToolpaceError as error:
        return failed(watch(), str(error))
    seconds = watch()
    if not judge:
        return Outcome(law.duration, seconds, points=points)
    at_nodes, between = usage_of_law(run, limits, law)
    return Outcome(law.duration, seconds, at_nodes, between, points=points)


def guarded(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """The same with the guarantee between the nodes."""
    return solve(axis_path, limits, n, guard=True)

"""CasADi and IPOPT on exactly the project's discretisation, see `testbed.ipopt`."""

from __future__ import annotations

from benchmarks.peers import Outcome, Stopwatch, failed, usage_of_law
from testbed.ipopt import SUCCEEDED, optimum
from testbed.mesh_problem import objective
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath


def solve(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """The optimum of the discretised problem; the time includes building the model, as a user has to."""
    watch = Stopwatch()
    found = optimum(axis_path, limits, n)
    seconds = watch()
    if not found.answered:
        return failed(seconds, found.note)
    law = found.law
    at_nodes, between = usage_of_law(axis_path.runs[0], limits, law)
    ok, time = found.note == SUCCEEDED, objective(found.problem, found.c)
    return Outcome(law.duration, seconds, at_nodes, between, ok, found.note, time, len(law.nodes))

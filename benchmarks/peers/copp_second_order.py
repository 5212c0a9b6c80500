"""COPP's second-order planner (copp-py, topp2_ra): reachability analysis for velocity and acceleration. Even mesh.

Its rows are those of both stations of a cell, as its `exceed_topp2` says: TOPP-RA's second scheme.
"""

from __future__ import annotations

import copp_py as copp
import numpy as np

from benchmarks.peers import Outcome, Stopwatch, failed
from benchmarks.peers.copp import model
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath


def solve(axis_path: AxisPath, limits: Limits, n: int) -> tuple[Outcome, float]:
    """The outcome, and the CPU time of its solve alone [s]."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    s = np.linspace(run.s0, run.s1, n + 1)
    try:
        robot = model(run, limits, s, order=2)
        alone = Stopwatch()
        z = copp.solver.topp2_ra.solve(copp.solver.topp2_ra.Problem(robot.constraints, (0, n), (0.0, 0.0)))
        of_solve = alone()
    except Exception as error:  # whatever a peer raises is its result
        return failed(watch(), str(error)), np.nan
    speed = np.sqrt(z)
    duration = float((2.0 * np.diff(s) / (speed[1:] + speed[:-1])).sum())
    return Outcome(duration, watch(), points=n + 1), of_solve

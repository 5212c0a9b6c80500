"""The law of a detour and the rest of its run, timed anew by a planner of runs."""

from __future__ import annotations

import numpy as np

from toolpace.axispath.axispath import AxisPath
from toolpace.deflect.detour import DetourRun
from toolpace.errors import InfeasibleError
from toolpace.laws.law import TimeLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import AT_REST, EndState
from toolpace.planning.guarantee import PROMISED
from toolpace.planning.planner import Planner
from toolpace.trajectory import Trajectory
from toolpace.workers import UNTOLD, Workers

MEETS = 1e-9
"""How far the law may begin from the state it shall, relative to its speed and acceleration: rounding."""


def planned_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Planner) -> TimeLaw:
    """The law that the planner finds, or the direct one where that is as fast, or keeps to what the other does not."""
    _, v, a, _ = run.parameter(np.zeros(1))[:, 0]
    try:
        law = planner.plan_run(run, limits, EndState(float(v), float(a)), AT_REST, Workers(), UNTOLD).law
    except InfeasibleError:
        return direct
    begin = law.at(np.zeros(1))[:3, 0]
    meets = np.allclose(begin[1:], [v, a], rtol=MEETS, atol=MEETS * (float(v) + abs(float(a))))
    if not meets or law.duration >= direct.duration:
        return direct
    alone = AxisPath((run,), limits.joints, run.machine)
    return law if Trajectory(alone, limits, (law,)).usage().worst <= PROMISED else direct

"""The fastest law of a detour and the rest of its run."""

from __future__ import annotations

import numpy as np

from toolpace.axispath.axispath import AxisPath
from toolpace.deflect.detour import DetourRun
from toolpace.errors import InfeasibleError
from toolpace.laws.law import TimeLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import EndState
from toolpace.planning.guarantee import PROMISED
from toolpace.planning.optimal.planner import plan_run
from toolpace.trajectory import Trajectory

MEETS = 1e-9
"""How far the law may begin from the state it shall, relative to its speed and acceleration: rounding."""


def optimal_law(
    run: DetourRun, limits: Limits, direct: TimeLaw, *, cells: int | None = None, guard: bool = True
) -> TimeLaw:
    """The fastest law, or the direct one where that is as fast."""
    _, v, a, _ = run.parameter(np.zeros(1))[:, 0]
    try:
        law, _ = plan_run(run, limits, start=EndState(float(v), float(a)), cells=cells, guard=guard)
    except InfeasibleError:
        return direct
    begin = law.at(np.zeros(1))[:3, 0]
    meets = np.allclose(begin[1:], [v, a], rtol=MEETS, atol=MEETS * (float(v) + abs(float(a))))
    if not meets or law.duration >= direct.duration:
        return direct
    alone = AxisPath((run,), limits.joints, run.machine)
    return law if Trajectory(alone, limits, (law,)).usage().worst <= PROMISED else direct

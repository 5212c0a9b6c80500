"""The time law of a detour by a planner of runs.

It looks no further than the rejoining needs: after as long again as the detour takes, the known law goes on.

    found o--detour--x--as long again--| the law as it was
          |<------- timed anew ------->|
"""

from __future__ import annotations

import numpy as np

from toolpace.common.errors import InfeasibleError
from toolpace.common.workers import UNTOLD, Workers
from toolpace.deflection.replanning.detour import DetourRun
from toolpace.deflection.replanning.remaining_motion import Stretch
from toolpace.machine.limits import Limits
from toolpace.motion.laws.chain import ChainLaw, LawPiece
from toolpace.motion.laws.law import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.planning.endstate import AT_REST, EndState
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import Planner

MEETS = 1e-9
"""How far the law may begin and end from the states it shall, relative to their speed and acceleration: rounding."""
NEARLY_THERE = 0.05
"""Time left after the known law is met, as a share of the detour, below which the rest is timed anew too."""


def planned_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Planner) -> TimeLaw:
    """The law that the planner finds, or the direct one where that is as fast, or keeps to what the other does not."""
    if not (run.smooth or run.ends_here):
        return direct
    met = direct.duration if run.ends_here else min(2.0 * run.detour.duration, direct.duration)
    if direct.duration - met < NEARLY_THERE * run.detour.duration:
        met = direct.duration
    begin = direct.at(np.zeros(1))[:3, 0]
    end = direct.at(np.array([met]))[:3, 0]
    whole = met == direct.duration
    part = Stretch(run, run.s1 if whole else float(end[0]))
    try:
        last = AT_REST if whole else EndState(float(end[1]), float(end[2]))
        first = EndState(float(begin[1]), float(begin[2]))
        law = planner.plan_run(part, limits, first, last, Workers(), UNTOLD).law
    except InfeasibleError:
        return direct
    alike = all(
        np.allclose(law.at(np.array([t]))[1:3, 0], given[1:], rtol=MEETS, atol=MEETS * float(abs(given[1:]).sum()))
        for t, given in ((0.0, begin), *(() if whole else ((law.duration, end),)))
    )
    if not alike or law.duration >= met:
        return direct
    alone = AxisPath((part,), limits.joints, run.machine)
    if Trajectory(alone, limits, (law,)).usage().worst > PROMISED:
        return direct
    if whole:
        return law
    assert isinstance(direct, ChainLaw)
    known = direct.pieces[-1]
    return ChainLaw([LawPiece(law, 0.0, law.duration),
                     LawPiece(known.law, known.begin + (met - float(direct.times[-2])), known.end)])  # fmt: skip

"""The time law of a detour as it was found."""

from __future__ import annotations

import numpy as np

from toolpace.deflection.replanning.detour import DetourRun
from toolpace.motion.laws.chain import ChainLaw, LawPiece
from toolpace.motion.laws.law import TimeLaw
from toolpace.motion.laws.quintic import QuinticLaw


def find_rejoin(run: DetourRun) -> QuinticLaw:
    """The law of the detour alone: its parameter is a cubic of time."""
    marks = run.detour.times
    p, v, a, jerk = run.parameter(marks)
    p[-1] = run.join
    return QuinticLaw(p, v, a, np.diff(marks), jerk[:-1])


def direct_law(run: DetourRun) -> TimeLaw:
    """The detour as made; then the commanded law goes on."""
    back = find_rejoin(run)
    if run.ends_here:
        return back
    law = run.detour.commanded.law
    rest = LawPiece(law, run.detour.rejoin, law.duration)
    return ChainLaw([LawPiece(back, 0.0, back.duration), rest])

"""The law under which a detour and the rest of its run go as they were found."""

from __future__ import annotations

import numpy as np

from toolpace.deflect.detour import DetourRun
from toolpace.laws.chain import ChainLaw, LawPiece
from toolpace.laws.law import TimeLaw
from toolpace.laws.quintic import QuinticLaw


def direct_law(run: DetourRun) -> TimeLaw:
    """The detour as made, a quintic of time since its parameter is a cubic; then the commanded law goes on."""
    marks = np.unique(np.concatenate([[0.0], run.kinks, [run.detour.duration]]))
    p, v, a, _ = run.parameter(marks)
    p[-1] = run.join
    way_back = QuinticLaw(p, v, a, np.diff(marks))
    if run.ends_here:
        return way_back
    law = run.detour.commanded.law
    rest = LawPiece(law, run.detour.rejoin, law.duration)
    return ChainLaw([LawPiece(way_back, 0.0, run.detour.duration), rest])

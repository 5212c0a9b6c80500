"""The time law to the next reference point by the genetic planner (Wu et al. 2009, step 4).

The detour itself needs no breeding: it is the shortest that is found within the limits.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.deflection.replanning.detour import DetourRun
from toolpace.machine.limits import Limits
from toolpace.motion.laws.chain import ChainLaw, LawPiece
from toolpace.motion.laws.law import TimeLaw
from toolpace.motion.laws.quintic import QuinticLaw
from toolpace.planning.genetic import Genetic, Intervals, Preset, interval_peaks, reference_points, with_bred_periods
from toolpace.planning.limit_tolerances import KEPT_INTERVAL

BEYOND = 1e-12
"""How far behind the rejoining the next reference point lies at least, absolute and relative to s: else it is the same
but for rounding."""


def genetic_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Genetic) -> TimeLaw:
    """The genetic algorithm on the interval from the rejoining to the next reference point.

    Speed and acceleration at both ends are those of the direct law, as the paper sets them to those of the reference
    path; from there on the direct law goes on.
    """
    if run.ends_here:
        return direct
    assert isinstance(direct, ChainLaw)
    back, known = direct.pieces
    after = next_point(run)
    if after is None:
        return direct
    begin = back.end
    end = begin + known.law.passing_time(after) - known.begin
    state = direct.at(np.array([begin, end]))
    # to the last digit, since the third derivative jumps there
    state[0] = run.join, after
    piece = shortened_piece(run, limits, LawPiece(direct, begin, end), state, planner)
    return ChainLaw([back, piece, LawPiece(known.law, known.begin + (end - begin), known.end)])


def next_point(run: DetourRun) -> float | None:
    """The reference point after the rejoining; None where it is the end."""
    commanded = run.detour.commanded
    law = commanded.law
    points = law.s if isinstance(law, QuinticLaw) else reference_points(commanded.run, None)
    after = points[points > run.join * (1.0 + BEYOND) + BEYOND]
    return float(after[0]) if len(after) > 1 else None


def shortened_piece(run: DetourRun, limits: Limits, direct: LawPiece, ends: Floats, planner: Genetic) -> LawPiece:
    """One interval between two states (4, 2), in the shortest period that is found.

    Where that of the direct law is not within the limits as a quintic (the direct law need not be one there), or is
    no longer, the interval keeps the direct law.
    """
    s, v, a = ends[:3]
    parts = Intervals(run, limits, s.copy(), (False, False))
    given = Preset(v.copy(), a.copy(), np.array([direct.end - direct.begin]))
    if interval_peaks(parts, given).max() > KEPT_INTERVAL:
        return direct
    try:
        best = with_bred_periods(parts, given, planner)
    except InfeasibleError:
        return direct
    law = QuinticLaw(s.copy(), best.speed, best.acceleration, best.periods)
    return LawPiece(law, 0.0, law.duration) if law.duration < direct.end - direct.begin else direct

"""The paper's steps (3) and (4): periods of the detour and of the way on to the next reference point."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats
from toolpace.deflect.detour import DetourRun
from toolpace.errors import InfeasibleError
from toolpace.laws.chain import ChainLaw, LawPiece
from toolpace.laws.law import TimeLaw
from toolpace.laws.quintic import QuinticLaw
from toolpace.machine.limits import Limits
from toolpace.planning.genetic.planner import Genetic, interval_peaks, with_bred_periods
from toolpace.planning.genetic.preset_speeds import Preset
from toolpace.planning.genetic.problem import Intervals, reference_points
from toolpace.planning.guarantee import KEPT_INTERVAL

BEYOND = 1e-12
"""How far behind the rejoining the next reference point lies at least, absolute and relative to s: else it is the same
but for rounding."""


def genetic_law(run: DetourRun, limits: Limits, direct: TimeLaw, planner: Genetic) -> TimeLaw:
    """The genetic algorithm on the detour and on the interval from the rejoining to the next reference point.

    Speeds and accelerations at all three points are those of the direct law, as the paper sets them to those of the
    reference path; from there on the direct law goes on.
    """
    times, state = interval_ends(run, direct)
    pieces = []
    for k in range(len(times) - 1):
        piece = LawPiece(direct, times[k], times[k + 1])
        pieces.append(shortened_piece(run, limits, piece, state[:, k : k + 2], planner))
    return ChainLaw([*pieces, LawPiece(direct, times[-1], direct.duration)])


def interval_ends(run: DetourRun, direct: TimeLaw) -> tuple[list[float], Floats]:
    """When the direct law is at the ends of the intervals that are timed anew, and its states (4, n) there."""
    commanded = run.detour.commanded
    law = commanded.law
    points = law.s if isinstance(law, QuinticLaw) else reference_points(commanded.run, None)
    after = points[points > run.join * (1.0 + BEYOND) + BEYOND]
    times = [0.0, *map(float, run.kinks), run.detour.duration]
    rejoining = len(times) - 1
    if len(after) > 1:
        times.append(direct.passing_time(float(after[0])))
    state = direct.at(np.array(times))
    # to the last digit, since the third derivative jumps there
    state[0, rejoining] = run.join
    if len(after) > 1:
        state[0, -1] = after[0]
    return times, state


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

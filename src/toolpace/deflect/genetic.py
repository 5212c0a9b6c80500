"""The paper's steps (3) and (4): periods of the detour and of the way on to the next reference point."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.deflect.detour import DetourRun
from toolpace.errors import InfeasibleError
from toolpace.laws.chain import ChainLaw, Piece
from toolpace.laws.law import TimeLaw
from toolpace.laws.quintic import QuinticLaw
from toolpace.machine.limits import Limits
from toolpace.planning.genetic.planner import Genetic, peaks, shortened
from toolpace.planning.genetic.preset_speeds import Preset
from toolpace.planning.genetic.problem import Intervals, reference_points
from toolpace.planning.guarantee import KEPT_INTERVAL


def genetic_law(run: DetourRun, limits: Limits, direct: TimeLaw, options: dict[str, Any]) -> TimeLaw:
    """The genetic algorithm on the detour and on the interval from the rejoining to the next reference point.

    Speeds and accelerations at all three points are those of the direct law, as the paper sets them to those of the
    reference path; from there on the direct law goes on. An interval whose direct period is not within the limits
    as a quintic (the direct law need not be one there) keeps the direct law.
    """
    from toolpace.deflect.replan import passing_time

    chosen = Genetic(**options)
    known = run.detour.known
    law = known.law
    points = law.s if isinstance(law, QuinticLaw) else reference_points(known.run, None)
    after = points[points > run.join * (1.0 + 1e-12) + 1e-12]
    marks = [0.0, *run.kinks, run.detour.duration]
    if len(after) > 1:
        marks.append(passing_time(direct, float(after[0])))
    state = direct.at(np.array(marks))
    # to the last digit, since the third derivative jumps there
    state[0, 1 + len(run.kinks)] = run.join
    if len(marks) > 2 + len(run.kinks):
        state[0, -1] = after[0]
    pieces: list[Piece] = []
    for k in range(len(marks) - 1):
        direct_piece = Piece(direct, marks[k], marks[k + 1])
        s, v, a = state[0, k : k + 2], state[1, k : k + 2], state[2, k : k + 2]
        parts = Intervals(run, limits, s.copy(), (False, False))
        given = Preset(v.copy(), a.copy(), np.array([marks[k + 1] - marks[k]]))
        if peaks(parts, given).max() > KEPT_INTERVAL:
            pieces.append(direct_piece)
            continue
        try:
            best = shortened(parts, given, chosen)
        except InfeasibleError:
            pieces.append(direct_piece)
            continue
        own = QuinticLaw(s.copy(), best.speed, best.acceleration, best.periods)
        pieces.append(
            Piece(own, 0.0, own.duration) if own.duration < direct_piece.end - direct_piece.begin else direct_piece
        )
    pieces.append(Piece(direct, marks[-1], direct.duration))
    return ChainLaw(pieces)

"""Holding a solution's limits between the nodes too."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.laws.spline import SplineLaw
from toolpace.planning.guarantee import ALLOWED
from toolpace.planning.optimal.dips import too_short
from toolpace.planning.optimal.ease import kept, worth
from toolpace.planning.optimal.meshed_run import Course
from toolpace.planning.optimal.solve import Stalled, slower
from toolpace.planning.optimal.windows import mend, solve_run, stretches
from toolpace.planning.peaks import cell_peaks
from toolpace.workers import Crew, Tell, part_of, untold

START_LOSS = 0.03
"""Share of z by which a solve that starts from a solution is slowed down first."""
WARM_SPREAD = 0.03
"""First gap of such a solve, relative to the duration."""
REFINE_ROUNDS = 6
LEAST_CELL = 1e-5
"""Time of a cell, as a share of that in which an acceleration builds up, below which it is cut no further."""
REFINE_ABOVE = 1.003
"""Usage between nodes from which a cell is cut rather than its limits lowered."""
QUARTER_ABOVE = 1.05
MOST_ROUNDS = 20
OVERSHOOT = 1.2
URGE = 1.3
MOST_OVERSHOOT = 6.0
"""How far a limit is lowered, as a multiple of how far it was passed; by how much more after each round; at most."""
MOST_MENDED = 0.3
"""Share of the nodes beyond which mending is no cheaper than solving anew."""


def guarded(course: Course, law: SplineLaw, fixed: bool, crew: Crew, tell: Tell = untold) -> SplineLaw:
    """The law with its limits held between the nodes too. Raises Stalled where that cannot be had.

    Where a limit is passed, the mesh is refined (unless it is fixed) or the rows there are tightened, and the
    surroundings are solved again. What that leaves, slowing down takes away.
    """
    c = law.c
    peak = cell_peaks(course, law, crew=crew)
    best, least = law, worth(law, peak, course.ramp)
    for round_ in range(MOST_ROUNDS):
        dips = law.dips()
        wrong = (peak.max(axis=1) > ALLOWED) | dips
        if not wrong.any():
            return kept(course, law, crew)
        worst = float(peak.max())
        parts = np.where(dips, 4, 1 if fixed or round_ >= REFINE_ROUNDS else halves(peak))
        parts[(np.diff(law.times) < course.ramp * LEAST_CELL) | too_short(law.nodes)] = 1
        if parts.max() > 1:
            course, c = course.finer(law, parts)
            wrong = np.repeat(wrong, parts)
            peak = np.repeat(np.where(parts[:, None] > 1, 1.0, peak), parts, axis=0)
        else:
            course.clock = law.times
        course.tighten(peak, min(OVERSHOOT * URGE ** max(round_ - 2, 0), MOST_OVERSHOOT), reach=1 + round_ // 3)
        # how many rounds there will be nobody knows; the first ones take the longest
        halfway = part_of(tell, 1.0 - 0.5**round_, 1.0 - 0.5 ** (round_ + 1))
        try:
            c, moved = resolve(course, c, wrong, START_LOSS + 1.0 - 1.0 / min(worst, 1.5), crew, halfway)
        except Stalled:
            break
        law = SplineLaw(course.nodes, c, course.rest)
        peak[moved] = cell_peaks(course, law, moved, crew)
        now = worth(law, peak, course.ramp)
        if now < least:
            best, least = law, now
    return kept(course, best, crew)


def halves(peak: Floats) -> Ints:
    """Parts into which the cells of these peaks (cells, 3) are cut."""
    worst = peak.max(axis=1)
    return np.where(worst > QUARTER_ABOVE, 4, np.where(worst > REFINE_ABOVE, 2, 1))


def resolve(
    course: Course, c: Floats, wrong: Bools, loss: float, crew: Crew, tell: Tell = untold
) -> tuple[Floats, Ints]:
    """New coefficients after the rows or the mesh at the marked cells changed, and the cells that moved.

    Only stretches around those cells are solved again, unless they are most of the run.
    """
    everything = np.arange(len(course.nodes) - 1)
    parts = stretches(course, wrong)
    if sum(part.high - part.low for part in parts) < MOST_MENDED * len(everything):
        mended, solved, stuck = mend(course, c, parts, loss, WARM_SPREAD, crew, tell)
        if not stuck or course.is_long:
            moved = np.zeros(len(everything), dtype=np.bool_)
            for low, high, _, _ in solved:
                moved[max(low - 1, 0) : high + 1] = True
            return mended, np.flatnonzero(moved)
    return solve_run(course, slower(course, c, loss), WARM_SPREAD, crew, tell), everything

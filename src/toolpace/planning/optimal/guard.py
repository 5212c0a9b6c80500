"""Holding a solution's limits between the nodes too."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.laws.spline import SplineLaw
from toolpace.planning.guarantee import ALLOWED
from toolpace.planning.optimal.dips import too_short
from toolpace.planning.optimal.ease import within_guarantee, worth
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import Stalled, slower
from toolpace.planning.optimal.windows import mend, solve_run, stretches
from toolpace.workers import UNTOLD, Progress, Workers

START_LOSS = 0.03
"""Share of z by which a solve that starts from a solution is slowed down first."""
WARM_SPREAD = 0.03
"""First gap of such a solve, relative to the duration."""
MOST_PASSED = 1.5
"""Usage beyond which a start is slowed down no further."""
REFINE_ROUNDS = 6
"""Rounds in which cells are cut; what passes a limit then is lowered only, lest the mesh grow without end."""
LEAST_CELL = 1e-5
"""Time of a cell, as a share of that in which an acceleration builds up, below which it is cut no further."""
REFINE_ABOVE = 1.003
"""Usage between nodes from which a cell is cut rather than its limits lowered."""
QUARTER_ABOVE = 1.05
"""The same, from which it is cut into four."""
MOST_ROUNDS = 20
"""Rounds after which the best law so far is slowed down."""
OVERSHOOT = 1.2
URGE = 1.3
MOST_OVERSHOOT = 6.0
"""How far a limit is lowered, as a multiple of how far it was passed; by how much more after each round; at most."""
MOST_MENDED = 0.3
"""Share of the nodes beyond which mending is no cheaper than solving anew."""


def guarded(
    meshed: MeshedRun, law: SplineLaw, fixed: bool, workers: Workers, progress: Progress = UNTOLD
) -> SplineLaw:
    """The law with its limits held between the nodes too. Raises Stalled where that cannot be had.

    repeat
      look between the nodes:  nothing passed?  done
      cut the cells that pass a limit by far (unless the mesh is fixed);  lower the limits of the others
      solve again around them;  keep the law that will be the fastest once it is slowed down to the guarantee
    slow the best one down to the guarantee
    """
    peak = meshed.peaks(law, workers=workers)
    best, least = law, worth(law, peak, meshed.ramp)
    for number in range(MOST_ROUNDS):
        dips = law.dips()
        wrong = (peak.max(axis=1) > ALLOWED) | dips
        if not wrong.any():
            return within_guarantee(meshed, law, workers)
        loss = START_LOSS + 1.0 - 1.0 / min(float(peak.max()), MOST_PASSED)
        parts = np.where(dips, 4, 1 if fixed or number >= REFINE_ROUNDS else halves(peak))
        parts[(np.diff(law.times) < meshed.ramp * LEAST_CELL) | too_short(law.nodes)] = 1
        meshed, c = meshed.cut(law, parts)
        wrong = np.repeat(wrong, parts)
        peak = np.repeat(np.where(parts[:, None] > 1, 1.0, peak), parts, axis=0)
        meshed.tighten(peak, min(OVERSHOOT * URGE ** max(number - 2, 0), MOST_OVERSHOOT), reach=1 + number // 3)
        # how many rounds there will be nobody knows; the first ones take the longest
        halfway = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
        try:
            c, moved = resolve(meshed, c, wrong, loss, workers, halfway)
        except Stalled:
            break
        law = SplineLaw(meshed.nodes, c, meshed.rest)
        peak[moved] = meshed.peaks(law, moved, workers)
        now = worth(law, peak, meshed.ramp)
        if now < least:
            best, least = law, now
    return within_guarantee(meshed, best, workers)


def halves(peak: Floats) -> Ints:
    """Parts into which the cells of these peaks (cells, 3) are cut."""
    worst = peak.max(axis=1)
    return np.where(worst > QUARTER_ABOVE, 4, np.where(worst > REFINE_ABOVE, 2, 1))


def resolve(
    meshed: MeshedRun, c: Floats, wrong: Bools, loss: float, workers: Workers, progress: Progress = UNTOLD
) -> tuple[Floats, Ints]:
    """New coefficients after the rows or the mesh at the marked cells changed, and the cells that moved.

    Only stretches around those cells are solved again, unless they are most of the run.
    """
    everything = np.arange(len(meshed.nodes) - 1)
    parts = stretches(meshed, wrong)
    if sum(part.high - part.low for part in parts) < MOST_MENDED * len(everything):
        mended, solved, stuck = mend(meshed, c, parts, loss, WARM_SPREAD, workers, progress)
        if not stuck or meshed.is_long:
            moved = np.zeros(len(everything), dtype=np.bool_)
            for low, high, _, _ in solved:
                moved[max(low - 1, 0) : high + 1] = True
            return mended, np.flatnonzero(moved)
    return solve_run(meshed, slower(meshed, c, loss), WARM_SPREAD, workers, progress), everything

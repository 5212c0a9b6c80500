"""The smoothest spline inside its tube, window by window.

What happens at one place does not reach far along the path: windows with fixed ends, and then windows over their
seams, come as close to the answer for the whole as one wants, in linear time. Ranges of one stage are GAP apart: no
sample touches two of them, so each can be solved while the others change, and the result is the same on any number
of cores.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.path.fit.spline import Samples, Spline, knots_of

USED = 0.95
"""Share of the tolerance that the samples may use; what lies between takes some of the rest."""
ACCURACY = 0.02
"""Duality gap over roughness, in each stretch of 32 cells."""
STEPS = 80
WAVE = 500.0
"""Waves longer than so many cells are gently pulled towards the polyline, which keeps the Newton matrix regular."""
WINDOW = 2000
"""Coefficients of a window."""
SEAM = 250
"""Coefficients on either side of a seam that are worked on again."""
GAP = 5
"""Coefficients between the ranges of a stage."""
REACH = 25
"""Cells on either side of a place that are worked on with it."""

Range = tuple[int, int]


def tighten(
    spline: Spline,
    data: Samples,
    weight: Floats,
    least_third: float,
    radius: Floats,
    where: Floats | None,
    workers: Workers,
    progress: Progress,
    rows: tuple[Floats, Floats] | None = None,
) -> None:
    """Minimise the roughness of a spline inside the tube, in place.

    `rows` (cells, 3, 6) make the roughness of each cell, and it weighs (cells,): see `SpeedWeights.rows`. None: that of
    the third derivative, all cells alike.
    `least_third` is a third derivative [tolerances, at unit weight] that no axis would feel; `radius` (m,) the share
    of the tolerance that may be used at each sample. `where` names parameters about which alone to work; None is
    everywhere.
    """
    from toolpace.kernels.fit import smoothing_spline as kernel
    from toolpace.kernels.fit.quintic_spline import third_rows
    from toolpace.kernels.fit.smoothest import smoothest

    h = np.diff(spline.breaks)
    third, cells = rows or (third_rows(knots_of(spline.breaks)), np.ones(len(h)))
    floor = 0.5 * least_third**2 * h * cells
    groups = ((spline.tip, np.ones(3), data.tip), (spline.turn, weight, data.turn))

    def solve(which: int, part: Range) -> None:
        x, share, target = groups[which]
        low, high = part
        base, end = max(0, low - 5), min(len(x), high + 5)
        j = slice(*np.searchsorted(data.first, [low - 5, high]))
        metric = data.metrics(which, j)
        pull = (2.0 * np.pi / (WAVE * h[data.first[j]])) ** 6 * data.gap[j] * cells[data.first[j]]
        moved = x[base:end].copy()
        samples = kernel.Samples(data.first[j] - base, data.rows[j], target[j], metric)
        allowed = USED * radius[j] * data.room[j, which]
        steps, _, _ = smoothest(
            kernel.Roughness(third[base : end - 5], share), samples, kernel.Tube(allowed, pull), moved,
            kernel.Free(low - base, high - base), floor[base : end - 5], ACCURACY, STEPS,
        )  # fmt: skip
        if 0 <= steps < STEPS or np.all(data.off(j, moved, base, target, metric) <= 1.02 * allowed):
            x[low:high] = moved[low - base : high - base]

    solve_ranges(ranges(spline.breaks, where), solve, workers, progress)


def ranges(breaks: Floats, where: Floats | None) -> list[list[Range]]:
    """Ranges of coefficients, stage by stage: about the parameters `where`, or everywhere."""
    n = len(breaks) + 4
    return everywhere(n) if where is None else [near(n, np.searchsorted(breaks, where))]


def everywhere(n: int) -> list[list[Range]]:
    """Ranges that cover n coefficients but for the ends and the seams, and then those over the seams."""
    seams = np.linspace(0, n, max(1, round(n / WINDOW)) + 1).astype(int)
    seams[0], seams[-1] = 1, n - 1 + GAP
    whole = [(int(a), int(b) - GAP) for a, b in pairwise(seams)]
    return [whole, [(int(a) - SEAM, int(a) + SEAM) for a in seams[1:-1]]]


def near(n: int, cells: npt.NDArray[np.intp]) -> list[Range]:
    """Disjoint ranges of coefficients within REACH of the cells."""
    out: list[Range] = []
    for cell in np.unique(cells):
        low, high = max(1, int(cell) - REACH), min(n - 1, int(cell) + REACH + 5)
        if out and low < out[-1][1] + GAP:
            out[-1] = (out[-1][0], high)
        else:
            out.append((low, high))
    return out


def solve_ranges(
    stages: list[list[Range]], solve: Callable[[int, Range], None], workers: Workers, progress: Progress = UNTOLD
) -> None:
    """solve(0, range) for the tip and solve(1, range) for the turn, for all ranges, on all cores stage by stage."""
    jobs = [[(which, part) for part in stage for which in range(2)] for stage in stages]
    parts = progress.split([len(stage) for stage in jobs])
    for stage, reported in zip(jobs, parts):
        workers.each(lambda job: solve(*job), stage, reported)

"""The smoothing of a spline inside its tube, window by window."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.workers import Progress, Workers
from toolpace.path.fit.samples import Samples
from toolpace.path.fit.spline import Spline, knots_of
from toolpace.path.fit.windows import Range, ranges, solve_ranges

USED = 0.95
"""Share of the tolerance that the samples may use; what lies between takes some of the rest."""
ACCURACY = 0.02
"""Duality gap over roughness, in each stretch of 32 cells."""
STEPS = 80
WAVE = 500.0
"""Waves longer than so many cells are gently pulled towards the polyline, which keeps the Newton matrix regular."""


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

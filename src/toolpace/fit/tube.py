"""Smooth the spline of a run as far as its tube allows, window by window.

What happens at one place does not reach far along the path: windows with fixed ends, and then windows over their
seams, come as close to the optimum of the whole as one wants, in linear time, and may be solved side by side.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

from toolpace.fit.mesh import Samples, knots_of
from toolpace.pathrun import Floats

USED = 0.95
"""Share of the tolerance that the samples may use; what lies between takes some of the rest."""
WINDOW = 2000
"""Coefficients that are smoothed at once."""
SEAM = 250
"""Coefficients on either side of a seam that are smoothed again."""
GAP = 5
"""Coefficients between ranges that are solved side by side."""
REACH = 25
"""Cells on either side of a repair that are smoothed again."""
ACCURACY = 0.02
"""Duality gap over roughness, in each stretch of 32 cells."""
STEPS = 80


def tighten(
    breaks: Floats,
    data: Samples,
    tip: Floats,
    turn: Floats,
    weight: Floats,
    least_third: float,
    radius: Floats,
    where: Floats | None,
    report: Callable[[float], None],
) -> None:
    """Minimise the roughness of tip and turn inside the tube, in place.

    `least_third` is a third derivative [tolerances, at unit weight] that no axis would feel; `radius` (m,) the share
    of the tolerance that may be used at each sample. `where` names parameters about which alone to work; None is
    everywhere. `report` is told the share done.
    """
    from toolpace.kernels.spline import third_rows
    from toolpace.kernels.tube import smoothest

    third = third_rows(knots_of(breaks))
    h = np.diff(breaks)
    # a gentle pull towards the polyline on waves longer than 500 cells keeps the Newton matrix regular
    gap = np.gradient(data.s) if len(data.s) > 1 else np.ones(1)
    pull = (2.0 * np.pi / (500.0 * h[data.first])) ** 6 * np.abs(gap)
    floor = 0.5 * least_third**2 * h
    tips = np.broadcast_to(np.eye(3), (len(data.s), 3, 3)).copy()
    groups = [
        (tip, np.ones(3), data.tip, tips),
        (turn, weight, data.turn, data.metric),
    ]

    def solve(job: tuple[int, int, int]) -> None:
        which, low, high = job
        x, share, target, metric = groups[which]
        base = max(0, low - 5)
        end = min(len(x), high + 5)
        j0, j1 = np.searchsorted(data.first, [low - 5, high])
        before = x[base:end].copy()
        steps, _, _ = smoothest(
            third[base : end - 5],
            share,
            data.first[j0:j1] - base,
            data.rows[j0:j1],
            target[j0:j1],
            metric[j0:j1],
            pull[j0:j1],
            USED * radius[j0:j1],
            before,
            low - base,
            high - base,
            floor[base : end - 5],
            ACCURACY,
            STEPS,
        )
        kept = before[low - base : high - base]
        if 0 <= steps < STEPS or not strays(data, before, base, (j0, j1), target, metric, USED * radius):
            x[low:high] = kept

    spans = windows(len(tip)) if where is None else [near(breaks, where)]
    jobs = [[(which, low, high) for low, high in stage for which in range(2)] for stage in spans]
    count = sum(len(stage) for stage in jobs)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        done = 0
        for stage in jobs:
            for _ in pool.map(solve, stage):
                done += 1
                report(done / count)


def strays(
    data: Samples, x: Floats, base: int, part: tuple[int, int], target: Floats, metric: Floats, radius: Floats
) -> bool:
    """Whether the spline with coefficients x from `base` on leaves the tube at the samples of the part."""
    j = slice(*part)
    r = np.einsum("jk,jkc->jc", data.rows[j], x[data.first[j, None] - base + np.arange(6)]) - target[j]
    square = np.einsum("jc,jcd,jd->j", r, metric[j], r)
    return not bool(np.all(square <= (1.02 * radius[j]) ** 2))


def windows(n: int) -> list[list[tuple[int, int]]]:
    """Ranges of coefficients that cover n but for the ends and the seams, and then those over the seams.

    Ranges of one stage are GAP apart: no sample touches two of them, so each can be solved while the others change.
    """
    seams = np.linspace(0, n, max(1, round(n / WINDOW)) + 1).astype(int)
    seams[0], seams[-1] = 1, n - 1 + GAP
    whole = [(int(a), int(b) - GAP) for a, b in pairwise(seams)]
    return [whole, [(int(a) - SEAM, int(a) + SEAM) for a in seams[1:-1]]]


def near(breaks: Floats, where: Floats) -> list[tuple[int, int]]:
    """Disjoint ranges of coefficients within REACH cells of the parameters."""
    n = len(breaks) + 4
    out: list[tuple[int, int]] = []
    for cell in np.unique(np.searchsorted(breaks, where)):
        low, high = max(1, int(cell) - REACH), min(n - 1, int(cell) + REACH + 5)
        if out and low < out[-1][1] + GAP:
            out[-1] = (out[-1][0], high)
        else:
            out.append((low, high))
    return out

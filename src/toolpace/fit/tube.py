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
SEAM = 250
ACCURACY = 0.02
STEPS = 80


def tighten(
    breaks: Floats,
    data: Samples,
    tip: Floats,
    turn: Floats,
    weight: Floats,
    least_third: float,
    radius: Floats,
    report: Callable[[float], None],
) -> None:
    """Minimise the roughness of tip and turn inside the tube, in place.

    `least_third` is a third derivative [tolerances, at unit weight] that no axis would feel; `radius` (m,) the share
    of the tolerance that may be used at each sample. `report` is told the share done.
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
        if steps >= 0 and np.all(np.isfinite(before)):
            x[low:high] = before[low - base : high - base]

    n = len(tip)
    count = max(1, round(n / WINDOW))
    seams = np.linspace(0, n, count + 1).astype(int)
    seams[0], seams[-1] = 1, n - 1
    whole = [(which, int(a), int(b)) for a, b in pairwise(seams) for which in range(2)]
    between = [(which, int(a) - SEAM, int(a) + SEAM) for a in seams[1:-1] for which in range(2)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        done = 0
        for stage in (whole, between):
            for _ in pool.map(solve, stage):
                done += 1
                report(done / (len(whole) + len(between)))

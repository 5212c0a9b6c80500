"""Windows of spline coefficients that are solved in parallel.

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

WINDOW = 2000
"""Coefficients of a window."""
SEAM = 250
"""Coefficients on either side of a seam that are worked on again."""
GAP = 5
"""Coefficients between the ranges of a stage."""
REACH = 25
"""Cells on either side of a place that are worked on with it."""

Range = tuple[int, int]


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
    for stage, told in zip(jobs, parts):
        workers.each(lambda job: solve(*job), stage, told)

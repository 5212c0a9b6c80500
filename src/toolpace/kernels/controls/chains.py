"""Chains of moves within a tolerance of one straight line, for a compressor."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

MOST = 100
"""Moves of a chain."""
ROUNDING = 1e-9
"""Share of a tolerance by which sums of lengths may be off."""


@jit()
def chains_of(place: Floats, tolerance: Floats, alone: Bools, cut: Bools) -> Ints:
    """The chain (n,) that each move belongs to, from 0 on.

    place: (n, axes) of the axes at the end of each move, in lengths; row 0 is where the first one starts. tolerance:
    (n,). alone: (n,) moves that are joined with no other. cut: (n,) moves behind which a chain ends in any case.
    """
    n = len(place)
    chain = np.zeros(n, dtype=np.int64)
    first = 1
    for i in range(1, n):
        begins = i == first or alone[i] or alone[i - 1] or cut[i - 1] or not _joins(place, tolerance[i], first, i)
        if begins:
            first = i
        chain[i] = chain[i - 1] + begins
    return chain


@jit()
def _joins(place: Floats, tolerance: float, first: int, i: int) -> bool:
    """Whether the moves from `first` up to i stay within the tolerance of the line from end to end."""
    if tolerance <= 0.0 or i - first >= MOST:
        return False
    axes, square = place.shape[1], 0.0
    for k in range(axes):
        square += (place[i, k] - place[first - 1, k]) ** 2
    if square == 0.0:
        return False
    for row in range(first, i):
        along = 0.0
        for k in range(axes):
            along += (place[row, k] - place[first - 1, k]) * (place[i, k] - place[first - 1, k])
        share, off = min(max(along / square, 0.0), 1.0), 0.0
        for k in range(axes):
            spoke = place[row, k] - place[first - 1, k]
            off += (spoke - share * (place[i, k] - place[first - 1, k])) ** 2
        if off > (tolerance * (1.0 + ROUNDING)) ** 2:
            return False
    return True

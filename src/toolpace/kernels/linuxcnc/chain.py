"""Straight blocks of one feed joined within a tolerance, as LinuxCNC's canon does.

Source: LinuxCNC's documents, "G64 P Q" ("naive cam detector").
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.vectors import Vector, along, dot, from_to, norm

MOST = 101
"""Points of a chain."""


@jit()
def chain_ends(place: Floats, tolerance: Floats, alone: Bools, cut: Bools) -> Ints:
    """Rows at which blocks end.

    place: (n, 3) of X, Y, Z at the end of each row, from row 0, where it starts. tolerance: (n,), 0 where rows stay as
    they are. alone: (n,) rows that are joined with no other. cut: (n,) rows behind which a block ends in any case.
    """
    n = len(place)
    ends = np.empty(n, dtype=np.int64)
    count = 0
    first = 1  # of the chain
    for i in range(1, n):
        if i > first and (alone[i] or not joins(place, tolerance[i], first, i)):
            ends[count] = i - 1
            count += 1
            first = i
        if alone[i] or cut[i]:
            ends[count] = i
            count += 1
            first = i + 1
    if first < n:
        ends[count] = n - 1
        count += 1
    return ends[:count]


@jit(inline=True)
def joins(place: Floats, tolerance: float, first: int, i: int) -> bool:
    """Whether the rows from `first` up to i may be one block."""
    if tolerance <= 0.0 or i - first >= MOST:
        return False
    base = point(place, first - 1)
    way = from_to(base, point(place, i))
    square = dot(way, way)
    if square == 0.0:
        return False
    for k in range(first, i):
        spoke = from_to(base, point(place, k))
        share = min(max(dot(way, spoke) / square, 0.0), 1.0)
        if norm(along(spoke, -share, way)) > tolerance:
            return False
    return True


@jit(inline=True)
def point(place: Floats, i: int) -> Vector:
    """Place of a row."""
    return place[i, 0], place[i, 1], place[i, 2]

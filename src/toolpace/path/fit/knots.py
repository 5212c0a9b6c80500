"""Knots of the fitted spline, from the vertices of the polyline."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import PathError
from toolpace.path.fit.polyline import Polyline

SPACING = 20.0
"""Least distance of the first knots [tolerances]: curves that differ by less than a tolerance need no closer ones."""
RATIO = 2.5
"""Most ratio of the lengths of neighbouring cells."""
LEAST = 1e-4
"""Shortest cell [tolerances]."""


def first_breaks(line: Polyline) -> Floats:
    """Breaks at vertices, SPACING of their own tolerances apart or more, and graded; two cells at least."""
    from toolpace.kernels.fit.quintic_spline import thin

    s = line.s
    own = np.concatenate([s[:1], np.cumsum(np.diff(s) / line.room.min(axis=1))])
    breaks = s[np.searchsorted(own, thin(own, SPACING))] if np.any(line.room != 1.0) else thin(s, SPACING)
    if len(breaks) < 3:
        breaks = np.array([s[0], 0.5 * (s[0] + s[-1]), s[-1]])
    return graded(breaks)


def graded(breaks: Floats) -> Floats:
    """The breaks with cells halved until none is more than RATIO times as long as a neighbour."""
    while True:
        h = np.diff(breaks)
        least = h.copy()
        least[1:] = np.minimum(least[1:], h[:-1])
        least[:-1] = np.minimum(least[:-1], h[1:])
        long = h > RATIO * least
        if not np.any(long):
            return breaks
        middle = 0.5 * (breaks[:-1] + breaks[1:])[long]
        breaks = np.sort(np.concatenate([breaks, middle]))


def refined_at(vertices: Floats, breaks: Floats, bad: Floats) -> Floats:
    """The breaks with the cells that hold or touch a bad parameter cut in two."""
    split = np.zeros(len(breaks) - 1, dtype=bool)
    for side in (-1e-9, 1e-9):
        at = np.searchsorted(breaks, bad + side * (1.0 + bad), side="right") - 1
        split[np.clip(at, 0, len(split) - 1)] = True
    if np.any(np.diff(breaks)[split] < LEAST):
        raise PathError("the program asks for a corner that no curve within the tolerance can follow")
    return graded(np.sort(np.concatenate([breaks, middles(vertices, breaks, split)])))


def middles(vertices: Floats, breaks: Floats, split: Bools) -> Floats:
    """Where to cut the cells: at the vertex nearest the middle if there is one in the middle half."""
    low, high = breaks[:-1][split], breaks[1:][split]
    middle = 0.5 * (low + high)
    above = np.clip(np.searchsorted(vertices, middle), 1, len(vertices) - 1)
    near = np.where(vertices[above] - middle < middle - vertices[above - 1], vertices[above], vertices[above - 1])
    return np.asarray(np.where(np.abs(near - middle) < 0.25 * (high - low), near, middle))

"""What jumps where a cut begins is made smooth along the way: averaged over a length, three times a third of it.

Three averages over a width w in series are one under a quadratic B-spline K of length L = 3 w. Steps of any kind come
out twice continuously differentiable, and with |value| <= D everywhere, whatever it does,

    |blended| <= D
    |slope| <= D int |K'| = 3 D / (2 w) = 4.5 D / L
    |second derivative| <= D int |K''| = 4 D / w^2 = 36 D / L^2
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats

BOXES = 3


def blended(way: Floats, value: Floats, length: float) -> Floats:
    """Averages (n, d) at ascending places (n,) [m] of a value (n - 1, d) that is constant between them.

    Beyond both ends it is nothing. Places must lie closer than a small share of the length [m] wherever the value is
    not nothing within half of that length: between them the averages are taken as straight.
    """
    width = length / BOXES
    places, back = np.unique(way, return_inverse=True)
    pad = width * np.linspace(-0.5 * (BOXES + 1), 0.0, 128, endpoint=False)
    grid = np.concatenate([places[0] + pad, places, places[-1] - pad[::-1]])
    # where places stand twice the way between them has no length, and its value no weight
    moves = way[1:] > way[:-1]
    steps = np.zeros((len(grid) - 1, value.shape[1]))
    steps[np.searchsorted(grid, way[:-1])[moves]] = value[moves]
    left, right = steps, steps
    for _ in range(BOXES):
        found = _moving_average(grid, left, right, width)
        left, right = found[:-1], found[1:]
    result: Floats = found[len(pad) :][: len(places)][back]
    return result


def _moving_average(grid: Floats, left: Floats, right: Floats, width: float) -> Floats:
    """Means (n, d) over a width about places (n,); between them it goes straight from `left` to `right` (n - 1, d)."""
    dx = np.diff(grid)[:, None]
    whole = np.concatenate([np.zeros((1, left.shape[1])), np.cumsum(0.5 * (left + right) * dx, axis=0)])

    def integral(x: Floats) -> Floats:
        """(n, d) up to x."""
        x = np.clip(x, grid[0], grid[-1])
        k = np.clip(np.searchsorted(grid, x, side="right") - 1, 0, len(dx) - 1)
        h = (x - grid[k])[:, None]
        up_to: Floats = whole[k] + h * (left[k] + 0.5 * h / dx[k] * (right[k] - left[k]))
        return up_to

    found: Floats = (integral(grid + 0.5 * width) - integral(grid - 0.5 * width)) / width
    return found

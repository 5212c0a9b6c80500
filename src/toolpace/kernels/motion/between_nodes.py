"""A path between mesh nodes, as the quintics that its derivatives at the nodes determine."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.narrow_features import missing

LANES = 64
"""Cells that are worked on side by side, for vector instructions: the probes of one are too few."""


@jit()
def path_between(low: Floats, high: Floats, length: Floats, inside: Floats, out: Floats) -> None:
    """Set q', q'', q''' at the shares `inside` (k,) of cells.

    Parameters: low and high (4, n, m) position and derivatives at the beginning and at the end of each cell, and length
    (n,) of it; out (n, 3, m, k). The error of q' is of the sixth order of the length.
    """
    k, m = len(inside), low.shape[2]
    quintic, told = np.empty((6, LANES)), np.empty((k, 3, LANES))
    for first in range(0, len(length), LANES):
        count = min(LANES, len(length) - first)
        for axis in range(m):
            _set_quintics(low, high, length, first, count, axis, quintic)
            for p in range(k):
                _set_values(quintic, length, first, count, inside[p], told[p])
            for i in range(count):
                for order in range(3):
                    for p in range(k):
                        out[first + i, order, axis, p] = told[p, order, i]


@jit(reorder=True)
def _set_quintics(low: Floats, high: Floats, length: Floats, first: int, count: int, axis: int, out: Floats) -> None:
    """Set the coefficients (6, count) of q' of one axis over shares of some cells, from both ends of them."""
    for i in range(count):
        cell = first + i
        h = length[cell]
        f0, d0, c0 = low[1, cell, axis], h * low[2, cell, axis], h * h * low[3, cell, axis]
        f1, d1, c1 = high[1, cell, axis], h * high[2, cell, axis], h * h * high[3, cell, axis]
        rise, slope, bend = f1 - f0 - d0 - 0.5 * c0, d1 - d0 - c0, c1 - c0
        out[0, i], out[1, i], out[2, i] = f0, d0, 0.5 * c0
        out[3, i] = 10.0 * rise - 4.0 * slope + 0.5 * bend
        out[4, i] = -15.0 * rise + 7.0 * slope - bend
        out[5, i] = 6.0 * rise - 3.0 * slope + 0.5 * bend


@jit(reorder=True)
def _set_values(a: Floats, length: Floats, first: int, count: int, x: float, out: Floats) -> None:
    """Set the value and two derivatives by s (3, count) of quintics (6, count) at the share x of their cells."""
    for i in range(count):
        per_length = 1.0 / length[first + i]
        a1, a2, a3, a4, a5 = a[1, i], a[2, i], a[3, i], a[4, i], a[5, i]
        out[0, i] = a[0, i] + x * (a1 + x * (a2 + x * (a3 + x * (a4 + x * a5))))
        out[1, i] = (a1 + x * (2.0 * a2 + x * (3.0 * a3 + x * (4.0 * a4 + x * 5.0 * a5)))) * per_length
        out[2, i] = (2.0 * a2 + x * (6.0 * a3 + x * (12.0 * a4 + x * 20.0 * a5))) * per_length * per_length


@jit()
def unlike(
    s: Floats, low: Floats, high: Floats, middle: Floats, length: Floats, z: Floats, velocity: Floats,
    acceleration: Floats, jerk: Floats,
) -> Floats:  # fmt: skip
    """(N,) largest share of a limit, at (ds/dt)^2 = z (N,), by which the path is unlike that quintic in each cell.

    From its derivatives in the middle, and from what its positions gain. Parameters: s (N,) where cells begin; low,
    middle and high (4, N, m) position and derivatives; length (N,) of the cells.
    """
    out = np.zeros(len(length))
    told = np.empty((len(length), 3, low.shape[2], 1))
    path_between(low, high, length, np.array([0.5]), told)
    missed = missing(low, high, s, length, np.sqrt(z), np.zeros((3, low.shape[2])))
    for i in range(len(length)):
        h, v = length[i], np.sqrt(z[i])
        for axis in range(low.shape[2]):
            by = abs(middle[1, i, axis] - told[i, 0, axis, 0]) * v / velocity[axis]
            by = max(by, abs(middle[2, i, axis] - told[i, 1, axis, 0]) * v**2 / acceleration[axis])
            by = max(by, abs(middle[3, i, axis] - told[i, 2, axis, 0]) * v**3 / jerk[axis])
            gain = missed[i, 0, axis] * v / h
            by = max(by, gain / velocity[axis], gain * v / h / acceleration[axis], gain * (v / h) ** 2 / jerk[axis])
            out[i] = max(out[i], by)
    return out

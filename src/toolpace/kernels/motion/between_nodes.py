"""A path between the nodes of a mesh, from its derivatives at them: q' as the quintic that both ends determine."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.hidden import missing


@jit(reorder=True)
def path_between(which: Ints, low: Floats, high: Floats, length: Floats, inside: Floats, out: Floats) -> None:
    """Set q', q'', q''' at the shares `inside` (k,) of some cells.

    Parameters: which (n,) cells; low and high (4, N, m) position and derivatives at the beginning and at the end of
    each cell of the mesh, and length (N,) of it; out (n, 3, m, k). The error of q' is of the sixth order of the length.
    """
    k, m = len(inside), low.shape[2]
    for i in range(len(which)):
        cell = which[i]
        h = length[cell]
        per_length, per_square = 1.0 / h, 1.0 / (h * h)
        for axis in range(m):
            # over x in [0, 1]: values and derivatives at both ends
            f0, d0, c0 = low[1, cell, axis], h * low[2, cell, axis], h * h * low[3, cell, axis]
            f1, d1, c1 = high[1, cell, axis], h * high[2, cell, axis], h * h * high[3, cell, axis]
            rise, slope, bend = f1 - f0 - d0 - 0.5 * c0, d1 - d0 - c0, c1 - c0
            a3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
            a4 = -15.0 * rise + 7.0 * slope - bend
            a5 = 6.0 * rise - 3.0 * slope + 0.5 * bend
            for p in range(k):
                x = inside[p]
                out[i, 0, axis, p] = f0 + x * (d0 + x * (0.5 * c0 + x * (a3 + x * (a4 + x * a5))))
                out[i, 1, axis, p] = (d0 + x * (c0 + x * (3.0 * a3 + x * (4.0 * a4 + x * 5.0 * a5)))) * per_length
                out[i, 2, axis, p] = (c0 + x * (6.0 * a3 + x * (12.0 * a4 + x * 20.0 * a5))) * per_square


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
    half, told = np.array([0.5]), np.empty((1, 3, low.shape[2], 1))
    missed = missing(low, high, s, length, np.sqrt(z), np.zeros((3, low.shape[2])))
    for i in range(len(length)):
        h, v = length[i], np.sqrt(z[i])
        path_between(np.array([i]), low, high, length, half, told)
        for axis in range(low.shape[2]):
            by = abs(middle[1, i, axis] - told[0, 0, axis, 0]) * v / velocity[axis]
            by = max(by, abs(middle[2, i, axis] - told[0, 1, axis, 0]) * v**2 / acceleration[axis])
            by = max(by, abs(middle[3, i, axis] - told[0, 2, axis, 0]) * v**3 / jerk[axis])
            gain = missed[i, 0, axis] * v / h
            by = max(by, gain / velocity[axis], gain * v / h / acceleration[axis], gain * (v / h) ** 2 / jerk[axis])
            out[i] = max(out[i], by)
    return out

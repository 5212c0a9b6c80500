"""Quintics in time that carry every joint from one state to another: what they take of the limits."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

SAMPLES = 24
HALVINGS = 40


@jit()
def polynomial(c: Floats, tau: float, order: int) -> float:
    """The order-th derivative (0 to 3) of the quintic C0 to C5 (6,) at tau."""
    value: float = 6.0 * c[3] + tau * (24.0 * c[4] + tau * 60.0 * c[5])
    if order == 0:
        value = c[0] + tau * (c[1] + tau * (c[2] + tau * (c[3] + tau * (c[4] + tau * c[5]))))
    elif order == 1:
        value = c[1] + tau * (2.0 * c[2] + tau * (3.0 * c[3] + tau * (4.0 * c[4] + tau * 5.0 * c[5])))
    elif order == 2:
        value = 2.0 * c[2] + tau * (6.0 * c[3] + tau * (12.0 * c[4] + tau * 20.0 * c[5]))
    return value


@jit()
def largest(c: Floats, order: int) -> float:
    """Largest absolute value of the order-th derivative (1 to 3) over [0, 1], at its turning points too."""
    worst = max(abs(polynomial(c, 0.0, order)), abs(polynomial(c, 1.0, order)))
    if order == 3:
        if c[5] != 0.0 and 0.0 < -c[4] / (5.0 * c[5]) < 1.0:
            worst = max(worst, abs(polynomial(c, -c[4] / (5.0 * c[5]), 3)))
        return worst
    left = polynomial(c, 0.0, order + 1)
    for k in range(SAMPLES):
        right = polynomial(c, (k + 1.0) / SAMPLES, order + 1)
        if left * right < 0.0:
            low, high = k / SAMPLES, (k + 1.0) / SAMPLES
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if polynomial(c, middle, order + 1) * left > 0.0:
                    low = middle
                else:
                    high = middle
            worst = max(worst, abs(polynomial(c, low, order)))
        left = right
    return worst


@jit()
def usages(start: Floats, ends: Floats, periods: Floats, limits: Floats) -> Floats:
    """(n,) largest value over limit of bridges from start (3, m) to ends (n, 3, m) in periods (n,).

    States are positions, velocities and accelerations; limits (3, m) velocity, acceleration, jerk.
    """
    n, m = ends.shape[0], ends.shape[2]
    out = np.zeros(n)
    c = np.empty(6)
    for k in range(n):
        t = periods[k]
        for i in range(m):
            c[0], c[1], c[2] = start[0, i], start[1, i] * t, start[2, i] * t * t / 2.0
            d1 = ends[k, 0, i] - c[0] - c[1] - c[2]
            d2 = ends[k, 1, i] * t - c[1] - 2.0 * c[2]
            d3 = ends[k, 2, i] * t * t / 2.0 - c[2]
            c[3], c[4], c[5] = 10.0 * d1 - 4.0 * d2 + d3, -15.0 * d1 + 7.0 * d2 - 2.0 * d3, 6.0 * d1 - 3.0 * d2 + d3
            scale = 1.0
            for order in range(3):
                scale *= t
                out[k] = max(out[k], largest(c, order + 1) / (scale * limits[order, i]))
                if out[k] > 10.0:
                    break
    return out

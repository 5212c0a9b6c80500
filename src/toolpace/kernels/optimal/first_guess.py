"""The first guess of the speed along a path: pointwise limits with jerk-limited ramps."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit()
def pointwise(
    q: Floats, velocity: Floats, acceleration: Floats, jerk: Floats, speed_cap: Floats
) -> tuple[Floats, Floats, Floats]:
    """For each point of q (4, n, m): cap on z = (ds/dt)^2 by velocity and feed, by all limits at steady speed, and
    the most d3s/dt3 that the jerk limits leave at rest."""
    n, m = q.shape[1], q.shape[2]
    cap, steady, third = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        speed, low_bend, low_twist, low_third = speed_cap[i], np.inf, np.inf, np.inf
        for j in range(m):
            q1, q2, q3 = abs(q[1, i, j]), abs(q[2, i, j]), abs(q[3, i, j])
            if q1 > 0.0:
                speed = min(speed, velocity[j] / q1)
                low_third = min(low_third, jerk[j] / q1)
            if q2 > 0.0:
                low_bend = min(low_bend, acceleration[j] / q2)
            if q3 > 0.0:
                low_twist = min(low_twist, jerk[j] / q3)
        cap[i], third[i] = speed**2, low_third
        steady[i] = min(cap[i], low_bend, low_twist ** (2.0 / 3.0))
    return cap, steady, third


@jit()
def unseen(
    low: Floats, high: Floats, length: Floats, z: Floats, velocity: Floats, acceleration: Floats, jerk: Floats
) -> Floats:
    """(n,) largest share of a limit that (ds/dt)^2 = z would ask for between two points, unseen at both.

    `low` and `high` (4, n, m) hold position and derivatives at the two, `length` (n,) their distance.
    """
    n, m = low.shape[1], low.shape[2]
    worst = np.zeros(n)
    for i in range(n):
        speed = np.sqrt(z[i]) if z[i] < np.inf else 0.0
        for j in range(m):
            # what the value of one order changes by, beyond what the next order tells
            by0 = abs((high[0, i, j] - low[0, i, j]) / length[i] - (low[1, i, j] + high[1, i, j]) / 2.0)
            by1 = abs((high[1, i, j] - low[1, i, j]) / length[i] - (low[2, i, j] + high[2, i, j]) / 2.0)
            by2 = abs((high[2, i, j] - low[2, i, j]) / length[i] - (low[3, i, j] + high[3, i, j]) / 2.0)
            worst[i] = max(worst[i], by0 * speed / velocity[j])
            worst[i] = max(worst[i], by1 * speed**2 / acceleration[j])
            worst[i] = max(worst[i], by2 * speed**3 / jerk[j])
    return worst


@jit()
def ramped(s: Floats, steady: Floats, third: Floats, z0: float, z1: float) -> Floats:
    """(n,) z below `steady` whose ramps respect d3s/dt3 <= `third` as if from rest, starting at z0 and ending at z1.

    They are straight in w = z^(3/4), and less steep than a ramp from rest, which is 2.12 sqrt(third).
    """
    n = len(s)
    w = np.empty(n)
    for i in range(n):
        w[i] = steady[i] ** 0.75
    w[0] = min(w[0], z0**0.75)
    w[n - 1] = min(w[n - 1], z1**0.75)
    for i in range(1, n):
        w[i] = min(w[i], w[i - 1] + np.sqrt(min(third[i], third[i - 1])) * (s[i] - s[i - 1]))
    for i in range(n - 2, -1, -1):
        w[i] = min(w[i], w[i + 1] + np.sqrt(min(third[i], third[i + 1])) * (s[i + 1] - s[i]))
    z: Floats = w ** (4.0 / 3.0)
    return z


@jit()
def times(s: Floats, z: Floats) -> Floats:
    """(n,) time to reach each point at the speeds sqrt(z), z^(3/4) being linear between points (exact next to rest)."""
    n = len(s)
    out = np.zeros(n)
    for i in range(n - 1):
        a, b = z[i] ** 0.25, z[i + 1] ** 0.25
        # integral of w^(-2/3) over a line from w = a^3 to b^3
        out[i + 1] = out[i] + 3.0 * (s[i + 1] - s[i]) / (a * a + a * b + b * b)
    return out

"""Values over limits along a motion: feed cap, then velocity, acceleration and jerk of each joint."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit


@jit()
def ratios(q: Floats, state: Floats, cap: Floats, velocity: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """(n, 1 + 3 m) from path derivatives q (4, n, m), states (4, n) of s and caps (n,) on ds/dt: the chain rule."""
    n, m = q.shape[1], q.shape[2]
    out = np.empty((n, 1 + 3 * m))
    for i in range(n):
        v, a, j = state[1, i], state[2, i], state[3, i]
        out[i, 0] = v / cap[i]
        for k in range(m):
            q1, q2, q3 = q[1, i, k], q[2, i, k], q[3, i, k]
            out[i, 1 + k] = abs(q1 * v) / velocity[k]
            out[i, 1 + m + k] = abs(q2 * v * v + q1 * a) / acceleration[k]
            out[i, 1 + 2 * m + k] = abs(q3 * v * v * v + 3.0 * q2 * v * a + q1 * j) / jerk[k]
    return out


@jit()
def peaks(place: Floats, ratio: Floats) -> Floats:
    """(cells, columns) largest value in each cell of samples at `place` (k,) in it; ratio (cells * k, columns).

    Where a sample is larger than both neighbours, the parabola through the three tells how high it goes between them.
    """
    k, columns = len(place), ratio.shape[1]
    cells = len(ratio) // k
    out = np.zeros((cells, columns))
    for c in range(cells):
        for col in range(columns):
            best = 0.0
            for i in range(k):
                value = ratio[c * k + i, col]
                if 0 < i < k - 1 and value > 0.9:
                    before, after = ratio[c * k + i - 1, col], ratio[c * k + i + 1, col]
                    if value >= before and value >= after:
                        h0, h1 = place[i] - place[i - 1], place[i + 1] - place[i]
                        rise0, rise1 = (value - before) / h0, (after - value) / h1
                        bend = (rise1 - rise0) / (h0 + h1)
                        if bend < 0.0:
                            slope = rise0 + bend * h0
                            value -= slope * slope / (4.0 * bend)
                best = max(best, value)
            out[c, col] = best
    return out


@jit()
def summits(s: Floats, ratio: Floats, most: float) -> Bools:
    """Raise samples of ratio (n, columns) at s (n,), in place, to the tops of the parabolas through three in a row.

    Returns (n - 1,) gaps beside a top that lies higher than its sample by more than `most`: to be looked into.
    """
    n, columns = ratio.shape
    out = np.zeros(max(n - 1, 0), dtype=np.bool_)
    for col in range(columns):
        before = ratio[0, col] if n > 0 else 0.0
        for i in range(1, n - 1):
            value, after = ratio[i, col], ratio[i + 1, col]
            h0, h1 = s[i] - s[i - 1], s[i + 1] - s[i]
            if value > 0.9 and value >= before and value >= after and h0 > 0.0 and h1 > 0.0:
                rise0, rise1 = (value - before) / h0, (after - value) / h1
                bend = (rise1 - rise0) / (h0 + h1)
                if bend < 0.0:
                    slope = rise0 + bend * h0
                    more = -slope * slope / (4.0 * bend)
                    if more > most:
                        out[i - 1] = out[i] = True
                    else:
                        ratio[i, col] = value + more
            before = value
    return out

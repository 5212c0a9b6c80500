"""Utilisation of the limits along a motion: feed cap, then velocity, acceleration and jerk of each joint."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

HIGH = 0.8
"""Usage from which it matters how high a peak goes between probes: three of them tell it to a fifth of a limit."""


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


@jit(inline=True)
def summit(x0: float, x1: float, x2: float, y0: float, y1: float, y2: float) -> tuple[float, float]:
    """Height and place of the top of the parabola through three points; the middle one where it has none."""
    h0, h1 = x1 - x0, x2 - x1
    rise0, rise1 = (y1 - y0) / h0, (y2 - y1) / h1
    bend = (rise1 - rise0) / (h0 + h1)
    if not bend < 0.0:
        return y1, x1
    slope = rise0 + bend * h0
    return y1 - slope * slope / (4.0 * bend), x1 - slope / (2.0 * bend)


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
                if 0 < i < k - 1 and value > HIGH:
                    before, after = ratio[c * k + i - 1, col], ratio[c * k + i + 1, col]
                    if value >= before and value >= after:
                        value, _ = summit(place[i - 1], place[i], place[i + 1], before, value, after)
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
        value = ratio[:, col].copy()
        for i in range(n):
            if not value[i] > HIGH:
                continue
            # Where two samples are at one place, each is the end of its side.
            is_first, is_last = i == 0 or s[i - 1] == s[i], i == n - 1 or s[i] == s[i + 1]
            low, high = (i, i + 2) if is_first else (i - 2, i) if is_last else (i - 1, i + 1)
            if low < 0 or high >= n or not s[low] < s[low + 1] < s[high]:
                continue
            if (not is_first and value[i - 1] > value[i]) or (not is_last and value[i + 1] > value[i]):
                continue
            top, at = summit(s[low], s[low + 1], s[high], value[low], value[low + 1], value[high])
            begin, end = s[i] if is_first else s[i - 1], s[i] if is_last else s[i + 1]
            if not (begin <= at <= end and top > value[i]):
                continue
            if top > value[i] + most:
                if not is_first:
                    out[i - 1] = True
                if not is_last:
                    out[i] = True
            else:
                ratio[i, col] = top
    return out

"""Path features between two evaluated places, as far as the path's increments tell.

Between two places position, slope and curvature change by the integrals of the next derivative. What both ends know of
that integral (Hermite's rule; for the curvature the trapezoid) is off by h^7, h^5, h^3 times higher derivatives on a
smooth path, and by the whole of what happens between them unseen, however short that is: a bend, a kink, a jump.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

ROUNDING = 64.0
"""Roundings of a value that a difference may be off by."""
ODD = 6.0
"""How many times its neighbours' error, brought to its own length, that of a gap is before it is looked into."""
STAYS = 0.25
"""Share of the error of a gap that is left in one of its halves where something happens in it; 1/8 on a smooth path."""
POWERS = (7, 5, 3)


@jit()
def missing(low: Floats, high: Floats, s: Floats, h: Floats, speed: Floats, least: Floats) -> Floats:
    """(n, 3, m) by how much position, slope and curvature change between two places beyond what both ends tell.

    low, high (4, n, m): the path at both; s (n,) where, h (n,) how far apart. What rounding explains is taken off, and
    changes of position, velocity and acceleration by less than `least` (3, m) at ds/dt = speed (n,) are let pass.
    """
    n, m = low.shape[1], low.shape[2]
    out = np.zeros((n, 3, m))
    eps = ROUNDING * 2.220446049250313e-16
    for i in range(n):
        if h[i] <= 0.0:
            continue
        for k in range(3):
            for j in range(m):
                change = high[k, i, j] - low[k, i, j] - 0.5 * h[i] * (low[k + 1, i, j] + high[k + 1, i, j])
                if k == 0:
                    change += h[i] ** 2 * (high[2, i, j] - low[2, i, j]) / 10.0
                    change -= h[i] ** 3 * (high[3, i, j] + low[3, i, j]) / 120.0
                elif k == 1:
                    change += h[i] ** 2 * (high[3, i, j] - low[3, i, j]) / 12.0
                slope = max(abs(low[k + 1, i, j]), abs(high[k + 1, i, j]))
                noise = least[k, j] / speed[i] ** k if speed[i] > 0.0 else 0.0
                noise += eps * (max(abs(low[k, i, j]), abs(high[k, i, j])) + (abs(s[i]) + h[i]) * slope)
                out[i, k, j] = max(abs(change) - noise, 0.0)
    return out


@jit()
def asked(missed: Floats, h: Floats, speed: Floats, velocity: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """(n,) largest share of a limit that what is missing asks for, spread over the gaps h (n,), at ds/dt = speed."""
    n, _, m = missed.shape
    out = np.zeros(n)
    for i in range(n):
        if h[i] <= 0.0:
            continue
        v = speed[i]
        for j in range(m):
            out[i] = max(out[i], missed[i, 0, j] / h[i] * v / velocity[j])
            out[i] = max(out[i], missed[i, 1, j] / h[i] * v * v / acceleration[j])
            out[i] = max(out[i], missed[i, 2, j] / h[i] * v * v * v / jerk[j])
    return out


@jit()
def odd_ones(missed: Floats, h: Floats) -> Bools:
    """(n,) gaps in a row from which more is missing than from their neighbours, for their length: there is something.

    missed (n, 3, m), h (n,).
    """
    n, _, m = missed.shape
    out = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        for k in range(3):
            for j in range(m):
                if missed[i, k, j] == 0.0 or out[i]:
                    continue
                expected = 0.0
                for other in (i - 2, i - 1, i + 1, i + 2):
                    if 0 <= other < n and h[other] > 0.0:
                        expected = max(expected, missed[other, k, j] * (h[i] / h[other]) ** POWERS[k])
                if missed[i, k, j] > ODD * expected:
                    out[i] = True
    return out


@jit()
def worse_half(whole: Floats, left: Floats, right: Floats) -> tuple[Bools, Bools]:
    """(n,) whether what is missing from gaps (n, 3, m) is missing from a half, too, and whether from the right one."""
    n, _, m = whole.shape
    stays, is_right = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    for i in range(n):
        best = STAYS
        for k in range(3):
            for j in range(m):
                if whole[i, k, j] > 0.0:
                    a, b = left[i, k, j] / whole[i, k, j], right[i, k, j] / whole[i, k, j]
                    if max(a, b) > best:
                        best = max(a, b)
                        stays[i], is_right[i] = True, b > a
    return stays, is_right

"""A path between mesh nodes: the quintics of its derivatives there, and features that these do not explain.

Between two places position, slope and curvature change by the integrals of the next derivative. What both ends say of
that integral (Hermite's rule; for the curvature the trapezoid) is off by h^7, h^5, h^3 times higher derivatives on a
smooth path, and by the whole of what happens between them unseen, however short that is: a bend, a kink, a jump.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

LANES = 64
"""Cells that are worked on side by side, for vector instructions: the probes of one are too few."""
ROUNDING = 64.0
"""Roundings of a value that a difference may be off by."""
ODD = 6.0
"""How many times its neighbours' error, brought to its own length, that of a gap is before it is looked into."""
STAYS = 0.25
"""Share of the error of a gap that is left in one of its halves where something happens in it; 1/8 on a smooth path."""
POWERS = (7, 5, 3)
"""Powers of the length that the errors of position, slope and curvature grow with."""


@jit()
def path_between(low: Floats, high: Floats, length: Floats, inside: Floats, out: Floats) -> None:
    """Set q', q'', q''' at the shares `inside` (k,) of cells.

    Parameters: low and high (4, n, m) position and derivatives at the beginning and at the end of each cell, and length
    (n,) of it; out (n, 3, m, k). The error of q' is of the sixth order of the length.
    """
    k, m = len(inside), low.shape[2]
    quintic, values = np.empty((6, LANES)), np.empty((k, 3, LANES))
    for first in range(0, len(length), LANES):
        count = min(LANES, len(length) - first)
        for axis in range(m):
            _set_quintics(low, high, length, first, count, axis, quintic)
            for p in range(k):
                _set_values(quintic, length, first, count, inside[p], values[p])
            for i in range(count):
                for order in range(3):
                    for p in range(k):
                        out[first + i, order, axis, p] = values[p, order, i]


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
def deviation_from_quintic(
    s: Floats, low: Floats, high: Floats, middle: Floats, length: Floats, z: Floats, velocity: Floats,
    acceleration: Floats, jerk: Floats,
) -> Floats:  # fmt: skip
    """(N,) largest share of a limit, at (ds/dt)^2 = z (N,), by which the path is unlike that quintic in each cell.

    From its derivatives in the middle, and from what its positions gain. Parameters: s (N,) where cells begin; low,
    middle and high (4, N, m) position and derivatives; length (N,) of the cells.
    """
    out = np.zeros(len(length))
    values = np.empty((len(length), 3, low.shape[2], 1))
    path_between(low, high, length, np.array([0.5]), values)
    errors = increment_errors(low, high, s, length, np.sqrt(z), np.zeros((3, low.shape[2])))
    for i in range(len(length)):
        h, v = length[i], np.sqrt(z[i])
        for axis in range(low.shape[2]):
            by = abs(middle[1, i, axis] - values[i, 0, axis, 0]) * v / velocity[axis]
            by = max(by, abs(middle[2, i, axis] - values[i, 1, axis, 0]) * v**2 / acceleration[axis])
            by = max(by, abs(middle[3, i, axis] - values[i, 2, axis, 0]) * v**3 / jerk[axis])
            gain = errors[i, 0, axis] * v / h
            by = max(by, gain / velocity[axis], gain * v / h / acceleration[axis], gain * (v / h) ** 2 / jerk[axis])
            out[i] = max(out[i], by)
    return out


@jit()
def increment_errors(low: Floats, high: Floats, s: Floats, h: Floats, speed: Floats, least: Floats) -> Floats:
    """(n, 3, m) by how much position, slope and curvature change between two places beyond what both ends explain.

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
def error_utilisation(
    errors: Floats, h: Floats, speed: Floats, velocity: Floats, acceleration: Floats, jerk: Floats
) -> Floats:
    """(n,) largest share of a limit that the errors (n, 3, m) take, spread over the gaps h (n,), at ds/dt = speed."""
    n, _, m = errors.shape
    out = np.zeros(n)
    for i in range(n):
        if h[i] <= 0.0:
            continue
        v = speed[i]
        for j in range(m):
            out[i] = max(out[i], errors[i, 0, j] / h[i] * v / velocity[j])
            out[i] = max(out[i], errors[i, 1, j] / h[i] * v * v / acceleration[j])
            out[i] = max(out[i], errors[i, 2, j] / h[i] * v * v * v / jerk[j])
    return out


@jit()
def outliers(errors: Floats, h: Floats) -> Bools:
    """(n,) gaps in a row with larger errors than their neighbours, for their length: there is something.

    errors (n, 3, m), h (n,).
    """
    n, _, m = errors.shape
    out = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        for k in range(3):
            for j in range(m):
                if errors[i, k, j] == 0.0 or out[i]:
                    continue
                expected = 0.0
                for other in (i - 2, i - 1, i + 1, i + 2):
                    if 0 <= other < n and h[other] > 0.0:
                        expected = max(expected, errors[other, k, j] * (h[i] / h[other]) ** POWERS[k])
                if errors[i, k, j] > ODD * expected:
                    out[i] = True
    return out


@jit()
def worse_half(whole: Floats, left: Floats, right: Floats) -> tuple[Bools, Bools]:
    """(n,) whether the error of gaps (n, 3, m) remains in one half of each, and whether in the right one."""
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

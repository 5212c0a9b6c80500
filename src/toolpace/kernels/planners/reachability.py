"""The highest z(s) = (ds/dt)^2 within speed and acceleration limits, by two passes over the cells.

Source: Pham and Pham, "A new approach to time-optimal path parameterization based on reachability analysis", IEEE
T-RO 2018 (TOPP-RA); the idea of following limits forth and back is Bobrow's (1985). z is linear in each cell, so
d2s/dt2 is constant there; a limit is a row at given places of the cell, with x and y for z at its ends:

    |q'' ((1 - f) x + f y) + q' (y - x) / (2 h)| <= 1        q'' and q' over the limit, f the place in the cell, 0 to 1

The backward pass keeps, node by node, the interval of z from which the end can be reached: the shadow on x of a polygon
in (x, y). The forward pass goes as fast as the intervals allow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

FEASIBLE, UNREACHABLE, TOO_FAST, TOO_SLOW = 0, 1, 2, 3
"""How it went: found; no state of a node reaches the end; the start is too fast, or too slow, for what follows."""
BEND = 1e-11
"""Share of a limit by which a vertex may lie outside a row."""
SAME = 1e-9
"""Relative difference between speeds that are the same."""


class Rows(NamedTuple):
    """The limits of a run on a mesh of n cells, at p places of each."""

    h: Floats
    """(n,) lengths of the cells."""
    at: Ints
    """(n, p) which point each place of a cell is."""
    place: Floats
    """(p,) from 0 to 1."""
    tight: Floats
    """(n, 2) factors by which speed and acceleration limits of a cell are lowered."""
    q1: Floats
    """(points, m) q' over the acceleration limits."""
    q2: Floats
    """(points, m) q'' over the acceleration limits."""
    cap: Floats
    """(points,) most z by velocity limits and feed."""
    top: Floats
    """(n + 1,) most z at the nodes."""


@jit()
def backward(rows: Rows, z1: float) -> tuple[Floats, Floats, int]:
    """Least and most z (n + 1,) of the nodes from which the end is reached with z1, and the node with none, or -1."""
    n, top = len(rows.h), rows.top
    low, high = np.zeros(n + 1), np.zeros(n + 1)
    low[n] = high[n] = z1
    scratch = np.empty((2 * rows.at.shape[1] * (rows.q1.shape[1] + 1) + 4, 3))
    for k in range(n - 1, -1, -1):
        # with a single y to lead to, its extreme is that of all
        free = low[k + 1] < high[k + 1]
        found, high[k] = edge(rows, k, 1.0, high[k + 1], free)
        if not found:
            count = polygon(rows, k, low[k + 1], high[k + 1], scratch)
            found, high[k] = extreme(scratch, count, 1.0, scale(high[k + 1], top[k]))
        # standing still is allowed in every cell, since limits are symmetric
        if found and low[k + 1] > 0.0:
            found, low[k] = edge(rows, k, -1.0, low[k + 1], free)
            if not found:
                count = polygon(rows, k, low[k + 1], high[k + 1], scratch)
                found, low[k] = extreme(scratch, count, -1.0, scale(high[k + 1], top[k]))
        if not found:
            return low, high, k
    return low, high, -1


@jit()
def forward(rows: Rows, low: Floats, high: Floats, z0: float) -> Floats:
    """(n + 1,) z: from z0 as fast as the intervals and the rows allow."""
    h, at, place, tight, q1, q2, cap, _ = rows
    n, m = len(h), q1.shape[1]
    z = np.empty(n + 1)
    z[0] = z0
    for k in range(n):
        x, y = z[k], high[k + 1]
        half = 0.5 / h[k]
        most = 1.0 / tight[k, 1]
        for i in range(at.shape[1]):
            f, point = place[i], at[k, i]
            if 0.0 < f < 1.0:
                y = min(y, (cap[point] / tight[k, 0] ** 2 - (1.0 - f) * x) / f)
            for j in range(m):
                c = q1[point, j] * half
                a, b = q2[point, j] * (1.0 - f) - c, q2[point, j] * f + c
                if b > 0.0:
                    y = min(y, (most - a * x) / b)
                elif b < 0.0:
                    y = min(y, (most + a * x) / -b)
        z[k + 1] = max(y, low[k + 1], 0.0)
    return z


@jit()
def solve(rows: Rows, z0: float, z1: float) -> tuple[Floats, int, int]:
    """z (n + 1,) from z0 to z1, how it went, and at which node it failed."""
    low, high, stuck = backward(rows, z1)
    if stuck >= 0:
        return high, UNREACHABLE, stuck
    if z0 > high[0] * (1.0 + SAME):
        return high, TOO_FAST, 0
    if z0 < low[0] * (1.0 - SAME):
        return low, TOO_SLOW, 0
    z = forward(rows, low, high, z0)
    z[len(rows.h)] = z1
    return z, FEASIBLE, -1


@jit()
def scale(high: float, top: float) -> float:
    """The unit of z in a polygon."""
    return float(high if high > 0.0 else top)


@jit()
def edge(rows: Rows, k: int, sign: float, y: float, free: bool) -> tuple[bool, float]:
    """The most (sign 1) or least (-1) x of a cell whose other end has the most or least y: is it an extreme of all y?

    It is if the row that holds it would let x follow y, and x lies within the other rows: so it is almost always.
    """
    h, at, place, tight, q1, q2, cap, top = rows
    upper, lower, upper_slope, lower_slope = top[k], 0.0, 0.0, 0.0
    half = 0.5 / h[k]
    most = 1.0 / tight[k, 1]
    for i in range(at.shape[1]):
        f, point = place[i], at[k, i]
        if 0.0 < f < 1.0:
            x = (cap[point] / tight[k, 0] ** 2 - f * y) / (1.0 - f)
            if x < upper:
                upper, upper_slope = x, -1.0
        for j in range(q1.shape[1]):
            c = q1[point, j] * half
            a, b = q2[point, j] * (1.0 - f) - c, q2[point, j] * f + c
            if a < 0.0:
                a, b = -a, -b
            if a > 0.0:
                x = (most - b * y) / a
                if x < upper:
                    upper, upper_slope = x, -b
                x = (-most - b * y) / a
                if x > lower:
                    lower, lower_slope = x, -b
            elif abs(b * y) > most:
                return False, 0.0
    if sign > 0.0:
        return upper >= lower and (upper_slope >= 0.0 or not free), upper
    return upper >= lower and (lower_slope >= 0.0 or not free), lower


@jit()
def polygon(rows: Rows, k: int, low: float, high: float, out: Floats) -> int:
    """The rows (a, b, c): a x + b w <= c of a cell, in x and w = y - x, both over their scale; the box comes first.

    In (x, y) all rows of a fine mesh would be nearly parallel.
    """
    h, at, place, tight, q1, q2, cap, top = rows
    unit = scale(high, top[k])
    out[0, 0], out[0, 1], out[0, 2] = 1.0, 0.0, top[k] / unit
    out[1, 0], out[1, 1], out[1, 2] = -1.0, 0.0, 0.0
    out[2, 0], out[2, 1], out[2, 2] = 1.0, 1.0, high / unit
    out[3, 0], out[3, 1], out[3, 2] = -1.0, -1.0, -low / unit
    count = 4
    half = 0.5 / h[k]
    for i in range(at.shape[1]):
        f, point = place[i], at[k, i]
        if 0.0 < f < 1.0:
            out[count, 0], out[count, 1], out[count, 2] = 1.0, f, cap[point] / tight[k, 0] ** 2 / unit
            count += 1
        for j in range(q1.shape[1]):
            a = q2[point, j] * tight[k, 1] * unit
            b = (q2[point, j] * f + q1[point, j] * half) * tight[k, 1] * unit
            out[count, 0], out[count, 1], out[count, 2] = a, b, 1.0
            out[count + 1, 0], out[count + 1, 1], out[count + 1, 2] = -a, -b, 1.0
            count += 2
    return count


@jit()
def extreme(rows: Floats, count: int, sign: float, unit: float) -> tuple[bool, float]:
    """The most (sign 1) or least (-1) x within the rows, row by row (Seidel 1991); the first four are a box."""
    x = rows[0, 2] if sign > 0.0 else 0.0
    w = (rows[2, 2] if sign > 0.0 else -rows[3, 2]) - x
    for i in range(4, count):
        a, b, c = rows[i, 0], rows[i, 1], rows[i, 2]
        if a * x + b * w <= c + BEND:
            continue
        # the extreme of the rows so far lies on this one: at a distance t along it from its nearest point to 0
        size = np.sqrt(a * a + b * b)
        along, across = -b / size, a / size
        x0, w0 = c * a / size**2, c * b / size**2
        first, last = -np.inf, np.inf
        for j in range(i):
            slope = rows[j, 0] * along + rows[j, 1] * across
            room = rows[j, 2] - rows[j, 0] * x0 - rows[j, 1] * w0
            if abs(slope) <= 1e-14 * (abs(rows[j, 0]) + abs(rows[j, 1])):
                if room < -1e-9:
                    return False, 0.0
            elif slope > 0.0:
                last = min(last, room / slope)
            else:
                first = max(first, room / slope)
        if first > last + 1e-10 * (1.0 + abs(last)):
            return False, 0.0
        t = last if sign * along > 0.0 else first
        x, w = x0 + t * along, w0 + t * across
    return True, max(x, 0.0) * unit

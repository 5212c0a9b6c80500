"""The time within a cell of a spline of the squared speed: the integral of ds / sqrt(z), exact to rounding.

Gauss' rule with n points errs, on an interval around which 1/sqrt(z) is analytic within an ellipse, by its bound there
times rho^(-2n), rho being the sum of the ellipse's half axes in half lengths (Trefethen, Approximation Theory and
Approximation Practice, theorem 19.3). A cubic cannot vanish within REACH half lengths of the middle where its higher
terms sum up to less than SHARE of its value there. With eight points the rule then errs by less than 1e-13. A cell
that is not like this is cut into panels that are: next to a fall of z to 1e-12 of itself some eighty.
Any part of a panel is like this too, so s at a time within it is found by the same rule.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

REACH, SHARE = 4.0, 0.9
FLOOR = 1e-13
"""Least z inside a cell, as a share of that at its slower node: what a coarse mesh lets fall to nothing goes on."""
LEAST = 1e-12
"""Shortest panel, as a share of its cell: met only where z falls to nothing."""
GAUSS_X = (np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0
GAUSS_W = np.polynomial.legendre.leggauss(8)[1] / 2.0


class Panels(NamedTuple):
    """Parts of cells on which Gauss' rule is exact, in order."""

    cell: Ints
    """(p,) the cell of each."""
    start: Floats
    """(p,) where it begins in that cell."""
    width: Floats
    """(p,)"""
    time: Floats
    """(p + 1,) when each begins, and when the last ends."""


@jit()
def value(cell: Floats, x: float) -> float:
    """The cubic of a cell at a distance x into it."""
    z: float = cell[0] + x * (cell[1] + x * (cell[2] + x * cell[3]))
    return z


@jit()
def floor_of(cell: Floats, h: float) -> float:
    """Least z in a cell of length h."""
    least: float = FLOOR * min(cell[0], max(value(cell, h), FLOOR * cell[0]))
    return least


@jit()
def exact(cell: Floats, floor: float, x: float, width: float) -> bool:
    """Whether the rule is exact from x to x + width."""
    r = 0.5 * width
    m = x + r
    z = value(cell, m)
    slope = abs(cell[1] + m * (2.0 * cell[2] + m * 3.0 * cell[3])) * r
    curve, third = abs(cell[2] + 3.0 * m * cell[3]) * r * r, abs(cell[3]) * r * r * r
    if z > floor:
        high: bool = REACH * (slope + REACH * (curve + REACH * third)) <= SHARE * z
        return high
    low: bool = slope + curve + third <= floor - z
    return low


@jit()
def time_over(cell: Floats, floor: float, x: float, width: float) -> float:
    """Time from x to x + width, a part of a panel."""
    total = 0.0
    for i in range(len(GAUSS_X)):
        total += GAUSS_W[i] / np.sqrt(max(value(cell, x + width * GAUSS_X[i]), floor))
    return total * width


@jit()
def panels_of(nodes: Floats, cells: Floats, begin: float) -> Panels:
    """The panels of all cells (n - 1, 4), the first of which begins at a time `begin`."""
    n = len(nodes)
    count = n - 1
    cell, start, width = np.empty(count, dtype=np.int64), np.empty(count), np.empty(count)
    time = np.empty(count + 1)
    time[0] = begin
    p = 0
    for k in range(n - 1):
        h = nodes[k + 1] - nodes[k]
        floor = floor_of(cells[k], h)
        x, w = 0.0, h
        while True:
            while w > LEAST * h and not exact(cells[k], floor, x, w):
                w *= 0.5
            if p == len(cell):
                cell, start, width, time = longer(cell, start, width, time)
            cell[p], start[p], width[p] = k, x, w
            time[p + 1] = time[p] + time_over(cells[k], floor, x, w)
            p += 1
            x += w
            if x >= h:
                break
            w = min(2.0 * w, h - x)
    return Panels(cell[:p].copy(), start[:p].copy(), width[:p].copy(), time[: p + 1].copy())


@jit()
def longer(cell: Ints, start: Floats, width: Floats, time: Floats) -> tuple[Ints, Floats, Floats, Floats]:
    """The same arrays with room for half as many panels more."""
    p = len(cell)
    room = p + p // 2 + 64
    cells, starts, widths, times = np.empty(room, dtype=np.int64), np.empty(room), np.empty(room), np.empty(room + 1)
    for i in range(p):
        cells[i], starts[i], widths[i], times[i] = cell[i], start[i], width[i], time[i]
    times[p] = time[p]
    return cells, starts, widths, times


@jit()
def way_after(cell: Floats, floor: float, start: float, width: float, wanted: float) -> float:
    """How far into its cell the motion has come a time `wanted` after the begin of a panel: Newton's method.

    It starts from Taylor's polynomial in time. The error of a step goes like its square, so one that is short of 1e-8
    of the panel is the last.
    """
    z = max(value(cell, start), floor)
    v = np.sqrt(z)
    slope = cell[1] + start * (2.0 * cell[2] + start * 3.0 * cell[3])
    curve = 2.0 * cell[2] + 6.0 * start * cell[3]
    w = wanted * v
    x = min(max(w * (1.0 + w / z * (slope / 4.0 + w * curve / 12.0)), 0.0), width)
    for _ in range(30):
        step = (time_over(cell, floor, start, x) - wanted) * np.sqrt(max(value(cell, start + x), floor))
        x = min(max(x - step, 0.0), width)
        if abs(step) <= 1e-8 * width:
            break
    found: float = start + x
    return found

"""Time along a spline of the squared speed z(s) = (ds/dt)^2: nodes' times, states over time, dense states.

A rest cell of length h has a constant third derivative J of s: s = J t^3 / 6, so it takes 3 h / v with v the speed at
its inner end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.cubic_spline import at_knots, basis_at_knots

FLOOR = 1e-6
STEEP = 30.0
INEXACT = 1e-4
"""Error of the time of a cell that is let pass; looked for where z at its nodes differs by a factor of STEEP."""
GAUSS_X = (np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0
GAUSS_W = np.polynomial.legendre.leggauss(8)[1] / 2.0
REST_INSIDE = np.linspace(0.0, 1.0, 65)


class Law(NamedTuple):
    """A spline of z over n nodes, and when it passes them."""

    nodes: Floats
    """(n,)"""
    cells: Floats
    """(n - 1, 4) z in each cell as powers of s - nodes[k]."""
    times: Floats
    """(n,) when the nodes are passed."""
    rest0: float
    """Length of the rest cell before the first node; 0 where the law starts in motion."""
    rest1: float
    """Length of the rest cell behind the last node."""
    duration: float


@jit()
def polynomials(nodes: Floats, c: Floats) -> Floats:
    """z in each cell as (n - 1, 4) coefficients of powers of s - nodes[k]."""
    u = at_knots(basis_at_knots(nodes), c)
    n = len(nodes)
    cells = np.empty((n - 1, 4))
    for k in range(n - 1):
        h = nodes[k + 1] - nodes[k]
        cells[k, 0] = u[k, 0]
        cells[k, 1] = u[k, 1]
        cells[k, 2] = u[k, 2] / 2.0
        cells[k, 3] = (u[k + 1, 2] - u[k, 2]) / (6.0 * h)
    return cells


@jit()
def _z(cell: Floats, x: float) -> float:
    """z at a distance x into the cell; held above a trifle, where a coarse mesh lets it dip below zero."""
    z: float = max(cell[0] + x * (cell[1] + x * (cell[2] + x * cell[3])), FLOOR * cell[0])
    return z


@jit()
def _time(cell: Floats, x: float) -> float:
    """Time from the left node to a distance x into the cell."""
    total = 0.0
    for i in range(len(GAUSS_X)):
        total += GAUSS_W[i] / np.sqrt(_z(cell, x * GAUSS_X[i]))
    return total * x


@jit()
def _time_after(cell: Floats, x: float, h: float) -> float:
    """Time from a distance x to a distance h into the cell."""
    total = 0.0
    for i in range(len(GAUSS_X)):
        total += GAUSS_W[i] / np.sqrt(_z(cell, x + (h - x) * GAUSS_X[i]))
    return total * (h - x)


@jit()
def dips(nodes: Floats, cells: Floats, inside: Floats) -> Bools:
    """(n - 1,) whether a cell is too long: z falls, inside, below half of what it is at either node, or changes by so
    much that the rule which integrates time is not exact."""
    n = len(nodes)
    out = np.zeros(n - 1, dtype=np.bool_)
    for k in range(n - 1):
        h = nodes[k + 1] - nodes[k]
        low = min(cells[k, 0], _z(cells[k], h))
        for f in inside:
            if _z(cells[k], f * h) < 0.5 * low:
                out[k] = True
        if max(cells[k, 0], _z(cells[k], h)) > STEEP * low:
            whole = _time(cells[k], h)
            out[k] |= abs(_time(cells[k], h / 2.0) + _time_after(cells[k], h / 2.0, h) - whole) > INEXACT * whole
    return out


@jit()
def end_speed(nodes: Floats, cells: Floats) -> float:
    """ds/dt at the last node."""
    n = len(nodes)
    speed: float = np.sqrt(_z(cells[n - 2], nodes[n - 1] - nodes[n - 2]))
    return speed


@jit()
def node_times(nodes: Floats, cells: Floats, rest0: float) -> Floats:
    """When each node is passed, counted from the start of the rest cell before the first node, if there is one."""
    n = len(nodes)
    times = np.empty(n)
    times[0] = 3.0 * rest0 / np.sqrt(cells[0, 0]) if rest0 > 0.0 else 0.0
    for k in range(n - 1):
        times[k + 1] = times[k] + _time(cells[k], nodes[k + 1] - nodes[k])
    return times


@jit()
def _rest(start: float, h: float, v: float, t: float, forth: float, out: Floats, i: int) -> None:
    """State t seconds after (forth) or before the moment of rest at `start`, in a cell of length h left at speed v."""
    third = 2.0 * v**3 / (9.0 * h * h)
    out[0, i] = start + forth * third * t**3 / 6.0
    out[1, i] = third * t * t / 2.0
    out[2, i] = forth * third * t
    out[3, i] = third


@jit()
def inside_cell(cell: Floats, x: float) -> tuple[float, float, float]:
    """ds/dt, d2s/dt2 and d3s/dt3 at a distance x into a cell."""
    v = np.sqrt(_z(cell, x))
    slope = cell[1] + x * (2.0 * cell[2] + x * 3.0 * cell[3])
    curve = 2.0 * cell[2] + 6.0 * x * cell[3]
    return v, slope / 2.0, curve * v / 2.0


@jit()
def _inside(node: float, cell: Floats, x: float, out: Floats, i: int) -> None:
    """State at a distance x into a cell."""
    out[0, i] = node + x
    out[1, i], out[2, i], out[3, i] = inside_cell(cell, x)


@jit()
def states(t: Floats, law: Law) -> Floats:
    """(4, len(t)): s, ds/dt, d2s/dt2, d3s/dt3 at sorted times."""
    nodes, cells, times, rest0, rest1, duration = law
    n = len(nodes)
    out = np.empty((4, len(t)))
    k = 0
    for i in range(len(t)):
        now = min(max(t[i], 0.0), duration)
        if now < times[0]:
            _rest(nodes[0] - rest0, rest0, np.sqrt(cells[0, 0]), now, 1.0, out, i)
            continue
        if now > times[n - 1] and rest1 > 0.0:
            _rest(nodes[n - 1] + rest1, rest1, end_speed(nodes, cells), duration - now, -1.0, out, i)
            continue
        if k > 0 and now < times[k]:
            k = 0
        while k < n - 2 and times[k + 1] < now:
            k += 1
        cell, h = cells[k], nodes[k + 1] - nodes[k]
        wanted = now - times[k]
        x = h * wanted / (times[k + 1] - times[k])
        for _ in range(30):
            step = (_time(cell, x) - wanted) * np.sqrt(_z(cell, x))
            x = min(max(x - step, 0.0), h)
            if abs(step) <= 1e-15 * h:
                break
        _inside(nodes[k], cell, x, out, i)
    return out


@jit()
def within(nodes: Floats, cells: Floats, which: Ints, inside: Floats) -> tuple[Floats, Floats]:
    """States at `inside` (k,), shares of a cell, in the cells `which` (m,), their ends taken from inside.

    Returns the states (4, m k), and whether each belongs to the right side of a break.
    """
    k = len(inside)
    out = np.empty((4, len(which) * k))
    right = np.ones(len(which) * k)
    i = 0
    for cell in which:
        h = nodes[cell + 1] - nodes[cell]
        for f in inside:
            _inside(nodes[cell], cells[cell], f * h, out, i)
            i += 1
        out[0, i - 1] = nodes[cell + 1]
        right[i - 1] = 0.0
    return out, right


@jit()
def probe(law: Law, inside: Floats, first: int, beyond: int) -> tuple[Floats, Floats, Floats]:
    """States at `inside` (k,), shares of a cell, in the cells from `first` to before `beyond`, ends from inside.

    Rest cells belong to the outermost ones, with states at REST_INSIDE. Returns the states (4, n), whether each
    belongs to the right side of a break, and the time each stands for.
    """
    nodes, cells, times, rest0, rest1, duration = law
    n = len(nodes)
    inner, outer = len(inside), len(REST_INSIDE)
    rest0 = rest0 if first == 0 else 0.0
    rest1 = rest1 if beyond == n - 1 else 0.0
    count = (beyond - first) * inner + (outer if rest0 > 0.0 else 0) + (outer if rest1 > 0.0 else 0)
    out = np.empty((4, count))
    right = np.ones(count)
    share = np.empty(count)
    i = 0
    if rest0 > 0.0:
        for f in REST_INSIDE:
            _rest(nodes[0] - rest0, rest0, np.sqrt(cells[0, 0]), f * times[0], 1.0, out, i)
            share[i] = times[0] / outer
            i += 1
        right[i - 1] = 0.0
    for k in range(first, beyond):
        h = nodes[k + 1] - nodes[k]
        for f in inside:
            _inside(nodes[k], cells[k], f * h, out, i)
            share[i] = (times[k + 1] - times[k]) / inner
            i += 1
        out[0, i - 1] = nodes[k + 1]
        right[i - 1] = 0.0
    if rest1 > 0.0:
        last = duration - times[n - 1]
        for f in REST_INSIDE:
            _rest(nodes[n - 1] + rest1, rest1, end_speed(nodes, cells), (1.0 - f) * last, -1.0, out, i)
            share[i] = last / outer
            i += 1
        right[i - 1] = 0.0
    return out, right, share

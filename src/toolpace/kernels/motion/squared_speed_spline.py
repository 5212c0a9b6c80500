"""Times and states along a spline of the squared speed z(s) = (ds/dt)^2.

A rest cell of length h has a constant third derivative J of s: s = J t^3 / 6, so it takes 3 h / v with v the speed at
its inner end.

The time within any other cell is the integral of ds / sqrt(z), exact to rounding. Gauss' rule with n points errs, on an
interval around which 1/sqrt(z) is analytic within an ellipse, by its bound there times rho^(-2n), rho being the sum of
the ellipse's half axes in half lengths (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3). A
cubic cannot vanish within REACH half lengths of the middle where its higher terms sum up to less than SHARE of its
value there. With eight points the rule then errs by less than 1e-13. A cell that is not like this is cut into panels
that are: next to a fall of z to 1e-12 of itself some eighty. Any part of a panel is like this too, so s at a time
within it is found by the same rule.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.cubic_spline import at_knots, basis_at_knots

STEEP, UNEVEN = 30.0, 1e-4
"""How far z at the nodes of a cell may differ, and its time by eight points be off beyond that, before it is cut."""
REST_INSIDE = np.linspace(0.0, 1.0, 65)
REACH, SHARE = 4.0, 0.9
"""See above: with eight points they keep the error of a panel below 1e-13."""
FLOOR = 1e-13
"""Least z inside a cell, as a share of that at its slower node: what a coarse mesh lets fall to nothing goes on."""
LEAST = 1e-12
"""Shortest panel, as a share of its cell: met only where z falls to nothing."""
GAUSS_X = (np.polynomial.legendre.leggauss(8)[0] + 1.0) / 2.0
GAUSS_W = np.polynomial.legendre.leggauss(8)[1] / 2.0


class Law(NamedTuple):
    """A spline of z over n nodes, and when it passes them."""

    nodes: Floats
    """(n,)"""
    cells: Floats
    """(n - 1, 4) z in each cell as powers of s - nodes[k]."""
    times: Floats
    """(n,) when the nodes are passed."""
    panels: Panels
    """Parts of the cells over which time is integrated."""
    rest0: float
    """Length of the rest cell before the first node; 0 where the law starts in motion."""
    rest1: float
    """Length of the rest cell behind the last node."""
    duration: float


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
def dips(nodes: Floats, cells: Floats, inside: Floats) -> Bools:
    """(n - 1,) whether a cell is too long: z falls, inside, below half of what it is at either node, or changes by so
    much that one cubic is a poor law: eight points of it do not even tell its time."""
    n = len(nodes)
    out = np.zeros(n - 1, dtype=np.bool_)
    for k in range(n - 1):
        h = nodes[k + 1] - nodes[k]
        low = min(cells[k, 0], value(cells[k], h))
        # z is no lower than the lowest of the points that control it
        first = cells[k, 0] + cells[k, 1] * h / 3.0
        second = 2.0 * first - cells[k, 0] + cells[k, 2] * h * h / 3.0
        if not min(first, second) >= 0.5 * low:
            for f in inside:
                if value(cells[k], f * h) < 0.5 * low:
                    out[k] = True
        if max(cells[k, 0], value(cells[k], h)) > STEEP * low:
            floor = floor_of(cells[k], h)
            whole = time_over(cells[k], floor, 0.0, h)
            halves = time_over(cells[k], floor, 0.0, h / 2.0) + time_over(cells[k], floor, h / 2.0, h / 2.0)
            out[k] |= abs(halves - whole) > UNEVEN * whole
    return out


@jit()
def end_speed(nodes: Floats, cells: Floats) -> float:
    """ds/dt at the last node."""
    n = len(nodes)
    last = cells[n - 2]
    speed: float = np.sqrt(max(value(last, nodes[n - 1] - nodes[n - 2]), FLOOR * last[0]))
    return speed


@jit()
def node_times(panels: Panels, nodes: Floats) -> Floats:
    """When each node is passed."""
    n = len(nodes)
    times = np.empty(n)
    for p in range(len(panels.cell)):
        if panels.start[p] == 0.0:
            times[panels.cell[p]] = panels.time[p]
    times[n - 1] = panels.time[-1]
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
def inside_cell(cell: Floats, floor: float, x: float) -> tuple[float, float, float]:
    """ds/dt, d2s/dt2 and d3s/dt3 at a distance x into a cell; where z has fallen to its floor, steady speed."""
    z = value(cell, x)
    if z <= floor:
        return np.sqrt(floor), 0.0, 0.0
    v = np.sqrt(z)
    slope = cell[1] + x * (2.0 * cell[2] + x * 3.0 * cell[3])
    curve = 2.0 * cell[2] + 6.0 * x * cell[3]
    return v, slope / 2.0, curve * v / 2.0


@jit()
def _inside(node: float, cell: Floats, floor: float, x: float, out: Floats, i: int) -> None:
    """State at a distance x into a cell."""
    out[0, i] = node + x
    out[1, i], out[2, i], out[3, i] = inside_cell(cell, floor, x)


@jit()
def states(t: Floats, law: Law) -> Floats:
    """(4, len(t)): s, ds/dt, d2s/dt2, d3s/dt3 at sorted times."""
    nodes, cells, times, panels, rest0, rest1, duration = law
    cell_of, start, width, time = panels
    n, last = len(nodes), len(panels.cell) - 1
    out = np.empty((4, len(t)))
    p, of, floor = -1, -1, 0.0
    for i in range(len(t)):
        now = min(max(t[i], 0.0), duration)
        if now < times[0]:
            _rest(nodes[0] - rest0, rest0, np.sqrt(cells[0, 0]), now, 1.0, out, i)
            continue
        if now > times[n - 1] and rest1 > 0.0:
            _rest(nodes[n - 1] + rest1, rest1, end_speed(nodes, cells), duration - now, -1.0, out, i)
            continue
        if p < 0 or now < time[p]:
            p = min(max(np.searchsorted(time, now) - 1, 0), last)
        while p < last and time[p + 1] < now:
            p += 1
        k = cell_of[p]
        if k != of:
            of, floor = k, floor_of(cells[k], nodes[k + 1] - nodes[k])
        x = way_after(cells[k], floor, start[p], width[p], now - time[p])
        _inside(nodes[k], cells[k], floor, x, out, i)
    return out


@jit()
def states_at(s: Floats, law: Law) -> Floats:
    """(4, len(s)): the states in which places in order are passed."""
    nodes, cells, _, _, rest0, rest1, _ = law
    n = len(nodes)
    out = np.empty((4, len(s)))
    last = end_speed(nodes, cells)
    for i in range(len(s)):
        x = s[i]
        if x < nodes[0] and rest0 > 0.0:
            v = np.sqrt(cells[0, 0])
            t = 3.0 * rest0 / v * np.cbrt(max(x - nodes[0] + rest0, 0.0) / rest0)
            _rest(nodes[0] - rest0, rest0, v, t, 1.0, out, i)
        elif x > nodes[n - 1] and rest1 > 0.0:
            t = 3.0 * rest1 / last * np.cbrt(max(nodes[n - 1] + rest1 - x, 0.0) / rest1)
            _rest(nodes[n - 1] + rest1, rest1, last, t, -1.0, out, i)
        else:
            k = min(max(np.searchsorted(nodes, x, side="right") - 1, 0), n - 2)
            _inside(nodes[k], cells[k], floor_of(cells[k], nodes[k + 1] - nodes[k]), x - nodes[k], out, i)
    return out


@jit()
def probe(law: Law, inside: Floats, first: int, beyond: int) -> tuple[Floats, Floats, Floats]:
    """States at `inside` (k,), shares of a cell, in the cells from `first` to before `beyond`, ends from inside.

    Rest cells belong to the outermost ones, with states at REST_INSIDE. Returns the states (4, n), whether each
    belongs to the right side of a break, and the time each stands for.
    """
    nodes, cells, times, _, rest0, rest1, duration = law
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
        # rounded, it could lie on the other side of a break there
        out[0, i - 1], right[i - 1] = nodes[0], 0.0
    for k in range(first, beyond):
        h = nodes[k + 1] - nodes[k]
        floor = floor_of(cells[k], h)
        for f in inside:
            _inside(nodes[k], cells[k], floor, f * h, out, i)
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
        out[0, i - outer], right[i - 1] = nodes[n - 1], 0.0
    return out, right, share


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

"""Times and states along a spline of the squared speed z(s) = (ds/dt)^2.

A rest cell of length h has a constant third derivative J of s: s = J t^3 / 6, so it takes 3 h / v with v the speed at
its inner end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.cell_time import FLOOR, Panels, floor_of, time_over, value, way_after
from toolpace.kernels.motion.cubic_spline import at_knots, basis_at_knots

STEEP, UNEVEN = 30.0, 1e-4
"""How far z at the nodes of a cell may differ, and its time by eight points be off beyond that, before it is cut."""
REST_INSIDE = np.linspace(0.0, 1.0, 65)


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

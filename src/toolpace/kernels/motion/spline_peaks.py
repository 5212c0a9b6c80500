"""Peaks of values over limits in the cells of a spline of z, the path being known at probes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.cell_time import floor_of
from toolpace.kernels.motion.usage import HIGH, summit

SPEED, ACCELERATION, JERK = 0, 1, 2
"""Kinds of limits; the feed is one of speed."""
LOOKS, FIVE = 12, 5
"""Places about such a peak at which it is looked for again, and probes that tell the path there: beside a narrow bend
the terms of jerk are hundreds of limits each, and all but one of them are taken away by the others."""
STRAIGHT = 1e-3
"""How far the inverse of a cap may be from a straight line over three probes, as a share of it, for a parabola to tell
it between them: a cap that jumps there is known at probes only."""
V, A, J = range(3)
"""ds/dt, d2s/dt2 and d3s/dt3."""


class Closer(NamedTuple):
    """Where closer looks are taken about each of the k probes of a cell, as shares of it, and room for them."""

    inside: Floats
    """(k,) the probes."""
    near: Floats
    """(k, LOOKS) the places: between both neighbours of a probe, or between an outermost one and its neighbour."""
    weight: Floats
    """(k, FIVE, LOOKS) of the path at the five probes around, at these places: Lagrange's."""
    state: Floats
    """(3, LOOKS) ds/dt, d2s/dt2 and d3s/dt3 at the places about one probe."""
    path: Floats
    """(3, 1, LOOKS) derivatives of the path there."""
    found: Floats
    """(1, LOOKS) values over limits there."""
    most: Floats
    """(LOOKS,) the same."""


@jit()
def spline_peaks(
    which: Ints, q: Floats, cap: Floats, nodes: Floats, cells: Floats, inside: Floats, velocity: Floats,
    acceleration: Floats, jerk: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """(n, 3) largest usage of speed, acceleration and jerk in some cells of a spline of z, and where, as a share of it.

    Parameters: which (n,) cells; q (n, 3, m, k) q', q'', q''' and cap (n, k) on ds/dt at the shares `inside` (k,) of
    each of them; nodes (N,) and cells (N - 1, 4) of the spline. A peak between probes is told by the parabola through
    three of them, and looked for where it is near a limit.
    """
    n, k, m = len(which), len(inside), q.shape[2]
    limits = np.stack((velocity, acceleration, jerk))
    peak, place = np.zeros((n, 3)), np.full((n, 3), 0.5)
    state, value, most = np.empty((3, k)), np.empty((m, k)), np.empty(k)
    closer = _closer_looks(inside)
    for i in range(n):
        length = nodes[which[i] + 1] - nodes[which[i]]
        z, floor = cells[which[i]], floor_of(cells[which[i]], length)
        _states(z, floor, length, inside, state)
        for p in range(k):
            most[p] = state[V, p] / cap[i, p]
        if _highest(most, inside, SPEED, peak[i], place[i]):
            _closer_to_cap(most, z, floor, length, closer, cap[i], peak[i], place[i])
        for kind in range(3):
            _values(q[i], state, limits[kind], kind, value, most)
            if _all_low(most, inside, kind, peak[i], place[i]):
                continue
            for axis in range(m):
                if _highest(value[axis], inside, kind, peak[i], place[i]):
                    _closer(
                        value[axis], z, floor, length, closer, q[i], axis, limits[kind, axis : axis + 1], kind,
                        peak[i], place[i],
                    )  # fmt: skip
    return peak, place


@jit(reorder=True)
def _states(cell: Floats, floor: float, length: float, inside: Floats, out: Floats) -> None:
    """Set ds/dt, d2s/dt2 and d3s/dt3 at shares of a cell; where z has fallen to its floor, steady speed."""
    for p in range(len(inside)):
        x = inside[p] * length
        z = cell[0] + x * (cell[1] + x * (cell[2] + x * cell[3]))
        v, moves = np.sqrt(max(z, floor)), 1.0 if z > floor else 0.0
        out[V, p] = v
        out[A, p] = moves * (0.5 * cell[1] + x * (cell[2] + x * 1.5 * cell[3]))
        out[J, p] = moves * (cell[2] + 3.0 * x * cell[3]) * v


@jit(reorder=True)
def _values(q: Floats, state: Floats, limit: Floats, kind: int, out: Floats, most: Floats) -> None:
    """Set values over limits of a kind at probes (m, k), and the most of all axes (k,); nan where any is nan."""
    most[:] = 0.0
    for axis in range(q.shape[1]):
        share = 1.0 / limit[axis]
        if kind == SPEED:
            for p in range(len(most)):
                out[axis, p] = abs(q[0, axis, p] * state[V, p]) * share
        elif kind == ACCELERATION:
            for p in range(len(most)):
                v, a = state[V, p], state[A, p]
                out[axis, p] = abs(q[1, axis, p] * v * v + q[0, axis, p] * a) * share
        else:
            for p in range(len(most)):
                v, a, j = state[V, p], state[A, p], state[J, p]
                third = q[2, axis, p] * v * v * v + 3.0 * q[1, axis, p] * v * a
                out[axis, p] = abs(third + q[0, axis, p] * j) * share
        for p in range(len(most)):
            most[p] = most[p] if out[axis, p] <= most[p] else out[axis, p]


@jit(inline=True)
def _all_low(most: Floats, inside: Floats, kind: int, peak: Floats, place: Floats) -> bool:
    """Whether no value (k,) is so high that it matters how high it goes between probes; then the peak is raised."""
    top, at = 0.0, 0
    for p in range(len(most)):
        if not most[p] <= top:
            top, at = most[p], p
            if not top <= HIGH:
                return False
    if top > peak[kind]:
        peak[kind], place[kind] = top, inside[at]
    return True


@jit()
def _highest(value: Floats, inside: Floats, kind: int, peak: Floats, place: Floats) -> bool:
    """Raise the peak (3,) of a kind, and set its place (3,), where the values (k,) at shares `inside` go higher.

    Returns whether any is so high that a top between them may be near the limit.
    """
    k, most = len(value), 0.0
    for p in range(k):
        most = most if value[p] <= most else value[p]
    if most <= HIGH and not most > peak[kind]:
        return False
    for p in range(k):
        top, at = value[p], inside[p]
        if 0 < p < k - 1 and top > HIGH and top >= value[p - 1] and top >= value[p + 1]:
            top, at = summit(inside[p - 1], at, inside[p + 1], value[p - 1], top, value[p + 1])
        if top > peak[kind] or np.isnan(top):
            peak[kind], place[kind] = top, at
    return most > HIGH


@jit()
def _closer_looks(inside: Floats) -> Closer:
    """Where closer looks are taken about the probes, and what tells the path there."""
    k = len(inside)
    near, weight = np.empty((k, LOOKS)), np.empty((k, FIVE, LOOKS))
    for p in range(k):
        begin, end = inside[max(p - 1, 0)], inside[min(p + 1, k - 1)]
        first = min(max(p - 2, 0), k - FIVE)
        around = inside[first : first + FIVE]
        for i in range(LOOKS):
            near[p, i] = begin + (end - begin) * (i + 1) / (LOOKS + 1)
        for one in range(FIVE):
            weight[p, one] = 1.0
            for other in range(FIVE):
                if other != one:
                    weight[p, one] *= (near[p] - around[other]) / (around[one] - around[other])
    room = np.empty((3, LOOKS)), np.empty((3, 1, LOOKS)), np.empty((1, LOOKS)), np.empty(LOOKS)
    return Closer(inside, near, weight, *room)


@jit(inline=True)
def _is_top(inside: Floats, value: Floats, p: int) -> bool:
    """Whether high values go higher about probe p.

    Beside a node, where a limit is held, the highest may lie between the outermost two probes.
    """
    last = len(inside) - 1
    if not value[p] > HIGH:
        return False
    if p == 0:
        _, at = summit(inside[0], inside[1], inside[2], value[0], value[1], value[2])
        return bool(value[1] <= value[0] and inside[0] < at < inside[1])
    if p == last:
        _, at = summit(inside[p - 2], inside[p - 1], inside[p], value[p - 2], value[p - 1], value[p])
        return bool(value[p - 1] <= value[p] and inside[p - 1] < at < inside[p])
    return bool(value[p] >= value[p - 1] and value[p] >= value[p + 1])


@jit(inline=True)
def _closer(
    value: Floats, cell: Floats, floor: float, length: float, closer: Closer, q: Floats, axis: int, limit: Floats,
    kind: int, peak: Floats, place: Floats,
) -> None:  # fmt: skip
    """Raise the peak (3,) of a kind of one axis at places about each top of its values (k,) that is near the limit.

    Parameters: cell (4,) polynomial of z, never below `floor`; q (3, m, k) derivatives of the path at the probes; limit
    (1,) of this axis. The path is interpolated between its probes, z is not: it is z that changes quickly.
    """
    inside, near, weight, state, path, found, most = closer
    for p in range(len(value)):
        if not _is_top(inside, value, p):
            continue
        _states(cell, floor, length, near[p], state)
        _path_near(q, axis, weight[p], min(max(p - 2, 0), len(value) - FIVE), kind, path)
        _values(path, state, limit, kind, found, most)
        i = int(np.argmax(most))
        top, at = most[i], near[p, i]
        if 0 < i < LOOKS - 1:
            top, at = summit(near[p, i - 1], at, near[p, i + 1], most[i - 1], top, most[i + 1])
        if top > peak[kind]:
            peak[kind], place[kind] = top, at


@jit(reorder=True)
def _path_near(q: Floats, axis: int, weight: Floats, first: int, highest: int, out: Floats) -> None:
    """Set the derivatives of one axis (3, 1, LOOKS), up to the `highest`, from those at five probes from `first` on."""
    out[:] = 0.0
    for order in range(highest + 1):
        for one in range(FIVE):
            known = q[order, axis, first + one]
            for i in range(LOOKS):
                out[order, 0, i] += weight[one, i] * known


@jit()
def _closer_to_cap(
    value: Floats, cell: Floats, floor: float, length: float, closer: Closer, cap: Floats, peak: Floats, place: Floats
) -> None:  # fmt: skip
    """Raise the peak (3,) of speed at places about each top of its values (k,) that is near the cap (k,)."""
    inside, near = closer.inside, closer.near
    for p in range(len(inside)):
        if not _is_top(inside, value, p):
            continue
        o = min(max(p, 1), len(inside) - 2)
        x0, x1, x2 = inside[o - 1], inside[o], inside[o + 1]
        slow0, slow1, slow2 = 1.0 / cap[o - 1], 1.0 / cap[o], 1.0 / cap[o + 1]
        rise = (slow2 - slow0) / (x2 - x0)
        off = slow1 - slow0 - rise * (x1 - x0)
        if not abs(off) <= STRAIGHT * slow1:
            continue
        _states(cell, floor, length, near[p], closer.state)
        for i in range(LOOKS):
            x = near[p, i]
            slow = slow0 + rise * (x - x0) + off * (x - x0) * (x2 - x) / ((x1 - x0) * (x2 - x1))
            found = closer.state[V, i] * slow
            if found > peak[SPEED]:
                peak[SPEED], place[SPEED] = found, x

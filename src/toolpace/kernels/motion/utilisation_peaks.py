"""Peaks of limit utilisation in the cells of a spline of z, with the path known at probes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.squared_speed_spline import floor_of
from toolpace.kernels.motion.usage import HIGH, summit

SPEED, ACCELERATION, JERK = 0, 1, 2
"""Kinds of limits; the feed is one of speed."""
LOOKS, FIVE = 12, 5
"""Places about such a peak at which it is looked for again, and probes that tell the path there: beside a narrow bend
the terms of jerk are hundreds of limits each, and all but one of them are taken away by the others."""
STRAIGHT = 1e-3
"""How far the inverse of a cap may be from a straight line over three probes, as a share of it, for a parabola to tell
it between them: a cap that jumps there is known at probes only."""
NO_HIGHER = 1e-6
"""By how much a top may rise above the highest between probes without a closer look."""
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
    found: Floats
    """(LOOKS,) values over limits there."""
    tops: Ints
    """(k,) probes about which a closer look is taken."""


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
    high = np.empty(m, dtype=np.bool_)
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
            if not _values(q[i], state, limits[kind], kind, value, most, high):
                _raise_low(most, inside, kind, peak[i], place[i])
                continue
            # beside a high axis one that is low throughout does not count
            for axis in range(m):
                if high[axis]:
                    _highest(value[axis], inside, kind, peak[i], place[i])
                    _closer(
                        value[axis], z, floor, length, closer, q[i], axis, limits[kind, axis], kind, peak[i], place[i]
                    )
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
def _values(q: Floats, state: Floats, limit: Floats, kind: int, out: Floats, most: Floats, high: Bools) -> bool:
    """Set values over limits of a kind at probes (m, k), the most of all axes (k,), nan where any is nan, and the axes
    (m,) with a value so high that it matters how high it goes between probes. Returns whether any has one."""
    most[:] = 0.0
    any_high = False
    for axis in range(q.shape[1]):
        share, low = 1.0 / limit[axis], True
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
            low &= out[axis, p] <= HIGH
        high[axis] = not low
        any_high |= not low
    return any_high


@jit(inline=True)
def _raise_low(most: Floats, inside: Floats, kind: int, peak: Floats, place: Floats) -> None:
    """Raise the peak (3,) of a kind, and set its place (3,), by the most (k,) at probes, none of which is high."""
    top, at = peak[kind], -1
    for p in range(len(most)):
        if most[p] > top:
            top, at = most[p], p
    if at >= 0:
        peak[kind], place[kind] = top, inside[at]


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
    return Closer(inside, near, weight, np.empty((3, LOOKS)), np.empty(LOOKS), np.empty(k, dtype=np.int64))


@jit()
def _tops(inside: Floats, value: Floats, tops: Ints) -> int:
    """Set at which probes the values (k,) go higher between them, of those that are high; returns how many there are.

    Beside a node, where a limit is held, the highest may lie between the outermost two probes.
    """
    count, last = 0, len(inside) - 1
    if value[0] > HIGH and value[1] <= value[0]:
        _, at = summit(inside[0], inside[1], inside[2], value[0], value[1], value[2])
        if inside[0] < at < inside[1]:
            tops[count], count = 0, count + 1
    for p in range(1, last):
        if value[p] > HIGH and value[p] >= value[p - 1] and value[p] >= value[p + 1]:
            tops[count], count = p, count + 1
    if value[last] > HIGH and value[last - 1] <= value[last]:
        _, at = summit(inside[last - 2], inside[last - 1], inside[last], value[last - 2], value[last - 1], value[last])
        if inside[last - 1] < at < inside[last]:
            tops[count], count = last, count + 1
    return count


@jit()
def _bound(inside: Floats, value: Floats, p: int) -> float:
    """What no value about probe p is above, as the parabola through three probes and their third differences tell."""
    last = len(inside) - 1
    o = min(max(p, 1), last - 1)
    x0, x1, x2, y0, y1, y2 = inside[o - 1], inside[o], inside[o + 1], value[o - 1], value[o], value[o + 1]
    rise, next_rise = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    bend, third, widest = (next_rise - rise) / (x2 - x0), 0.0, max(x1 - x0, x2 - x1)
    if o > 1:
        before = inside[o - 2]
        third = abs(bend - (rise - (y0 - value[o - 2]) / (x0 - before)) / (x1 - before)) / (x2 - before)
    if o < last - 1:
        after = inside[o + 2]
        third = max(third, abs(((value[o + 2] - y2) / (after - x2) - next_rise) / (after - x1) - bend) / (after - x0))
    top = max(y0, y1, y2)
    slope = rise + bend * (x1 - x0)
    if bend < 0.0 and abs(slope) < -2.0 * bend * widest:
        top = max(top, y1 - slope * slope / (4.0 * bend))
    bound: float = top + third * widest * widest * widest
    return bound


@jit()
def _closer(
    value: Floats, cell: Floats, floor: float, length: float, closer: Closer, q: Floats, axis: int, limit: float,
    kind: int, peak: Floats, place: Floats,
) -> None:  # fmt: skip
    """Raise the peak (3,) of a kind of one axis at places about each top of its values (k,) that is near the limit.

    Parameters: cell (4,) polynomial of z, never below `floor`; q (3, m, k) derivatives of the path at the probes. The
    path is interpolated between its probes, z is not: it is z that changes quickly.
    """
    inside, near, found, tops = closer.inside, closer.near, closer.found, closer.tops
    for one in range(_tops(inside, value, tops)):
        p = tops[one]
        if _bound(inside, value, p) <= peak[kind] + NO_HIGHER:
            continue
        _values_near(cell, floor, length, closer, p, q, axis, 1.0 / limit, kind)
        i = 0
        for other in range(1, LOOKS):
            if found[other] > found[i]:
                i = other
        top, at = found[i], near[p, i]
        if 0 < i < LOOKS - 1:
            top, at = summit(near[p, i - 1], at, near[p, i + 1], found[i - 1], top, found[i + 1])
        if top > peak[kind]:
            peak[kind], place[kind] = top, at


@jit(reorder=True)
def _values_near(
    cell: Floats, floor: float, length: float, closer: Closer, p: int, q: Floats, axis: int, share: float, kind: int
) -> None:
    """Set what is found at the places about probe p: values of a kind of one axis, times `share`."""
    near, weight, state, found = closer.near, closer.weight, closer.state, closer.found
    _states(cell, floor, length, near[p], state)
    first = min(max(p - 2, 0), q.shape[2] - FIVE)
    if kind == SPEED:
        for i in range(LOOKS):
            found[i] = abs(_blend(q, 0, axis, first, weight, p, i) * state[V, i]) * share
    elif kind == ACCELERATION:
        for i in range(LOOKS):
            v, q1, q2 = state[V, i], _blend(q, 0, axis, first, weight, p, i), _blend(q, 1, axis, first, weight, p, i)
            found[i] = abs(q2 * v * v + q1 * state[A, i]) * share
    else:
        for i in range(LOOKS):
            v, q1, q2 = state[V, i], _blend(q, 0, axis, first, weight, p, i), _blend(q, 1, axis, first, weight, p, i)
            third = _blend(q, 2, axis, first, weight, p, i) * v * v * v + 3.0 * q2 * v * state[A, i]
            found[i] = abs(third + q1 * state[J, i]) * share


@jit(inline=True)
def _blend(q: Floats, order: int, axis: int, first: int, weight: Floats, p: int, i: int) -> float:
    """A derivative of one axis at a place about probe p, from those at five probes from `first` on."""
    value: float = (
        q[order, axis, first] * weight[p, 0, i] + q[order, axis, first + 1] * weight[p, 1, i]
        + q[order, axis, first + 2] * weight[p, 2, i] + q[order, axis, first + 3] * weight[p, 3, i]
        + q[order, axis, first + 4] * weight[p, 4, i]
    )  # fmt: skip
    return value


@jit()
def _closer_to_cap(
    value: Floats, cell: Floats, floor: float, length: float, closer: Closer, cap: Floats, peak: Floats, place: Floats
) -> None:  # fmt: skip
    """Raise the peak (3,) of speed at places about each top of its values (k,) that is near the cap (k,)."""
    inside, near, tops = closer.inside, closer.near, closer.tops
    for one in range(_tops(inside, value, tops)):
        p = tops[one]
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

"""Values over limits along a motion: feed cap, then velocity, acceleration and jerk of each joint."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.motion.cell_time import floor_of
from toolpace.kernels.motion.spline_law import inside_cell

SPEED, ACCELERATION, JERK = 0, 1, 2
"""Kinds of limits; the feed is one of speed."""
HIGH = 0.8
"""Usage from which it matters how high a peak goes between probes: three of them tell it to a fifth of a limit."""
CLOSER_LOOKS, FIVE = 12, 5
"""Places on either side of such a peak at which it is looked for again, and probes that tell the path there: beside a
narrow bend the terms of jerk are hundreds of limits each, and all but one of them are taken away by the others."""
STRAIGHT = 1e-3
"""How far the inverse of a cap may be from a straight line over three probes, as a share of it, for a parabola to tell
it between them: a cap that jumps there is known at probes only."""


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


@jit()
def spline_peaks(
    which: Ints, q: Floats, cap: Floats, nodes: Floats, cells: Floats, inside: Floats, velocity: Floats,
    acceleration: Floats, jerk: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """(n, 3) largest usage of speed, acceleration and jerk in some cells of a spline of z, and where, as a share of it.

    Parameters: which (n,) cells; q (3, n k, m) q', q'', q''' and cap (n k,) on ds/dt at the shares `inside` (k,) of
    each of them; nodes (N,) and cells (N - 1, 4) of the spline. A peak between probes is told by the parabola through
    three of them, and looked for where it is near a limit.
    """
    n, k, m = len(which), len(inside), q.shape[2]
    peak, place = np.zeros((n, 3)), np.full((n, 3), 0.5)
    speed, speed2, speed3 = np.empty(k), np.empty(k), np.empty(k)
    rise, both, bend = np.empty(k), np.empty(k), np.empty(k)
    value = np.empty(k)
    for i in range(n):
        cell, low = which[i], i * k
        length = nodes[cell + 1] - nodes[cell]
        z, floor = cells[cell], floor_of(cells[cell], length)
        for p in range(k):
            v, a, j = inside_cell(z, floor, inside[p] * length)
            speed[p], speed2[p], speed3[p] = v, v * v, v * v * v
            rise[p], both[p], bend[p] = a, 3.0 * v * a, j
            value[p] = v / cap[low + p]
        if highest(value, inside, SPEED, peak[i], place[i]):
            closer_to_cap(value, z, floor, length, inside, cap, low, peak[i], place[i])
        for axis in range(m):
            for p in range(k):
                value[p] = abs(q[0, low + p, axis] * speed[p]) / velocity[axis]
            if highest(value, inside, SPEED, peak[i], place[i]):
                closer(value, z, floor, length, inside, q, low, axis, velocity[axis], SPEED, peak[i], place[i])
            for p in range(k):
                value[p] = abs(q[1, low + p, axis] * speed2[p] + q[0, low + p, axis] * rise[p]) / acceleration[axis]
            if highest(value, inside, ACCELERATION, peak[i], place[i]):
                limit = acceleration[axis]
                closer(value, z, floor, length, inside, q, low, axis, limit, ACCELERATION, peak[i], place[i])
            for p in range(k):
                third = q[2, low + p, axis] * speed3[p] + q[1, low + p, axis] * both[p]
                value[p] = abs(third + q[0, low + p, axis] * bend[p]) / jerk[axis]
            if highest(value, inside, JERK, peak[i], place[i]):
                closer(value, z, floor, length, inside, q, low, axis, jerk[axis], JERK, peak[i], place[i])
    return peak, place


@jit()
def highest(value: Floats, inside: Floats, kind: int, peak: Floats, place: Floats) -> bool:
    """Raise the peak (3,) of a kind, and set its place (3,), where the values (k,) at shares `inside` go higher.

    Returns whether any is so high that a top between them may be near the limit.
    """
    k, most = len(value), 0.0
    for p in range(k):
        most = max(most, value[p])
    if most <= HIGH and not most > peak[kind] and not np.isnan(value.sum()):
        return False
    for p in range(k):
        top, at = value[p], inside[p]
        if 0 < p < k - 1 and top > HIGH and top >= value[p - 1] and top >= value[p + 1]:
            top, at = summit(inside[p - 1], at, inside[p + 1], value[p - 1], top, value[p + 1])
        if top > peak[kind] or np.isnan(top):
            peak[kind], place[kind] = top, at
    return most > HIGH


@jit(inline=True)
def about_top(inside: Floats, value: Floats, p: int) -> tuple[float, float]:
    """Ends of the part of a cell in which high values go higher about probe p; the same where none does.

    Beside a node, where a limit is held, the highest may lie between the outermost two probes.
    """
    begin, end = 0.0, 0.0
    last = len(inside) - 1
    if value[p] > HIGH:
        if p == 0:
            _, at = summit(inside[0], inside[1], inside[2], value[0], value[1], value[2])
            if value[1] <= value[0] and inside[0] < at < inside[1]:
                begin, end = inside[0], inside[1]
        elif p == last:
            _, at = summit(inside[p - 2], inside[p - 1], inside[p], value[p - 2], value[p - 1], value[p])
            if value[p - 1] <= value[p] and inside[p - 1] < at < inside[p]:
                begin, end = inside[p - 1], inside[p]
        elif value[p] >= value[p - 1] and value[p] >= value[p + 1]:
            begin, end = inside[p - 1], inside[p + 1]
    return begin, end


@jit()
def closer(
    value: Floats, cell: Floats, floor: float, length: float, inside: Floats, q: Floats, low: int, axis: int,
    limit: float, kind: int, peak: Floats, place: Floats,
) -> None:  # fmt: skip
    """Raise the peak (3,) of a kind of one axis at places about each top of its values (k,) that is near the limit.

    Parameters: cell (4,) polynomial of z, never below `floor`; q (3, n k, m) derivatives of the path, those of this
    cell from `low` on. The path is interpolated between its probes, z is not: it is z that changes quickly.
    """
    for p in range(len(inside)):
        begin, end = about_top(inside, value, p)
        if begin == end:
            continue
        first = min(max(p - 2, 0), len(inside) - FIVE)
        for i in range(1, 2 * CLOSER_LOOKS):
            x = begin + (end - begin) * i / (2 * CLOSER_LOOKS)
            q1, q2, q3 = 0.0, 0.0, 0.0
            for near in range(first, first + FIVE):
                weight = 1.0
                for other in range(first, first + FIVE):
                    if other != near:
                        weight *= (x - inside[other]) / (inside[near] - inside[other])
                o = low + near
                q1, q2, q3 = q1 + weight * q[0, o, axis], q2 + weight * q[1, o, axis], q3 + weight * q[2, o, axis]
            v, a, j = inside_cell(cell, floor, x * length)
            if kind == SPEED:
                found = abs(q1 * v) / limit
            elif kind == ACCELERATION:
                found = abs(q2 * v * v + q1 * a) / limit
            else:
                found = abs(q3 * v * v * v + 3.0 * q2 * v * a + q1 * j) / limit
            if found > peak[kind]:
                peak[kind], place[kind] = found, x


@jit()
def closer_to_cap(
    value: Floats, cell: Floats, floor: float, length: float, inside: Floats, cap: Floats, low: int, peak: Floats,
    place: Floats,
) -> None:  # fmt: skip
    """Raise the peak (3,) of speed at places about each top of its values (k,) that is near the cap.

    Parameters as for `closer`; cap (n k,) on ds/dt, that of this cell from `low` on.
    """
    for p in range(len(inside)):
        begin, end = about_top(inside, value, p)
        if begin == end:
            continue
        middle = min(max(p, 1), len(inside) - 2)
        x0, x1, x2 = inside[middle - 1], inside[middle], inside[middle + 1]
        o = low + middle
        slow0, slow1, slow2 = 1.0 / cap[o - 1], 1.0 / cap[o], 1.0 / cap[o + 1]
        rise = (slow2 - slow0) / (x2 - x0)
        off = slow1 - slow0 - rise * (x1 - x0)
        if not abs(off) <= STRAIGHT * slow1:
            continue
        for i in range(1, 2 * CLOSER_LOOKS):
            x = begin + (end - begin) * i / (2 * CLOSER_LOOKS)
            slow = slow0 + rise * (x - x0) + off * (x - x0) * (x2 - x) / ((x1 - x0) * (x2 - x1))
            found = inside_cell(cell, floor, x * length)[0] * slow
            if found > peak[SPEED]:
                peak[SPEED], place[SPEED] = found, x

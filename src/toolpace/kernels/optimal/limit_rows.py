"""The rows of the optimal planner's problem from a path's derivatives, and the places between nodes that get rows.

At such a place the limits are lowered, by how much they were exceeded there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

SHARE, MOST_LOWERED = 0.3, 4e-4
"""How far a limit is lowered where it gets a row, as a share of what it was passed by, and at most: on either side of
the row about a fourth is left."""
OVERSHOOT = 1.6
"""The same where there is a row already: what is passed beside it stays, if it alone is held to the limit."""
SAME_PLACE = 0.12
"""Share of a cell up to which two places are one: the row there is lowered, and no other put beside it."""
BESIDE_NODE = 0.02
"""Share of a cell that a place between two nodes keeps from them."""
QUARTERS, EIGHTHS = np.linspace(0.25, 0.75, 3), np.linspace(0.125, 0.875, 7)
"""Where a cell that passes a limit by more than a little, or very far, gets its first rows."""
LOWERED = np.array([1.00005, 1.0005, 1.0005])
"""By what their limits of speed, acceleration and jerk are divided: z is smooth between them, its derivatives are less
so."""
A_LITTLE, FAR_PASSED, VERY_FAR = 1.0006, 1.001, 1.01
"""Usage from which that is a little, far, and very far."""
NEIGHBOURS = 3
"""Cells on either side of one that passes a limit by far that get a row too: what such a place loses they would gain.
The next of them get three, since the joints may come to take turns there."""
NOTHING, IN_THE_MIDDLE, AT_PEAKS, AT_QUARTERS, AT_EIGHTHS = range(5)
"""The rows that a cell gets: none, one, one where each kind of limit is passed most, or those at such places."""


class PointRows(NamedTuple):
    """A problem by points: the nodes of its mesh, on both sides where the run has a break, and places between them."""

    basis: Floats
    """(points, 3, 4) z, z', z'' of a point from its four coefficients; row d gives the d-th derivative."""
    first: Ints
    """(points,) the first of those coefficients, ascending."""
    weight: Floats
    """(points,) of the pace 1 / sqrt(z) in the time."""
    cap: Floats
    """(points,) on z: of velocity and feed."""
    rows: Floats
    """(points, 2 m, 3) the first m of acceleration, the others of jerk, divided by their limits."""
    shift: Floats
    """(points, 2 m) the constants of the rows: |r . (z, z', z'') + shift| <= limit; empty where all are zero."""


@jit()
def rows_of(q: Floats, ahead: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """(points, 2 m, 3) rows r of acceleration, then of jerk, as multiples of their limits: r . (z, z', z'').

    From the derivatives q (4, points, m) of the path. Acceleration is held at `ahead` (points,) beyond a point, by its
    slope there, which is that of jerk.
    """
    points, m = q.shape[1], q.shape[2]
    rows = np.empty((points, 2 * m, 3))
    for p in range(points):
        for j in range(m):
            j0, j1, j2 = q[3, p, j], 1.5 * q[2, p, j], q[1, p, j] / 2.0
            rows[p, j, 0] = (q[2, p, j] + ahead[p] * j0) / acceleration[j]
            rows[p, j, 1] = (j2 + ahead[p] * j1) / acceleration[j]
            rows[p, j, 2] = ahead[p] * j2 / acceleration[j]
            rows[p, m + j, 0], rows[p, m + j, 1], rows[p, m + j, 2] = j0 / jerk[j], j1 / jerk[j], j2 / jerk[j]
    return rows


@jit()
def order_with(node: Ints, inside: Bools, place: Floats, cell: Ints, places: Floats) -> Ints:
    """(n + k,) the order of n points and of k places between nodes, which are numbered behind them.

    Both ascend: points by node (n,), those at it before those `inside` the cell behind it, these by place (n,).
    """
    n, k = len(node), len(places)
    out = np.empty(n + k, dtype=np.int64)
    i, j = 0, 0
    for p in range(n + k):
        if j == k or (
            i < n and (node[i] < cell[j] or (node[i] == cell[j] and not (inside[i] and place[i] > places[j])))
        ):
            out[p], i = i, i + 1
        else:
            out[p], j = n + j, j + 1
    return out


@jit(reorder=True)
def lowered(cap: Floats, rows: Floats, by: Floats) -> tuple[Floats, Floats]:
    """Caps (points,) and rows (points, 2 m, 3) with limits divided by factors (points, 3) of speed, acceleration and
    jerk."""
    points, count = rows.shape[0], rows.shape[1]
    caps, out = np.empty(points), np.empty(rows.shape)
    for p in range(points):
        caps[p] = cap[p] / (by[p, 0] * by[p, 0])
        for i in range(count):
            for d in range(3):
                out[p, i, d] = rows[p, i, d] * by[p, 1 if i < count // 2 else 2]
    return caps, out


@jit()
def usage(points: PointRows, c: Floats) -> tuple[Floats, Floats]:
    """(points, 3) largest value over limit of cap, acceleration and jerk rows, and (points,) z, from coefficients c.

    Infinite where z is not positive.
    """
    basis, first, cap, rows, shift = points.basis, points.first, points.cap, points.rows, points.shift
    n, count, shifted = rows.shape[0], rows.shape[1], len(shift) > 0
    used, z = np.zeros((n, 3)), np.empty(n)
    for p in range(n):
        k = first[p]
        c0, c1, c2, c3 = c[k], c[k + 1], c[k + 2], c[k + 3]
        u0 = basis[p, 0, 0] * c0 + basis[p, 0, 1] * c1 + basis[p, 0, 2] * c2 + basis[p, 0, 3] * c3
        u1 = basis[p, 1, 0] * c0 + basis[p, 1, 1] * c1 + basis[p, 1, 2] * c2 + basis[p, 1, 3] * c3
        u2 = basis[p, 2, 0] * c0 + basis[p, 2, 1] * c1 + basis[p, 2, 2] * c2 + basis[p, 2, 3] * c3
        z[p] = u0
        if not u0 > 0.0:
            used[p] = np.inf
            continue
        used[p, 0] = u0 / cap[p]
        for i in range(count):
            value = rows[p, i, 0] * u0 + rows[p, i, 1] * u1 + rows[p, i, 2] * u2
            value = abs(value + shift[p, i] if shifted else value)
            kind = 1 if i < count // 2 else 2
            used[p, kind] = max(used[p, kind], value)
        used[p, 2] *= np.sqrt(u0)
    return used, z


@jit()
def held(
    nodes: Floats, place: Floats, lowered: Floats, used: Floats, top: Floats, wrong: Bools, fresh: Bools, urge: float,
    allowed: float,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Places (k,) of the rows there are and of further ones, ascending, and by what their limits (k, 3) are divided.

    Parameters: place (j,) and lowered (j, 3) of the rows there are; used and top (cells, 3) the largest usage of each
    kind and its place as a share of the cell; `wrong` (cells,) those that are held where they use more than `allowed`;
    `fresh` (cells,) those that get rows whatever; `urge`, how much more than usual limits are lowered.
    """
    asked = asked_for(nodes, place, used, wrong, fresh, allowed)
    places, factors = with_further(nodes, place, lowered, used, top, asked, allowed)
    by = np.ones_like(factors)
    for i in range(len(asked)):
        if asked[i] != AT_PEAKS:
            continue
        for kind in range(3):
            if used[i, kind] > allowed:
                s, length, excess = inside(nodes, i, top[i, kind]), nodes[i + 1] - nodes[i], used[i, kind] - 1.0
                there = is_near(place, s, SAME_PLACE * length)
                more = urge * OVERSHOOT * excess if there else min(urge * SHARE * excess, MOST_LOWERED)
                row = nearest(places, s)
                by[row, kind] = max(by[row, kind], 1.0 + more)
    return places, factors * by


@jit()
def asked_for(nodes: Floats, place: Floats, used: Floats, wrong: Bools, fresh: Bools, allowed: float) -> Ints:
    """(cells,) the rows that each cell gets."""
    cells = len(wrong)
    has_rows, worst, asked = np.zeros(cells, dtype=np.bool_), np.empty(cells), np.zeros(cells, dtype=np.int64)
    i = 0
    for s in place:
        while i < cells - 1 and nodes[i + 1] <= s:
            i += 1
        has_rows[i] = True
    for i in range(cells):
        worst[i] = max(used[i, 0], used[i, 1], used[i, 2])
        if not has_rows[i] and (fresh[i] or (wrong[i] and worst[i] > A_LITTLE)):
            asked[i] = AT_EIGHTHS if worst[i] > VERY_FAR else AT_QUARTERS
        elif wrong[i] and worst[i] > allowed:
            asked[i] = AT_PEAKS
    for i in range(cells):
        if fresh[i] or (wrong[i] and worst[i] > FAR_PASSED):
            ask_beside(asked, has_rows, i, NEIGHBOURS, IN_THE_MIDDLE)
        if fresh[i] or (wrong[i] and worst[i] > A_LITTLE and not has_rows[i]):
            ask_beside(asked, has_rows, i, 1, AT_QUARTERS)
    return asked


@jit()
def ask_beside(asked: Ints, has_rows: Bools, i: int, reach: int, rows: int) -> None:
    """Have so many cells on either side of one get such rows, or more, where they have none yet."""
    for near in range(max(i - reach, 0), min(i + reach, len(asked) - 1) + 1):
        if not has_rows[near]:
            asked[near] = max(asked[near], rows)


@jit()
def with_further(
    nodes: Floats, place: Floats, lowered: Floats, used: Floats, top: Floats, asked: Ints, allowed: float
) -> tuple[Floats, Floats]:
    """The places (k,) and factors (k, 3) of the rows there are, and of those that the cells get."""
    most = len(place) + len(EIGHTHS) * np.count_nonzero(asked)
    places, factors, own = np.empty(most), np.ones((most, 3)), np.empty(len(EIGHTHS))
    count, j, last = 0, 0, -np.inf
    for i in range(len(asked)):
        if asked[i] == NOTHING:
            continue
        few = own_places(nodes, place, used, top, asked, allowed, i, own)
        for one in range(few):
            if asked[i] == AT_PEAKS:
                # of peaks next to each other the first gets a row
                if own[one] - last < SAME_PLACE * (nodes[i + 1] - nodes[i]):
                    continue
                last = own[one]
            while j < len(place) and place[j] < own[one]:
                places[count], factors[count], count, j = place[j], lowered[j], count + 1, j + 1
            if asked[i] >= AT_QUARTERS:
                factors[count] = LOWERED
            places[count], count = own[one], count + 1
    while j < len(place):
        places[count], factors[count], count, j = place[j], lowered[j], count + 1, j + 1
    return places[:count].copy(), factors[:count].copy()


@jit()
def own_places(
    nodes: Floats, place: Floats, used: Floats, top: Floats, asked: Ints, allowed: float, i: int, out: Floats
) -> int:
    """Set the places (7,) at which a cell gets rows, ascending, and return how many there are.

    At peaks there is none where a row is near already.
    """
    node, length, few = nodes[i], nodes[i + 1] - nodes[i], 0
    if asked[i] == AT_PEAKS:
        for kind in range(3):
            s = inside(nodes, i, top[i, kind])
            if used[i, kind] > allowed and not is_near(place, s, SAME_PLACE * length):
                out[few], few = s, few + 1
        out[:few].sort()
        return few
    if asked[i] == IN_THE_MIDDLE:
        out[0] = node + length / 2.0
        return 1
    shares = EIGHTHS if asked[i] == AT_EIGHTHS else QUARTERS
    for x in shares:
        out[few], few = node + length * x, few + 1
    return few


@jit()
def inside(nodes: Floats, i: int, share: float) -> float:
    """The place at a share of a cell, kept from both its nodes."""
    place: float = nodes[i] + min(max(share, BESIDE_NODE), 1.0 - BESIDE_NODE) * (nodes[i + 1] - nodes[i])
    return place


@jit()
def nearest(places: Floats, s: float) -> int:
    """The nearest of places (k,), ascending, of which there are some."""
    after = min(max(int(np.searchsorted(places, s)), 1), max(len(places) - 1, 1))
    at = min(after, len(places) - 1)
    return after - 1 if abs(places[after - 1] - s) <= abs(places[at] - s) else at


@jit()
def is_near(places: Floats, s: float, apart: float) -> bool:
    """Whether any of places (k,), ascending, lies within `apart` of s."""
    return len(places) > 0 and abs(places[nearest(places, s)] - s) < apart

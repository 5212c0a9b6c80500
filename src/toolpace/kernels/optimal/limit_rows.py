"""The rows of the optimal planner's problem, from a path's derivatives, and their values for a z."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit


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
    basis, first, cap, rows = points.basis, points.first, points.cap, points.rows
    n, count = rows.shape[0], rows.shape[1]
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
            value = abs(rows[p, i, 0] * u0 + rows[p, i, 1] * u1 + rows[p, i, 2] * u2)
            kind = 1 if i < count // 2 else 2
            used[p, kind] = max(used[p, kind], value)
        used[p, 2] *= np.sqrt(u0)
    return used, z

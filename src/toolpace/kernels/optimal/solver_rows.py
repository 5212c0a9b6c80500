"""The passes of the solver over its rows.

Points are kept in tiles (see `tiles`), so that vector instructions work on several of them at once. Here no point
waits: the fourth of a step (see `multipliers`) is zero. Sums and peaks are kept lane by lane, and gathered at the end.
`tau` is the share of the reliefs that still stands.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import multipliers
from toolpace.kernels.optimal.limit_rows import PointRows
from toolpace.kernels.optimal.multipliers import (
    BOUND,
    BOUNDS,
    EXTRA,
    EXTRA_JERK,
    FALL,
    FALLS,
    GROWS,
    LIMIT,
    LINEAR,
    MOST_FALL,
    RELAXED,
    SHIFT,
    SLOPE,
    SQUARE,
    TILE,
    Z1,
    Z2,
    RowSteps,
    RowTiles,
    Z,
    set_bounds,
    set_shift,
    share_left,
    tiled,
)
from toolpace.kernels.optimal.newton import System, add_curvature, add_curvature_inside, add_slope

KEEP_CURVATURE = 0.05
"""Least share of the curvature of the duration that stays where the jerk rows bend the other way: it keeps the Newton
matrix positive definite."""
CAP, ACCELERATION, JERK = 0, 1, 2
"""What the columns of a relief are for."""


class Caps(NamedTuple):
    """What the points have beside their rows, in tiles."""

    weight: Floats
    """(tiles, TILE) of the pace in the time."""
    cap: Floats
    """(tiles, TILE) on z."""
    relief: Floats
    """(tiles, 3, TILE) of cap, acceleration and jerk rows: by how much they are relaxed at first."""
    dual: Floats
    """(tiles, TILE) multipliers of the caps."""
    step: Floats
    """(tiles, TILE) the corrector's steps of these multipliers."""


@jit(inline=True)
def caps_of(points: PointRows, relief: Floats) -> Caps:
    """The caps of a problem with relief (points, 3), their multipliers still zero."""
    n = len(points.first)
    weight = tiled(points.weight.reshape(n, 1)).reshape(-1, TILE)
    cap = tiled(points.cap.reshape(n, 1)).reshape(-1, TILE)
    return Caps(weight, cap, tiled(relief), np.zeros_like(cap), np.zeros_like(cap))


@jit()
def spread(points: PointRows, c: Floats, out: Floats) -> None:
    """out (tiles, 3 or more, TILE): z, z', z'' at the points from the coefficients c."""
    basis, first = points.basis, points.first
    for p in range(len(first)):
        k = first[p]
        for d in range(3):
            out[p // TILE, d, p % TILE] = basis[p, d, 0] * c[k] + basis[p, d, 1] * c[k + 1] + basis[p, d, 2] * c[k + 2]
        if basis[p, 2, 3] != 0.0:
            for d in range(3):
                out[p // TILE, d, p % TILE] += basis[p, d, 3] * c[k + 3]


@jit()
def wanted(points: PointRows, c: Floats, idle: float) -> Bools:
    """(tiles, 2 m) the rows that are used at least so much at some point of a tile, with the coefficients c."""
    basis, first, rows, shift = points.basis, points.first, points.rows, points.shift
    n, count, shifted = rows.shape[0], rows.shape[1], len(shift) > 0
    out = np.zeros(((n + TILE - 1) // TILE, count), dtype=np.bool_)
    state = np.empty(3)
    for p in range(n):
        for d in range(3):
            state[d] = 0.0
            for j in range(4):
                state[d] += basis[p, d, j] * c[first[p] + j]
        pace = np.sqrt(state[0])
        for i in range(count):
            value = rows[p, i, 0] * state[0] + rows[p, i, 1] * state[1] + rows[p, i, 2] * state[2]
            value = abs(value + shift[p, i] if shifted else value)
            out[p // TILE, i] |= not (value if 2 * i < count else value * pace) < idle
    return out


@jit(reorder=True)
def states(points: PointRows, c: Floats, caps: Caps, tau: float, at: Floats) -> None:
    """Set the states at the points from the coefficients c."""
    relief = caps.relief
    spread(points, c, at)
    for t in range(len(at)):
        for p in range(min(TILE, len(points.first) - t * TILE)):
            pace = 1.0 / np.sqrt(at[t, Z, p])
            at[t, LIMIT, p], at[t, FALL, p] = pace, 0.5 * pace / at[t, Z, p]
            at[t, EXTRA, p], at[t, EXTRA_JERK, p] = tau * relief[t, ACCELERATION, p], tau * relief[t, JERK, p]


@jit(reorder=True)
def start(tiles: RowTiles, caps: Caps, tau: float, centre: float) -> None:
    """Multipliers that make every product of slack and multiplier equal to `centre`."""
    at, cap, relief, dual_cap = tiles.at, caps.cap, caps.relief, caps.dual
    multipliers.start(tiles, centre)
    for t in range(len(at)):
        for p in range(min(TILE, tiles.points - t * TILE)):
            dual_cap[t, p] = centre / (cap[t, p] - at[t, Z, p] + tau * relief[t, CAP, p])


@jit(inline=True)
def duration(tiles: RowTiles, caps: Caps) -> float:
    """The time that is minimised: the sum of weight / sqrt(z)."""
    time = 0.0
    for p in range(tiles.points):
        time += caps.weight[p // TILE, p % TILE] * tiles.at[p // TILE, LIMIT, p % TILE]
    return time


M00, M01, M02, M11, M12, M22, G0, G1, G2, L0, L1, L2, REVERSE = range(13)
"""Sums of a point: second derivatives, right-hand side, gradient, and all multipliers of its jerk rows."""


@jit(reorder=True)
def newton_system(
    points: PointRows, tiles: RowTiles, caps: Caps, tau: float, system: System, gradient: Floats
) -> tuple[float, float]:
    """Newton matrix, right-hand side for a centring of zero, gradient (n,) of the Lagrangian; returns gap and time."""
    basis, first, rows, kept, at, dual = points.basis, points.first, tiles.rows, tiles.kept, tiles.at, tiles.dual
    weight, cap, relief, dual_cap = caps.weight, caps.cap, caps.relief, caps.dual
    matrix, rhs = system.matrix, system.rhs
    matrix[:] = 0.0
    rhs[:] = 0.0
    gradient[:] = 0.0
    sums, bounds, gaps, times = np.empty((13, TILE)), np.empty((BOUNDS, TILE)), np.zeros(TILE), np.zeros(TILE)
    for t in range(len(rows)):
        lanes = min(TILE, len(first) - t * TILE)
        set_bounds(at[t], lanes, bounds)
        sums[:] = 0.0
        for i in range(kept[t, 0] + kept[t, 1]):
            kind = 0 if i < kept[t, 0] else 1
            set_shift(tiles, t, i, lanes, bounds)
            jerk = float(kind)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                fall, extra = bounds[SLOPE + kind, p], bounds[RELAXED + kind, p]
                value, room = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p], bounds[BOUND + kind, p] + extra
                value += bounds[SHIFT, p]
                up, down = room - value, room + value
                inverse = 1.0 / (up * down)
                above, below = dual[t, i, 0, p], dual[t, i, 1, p]
                stiff_up, stiff_down = above * inverse * down, below * inverse * up
                both, odd = stiff_up + stiff_down, stiff_up - stiff_down
                total, difference = above + below, above - below
                h0, push = both * r0 + odd * fall, odd * r0 + both * fall
                sums[M00, p] += h0 * r0 + push * fall
                sums[M01, p] += h0 * r1
                sums[M02, p] += h0 * r2
                sums[M11, p] += both * r1 * r1
                sums[M12, p] += both * r1 * r2
                sums[M22, p] += both * r2 * r2
                sums[G0, p] += extra * push
                sums[G1, p] += extra * odd * r1
                sums[G2, p] += extra * odd * r2
                sums[L0, p] += difference * r0 + total * fall
                sums[L1, p] += difference * r1
                sums[L2, p] += difference * r2
                sums[REVERSE, p] += jerk * total
                gaps[p] += up * above + down * below
        for p in range(lanes):
            z, w, fall = at[t, Z, p], weight[t, p], at[t, FALL, p]
            relaxed = tau * relief[t, CAP, p]
            slack = cap[t, p] - z + relaxed
            stiff = dual_cap[t, p] / slack
            sums[M00, p] += stiff + 1.5 * fall / z * max(w - sums[REVERSE, p], KEEP_CURVATURE * w)
            sums[G0, p] += stiff * relaxed - w * fall
            sums[L0, p] += dual_cap[t, p] - w * fall
            gaps[p] += slack * dual_cap[t, p]
            times[p] += w * at[t, LIMIT, p]
        for p in range(lanes):
            point = t * TILE + p
            k = first[point]
            curvature = (sums[M00, p], sums[M01, p], sums[M02, p], sums[M11, p], sums[M12, p], sums[M22, p])
            add_curvature(basis, point, k, curvature, matrix)
            add_slope(basis, point, k, (-sums[G0, p], -sums[G1, p], -sums[G2, p]), rhs)
            add_slope(basis, point, k, (sums[L0, p], sums[L1, p], sums[L2, p]), gradient)
            e0, e1, e2 = basis[point, 0, 3], basis[point, 1, 3], basis[point, 2, 3]
            if e2 != 0.0:
                add_curvature_inside(basis, point, k, curvature, matrix)
                rhs[k + 3] -= e0 * sums[G0, p] + e1 * sums[G1, p] + e2 * sums[G2, p]
                gradient[k + 3] += e0 * sums[L0, p] + e1 * sums[L1, p] + e2 * sums[L2, p]
    return float(gaps.sum()), float(times.sum())


A0, A1, A2, C0, C1, C2 = range(6)
"""Sums of a point: what centring and the second-order terms take from the right-hand side."""


@jit(reorder=True)
def predict(
    points: PointRows, tiles: RowTiles, caps: Caps, tau: float, affine: Floats, gap: float, system: System
) -> float:
    """What the predictor's step `affine` (tiles, 4, TILE) teaches the corrector: `centring` and `second` of the system.

    Returns the share of the gap that the longest such step leaves.
    """
    basis, first, rows, kept, at, dual = points.basis, points.first, tiles.rows, tiles.kept, tiles.at, tiles.dual
    cap, relief, dual_cap, centring, second = caps.cap, caps.relief, caps.dual, system.centring, system.second
    centring[:] = 0.0
    second[:] = 0.0
    sums, bounds, lane = np.empty((6, TILE)), np.empty((BOUNDS, TILE)), np.zeros((4, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, len(first) - t * TILE)
        set_bounds(at[t], lanes, bounds)
        for p in range(lanes):
            move = affine[t, 0, p]
            relaxed = tau * relief[t, CAP, p]
            inverse = 1.0 / (cap[t, p] - at[t, Z, p] + relaxed)
            change = -(move + relaxed) * inverse
            sums[A0, p], sums[A1, p], sums[A2, p] = inverse, 0.0, 0.0
            sums[C0, p], sums[C1, p], sums[C2, p] = dual_cap[t, p] * (1.0 + change) * change, 0.0, 0.0
            product = dual_cap[t, p] / inverse * change
            lane[LINEAR, p] += product
            lane[SQUARE, p] += product * change
            lane[FALLS, p] = max(lane[FALLS, p], max(-change, -move / at[t, Z, p]))
            lane[GROWS, p] = max(lane[GROWS, p], change)
        for i in range(kept[t, 0] + kept[t, 1]):
            kind = 0 if i < kept[t, 0] else 1
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                fall, extra = bounds[SLOPE + kind, p], bounds[RELAXED + kind, p]
                value, room = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p], bounds[BOUND + kind, p] + extra
                value += bounds[SHIFT, p]
                move = r0 * affine[t, 0, p] + r1 * affine[t, 1, p] + r2 * affine[t, 2, p]
                common = -fall * affine[t, 0, p] - extra
                up, down = room - value, room + value
                inverse = 1.0 / (up * down)
                inverse_up, inverse_down = inverse * down, inverse * up
                change_up, change_down = (common - move) * inverse_up, (common + move) * inverse_down
                above, below = dual[t, i, 0, p] * change_up, dual[t, i, 1, p] * change_down
                lane[LINEAR, p] += above * up + below * down
                lane[SQUARE, p] += above * up * change_up + below * down * change_down
                lane[FALLS, p] = max(lane[FALLS, p], max(-change_up, -change_down))
                lane[GROWS, p] = max(lane[GROWS, p], max(change_up, change_down))
                both, odd = inverse_up + inverse_down, inverse_up - inverse_down
                sums[A0, p] += odd * r0 + both * fall
                sums[A1, p] += odd * r1
                sums[A2, p] += odd * r2
                above, below = above * (1.0 + change_up), below * (1.0 + change_down)
                sums[C0, p] += (above - below) * r0 + (above + below) * fall
                sums[C1, p] += (above - below) * r1
                sums[C2, p] += (above - below) * r2
        for p in range(lanes):
            point = t * TILE + p
            k = first[point]
            add_slope(basis, point, k, (sums[A0, p], sums[A1, p], sums[A2, p]), centring)
            add_slope(basis, point, k, (sums[C0, p], sums[C1, p], sums[C2, p]), second)
            e0, e1, e2 = basis[point, 0, 3], basis[point, 1, 3], basis[point, 2, 3]
            if e2 != 0.0:
                centring[k + 3] += e0 * sums[A0, p] + e1 * sums[A1, p] + e2 * sums[A2, p]
                second[k + 3] += e0 * sums[C0, p] + e1 * sums[C1, p] + e2 * sums[C2, p]
    return share_left(gap, lane[FALLS].max(), lane[GROWS].max(), lane[LINEAR].sum(), lane[SQUARE].sum())


@jit(reorder=True)
def correct(tiles: RowTiles, caps: Caps, tau: float, steps: RowSteps, centre: float) -> tuple[float, float]:
    """Set the steps of all multipliers that go with the corrector's change of z, z', z''.

    Returns the largest relative losses of slack and of multiplier.
    """
    at, affine, change = tiles.at, steps.affine, steps.change
    cap, relief, dual_cap, step_cap = caps.cap, caps.relief, caps.dual, caps.step
    loss, loss_dual = multipliers.correct(tiles, steps, centre)
    for t in range(len(at)):
        for p in range(min(TILE, tiles.points - t * TILE)):
            z, relaxed, multiplier = at[t, Z, p], tau * relief[t, CAP, p], dual_cap[t, p]
            inverse = 1.0 / (cap[t, p] - z + relaxed)
            by, before = -(change[t, 0, p] + relaxed) * inverse, -(affine[t, 0, p] + relaxed) * inverse
            grow = centre * inverse / multiplier + before * (1.0 + before) - by - 1.0
            step_cap[t, p] = multiplier * grow
            loss, loss_dual = max(loss, max(-by, -change[t, 0, p] / (MOST_FALL * z))), max(loss_dual, -grow)
    return loss, loss_dual

"""The passes of the relaxation over its rows.

As in `solver_rows` points are kept in tiles, sums and peaks lane by lane. What belongs to the knots of the points comes
spread out to them: states (see `relaxation_knots`), steps, and how waits follow. The limit of a jerk row is pace and
wait together.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.multipliers import (
    BOUND,
    BOUNDS,
    COMMON,
    FALL,
    FALLS,
    GROWS,
    LIMIT,
    LINEAR,
    RELAXED,
    SQUARE,
    Z1,
    Z2,
    RowTiles,
    Z,
    set_bounds,
    set_common,
)
from toolpace.kernels.optimal.newton import System, add_curvature, add_slope
from toolpace.kernels.optimal.relaxation_knots import TOTAL, V0, V1, V2
from toolpace.kernels.optimal.relaxation_work import Points, Waits
from toolpace.kernels.optimal.tiles import TILE

LEAN, MEAN1, MEAN2 = 0, 2, 4
"""Of the rows of a tile, those of acceleration, and next to it those of jerk: how limit and wait follow z, z', z''."""


@jit()
def at_points(first: Ints, values: Floats, out: Floats) -> None:
    """out (tiles, width, TILE): at each point the values (n, width) of its knot."""
    for k in range(len(values)):
        for p in range(first[k], first[k + 1]):
            for i in range(values.shape[1]):
                out[p // TILE, i, p % TILE] = values[k, i]


@jit(inline=True)
def by_point(tiles: Floats, out: Floats) -> None:
    """out (points, count, 2) from tiles (tiles, count, 2, TILE)."""
    for p in range(len(out)):
        for i in range(out.shape[1]):
            out[p, i, 0], out[p, i, 1] = tiles[p // TILE, i, 0, p % TILE], tiles[p // TILE, i, 1, p % TILE]


@jit(reorder=True, inline=True)
def _means(at: Floats, mean: Floats, lanes: int, out: Floats) -> None:
    """Set what the waits do to the rows of a tile."""
    for p in range(lanes):
        out[LEAN, p], out[LEAN + 1, p] = 0.0, at[FALL, p] - mean[0, p]
        out[MEAN1, p], out[MEAN1 + 1, p] = 0.0, mean[1, p]
        out[MEAN2, p], out[MEAN2 + 1, p] = 0.0, mean[2, p]


@jit(reorder=True)
def wait_system(tiles: RowTiles, out: Floats) -> None:
    """out (points, 4): what the jerk rows of each point add to the second derivatives by the wait of its knot."""
    points, rows, _, at, dual = tiles
    half = rows.shape[1] // 2
    sums = np.empty((4, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, points - t * TILE)
        sums[:] = 0.0
        for i in range(half, 2 * half):
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p]
                up, down = at[t, LIMIT, p] - value, at[t, LIMIT, p] + value
                inverse = 1.0 / (up * down)
                stiff_up, stiff_down = dual[t, i, 0, p] * inverse * down, dual[t, i, 1, p] * inverse * up
                both, odd = stiff_up + stiff_down, stiff_up - stiff_down
                sums[TOTAL, p] += both
                sums[V0, p] += odd * r0 + both * at[t, FALL, p]
                sums[V1, p] += odd * r1
                sums[V2, p] += odd * r2
        for p in range(lanes):
            for i in range(4):
                out[t * TILE + p, i] = sums[i, p]


M00, M01, M02, M11, M12, M22, G0, G1, G2 = range(9)
"""Sums of a point: second derivatives and right-hand side, the wait eliminated."""


@jit(reorder=True)
def newton_system(basis: Floats, points: Points, tiles: RowTiles, system: System) -> float:
    """Add the rows to the Newton matrix and the right-hand side for a centring of zero; returns their gap.

    What is left of the jerk rows of a knot after the elimination of its wait is the scatter of their gradients about
    their mean, which is summed as such: the difference of two large sums would drown.
    """
    knot, mean, matrix, rhs = points.knot, points.mean, system.matrix, system.rhs
    rows, at, dual = tiles.rows, tiles.at, tiles.dual
    half = rows.shape[1] // 2
    sums, bounds, gaps = np.empty((9, TILE)), np.empty((BOUNDS, TILE)), np.zeros(TILE)
    means = np.empty((6, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, len(knot) - t * TILE)
        set_bounds(at[t], lanes, bounds)
        _means(at[t], mean[t], lanes, means)
        sums[:] = 0.0
        for i in range(2 * half):
            kind = 0 if i < half else 1
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value, extra = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p], bounds[RELAXED + kind, p]
                up, down = bounds[BOUND + kind, p] + extra - value, bounds[BOUND + kind, p] + extra + value
                inverse = 1.0 / (up * down)
                above, below = dual[t, i, 0, p], dual[t, i, 1, p]
                stiff_up, stiff_down = above * inverse * down, below * inverse * up
                gaps[p] += up * above + down * below
                lean, mean1, mean2 = means[LEAN + kind, p], means[MEAN1 + kind, p], means[MEAN2 + kind, p]
                up0, up1, up2 = lean + r0, r1 - mean1, r2 - mean2
                down0, down1, down2 = lean - r0, -r1 - mean1, -r2 - mean2
                sums[M00, p] += stiff_up * up0 * up0 + stiff_down * down0 * down0
                sums[M01, p] += stiff_up * up0 * up1 + stiff_down * down0 * down1
                sums[M02, p] += stiff_up * up0 * up2 + stiff_down * down0 * down2
                sums[M11, p] += stiff_up * up1 * up1 + stiff_down * down1 * down1
                sums[M12, p] += stiff_up * up1 * up2 + stiff_down * down1 * down2
                sums[M22, p] += stiff_up * up2 * up2 + stiff_down * down2 * down2
                pull = extra * (stiff_up - stiff_down)
                sums[G0, p] += pull * r0
                sums[G1, p] += pull * r1
                sums[G2, p] += pull * r2
        for p in range(lanes):
            k = knot[t * TILE + p]
            curvature = (sums[M00, p], sums[M01, p], sums[M02, p], sums[M11, p], sums[M12, p], sums[M22, p])
            add_curvature(basis, k, k, curvature, matrix)
            add_slope(basis, k, k, (-sums[G0, p], -sums[G1, p], -sums[G2, p]), rhs)
    return float(gaps.sum())


A0, A1, A2, AWAIT, C0, C1, C2, CWAIT = range(8)
"""Sums of a point: what centring and the second-order terms take from the right-hand side and the pull of the wait."""


@jit(reorder=True)
def predict(
    basis: Floats, points: Points, tiles: RowTiles, affine: Floats, system: System, waits: Waits
) -> tuple[float, float, float, float]:
    """Add what the predictor's step `affine` (tiles, 4, TILE) teaches the corrector: as in `solver_rows.predict`.

    Besides what they take from the right-hand side, centring and the second-order terms pull at the waits.
    Returns the largest relative fall and growth of a slack, and the sums that give the gap after a step.
    """
    knot, mean, rows, at, dual = points.knot, points.mean, tiles.rows, tiles.at, tiles.dual
    centring, second, pull_centring, pull_second = system.centring, system.second, waits.centring, waits.second
    half = rows.shape[1] // 2
    sums, bounds, lane = np.empty((8, TILE)), np.empty((BOUNDS, TILE)), np.zeros((4, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, len(knot) - t * TILE)
        set_bounds(at[t], lanes, bounds)
        set_common(at[t], affine[t], COMMON, lanes, bounds)
        sums[:] = 0.0
        for i in range(2 * half):
            kind = 0 if i < half else 1
            jerk = 0.0 if i < half else 1.0
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p]
                move = r0 * affine[t, 0, p] + r1 * affine[t, 1, p] + r2 * affine[t, 2, p]
                room, common = bounds[BOUND + kind, p] + bounds[RELAXED + kind, p], bounds[COMMON + kind, p]
                up, down = room - value, room + value
                inverse = 1.0 / (up * down)
                inverse_up, inverse_down = inverse * down, inverse * up
                change_up, change_down = (common - move) * inverse_up, (common + move) * inverse_down
                above, below = dual[t, i, 0, p] * change_up, dual[t, i, 1, p] * change_down
                lane[LINEAR, p] += above * up + below * down
                lane[SQUARE, p] += above * up * change_up + below * down * change_down
                lane[FALLS, p] = max(lane[FALLS, p], max(-change_up, -change_down))
                lane[GROWS, p] = max(lane[GROWS, p], max(change_up, change_down))
                odd = inverse_up - inverse_down
                sums[A0, p] += odd * r0
                sums[A1, p] += odd * r1
                sums[A2, p] += odd * r2
                sums[AWAIT, p] += jerk * (inverse_up + inverse_down)
                above, below = above * (1.0 + change_up), below * (1.0 + change_down)
                sums[C0, p] += (above - below) * r0
                sums[C1, p] += (above - below) * r1
                sums[C2, p] += (above - below) * r2
                sums[CWAIT, p] += jerk * (above + below)
        for p in range(lanes):
            k = knot[t * TILE + p]
            lean, mean1, mean2 = at[t, FALL, p] - mean[t, 0, p], mean[t, 1, p], mean[t, 2, p]
            by = sums[AWAIT, p]
            slope = (sums[A0, p] + by * lean, sums[A1, p] - by * mean1, sums[A2, p] - by * mean2)
            add_slope(basis, k, k, slope, centring)
            pull_centring[k] += by
            by = sums[CWAIT, p]
            slope = (sums[C0, p] + by * lean, sums[C1, p] - by * mean1, sums[C2, p] - by * mean2)
            add_slope(basis, k, k, slope, second)
            pull_second[k] += by
    return float(lane[FALLS].max()), float(lane[GROWS].max()), float(lane[LINEAR].sum()), float(lane[SQUARE].sum())

"""A convex relaxation of the optimal planner's problem, for its lower bound.

In the problem of `solver` only the right side of the jerk rows is not convex. Here every knot k has a
wait y_k >= 0 as well, a time that it may stand still for at the price of that time:

    minimise    sum_k w_k (1 / sqrt(z_k) + y_k)  [+ price . c, of a part whose surroundings are priced]
    subject to  z_k <= cap_k
                |r . (z, z', z'')_k + shift| <= 1                        acceleration rows
                |r . (z, z', z'')_k + shift| <= 1 / sqrt(z_k) + y_k      jerk rows
                low_k <= z_k,  1 / sqrt(z_k) + y_k <= chord_k(z_k)       where low_k > 0

With the pace 1 / sqrt(z_k) + y_k as the variable this is convex, and y = 0 gives the problem itself. Where z is known
to lie in a range, from low to cap, the pace is no more than the chord of 1 / sqrt(z) over that range: the narrower the
ranges, the closer the relaxation. A knot without rows has no wait. `relax` finds multipliers near its optimum by a
primal-dual interior-point method; the wait is eliminated knot by knot, so that the Newton matrix keeps its diagonals.
The derivation is in docs/design/bound.md.

As in `solver_rows` points are kept in tiles, sums and peaks lane by lane. What belongs to the knots of the points comes
spread out to them: states (see `relaxation_knots`), steps, and how waits follow. The limit of a jerk row is pace and
wait together.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import multipliers, relaxation_knots
from toolpace.kernels.optimal.dual import KnotRows, dual_value
from toolpace.kernels.optimal.multipliers import (
    BACK_OFF,
    BOUND,
    BOUNDS,
    COMMON,
    FALL,
    FALLS,
    GROWS,
    LIMIT,
    LINEAR,
    RELAXED,
    SHIFT,
    SQUARE,
    TILE,
    Z1,
    Z2,
    RowTiles,
    Z,
    advance,
    product_aimed_at,
    set_bounds,
    set_common,
    set_shift,
    share_left,
)
from toolpace.kernels.optimal.newton import System, add_curvature, add_slope, aim_at_centre, aim_at_optimum, factor_tied
from toolpace.kernels.optimal.relaxation_knots import TOTAL, V0, V1, V2, at_knots
from toolpace.kernels.optimal.relaxation_work import Points, Waits, Work, count_of, work_of

NEAR = 1e-3
"""Gap relative to the time at the start from which the bound is worked out at every step, and the best one kept."""
NEAR_ENOUGH = 0.03
"""The same where any bound beyond a given one will do."""
ROUNDING = 1e-4
"""Gap, as a multiple of what is tolerated, at which further steps only gather rounding."""
LEAN, MEAN1, MEAN2 = 0, 2, 4
"""Of the rows of a tile, those of acceleration, and next to it those of jerk: how limit and wait follow z, z', z''."""


@jit()
def relax(
    knots: KnotRows, low: Floats, cap: Floats, c: Floats, relief: Floats, tolerance: float, enough: float,
    most_steps: int,
) -> tuple[float, Floats, Floats, int]:  # fmt: skip
    """Multipliers near the optimum of the relaxation, and their bound.

    Parameters: low (n,) 0 where unknown, and cap (n,) of z; c (n + 2,) start with z > 0 at the knots, overwritten by
    the result; relief (n, 4) of cap, acceleration, floor and chord (the last is found here); tolerance of what is lost
    between what is minimised and the bound, relative to the time at the start; a bound of `enough` ends it early.
    Returns the bound, its multipliers (points, 2 m, 2), the waits (n,), and the number of steps.
    """
    work = work_of(knots, low, cap, relief)
    points, count = knots.rows.shape[0], knots.rows.shape[1]
    products = 2 * points * count + count_of(work.own)
    best, dual = np.zeros((points, count, 2)), np.zeros((points, count, 2))
    bound, _, _ = dual_value(knots, low, cap, best)
    scale, tau = _start(work, c, products)
    near = NEAR if enough == np.inf else NEAR_ENOUGH
    number = 0
    for number in range(most_steps + 1):
        gap, least = _newton_system(work, c)
        if gap < near * scale or number == most_steps:
            by_point(work.tiles.dual, dual)
            value, _, _ = dual_value(knots, low, cap, dual)
            if value > bound:
                bound = value
                copy(dual.reshape(-1), best.reshape(-1))
            if bound >= enough or (least - bound < tolerance * scale and tau < 1e-9):
                break
            if gap < ROUNDING * tolerance * scale:
                break
        if number == most_steps or not factor_tied(work.system, knots.ends):
            break
        centre = product_aimed_at(gap, products, _predictor(work, gap))
        go, go_dual = _corrector(work, tau, centre)
        if not (go > 0.0 and go_dual > 0.0):
            break
        _go(work, c, go, go_dual)
        tau *= 1.0 - go
        _evaluate(work, tau)
    return bound, best, work.states.wait, number


@jit(inline=True)
def _start(work: Work, c: Floats, products: int) -> tuple[float, float]:
    """Set states, waits and multipliers for a gap as large as the time at the start.

    Returns that time, and the share of the reliefs that stands.
    """
    knots, states = work.knots, work.states
    at_knots(knots.basis, c, states.at)
    time = 0.0
    for k in range(len(knots.weight)):
        time += knots.weight[k] / np.sqrt(states.at[k, 0])
    centre = time / products
    relaxation_knots.first_waits(knots, work.own, states, centre)
    tau = 1.0 if np.max(work.own.relief) > 0.0 else 0.0
    _evaluate(work, tau)
    relaxation_knots.start(knots, work.own, states, centre)
    multipliers.start(work.tiles, centre)
    return time, tau


@jit(inline=True)
def _evaluate(work: Work, tau: float) -> None:
    """Complete the states of knots and points from z, z', z'' and wait at the knots."""
    relaxation_knots.complete(work.own, tau, work.states)
    at_points(work.knots.first, work.states.at, work.tiles.at)


@jit(inline=True)
def _newton_system(work: Work, c: Floats) -> tuple[float, float]:
    """Newton matrix and right-hand side for a centring of zero, the waits eliminated; returns gap and value."""
    knots, system, waits, points = work.knots, work.system, work.waits, work.points
    system.matrix[:] = 0.0
    copy(-knots.price, system.rhs)
    wait_system(work.tiles, points.of_wait)
    gap, value = relaxation_knots.eliminate_waits(knots, work.own, work.states, points.of_wait, system, waits)
    at_points(knots.first, waits.mean, points.mean)
    gap += newton_system(knots.basis, points, work.tiles, system)
    return gap, value + float(c @ knots.price)


@jit(inline=True)
def _predictor(work: Work, gap: float) -> float:
    """Straight at the optimum, to learn how far one can go: returns the share of the gap that this leaves."""
    knots, system, waits, affine = work.knots, work.system, work.waits, work.knot_steps.affine
    aim_at_optimum(system, knots.ends)
    at_knots(knots.basis, system.direction, affine)
    relaxation_knots.follow(waits, affine)
    at_points(knots.first, affine, work.row_steps.affine)
    system.centring[:], system.second[:], waits.centring[:], waits.second[:] = 0.0, 0.0, 0.0, 0.0
    falls, grows, linear, square = relaxation_knots.predict(knots, work.own, work.states, waits, affine, system)
    of_rows = predict(knots.basis, work.points, work.tiles, work.row_steps.affine, system, waits)
    return share_left(gap, max(falls, of_rows[0]), max(grows, of_rows[1]), linear + of_rows[2], square + of_rows[3])


@jit(inline=True)
def _corrector(work: Work, tau: float, centre: float) -> tuple[float, float]:
    """The step that is taken: centred, with the second-order terms that the predictor revealed.

    Returns how much of it can be gone by coefficients and waits, and by the multipliers.
    """
    knots, system, waits, change = work.knots, work.system, work.waits, work.knot_steps.change
    aim_at_centre(system, knots.ends, centre)
    pull = waits.pull
    pull -= centre * waits.centring + waits.second
    at_knots(knots.basis, system.direction, change)
    relaxation_knots.follow(waits, change)
    at_points(knots.first, change, work.row_steps.change)
    loss, loss_dual = relaxation_knots.correct(work.own, work.states, work.knot_steps, centre)
    loss_rows, loss_dual_rows = multipliers.correct(work.tiles, work.row_steps, centre)
    go = min(1.0, BACK_OFF / max(loss, loss_rows))
    go_dual = min(1.0, BACK_OFF / max(loss_dual, loss_dual_rows))
    return relaxation_knots.within_chords(work.own, tau, work.states, change, go), go_dual


@jit(inline=True)
def _go(work: Work, c: Floats, go: float, go_dual: float) -> None:
    """Go these shares of the corrector's step: with coefficients and waits, and with the multipliers."""
    states, steps = work.states, work.knot_steps
    c += go * work.system.direction
    at_knots(work.knots.basis, c, states.at)
    for k in range(len(states.wait)):
        states.wait[k] += go * steps.change[k, 3]
    advance(work.tiles.dual.reshape(-1), work.row_steps.dual.reshape(-1), go_dual)
    advance(states.dual.reshape(-1), steps.dual.reshape(-1), go_dual)


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
    points, rows, _, at, dual, _ = tiles
    half = rows.shape[1] // 2
    sums, bounds = np.empty((4, TILE)), np.zeros((BOUNDS, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, points - t * TILE)
        sums[:] = 0.0
        for i in range(half, 2 * half):
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p] + bounds[SHIFT, p]
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
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value, extra = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p], bounds[RELAXED + kind, p]
                value += bounds[SHIFT, p]
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
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p] + bounds[SHIFT, p]
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

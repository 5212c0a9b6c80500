"""How fast the optimal planner's problem could be solved at best: a convex relaxation of it.

In the problem of `solver` only the right side of the jerk rows is not convex. Here every knot k has a
wait y_k >= 0 as well, a time that it may stand still for at the price of that time:

    minimise    sum_k w_k (1 / sqrt(z_k) + y_k)  [+ price . c, of a part whose surroundings are priced]
    subject to  z_k <= cap_k
                |r . (z, z', z'')_k| <= 1                                acceleration rows
                |r . (z, z', z'')_k| <= 1 / sqrt(z_k) + y_k              jerk rows
                low_k <= z_k,  1 / sqrt(z_k) + y_k <= chord_k(z_k)       where low_k > 0

With the pace 1 / sqrt(z_k) + y_k as the variable this is convex, and y = 0 gives the problem itself. Where z is known
to lie in a range, from low to cap, the pace is no more than the chord of 1 / sqrt(z) over that range: the narrower the
ranges, the closer the relaxation. A knot without rows has no wait. `relax` finds multipliers near its optimum by a
primal-dual interior-point method; the wait is eliminated knot by knot, so that the Newton matrix keeps five diagonals.
The derivation is in docs/design/bound.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import multipliers, relaxation_knots, relaxation_rows
from toolpace.kernels.optimal.dual import dual_value
from toolpace.kernels.optimal.multipliers import STATES, share_left
from toolpace.kernels.optimal.newton import factor_tied, solve_tied
from toolpace.kernels.optimal.tiles import TILE, advance, tiled

CONVERGED, STALLED, BROKEN = 0, 1, 2
BACK_OFF = 0.99
NEAR = 1e-3
"""Gap relative to the time at the start from which the bound is worked out at every step, and the best one kept."""
NEAR_ENOUGH = 0.03
"""The same where any bound beyond a given one will do."""
ROUNDING = 1e-4
"""Gap, as a multiple of what is tolerated, at which further steps only gather rounding."""


@jit()
def relax(
    basis: Any, first: Any, weight: Any, price: Any, low: Any, cap: Any, rows: Any, c: Any, relief: Any, end: Any,
    ratio: Any, fixed: Any, spread: Any, tolerance: Any, enough: Any, most_steps: Any,
) -> Any:  # fmt: skip
    """Multipliers near the optimum of the relaxation, and their bound.

    Parameters as of `dual_value` and `speed.maximise_speed`, low (0 where unknown), cap and weight (n,) by knot, relief
    (n, 4) of cap, acceleration, floor and chord (the last is found here); c (n + 2,) start with z > 0 at the knots;
    tolerance of what is lost between what is minimised and the bound, relative to the time at the start; a bound of
    `enough` ends it early.
    Returns the bound, its multipliers (points, 2 m, 2), the waits (n,), the least value, status and steps.
    """
    points, count, knots, n = rows.shape[0], rows.shape[1], len(weight), len(c)
    knot = np.empty(points, dtype=np.int64)
    for k in range(knots):
        knot[first[k] : first[k + 1]] = k
    active = np.empty((knots, 4), dtype=np.bool_)
    products = 2 * points * count + relaxation_knots.own_rows(first, low, active)
    tiles = tiled(rows.reshape(points, 3 * count)).reshape(-1, count, 3, TILE)
    dual, step = np.zeros((len(tiles), count, 2, TILE)), np.zeros((len(tiles), count, 2, TILE))
    at, mean_at = np.zeros((len(tiles), STATES, TILE)), np.zeros((len(tiles), 3, TILE))
    affine_at, change_at = np.zeros((len(tiles), 4, TILE)), np.zeros((len(tiles), 4, TILE))
    of_point, best = np.empty((points, 4)), np.zeros((points, count, 2))
    by_point = np.zeros((points, count, 2))
    state, affine, change = np.empty((knots, STATES)), np.empty((knots, 4)), np.empty((knots, 4))
    slack, slope, relaxed = np.empty((knots, 4)), np.empty((knots, 4)), np.empty((knots, 4))
    wait, single, step_single = np.empty(knots), np.zeros((knots, 4)), np.zeros((knots, 4))
    chord, mean, stiff, pull = np.zeros((knots, 2)), np.empty((knots, 3)), np.empty(knots), np.empty(knots)
    pull_centring, pull_second = np.empty(knots), np.empty(knots)
    matrix, spare = np.empty((3, n)), np.empty((3, n))
    rhs, direction, centring, second = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    relaxation_knots.chords(first, low, cap, chord)
    bound, _, _ = dual_value(basis, first, weight, price, low, cap, rows, best, end, ratio, fixed)
    relaxation_knots.at_knots(basis, c, state)
    scale = 0.0
    for k in range(knots):
        scale += weight[k] / np.sqrt(state[k, 0])
    centre = spread * scale / products
    relaxation_knots.first_waits(first, weight, low, chord, rows, relief, state, centre, wait)
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    least = np.inf
    near = NEAR if enough == np.inf else NEAR_ENOUGH
    status, steps = STALLED, most_steps
    for number in range(most_steps + 1):
        relaxation_knots.states(low, cap, chord, relief, tau, wait, state, slack, slope, relaxed)
        relaxation_rows.at_points(first, state, at)
        if number == 0:
            relaxation_knots.start(first, weight, active, slack, centre, single)
            multipliers.start(points, tiles, at, centre, dual)
        matrix[:] = 0.0
        rhs[:] = -price
        relaxation_rows.wait_system(points, tiles, at, dual, of_point)
        own, least = relaxation_knots.eliminate_waits(
            basis, first, weight, active, state, slack, slope, relaxed, single, of_point, matrix, rhs, mean, stiff, pull
        )
        relaxation_rows.at_points(first, mean, mean_at)
        gap = own + relaxation_rows.newton_system(basis, knot, tiles, at, mean_at, dual, matrix, rhs)
        least += c @ price
        if gap < near * scale or number == most_steps:
            relaxation_rows.by_point(dual, by_point)
            value, _, _ = dual_value(basis, first, weight, price, low, cap, rows, by_point, end, ratio, fixed)
            if value > bound:
                bound = value
                best[:] = by_point
            if bound >= enough or (least - bound < tolerance * scale and tau < 1e-9):
                status, steps = CONVERGED, number
                break
            if gap < ROUNDING * tolerance * scale:
                status, steps = BROKEN, number
                break
        if number == most_steps:
            break
        if not factor_tied(matrix, end, ratio, spare):
            status, steps = BROKEN, number
            break
        # predictor: straight at the optimum, to learn how far one can go
        direction[:] = rhs
        solve_tied(matrix, end, ratio, direction)
        relaxation_knots.at_knots(basis, direction, affine)
        relaxation_knots.waits(mean, stiff, pull, affine)
        relaxation_rows.at_points(first, affine, affine_at)
        centring[:], second[:], pull_centring[:], pull_second[:] = 0.0, 0.0, 0.0, 0.0
        falls, grows, linear, square = relaxation_knots.predict(
            basis, active, state, slack, slope, relaxed, single, mean, affine, centring, second, pull_centring,
            pull_second,
        )  # fmt: skip
        falls_rows, grows_rows, linear_rows, square_rows = relaxation_rows.predict(
            basis, knot, tiles, at, mean_at, affine_at, dual, centring, second, pull_centring, pull_second
        )
        left = share_left(
            gap, max(falls, falls_rows), max(grows, grows_rows), linear + linear_rows, square + square_rows
        )
        centre = gap / products * max(min(left, 1.0) ** 3, 1e-8)
        # corrector: centred, with the second-order terms that the predictor revealed
        direction[:] = rhs - centre * centring - second
        pull -= centre * pull_centring + pull_second
        solve_tied(matrix, end, ratio, direction)
        relaxation_knots.at_knots(basis, direction, change)
        relaxation_knots.waits(mean, stiff, pull, change)
        relaxation_rows.at_points(first, change, change_at)
        loss, loss_dual = relaxation_knots.correct(
            active, state, slack, slope, relaxed, single, affine, change, centre, step_single
        )
        loss_rows, loss_dual_rows = multipliers.correct(points, tiles, at, affine_at, change_at, dual, centre, step)
        go = min(1.0, BACK_OFF / max(loss, loss_rows))
        go_dual = min(1.0, BACK_OFF / max(loss_dual, loss_dual_rows))
        go = relaxation_knots.within_chords(active, chord, relief, tau, state, wait, change, go)
        if not (go > 0.0 and go_dual > 0.0):
            status, steps = BROKEN, number
            break
        c += go * direction
        relaxation_knots.at_knots(basis, c, state)
        for k in range(knots):
            wait[k] += go * change[k, 3]
        advance(dual, step, go_dual)
        advance(single, step_single, go_dual)
        tau *= 1.0 - go
    return bound, best, wait, least, status, steps

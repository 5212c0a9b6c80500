"""How fast the optimal planner's problem could be solved at best: a convex relaxation of it.

In the problem of `toolpace.kernels.speed` only the right side of the jerk rows is not convex. Here every knot k has a
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

from toolpace.kernels import relaxedrows
from toolpace.kernels.bound import dual_value
from toolpace.kernels.jit import jit
from toolpace.kernels.newton import factor_tied, solve_tied

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
    ranged = 0
    for k in range(knots):
        ranged += low[k] > 0.0
    products = 2 * points * count + 2 * knots + 2 * ranged
    u, du, affine = np.empty((knots, 3)), np.zeros((knots, 3)), np.zeros((knots, 3))
    wait, dwait, affine_wait = np.empty(knots), np.zeros(knots), np.zeros(knots)
    dual, step, best = np.zeros((points, count, 2)), np.zeros((points, count, 2)), np.zeros((points, count, 2))
    single, step_single, chord = np.zeros((knots, 4)), np.zeros((knots, 4)), np.zeros((knots, 2))
    mean, stiff, pull = np.empty((knots, 3)), np.empty(knots), np.empty(knots)
    matrix, spare = np.empty((3, n)), np.empty((3, n))
    rhs, direction = np.empty(n), np.empty(n)
    relaxedrows.chords(first, low, cap, chord)
    bound, _, _ = dual_value(basis, first, weight, price, low, cap, rows, dual, end, ratio, fixed)
    relaxedrows.at_knots(basis, c, u)
    scale = 0.0
    for k in range(knots):
        scale += weight[k] / np.sqrt(u[k, 0])
    relaxedrows.first_multipliers(
        first, weight, low, cap, chord, rows, relief, u, spread * scale / products, wait, dual, single
    )  # fmt: skip
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    least = np.inf
    near = NEAR if enough == np.inf else NEAR_ENOUGH
    status, steps = STALLED, most_steps
    for number in range(most_steps + 1):
        gap, least = relaxedrows.newton_system(
            basis, first, weight, low, cap, chord, rows, relief, tau, u, wait, dual, single, matrix, rhs, mean, stiff,
            pull, step,
        )  # fmt: skip
        least += c @ price
        rhs -= price
        if gap < near * scale or number == most_steps:
            value, _, _ = dual_value(basis, first, weight, price, low, cap, rows, dual, end, ratio, fixed)
            if value > bound:
                bound = value
                best[:] = dual
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
        direction[:] = rhs
        solve_tied(matrix, end, ratio, direction)
        relaxedrows.at_knots(basis, direction, affine)
        relaxedrows.waits(mean, stiff, pull, affine, affine_wait)
        loss, loss_dual, sum_s, sum_l, sum_sl = relaxedrows.dual_step(
            first, low, cap, chord, rows, relief, tau, u, wait, dual, single, affine, affine_wait, affine, affine_wait,
            0.0, False, step, step_single,
        )  # fmt: skip
        go, go_dual = min(1.0, 1.0 / loss), min(1.0, 1.0 / loss_dual)
        reached = (gap + go_dual * sum_s + go * sum_l + go * go_dual * sum_sl) / gap
        centre = gap / products * max(min(reached, 1.0) ** 3, 1e-8)
        relaxedrows.correct(
            basis, first, low, cap, chord, rows, relief, tau, u, affine, wait, affine_wait, step, step_single, centre,
            mean, rhs, pull,
        )  # fmt: skip
        direction[:] = rhs
        solve_tied(matrix, end, ratio, direction)
        relaxedrows.at_knots(basis, direction, du)
        relaxedrows.waits(mean, stiff, pull, du, dwait)
        loss, loss_dual, sum_s, sum_l, sum_sl = relaxedrows.dual_step(
            first, low, cap, chord, rows, relief, tau, u, wait, dual, single, du, dwait, affine, affine_wait, centre,
            True, step, step_single,
        )  # fmt: skip
        go, go_dual = min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)
        if ranged:
            go = relaxedrows.within_chords(low, chord, relief, tau, u, wait, du, dwait, go)
        if not (go > 0.0 and go_dual > 0.0):
            status, steps = BROKEN, number
            break
        c += go * direction
        relaxedrows.at_knots(basis, c, u)
        wait += go * dwait
        dual += go_dual * step
        single += go_dual * step_single
        tau *= 1.0 - go
    return bound, best, wait, least, status, steps

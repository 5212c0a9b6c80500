"""A convex relaxation of the optimal planner's problem, for its lower bound.

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
primal-dual interior-point method; the wait is eliminated knot by knot, so that the Newton matrix keeps its diagonals.
The derivation is in docs/design/bound.md.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import multipliers, relaxation_knots, relaxation_rows
from toolpace.kernels.optimal.dual import KnotRows, dual_value
from toolpace.kernels.optimal.multipliers import product_aimed_at, share_left
from toolpace.kernels.optimal.newton import aim_at_centre, aim_at_optimum, factor_tied
from toolpace.kernels.optimal.relaxation_knots import at_knots
from toolpace.kernels.optimal.relaxation_rows import at_points
from toolpace.kernels.optimal.relaxation_work import Work, count_of, work_of
from toolpace.kernels.optimal.tiles import advance

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
    knots: KnotRows, low: Floats, cap: Floats, c: Floats, relief: Floats, tolerance: float, enough: float,
    most_steps: int,
) -> tuple[float, Floats, Floats, float, int, int]:  # fmt: skip
    """Multipliers near the optimum of the relaxation, and their bound.

    Parameters: low (n,) 0 where unknown, and cap (n,) of z; c (n + 2,) start with z > 0 at the knots, overwritten by
    the result; relief (n, 4) of cap, acceleration, floor and chord (the last is found here); tolerance of what is lost
    between what is minimised and the bound, relative to the time at the start; a bound of `enough` ends it early.
    Returns the bound, its multipliers (points, 2 m, 2), the waits (n,), the least value, status and steps.
    """
    work = work_of(knots, low, cap, relief)
    points, count = knots.rows.shape[0], knots.rows.shape[1]
    products = 2 * points * count + count_of(work.own)
    best, dual = np.zeros((points, count, 2)), np.zeros((points, count, 2))
    bound, _, _ = dual_value(knots, low, cap, best)
    scale, tau = _start(work, c, products)
    near = NEAR if enough == np.inf else NEAR_ENOUGH
    least, status, steps = np.inf, STALLED, most_steps
    for number in range(most_steps + 1):
        gap, least = _newton_system(work, c)
        if gap < near * scale or number == most_steps:
            relaxation_rows.by_point(work.tiles.dual, dual)
            value, _, _ = dual_value(knots, low, cap, dual)
            if value > bound:
                bound = value
                copy(dual.reshape(-1), best.reshape(-1))
            if bound >= enough or (least - bound < tolerance * scale and tau < 1e-9):
                status, steps = CONVERGED, number
                break
            if gap < ROUNDING * tolerance * scale:
                status, steps = BROKEN, number
                break
        if number == most_steps:
            break
        if not factor_tied(work.system, knots.ends):
            status, steps = BROKEN, number
            break
        centre = product_aimed_at(gap, products, _predictor(work, gap))
        go, go_dual = _corrector(work, tau, centre)
        if not (go > 0.0 and go_dual > 0.0):
            status, steps = BROKEN, number
            break
        _go(work, c, go, go_dual)
        tau *= 1.0 - go
        _evaluate(work, tau)
    return bound, best, work.states.wait, least, status, steps


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
    relaxation_rows.wait_system(work.tiles, points.of_wait)
    gap, value = relaxation_knots.eliminate_waits(knots, work.own, work.states, points.of_wait, system, waits)
    at_points(knots.first, waits.mean, points.mean)
    gap += relaxation_rows.newton_system(knots.basis, points, work.tiles, system)
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
    of_rows = relaxation_rows.predict(knots.basis, work.points, work.tiles, work.row_steps.affine, system, waits)
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

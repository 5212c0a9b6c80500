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

from toolpace.kernels.bound import dual_value
from toolpace.kernels.jit import jit
from toolpace.kernels.pentadiagonal import solve
from toolpace.kernels.speed import _factor_safely, _tie_matrix, _tie_vector, _untie

CONVERGED, STALLED, BROKEN = 0, 1, 2
CAP, WAIT, FLOOR, CHORD = 0, 1, 2, 3
"""The rows of a knot itself, as the columns of their multipliers."""
RELIEF_CAP, RELIEF_ACCELERATION, RELIEF_FLOOR, RELIEF_CHORD = 0, 1, 2, 3
BACK_OFF = 0.99
LEAST_LEFT = 0.005
"""Share of the slack of a chord that a step leaves: it falls below what its tangent says."""
NEAR = 1e-3
"""Gap relative to the time at the start from which the bound is worked out at every step, and the best one kept."""
NEAR_ENOUGH = 0.03
"""The same where any bound beyond a given one will do."""
ROUNDING = 1e-4
"""Gap, as a multiple of what is tolerated, at which further steps only gather rounding."""
MOST_FALL = 0.6
"""Share of z that a step may take at a knot: beyond it the tangent of 1 / sqrt(z) says nothing."""


@jit()
def chords(first: Any, low: Any, cap: Any, chord: Any) -> Any:
    """chord (n, 2): height and fall of the line through 1 / sqrt(z) at low and cap, where a knot has range and rows."""
    for k in range(len(low)):
        if low[k] > 0.0 and first[k] < first[k + 1]:
            a, b = np.sqrt(low[k]), np.sqrt(cap[k])
            chord[k, 1] = 1.0 / (a * b * (a + b))
            chord[k, 0] = 1.0 / a + chord[k, 1] * low[k]


@jit()
def at_knots(basis: Any, c: Any, out: Any) -> Any:
    """out (n, 3): z, z', z'' at the knots."""
    for k in range(len(basis)):
        for d in range(3):
            out[k, d] = basis[k, d, 0] * c[k] + basis[k, d, 1] * c[k + 1] + basis[k, d, 2] * c[k + 2]


@jit()
def _first_multipliers(
    first: Any, weight: Any, low: Any, cap: Any, chord: Any, rows: Any, relief: Any, u: Any, centre: Any, wait: Any,
    dual: Any, single: Any,
) -> Any:  # fmt: skip
    """Waits and multipliers with every product of slack and multiplier equal to `centre`; jerk balances the time.

    Where a chord leaves no room for the wait, it is given relief.
    """
    half = rows.shape[1] // 2
    for k in range(len(weight)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        pace = 1.0 / np.sqrt(z)
        single[k, CAP] = centre / (cap[k] - z + relief[k, RELIEF_CAP])
        if low[k] > 0.0:
            single[k, FLOOR] = centre / (z - low[k] + relief[k, RELIEF_FLOOR])
        if first[k] == first[k + 1]:
            wait[k], single[k, WAIT] = 0.0, weight[k]
            continue
        worst = 0.0
        count = 1
        for p in range(first[k], first[k + 1]):
            for i in range(half, 2 * half):
                worst = max(worst, abs(rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2))
                count += 2
        # the wait at which the multipliers of jerk and wait sum to the weight: Newton on 1 / sum of 1 / slack
        lowest = max(worst - pace, 0.0)
        y = lowest + count * centre / weight[k]
        for _ in range(3):
            total, square = 1.0 / y, 1.0 / (y * y)
            for p in range(first[k], first[k + 1]):
                for i in range(half, 2 * half):
                    value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
                    up, down = 1.0 / (pace + y - value), 1.0 / (pace + y + value)
                    total += up + down
                    square += up * up + down * down
            y = max(y + (centre / weight[k] * total - 1.0) * total / square, lowest + 0.1 * (y - lowest))
        if low[k] > 0.0:
            room = chord[k, 0] - chord[k, 1] * z - pace
            if room > 1.1 * lowest:
                y = min(y, 0.5 * (room + lowest))
            if room < 1.1 * y:
                relief[k, RELIEF_CHORD] = 1.5 * y - room + 0.01 * pace
            single[k, CHORD] = centre / (room - y + relief[k, RELIEF_CHORD])
        wait[k] = y
        single[k, WAIT] = centre / y
        for p in range(first[k], first[k + 1]):
            for i in range(2 * half):
                value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
                limit = 1.0 + relief[k, RELIEF_ACCELERATION] if i < half else pace + y
                dual[p, i, 0] = centre / (limit - value)
                dual[p, i, 1] = centre / (limit + value)


@jit()
def _newton_system(
    basis: Any, first: Any, weight: Any, low: Any, cap: Any, chord: Any, rows: Any, relief: Any, tau: Any, u: Any,
    wait: Any, dual: Any, single: Any, matrix: Any, rhs: Any, mean: Any, stiff: Any, pull: Any, force: Any,
) -> Any:  # fmt: skip
    """Newton matrix and right-hand side for a centring of zero, wait eliminated; returns gap and relaxed time.

    The jerk rows of a knot and its wait share one unknown: what is left after its elimination is the scatter of
    their gradients about their mean, which is summed as such, since the difference of two large sums would drown.
    mean (n, 3) and stiff (n,) are that mean and the sum of weights, pull (n,) what the waits are pulled down by;
    force (points, rows, 2) is room for the weights.
    """
    half = rows.shape[1] // 2
    matrix[:] = 0.0
    rhs[:] = 0.0
    gap = 0.0
    time = 0.0
    moment = np.empty((3, 3))
    for k in range(len(weight)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        limit = pace + wait[k]
        relax_cap, allowed = tau * relief[k, RELIEF_CAP], 1.0 + tau * relief[k, RELIEF_ACCELERATION]
        slack = cap[k] - z + relax_cap
        cap_force = single[k, CAP] / slack
        gap += slack * single[k, CAP] + wait[k] * single[k, WAIT]
        time += weight[k] * limit
        bare = first[k] == first[k + 1]
        wait_force = 0.0 if bare else single[k, WAIT] / wait[k]
        total, v0, v1, v2 = 1.0 if bare else wait_force, 0.0, 0.0, 0.0
        pulled = 0.0 if bare else weight[k]
        floor_force = floor_pull = chord_force = chord_pull = lean = 0.0
        if low[k] > 0.0:
            relax_floor = tau * relief[k, RELIEF_FLOOR]
            slack = z - low[k] + relax_floor
            floor_force = single[k, FLOOR] / slack
            floor_pull = floor_force * relax_floor
            gap += slack * single[k, FLOOR]
        if low[k] > 0.0 and not bare:
            relax_chord = tau * relief[k, RELIEF_CHORD]
            slack = chord[k, 0] - chord[k, 1] * z - limit + relax_chord
            chord_force = single[k, CHORD] / slack
            chord_pull = chord_force * relax_chord
            gap += slack * single[k, CHORD]
            lean = tangent - chord[k, 1]
            total += chord_force
            v0 += chord_force * lean
            pulled += chord_pull
        for p in range(first[k], first[k + 1]):
            for i in range(half, 2 * half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                value = b0 * z + b1 * z1 + b2 * z2
                up, down = limit - value, limit + value
                lup, ldown = dual[p, i, 0], dual[p, i, 1]
                wup, wdown = lup / up, ldown / down
                gap += up * lup + down * ldown
                force[p, i, 0], force[p, i, 1] = wup, wdown
                both, odd = wup + wdown, wup - wdown
                total += both
                v0 += odd * b0 + both * tangent
                v1 += odd * b1
                v2 += odd * b2
        a0, a1, a2 = v0 / total, v1 / total, v2 / total
        mean[k, 0], mean[k, 1], mean[k, 2], stiff[k], pull[k] = a0, a1, a2, total, pulled
        m00 = cap_force + floor_force + wait_force * a0 * a0 + 1.5 * tangent / z * single[k, WAIT]
        m00 += chord_force * (lean - a0) ** 2
        m01, m02 = wait_force * a0 * a1, wait_force * a0 * a2
        m11, m12, m22 = wait_force * a1 * a1, wait_force * a1 * a2, wait_force * a2 * a2
        m01 -= chord_force * (lean - a0) * a1
        m02 -= chord_force * (lean - a0) * a2
        m11 += chord_force * a1 * a1
        m12 += chord_force * a1 * a2
        m22 += chord_force * a2 * a2
        g0 = cap_force * relax_cap - floor_pull - weight[k] * tangent + pulled * a0 - chord_pull * lean
        g1, g2 = pulled * a1, pulled * a2
        extra = allowed - 1.0
        e0 = tangent - a0
        for p in range(first[k], first[k + 1]):
            for i in range(half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                value = b0 * z + b1 * z1 + b2 * z2
                up, down = allowed - value, allowed + value
                lup, ldown = dual[p, i, 0], dual[p, i, 1]
                wup, wdown = lup / up, ldown / down
                gap += up * lup + down * ldown
                force[p, i, 0], force[p, i, 1] = wup, wdown
                both, odd = wup + wdown, wup - wdown
                m00 += both * b0 * b0
                m01 += both * b0 * b1
                m02 += both * b0 * b2
                m11 += both * b1 * b1
                m12 += both * b1 * b2
                m22 += both * b2 * b2
                g0 += extra * odd * b0
                g1 += extra * odd * b1
                g2 += extra * odd * b2
            for i in range(half, 2 * half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                wup, wdown = force[p, i, 0], force[p, i, 1]
                p0, p1, p2 = e0 + b0, b1 - a1, b2 - a2
                n0, n1, n2 = e0 - b0, -b1 - a1, -b2 - a2
                m00 += wup * p0 * p0 + wdown * n0 * n0
                m01 += wup * p0 * p1 + wdown * n0 * n1
                m02 += wup * p0 * p2 + wdown * n0 * n2
                m11 += wup * p1 * p1 + wdown * n1 * n1
                m12 += wup * p1 * p2 + wdown * n1 * n2
                m22 += wup * p2 * p2 + wdown * n2 * n2
        moment[0, 0], moment[0, 1], moment[0, 2] = m00, m01, m02
        moment[1, 0], moment[1, 1], moment[1, 2] = m01, m11, m12
        moment[2, 0], moment[2, 1], moment[2, 2] = m02, m12, m22
        for i in range(3):
            c0, c1, c2 = basis[k, 0, i], basis[k, 1, i], basis[k, 2, i]
            t0 = c0 * m00 + c1 * m01 + c2 * m02
            t1 = c0 * m01 + c1 * m11 + c2 * m12
            t2 = c0 * m02 + c1 * m12 + c2 * m22
            for j in range(i, 3):
                matrix[j - i, k + i] += t0 * basis[k, 0, j] + t1 * basis[k, 1, j] + t2 * basis[k, 2, j]
            rhs[k + i] -= c0 * g0 + c1 * g1 + c2 * g2
    return gap, time


@jit()
def _correct(
    basis: Any, first: Any, low: Any, cap: Any, chord: Any, rows: Any, relief: Any, tau: Any, u: Any, du: Any,
    wait: Any, dwait: Any, step: Any, step_single: Any, centre: Any, mean: Any, rhs: Any, pull: Any,
) -> Any:  # fmt: skip
    """Add to rhs, and take from pull, what centring and the second-order terms of the affine step ask for."""
    half = rows.shape[1] // 2
    for k in range(len(wait)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        d0, d1, d2, dy = du[k, 0], du[k, 1], du[k, 2], dwait[k]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        limit = pace + wait[k]
        relax_cap, extra = tau * relief[k, RELIEF_CAP], tau * relief[k, RELIEF_ACCELERATION]
        g0 = (centre + step_single[k, CAP] * (d0 + relax_cap)) / (cap[k] - z + relax_cap)
        bare = first[k] == first[k + 1]
        target = 0.0 if bare else (centre - step_single[k, WAIT] * dy) / wait[k]
        a0, a1, a2 = mean[k, 0], mean[k, 1], mean[k, 2]
        if low[k] > 0.0:
            relax_floor = tau * relief[k, RELIEF_FLOOR]
            g0 -= (centre - step_single[k, FLOOR] * (d0 - relax_floor)) / (z - low[k] + relax_floor)
        if low[k] > 0.0 and not bare:
            relax_chord = tau * relief[k, RELIEF_CHORD]
            lean = tangent - chord[k, 1]
            slack = chord[k, 0] - chord[k, 1] * z - limit + relax_chord
            push = (centre - step_single[k, CHORD] * (lean * d0 - dy - relax_chord)) / slack
            g0 -= push * lean
            target -= push
        g0 -= target * a0
        g1 = -target * a1
        g2 = -target * a2
        total = target
        for p in range(first[k], first[k + 1]):
            for i in range(half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                value = b0 * z + b1 * z1 + b2 * z2
                move = b0 * d0 + b1 * d1 + b2 * d2
                gup = (centre + step[p, i, 0] * (move + extra)) / (1.0 + extra - value)
                gdown = (centre + step[p, i, 1] * (extra - move)) / (1.0 + extra + value)
                g0 += (gup - gdown) * b0
                g1 += (gup - gdown) * b1
                g2 += (gup - gdown) * b2
            for i in range(half, 2 * half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                value = b0 * z + b1 * z1 + b2 * z2
                move = b0 * d0 + b1 * d1 + b2 * d2
                rest = tangent * d0 - dy
                gup = (centre + step[p, i, 0] * (rest + move)) / (limit - value)
                gdown = (centre + step[p, i, 1] * (rest - move)) / (limit + value)
                total += gup + gdown
                g0 += gup * (tangent + b0 - a0) + gdown * (tangent - b0 - a0)
                g1 += gup * (b1 - a1) - gdown * (b1 + a1)
                g2 += gup * (b2 - a2) - gdown * (b2 + a2)
        pull[k] -= total
        for i in range(3):
            rhs[k + i] -= basis[k, 0, i] * g0 + basis[k, 1, i] * g1 + basis[k, 2, i] * g2


@jit()
def _waits(mean: Any, stiff: Any, pull: Any, du: Any, dwait: Any) -> Any:
    """The change of the waits that belongs to a change du of z, z', z''."""
    for k in range(len(stiff)):
        dwait[k] = mean[k, 0] * du[k, 0] + mean[k, 1] * du[k, 1] + mean[k, 2] * du[k, 2] - pull[k] / stiff[k]


@jit()
def _dual_step(
    first: Any, low: Any, cap: Any, chord: Any, rows: Any, relief: Any, tau: Any, u: Any, wait: Any, dual: Any,
    single: Any, du: Any, dwait: Any, affine: Any, affine_wait: Any, centre: Any, corrected: Any, step: Any,
    step_single: Any,
) -> Any:  # fmt: skip
    """Steps of the multipliers for the primal step (du, dwait); (affine, affine_wait) is that of the predictor.

    Returns the largest relative losses of slack and of multiplier, and the three sums that give the gap after a step.
    """
    half = rows.shape[1] // 2
    loss = loss_dual = 0.0
    sum_s = sum_l = sum_sl = 0.0
    slacks, changes, befores = np.empty(4), np.empty(4), np.empty(4)
    for k in range(len(wait)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        d0, d1, d2, dy = du[k, 0], du[k, 1], du[k, 2], dwait[k]
        f0, f1, f2, fy = affine[k, 0], affine[k, 1], affine[k, 2], affine_wait[k]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        relax = tau * relief[k, RELIEF_ACCELERATION]
        loss = max(loss, -d0 / (MOST_FALL * z))
        # slack, its change in this step, and that of the predictor
        slacks[CAP] = cap[k] - z + tau * relief[k, RELIEF_CAP]
        changes[CAP] = -d0 - tau * relief[k, RELIEF_CAP]
        befores[CAP] = -f0 - tau * relief[k, RELIEF_CAP]
        slacks[WAIT], changes[WAIT], befores[WAIT] = wait[k], dy, fy
        if low[k] > 0.0:
            slacks[FLOOR] = z - low[k] + tau * relief[k, RELIEF_FLOOR]
            changes[FLOOR] = d0 - tau * relief[k, RELIEF_FLOOR]
            befores[FLOOR] = f0 - tau * relief[k, RELIEF_FLOOR]
            lean = tangent - chord[k, 1]
            slacks[CHORD] = chord[k, 0] - chord[k, 1] * z - pace - wait[k] + tau * relief[k, RELIEF_CHORD]
            changes[CHORD] = lean * d0 - dy - tau * relief[k, RELIEF_CHORD]
            befores[CHORD] = lean * f0 - fy - tau * relief[k, RELIEF_CHORD]
        bare = first[k] == first[k + 1]
        for i in range(4 if low[k] > 0.0 else 2):
            if bare and i != CAP and i != FLOOR:
                continue
            lam = single[k, i]
            target = centre - step_single[k, i] * befores[i] if corrected else 0.0
            dlam = (target - lam * changes[i]) / slacks[i] - lam
            loss, loss_dual = max(loss, -changes[i] / slacks[i]), max(loss_dual, -dlam / lam)
            sum_s += slacks[i] * dlam
            sum_l += lam * changes[i]
            sum_sl += changes[i] * dlam
            step_single[k, i] = dlam
        for p in range(first[k], first[k + 1]):
            for i in range(2 * half):
                b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
                value = b0 * z + b1 * z1 + b2 * z2
                move = b0 * d0 + b1 * d1 + b2 * d2
                moved = b0 * f0 + b1 * f1 + b2 * f2
                if i < half:
                    limit, common, before = 1.0 + relax, -relax, -relax
                else:
                    limit, common, before = pace + wait[k], dy - tangent * d0, fy - tangent * f0
                for side in range(2):
                    sign = 1.0 if side == 0 else -1.0
                    lam = dual[p, i, side]
                    inverse = 1.0 / (limit - sign * value)
                    change = common - sign * move
                    target = centre - step[p, i, side] * (before - sign * moved) if corrected else 0.0
                    dlam = (target - lam * change) * inverse - lam
                    loss = max(loss, -change * inverse)
                    loss_dual = max(loss_dual, -dlam / lam)
                    sum_s += (limit - sign * value) * dlam
                    sum_l += lam * change
                    sum_sl += change * dlam
                    step[p, i, side] = dlam
    return loss, loss_dual, sum_s, sum_l, sum_sl


@jit()
def _room(chord: Any, relaxed: Any, z: Any, wait: Any) -> Any:
    """What is left of the chord of a knot, relief included."""
    return chord[0] - chord[1] * z - 1.0 / np.sqrt(z) - wait + relaxed


@jit()
def _within_chords(
    low: Any, chord: Any, relief: Any, tau: Any, u: Any, wait: Any, du: Any, dwait: Any, go: Any,
) -> Any:  # fmt: skip
    """The longest of go, go / 2, ... after which every chord has some room left."""
    k = 0
    while k < len(low) and go > 1e-12:
        if low[k] > 0.0 and chord[k, 0] > 0.0:
            relaxed = tau * relief[k, RELIEF_CHORD]
            before = _room(chord[k], relaxed, u[k, 0], wait[k])
            after = _room(chord[k], (1.0 - go) * relaxed, u[k, 0] + go * du[k, 0], wait[k] + go * dwait[k])
            if not after > LEAST_LEFT * before:
                go *= 0.5
                k = -1
        k += 1
    return go


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
    chords(first, low, cap, chord)
    bound, _, _ = dual_value(basis, first, weight, price, low, cap, rows, dual, end, ratio, fixed)
    at_knots(basis, c, u)
    scale = 0.0
    for k in range(knots):
        scale += weight[k] / np.sqrt(u[k, 0])
    _first_multipliers(
        first, weight, low, cap, chord, rows, relief, u, spread * scale / products, wait, dual, single
    )  # fmt: skip
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    least = np.inf
    near = NEAR if enough == np.inf else NEAR_ENOUGH
    status, steps = STALLED, most_steps
    for number in range(most_steps + 1):
        gap, least = _newton_system(
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
        _tie_matrix(matrix, end, ratio)
        if not _factor_safely(matrix, spare):
            status, steps = BROKEN, number
            break
        direction[:] = rhs
        _tie_vector(direction, end, ratio)
        solve(matrix, direction)
        _untie(direction, end, ratio)
        at_knots(basis, direction, affine)
        _waits(mean, stiff, pull, affine, affine_wait)
        loss, loss_dual, sum_s, sum_l, sum_sl = _dual_step(
            first, low, cap, chord, rows, relief, tau, u, wait, dual, single, affine, affine_wait, affine, affine_wait,
            0.0, False, step, step_single,
        )  # fmt: skip
        go, go_dual = min(1.0, 1.0 / loss), min(1.0, 1.0 / loss_dual)
        reached = (gap + go_dual * sum_s + go * sum_l + go * go_dual * sum_sl) / gap
        centre = gap / products * max(min(reached, 1.0) ** 3, 1e-8)
        _correct(
            basis, first, low, cap, chord, rows, relief, tau, u, affine, wait, affine_wait, step, step_single, centre,
            mean, rhs, pull,
        )  # fmt: skip
        direction[:] = rhs
        _tie_vector(direction, end, ratio)
        solve(matrix, direction)
        _untie(direction, end, ratio)
        at_knots(basis, direction, du)
        _waits(mean, stiff, pull, du, dwait)
        loss, loss_dual, sum_s, sum_l, sum_sl = _dual_step(
            first, low, cap, chord, rows, relief, tau, u, wait, dual, single, du, dwait, affine, affine_wait, centre,
            True, step, step_single,
        )  # fmt: skip
        go, go_dual = min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)
        if ranged:
            go = _within_chords(low, chord, relief, tau, u, wait, du, dwait, go)
        if not (go > 0.0 and go_dual > 0.0):
            status, steps = BROKEN, number
            break
        c += go * direction
        at_knots(basis, c, u)
        wait += go * dwait
        dual += go_dual * step
        single += go_dual * step_single
        tau *= 1.0 - go
    return bound, best, wait, least, status, steps

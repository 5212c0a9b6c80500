"""How fast the optimal planner's problem could be solved at best: a convex relaxation of it, and its dual function.

In the problem of `toolpace.kernels.speed` only the right side of the jerk rows is not convex. Here every knot k has a
wait y_k >= 0 as well, a time that it may stand still for at the price of that time:

    minimise    sum_k w_k (1 / sqrt(z_k) + y_k)
    subject to  z_k <= cap_k
                |r . (z, z', z'')_k| <= 1                                acceleration rows
                |r . (z, z', z'')_k| <= 1 / sqrt(z_k) + y_k              jerk rows

With the pace 1 / sqrt(z_k) + y_k as the variable this is convex, and y = 0 gives the problem itself. `relax` finds
multipliers near its optimum by a primal-dual interior-point method; the wait is eliminated knot by knot, so that the
Newton matrix keeps five diagonals. `dual_value` turns any multipliers, good or bad, into a bound of the problem. The
derivation is in docs/design/bound.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.pentadiagonal import solve
from toolpace.kernels.speed import REST, _factor_safely, _tie_matrix, _tie_vector, _untie

CONVERGED, STALLED, BROKEN = 0, 1, 2
BACK_OFF = 0.99
NEAR = 1e-3
"""Gap relative to the time from which the bound is worked out at every step, and the best one kept."""
ROUNDING = 1e-4
"""Gap, as a multiple of the tolerance, at which further steps only gather rounding."""
MOST_FALL = 0.6
"""Share of z that a step may take at a knot: beyond it the tangent of 1 / sqrt(z) says nothing."""
UNIT = 2.0**-53
"""Largest relative error of one rounding."""


@jit()
def at_knots(basis: Any, c: Any, out: Any) -> Any:
    """out (n, 3): z, z', z'' at the knots."""
    for k in range(len(basis)):
        for d in range(3):
            out[k, d] = basis[k, d, 0] * c[k] + basis[k, d, 1] * c[k + 1] + basis[k, d, 2] * c[k + 2]


@jit()
def _first_multipliers(
    first: Any, weight: Any, cap: Any, rows: Any, relief: Any, u: Any, centre: Any, wait: Any, dual: Any,
    dual_cap: Any, dual_wait: Any,
) -> Any:  # fmt: skip
    """Waits and multipliers with every product of slack and multiplier equal to `centre`; jerk balances the time."""
    half = rows.shape[1] // 2
    for k in range(len(weight)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        pace = 1.0 / np.sqrt(z)
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
        wait[k] = y
        dual_wait[k] = centre / y
        dual_cap[k] = centre / (cap[k] - z + relief[k, 0])
        for p in range(first[k], first[k + 1]):
            for i in range(2 * half):
                value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
                limit = 1.0 + relief[k, 1] if i < half else pace + y
                dual[p, i, 0] = centre / (limit - value)
                dual[p, i, 1] = centre / (limit + value)


@jit()
def _newton_system(
    basis: Any, first: Any, weight: Any, cap: Any, rows: Any, relief: Any, tau: Any, u: Any, wait: Any, dual: Any,
    dual_cap: Any, dual_wait: Any, matrix: Any, rhs: Any, mean: Any, stiff: Any, force: Any,
) -> Any:  # fmt: skip
    """Newton matrix and right-hand side for a centring of zero, wait eliminated; returns gap and relaxed time.

    The jerk rows of a knot and its wait share one unknown: what is left after its elimination is the scatter of
    their gradients about their mean, which is summed as such, since the difference of two large sums would drown.
    mean (n, 3) and stiff (n,) are that mean and the sum of weights; force (points, rows, 2) is room for the weights.
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
        relax_cap, allowed = tau * relief[k, 0], 1.0 + tau * relief[k, 1]
        slack = cap[k] - z + relax_cap
        cap_force = dual_cap[k] / slack
        gap += slack * dual_cap[k] + wait[k] * dual_wait[k]
        time += weight[k] * limit
        wait_force = dual_wait[k] / wait[k]
        total, v0, v1, v2 = wait_force, 0.0, 0.0, 0.0
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
        mean[k, 0], mean[k, 1], mean[k, 2], stiff[k] = a0, a1, a2, total
        m00 = cap_force + wait_force * a0 * a0 + 1.5 * tangent / z * dual_wait[k]
        m01, m02 = wait_force * a0 * a1, wait_force * a0 * a2
        m11, m12, m22 = wait_force * a1 * a1, wait_force * a1 * a2, wait_force * a2 * a2
        g0 = cap_force * relax_cap - weight[k] * tangent + weight[k] * a0
        g1, g2 = weight[k] * a1, weight[k] * a2
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
    basis: Any, first: Any, weight: Any, cap: Any, rows: Any, relief: Any, tau: Any, u: Any, du: Any, wait: Any,
    dwait: Any, step: Any, step_cap: Any, step_wait: Any, centre: Any, mean: Any, rhs: Any, pull: Any,
) -> Any:  # fmt: skip
    """Add to rhs what centring and the second-order terms of the affine step ask for; pull (n,): of the waits."""
    half = rows.shape[1] // 2
    for k in range(len(weight)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        d0, d1, d2, dy = du[k, 0], du[k, 1], du[k, 2], dwait[k]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        limit = pace + wait[k]
        relax_cap, extra = tau * relief[k, 0], tau * relief[k, 1]
        g0 = (centre + step_cap[k] * (d0 + relax_cap)) / (cap[k] - z + relax_cap)
        g1, g2 = 0.0, 0.0
        target = (centre - step_wait[k] * dy) / wait[k]
        a0, a1, a2 = mean[k, 0], mean[k, 1], mean[k, 2]
        g0 -= target * a0
        g1 -= target * a1
        g2 -= target * a2
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
        pull[k] = weight[k] - total
        for i in range(3):
            rhs[k + i] -= basis[k, 0, i] * g0 + basis[k, 1, i] * g1 + basis[k, 2, i] * g2


@jit()
def _waits(mean: Any, stiff: Any, pull: Any, du: Any, dwait: Any) -> Any:
    """The change of the waits that belongs to a change du of z, z', z''."""
    for k in range(len(stiff)):
        dwait[k] = mean[k, 0] * du[k, 0] + mean[k, 1] * du[k, 1] + mean[k, 2] * du[k, 2] - pull[k] / stiff[k]


@jit()
def _dual_step(
    first: Any, cap: Any, rows: Any, relief: Any, tau: Any, u: Any, wait: Any, dual: Any, dual_cap: Any,
    dual_wait: Any, du: Any, dwait: Any, affine: Any, affine_wait: Any, centre: Any, corrected: Any, step: Any,
    step_cap: Any, step_wait: Any,
) -> Any:  # fmt: skip
    """Steps of the multipliers for the primal step (du, dwait); (affine, affine_wait) is that of the predictor.

    Returns the largest relative losses of slack and of multiplier, and the three sums that give the gap after a step.
    """
    half = rows.shape[1] // 2
    loss = loss_dual = 0.0
    sum_s = sum_l = sum_sl = 0.0
    for k in range(len(wait)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        d0, d1, d2, dy = du[k, 0], du[k, 1], du[k, 2], dwait[k]
        f0, f1, f2, fy = affine[k, 0], affine[k, 1], affine[k, 2], affine_wait[k]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        relax_cap, relax = tau * relief[k, 0], tau * relief[k, 1]
        loss = max(loss, -d0 / (MOST_FALL * z))
        slack, lam, change = cap[k] - z + relax_cap, dual_cap[k], -d0 - relax_cap
        target = centre + step_cap[k] * (f0 + relax_cap) if corrected else 0.0
        dlam = (target - lam * change) / slack - lam
        loss, loss_dual = max(loss, -change / slack), max(loss_dual, -dlam / lam)
        sum_s += slack * dlam
        sum_l += lam * change
        sum_sl += change * dlam
        step_cap[k] = dlam
        slack, lam = wait[k], dual_wait[k]
        target = centre - step_wait[k] * fy if corrected else 0.0
        dlam = (target - lam * dy) / slack - lam
        loss, loss_dual = max(loss, -dy / slack), max(loss_dual, -dlam / lam)
        sum_s += slack * dlam
        sum_l += lam * dy
        sum_sl += dy * dlam
        step_wait[k] = dlam
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
def lowest(kappa: Any, theta: Any, low: Any, high: Any) -> Any:
    """The least of kappa / sqrt(z) + theta z over low <= z <= high, low < z where low is zero."""
    if low > 0.0:
        best = min(kappa / np.sqrt(low) + theta * low, kappa / np.sqrt(high) + theta * high)
    elif kappa < 0.0:
        return -np.inf
    else:
        best = kappa / np.sqrt(high) + theta * high
        if kappa == 0.0:
            best = min(best, 0.0)
    if kappa > 0.0 and theta > 0.0:
        z = (0.5 * kappa / theta) ** (2.0 / 3.0)
        if low < z < high:
            best = min(best, kappa / np.sqrt(z) + theta * z)
    return best


@jit()
def _transposed(basis: Any, end: Any, ratio: Any, b: Any, sign: Any) -> Any:
    """Overwrite b (n,) by the solution of A' x = b, A the values at the knots of the free coefficients.

    Knot k owns coefficient k + 1; at an end in motion the outermost knot owns none, and its entry is left at zero.
    `sign` -1 solves with the signs of the neighbours turned: A is totally positive, so that its inverse has the
    signs of a chess board, and that solution for b >= 0 is |A^-1|' b.
    """
    n = len(b)
    low = 0 if end[0] == REST else 1
    high = n - 1 if end[1] == REST else n - 2
    diagonal = np.empty(n)
    for k in range(low, high + 1):
        diagonal[k] = basis[k, 0, 1]
        if k == 0:
            diagonal[k] += basis[k, 0, 0] / ratio[0]
        if k == n - 1:
            diagonal[k] += basis[k, 0, 2] / ratio[1]
    for k in range(low, high):
        # row k of A' has basis[k + 1, 0, 0] to the right, row k + 1 has basis[k, 0, 2] to the left
        factor = sign * basis[k, 0, 2] / diagonal[k]
        diagonal[k + 1] -= factor * sign * basis[k + 1, 0, 0]
        b[k + 1] -= factor * b[k]
    for k in range(high, low - 1, -1):
        if k < high:
            b[k] -= sign * basis[k + 1, 0, 0] * b[k + 1]
        b[k] /= diagonal[k]
    for k in range(n):
        if k < low or k > high:
            b[k] = 0.0


@jit()
def dual_value(
    basis: Any, first: Any, weight: Any, low: Any, high: Any, rows: Any, dual: Any, end: Any, ratio: Any, fixed: Any,
) -> Any:  # fmt: skip
    """A lower bound of sum weight / sqrt(z) over all feasible z with low <= z <= high at the knots.

    Parameters: basis (n, 3, 3) of the knots; first (n + 1,) point of each knot; weight, low, high (n,); rows (points,
    2 m, 3) as in `speed.maximise_speed`; dual (points, 2 m, 2) any multipliers >= 0; end, ratio (2,) as there; fixed
    (4,) the two outermost coefficients on either side, where that end is in motion.
    The multipliers of jerk of a knot are lowered where they outweigh the time and z may come close to zero. Rounding
    is charged: the result holds for the arrays as they are given. Returns the bound, kappa (n,) and theta (n,): what
    remains of the time's weight at a knot, and the price of z there.
    """
    n, count = len(weight), rows.shape[1]
    half = count // 2
    force, size = np.zeros(n + 2), np.zeros(n + 2)
    kappa = np.empty(n)
    total = 0.0
    scale = 0.0
    for k in range(n):
        g0 = g1 = g2 = 0.0
        s0 = s1 = s2 = 0.0
        reverse = 0.0
        for p in range(first[k], first[k + 1]):
            for i in range(half, count):
                reverse += dual[p, i, 0] + dual[p, i, 1]
        rounding = 8.0 * (count * (first[k + 1] - first[k]) + 4) * UNIT
        share = 1.0
        given = (k == 0 and end[0] != REST) or (k == n - 1 and end[1] != REST)
        if not (given or low[k] > 0.0) and reverse > weight[k] * (1.0 - rounding):
            share = weight[k] * (1.0 - 2.0 * rounding) / reverse
        kappa[k] = weight[k] - share * reverse - rounding * max(weight[k], share * reverse)
        for p in range(first[k], first[k + 1]):
            for i in range(count):
                up, down = dual[p, i, 0], dual[p, i, 1]
                if i < half:
                    total -= up + down
                    scale += up + down
                else:
                    up, down = share * up, share * down
                g0 += (up - down) * rows[p, i, 0]
                g1 += (up - down) * rows[p, i, 1]
                g2 += (up - down) * rows[p, i, 2]
                s0 += (up + down) * abs(rows[p, i, 0])
                s1 += (up + down) * abs(rows[p, i, 1])
                s2 += (up + down) * abs(rows[p, i, 2])
        for j in range(3):
            b0, b1, b2 = basis[k, 0, j], basis[k, 1, j], basis[k, 2, j]
            force[k + j] += b0 * g0 + b1 * g1 + b2 * g2
            size[k + j] += abs(b0) * s0 + abs(b1) * s1 + abs(b2) * s2
    points = 2.0 * (count + 8)
    first_knot, last_knot = 0, n - 1
    theta, error = np.empty(n), np.empty(n)
    if end[0] == REST:
        force[1] += force[0] / ratio[0]
        size[1] += size[0] / ratio[0]
    else:
        first_knot = 1
        total += force[0] * fixed[0] + force[1] * fixed[1]
        scale += points * (size[0] * abs(fixed[0]) + size[1] * abs(fixed[1]))
    if end[1] == REST:
        force[n] += force[n + 1] / ratio[1]
        size[n] += size[n + 1] / ratio[1]
    else:
        last_knot = n - 2
        total += force[n] * fixed[2] + force[n + 1] * fixed[3]
        scale += points * (size[n] * abs(fixed[2]) + size[n + 1] * abs(fixed[3]))
    theta[:] = force[1 : n + 1]
    _transposed(basis, end, ratio, theta, 1.0)
    # rounding of the right-hand side and of the solution, which is backward stable entry by entry
    for k in range(first_knot, last_knot + 1):
        back = basis[k, 0, 1] * abs(theta[k])
        if k == 0:
            back += basis[k, 0, 0] / ratio[0] * abs(theta[k])
        if k == n - 1:
            back += basis[k, 0, 2] / ratio[1] * abs(theta[k])
        if k > first_knot:
            back += basis[k - 1, 0, 2] * abs(theta[k - 1])
        if k < last_knot:
            back += basis[k + 1, 0, 0] * abs(theta[k + 1])
        error[k] = UNIT * (2.0 * points * size[k + 1] + 16.0 * back)
    _transposed(basis, end, ratio, error, -1.0)
    for k in range(first_knot, last_knot + 1):
        value = lowest(kappa[k], theta[k] - 2.0 * error[k], low[k], high[k])
        total += value
        scale += abs(value)
    if end[0] != REST:
        shift = theta[1] * basis[1, 0, 0] * fixed[1] if last_knot >= 1 else 0.0
        value = kappa[0] / np.sqrt(fixed[0])
        total += value - shift
        scale += abs(value) + points * abs(shift)
        if last_knot >= 1:
            total -= 2.0 * error[1] * abs(basis[1, 0, 0] * fixed[1])
    if end[1] != REST:
        shift = theta[n - 2] * basis[n - 2, 0, 2] * fixed[2] if last_knot >= first_knot else 0.0
        value = kappa[n - 1] / np.sqrt(fixed[3])
        total += value - shift
        scale += abs(value) + points * abs(shift)
        if last_knot >= first_knot:
            total -= 2.0 * error[n - 2] * abs(basis[n - 2, 0, 2] * fixed[2])
    return total - (n * (count + 4)) * UNIT * scale, kappa, theta


@jit()
def relax(
    basis: Any, first: Any, weight: Any, cap: Any, rows: Any, c: Any, relief: Any, end: Any, ratio: Any, fixed: Any,
    spread: Any, tolerance: Any, most_steps: Any,
) -> Any:  # fmt: skip
    """Multipliers near the optimum of the relaxation, and their bound.

    Parameters as of `dual_value` and `speed.maximise_speed`, cap, weight and relief (n, 2), of cap and acceleration,
    by knot; c (n + 2,) start with z > 0 at the knots; tolerance of what is lost between the relaxed time and the
    bound, relative to the time.
    Returns the bound, its multipliers (points, 2 m, 2), the waits (n,), the relaxed time, status and steps.
    """
    points, count, knots, n = rows.shape[0], rows.shape[1], len(weight), len(c)
    products = 2 * points * count + 2 * knots
    u, du, affine = np.empty((knots, 3)), np.zeros((knots, 3)), np.zeros((knots, 3))
    wait, dwait, affine_wait = np.empty(knots), np.zeros(knots), np.zeros(knots)
    dual, step = np.zeros((points, count, 2)), np.zeros((points, count, 2))
    dual_cap, step_cap = np.empty(knots), np.zeros(knots)
    dual_wait, step_wait = np.empty(knots), np.zeros(knots)
    mean, stiff, pull = np.empty((knots, 3)), np.empty(knots), np.empty(knots)
    matrix, spare = np.empty((3, n)), np.empty((3, n))
    rhs, direction = np.empty(n), np.empty(n)
    none = np.zeros(knots)
    bound, _, _ = dual_value(basis, first, weight, none, cap, rows, dual, end, ratio, fixed)
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    at_knots(basis, c, u)
    start = 0.0
    for k in range(knots):
        start += weight[k] / np.sqrt(u[k, 0])
    _first_multipliers(
        first, weight, cap, rows, relief, u, spread * start / products, wait, dual, dual_cap, dual_wait
    )  # fmt: skip
    gap, time = np.inf, start
    status, steps = STALLED, most_steps
    for number in range(most_steps + 1):
        gap, time = _newton_system(
            basis, first, weight, cap, rows, relief, tau, u, wait, dual, dual_cap, dual_wait, matrix, rhs, mean,
            stiff, step,
        )  # fmt: skip
        if gap < NEAR * time or number == most_steps:
            value, _, _ = dual_value(basis, first, weight, none, cap, rows, dual, end, ratio, fixed)
            bound = max(bound, value)
            if time - bound < tolerance * time and tau < 1e-9:
                status, steps = CONVERGED, number
                break
            if gap < ROUNDING * tolerance * time:
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
        pull[:] = weight
        _waits(mean, stiff, pull, affine, affine_wait)
        loss, loss_dual, sum_s, sum_l, sum_sl = _dual_step(
            first, cap, rows, relief, tau, u, wait, dual, dual_cap, dual_wait, affine, affine_wait, affine,
            affine_wait, 0.0, False, step, step_cap, step_wait,
        )  # fmt: skip
        go, go_dual = min(1.0, 1.0 / loss), min(1.0, 1.0 / loss_dual)
        reached = (gap + go_dual * sum_s + go * sum_l + go * go_dual * sum_sl) / gap
        centre = gap / products * max(min(reached, 1.0) ** 3, 1e-8)
        _correct(
            basis, first, weight, cap, rows, relief, tau, u, affine, wait, affine_wait, step, step_cap, step_wait,
            centre, mean, rhs, pull,
        )  # fmt: skip
        direction[:] = rhs
        _tie_vector(direction, end, ratio)
        solve(matrix, direction)
        _untie(direction, end, ratio)
        at_knots(basis, direction, du)
        _waits(mean, stiff, pull, du, dwait)
        loss, loss_dual, sum_s, sum_l, sum_sl = _dual_step(
            first, cap, rows, relief, tau, u, wait, dual, dual_cap, dual_wait, du, dwait, affine, affine_wait, centre,
            True, step, step_cap, step_wait,
        )  # fmt: skip
        go, go_dual = min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)
        if not (go > 0.0 and go_dual > 0.0):
            status, steps = BROKEN, number
            break
        c += go * direction
        at_knots(basis, c, u)
        wait += go * dwait
        dual += go_dual * step
        dual_cap += go_dual * step_cap
        dual_wait += go_dual * step_wait
        tau *= 1.0 - go
    return bound, dual, wait, time, status, steps

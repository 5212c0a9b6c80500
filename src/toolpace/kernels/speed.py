"""The core of the optimal planner: a primal-dual interior-point method for the speed along a path.

Unknown is z(s) = (ds/dt)^2, a cubic spline with coefficients c, judged at points that lie on its knots:

    minimise    sum_p w_p / sqrt(z_p)
    subject to  z_p <= cap_p                                             velocity, feed
                |r . (z, z', z'')_p| <= 1                                acceleration rows
                |r . (z, z', z'')_p| <= z_p^(-1/2)                       jerk rows

The right side of a jerk row is convex where it would have to be concave; its tangent at the current z lies below it,
so a Newton step that respects the tangent stays feasible, and no outer loop is needed. All rows of a point touch
three coefficients: they are collapsed into a 3 x 3 moment matrix in (z, z', z''), and the Newton matrix has five
diagonals. Predictor and corrector follow Mehrotra (1992). A start outside the constraints is met by `relief`, an
amount by which the rows of a point are relaxed; it shrinks to nothing with the steps taken.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.pentadiagonal import factor, solve

OPTIMAL, STALLED, BROKEN = 0, 1, 2
REST, MOVING = 0, 1
BACK_OFF = 0.99
MOST_FALL = 0.6
"""Most of z at a node that a step may take away: where z falls far, the tangents of the jerk rows mislead."""
KEEP_CURVATURE = 0.05
ROUNDING = 300.0
"""The gradient is a difference of large numbers: its tolerance, as a multiple of that of the gap."""


@jit()
def _tie_matrix(matrix: Any, end: Any, ratio: Any) -> Any:
    """Take the coefficients that an end fixes out of the Newton matrix.

    At rest c_1 = ratio[0] c_0, so c_0 is eliminated; in motion c_0 and c_1 are given. The last two likewise.
    """
    diagonal, first, second = matrix[0], matrix[1], matrix[2]
    n = len(diagonal)
    if end[0] == REST:
        a = 1.0 / ratio[0]
        diagonal[1] += 2.0 * a * first[0] + a * a * diagonal[0]
        first[1] += a * second[0]
    else:
        diagonal[1], first[1], second[1] = 1.0, 0.0, 0.0
    diagonal[0], first[0], second[0] = 1.0, 0.0, 0.0
    if end[1] == REST:
        a = 1.0 / ratio[1]
        diagonal[n - 2] += 2.0 * a * first[n - 2] + a * a * diagonal[n - 1]
        first[n - 3] += a * second[n - 3]
    else:
        diagonal[n - 2], first[n - 3], second[n - 4] = 1.0, 0.0, 0.0
    diagonal[n - 1], first[n - 2], second[n - 3] = 1.0, 0.0, 0.0


@jit()
def _tie_vector(b: Any, end: Any, ratio: Any) -> Any:
    """The same elimination for a right-hand side or a gradient."""
    n = len(b)
    b[1] = b[1] + b[0] / ratio[0] if end[0] == REST else 0.0
    b[n - 2] = b[n - 2] + b[n - 1] / ratio[1] if end[1] == REST else 0.0
    b[0] = b[n - 1] = 0.0


@jit()
def _untie(b: Any, end: Any, ratio: Any) -> Any:
    """Give the eliminated coefficients of a direction their values back."""
    n = len(b)
    if end[0] == REST:
        b[0] = b[1] / ratio[0]
    if end[1] == REST:
        b[n - 1] = b[n - 2] / ratio[1]


@jit()
def _factor_safely(matrix: Any, spare: Any) -> Any:
    """Factor in place; where rounding spoils a pivot, with a diagonal raised by as little as makes it succeed."""
    spare[:] = matrix
    raised = 1e-13
    while factor(matrix) != 0:
        if raised > 1e-4:
            return False
        matrix[:] = spare
        matrix[0] *= 1.0 + raised
        raised *= 30.0
    return True


@jit()
def _spread(basis: Any, node: Any, values: Any, out: Any) -> Any:
    """out (points, 3): z, z', z'' at the points from the coefficients `values`."""
    for p in range(len(node)):
        k = node[p]
        v0, v1, v2 = values[k], values[k + 1], values[k + 2]
        for d in range(3):
            out[p, d] = basis[p, d, 0] * v0 + basis[p, d, 1] * v1 + basis[p, d, 2] * v2


@jit()
def _newton_system(
    basis: Any,
    node: Any,
    weight: Any,
    cap: Any,
    rows: Any,
    relief: Any,
    tau: Any,
    u: Any,
    dual: Any,
    dual_cap: Any,
    matrix: Any,
    rhs: Any,
    gradient: Any,
) -> Any:
    """Newton matrix, right-hand side for a centring of zero, gradient of the Lagrangian; returns gap and time."""
    points, count = rows.shape[0], rows.shape[1]
    half = count // 2
    matrix[:] = 0.0
    rhs[:] = 0.0
    gradient[:] = 0.0
    gap = 0.0
    time = 0.0
    moment = np.empty((3, 3))
    for p in range(points):
        z, z1, z2 = u[p, 0], u[p, 1], u[p, 2]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        relax_cap, relax_acceleration, relax_jerk = tau * relief[p, 0], tau * relief[p, 1], tau * relief[p, 2]
        slack = cap[p] - z + relax_cap
        force = dual_cap[p] / slack
        gap += slack * dual_cap[p]
        m00, m01, m02, m11, m12, m22 = force, 0.0, 0.0, 0.0, 0.0, 0.0
        g0, g1, g2 = force * relax_cap, 0.0, 0.0
        l0, l1, l2 = dual_cap[p], 0.0, 0.0
        reverse = 0.0
        for i in range(count):
            b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
            value = b0 * z + b1 * z1 + b2 * z2
            limit = 1.0 if i < half else pace
            d = 0.0 if i < half else tangent
            extra = relax_acceleration if i < half else relax_jerk
            up, down = limit - value + extra, limit + value + extra
            lup, ldown = dual[p, i, 0], dual[p, i, 1]
            wup, wdown = lup / up, ldown / down
            both, odd = wup + wdown, wup - wdown
            m00 += both * (b0 * b0 + d * d) + 2.0 * odd * b0 * d
            m01 += both * b0 * b1 + odd * b1 * d
            m02 += both * b0 * b2 + odd * b2 * d
            m11 += both * b1 * b1
            m12 += both * b1 * b2
            m22 += both * b2 * b2
            g0 += extra * (odd * b0 + both * d)
            g1 += extra * odd * b1
            g2 += extra * odd * b2
            l0 += (lup - ldown) * b0 + (lup + ldown) * d
            l1 += (lup - ldown) * b1
            l2 += (lup - ldown) * b2
            gap += up * lup + down * ldown
            if i >= half:
                reverse += lup + ldown
        fall = -weight[p] * tangent
        m00 += 1.5 * tangent / z * max(weight[p] - reverse, KEEP_CURVATURE * weight[p])
        time += weight[p] * pace
        g0 += fall
        l0 += fall
        moment[0, 0], moment[0, 1], moment[0, 2] = m00, m01, m02
        moment[1, 0], moment[1, 1], moment[1, 2] = m01, m11, m12
        moment[2, 0], moment[2, 1], moment[2, 2] = m02, m12, m22
        k = node[p]
        for i in range(3):
            e0, e1, e2 = basis[p, 0, i], basis[p, 1, i], basis[p, 2, i]
            t0 = e0 * m00 + e1 * m01 + e2 * m02
            t1 = e0 * m01 + e1 * m11 + e2 * m12
            t2 = e0 * m02 + e1 * m12 + e2 * m22
            for j in range(i, 3):
                matrix[j - i, k + i] += t0 * basis[p, 0, j] + t1 * basis[p, 1, j] + t2 * basis[p, 2, j]
            rhs[k + i] -= e0 * g0 + e1 * g1 + e2 * g2
            gradient[k + i] += e0 * l0 + e1 * l1 + e2 * l2
    return gap, time


@jit()
def _predict(
    basis: Any,
    node: Any,
    cap: Any,
    rows: Any,
    relief: Any,
    tau: Any,
    u: Any,
    dual: Any,
    dual_cap: Any,
    du: Any,
    step: Any,
    step_cap: Any,
    centring: Any,
    second: Any,
) -> Any:
    """Steps of the multipliers for the predictor's primal step du, and what they teach the corrector.

    The corrector's right-hand side is the predictor's, less `second` (n,), the second-order terms, and less
    `centring` (n,) times the product aimed at. Returns the largest relative losses of slack and of multiplier,
    and the three sums that give the gap after a step.
    """
    points, count = rows.shape[0], rows.shape[1]
    half = count // 2
    centring[:] = 0.0
    second[:] = 0.0
    loss = loss_dual = 0.0
    sum_s = sum_l = sum_sl = 0.0
    for p in range(points):
        z, z1, z2 = u[p, 0], u[p, 1], u[p, 2]
        d0, d1, d2 = du[p, 0], du[p, 1], du[p, 2]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        relax_cap, relax_acceleration, relax_jerk = tau * relief[p, 0], tau * relief[p, 1], tau * relief[p, 2]
        loss = max(loss, -d0 / z)
        slack, lam = cap[p] - z + relax_cap, dual_cap[p]
        inverse = 1.0 / slack
        change = -d0 - relax_cap
        dlam = -lam * change * inverse - lam
        loss = max(loss, -change * inverse)
        loss_dual = max(loss_dual, -dlam / lam)
        sum_s += slack * dlam
        sum_l += lam * change
        sum_sl += change * dlam
        step_cap[p] = dlam
        a0, a1, a2 = inverse, 0.0, 0.0
        c0, c1, c2 = -dlam * change * inverse, 0.0, 0.0
        for i in range(count):
            b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
            value = b0 * z + b1 * z1 + b2 * z2
            move = b0 * d0 + b1 * d1 + b2 * d2
            limit = 1.0 if i < half else pace
            d = 0.0 if i < half else tangent
            extra = relax_acceleration if i < half else relax_jerk
            up, down = limit - value + extra, limit + value + extra
            lup, ldown = dual[p, i, 0], dual[p, i, 1]
            iup, idown = 1.0 / up, 1.0 / down
            change_up, change_down = -d * d0 - move - extra, -d * d0 + move - extra
            ratio_up, ratio_down = change_up * iup, change_down * idown
            dup, ddown = -lup * ratio_up - lup, -ldown * ratio_down - ldown
            loss = max(loss, max(-ratio_up, -ratio_down))
            # without centring a multiplier loses 1 + the relative change of its slack
            loss_dual = max(loss_dual, max(1.0 + ratio_up, 1.0 + ratio_down))
            sum_s += up * dup + down * ddown
            sum_l += lup * change_up + ldown * change_down
            sum_sl += change_up * dup + change_down * ddown
            step[p, i, 0], step[p, i, 1] = dup, ddown
            both, odd = iup + idown, iup - idown
            a0 += odd * b0 + both * d
            a1 += odd * b1
            a2 += odd * b2
            gup, gdown = -dup * ratio_up, -ddown * ratio_down
            c0 += (gup - gdown) * b0 + (gup + gdown) * d
            c1 += (gup - gdown) * b1
            c2 += (gup - gdown) * b2
        k = node[p]
        for i in range(3):
            e0, e1, e2 = basis[p, 0, i], basis[p, 1, i], basis[p, 2, i]
            centring[k + i] += e0 * a0 + e1 * a1 + e2 * a2
            second[k + i] += e0 * c0 + e1 * c1 + e2 * c2
    return loss, loss_dual, sum_s, sum_l, sum_sl


@jit()
def _correct(
    cap: Any,
    rows: Any,
    relief: Any,
    tau: Any,
    u: Any,
    dual: Any,
    dual_cap: Any,
    du: Any,
    affine: Any,
    centre: Any,
    step: Any,
    step_cap: Any,
) -> Any:
    """Steps of the multipliers for the corrector's primal step du; `affine` is the predictor's.

    `step` and `step_cap` hold the predictor's steps on entry. Returns the largest relative losses of slack and of
    multiplier.
    """
    points, count = rows.shape[0], rows.shape[1]
    half = count // 2
    loss = loss_dual = 0.0
    for p in range(points):
        z, z1, z2 = u[p, 0], u[p, 1], u[p, 2]
        d0, d1, d2 = du[p, 0], du[p, 1], du[p, 2]
        a0, a1, a2 = affine[p, 0], affine[p, 1], affine[p, 2]
        pace = 1.0 / np.sqrt(z)
        tangent = 0.5 * pace / z
        relax_cap, relax_acceleration, relax_jerk = tau * relief[p, 0], tau * relief[p, 1], tau * relief[p, 2]
        loss = max(loss, -d0 / (MOST_FALL * z))
        slack, lam = cap[p] - z + relax_cap, dual_cap[p]
        change = -d0 - relax_cap
        dlam = (centre + step_cap[p] * (a0 + relax_cap) - lam * change) / slack - lam
        loss = max(loss, -change / slack)
        loss_dual = max(loss_dual, -dlam / lam)
        step_cap[p] = dlam
        for i in range(count):
            b0, b1, b2 = rows[p, i, 0], rows[p, i, 1], rows[p, i, 2]
            value = b0 * z + b1 * z1 + b2 * z2
            move = b0 * d0 + b1 * d1 + b2 * d2
            first = b0 * a0 + b1 * a1 + b2 * a2
            limit = 1.0 if i < half else pace
            d = 0.0 if i < half else tangent
            extra = relax_acceleration if i < half else relax_jerk
            for side in range(2):
                sign = 1.0 if side == 0 else -1.0
                slack, lam = limit - sign * value + extra, dual[p, i, side]
                change = -d * d0 - sign * move - extra
                inverse = 1.0 / (slack * lam)
                target = centre + step[p, i, side] * (d * a0 + sign * first + extra) - lam * change
                dlam = (target - slack * lam) * inverse * lam
                loss = max(loss, -change * lam * inverse)
                loss_dual = max(loss_dual, (slack * lam - target) * inverse)
                step[p, i, side] = dlam
    return loss, loss_dual


@jit()
def _first_multipliers(
    weight: Any, cap: Any, rows: Any, relief: Any, u: Any, spread: Any, dual: Any, dual_cap: Any
) -> Any:
    """Multipliers that make every product of slack and multiplier equal, together `spread` of the time."""
    points, count = rows.shape[0], rows.shape[1]
    half = count // 2
    time = 0.0
    for p in range(points):
        time += weight[p] / np.sqrt(u[p, 0])
    centre = spread * time / (points * (2 * count + 1))
    for p in range(points):
        z, z1, z2 = u[p, 0], u[p, 1], u[p, 2]
        pace = 1.0 / np.sqrt(z)
        dual_cap[p] = centre / (cap[p] - z + relief[p, 0])
        for i in range(count):
            value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
            limit = 1.0 + relief[p, 1] if i < half else pace + relief[p, 2]
            dual[p, i, 0] = centre / (limit - value)
            dual[p, i, 1] = centre / (limit + value)


@jit()
def maximise_speed(
    basis: Any,
    node: Any,
    weight: Any,
    cap: Any,
    rows: Any,
    c: Any,
    relief: Any,
    end: Any,
    ratio: Any,
    spread: Any,
    tolerance: Any,
    most_steps: Any,
) -> Any:
    """Coefficients of the fastest z within the rows.

    Parameters: basis (points, 3, 3) and node (points,) tie a point to its coefficients; weight (points,) of the
    time; cap (points,) on z; rows (points, 2 m, 3), the first m of acceleration, the others of jerk, divided by
    their limits; c (n,) start with z > 0 at all points; relief (points, 3) of cap, acceleration and jerk rows,
    positive where the start breaks one; end (2,) REST or MOVING; ratio (2,) = c_1 / c_0 and c_n-2 / c_n-1 at ends
    at rest; spread, the first gap, and tolerance of gap and gradient, relative to the time.
    Returns c, status, steps, and gap and scaled gradient relative to the time.
    """
    points, count, n = rows.shape[0], rows.shape[1], len(c)
    products = points * (2 * count + 1)
    u, du, affine = np.empty((points, 3)), np.zeros((points, 3)), np.zeros((points, 3))
    dual, step = np.empty((points, count, 2)), np.zeros((points, count, 2))
    dual_cap, step_cap = np.empty(points), np.zeros(points)
    matrix, spare = np.empty((3, n)), np.empty((3, n))
    rhs, direction, gradient, centring, second = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    _spread(basis, node, c, u)
    _first_multipliers(weight, cap, rows, relief, u, spread, dual, dual_cap)
    gap, time, residual = np.inf, 1.0, np.inf
    for steps in range(most_steps):
        gap, time = _newton_system(
            basis, node, weight, cap, rows, relief, tau, u, dual, dual_cap, matrix, rhs, gradient
        )
        _tie_vector(gradient, end, ratio)
        residual = 0.0
        for i in range(n):
            residual += abs(gradient[i] * c[i])
        if gap < tolerance * time and residual < ROUNDING * tolerance * time and tau < 1e-9:
            return c, OPTIMAL, steps, gap / time, residual / time
        _tie_matrix(matrix, end, ratio)
        if not _factor_safely(matrix, spare):
            return c, BROKEN, steps, gap / time, residual / time
        # predictor: straight at the optimum, to learn how far one can go
        direction[:] = rhs
        _tie_vector(direction, end, ratio)
        solve(matrix, direction)
        _untie(direction, end, ratio)
        _spread(basis, node, direction, affine)
        loss, loss_dual, sum_s, sum_l, sum_sl = _predict(
            basis, node, cap, rows, relief, tau, u, dual, dual_cap, affine, step, step_cap, centring, second
        )
        go, go_dual = min(1.0, 1.0 / loss), min(1.0, 1.0 / loss_dual)
        reached = (gap + go_dual * sum_s + go * sum_l + go * go_dual * sum_sl) / gap
        centre = gap / products * max(min(reached, 1.0) ** 3, 1e-8)
        # corrector: centred, with the second-order terms that the predictor revealed
        direction[:] = rhs - centre * centring - second
        _tie_vector(direction, end, ratio)
        solve(matrix, direction)
        _untie(direction, end, ratio)
        _spread(basis, node, direction, du)
        loss, loss_dual = _correct(cap, rows, relief, tau, u, dual, dual_cap, du, affine, centre, step, step_cap)
        go, go_dual = min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)
        if not (go > 0.0 and go_dual > 0.0):
            return c, BROKEN, steps, gap / time, residual / time
        c += go * direction
        _spread(basis, node, c, u)
        dual += go_dual * step
        dual_cap += go_dual * step_cap
        tau *= 1.0 - go
    return c, STALLED, most_steps, gap / time, residual / time

"""The passes over the knots of the relaxed problem: all that `toolpace.kernels.relaxation` does row by row.

The rows of a knot are those of its points, rows (points, 2 m, 3) from first[k] to first[k + 1]; a knot without any has
no wait. `single` (n, 4) are the multipliers of the knot itself, of cap, wait, floor and chord, u (n, 3) its z, z', z'',
and relief (n, 4), times tau, what its rows are relaxed by.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.newton import add_curvature, add_slope

CAP, WAIT, FLOOR, CHORD = 0, 1, 2, 3
"""The rows of a knot itself, as the columns of their multipliers."""
RELIEF_CAP, RELIEF_ACCELERATION, RELIEF_FLOOR, RELIEF_CHORD = 0, 1, 2, 3
LEAST_LEFT = 0.005
"""Share of the slack of a chord that a step leaves: it falls below what its tangent says."""
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
def first_multipliers(
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
def newton_system(
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
        add_curvature(basis, k, k, m00, m01, m02, m11, m12, m22, matrix)
        add_slope(basis, k, k, -g0, -g1, -g2, rhs)
    return gap, time


@jit()
def correct(
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
        add_slope(basis, k, k, -g0, -g1, -g2, rhs)


@jit()
def waits(mean: Any, stiff: Any, pull: Any, du: Any, dwait: Any) -> Any:
    """The change of the waits that belongs to a change du of z, z', z''."""
    for k in range(len(stiff)):
        dwait[k] = mean[k, 0] * du[k, 0] + mean[k, 1] * du[k, 1] + mean[k, 2] * du[k, 2] - pull[k] / stiff[k]


@jit()
def dual_step(
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
def within_chords(
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

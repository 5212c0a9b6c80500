"""The knots of the relaxed problem: their own rows, their waits, and what both have in a Newton step.

A knot has up to four rows of its own, as slacks that shall not be negative, and multipliers `single` (n, 4) for them:

    CAP    cap - z                              FLOOR  z - low                                     with a range
    WAIT   the wait itself, with rows only      CHORD  chord(z) - 1 / sqrt(z) - wait               with a range and rows

`slope` is the derivative of a slack by z, PUSH that by the wait, and relief (n, 4), times tau, what is added to them.
The wait is eliminated knot by knot: `mean` (n, 3) is its change for a change of (z, z', z''), `stiff` (n,) the second
derivative by it, and `pull` (n,) the first.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.multipliers import EXTRA, EXTRA_JERK, FALL, LIMIT, Z
from toolpace.kernels.optimal.newton import add_curvature, add_slope

CAP, WAIT, FLOOR, CHORD = range(4)
PUSH = (0.0, 1.0, 0.0, -1.0)
RELIEF_CAP, RELIEF_ACCELERATION, RELIEF_FLOOR, RELIEF_CHORD = range(4)
"""Columns of a relief; a wait needs none."""
TOTAL, V0, V1, V2 = range(4)
"""What the jerk rows of a point add to the second derivatives by the wait: twice, and once with (z, z', z'')."""
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
    """out (n, 3 or more): z, z', z'' at the knots."""
    for k in range(len(basis)):
        for d in range(3):
            out[k, d] = basis[k, d, 0] * c[k] + basis[k, d, 1] * c[k + 1] + basis[k, d, 2] * c[k + 2]


@jit()
def own_rows(first: Any, low: Any, active: Any) -> Any:
    """active (n, 4): which rows of its own each knot has; returns how many there are."""
    count = 0
    for k in range(len(low)):
        with_rows = first[k] < first[k + 1]
        active[k, CAP], active[k, WAIT] = True, with_rows
        active[k, FLOOR], active[k, CHORD] = low[k] > 0.0, low[k] > 0.0 and with_rows
        for i in range(4):
            count += active[k, i]
    return count


@jit()
def first_waits(
    first: Any, weight: Any, low: Any, chord: Any, rows: Any, relief: Any, u: Any, centre: Any, wait: Any,
) -> Any:  # fmt: skip
    """Waits at which the multipliers of jerk and wait balance the time, if every product with a slack is `centre`.

    Where a chord leaves no room for the wait, it is given relief.
    """
    half = rows.shape[1] // 2
    for k in range(len(weight)):
        z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
        pace = 1.0 / np.sqrt(z)
        wait[k] = 0.0
        if first[k] == first[k + 1]:
            continue
        worst = 0.0
        count = 1
        for p in range(first[k], first[k + 1]):
            for i in range(half, 2 * half):
                worst = max(worst, abs(rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2))
                count += 2
        # Newton on 1 / sum of 1 / slack
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
        wait[k] = y


@jit()
def states(
    low: Any, cap: Any, chord: Any, relief: Any, tau: Any, wait: Any, state: Any, slack: Any, slope: Any, relaxed: Any
) -> Any:
    """Complete the states (n, 7), of which z, z', z'' are known; set slacks, slopes and what is relaxed (n, 4)."""
    for k in range(len(wait)):
        z = state[k, Z]
        pace = 1.0 / np.sqrt(z)
        fall = 0.5 * pace / z
        state[k, LIMIT], state[k, FALL] = pace + wait[k], fall
        state[k, EXTRA], state[k, EXTRA_JERK] = tau * relief[k, RELIEF_ACCELERATION], 0.0
        relaxed[k, CAP], relaxed[k, WAIT] = tau * relief[k, RELIEF_CAP], 0.0
        relaxed[k, FLOOR], relaxed[k, CHORD] = tau * relief[k, RELIEF_FLOOR], tau * relief[k, RELIEF_CHORD]
        slack[k, CAP], slope[k, CAP] = cap[k] - z + relaxed[k, CAP], -1.0
        slack[k, WAIT], slope[k, WAIT] = wait[k], 0.0
        slack[k, FLOOR], slope[k, FLOOR] = z - low[k] + relaxed[k, FLOOR], 1.0
        slack[k, CHORD] = chord[k, 0] - chord[k, 1] * z - state[k, LIMIT] + relaxed[k, CHORD]
        slope[k, CHORD] = fall - chord[k, 1]


@jit()
def start(first: Any, weight: Any, active: Any, slack: Any, centre: Any, single: Any) -> Any:
    """Multipliers that make every product of slack and multiplier equal to `centre`.

    A knot without rows has no wait; a multiplier that equals the weight leaves its time the full curvature.
    """
    for k in range(len(weight)):
        for i in range(4):
            if active[k, i]:
                single[k, i] = centre / slack[k, i]
        if first[k] == first[k + 1]:
            single[k, WAIT] = weight[k]


@jit()
def eliminate_waits(
    basis: Any, first: Any, weight: Any, active: Any, state: Any, slack: Any, slope: Any, relaxed: Any, single: Any,
    of_point: Any, matrix: Any, rhs: Any, mean: Any, stiff: Any, pull: Any,
) -> Any:  # fmt: skip
    """Mean, stiffness and pull of the waits, given the sums of the points' jerk rows; adds the knots' own part.

    of_point (points, 4) are those sums. Returns gap and relaxed time of the knots.
    """
    gap = 0.0
    time = 0.0
    for k in range(len(weight)):
        bare = first[k] == first[k + 1]
        total, v0, v1, v2 = 1.0 if bare else 0.0, 0.0, 0.0, 0.0
        pulled = 0.0 if bare else weight[k]
        fall = state[k, FALL]
        g0 = -weight[k] * fall
        time += weight[k] * state[k, LIMIT]
        for i in range(4):
            if active[k, i]:
                force = single[k, i] / slack[k, i]
                gap += single[k, i] * slack[k, i]
                total += force * PUSH[i] ** 2
                v0 -= force * PUSH[i] * slope[k, i]
                pulled -= force * PUSH[i] * relaxed[k, i]
                g0 -= force * slope[k, i] * relaxed[k, i]
        for p in range(first[k], first[k + 1]):
            total += of_point[p, TOTAL]
            v0 += of_point[p, V0]
            v1 += of_point[p, V1]
            v2 += of_point[p, V2]
        a0, a1, a2 = v0 / total, v1 / total, v2 / total
        mean[k, 0], mean[k, 1], mean[k, 2], stiff[k], pull[k] = a0, a1, a2, total, pulled
        # the curvature of the time, of which the multipliers of jerk take what they do not leave to the wait
        m00, m01, m02, m11, m12, m22 = 1.5 * fall / state[k, Z] * single[k, WAIT], 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(4):
            if active[k, i]:
                force = single[k, i] / slack[k, i]
                w0, w1, w2 = slope[k, i] + PUSH[i] * a0, PUSH[i] * a1, PUSH[i] * a2
                m00 += force * w0 * w0
                m01 += force * w0 * w1
                m02 += force * w0 * w2
                m11 += force * w1 * w1
                m12 += force * w1 * w2
                m22 += force * w2 * w2
        add_curvature(basis, k, k, m00, m01, m02, m11, m12, m22, matrix)
        add_slope(basis, k, k, -g0 - pulled * a0, -pulled * a1, -pulled * a2, rhs)
    return gap, time


@jit()
def waits(mean: Any, stiff: Any, pull: Any, change: Any) -> Any:
    """Set the change of the waits, column 3, that belongs to a change (n, 4) of z, z', z''."""
    for k in range(len(stiff)):
        change[k, 3] = mean[k, 0] * change[k, 0] + mean[k, 1] * change[k, 1] + mean[k, 2] * change[k, 2]
        change[k, 3] -= pull[k] / stiff[k]


@jit()
def predict(
    basis: Any, active: Any, state: Any, slack: Any, slope: Any, relaxed: Any, single: Any, mean: Any, affine: Any,
    centring: Any, second: Any, pull_centring: Any, pull_second: Any,
) -> Any:  # fmt: skip
    """The part of the knots' own rows in what `relaxedrows.predict` finds, to the vectors of which it adds.

    Returns the largest relative fall and growth of a slack, and the sums of slack times multiplier times such a
    change, and its square.
    """
    falls = grows = linear = square = 0.0
    for k in range(len(state)):
        falls = max(falls, -affine[k, 0] / (MOST_FALL * state[k, Z]))
        for i in range(4):
            if active[k, i]:
                change = (slope[k, i] * affine[k, 0] + PUSH[i] * affine[k, 3] - relaxed[k, i]) / slack[k, i]
                product = single[k, i] * slack[k, i] * change
                linear += product
                square += product * change
                falls, grows = max(falls, -change), max(grows, change)
                for order in range(2):
                    push = 1.0 / slack[k, i] if order == 0 else single[k, i] * (1.0 + change) * change
                    target = push * PUSH[i]
                    vector, pull = (centring, pull_centring) if order == 0 else (second, pull_second)
                    g0 = -push * slope[k, i] - target * mean[k, 0]
                    add_slope(basis, k, k, g0, -target * mean[k, 1], -target * mean[k, 2], vector)
                    pull[k] += target
    return falls, grows, linear, square


@jit()
def correct(
    active: Any, state: Any, slack: Any, slope: Any, relaxed: Any, single: Any, affine: Any, change: Any, centre: Any,
    step: Any,
) -> Any:  # fmt: skip
    """Steps (n, 4) of the knots' own multipliers for the corrector's step `change` (n, 4); `affine` the predictor's.

    Returns the largest relative losses of slack and of multiplier.
    """
    loss = loss_dual = 0.0
    for k in range(len(state)):
        loss = max(loss, -change[k, 0] / (MOST_FALL * state[k, Z]))
        for i in range(4):
            if active[k, i]:
                before = (slope[k, i] * affine[k, 0] + PUSH[i] * affine[k, 3] - relaxed[k, i]) / slack[k, i]
                by = (slope[k, i] * change[k, 0] + PUSH[i] * change[k, 3] - relaxed[k, i]) / slack[k, i]
                grow = centre / (slack[k, i] * single[k, i]) + before * (1.0 + before) - by - 1.0
                step[k, i] = single[k, i] * grow
                loss, loss_dual = max(loss, -by), max(loss_dual, -grow)
    return loss, loss_dual


@jit()
def _room(chord: Any, relaxed: Any, z: Any, wait: Any) -> Any:
    """What is left of the chord of a knot, relief included."""
    return chord[0] - chord[1] * z - 1.0 / np.sqrt(z) - wait + relaxed


@jit()
def within_chords(active: Any, chord: Any, relief: Any, tau: Any, state: Any, wait: Any, change: Any, go: Any) -> Any:
    """The longest of go, go / 2, ... after which every chord has some room left."""
    k = 0
    while k < len(wait) and go > 1e-12:
        if active[k, CHORD]:
            relaxed = tau * relief[k, RELIEF_CHORD]
            before = _room(chord[k], relaxed, state[k, Z], wait[k])
            after = _room(chord[k], (1.0 - go) * relaxed, state[k, Z] + go * change[k, 0], wait[k] + go * change[k, 3])
            if not after > LEAST_LEFT * before:
                go *= 0.5
                k = -1
        k += 1
    return go

"""The knots of the relaxation: their rows, their waiting times, their part in a Newton step.

The rows are those of `relaxation_work`, PUSH their derivatives by the wait. `tau` is the share of the reliefs that
still stands. The wait is eliminated knot by knot.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.dual import KnotRows
from toolpace.kernels.optimal.multipliers import EXTRA, EXTRA_JERK, FALL, LIMIT, MOST_FALL, Z
from toolpace.kernels.optimal.newton import System, add_curvature, add_slope
from toolpace.kernels.optimal.relaxation_work import (
    CAP,
    CHORD,
    FLOOR,
    RELIEF_ACCELERATION,
    RELIEF_CAP,
    RELIEF_CHORD,
    RELIEF_FLOOR,
    WAIT,
    KnotStates,
    KnotSteps,
    OwnRows,
    Waits,
)

PUSH = (0.0, 1.0, 0.0, -1.0)
TOTAL, V0, V1, V2 = range(4)
"""What the jerk rows of a point add to the second derivatives by the wait: twice, and once with (z, z', z'')."""
LEAST_LEFT = 0.005
"""Share of the slack of a chord that a step leaves: it falls below what its tangent says."""


@jit()
def at_knots(basis: Floats, c: Floats, out: Floats) -> None:
    """out (n, 3 or more): z, z', z'' at the knots."""
    for k in range(len(basis)):
        for d in range(3):
            out[k, d] = basis[k, d, 0] * c[k] + basis[k, d, 1] * c[k + 1] + basis[k, d, 2] * c[k + 2]


@jit()
def first_waits(knots: KnotRows, own: OwnRows, states: KnotStates, centre: float) -> None:
    """Waits at which the multipliers of jerk and wait balance the time, if every product with a slack is `centre`.

    Where a chord leaves no room for the wait, it is given relief.
    """
    first, weight, u, chord = knots.first, knots.weight, states.at, own.chord
    for k in range(len(weight)):
        states.wait[k] = 0.0
        if first[k] == first[k + 1]:
            continue
        z = u[k, 0]
        pace = 1.0 / np.sqrt(z)
        lowest, y = _balancing(knots, k, u, centre)
        if own.low[k] > 0.0:
            room = chord[k, 0] - chord[k, 1] * z - pace
            if room > 1.1 * lowest:
                y = min(y, 0.5 * (room + lowest))
            if room < 1.1 * y:
                own.relief[k, RELIEF_CHORD] = 1.5 * y - room + 0.01 * pace
        states.wait[k] = y


@jit(inline=True)
def _balancing(knots: KnotRows, k: int, u: Floats, centre: float) -> tuple[float, float]:
    """The least wait that the jerk rows of a knot ask for at u (n, 3 or more), and the one that balances the time."""
    first, weight, rows, shifted = knots.first, knots.weight, knots.rows, len(knots.shift) > 0
    half = rows.shape[1] // 2
    z, z1, z2 = u[k, 0], u[k, 1], u[k, 2]
    pace = 1.0 / np.sqrt(z)
    worst = 0.0
    count = 1
    for p in range(first[k], first[k + 1]):
        for i in range(half, 2 * half):
            value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
            worst = max(worst, abs(value + knots.shift[p, i] if shifted else value))
            count += 2
    # Newton on 1 / sum of 1 / slack
    lowest = max(worst - pace, 0.0)
    y = lowest + count * centre / weight[k]
    for _ in range(3):
        total, square = 1.0 / y, 1.0 / (y * y)
        for p in range(first[k], first[k + 1]):
            for i in range(half, 2 * half):
                value = rows[p, i, 0] * z + rows[p, i, 1] * z1 + rows[p, i, 2] * z2
                if shifted:
                    value += knots.shift[p, i]
                up, down = 1.0 / (pace + y - value), 1.0 / (pace + y + value)
                total += up + down
                square += up * up + down * down
        y = max(y + (centre / weight[k] * total - 1.0) * total / square, lowest + 0.1 * (y - lowest))
    return lowest, y


@jit()
def complete(own: OwnRows, tau: float, states: KnotStates) -> None:
    """Complete the states, of which z, z', z'' and wait are known."""
    low, cap, chord, relief = own.low, own.cap, own.chord, own.relief
    state, wait, slack, slope, relaxed = states.at, states.wait, states.slack, states.slope, states.relaxed
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
def start(knots: KnotRows, own: OwnRows, states: KnotStates, centre: float) -> None:
    """Multipliers that make every product of slack and multiplier equal to `centre`.

    A knot without rows has no wait; a multiplier that equals the weight leaves its time the full curvature.
    """
    first, weight, active, slack, dual = knots.first, knots.weight, own.active, states.slack, states.dual
    for k in range(len(weight)):
        for i in range(4):
            if active[k, i]:
                dual[k, i] = centre / slack[k, i]
        if first[k] == first[k + 1]:
            dual[k, WAIT] = weight[k]


@jit()
def eliminate_waits(
    knots: KnotRows, own: OwnRows, states: KnotStates, of_point: Floats, system: System, waits: Waits
) -> tuple[float, float]:
    """Mean, stiffness and pull of the waits, given the sums of the points' jerk rows; adds the knots' own part.

    of_point (points, 4) are those sums. Returns gap and relaxed time of the knots.
    """
    first, weight, active, state, dual = knots.first, knots.weight, own.active, states.at, states.dual
    slack, slope, relaxed = states.slack, states.slope, states.relaxed
    mean, stiff, pull = waits.mean, waits.stiff, waits.pull
    basis, matrix, rhs = knots.basis, system.matrix, system.rhs
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
                force = dual[k, i] / slack[k, i]
                gap += dual[k, i] * slack[k, i]
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
        m00, m01, m02, m11, m12, m22 = 1.5 * fall / state[k, Z] * dual[k, WAIT], 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(4):
            if active[k, i]:
                force = dual[k, i] / slack[k, i]
                w0, w1, w2 = slope[k, i] + PUSH[i] * a0, PUSH[i] * a1, PUSH[i] * a2
                m00 += force * w0 * w0
                m01 += force * w0 * w1
                m02 += force * w0 * w2
                m11 += force * w1 * w1
                m12 += force * w1 * w2
                m22 += force * w2 * w2
        add_curvature(basis, k, k, (m00, m01, m02, m11, m12, m22), matrix)
        add_slope(basis, k, k, (-g0 - pulled * a0, -pulled * a1, -pulled * a2), rhs)
    return gap, time


@jit(inline=True)
def follow(waits: Waits, change: Floats) -> None:
    """Set the change of the waits, column 3, that belongs to a change (n, 4) of z, z', z''."""
    mean, stiff, pull = waits.mean, waits.stiff, waits.pull
    for k in range(len(stiff)):
        change[k, 3] = mean[k, 0] * change[k, 0] + mean[k, 1] * change[k, 1] + mean[k, 2] * change[k, 2]
        change[k, 3] -= pull[k] / stiff[k]


@jit()
def predict(
    knots: KnotRows, own: OwnRows, states: KnotStates, waits: Waits, affine: Floats, system: System
) -> tuple[float, float, float, float]:
    """The part of the knots' own rows in what `relaxation.predict` finds, to the vectors of which it adds.

    Returns the largest relative fall and growth of a slack, and the sums of slack times multiplier times such a
    change, and its square.
    """
    active, state, slack, slope, relaxed = own.active, states.at, states.slack, states.slope, states.relaxed
    dual, mean, basis = states.dual, waits.mean, knots.basis
    centring, second, pull_centring, pull_second = system.centring, system.second, waits.centring, waits.second
    falls = grows = linear = square = 0.0
    for k in range(len(state)):
        falls = max(falls, -affine[k, 0] / (MOST_FALL * state[k, Z]))
        for i in range(4):
            if active[k, i]:
                change = (slope[k, i] * affine[k, 0] + PUSH[i] * affine[k, 3] - relaxed[k, i]) / slack[k, i]
                product = dual[k, i] * slack[k, i] * change
                linear += product
                square += product * change
                falls, grows = max(falls, -change), max(grows, change)
                push = 1.0 / slack[k, i]
                target = push * PUSH[i]
                g0 = -push * slope[k, i] - target * mean[k, 0]
                add_slope(basis, k, k, (g0, -target * mean[k, 1], -target * mean[k, 2]), centring)
                pull_centring[k] += target
                push = dual[k, i] * (1.0 + change) * change
                target = push * PUSH[i]
                g0 = -push * slope[k, i] - target * mean[k, 0]
                add_slope(basis, k, k, (g0, -target * mean[k, 1], -target * mean[k, 2]), second)
                pull_second[k] += target
    return falls, grows, linear, square


@jit()
def correct(own: OwnRows, states: KnotStates, steps: KnotSteps, centre: float) -> tuple[float, float]:
    """Set the steps of the knots' own multipliers that go with the corrector's change.

    Returns the largest relative losses of slack and of multiplier.
    """
    active, state, slack, slope, relaxed = own.active, states.at, states.slack, states.slope, states.relaxed
    dual, (affine, change, step) = states.dual, steps
    loss = loss_dual = 0.0
    for k in range(len(state)):
        loss = max(loss, -change[k, 0] / (MOST_FALL * state[k, Z]))
        for i in range(4):
            if active[k, i]:
                before = (slope[k, i] * affine[k, 0] + PUSH[i] * affine[k, 3] - relaxed[k, i]) / slack[k, i]
                by = (slope[k, i] * change[k, 0] + PUSH[i] * change[k, 3] - relaxed[k, i]) / slack[k, i]
                grow = centre / (slack[k, i] * dual[k, i]) + before * (1.0 + before) - by - 1.0
                step[k, i] = dual[k, i] * grow
                loss, loss_dual = max(loss, -by), max(loss_dual, -grow)
    return loss, loss_dual


@jit(inline=True)
def _room(chord: Floats, relaxed: float, z: float, wait: float) -> float:
    """What is left of the chord of a knot, relief included."""
    return float(chord[0] - chord[1] * z - 1.0 / np.sqrt(z) - wait + relaxed)


@jit()
def within_chords(own: OwnRows, tau: float, states: KnotStates, change: Floats, go: float) -> float:
    """The longest of go, go / 2, ... of a change (n, 4) after which every chord has some room left."""
    active, chord, relief, state, wait = own.active, own.chord, own.relief, states.at, states.wait
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

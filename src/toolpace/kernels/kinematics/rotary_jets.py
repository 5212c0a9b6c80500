"""Derivatives of the rotary joints to third order from those of the tool axis.

The k-th Taylor coefficient of R1 R2 a0 is linear in the k-th coefficients of the two angles, so they follow one after
the other: what the coefficients below k make of the axis is taken from the given coefficient, and the rest is shared
out between the angles, two unknowns in three equations of rank two.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import dot, second_angle, solve_rotary, turn
from toolpace.kernels.kinematics.geometry import A0, U1, U2
from toolpace.kernels.kinematics.taylor import Angle, new_angle, sine_term, split, start_angle

NOISE = 64.0 * 2.0**-52
"""Rounding of a tool axis and of what is made of it: a derivative of the first joint below it is taken for none."""
EDGE = 1e-14
"""Squared sine between the motions that both joints give the axis, at which the two solutions meet."""


@jit()
def nearest(solutions: Floats, near: Floats) -> int:
    """Unwind both solutions (2, 2) to the turns nearest to `near` (2,), in place, and name the nearer one."""
    best = 0
    least = math.inf
    for side in range(2):
        total = 0.0
        for joint in range(2):
            off = solutions[side, joint] - near[joint]
            off -= 2.0 * math.pi * np.round(off / (2.0 * math.pi))
            solutions[side, joint] = near[joint] + off
            total += off * off
        if total < least:
            least = total
            best = side
    return best


@jit()
def drop_noise(axis: Floats, off: float, first: Floats) -> None:
    """Set those Taylor coefficients (4,) of the first angle to zero that are rounding, `off` the sine from the pole.

    The rounding of an axis with the coefficients (4, 3) grows with each order as fast as the direction from the pole.
    """
    rate = 0.0
    for k in range(1, 4):
        rate = max(rate, (math.sqrt(dot(axis[k], axis[k])) / off) ** (1.0 / k))
    noise = NOISE / off
    for k in range(1, 4):
        noise *= rate
        if abs(first[k]) < noise:
            first[k] = 0.0


@jit()
def angles_near(
    frame: Floats, pole_tolerance: float, axis: Floats, near: Floats, solutions: Floats
) -> tuple[bool, int]:
    """Both solutions (2, 2) of an axis (3,), unwound to `near` (2,): whether it is the pole, and the nearer one."""
    pole = solve_rotary(frame, pole_tolerance, axis, solutions)
    if pole:
        back = np.empty(3)
        turn(frame[U1], -math.sin(near[0]), math.cos(near[0]), axis, back)
        for side in range(2):
            solutions[side, 0] = near[0]
            solutions[side, 1] = second_angle(frame, back)
    return pole, nearest(solutions, near)


@jit()
def set_term(angle: Angle, k: int, value: float) -> None:
    """Make `value` the k-th coefficient of an angle, whose sine and cosine have been worked out with zero."""
    angle.value[k] = value
    angle.sine[k] += angle.cosine[0] * value
    angle.cosine[k] -= angle.sine[0] * value


@jit()
def rotary_jets(frame: Floats, pole_tolerance: float, axis: Floats, near: Floats, out: Floats) -> None:
    """Derivatives (4, n, 2) of the rotary joints from those of the axis (4, n, 3), nearest to `near` (n, 2).

    At the pole the first angle keeps the value of `near` and rests; next to it its derivatives are none where they
    would be rounding only, as on an axis that passes right through. Where the two solutions meet away from the pole
    (the edge of reach) no finite derivative exists, and the result is nan.
    """
    u1 = frame[U1]
    solutions = np.empty((2, 2))
    a = np.empty((4, 3))
    constant = np.empty((3, 3))  # a0, split for turning about u2
    inner = np.empty((4, 3))  # the jet R2 a0
    parts = np.empty((4, 3, 3))  # the same, split for turning about u1
    g1, g2 = np.empty(3), np.empty(3)  # derivatives of the axis by both angles
    rest = np.empty(3)
    first, second = new_angle(), new_angle()
    (t1, s1, k1), (t2, s2, k2) = first, second
    split(frame[U2], frame[A0], constant)
    for i in range(axis.shape[1]):
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                a[k, d] = axis[k, i, d] / factorial
        pole, side = angles_near(frame, pole_tolerance, a[0], near[i], solutions)
        start_angle(first, solutions[side, 0])
        start_angle(second, solutions[side, 1])
        for d in range(3):
            inner[0, d] = constant[0, d] + k2[0] * constant[1, d] + s2[0] * constant[2, d]
            rest[d] = k2[0] * constant[2, d] - s2[0] * constant[1, d]
        turn(u1, s1[0], k1[0], rest, g2)
        split(u1, inner[0], parts[0])
        for d in range(3):
            g1[d] = k1[0] * parts[0, 2, d] - s1[0] * parts[0, 1, d]
        g11, g12, g22 = dot(g1, g1), dot(g1, g2), dot(g2, g2)
        det = g11 * g22 - g12 * g12
        for k in range(1, 4):
            # what the axis becomes where both angles have a k-th coefficient of zero, and what is missing then
            t1[k] = t2[k] = 0.0
            sine_term(first, k)
            sine_term(second, k)
            for d in range(3):
                inner[k, d] = k2[k] * constant[1, d] + s2[k] * constant[2, d]
            split(u1, inner[k], parts[k])
            for d in range(3):
                total = parts[k, 0, d]
                for j in range(k + 1):
                    total += k1[j] * parts[k - j, 1, d] + s1[j] * parts[k - j, 2, d]
                rest[d] = a[k, d] - total
            r1, r2 = dot(rest, g1), dot(rest, g2)
            c1 = c2 = np.nan
            if pole:
                c1, c2 = 0.0, r2 / g22
            elif det > EDGE * g11 * g22:
                c1, c2 = (g22 * r1 - g12 * r2) / det, (g11 * r2 - g12 * r1) / det
            set_term(first, k, c1)
            set_term(second, k, c2)
            for d in range(3):
                inner[k, d] = k2[k] * constant[1, d] + s2[k] * constant[2, d]
            split(u1, inner[k], parts[k])
        if not pole:
            drop_noise(a, math.sqrt(g11), t1)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            out[k, i, 0] = t1[k] * factorial
            out[k, i, 1] = t2[k] * factorial

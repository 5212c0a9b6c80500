"""Derivatives of the rotary joints to third order from those of the tool axis.

The k-th Taylor coefficient of R1 R2 a0 is linear in the k-th coefficients of the two angles, so they follow one after
the other: what the coefficients below k make of the axis is taken from the given coefficient, and the rest is shared
out between the angles, two unknowns in three equations of rank two.
"""

from __future__ import annotations

import math
from typing import NamedTuple

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


class Turned(NamedTuple):
    """The axis R1 R2 a0 of one point, and what it is made of."""

    axis: Floats
    """(4, 3) Taylor coefficients of the given axis."""
    constant: Floats
    """(3, 3) a0, split for turning about u2."""
    inner: Floats
    """(4, 3) Taylor coefficients of R2 a0."""
    parts: Floats
    """(4, 3, 3) these, split for turning about u1."""
    by_first: Floats
    """(3,) derivative of the axis by the first angle."""
    by_second: Floats
    """(3,) derivative of the axis by the second angle."""
    rest: Floats
    """(3,) what a coefficient of the axis has beyond that which the lower coefficients of the angles make."""


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
def inner_term(turned: Turned, u1: Floats, second: Angle, k: int) -> None:
    """Coefficient k >= 1 of R2 a0, and its parts."""
    for d in range(3):
        turned.inner[k, d] = second.cosine[k] * turned.constant[1, d] + second.sine[k] * turned.constant[2, d]
    split(u1, turned.inner[k], turned.parts[k])


@jit()
def begin(turned: Turned, u1: Floats, first: Angle, second: Angle) -> None:
    """Coefficient 0 of R2 a0, its parts, and the derivatives of the axis by both angles."""
    s1, k1, s2, k2 = first.sine[0], first.cosine[0], second.sine[0], second.cosine[0]
    constant = turned.constant
    for d in range(3):
        turned.inner[0, d] = constant[0, d] + k2 * constant[1, d] + s2 * constant[2, d]
        turned.rest[d] = k2 * constant[2, d] - s2 * constant[1, d]
    turn(u1, s1, k1, turned.rest, turned.by_second)
    split(u1, turned.inner[0], turned.parts[0])
    for d in range(3):
        turned.by_first[d] = k1 * turned.parts[0, 2, d] - s1 * turned.parts[0, 1, d]


@jit()
def leave_rest(turned: Turned, u1: Floats, first: Angle, second: Angle, k: int) -> None:
    """What coefficient k of the axis has beyond that which the angles make with a k-th coefficient of zero."""
    first.value[k] = 0.0
    second.value[k] = 0.0
    sine_term(first, k)
    sine_term(second, k)
    inner_term(turned, u1, second, k)
    for d in range(3):
        total = turned.parts[k, 0, d]
        for j in range(k + 1):
            total += first.cosine[j] * turned.parts[k - j, 1, d] + first.sine[j] * turned.parts[k - j, 2, d]
        turned.rest[d] = turned.axis[k, d] - total


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
    first, second = new_angle(), new_angle()
    turned = Turned(
        np.empty((4, 3)), np.empty((3, 3)), np.empty((4, 3)), np.empty((4, 3, 3)), np.empty(3), np.empty(3), np.empty(3)
    )
    split(frame[U2], frame[A0], turned.constant)
    for i in range(axis.shape[1]):
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                turned.axis[k, d] = axis[k, i, d] / factorial
        pole, side = angles_near(frame, pole_tolerance, turned.axis[0], near[i], solutions)
        start_angle(first, solutions[side, 0])
        start_angle(second, solutions[side, 1])
        begin(turned, u1, first, second)
        g1, g2, rest = turned.by_first, turned.by_second, turned.rest
        g11, g12, g22 = dot(g1, g1), dot(g1, g2), dot(g2, g2)
        det = g11 * g22 - g12 * g12
        for k in range(1, 4):
            leave_rest(turned, u1, first, second, k)
            r1, r2 = dot(rest, g1), dot(rest, g2)
            if pole:
                set_term(first, k, 0.0)
                set_term(second, k, r2 / g22)
            elif det > EDGE * g11 * g22:
                set_term(first, k, (g22 * r1 - g12 * r2) / det)
                set_term(second, k, (g11 * r2 - g12 * r1) / det)
            else:
                set_term(first, k, np.nan)
                set_term(second, k, np.nan)
            inner_term(turned, u1, second, k)
        if not pole:
            drop_noise(turned.axis, math.sqrt(g11), first.value)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            out[k, i, 0] = first.value[k] * factorial
            out[k, i, 1] = second.value[k] * factorial

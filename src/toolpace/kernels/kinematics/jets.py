"""Derivatives of axis and joints to third order along a path parameter, by truncated Taylor arithmetic.

Arrays hold plain derivatives, shape (4, n, ...): value, first, second, third. `frame`: see chain.py.

A jet is the array of Taylor coefficients f, f', f''/2, f'''/6 along some parameter. Products of jets are
convolutions, and a function that solves a linear differential equation gives its coefficients one after the
other (Moore 1966; Griewank and Walther, Evaluating Derivatives, 2008, chapter 13).

The k-th coefficient of R1 R2 a0 is linear in the k-th coefficients of the two angles. So the rotary joints follow from
the tool axis one order after the other: what the coefficients below k make of the axis is subtracted from its own, and
the rest is shared out between the angles, two unknowns in three equations of rank two.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import dot, reciprocal, second_angle, solve_rotary, turn
from toolpace.kernels.kinematics.geometry import A0, C0, C1, C2, LINEAR, U1, U2, Chain

NOISE = 64.0 * 2.0**-52
"""Rounding of a tool axis and of what is made of it: a derivative of the first joint below it is taken for none."""
EDGE = 1e-14
"""Squared sine between the motions that both joints give the axis, at which the two solutions meet."""


class Angle(NamedTuple):
    """Jets (4,) of an angle and of its sine and cosine."""

    value: Floats
    sine: Floats
    cosine: Floats


@jit()
def load_angle(rotary: Floats, i: int, joint: int, angle: Angle) -> None:
    """Taylor coefficients of a rotary joint at point i, and of its sine and cosine."""
    start_angle(angle, rotary[0, i, joint])
    angle.value[1] = rotary[1, i, joint]
    angle.value[2] = rotary[2, i, joint] / 2.0
    angle.value[3] = rotary[3, i, joint] / 6.0
    for k in range(1, 4):
        sine_term(angle, k)


@jit()
def axis_jets(frame: Floats, rotary: Floats, out: Floats) -> None:
    """Derivatives (4, n, 3) of the tool axis from those (4, n, 2) of the rotary joints."""
    parts = np.empty((3, 3))
    scratch = np.empty((4, 3, 3))
    inner = np.empty((4, 3))
    turned = np.empty((4, 3))
    first, second = new_angle(), new_angle()
    split(frame[U2], frame[A0], parts)
    for i in range(rotary.shape[1]):
        load_angle(rotary, i, 0, first)
        load_angle(rotary, i, 1, second)
        turn_constant(parts, second, inner)
        turn_jet(frame[U1], first, inner, scratch, turned)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                out[k, i, d] = turned[k, d] * factorial


@jit()
def linear_jets(geometry: Chain, tip: Floats, rotary: Floats, q: Floats) -> int:
    """Derivatives (4, n, 5) of all joints from those of the tip (4, n, 3) and of the rotary joints (4, n, 2).

    The columns M of the linear joints and the right side b are jets; M q = b gives the coefficients one by
    one: q_k = inverse(M_0) (b_k - sum over j = 1..k of M_j q_(k-j)). Returns the first singular point, or
    -1.
    """
    frame, group, place = geometry
    const = np.empty((4, 3, 3))
    scratch = np.empty((4, 3, 3))
    column = np.zeros((3, 4, 3))
    start = np.empty((3, 3))
    inverse = np.empty((3, 3))
    inner = np.empty((4, 3))
    b = np.empty((4, 3))
    value = np.empty((4, 3))
    first, second = new_angle(), new_angle()
    split(frame[U2], frame[C2], const[0])
    for j in range(3):
        copy(frame[LINEAR + j], column[j, 0])
        split(frame[U1] if group[j] == 1 else frame[U2], frame[LINEAR + j], const[1 + j])
    singular = -1
    for i in range(tip.shape[1]):
        load_angle(rotary, i, 0, first)
        load_angle(rotary, i, 1, second)
        turn_constant(const[0], second, inner)
        for d in range(3):
            inner[0, d] += frame[C1, d]
        turn_jet(frame[U1], first, inner, scratch, b)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                b[k, d] = tip[k, i, d] / factorial - b[k, d]
        for d in range(3):
            b[0, d] += frame[C0, d]
        for j in range(3):
            if group[j] == 1:
                turn_constant(const[1 + j], first, column[j])
            elif group[j] == 2:
                turn_constant(const[1 + j], second, inner)
                turn_jet(frame[U1], first, inner, scratch, column[j])
            copy(column[j, 0], start[j])
        if not reciprocal(start, inverse) and singular < 0:
            singular = i
        solve_orders(geometry, column, inverse, b, value)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for j in range(3):
                q[k, i, place[2 + j]] = value[k, j] * factorial
            q[k, i, place[0]] = rotary[k, i, 0]
            q[k, i, place[1]] = rotary[k, i, 1]
    return singular


@jit()
def solve_orders(geometry: Chain, column: Floats, inverse: Floats, b: Floats, value: Floats) -> None:
    """Taylor coefficients `value` (4, 3) of the linear joints, from M q = b order by order; b (4, 3) is used up.

    column (3, 4, 3): jets of the columns of M; inverse (3, 3) of M_0. Columns of group 0 are constant.
    """
    for k in range(4):
        for m in range(1, k + 1):
            for j in range(3):
                if geometry.group[j] > 0:
                    for d in range(3):
                        b[k, d] -= column[j, m, d] * value[k - m, j]
        for j in range(3):
            value[k, j] = dot(inverse[j], b[k])


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


@jit()
def new_angle() -> Angle:
    """Room for an angle."""
    return Angle(np.empty(4), np.empty(4), np.empty(4))


@jit()
def start_angle(angle: Angle, value: float) -> None:
    """Write coefficient 0 of all three jets."""
    angle.value[0] = value
    angle.sine[0] = math.sin(value)
    angle.cosine[0] = math.cos(value)


@jit()
def sine_term(angle: Angle, k: int) -> None:
    """Write coefficient k >= 1 of the sine and cosine, given the ones below k and coefficient k of the angle."""
    s = 0.0
    c = 0.0
    for j in range(1, k + 1):
        s += j * angle.value[j] * angle.cosine[k - j]
        c -= j * angle.value[j] * angle.sine[k - j]
    angle.sine[k] = s / k
    angle.cosine[k] = c / k


@jit(inline=True)
def split(direction: Floats, vector: Floats, parts: Floats) -> None:
    """Split a vector (3,) for turning about a direction: R(t) v = parts[0] + cos(t) parts[1] + sin(t) parts[2]."""
    along = direction[0] * vector[0] + direction[1] * vector[1] + direction[2] * vector[2]
    for i in range(3):
        parts[0, i] = along * direction[i]
        parts[1, i] = vector[i] - parts[0, i]
    parts[2, 0] = direction[1] * vector[2] - direction[2] * vector[1]
    parts[2, 1] = direction[2] * vector[0] - direction[0] * vector[2]
    parts[2, 2] = direction[0] * vector[1] - direction[1] * vector[0]


@jit()
def turn_constant(parts: Floats, angle: Angle, out: Floats) -> None:
    """Jet (4, 3) of a constant vector turned by a jet of angles; parts (3, 3) from `split`."""
    for k in range(4):
        for i in range(3):
            out[k, i] = angle.cosine[k] * parts[1, i] + angle.sine[k] * parts[2, i]
    for i in range(3):
        out[0, i] += parts[0, i]


@jit()
def turn_jet(direction: Floats, angle: Angle, vector: Floats, parts: Floats, out: Floats) -> None:
    """Jet (4, 3) of a vector jet (4, 3) turned by a jet of angles; parts (4, 3, 3) is scratch."""
    for k in range(4):
        split(direction, vector[k], parts[k])
    for k in range(4):
        for i in range(3):
            total = parts[k, 0, i]
            for j in range(k + 1):
                total += angle.cosine[j] * parts[k - j, 1, i] + angle.sine[j] * parts[k - j, 2, i]
            out[k, i] = total

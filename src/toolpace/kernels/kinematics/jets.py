"""Derivatives of the kinematics to third order along a path parameter, by Taylor arithmetic.

Arrays hold plain derivatives, shape (4, n, ...): value, first, second, third. `frame`: see chain.py.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import dot, reciprocal
from toolpace.kernels.kinematics.geometry import A0, C0, C1, C2, LINEAR, U1, U2, Chain
from toolpace.kernels.kinematics.taylor import Angle, new_angle, sine_term, split, start_angle, turn_constant, turn_jet


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

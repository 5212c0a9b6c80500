"""Derivatives of the kinematics to third order along a path parameter, by Taylor arithmetic.

Arrays hold plain derivatives, shape (4, n, ...): value, first, second, third. `frame`, `group`, `place`:
see chain.py.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.chain import dot, reciprocal, second_angle, solve_rotary, turn
from toolpace.kernels.kinematics.taylor import sine_term, split, turn_constant, turn_jet

NOISE = 64.0 * 2.0**-52
"""Rounding of a tool axis and of what is made of it: a derivative of the first joint below it is taken for none."""


@jit()
def load_angle(rotary: Any, i: int, joint: int, angle: Any, sine: Any, cosine: Any) -> None:
    """Taylor coefficients (4,) of a rotary joint at point i, and of its sine and cosine."""
    angle[0] = rotary[0, i, joint]
    angle[1] = rotary[1, i, joint]
    angle[2] = rotary[2, i, joint] / 2.0
    angle[3] = rotary[3, i, joint] / 6.0
    sine[0] = math.sin(angle[0])
    cosine[0] = math.cos(angle[0])
    for k in range(1, 4):
        sine_term(angle, sine, cosine, k)


@jit()
def axis_jets(frame: Any, rotary: Any, out: Any) -> None:
    """Derivatives (4, n, 3) of the tool axis from those (4, n, 2) of the rotary joints."""
    parts = np.empty((3, 3))
    scratch = np.empty((4, 3, 3))
    inner = np.empty((4, 3))
    turned = np.empty((4, 3))
    angle, s1, k1, s2, k2 = np.empty(4), np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    split(frame[1], frame[2], parts[0], parts[1], parts[2])
    for i in range(rotary.shape[1]):
        load_angle(rotary, i, 0, angle, s1, k1)
        load_angle(rotary, i, 1, angle, s2, k2)
        turn_constant(parts, s2, k2, inner)
        turn_jet(frame[0], s1, k1, inner, scratch, turned)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                out[k, i, d] = turned[k, d] * factorial


@jit()
def linear_jets(frame: Any, group: Any, place: Any, tip: Any, rotary: Any, q: Any) -> int:
    """Derivatives (4, n, 5) of all joints from those of the tip (4, n, 3) and of the rotary joints (4, n, 2).

    The columns M of the linear joints and the right side b are jets; M q = b gives the coefficients one by
    one: q_k = inverse(M_0) (b_k - sum over j = 1..k of M_j q_(k-j)). Returns the first singular point, or
    -1.
    """
    const = np.empty((4, 3, 3))
    scratch = np.empty((4, 3, 3))
    column = np.zeros((3, 4, 3))
    start = np.empty((3, 3))
    inverse = np.empty((3, 3))
    inner = np.empty((4, 3))
    b = np.empty((4, 3))
    value = np.empty((4, 3))
    right = np.empty(3)
    angle, s1, k1, s2, k2 = np.empty(4), np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    split(frame[1], frame[5], const[0, 0], const[0, 1], const[0, 2])
    for j in range(3):
        column[j, 0] = frame[6 + j]
        by = frame[0] if group[j] == 1 else frame[1]
        split(by, frame[6 + j], const[1 + j, 0], const[1 + j, 1], const[1 + j, 2])
    singular = -1
    for i in range(tip.shape[1]):
        load_angle(rotary, i, 0, angle, s1, k1)
        load_angle(rotary, i, 1, angle, s2, k2)
        turn_constant(const[0], s2, k2, inner)
        for d in range(3):
            inner[0, d] += frame[4, d]
        turn_jet(frame[0], s1, k1, inner, scratch, b)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                b[k, d] = tip[k, i, d] / factorial - b[k, d]
        for d in range(3):
            b[0, d] += frame[3, d]
        for j in range(3):
            if group[j] == 1:
                turn_constant(const[1 + j], s1, k1, column[j])
            elif group[j] == 2:
                turn_constant(const[1 + j], s2, k2, inner)
                turn_jet(frame[0], s1, k1, inner, scratch, column[j])
            start[j] = column[j, 0]
        if not reciprocal(start, inverse) and singular < 0:
            singular = i
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                right[d] = b[k, d]
            for m in range(1, k + 1):
                for j in range(3):
                    if group[j] > 0:
                        for d in range(3):
                            right[d] -= column[j, m, d] * value[k - m, j]
            for j in range(3):
                value[k, j] = dot(inverse[j], right)
                q[k, i, place[2 + j]] = value[k, j] * factorial
            q[k, i, place[0]] = rotary[k, i, 0]
            q[k, i, place[1]] = rotary[k, i, 1]
    return singular


@jit()
def nearest(solutions: Any, near: Any) -> int:
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
def drop_noise(axis: Any, off: float, first: Any) -> None:
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
def rotary_jets(frame: Any, pole_tolerance: float, axis: Any, near: Any, out: Any) -> None:
    """Derivatives (4, n, 2) of the rotary joints from those of the axis (4, n, 3), nearest to `near` (n, 2).

    The k-th coefficient of R1 R2 a0 is linear in the k-th coefficients of the angles: two unknowns, three
    equations of rank two. At the pole the first angle keeps the value of `near` and rests; next to it its
    derivatives are none where they would be rounding only, as on an axis that passes right through. Where the two
    solutions meet away from the pole (the edge of reach) no finite derivative exists, and the result is
    nan.
    """
    solutions = np.empty((2, 2))
    parts = np.empty((3, 3))
    inner = np.empty((4, 3))
    split1 = np.empty((4, 3, 3))
    a = np.empty((4, 3))
    back = np.empty(3)
    g1 = np.empty(3)
    g2 = np.empty(3)
    rest = np.empty(3)
    t1, s1, k1 = np.empty(4), np.empty(4), np.empty(4)
    t2, s2, k2 = np.empty(4), np.empty(4), np.empty(4)
    u1 = frame[0]
    split(frame[1], frame[2], parts[0], parts[1], parts[2])
    for i in range(axis.shape[1]):
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            for d in range(3):
                a[k, d] = axis[k, i, d] / factorial
        pole = solve_rotary(frame, pole_tolerance, a[0], solutions)
        if pole:
            turn(u1, -math.sin(near[i, 0]), math.cos(near[i, 0]), a[0], back)
            for side in range(2):
                solutions[side, 0] = near[i, 0]
                solutions[side, 1] = second_angle(frame, back)
        side = nearest(solutions, near[i])
        t1[0], t2[0] = solutions[side, 0], solutions[side, 1]
        s1[0], k1[0], s2[0], k2[0] = math.sin(t1[0]), math.cos(t1[0]), math.sin(t2[0]), math.cos(t2[0])
        for d in range(3):
            inner[0, d] = parts[0, d] + k2[0] * parts[1, d] + s2[0] * parts[2, d]
            back[d] = k2[0] * parts[2, d] - s2[0] * parts[1, d]
        turn(u1, s1[0], k1[0], back, g2)
        split(u1, inner[0], split1[0, 0], split1[0, 1], split1[0, 2])
        for d in range(3):
            g1[d] = k1[0] * split1[0, 2, d] - s1[0] * split1[0, 1, d]
        g11, g12, g22 = dot(g1, g1), dot(g1, g2), dot(g2, g2)
        det = g11 * g22 - g12 * g12
        for k in range(1, 4):
            t1[k] = 0.0
            t2[k] = 0.0
            sine_term(t1, s1, k1, k)
            sine_term(t2, s2, k2, k)
            for d in range(3):
                inner[k, d] = k2[k] * parts[1, d] + s2[k] * parts[2, d]
            split(u1, inner[k], split1[k, 0], split1[k, 1], split1[k, 2])
            for d in range(3):
                total = split1[k, 0, d]
                for j in range(k + 1):
                    total += k1[j] * split1[k - j, 1, d] + s1[j] * split1[k - j, 2, d]
                rest[d] = a[k, d] - total
            r1, r2 = dot(rest, g1), dot(rest, g2)
            if pole:
                t2[k] = r2 / g22
            elif det > 1e-14 * g11 * g22:
                t1[k] = (g22 * r1 - g12 * r2) / det
                t2[k] = (g11 * r2 - g12 * r1) / det
            else:
                t1[k] = np.nan
                t2[k] = np.nan
            s1[k] += k1[0] * t1[k]
            k1[k] -= s1[0] * t1[k]
            s2[k] += k2[0] * t2[k]
            k2[k] -= s2[0] * t2[k]
            for d in range(3):
                inner[k, d] = k2[k] * parts[1, d] + s2[k] * parts[2, d]
            split(u1, inner[k], split1[k, 0], split1[k, 1], split1[k, 2])
        if not pole:
            drop_noise(a, math.sqrt(g11), t1)
        factorial = 1.0
        for k in range(4):
            factorial *= max(k, 1)
            out[k, i, 0] = t1[k] * factorial
            out[k, i, 1] = t2[k] * factorial

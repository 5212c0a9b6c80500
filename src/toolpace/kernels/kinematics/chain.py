"""Forward and inverse kinematics of five-axis chains on plain arrays.

Seen from the workpiece, every machine is one chain of five motions that ends at the tool: the joints of the
workpiece side backwards, then those of the tool side. Two of them turn, R1 (nearest the workpiece) and R2;
the linear ones lie before R1 (group 0), between (group 1) or after R2 (group 2). With u1, u2 the axes of
rotation,

    axis      =  R1 R2 a0
    tip + c0  =  L0 + R1 (c1 + L1 + R2 (c2 + L2)),    Lg = sum over the joints of group g of direction * q

`frame` (9, 3) holds u1, u2, a0, c0, c1, c2 and the three linear directions, all in the orientation of the
workpiece frame at joints zero, signed so that a joint of the workpiece side counts backwards; see geometry.py
for what else a chain has.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.geometry import A0, C0, C1, C2, LINEAR, U1, U2, Chain

Vector = Floats | tuple[float, float, float]
"""(3,)"""

REACH_SLACK = 1e-9
"""How far the squared half-chord of the cones may be negative (1e-9 rad of tilt) and count as touching."""
SINGULAR = 1e-9
"""Volume spanned by the three linear directions below which they cannot move the tip in space."""


@jit(inline=True)
def dot(a: Vector, b: Vector) -> float:
    """Inner product of two vectors (3,)."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@jit(inline=True)
def triple(a: Vector, b: Vector, c: Vector) -> float:
    """a . (b x c)."""
    volume: float = (
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return volume


@jit(inline=True)
def turn(u: Floats, sine: float, cosine: float, v: Floats, out: Floats) -> None:
    """Rodrigues: turn v about the unit vector u; `out` may be `v`."""
    along = dot(u, v) * (1.0 - cosine)
    x = cosine * v[0] + sine * (u[1] * v[2] - u[2] * v[1]) + along * u[0]
    y = cosine * v[1] + sine * (u[2] * v[0] - u[0] * v[2]) + along * u[1]
    z = cosine * v[2] + sine * (u[0] * v[1] - u[1] * v[0]) + along * u[2]
    out[0] = x
    out[1] = y
    out[2] = z


@jit()
def forward(geometry: Chain, q: Floats, tip: Floats, axis: Floats) -> None:
    """Joint positions (n, 5) to tips (n, 3) and unit tool axes (n, 3) in the workpiece frame."""
    frame, group, place = geometry
    for i in range(len(q)):
        t1 = q[i, place[0]]
        t2 = q[i, place[1]]
        s1, k1, s2, k2 = math.sin(t1), math.cos(t1), math.sin(t2), math.cos(t2)
        turn(frame[U2], s2, k2, frame[A0], axis[i])
        turn(frame[U1], s1, k1, axis[i], axis[i])
        copy(frame[C2], tip[i])
        for g in range(2, -1, -1):
            for j in range(3):
                if group[j] == g:
                    for d in range(3):
                        tip[i, d] += frame[LINEAR + j, d] * q[i, place[2 + j]]
            if g > 0:
                turn(frame[U1 if g == 1 else U2], s2 if g == 2 else s1, k2 if g == 2 else k1, tip[i], tip[i])
                if g == 2:
                    for d in range(3):
                        tip[i, d] += frame[C1, d]
        for d in range(3):
            tip[i, d] -= frame[C0, d]


@jit()
def axes(frame: Floats, rotary: Floats, axis: Floats) -> None:
    """Rotary positions (n, 2) to unit tool axes (n, 3)."""
    for i in range(len(rotary)):
        turn(frame[U2], math.sin(rotary[i, 1]), math.cos(rotary[i, 1]), frame[A0], axis[i])
        turn(frame[U1], math.sin(rotary[i, 0]), math.cos(rotary[i, 0]), axis[i], axis[i])


@jit(inline=True)
def second_angle(frame: Floats, target: Vector) -> float:
    """Angle of R2 that brings R2 a0 nearest to the target (3,), itself given in the frame before R1."""
    u2 = frame[U2]
    a0 = frame[A0]
    return math.atan2(triple(u2, a0, target), dot(a0, target) - dot(u2, a0) * dot(u2, target))


@jit()
def solve_rotary(frame: Floats, pole_tolerance: float, a: Floats, solutions: Floats) -> bool:
    """Both angles (2, 2) [solution, joint] with R1 R2 a0 = a, or nan; returns whether a lies at the pole.

    Two rotations that carry one direction into another (Paden and Kahan's second subproblem; Murray, Li and
    Sastry 1994, 3.3): b = R2 a0 lies on a cone about u2, and on the cone about u1 through a. Its part
    across u1 has length w = |u1 x a| and the component p along u2, so the other component is the root of (w
    - p)(w + p). Written this way, no digits are lost near the pole (a along u1), where w and p are small
    together. At the pole the first angle is free and returned as zero.
    """
    u1 = frame[U1]
    u2 = frame[U2]
    a0 = frame[A0]
    slant = dot(u1, u2)
    lean = dot(u2, a0)
    h = dot(u1, a)
    ax, ay, az = a[0] - h * u1[0], a[1] - h * u1[1], a[2] - h * u1[2]
    wx, wy, wz = u1[1] * a[2] - u1[2] * a[1], u1[2] * a[0] - u1[0] * a[2], u1[0] * a[1] - u1[1] * a[0]
    ww = wx * wx + wy * wy + wz * wz
    w = math.sqrt(ww)
    norm = math.sqrt(1.0 - slant * slant)
    offset = lean - slant if h > 0.0 else lean + slant
    if abs(offset) < 1e-14:
        offset = 0.0
    rest = ww / (1.0 + abs(h))
    p = (offset + (slant * rest if h > 0.0 else -slant * rest)) / norm
    square = (w - p) * (w + p)
    pole = w < pole_tolerance
    # An offset between pole and reach (an axis rounded in the file) must not make the pole unreachable.
    if not square >= -(REACH_SLACK if not pole else max(REACH_SLACK, 4.0 * pole_tolerance * pole_tolerance)):
        solutions[:] = np.nan
        return pole
    other = math.sqrt(max(square, 0.0))
    e2 = (u1[1] * u2[2] - u1[2] * u2[1], u1[2] * u2[0] - u1[0] * u2[2], u1[0] * u2[1] - u1[1] * u2[0])
    for side in range(2):
        r = other if side == 0 else -other
        bx = (p * (u2[0] - slant * u1[0]) + r * e2[0]) / norm
        by = (p * (u2[1] - slant * u1[1]) + r * e2[1]) / norm
        bz = (p * (u2[2] - slant * u1[2]) + r * e2[2]) / norm
        across = bx * ax + by * ay + bz * az
        cross = u1[0] * (by * az - bz * ay) + u1[1] * (bz * ax - bx * az) + u1[2] * (bx * ay - by * ax)
        solutions[side, 0] = 0.0 if pole else math.atan2(cross, across)
        solutions[side, 1] = second_angle(frame, (bx + h * u1[0], by + h * u1[1], bz + h * u1[2]))
    return pole


@jit()
def rotary_solutions(frame: Floats, pole_tolerance: float, axis: Floats, solutions: Floats, pole: Bools) -> None:
    """`solve_rotary` for axes (n, 3): solutions (n, 2, 2), pole (n,)."""
    for i in range(len(axis)):
        pole[i] = solve_rotary(frame, pole_tolerance, axis[i], solutions[i])


@jit()
def linear_columns(geometry: Chain, s1: float, k1: float, s2: float, k2: float, columns: Floats) -> None:
    """How each linear joint moves the tip in the workpiece frame, one row (3,) a joint; sine, cosine of R1, R2."""
    frame, group, _ = geometry
    for j in range(3):
        copy(frame[LINEAR + j], columns[j])
        if group[j] == 2:
            turn(frame[U2], s2, k2, columns[j], columns[j])
        if group[j] >= 1:
            turn(frame[U1], s1, k1, columns[j], columns[j])


@jit()
def reciprocal(columns: Floats, inverse: Floats) -> bool:
    """Inverse of the matrix whose columns are the rows of `columns`; False where they span no space."""
    volume = triple(columns[0], columns[1], columns[2])
    if not abs(volume) > SINGULAR:
        inverse[:] = np.nan
        return False
    for j in range(3):
        a = columns[(j + 1) % 3]
        b = columns[(j + 2) % 3]
        inverse[j, 0] = (a[1] * b[2] - a[2] * b[1]) / volume
        inverse[j, 1] = (a[2] * b[0] - a[0] * b[2]) / volume
        inverse[j, 2] = (a[0] * b[1] - a[1] * b[0]) / volume
    return True


@jit()
def joints_at(geometry: Chain, tip: Floats, rotary: Floats, q: Floats) -> int:
    """Tips (n, 3) and rotary positions (n, 2) to joints (n, 5); returns the first singular point, or -1."""
    frame, _, place = geometry
    columns = np.empty((3, 3))
    inverse = np.empty((3, 3))
    b = np.empty(3)
    singular = -1
    for i in range(len(tip)):
        s1, k1 = math.sin(rotary[i, 0]), math.cos(rotary[i, 0])
        s2, k2 = math.sin(rotary[i, 1]), math.cos(rotary[i, 1])
        turn(frame[U2], s2, k2, frame[C2], b)
        for d in range(3):
            b[d] += frame[C1, d]
        turn(frame[U1], s1, k1, b, b)
        for d in range(3):
            b[d] = tip[i, d] + frame[C0, d] - b[d]
        linear_columns(geometry, s1, k1, s2, k2, columns)
        if not reciprocal(columns, inverse) and singular < 0:
            singular = i
        q[i, place[0]] = rotary[i, 0]
        q[i, place[1]] = rotary[i, 1]
        for j in range(3):
            q[i, place[2 + j]] = dot(inverse[j], b)
    return singular

"""Torques of a tree of bodies along a path, by d'Alembert's principle in Lagrange's form: machine/dynamics has it.

A body does work through the columns of its Jacobians, one for each joint between the bed and itself: what the joint's
motion does to its centre and to its rotation. All vectors are in the frame of the bed, "change" is the derivative along
the path.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit


class Bodies(NamedTuple):
    """m bodies, each on the joint that moves it, with every joint at zero."""

    order: Ints
    """(m,) the bodies, none before the one that it sits on."""
    parent: Ints
    """(m,) the body that each sits on, -1 for the bed."""
    rotary: Bools
    """(m,) whether its joint turns."""
    axis: Floats
    """(m, 3) unit vectors."""
    point: Floats
    """(m, 3) on the axis of a rotary joint."""
    mass: Floats
    """(m,)"""
    centre: Floats
    """(m, 3) of the mass."""
    tensor: Floats
    """(m, 3, 3) inertia about the centre."""
    gravity: Floats
    """(3,)"""


class Pose(NamedTuple):
    """The bodies at one place of a path."""

    turn: Floats
    """(m, 3, 3) from directions with every joint at zero."""
    spin: Floats
    """(m, 3) rotation along the path."""
    shift: Floats
    """(m, 2, 3) where the origin of the bed has gone with a body, and its change."""
    axis: Floats
    """(m, 2, 3) of its joint, and its change."""
    point: Floats
    """(m, 2, 3)"""
    centre: Floats
    """(m, 2, 3)"""


@jit(inline=True)
def crossed(a: Floats, b: Floats, out: Floats) -> None:
    """Add a x b to `out` (3,)."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@jit(inline=True)
def carried(turn: Floats, spin: Floats, shift: Floats, place: Floats, arm: Floats, out: Floats) -> None:
    """Set out (2, 3): a point of a body, told with every joint at zero, and its change; `arm` (3,) is room for work."""
    for i in range(3):
        arm[i] = turn[i, 0] * place[0] + turn[i, 1] * place[1] + turn[i, 2] * place[2]
        out[0, i], out[1, i] = shift[0, i] + arm[i], shift[1, i]
    crossed(spin, arm, out[1])


@jit(inline=True)
def turned(below: Floats, u: Floats, angle: float, out: Floats) -> None:
    """Set out (3, 3): `below` (3, 3) times the rotation about the unit vector u (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    for j in range(3):
        k, h = (j + 1) % 3, (j + 2) % 3
        # column j of the rotation
        own = (1.0 - c) * u[j]
        same, after, before = c + own * u[j], own * u[k] + s * u[h], own * u[h] - s * u[k]
        for i in range(3):
            out[i, j] = below[i, j] * same + below[i, k] * after + below[i, h] * before


@jit(inline=True)
def move(bodies: Bodies, i: int, q: float, first: float, bed: Pose, pose: Pose, arm: Floats) -> None:
    """Set the pose of a body whose joint is at q and moves by `first` along the path."""
    rotary, p = bodies.rotary[i], bodies.parent[i]
    below, k = (bed, 0) if p < 0 else (pose, p)
    turn, spin, shift = below.turn[k], below.spin[k], below.shift[k]
    u, axis = bodies.axis[i], pose.axis[i]
    for d in range(3):
        axis[0, d] = turn[d, 0] * u[0] + turn[d, 1] * u[1] + turn[d, 2] * u[2]
        axis[1, d] = 0.0
    crossed(spin, axis[0], axis[1])
    carried(turn, spin, shift, bodies.point[i], arm, pose.point[i])
    if rotary:
        turned(turn, u, q, pose.turn[i])
        for d in range(3):
            pose.spin[i, d] = spin[d] + axis[0, d] * first
        for d in range(3):
            own = pose.turn[i, d]
            arm[d] = -(own[0] * bodies.point[i, 0] + own[1] * bodies.point[i, 1] + own[2] * bodies.point[i, 2])
            pose.shift[i, 0, d], pose.shift[i, 1, d] = pose.point[i, 0, d] + arm[d], pose.point[i, 1, d]
        crossed(pose.spin[i], arm, pose.shift[i, 1])
    else:
        for d in range(3):
            for j in range(3):
                pose.turn[i, d, j] = turn[d, j]
            pose.spin[i, d] = spin[d]
            pose.shift[i, 0, d] = shift[0, d] + axis[0, d] * q
            pose.shift[i, 1, d] = shift[1, d] + axis[1, d] * q + axis[0, d] * first
    carried(pose.turn[i], pose.spin[i], pose.shift[i], bodies.centre[i], arm, pose.centre[i])


@jit(inline=True)
def column(bodies: Bodies, pose: Pose, b: int, i: int, arm: Floats, out: Floats) -> None:
    """Set out (4, 3): what the joint i does to centre and rotation of the body b, and the changes of both."""
    out[:] = 0.0
    turns = 1 if bodies.rotary[i] else 0
    for d in range(3):
        out[turns, d], out[2 + turns, d] = pose.axis[i, 0, d], pose.axis[i, 1, d]
    if turns:
        for d in range(3):
            arm[d] = pose.centre[b, 0, d] - pose.point[i, 0, d]
        crossed(pose.axis[i, 0], arm, out[0])
        crossed(pose.axis[i, 1], arm, out[2])
        for d in range(3):
            arm[d] = pose.centre[b, 1, d] - pose.point[i, 1, d]
        crossed(pose.axis[i, 0], arm, out[2])


@jit(inline=True)
def pose_of(m: int) -> Pose:
    """Room for one, of m bodies at rest."""
    turn = np.zeros((m, 3, 3))
    for i in range(m):
        for d in range(3):
            turn[i, d, d] = 1.0
    parts = np.zeros((4, m, 2, 3))
    return Pose(turn, np.zeros((m, 3)), parts[0], parts[1], parts[2], parts[3])


@jit(inline=True)
def inertia_moment(pose: Pose, bodies: Bodies, b: int, spin: Floats, out: Floats) -> None:
    """Set out (3,): the inertia of the body b about its centre, turned with it, times `spin` (3,)."""
    turn, tensor = pose.turn[b], bodies.tensor[b]
    out[:] = 0.0
    for j in range(3):
        moment = 0.0
        for k in range(3):
            moment += tensor[j, k] * (turn[0, k] * spin[0] + turn[1, k] * spin[1] + turn[2, k] * spin[2])
        for d in range(3):
            out[d] += turn[d, j] * moment


@jit()
def along(bodies: Bodies, q: Floats, out: Floats) -> None:
    """Add to out (3, n, m) what the torques are times d2s/dt2, times (ds/dt)^2 and at rest, from the path q (3 or more,
    n, m)."""
    n, m = q.shape[1], q.shape[2]
    bed, pose, arm, columns = pose_of(1), pose_of(m), np.empty(3), np.empty((m, 4, 3))
    motion, moments = np.empty((4, 3)), np.empty((2, 3))
    for s in range(n):
        for i in bodies.order:
            move(bodies, i, q[0, s, i], q[1, s, i], bed, pose, arm)
        for b in range(m):
            # velocity and spin of the body by s, and what they change by
            motion[:] = 0.0
            i = b
            while i >= 0:
                one = columns[i]
                column(bodies, pose, b, i, arm, one)
                for d in range(3):
                    motion[0, d] += one[0, d] * q[1, s, i]
                    motion[1, d] += one[1, d] * q[1, s, i]
                    motion[2, d] += one[2, d] * q[1, s, i] + one[0, d] * q[2, s, i]
                    motion[3, d] += one[3, d] * q[1, s, i] + one[1, d] * q[2, s, i]
                i = bodies.parent[i]
            inertia_moment(pose, bodies, b, motion[1], moments[0])
            inertia_moment(pose, bodies, b, motion[3], moments[1])
            crossed(motion[1], moments[0], moments[1])
            mass = bodies.mass[b]
            i = b
            while i >= 0:
                one = columns[i]
                for d in range(3):
                    out[0, s, i] += mass * one[0, d] * motion[0, d] + one[1, d] * moments[0, d]
                    out[1, s, i] += mass * one[0, d] * motion[2, d] + one[1, d] * moments[1, d]
                    out[2, s, i] -= mass * one[0, d] * bodies.gravity[d]
                i = bodies.parent[i]

"""Arcs that round corners between lines and arcs within a tolerance."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ARC,
    BEGIN,
    END,
    KIND,
    LENGTH,
    LINE,
    NOMINAL,
    SIDEWAYS,
    SWEEP,
    TOLERANCE,
    TOP,
    Blocks,
    Control,
    most_speed,
)
from toolpace.kernels.linuxcnc.sides import SMALL_ANGLE, Rounding, Side, arc_side, in_its_plane, leaving, no_rounding
from toolpace.kernels.linuxcnc.touching import placed
from toolpace.kernels.linuxcnc.vectors import Vector, across, dot, of_block

SMALL_ARC = 1e-6
"""[mm]"""
MOST_OF_TOLERANCE = 0.25
"""Share of a block's length that a rounding may leave the corner by where no tolerance is given."""


@jit()
def round_corner(b: Blocks, q: Floats, k: int, new: int, j0: int, j1: int, control: Control) -> tuple[bool, Rounding]:
    """The rounding between segments k and new, of blocks j0 and j1; False where there can be none."""
    tangent0, tangent1 = of_block(b, j0, END), of_block(b, j1, BEGIN)
    theta = 0.5 * math.acos(max(-1.0, min(1.0, -dot(tangent0, tangent1))))
    if math.pi / 2 - theta < SMALL_ANGLE or theta < SMALL_ANGLE:
        return False, no_rounding()
    binormal = across(tangent0, tangent1)
    lines = q[k, KIND] == LINE and q[new, KIND] == LINE
    first = Side(tangent0, min(q[k, LENGTH], 0.5 * q[k, NOMINAL]), 0.0, False, 0.0)
    if q[k, KIND] == ARC:
        first = arc_side(b, j0, j1, q[k, SWEEP], theta, True)
    second = Side(tangent1, 0.5 * q[new, NOMINAL], 0.0, False, 0.0)
    if q[new, KIND] == ARC:
        second = arc_side(b, j1, j1, q[new, SWEEP], theta, False)
    if not (in_its_plane(b, q, k, j0, binormal) and in_its_plane(b, q, new, j1, binormal)):
        return False, no_rounding()
    half = min(theta - first.lean, theta - second.lean)
    if q[k, KIND] == ARC and q[new, KIND] == ARC and half < math.pi / 12:
        return False, no_rounding()
    tolerance = tolerance_of(q, k, new)
    found, plan = plan_of(q, k, new, control, first, second, half, tolerance, binormal, lines)
    if not found:
        return False, plan
    if lines:
        cut = plan.radius / math.tan(half)
        return True, leaving(plan, plan.radius, plan.angle, q[k, LENGTH] - cut, q[new, LENGTH] - cut)
    return placed(b, q, k, new, j0, j1, plan, first, second, tolerance, binormal, control)


@jit(inline=True)
def tolerance_of(q: Floats, k: int, new: int) -> float:
    """Most distance from the corner to the rounding."""
    found = math.inf
    for s in (k, new):
        share = MOST_OF_TOLERANCE * q[s, NOMINAL]
        found = min(found, share if q[s, TOLERANCE] == 0.0 else min(share, q[s, TOLERANCE]))
    return found


@jit(inline=True)
def plan_of(
    q: Floats, k: int, new: int, control: Control, first: Side, second: Side, half: float, tolerance: float,
    binormal: Vector, lines: bool,
) -> tuple[bool, Rounding]:  # fmt: skip
    """Radius and speed: as fast as the normal acceleration allows within the tolerance, and no wider than needed."""
    phi = math.pi - 2.0 * half
    most = in_plane(binormal, control.acceleration)
    normal_most = SIDEWAYS * most
    asked = max(most_speed(q, k, control, 1.0), most_speed(q, new, control, 1.0))
    goal = max(most_speed(q, k, control, control.override), most_speed(q, new, control, control.override))
    planar = in_plane(binormal, control.velocity)
    if lines:
        planar = max(planar, altitude(q, k, new, first, second, phi))
    goal = min(goal, planar)
    reach = min(min(first.reach, second.reach), math.cos(half) * tolerance / (1.0 - math.sin(half)))
    widest = math.tan(half) * reach
    speed = min(math.sqrt(normal_most * widest), goal)
    # as much of the blocks as an overlap at half the acceleration would take
    time = min(math.sqrt(most * reach), speed) / (0.5 * most)
    radius = max(speed * speed / normal_most, min(time * speed / phi, widest))
    if radius < 1e-12 or radius * phi < SMALL_ARC:
        return False, no_rounding()
    return True, Rounding(speed, asked, most, radius, phi, 0.0, 0.0)


@jit(inline=True)
def altitude(q: Floats, k: int, new: int, first: Side, second: Side, phi: float) -> float:
    """Height of the triangle of both segments' most velocities over the side between them."""
    steep = math.cos(min(phi, 0.49 * math.pi))
    v0, v1 = min(q[k, TOP], q[new, TOP] / steep), min(q[new, TOP], q[k, TOP] / steep)
    base = v0 * v0 + v1 * v1 - 2.0 * v0 * v1 * dot(first.direction, second.direction)
    found: float = v0 * v1 * math.sin(phi) / math.sqrt(base)
    return found


@jit()
def in_plane(normal: Vector, limits: Floats) -> float:
    """Most of a vector in a plane that keeps every axis within its limit, whatever its direction there."""
    found = math.inf
    for i in range(3):
        found = min(found, limits[i] / max(math.sqrt(max(1.0 - normal[i] ** 2, 0.0)), 1e-12))
    return found

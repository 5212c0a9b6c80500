"""Arcs that round corners between lines and arcs, within a tolerance or a quarter of the blocks."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ARC,
    LENGTH,
    LINE,
    NOMINAL,
    NORMAL,
    SWEEP,
    TOLERANCE,
    TOP,
    Blocks,
    Control,
    most_speed,
)
from toolpace.kernels.linuxcnc.vectors import across, between, dot, norm, on_circle, unit

SMALL_ANGLE = 1e-6
SMALL_ARC = 1e-6
"""[mm]"""
MOST_OF_TOLERANCE = 0.25
"""Share of a block's length that a rounding may leave the corner by where no tolerance is given."""
TANGENT_ERROR = 0.25
"""Share of the normal acceleration that a rounding's error of tangent may take within a cycle."""


class Rounding(NamedTuple):
    """A rounding that can be, and what it leaves of both segments."""

    speed: float
    """Most speed on it."""
    asked: float
    acceleration: float
    radius: float
    angle: float
    first: float
    """What is left of the segment before it: a length, or the sweep of an arc."""
    second: float


class Side(NamedTuple):
    """One of both segments, as a line towards the corner or away from it."""

    direction: Floats
    """(3,) of its chord."""
    reach: float
    """Most length along it."""
    lean: float
    """By how much the chord closes the half angle."""
    convex: bool
    most: float
    """Of an arc: most sweep that may be cut."""


@jit()
def no_rounding() -> Rounding:
    return Rounding(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit()
def leaving(plan: Rounding, radius: float, angle: float, first: float, second: float) -> Rounding:
    """A rounding as it was placed."""
    return Rounding(plan.speed, plan.asked, plan.acceleration, radius, angle, first, second)


@jit()
def line_side(direction: Floats, reach: float) -> Side:
    return Side(direction, reach, 0.0, False, 0.0)


@jit()
def arc_side(
    b: Blocks,
    j: int,
    tangent: Floats,
    other: Floats,
    corner: Floats,
    sweep: float,
    share: float,
    theta: float,
    ends: bool,
) -> Side:
    """An arc that ends in the corner, or starts there; sweep is what is left of it."""
    centre = b.centre[j]
    radius = norm(corner - centre)
    inside = dot(corner - centre, other) < 0.0
    convex = inside if ends else not inside
    most = min(sweep * share, theta if convex else math.pi / 2)
    if not convex:
        return Side(tangent, most * radius, 0.0, False, most)
    # the chord of half of what may be cut
    near = on_circle(b, j, b.sweep[j] - 0.5 * most if ends else (b.sweep[j] - sweep) + 0.5 * most)
    chord = unit(corner - near if ends else near - corner)
    return Side(chord, math.sin(0.25 * most) * radius, 0.25 * most, True, most)


@jit()
def round_corner(b: Blocks, q: Floats, k: int, new: int, j0: int, j1: int, control: Control) -> tuple[bool, Rounding]:
    """The rounding between segments k and new, of blocks j0 and j1; False where there can be none."""
    corner = b.corner[j1]
    tangent0, tangent1 = b.end[j0], b.begin[j1]
    theta = 0.5 * math.acos(max(-1.0, min(1.0, -dot(tangent0, tangent1))))
    binormal = unit(across(tangent0, tangent1))
    if math.pi / 2 - theta < SMALL_ANGLE or theta < SMALL_ANGLE:
        return False, no_rounding()
    lines = b.kind[j0] == LINE and b.kind[j1] == LINE
    if b.kind[j0] == LINE:
        first = line_side(tangent0, min(q[k, LENGTH], 0.5 * q[k, NOMINAL]))
    else:
        first = arc_side(b, j0, tangent0, tangent1, corner, q[k, SWEEP], 2.0 / 3.0, theta, True)
    if b.kind[j1] == LINE:
        second = line_side(tangent1, 0.5 * q[new, NOMINAL])
    else:
        second = arc_side(b, j1, tangent1, tangent0, corner, q[new, SWEEP], 1.0 / 3.0, theta, False)
    for j in (j0, j1):
        if b.kind[j] == ARC and abs(abs(dot(binormal, b.normal[j])) - 1.0) > 0.5 * SMALL_ANGLE**2 + 1e-15:
            return False, no_rounding()
    half = min(theta, theta - first.lean, theta - second.lean)
    if not lines and b.kind[j0] == ARC and b.kind[j1] == ARC and half < math.pi / 12:
        return False, no_rounding()
    tolerance = tolerance_of(q, k, new)
    found, plan = plan_of(q, k, new, control, first, second, half, tolerance, binormal, lines)
    if not found:
        return False, plan
    if lines:
        cut = plan.radius / math.tan(half)
        return True, leaving(plan, plan.radius, plan.angle, q[k, LENGTH] - cut, q[new, LENGTH] - cut)
    return placed(b, q, k, new, j0, j1, plan, first, second, tolerance, binormal, control)


@jit()
def tolerance_of(q: Floats, k: int, new: int) -> float:
    """Most distance from the corner to the rounding."""
    found = math.inf
    for s in (k, new):
        share = MOST_OF_TOLERANCE * q[s, NOMINAL]
        found = min(found, share if q[s, TOLERANCE] == 0.0 else min(share, q[s, TOLERANCE]))
    return found


@jit()
def plan_of(
    q: Floats, k: int, new: int, control: Control, first: Side, second: Side, half: float, tolerance: float,
    binormal: Floats, lines: bool,
) -> tuple[bool, Rounding]:  # fmt: skip
    """Radius and speed: as fast as the normal acceleration allows within the tolerance, and no wider than needed."""
    phi = math.pi - 2.0 * half
    most = in_plane(binormal, control.acceleration)
    normal_most = NORMAL * most
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


@jit()
def altitude(q: Floats, k: int, new: int, first: Side, second: Side, phi: float) -> float:
    """Height of the triangle of both segments' most velocities over the side between them."""
    steep = math.cos(min(phi, 0.49 * math.pi))
    v0, v1 = min(q[k, TOP], q[new, TOP] / steep), min(q[new, TOP], q[k, TOP] / steep)
    base = norm(second.direction * v1 - first.direction * v0)
    return v0 * v1 * math.sin(phi) / base


@jit()
def in_plane(normal: Floats, limits: Floats) -> float:
    """Most of a vector in a plane that keeps every axis within its limit, whatever its direction there."""
    found = math.inf
    for i in range(3):
        if limits[i] > 0.0:
            found = min(found, limits[i] / max(math.sqrt(max(1.0 - normal[i] ** 2, 0.0)), 1e-12))
    return found


@jit()
def placed(
    b: Blocks, q: Floats, k: int, new: int, j0: int, j1: int, plan: Rounding, first: Side, second: Side,
    tolerance: float, binormal: Floats, control: Control,
) -> tuple[bool, Rounding]:  # fmt: skip
    """The rounding where one side is an arc: its centre at its radius from both, and what is cut of them."""
    corner, radius = b.corner[j1], plan.radius
    found, spoke = centre_of(b, j0, j1, radius, first, second, binormal)
    if not found or norm(spoke) - radius > tolerance:
        return False, plan
    centre = corner + spoke
    rest = np.empty(2)
    ends = np.empty((2, 3))
    tangents = np.empty((2, 3))
    for side in range(2):
        s, j = (k, j0) if side == 0 else (new, j1)
        tangents[side] = b.end[j0] if side == 0 else b.begin[j1]
        if b.kind[j] == LINE:
            cut = abs(dot(spoke, tangents[side]))
            rest[side] = q[s, LENGTH] - cut
            ends[side] = corner + tangents[side] * (-cut if side == 0 else cut)
            continue
        cut = between(corner - b.centre[j], centre - b.centre[j])
        if cut > (first.most if side == 0 else second.most):
            return False, plan
        rest[side] = q[s, SWEEP] - cut
        at = b.sweep[j] - cut if side == 0 else (b.sweep[j] - q[s, SWEEP]) + cut
        ends[side] = on_circle(b, j, at)
        tangents[side] = unit(across(b.normal[j], ends[side] - b.centre[j]))
    allowed = NORMAL * TANGENT_ERROR * plan.acceleration * control.cycle / plan.speed
    for side in range(2):
        j = j0 if side == 0 else j1
        if b.kind[j] == ARC and between(unit(across(binormal, ends[side] - centre)), tangents[side]) > allowed:
            return False, plan
    angle = between(ends[0] - centre, ends[1] - centre)
    radius = 0.5 * (norm(ends[0] - centre) + norm(ends[1] - centre))
    return angle > SMALL_ANGLE, leaving(plan, radius, angle, rest[0], rest[1])


@jit()
def centre_of(
    b: Blocks, j0: int, j1: int, radius: float, first: Side, second: Side, binormal: Floats
) -> tuple[bool, Floats]:
    """From the corner to the centre of a circle that touches both sides."""
    corner = b.corner[j1]
    if b.kind[j0] == ARC and b.kind[j1] == ARC:
        return between_arcs(b, j0, j1, radius, first, second, binormal)
    line_first = b.kind[j0] == LINE
    side = first if line_first else second
    arc = second if line_first else first
    j = j1 if line_first else j0
    to_arc = b.centre[j] - corner
    distance = norm(to_arc) + (-radius if arc.convex else radius)
    inwards = unit(across(binormal, side.direction))
    along, over = dot(to_arc, side.direction), dot(to_arc, inwards)
    rest = distance**2 - (radius - over) ** 2
    if rest < 0.0:
        return False, to_arc
    root = math.sqrt(rest)
    cut = min(abs(-along + root), abs(-along - root))
    return True, side.direction * (-cut if line_first else cut) + inwards * radius


@jit()
def between_arcs(
    b: Blocks, j0: int, j1: int, radius: float, first: Side, second: Side, binormal: Floats
) -> tuple[bool, Floats]:
    """The same where both sides are arcs: the nearer of two circles."""
    corner = b.corner[j1]
    apart = b.centre[j1] - b.centre[j0]
    gap = norm(apart)
    d0 = norm(corner - b.centre[j0]) + (-radius if first.convex else radius)
    d1 = norm(corner - b.centre[j1]) + (-radius if second.convex else radius)
    if gap < 1e-12:
        return False, apart
    along = (d0 * d0 - d1 * d1 + gap * gap) / (2.0 * gap)
    rest = d0 * d0 - along * along
    if rest < 0.0:
        return False, apart
    forth = apart / gap
    aside = unit(across(binormal, forth)) * math.sqrt(rest)
    base = b.centre[j0] - corner + forth * along
    one, other = base + aside, base - aside
    return True, other if norm(other) < norm(one) else one

"""Arcs that round corners between lines and arcs within a tolerance, as LinuxCNC's planner places them.

Both segments are seen as lines towards the corner; where one is an arc, the circle is the one tangent to both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ARC,
    BEGIN,
    CENTRE,
    CORNER,
    END,
    KIND,
    LENGTH,
    LINE,
    NOMINAL,
    NORMAL,
    OF_SWEEP,
    ORIGIN,
    SIDEWAYS,
    SWEEP,
    TOLERANCE,
    TOP,
    Blocks,
    Control,
    Vector,
    across,
    along,
    between,
    dot,
    from_to,
    most_speed,
    norm,
    of_block,
    on_circle,
    unit,
)
from toolpace.kernels.linuxcnc.limited_jerk import speed_from_rest

SMALL_ARC = 1e-6
"""[mm]"""
MOST_OF_TOLERANCE = 0.25
"""Share of a block's length that a rounding may leave the corner by where no tolerance is given."""
SMALL_ANGLE = 1e-6
"""Between ways that count as one, or as turned back [rad]."""
TANGENT_ERROR = 0.25
"""Share of the normal acceleration that a rounding's error of tangent may take within a cycle."""


class Rounding(NamedTuple):
    """A rounding that can be, and what it leaves of both segments."""

    speed: float
    """Most speed on it."""
    requested: float
    acceleration: float
    radius: float
    angle: float
    first: float
    """What is left of the segment before it: a length, or the sweep of an arc."""
    second: float


class Side(NamedTuple):
    """One of both segments, as a line towards the corner or away from it."""

    direction: Vector
    """Of its chord."""
    reach: float
    """Most length along it."""
    lean: float
    """By how much the chord closes the half angle."""
    convex: bool
    most: float
    """Of an arc: most sweep that may be cut."""


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
    requested = max(most_speed(q, k, control, 1.0), most_speed(q, new, control, 1.0))
    goal = max(most_speed(q, k, control, control.override), most_speed(q, new, control, control.override))
    planar = in_plane(binormal, control.velocity)
    if lines:
        planar = max(planar, altitude(q, k, new, first, second, phi))
    goal = min(goal, planar)
    reach = min(min(first.reach, second.reach), math.cos(half) * tolerance / (1.0 - math.sin(half)))
    widest = math.tan(half) * reach
    # at limited jerk: as fast as a way of the length of the radius is from rest to rest
    sideways = speed_from_rest(normal_most, control.jerk, widest, control)
    speed = min(sideways if control.jerk > 0.0 else math.sqrt(normal_most * widest), goal)
    # as much of the blocks as an overlap at half the acceleration would take
    time = min(math.sqrt(most * reach), speed) / (0.5 * most)
    radius = max(speed * speed / normal_most, min(time * speed / phi, widest))
    if control.jerk > 0.0:
        radius = max(radius, speed * math.sqrt(speed / control.jerk))
    if radius < 1e-12 or radius * phi < SMALL_ARC:
        return False, no_rounding()
    return True, Rounding(speed, requested, most, radius, phi, 0.0, 0.0)


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


@jit(inline=True)
def no_rounding() -> Rounding:
    """In place of one that cannot be."""
    return Rounding(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit(inline=True)
def leaving(plan: Rounding, radius: float, angle: float, first: float, second: float) -> Rounding:
    """A rounding as it was placed."""
    return Rounding(plan.speed, plan.requested, plan.acceleration, radius, angle, first, second)


@jit()
def arc_side(b: Blocks, j: int, j1: int, sweep: float, theta: float, ends: bool) -> Side:
    """An arc that ends in the corner at the start of block j1, or starts there; sweep is what is left of it."""
    corner, centre = of_block(b, j1, CORNER), of_block(b, j, CENTRE)
    spoke = from_to(centre, corner)
    tangent = of_block(b, j, END) if ends else of_block(b, j, BEGIN)
    other = of_block(b, j1, BEGIN) if ends else of_block(b, j1 - 1, END)
    convex = (dot(spoke, other) < 0.0) == ends
    most = min(sweep * (2.0 / 3.0 if ends else 1.0 / 3.0), theta if convex else math.pi / 2)
    if not convex:
        return Side(tangent, most * norm(spoke), 0.0, False, most)
    # the chord of half of what may be cut
    whole = b.figures[j, OF_SWEEP]
    near = on_circle(b, j, whole - 0.5 * most if ends else whole - sweep + 0.5 * most)
    chord = from_to(near, corner) if ends else from_to(corner, near)
    return Side(unit(chord), math.sin(0.25 * most) * norm(spoke), 0.25 * most, True, most)


@jit(inline=True)
def in_its_plane(b: Blocks, q: Floats, k: int, j: int, binormal: Vector) -> bool:
    """Whether a segment is a line, or an arc in the plane of the corner."""
    if q[k, KIND] == LINE:
        return True
    off = 1.0 - abs(dot(binormal, of_block(b, j, NORMAL)))
    return off < 0.5 * SMALL_ANGLE**2 + 1e-15


@jit(inline=True)
def placed(
    b: Blocks, q: Floats, k: int, new: int, j0: int, j1: int, plan: Rounding, first: Side, second: Side,
    tolerance: float, binormal: Vector, control: Control,
) -> tuple[bool, Rounding]:  # fmt: skip
    """The rounding where one side is an arc: its centre at its radius from both, and what is cut of them."""
    found, spoke = centre_of(b, q, k, new, j0, j1, plan.radius, first, second, binormal)
    if not found or norm(spoke) - plan.radius > tolerance:
        return False, plan
    corner = of_block(b, j1, CORNER)
    centre = along(corner, 1.0, spoke)
    # how far its tangents may be off those of the arcs
    allowed = SIDEWAYS * TANGENT_ERROR * plan.acceleration * control.cycle / plan.speed
    good, first_left, start = cut_off(b, q, k, j0, corner, centre, binormal, first.most, allowed, True)
    fine, second_left, stop = cut_off(b, q, new, j1, corner, centre, binormal, second.most, allowed, False)
    angle = between(start, stop)
    radius = 0.5 * (norm(start) + norm(stop))
    return good and fine and angle > SMALL_ANGLE, leaving(plan, radius, angle, first_left, second_left)


@jit()
def cut_off(
    b: Blocks, q: Floats, s: int, j: int, corner: Vector, centre: Vector, binormal: Vector, most: float, allowed: float,
    ends: bool,
) -> tuple[bool, float, Vector]:  # fmt: skip
    """Whether a rounding about a centre may touch segment s, what it leaves of it, and the spoke to where it does."""
    if q[s, KIND] == LINE:
        way = of_block(b, j, END)
        cut = abs(dot(from_to(corner, centre), way))
        return True, q[s, LENGTH] - cut, from_to(centre, along(corner, -cut if ends else cut, way))
    own = of_block(b, j, CENTRE)
    cut = between(from_to(own, corner), from_to(own, centre))
    left = q[s, SWEEP] - cut
    whole = b.figures[j, OF_SWEEP]
    place = on_circle(b, j, whole - cut if ends else whole - left)
    spoke = from_to(centre, place)
    tangent = across(of_block(b, j, NORMAL), from_to(own, place))
    return cut <= most and between(across(binormal, spoke), tangent) <= allowed, left, spoke


@jit(inline=True)
def centre_of(
    b: Blocks, q: Floats, k: int, new: int, j0: int, j1: int, radius: float, first: Side, second: Side, binormal: Vector
) -> tuple[bool, Vector]:
    """From the corner to the centre of a circle that touches both sides."""
    if q[k, KIND] == ARC and q[new, KIND] == ARC:
        return between_arcs(b, j0, j1, radius, first, second, binormal)
    line_first = q[k, KIND] == LINE
    side = first if line_first else second
    arc = second if line_first else first
    to_arc = from_to(of_block(b, j1, CORNER), of_block(b, j1 if line_first else j0, CENTRE))
    distance = norm(to_arc) + (-radius if arc.convex else radius)
    inwards = across(binormal, side.direction)
    forth, over = dot(to_arc, side.direction), dot(to_arc, inwards)
    rest = distance**2 - (radius - over) ** 2
    if rest < 0.0:
        return False, to_arc
    root = math.sqrt(rest)
    cut = min(abs(-forth + root), abs(-forth - root))
    back = along(ORIGIN, -cut if line_first else cut, side.direction)
    return True, along(back, radius, inwards)


@jit(inline=True)
def between_arcs(
    b: Blocks, j0: int, j1: int, radius: float, first: Side, second: Side, binormal: Vector
) -> tuple[bool, Vector]:
    """The same where both sides are arcs: the nearer of two circles."""
    corner, centre0, centre1 = of_block(b, j1, CORNER), of_block(b, j0, CENTRE), of_block(b, j1, CENTRE)
    apart = from_to(centre0, centre1)
    gap = norm(apart)
    d0 = norm(from_to(centre0, corner)) + (-radius if first.convex else radius)
    d1 = norm(from_to(centre1, corner)) + (-radius if second.convex else radius)
    if gap < 1e-12:
        return False, apart
    forth = (d0 * d0 - d1 * d1 + gap * gap) / (2.0 * gap)
    rest = d0 * d0 - forth * forth
    if rest < 0.0:
        return False, apart
    aside = across(binormal, apart)
    base = along(from_to(corner, centre0), forth, unit(apart))
    one, other = along(base, math.sqrt(rest), aside), along(base, -math.sqrt(rest), aside)
    return True, other if norm(other) < norm(one) else one

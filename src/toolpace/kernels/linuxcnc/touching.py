"""The circle tangent to an arc and a line, or to two arcs."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ARC,
    CENTRE,
    CORNER,
    END,
    KIND,
    LENGTH,
    LINE,
    NORMAL,
    OF_SWEEP,
    SIDEWAYS,
    SWEEP,
    Blocks,
    Control,
)
from toolpace.kernels.linuxcnc.sides import SMALL_ANGLE, Rounding, Side, leaving
from toolpace.kernels.linuxcnc.vectors import (
    ORIGIN,
    Vector,
    across,
    along,
    between,
    dot,
    from_to,
    norm,
    of_block,
    on_circle,
    unit,
)

TANGENT_ERROR = 0.25
"""Share of the normal acceleration that a rounding's error of tangent may take within a cycle."""


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

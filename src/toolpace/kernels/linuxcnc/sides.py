"""The segments on both sides of a corner as lines, and the rounding between them."""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    BEGIN,
    CENTRE,
    CORNER,
    END,
    KIND,
    LINE,
    NORMAL,
    OF_SWEEP,
    Blocks,
)
from toolpace.kernels.linuxcnc.vectors import Vector, dot, from_to, norm, of_block, on_circle, unit

SMALL_ANGLE = 1e-6


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

    direction: Vector
    """Of its chord."""
    reach: float
    """Most length along it."""
    lean: float
    """By how much the chord closes the half angle."""
    convex: bool
    most: float
    """Of an arc: most sweep that may be cut."""


@jit(inline=True)
def no_rounding() -> Rounding:
    """In place of one that cannot be."""
    return Rounding(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit(inline=True)
def leaving(plan: Rounding, radius: float, angle: float, first: float, second: float) -> Rounding:
    """A rounding as it was placed."""
    return Rounding(plan.speed, plan.asked, plan.acceleration, radius, angle, first, second)


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

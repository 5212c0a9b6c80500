"""Vectors of X, Y, Z as three numbers, without allocation."""

from __future__ import annotations

import math

from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import CENTRE, CORNER, NORMAL, OF_SWEEP, RISE, Blocks

Vector = tuple[float, float, float]
ORIGIN = (0.0, 0.0, 0.0)


@jit()
def of_block(b: Blocks, j: int, which: int) -> Vector:
    """A vector of a block."""
    return b.vectors[j, which, 0], b.vectors[j, which, 1], b.vectors[j, which, 2]


@jit()
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit()
def norm(a: Vector) -> float:
    """Length."""
    return math.sqrt(dot(a, a))


@jit()
def along(a: Vector, share: float, b: Vector) -> Vector:
    """a + share b"""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]


@jit()
def from_to(a: Vector, b: Vector) -> Vector:
    """b - a"""
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@jit()
def unit(a: Vector) -> Vector:
    """Direction; zero of a vector without length."""
    size = norm(a)
    return along(ORIGIN, 1.0 / size if size > 0.0 else 0.0, a)


@jit()
def across(a: Vector, b: Vector) -> Vector:
    """Direction of the cross product; zero where both are parallel."""
    return unit((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


@jit()
def between(a: Vector, b: Vector) -> float:
    """Angle."""
    return math.acos(max(-1.0, min(1.0, dot(unit(a), unit(b)))))


@jit()
def on_circle(b: Blocks, j: int, angle: float) -> Vector:
    """Place of block j's arc at an angle from its start."""
    centre = of_block(b, j, CENTRE)
    spoke = from_to(centre, of_block(b, j, CORNER))
    place = along(centre, math.cos(angle), spoke)
    place = along(place, math.sin(angle) * norm(spoke), across(of_block(b, j, NORMAL), spoke))
    return along(place, angle / b.figures[j, OF_SWEEP], of_block(b, j, RISE))

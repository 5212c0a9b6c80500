"""Frames of tilted planes from points, vectors, or the tool direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix, Vector
from toolpace.programs.reading.gcode.program.words import RefusedError, WordError

SHORT = 1e-9
"""Least length of a direction, and of the sine of an angle between two of them."""
SQUARE = 1e-4
"""Most of the cosine of two axes that are meant to be square: what numbers of four places leave."""


def plane_of_points(points: Sequence[Vector], word: str) -> Matrix:
    """Origin in the first of three points (3,) [m], X to the second, the third on the side of +Y. Raises WordError."""
    first, second, third = map(np.asarray, points)
    x = second - first
    return _frame(first, x, np.cross(x, third - first), f"the three points of {word} P2 are on one line")


def plane_of_vectors(at: Vector, x: Vector, z: Vector, word: str) -> Matrix:
    """Origin at a point (3,) [m], axes X and Z along vectors (3,). Raises WordError, and RefusedError where these are
    not square."""
    first, normal = np.asarray(x), np.asarray(z)
    product = float(np.linalg.norm(first) * np.linalg.norm(normal))
    if product > SHORT and abs(float(first @ normal)) > SQUARE * product:
        raise RefusedError(f"{word} P3 with vectors that are not square", "write X in the plane, at 90 degrees to Z")
    return _frame(np.asarray(at), first, normal, f"a vector of {word} P3 is zero")


def plane_of_tool(at: Vector, axis: Vector, word: str) -> Matrix:
    """Origin at a point (3,) [m], Z along the axis (3,) of a tool, X level. Raises RefusedError where it is upright."""
    level = np.cross([0.0, 0.0, 1.0], axis)
    if math.hypot(*level) < 1e-6:
        raise RefusedError(f"{word} with the tool upright", "every X is level then: write G68.2 X Y Z I J K")
    return _frame(np.asarray(at), level, np.asarray(axis), "")


def _frame(at: Floats, x: Floats, z: Floats, fault: str) -> Matrix:
    """From an origin (3,), X in the plane across Z (3,), and Z. Raises WordError with the fault where there is none."""
    if np.linalg.norm(z) < SHORT * np.linalg.norm(x) or not np.linalg.norm(z) or not np.linalg.norm(x):
        raise WordError(f"{fault}: correct it")
    z = z / np.linalg.norm(z)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    columns = np.stack([x, np.cross(z, x), z], axis=1)
    return affine.product(affine.shift(at.tolist()), affine.linear(columns.tolist()))

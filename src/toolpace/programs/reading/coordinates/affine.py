"""Affine frames: rotations, reflections, scales and shifts as 4 by 4 matrices.

A frame maps points written in it to the coordinates it stands in. Small and in plain Python: a program changes its
frame a few times, and moves thousands of points, one at a time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.programs.reading.arcs import ROUNDING, Arc
from toolpace.programs.reading.splines import Bezier

Matrix = tuple[tuple[float, float, float, float], ...]
"""Three rows of a 4 by 4 matrix: rotation and shift; the fourth is (0, 0, 0, 1)."""
Vector = Sequence[float]

IDENTITY: Matrix = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


def shift(by: Vector) -> Matrix:
    """A shift."""
    return ((1.0, 0.0, 0.0, by[0]), (0.0, 1.0, 0.0, by[1]), (0.0, 0.0, 1.0, by[2]))


def rotation(axis: int, angle: float) -> Matrix:
    """A turn about the axis 0, 1 or 2 by an angle [rad]."""
    # multiples of a right angle are exact: they are the commonest, and rounding would tilt straight lines
    quarter = round(angle / (math.pi / 2.0))
    exact = math.isclose(angle, quarter * math.pi / 2.0, abs_tol=1e-14)
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter % 4] if exact else (math.cos(angle), math.sin(angle))
    rows = [[1.0 if i == j else 0.0 for j in range(4)] for i in range(3)]
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rows[j][j], rows[j][k], rows[k][j], rows[k][k] = float(c), -float(s), float(s), float(c)
    return _frozen(rows)


def turns(*steps: tuple[int, float]) -> Matrix:
    """Turns about axes [rad], each about the axes as turned by those before."""
    made = IDENTITY
    for axis, angle in steps:
        made = product(made, rotation(axis, angle))
    return made


def scaling(by: Vector) -> Matrix:
    """Scales, or where negative mirrors, along the axes."""
    return ((by[0], 0.0, 0.0, 0.0), (0.0, by[1], 0.0, 0.0), (0.0, 0.0, by[2], 0.0))


def linear(rows: Sequence[Vector]) -> Matrix:
    """A 3 by 3 matrix as a frame without shift."""
    return _frozen([[*map(float, row), 0.0] for row in rows])


def of_array(array: Floats) -> Matrix:
    """The frame of an array (3, 3) or (3, 4), without the roundings of kinematics, which would tilt straight lines."""
    whole = np.round(array)
    near = np.abs(array - whole) < np.array([1e-13, 1e-13, 1e-13, 1e-15])[: array.shape[1]]
    made = _frozen([[*row, 0.0] for row in np.where(near, whole, array).tolist()])
    return IDENTITY if made == IDENTITY else made


def of_axes(x: Vector, z: Vector) -> Matrix | None:
    """The turn to a direction x (3,) and a normal z (3,), to which x is made upright; None where they are parallel or
    zero."""
    size, length = math.hypot(*x), math.hypot(*z)
    if not size or not length or length < ROUNDING * size:
        return None
    z = [value / length for value in z]
    along = sum(a * b for a, b in zip(x, z))
    x = [a - along * b for a, b in zip(x, z)]
    length = math.hypot(*x)
    if length < ROUNDING * size:
        return None
    x = [value / length for value in x]
    return linear(list(zip(x, cross(z, x), z)))


def cross(a: Vector, b: Vector) -> list[float]:
    """The vector product (3,)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def product(first: Matrix, second: Matrix) -> Matrix:
    """The frame `second` written in the frame `first`."""
    return _frozen(
        [
            [sum(row[k] * second[k][j] for k in range(3)) + (row[3] if j == 3 else 0.0) for j in range(4)]
            for row in first
        ]
    )


def apply(frame: Matrix, point: Vector) -> tuple[float, float, float]:
    """A point (3,) of the frame, in the coordinates that the frame stands in."""
    x, y, z = point[0], point[1], point[2]
    a, b, c = frame
    return (
        a[0] * x + a[1] * y + a[2] * z + a[3],
        b[0] * x + b[1] * y + b[2] * z + b[3],
        c[0] * x + c[1] * y + c[2] * z + c[3],
    )


def direct(frame: Matrix, direction: Vector) -> tuple[float, float, float]:
    """A direction (3,) of the frame: turned, not shifted."""
    x, y, z = direction[0], direction[1], direction[2]
    a, b, c = frame
    return a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z


def inverse(frame: Matrix) -> Matrix:
    """The frame that undoes it."""
    made = np.linalg.inv(np.vstack([np.array(frame), [0.0, 0.0, 0.0, 1.0]]))
    return _frozen(made[:3].tolist())


def keeps_circle(frame: Matrix, arc: Arc) -> bool:
    """Whether an arc stays one in the coordinates that the frame stands in."""
    u, w = direct(frame, arc.u), direct(frame, arc.w)
    size = math.hypot(*u) * math.hypot(*w)
    across = math.fsum(a * b for a, b in zip(u, w))
    return abs(math.hypot(*u) - math.hypot(*w)) < ROUNDING * math.sqrt(size) and abs(across) < ROUNDING * size


def _frozen(rows: Sequence[Sequence[float]]) -> Matrix:
    return tuple((row[0], row[1], row[2], row[3]) for row in rows)


def carried_curve(frame: Matrix, curve: Bezier) -> Bezier:
    """A Bezier curve in the coordinates that the frame stands in."""
    return Bezier(tuple(apply(frame, point) for point in curve.points), curve.weights)


def carried(frame: Matrix, arc: Arc) -> Arc:
    """An arc in the coordinates that the frame stands in; its radii grow where the frame scales."""
    u, w = direct(frame, arc.u), direct(frame, arc.w)
    grown = max(math.hypot(*u), math.hypot(*w))
    if abs(grown - 1.0) < ROUNDING:
        grown = 1.0
    return Arc(
        apply(frame, arc.centre),
        (u[0] / grown, u[1] / grown, u[2] / grown),
        (w[0] / grown, w[1] / grown, w[2] / grown),
        arc.r0 * grown,
        arc.r1 * grown,
        arc.sweep,
        direct(frame, arc.rise),
    )

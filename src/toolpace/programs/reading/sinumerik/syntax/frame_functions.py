"""Frames as values: CTRANS, CROT, CSCALE, CMIRROR and their chain."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.common.units import DEGREE
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.sinumerik.syntax.values import Axis, Value, ValueFault, real

FUNCTIONS = ("CTRANS", "CFINE", "CROT", "CSCALE", "CMIRROR")
SLOTS = {"X": 0, "Y": 1, "Z": 2}
RPY = (2, 1, 0)
"""Axes of the turns of one ROT block: Z, then the new Y, then the newest X, whatever the order they are written in
(MD10600 = 1, Programming Manual Fundamentals, 12.4)."""


def made(name: str, arguments: Sequence[Value], unit: float) -> Matrix:
    """The frame of a function with these arguments: axes, each with its value, but for CMIRROR."""
    values: dict[str, float] = {}
    if name == "CMIRROR":
        return mirror(axes(arguments))
    if len(arguments) % 2:
        raise ValueFault(f"{name} takes axes with a value each, like {name}(X,10,Y,20): correct it")
    for axis, value in zip(axes(arguments[::2]), arguments[1::2]):
        values[axis] = real(value)
    if name == "CROT":
        return rotation(values)
    if name == "CSCALE":
        return scale(values)
    return affine.shift([values.get(axis, 0.0) * unit for axis in SLOTS])


def axes(arguments: Sequence[Value]) -> list[str]:
    """Letters of axes that a frame has: X, Y, Z."""
    found = []
    for argument in arguments:
        letter = argument.letter if isinstance(argument, Axis) else ""
        if letter not in SLOTS:
            raise ValueFault("a frame's function takes the axes X, Y and Z: correct its arguments")
        found.append(letter)
    return found


def rotation(degrees: dict[str, float]) -> Matrix:
    """Turns by angles about the axes, by name."""
    return affine.turns(*((slot, degrees.get("XYZ"[slot], 0.0) * DEGREE) for slot in RPY))


def scale(factors: dict[str, float]) -> Matrix:
    """Scales along the axes, by name."""
    wanted = [factors.get(axis, 1.0) for axis in SLOTS]
    if not all(1e-6 < abs(factor) < 1e6 for factor in wanted):
        raise ValueFault("a scale must not be zero: correct it")
    return affine.scaling(wanted)


def mirror(letters: Sequence[str]) -> Matrix:
    """Reflections along the axes."""
    return affine.scaling([-1.0 if axis in letters else 1.0 for axis in SLOTS])


def solid(degrees: dict[str, float]) -> Matrix:
    """ROTS: a plane by the angles of its intersections with two planes of the coordinates [deg].

    X, Y: the new X axis lies in the old ZX plane; Z, X: the new Z axis in the old YZ plane; Y, Z: the new Y axis in
    the old XY plane (K2, frame rotations with solid angles).
    """
    if len(degrees) != 2:
        raise ValueFault("ROTS takes two angles: X and Y, Y and Z, or Z and X")
    missing = next(slot for slot in range(3) if "XYZ"[slot] not in degrees)
    first, second = (missing + 1) % 3, (missing + 2) % 3
    a, b = degrees["XYZ"[first]] * DEGREE, degrees["XYZ"[second]] * DEGREE
    along, across = [0.0] * 3, [0.0] * 3
    along[first], along[missing] = math.cos(b), -math.sin(b)
    across[second], across[missing] = math.cos(a), math.sin(a)
    normal = _unit(cross(along, across))
    columns = {first: along, second: cross(normal, along), missing: normal}
    return affine.linear([[columns[column][row] for column in range(3)] for row in range(3)])


def cross(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """The vector product (3,)."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _unit(a: list[float]) -> list[float]:
    size = math.hypot(*a)
    if size < 1e-9:
        raise ValueFault("these angles of ROTS span no plane: correct them")
    return [value / size for value in a]

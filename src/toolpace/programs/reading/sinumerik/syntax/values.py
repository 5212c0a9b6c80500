"""Values of expressions: numbers, texts, axes, rows, and frames with the functions that make them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from toolpace.common.units import DEGREE
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.expressions import BlockError


class Axis(NamedTuple):
    """The name of an axis as a value: X, X1, C."""

    name: str

    @property
    def letter(self) -> str:
        """The letter of the axis: machine axes are X1, Y1, where geometry axes are X, Y."""
        return self.name[0] if len(self.name) == 1 or self.name[1:].isdigit() else self.name


@dataclass(frozen=True)
class Row:
    """Values of several elements of an array: SET(1, 2, 3), or REP(5) for all from an element on."""

    values: tuple[Value, ...]
    repeated: bool = False


Value = float | int | bool | str | Axis | Matrix | Row


class Memory(Protocol):
    """What expressions look into."""

    r: dict[int, float]
    unit: float
    """Of lengths [m]."""
    literals: tuple[float, ...]
    """Constants of the block at hand."""

    def variable(self, name: str, index: tuple[int, ...]) -> Value:
        """A variable of the program. Raises Unread."""

    def letter(self, name: str) -> Value:
        """A variable of one letter where there is one, else the axis."""

    def system(self, name: str, index: tuple[Value, ...]) -> Value:
        """A variable of the control. Raises Unread."""


Compiled = Callable[[Memory], Value]


class Unread(Exception):
    """A word that may move something and is not read."""

    def __init__(self, word: str, cure: str) -> None:
        super().__init__(word, cure)
        self.word, self.cure = word, cure


def real(value: Value) -> float:
    """The value as a number."""
    if isinstance(value, (float, int)):
        if not abs(value) < 1e300:
            raise BlockError(f"the expression comes to {value:g}: correct its numbers")
        return value
    raise BlockError(f"{shown(value)} is no number: write a number or a REAL variable")


def whole(value: Value) -> int:
    """The value as a whole number: of an index, a count."""
    number = real(value)
    if number != round(number) or not abs(number) < 1e15:
        raise BlockError(f"{number:g} must be a whole number here: correct it")
    return round(number)


def shown(value: Value) -> str:
    """The value in messages."""
    if isinstance(value, Axis):
        return f"axis {value.name}"
    if isinstance(value, str):
        return f'"{value[:30]}"'
    if isinstance(value, Row):
        return "several values"
    return f"{value:g}" if isinstance(value, (float, int)) else "a frame"


def text(value: Value) -> str:
    """The value as a text, as `<<` joins it."""
    if isinstance(value, str):
        return value
    return value.name if isinstance(value, Axis) else shown(value)


def equal(a: Value, b: Value) -> bool:
    """Whether values are equal: numbers to one part in 10^12 (NC Programming, 3.1.3: relative comparison)."""
    if isinstance(a, (float, int)) and isinstance(b, (float, int)):
        return a == b or abs(a - b) <= 1e-12 * max(abs(a), abs(b))
    if type(a) is not type(b):
        raise BlockError(f"{shown(a)} and {shown(b)} cannot be compared: they are of different kinds")
    return a == b


def above(a: Value, b: Value) -> bool:
    """Whether a > b, and not equal in the sense of `equal`."""
    return real(a) > real(b) and not equal(a, b)


# Frames

FRAME_FUNCTIONS = ("CTRANS", "CFINE", "CROT", "CSCALE", "CMIRROR")
SLOTS = {"X": 0, "Y": 1, "Z": 2}
RPY = (2, 1, 0)
"""Axes of the turns of one ROT block: Z, then the new Y, then the newest X, whatever the order they are written in
(MD10600 = 1, Programming Manual Fundamentals, 12.4)."""


def frame(name: str, arguments: Sequence[Value], unit: float) -> Matrix:
    """The frame of a function with these arguments: axes, each with its value, but for CMIRROR."""
    values: dict[str, float] = {}
    if name == "CMIRROR":
        return mirror(axes(arguments))
    if len(arguments) % 2:
        raise BlockError(f"{name} takes axes with a value each, like {name}(X,10,Y,20): correct it")
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
            raise BlockError("a frame's function takes the axes X, Y and Z: correct its arguments")
        found.append(letter)
    return found


def rotation(degrees: dict[str, float]) -> Matrix:
    """Turns by angles about the axes, by name."""
    return affine.turns(*((slot, degrees.get("XYZ"[slot], 0.0) * DEGREE) for slot in RPY))


def scale(factors: dict[str, float]) -> Matrix:
    """Scales along the axes, by name."""
    wanted = [factors.get(axis, 1.0) for axis in SLOTS]
    if not all(1e-6 < abs(factor) < 1e6 for factor in wanted):
        raise BlockError("a scale must not be zero: correct it")
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
        raise BlockError("ROTS takes two angles: X and Y, Y and Z, or Z and X")
    missing = next(slot for slot in range(3) if "XYZ"[slot] not in degrees)
    first, second = (missing + 1) % 3, (missing + 2) % 3
    a, b = degrees["XYZ"[first]] * DEGREE, degrees["XYZ"[second]] * DEGREE
    along, across = [0.0] * 3, [0.0] * 3
    along[first], along[missing] = math.cos(b), -math.sin(b)
    across[second], across[missing] = math.cos(a), math.sin(a)
    normal = _unit(affine.cross(along, across))
    columns = {first: along, second: affine.cross(normal, along), missing: normal}
    return affine.linear([[columns[column][row] for column in range(3)] for row in range(3)])


def _unit(a: list[float]) -> list[float]:
    size = math.hypot(*a)
    if size < 1e-9:
        raise BlockError("these angles of ROTS span no plane: correct them")
    return [value / size for value in a]

"""Values of expressions, and built-in functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from toolpace.common.units import DEGREE
from toolpace.programs.reading.coordinates.affine import Matrix


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


class ValueFault(ValueError):
    """A value that cannot be; the message says why and what to write."""


class Unread(Exception):
    """A word that may move something and is not read."""

    def __init__(self, word: str, cure: str) -> None:
        super().__init__(word, cure)
        self.word, self.cure = word, cure


def real(value: Value) -> float:
    """The value as a number."""
    if isinstance(value, (float, int)):
        if not abs(value) < 1e300:
            raise ValueFault(f"the expression comes to {value:g}: correct its numbers")
        return value
    raise ValueFault(f"{shown(value)} is no number: write a number or a REAL variable")


def whole(value: Value) -> int:
    """The value as a whole number: of an index, a count."""
    number = real(value)
    if number != round(number) or not abs(number) < 1e15:
        raise ValueFault(f"{number:g} must be a whole number here: correct it")
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
        raise ValueFault(f"{shown(a)} and {shown(b)} cannot be compared: they are of different kinds")
    return a == b


def above(a: Value, b: Value) -> bool:
    """Whether a > b, and not equal in the sense of `equal`."""
    return real(a) > real(b) and not equal(a, b)


def nonzero(value: Value) -> float:
    """A divisor."""
    number = real(value)
    if number == 0.0:
        raise ValueFault("an expression divides by zero: correct it")
    return number


def _within(name: str, value: float, low: float, high: float) -> float:
    if not low <= value <= high:
        raise ValueFault(f"{name}({value:g}) has no value: its argument lies beyond what {name} takes")
    return value


def rounded(x: float) -> float:
    """To the next whole number, halves away from zero: ROUND, and a REAL that an INT is given."""
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _rounded_up(x: float) -> float:
    return float(math.ceil(x)) if x > 0 else float(math.floor(x))


FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, lambda x: math.sin(x * DEGREE)),
    "COS": (1, lambda x: math.cos(x * DEGREE)),
    "TAN": (1, lambda x: math.tan(x * DEGREE)),
    "ASIN": (1, lambda x: math.asin(_within("ASIN", x, -1, 1)) / DEGREE),
    "ACOS": (1, lambda x: math.acos(_within("ACOS", x, -1, 1)) / DEGREE),
    "ATAN2": (2, lambda y, x: math.atan2(y, x) / DEGREE),
    "SQRT": (1, lambda x: math.sqrt(_within("SQRT", x, 0, math.inf))),
    "ABS": (1, abs),
    "POT": (1, lambda x: x * x),
    "TRUNC": (1, lambda x: float(math.trunc(x))),
    "ROUND": (1, rounded),
    "ROUNDUP": (1, _rounded_up),
    "LN": (1, lambda x: math.log(_within("LN", x, 5e-324, math.inf))),
    "EXP": (1, lambda x: math.exp(_within("EXP", x, -700, 700))),
    "MINVAL": (2, min),
    "MAXVAL": (2, max),
    "BOUND": (3, lambda low, high, x: min(max(x, low), high)),
}
"""How many arguments each function takes, and what it is; angles are in degrees (NC Programming, 2.15)."""
CONSTANTS: dict[str, Value] = {
    "TRUE": True,
    "FALSE": False,
    # parts of a frame: $P_UIFR[1, X, TR]
    **{part: part for part in ("TR", "FI", "RT", "SC", "MI")},
    # modes of CYCLE832 (NC Programming, 3.25)
    "_OFF": 0,
    "_FINISH": 1,
    "_SEMIFIN": 2,
    "_ROUGH": 3,
    "_PRECISION": 4,
    "_ORI_FINISH": 11,
    "_ORI_SEMIFIN": 12,
    "_ORI_ROUGH": 13,
    "_ORI_PRECISION": 14,
    "_TOP_SURFACE_SMOOTH_OFF": 1_000_000,
    "_TOP_SURFACE_SMOOTH_ON": 2_000_000,
}
"""Names of values."""

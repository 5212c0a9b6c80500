"""Q parameters of a running program, and formulas of them: operators and functions of Klartext, and how it writes them.

Angles are in degrees. `^` in a chain, or behind a sign or a function without brackets, is refused: the manuals do not
say which goes first.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import TypeAlias

from toolpace.common.units import DEGREE
from toolpace.programs.reading import expressions
from toolpace.programs.reading.expressions import (
    BlockError,
    TextParser,
    checked,
    divided,
    power,
    remainder,
)

LARGEST = 1e9
"""Beyond which a value is a slip: no machine travels so far."""

MOST = {"Q": 1999, "QL": 499, "QR": 499}
"""Highest number of a parameter of each kind (TNC 640 Klartext, "Q parameters", "Overview of functions")."""
Thunk = Callable[[], float]
Value = float | Thunk
"""A number, or what gives it where it is executed."""
Node: TypeAlias = "float | Callable[[Parameters], float]"


class UnsetError(Exception):
    """A parameter is read that has no value; the message is its name, "" where it hangs on another that has none."""


class Parameters:
    """Values of Q (of all programs), QR (kept), QL (of one program) and texts QS."""

    def __init__(self, preset: Mapping[str, float]) -> None:
        self.shared: dict[str, float] = {name.upper(): value for name, value in preset.items()}
        self.local: dict[str, float] = {}
        self.texts: dict[str, str] = {}
        self.hanging: set[str] = set()
        """Names whose value hangs on parameters that have none."""

    def get(self, name: str) -> float:
        """Value of Q5, QL5 or QR5. Raises UnsetError."""
        values = self.local if name.startswith("QL") else self.shared
        try:
            return values[name]
        except KeyError:
            raise UnsetError("" if name in self.hanging else name) from None

    def assign(self, name: str, value: Callable[[], float]) -> None:
        """Give it the value of a formula. Raises BlockError, UnsetError: then it has none from there on."""
        try:
            self.set(name, value())
        except UnsetError:
            self.forget(name)
            raise

    def forget(self, name: str) -> None:
        """Take it for one whose value hangs on what is not known."""
        (self.local if name.startswith("QL") else self.shared).pop(name, None)
        self.hanging.add(name)

    def set(self, name: str, value: float) -> None:
        """Give it a value. Raises BlockError where that is none."""
        if not math.isfinite(value):
            raise BlockError(f"{name} would become {value:g}: check the figures of the formula")
        (self.local if name.startswith("QL") else self.shared)[name] = value

    def text(self, name: str) -> str:
        """Text of QS5. Raises UnsetError."""
        try:
            return self.texts[name]
        except KeyError:
            raise UnsetError(name) from None


def named(name: str) -> str:
    """The name of a parameter that a block sets. Raises BlockError where the control has none of that number."""
    kind = name.rstrip("0123456789")
    if int(name[len(kind) :]) > MOST[kind]:
        raise BlockError(f"{name} is no parameter: {kind} are numbered from 0 to {MOST[kind]}")
    return name


def number(text: str) -> float:
    """A number of a program, with point or comma. Raises BlockError."""
    value = float(text.replace(",", "."))
    if not abs(value) <= LARGEST:
        raise BlockError(f"{text[:20]} is beyond any machine (at most 1e9): check its digits")
    return value


def _sine(x: float) -> float:
    # multiples of a right angle are exact, as they are on the control's display
    return float((0, 1, 0, -1)[int(x // 90.0) % 4]) if x % 90.0 == 0.0 else math.sin(x * DEGREE)


FUNCTIONS = {
    **expressions.FUNCTIONS,
    **{
        name: (1, checked(name, function))
        for name, function in {
            "SQ": lambda x: x * x,
            "SIN": _sine,
            "COS": lambda x: _sine(x + 90.0) if x % 90.0 == 0.0 else math.cos(x * DEGREE),
            "LOG": math.log10,
            "NEG": operator.neg,
            "INT": lambda x: float(math.trunc(x)),
            "FRAC": lambda x: x - math.trunc(x),
            "SGN": lambda x: float((x > 0.0) - (x < 0.0)),
        }.items()
    },
}
OPERATORS: Mapping[str, tuple[int, Callable[[float, float], float]]] = {
    "LEN": (1, math.hypot),
    "ANG": (1, lambda a, b: math.atan2(a, b) / DEGREE % 360.0),
    "+": (2, operator.add),
    "-": (2, operator.sub),
    "*": (3, operator.mul),
    "/": (3, divided),
    "DIV": (3, divided),
    "%": (3, remainder),
    "^": (5, power),
}
"""LEN, ANG and DIV are those of FN 8, FN 13 and FN 4."""


def formula(text: str, parameters: Parameters) -> Value:
    """A formula as a number, or as a function of none. Raises BlockError; so does the function, and UnsetError."""
    parser = _Parser(text)
    made = parser.expression()
    if parser.at < len(text) and text[parser.at :].strip():
        raise BlockError(f"{parser.found()} stands where the formula should end: check its brackets and spelling")
    if isinstance(made, float):
        return made
    value = made

    def run() -> float:
        found = value(parameters)
        if not math.isfinite(found):
            raise BlockError(f"the formula {text.strip()[:40]} grows without end: check its figures")
        return found

    return run


def evaluate(value: Value) -> float:
    """The number of a value. Raises BlockError, UnsetError."""
    return value if isinstance(value, float) else value()


class _Parser(TextParser[Node]):
    token = re.compile(
        r"\s*(?:(?P<number>[0-9]+[.,]?[0-9]*|[.,][0-9]+)|(?P<name>Q[LR]?[0-9]+)|(?P<mark>[-+*/^%()])"
        r"|(?P<word>[A-Z]+?(?=Q[LR]?[0-9]|[^A-Z]|$)))"
    )
    operators, functions, bracketed = OPERATORS, FUNCTIONS, frozenset("^")
    longest = 200
    cure = "write a number, a Q parameter or a function"

    def operand(self) -> Node:
        """A number, a parameter, or a function of what stands behind its name."""
        kind, symbol = self.kind, self.symbol
        if kind == "number":
            self.step()
            return number(symbol)
        if kind == "name":
            self.step()
            return lambda parameters: parameters.get(symbol)
        if symbol != "PI" and symbol not in self.functions:
            raise self.missing()
        self.step()
        return math.pi if symbol == "PI" else self.call(symbol, [self.value()])

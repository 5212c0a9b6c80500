"""Formulas of Q parameters, compiled to functions (Pratt 1973).

Angles are in degrees. `^` in a chain, or behind a sign or a function without brackets, is refused: the manuals do not
say which goes first.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable

from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters, number

Thunk = Callable[[], float]
Value = float | Thunk
"""A number, or what gives it where it is executed."""

_TOKEN = re.compile(
    r"\s*(?:(?P<number>[0-9]+[.,]?[0-9]*|[.,][0-9]+)|(?P<name>Q[LR]?[0-9]+)|(?P<operator>[-+*/^%()])"
    r"|(?P<word>[A-Z]+?(?=Q[LR]?[0-9]|[^A-Z]|$)))"
)
DEEPEST = 60
"""Brackets and functions within each other."""
LONGEST = 200
"""Operators of one formula."""
DEGREE = math.pi / 180.0


def _sine(x: float) -> float:
    # multiples of a right angle are exact, as they are on the control's display
    return float((0, 1, 0, -1)[int(x // 90.0) % 4]) if x % 90.0 == 0.0 else math.sin(x * DEGREE)


FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SQ": lambda x: x * x,
    "SQRT": math.sqrt,
    "SIN": _sine,
    "COS": lambda x: _sine(x + 90.0) if x % 90.0 == 0.0 else math.cos(x * DEGREE),
    "TAN": lambda x: math.tan(x * DEGREE),
    "ASIN": lambda x: math.asin(x) / DEGREE,
    "ACOS": lambda x: math.acos(x) / DEGREE,
    "ATAN": lambda x: math.atan(x) / DEGREE,
    "LN": math.log,
    "LOG": math.log10,
    "EXP": math.exp,
    "NEG": operator.neg,
    "INT": math.trunc,
    "ABS": abs,
    "FRAC": lambda x: x - math.trunc(x),
    "SGN": lambda x: float((x > 0.0) - (x < 0.0)),
}


def _power(a: float, b: float) -> float:
    return math.pow(a, b)


def _angle(a: float, b: float) -> float:
    return math.atan2(a, b) / DEGREE % 360.0


BINARY: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "LEN": (1, math.hypot),
    "ANG": (1, _angle),
    "+": (2, operator.add),
    "-": (2, operator.sub),
    "*": (3, operator.mul),
    "/": (3, operator.truediv),
    "DIV": (3, operator.truediv),
    "%": (3, math.fmod),
    "^": (5, _power),
}
"""Operators with what binds tighter; LEN, ANG and DIV are those of FN 8, FN 13 and FN 4."""
PREFIX = 5
"""A sign or a function goes before all operators."""


def formula(text: str, parameters: Parameters) -> Value:
    """A formula as a number, or as a function of none. Raises BlockError; so does the function, and UnsetError."""
    try:
        made = _Parser(text, parameters).whole()
        return made if isinstance(made, float) else _guarded(made, text)
    except (ArithmeticError, ValueError) as error:
        raise BlockError(f"the formula {text.strip()[:40]} has no value ({error})") from None


def evaluate(value: Value) -> float:
    """The number of a value. Raises BlockError, UnsetError."""
    return value if isinstance(value, float) else value()


def _guarded(thunk: Thunk, text: str) -> Thunk:
    def run() -> float:
        try:
            value = thunk()
        except (ArithmeticError, ValueError) as error:
            raise BlockError(f"the formula {text.strip()[:40]} has no value ({error})") from None
        if not math.isfinite(value):
            raise BlockError(f"the formula {text.strip()[:40]} grows without end: check its figures")
        return value

    return run


class _Parser:
    def __init__(self, text: str, parameters: Parameters) -> None:
        self.text, self.parameters = text, parameters
        self.at = 0
        self.depth, self.operators = 0, 0
        self.kind, self.token = "", ""
        self.step()

    def step(self) -> str:
        """Go to the next token; returns the one left."""
        left = self.token
        found = _TOKEN.match(self.text, self.at)
        if found is None:
            rest = self.text[self.at :].strip()
            if rest:
                raise BlockError(f"{rest[:20]} is not read in a formula: check its spelling")
            self.kind, self.token = "end", ""
        else:
            self.kind, self.token, self.at = str(found.lastgroup), found[str(found.lastgroup)], found.end()
        return left

    def whole(self) -> Value:
        made, _ = self.expression(0)
        if self.kind != "end":
            raise BlockError(f"{self.token} stands where the formula should end: check its brackets")
        return made

    def expression(self, least: int) -> tuple[Value, bool]:
        """What binds tighter than `least`; and whether a sign, a function or `^` is its outermost part."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise BlockError(f"more than {DEEPEST} brackets and functions within each other: divide the formula")
        left, open_ended = self.operand()
        while self.kind != "end" and self.token in BINARY and BINARY[self.token][0] > least:
            sign = self.step()
            self.operators += 1
            if self.operators > LONGEST:
                raise BlockError(f"more than {LONGEST} operators in one formula: divide it")
            binding, function = BINARY[sign]
            if sign == "^" and open_ended:
                raise BlockError("^ needs brackets here: which part goes first is not said")
            right, _ = self.expression(binding)
            left, open_ended = _joined(function, left, right), sign == "^"
        self.depth -= 1
        return left, open_ended

    def operand(self) -> tuple[Value, bool]:
        kind, token = self.kind, self.step()
        if kind == "number":
            return number(token), False
        if kind == "name":
            get = self.parameters.get
            return (lambda: get(token)), False
        if token == "(":
            inner, _ = self.expression(0)
            if self.step() != ")":
                raise BlockError("a bracket is not closed: write )")
            return inner, False
        if token == "PI":
            return math.pi, False
        if token in "+-" and kind == "operator":
            inner, _ = self.expression(PREFIX)
            return (_applied(operator.neg, inner) if token == "-" else inner), True
        if token in FUNCTIONS:
            inner, _ = self.expression(PREFIX)
            return _applied(FUNCTIONS[token], inner), True
        shown = f"'{token}'" if token else "nothing"
        raise BlockError(f"{shown} stands where a number, Q parameter or function should: check the formula")


def _applied(function: Callable[[float], float], inner: Value) -> Value:
    if isinstance(inner, float):
        return float(function(inner))
    return lambda: function(inner())


def _joined(function: Callable[[float, float], float], left: Value, right: Value) -> Value:
    if isinstance(left, float):
        if isinstance(right, float):
            return float(function(left, right))
        return lambda: function(left, right())
    if isinstance(right, float):
        return lambda: function(left(), right)
    return lambda: function(left(), right())

"""Expressions of word-address programs: numbers, variables, and the operators and functions of each control.

After the documents of LinuxCNC (Parameters and Expressions) and Fanuc (Custom Macro B): brackets are [ ], angles are
in degrees, and a variable may be empty, which counts as zero wherever it is reckoned with.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from toolpace.common.units import DEGREE
from toolpace.programs.reading import expressions
from toolpace.programs.reading.expressions import (
    BlockError,
    TextParser,
    away_from_zero,
    checked,
    divided,
    half_away_from_zero,
    power,
    remainder,
)
from toolpace.programs.reading.gcode.program.words import bounded, rounded

if TYPE_CHECKING:
    from toolpace.programs.reading.gcode.program.variables import Variables

Node: TypeAlias = "float | Reference | Callable[[Variables], float]"
"""A constant, a variable, or what is made of them."""
Operators = Mapping[str, tuple[int, Callable[[float, float], float]]]
Functions = Mapping[str, tuple[int, Callable[..., float]]]
EQUAL = 1e-4
"""Difference of two numbers that EQ takes for none (LinuxCNC, "Binary Operators")."""
ATAN_TO_360 = "ASIN and ATAN give angles from 0 to 360 degrees (parameter 6004#0 = 0 of Fanuc; with 1 below zero too)"
ATAN_SIGNED = "ASIN and ATAN give angles from -180 to 180 degrees"
OF_TWO = "ATAN[]/[]"
_NAME = re.compile(r"(?:_(?:HAL|INI)\[[^>\[\]#]{1,100}\][^>\[\]#]{0,100}|[^>\[\]#]{1,200})>")


# Operators


def _bits(operation: Callable[[int, int], int]) -> Callable[[float, float], float]:
    return lambda a, b: float(operation(round(a), round(b)))


def _never_negative(a: float, b: float) -> float:
    rest = remainder(a, b)
    return rest if rest >= 0.0 else rest + abs(b)


def _sure_remainder(a: float, b: float) -> float:
    if a < 0.0 or b <= 0.0 or a != int(a) or b != int(b):
        raise BlockError(
            f"{a:g} MOD {b:g}: controls differ in the remainder of what is below zero or not whole; write the value out"
        )
    return remainder(a, b)


def _remainder_of_whole(a: float, b: float) -> float:
    """Of both rounded to whole numbers, with the sign of the first (B-64304EN, "Arithmetic and logic operation")."""
    return remainder(half_away_from_zero(a), half_away_from_zero(b))


OPERATORS: Operators = {
    "**": (6, power),
    "*": (5, operator.mul),
    "/": (5, divided),
    "+": (4, operator.add),
    "-": (4, operator.sub),
    "EQ": (3, lambda a, b: float(abs(a - b) < EQUAL)),
    "NE": (3, lambda a, b: float(abs(a - b) >= EQUAL)),
    "GT": (3, lambda a, b: float(a > b)),
    "GE": (3, lambda a, b: float(a >= b)),
    "LT": (3, lambda a, b: float(a < b)),
    "LE": (3, lambda a, b: float(a <= b)),
}
"""How much they bind, and what they make of two numbers."""
TRUTH: Operators = {
    "MOD": (5, _never_negative),
    "AND": (2, lambda a, b: float(a != 0.0 and b != 0.0)),
    "OR": (2, lambda a, b: float(a != 0.0 or b != 0.0)),
    "XOR": (2, lambda a, b: float((a != 0.0) != (b != 0.0))),
}
"""LinuxCNC: logic on truth binds last of all."""
BITS: Operators = {
    "MOD": (5, _sure_remainder),
    "AND": (5, _bits(operator.and_)),
    "OR": (4, _bits(operator.or_)),
    "XOR": (4, _bits(operator.xor)),
}
"""Fanuc: logic on bits binds like * and +."""
WHOLE_REMAINDER: Operators = {"MOD": (5, _remainder_of_whole)}


# Functions

_PI = np.longdouble("3.14159265358979323846264338327950288")


def _of_long(function: Callable[[np.longdouble], np.longdouble]) -> Callable[[float], float]:
    return lambda value: float(function(np.longdouble(value) * _PI / 180))


def _long_degrees(angle: float) -> float:
    """An angle [rad] in degrees, as LinuxCNC's interpreter reckons it."""
    return float(np.longdouble(angle * 180.0) / _PI)


def _round_of_integers(value: float) -> float:
    if abs(value) >= 2.0**31:
        raise BlockError(f"ROUND of {value:g} is beyond what LinuxCNC's interpreter can round: check the expression")
    return half_away_from_zero(value)


FUNCTIONS: Functions = {
    **expressions.FUNCTIONS,
    "SQR": (1, checked("SQR", math.sqrt)),
    "FIX": (1, checked("FIX", lambda a: float(math.floor(a)))),
    "FUP": (1, checked("FUP", lambda a: float(math.ceil(a)))),
    "ROUND": (1, checked("ROUND", half_away_from_zero)),
    OF_TWO: (2, lambda a, b: math.atan2(a, b) / DEGREE),
}
"""How many arguments they take, and what they make of them."""
LONG: Functions = {
    "SIN": (1, checked("SIN", _of_long(np.sin))),
    "COS": (1, checked("COS", _of_long(np.cos))),
    "TAN": (1, checked("TAN", _of_long(np.tan))),
    "ASIN": (1, checked("ASIN", lambda a: _long_degrees(math.asin(a)))),
    "ACOS": (1, checked("ACOS", lambda a: _long_degrees(math.acos(a)))),
    "ROUND": (1, _round_of_integers),
    OF_TWO: (2, lambda a, b: _long_degrees(math.atan2(a, b))),
}
"""As LinuxCNC's interpreter reckons them, with its long number pi: the cosine of 90 degrees has another sign."""
MACRO_B: Functions = {
    "FIX": (1, checked("FIX", lambda a: float(math.trunc(a)))),
    "FUP": (1, checked("FUP", away_from_zero)),
    "POW": (2, power),
}
"""Fanuc cuts towards zero and away from it; LinuxCNC goes down and up."""


@dataclass(frozen=True)
class Grammar:
    """How a controller writes expressions, and what they come to."""

    bits: bool = False
    """Whether AND, OR and XOR work on bits and bind like * and + (Fanuc); else on truth, last of all (LinuxCNC)."""
    letter: str = ""
    """With a number behind it it is a variable too (E254 of MillPlus)."""
    strict: bool = False
    """Whether expressions are those of LinuxCNC's interpreter, whose ATAN takes two values."""
    whole_remainder: bool = False
    """Whether MOD takes whole numbers."""
    to_360: bool = False
    """Whether no angle that ASIN and ATAN of two values give is below zero."""
    operators: Operators = field(init=False)
    functions: Functions = field(init=False)

    def __post_init__(self) -> None:
        logic, whole = BITS if self.bits else TRUTH, WHOLE_REMAINDER if self.whole_remainder else {}
        object.__setattr__(self, "operators", {**OPERATORS, **logic, **whole})
        macro, long = MACRO_B if self.bits else {}, LONG if self.strict else {}
        object.__setattr__(self, "functions", {**FUNCTIONS, **macro, **long})


class Reference:
    """A variable: its number, a number that is itself reckoned, or its name."""

    __slots__ = ("of",)

    def __init__(self, of: int | str | Callable[[Variables], float]) -> None:
        self.of = of

    def key(self, variables: Variables) -> int | str:
        """Number or name."""
        return whole(self.of(variables), "the number of a variable") if callable(self.of) else self.of

    def value(self, variables: Variables) -> float | None:
        """The value; None where the variable is empty."""
        return variables.get(self.key(variables))

    def __call__(self, variables: Variables) -> float:
        value = self.value(variables)
        return 0.0 if value is None else value


def whole(value: float, what: str) -> int:
    """A value as a whole number; BlockError where it is none."""
    if not abs(value) <= 1e9 or abs(value - round(value)) >= 1e-4:
        raise BlockError(f"{what} must be a whole number, not {value:g}: correct it")
    return round(value)


def value_of(node: Node, variables: Variables) -> float | None:
    """What a node comes to; None where it is an empty variable."""
    if isinstance(node, float):
        return node
    return node.value(variables) if isinstance(node, Reference) else node(variables)


def _function(node: Node) -> Callable[[Variables], float]:
    return (lambda variables: node) if isinstance(node, float) else node


class Parser(TextParser[Node]):
    """Reads values and expressions of one block from a place on."""

    token = re.compile(
        r"[ \t]*+(?:(?P<number>[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)|(?P<operator>AND|OR|XOR|MOD|EQ|NE|G[TE]|L[TE])"
        r"|(?P<name>[A-Z]++)|(?P<mark>\*\*|[-+*/\[\]#<,]))"
    )
    opening, closing = "[", "]"
    cure = "write a number, # or [ ]"

    def __init__(self, text: str, at: int = 0, *, grammar: Grammar) -> None:
        super().__init__(text, at)
        self.grammar = grammar
        self.operators, self.functions = grammar.operators, grammar.functions
        self.address = ""
        """The letter of the word whose value is read, to whose least increment ROUND then rounds (Custom Macro B)."""

    def lacks_value(self) -> bool:
        """Whether no value begins here."""
        if self.kind in ("name", "operator"):
            return "[" not in self.text[self.end : self.end + 3] and self.symbol != self.grammar.letter
        return not self.kind or self.symbol in ("]", "/", "*", "**", "<")

    def operand(self) -> Node:
        """A number, a variable, or a function of values in brackets."""
        kind, symbol = self.kind, self.symbol
        if kind != "number" and kind != "name" and symbol != "#":
            raise self.missing()
        self.step()
        if kind == "number":
            return bounded(float(symbol))
        return self._named(symbol) if kind == "name" else self._reference()

    def joined(self, name: str, function: Callable[..., object], left: Node, right: Node) -> Node:
        """The node of an operator; to Fanuc an empty variable is equal to an empty one only, not to zero."""
        if not self.grammar.bits or name not in ("EQ", "NE"):
            return super().joined(name, function, left, right)
        wanted = name == "EQ"
        return lambda variables: float((value_of(left, variables) == value_of(right, variables)) == wanted)

    def _named(self, name: str) -> Node:
        if name == self.grammar.letter and self.kind == "number":
            number = self.value()
            assert isinstance(number, float)
            return Reference(whole(number, f"the number behind {name}"))
        if name == "EXISTS":
            self.need("[")
            self.need("#")
            reference = self._reference()
            self.need("]")
            return lambda variables: float(variables.exists(reference.key(variables)))
        if name not in self.functions:
            raise BlockError(f"'{name[:20]}' is no function that is known here: write the value out")
        self.need("[")
        arguments = self.enumerated("]")
        if name == "ATAN":
            return self._arc_tangent(arguments)
        made = self.call(name, arguments)
        if name == "ROUND" and self.grammar.bits and self.address:
            letter, value = self.address, _function(arguments[0])
            return lambda variables: rounded(value(variables), variables.increment(letter))
        return self._in_range(made) if name == "ASIN" else made

    def _arc_tangent(self, arguments: list[Node]) -> Node:
        """ATAN[a]/[b], ATAN[a]; Fanuc has ATAN[a,b] too (B-64304EN, "Arithmetic and logic operation")."""
        if not self.grammar.bits or len(arguments) != 2:
            if len(arguments) != 1 or (not self.grammar.strict and self.symbol != "/"):
                return self.call("ATAN", arguments)
            self.need("/")
            self.need("[")
            arguments += self.enumerated("]")
        return self._in_range(self.call(OF_TWO, arguments))

    def _in_range(self, node: Node) -> Node:
        """The angle [deg] of a function, by the controller's range where it is below zero."""
        if not self.grammar.bits:
            return node
        angle, to_360 = _function(node), self.grammar.to_360

        def within(variables: Variables) -> float:
            found = angle(variables)
            if found >= 0.0:
                return found
            variables.say(ATAN_TO_360 if to_360 else ATAN_SIGNED)
            return found + 360.0 if to_360 else found

        return within

    def _reference(self) -> Reference:
        """What stands behind #."""
        if self.symbol == "<":
            match = _NAME.match(self.text, self.end)
            if match is None:
                raise BlockError("the name of a variable must end with '>': write it like #<depth>")
            self.go_to(match.end())
            return Reference("".join(match[0][:-1].split()))
        inner = self.value()
        if isinstance(inner, float):
            return Reference(whole(inner, "the number of a variable"))
        return Reference(_function(inner))

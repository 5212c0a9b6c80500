"""Expressions of programs: one operator-precedence parser (Pratt 1973), to which each language gives its tables.

    expression(least):
        left = value()
        while the next operator binds more than `least`:
            go past it
            left = joined(operator, left, expression(its binding))

Operators are left-associative, and signs bind more than all of them. An expression becomes a node: a number where all
of it is constant, else a function of the variables.
"""

from __future__ import annotations

import math
import operator
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar, Generic, TypeVar, cast

from toolpace.common.units import DEGREE

Node = TypeVar("Node")
"""A number, or a function of what holds the variables."""
Function = Callable[..., object]


class BlockError(ValueError):
    """A block that cannot be read or executed; the message says why and what to write."""


class ExpressionParser(ABC, Generic[Node]):
    """Reads values and expressions, one behind the other."""

    operators: Mapping[str, tuple[int, Function]]
    """How much each binds, and what it makes of two values."""
    functions: Mapping[str, tuple[int, Function]]
    """How many arguments each takes, and what it makes of them."""
    signs: Mapping[str, Function | None] = {"-": operator.neg, "+": None}
    """What stands before a value; None where the value stays as it is."""
    brackets: ClassVar[tuple[str, str]] = ("(", ")")
    deepest: ClassVar[int] = 60
    """Brackets, functions and signs within each other: more is no expression that anybody wrote."""
    longest: ClassVar[int] = 500
    """Operators that one parser reads, since values of long sums are worked out from within."""
    cure: ClassVar[str] = "write a number, a variable or an expression"
    """Where a value is missing."""

    def __init__(self) -> None:
        self.depth = self.length = 0

    @abstractmethod
    def symbol(self) -> str:
        """The next token where it can be a mark or the name of an operator, without taking it; else empty."""

    @abstractmethod
    def step(self) -> None:
        """Go past the symbol."""

    @abstractmethod
    def found(self) -> str:
        """What comes next, in messages."""

    @abstractmethod
    def operand(self) -> Node:
        """A value that begins with neither sign nor bracket: a number, a variable, a function."""

    def operator(self) -> str:
        """The symbol behind a value."""
        return self.symbol()

    def go_past(self, name: str) -> None:
        """Go past an operator. Raises BlockError where there are too many."""
        self.length += 1
        if self.length > self.longest:
            raise BlockError(f"more than {self.longest} operators in an expression: split it")
        self.step()

    def joined(self, name: str, left: Node, right: Node) -> Node:
        """The node of an operator."""
        return joined(self.operators[name][1], left, right)

    def expression(self, least: int = 0) -> Node:
        """Values joined by operators that bind more than `least`. Raises BlockError."""
        left = self.value()
        while True:
            name = self.operator()
            binding = self.operators[name][0] if name in self.operators else 0
            if binding <= least:
                return left
            self.go_past(name)
            left = self.joined(name, left, self.expression(binding))

    def value(self) -> Node:
        """An operand or an expression in brackets, with signs before it. Raises BlockError."""
        self.depth += 1
        if self.depth > self.deepest:
            raise BlockError(f"more than {self.deepest} brackets and signs within each other: split the expression")
        symbol = self.symbol()
        if symbol in self.signs:
            self.step()
            function, made = self.signs[symbol], self.value()
            if function is not None:
                made = applied(function, made)
        elif symbol == self.brackets[0]:
            self.step()
            made = self.expression()
            self.need(self.brackets[1])
        else:
            made = self.operand()
        self.depth -= 1
        return made

    def passes(self, mark: str) -> bool:
        """Go past this mark, if it is next."""
        if self.symbol() != mark:
            return False
        self.step()
        return True

    def need(self, mark: str) -> None:
        """Go past this mark. Raises BlockError where another token is next."""
        if not self.passes(mark):
            raise BlockError(f"'{mark}' is missing before {self.found()}: write it there")

    def enumerated(self, closing: str) -> list[Node]:
        """Expressions between commas, up to the closing mark, which is passed. Raises BlockError."""
        made = [self.expression()]
        while self.passes(","):
            made.append(self.expression())
        self.need(closing)
        return made

    def call(self, name: str, arguments: list[Node]) -> Node:
        """The node of a function. Raises BlockError where it takes another number of arguments."""
        count, function = self.functions[name]
        if len(arguments) != count:
            plural = "" if count == 1 else "s"
            raise BlockError(f"{name} takes {count} argument{plural}, not {len(arguments)}: correct them")
        return applied(function, *arguments)

    def missing(self) -> BlockError:
        """The error where no value begins."""
        return BlockError(f"a value is missing before {self.found()}: {self.cure}")


class TextParser(ExpressionParser[Node]):
    """Takes its tokens out of a text, as they are asked for."""

    token: ClassVar[re.Pattern[str]]
    """One token, as a group with the name of its kind; those of the kind `number` and `name` are no symbols."""

    def __init__(self, text: str, at: int = 0) -> None:
        super().__init__()
        self.text, self.at = text, at
        self.end = at
        """Where the token that was looked at last ends."""

    def peek(self) -> tuple[str, str]:
        """Kind and text of the next token, without taking it; both are empty where none is."""
        match = self.token.match(self.text, self.at)
        if match is None:
            return "", ""
        self.end = match.end()
        kind = cast(str, match.lastgroup)
        return kind, match[kind]

    def symbol(self) -> str:
        """Any token but numbers."""
        kind, text = self.peek()
        return "" if kind == "number" else text

    def step(self) -> None:
        """Go behind the token that was looked at last."""
        self.at = self.end

    def found(self) -> str:
        """The text that is left."""
        rest = self.text[self.at : self.at + 20].strip()
        return f"'{rest}'" if rest else "the end of the block"


def joined(function: Function, left: Node, right: Node) -> Node:
    """The node of a function of two nodes; a number where both are."""
    first, second = cast(Function, left), cast(Function, right)
    if isinstance(left, float):
        if isinstance(right, float):
            return cast(Node, function(left, right))
        return cast(Node, lambda variables: function(left, second(variables)))
    if isinstance(right, float):
        return cast(Node, lambda variables: function(first(variables), right))
    return cast(Node, lambda variables: function(first(variables), second(variables)))


def applied(function: Function, *nodes: Node) -> Node:
    """The node of a function of nodes; a number where all of them are."""
    if len(nodes) == 2:
        return joined(function, *nodes)
    if all(isinstance(node, float) for node in nodes):
        return cast(Node, function(*nodes))
    if len(nodes) == 1:
        inner = cast(Function, nodes[0])
        return cast(Node, lambda variables: function(inner(variables)))
    values = [cast(Function, constant(node) if isinstance(node, float) else node) for node in nodes]
    return cast(Node, lambda variables: function(*[value(variables) for value in values]))


def constant(value: object) -> Callable[[object], object]:
    """A function that has this value whatever the variables are."""
    return lambda variables: value


# What numbers come to


def checked(name: str, function: Callable[..., float]) -> Callable[..., float]:
    """A function that raises BlockError where it has no value."""

    def run(*values: float) -> float:
        try:
            return float(function(*values))
        except (ArithmeticError, ValueError):
            shown = " and ".join(f"{value:g}" for value in values)
            raise BlockError(f"{name} of {shown} is no number: check the expression and its variables") from None

    return run


def divided(a: float, b: float) -> float:
    """a / b. Raises BlockError."""
    if b == 0.0:
        raise BlockError("division by zero: check the expression and its variables")
    return a / b


def remainder(a: float, b: float) -> float:
    """What is left of a behind whole times b, with the sign of a. Raises BlockError."""
    if b == 0.0:
        raise BlockError("a remainder of a division by zero: check the expression and its variables")
    return _remainder(a, b)


_remainder = checked("the remainder", math.fmod)


def power(a: float, b: float) -> float:
    """a to the power of b. Raises BlockError."""
    try:
        return math.pow(a, b)
    except (ArithmeticError, ValueError):
        raise BlockError(f"{a:g} to the power of {b:g} is no number: check the expression and its variables") from None


def half_away_from_zero(value: float) -> float:
    """The next whole number, halves away from zero."""
    return math.copysign(math.floor(abs(value) + 0.5), value)


def away_from_zero(value: float) -> float:
    """The next whole number that is no nearer to zero."""
    return math.copysign(math.ceil(abs(value)), value)


_OF_ONE: Mapping[str, Callable[..., float]] = {
    "SIN": lambda x: math.sin(x * DEGREE),
    "COS": lambda x: math.cos(x * DEGREE),
    "TAN": lambda x: math.tan(x * DEGREE),
    "ASIN": lambda x: math.asin(x) / DEGREE,
    "ACOS": lambda x: math.acos(x) / DEGREE,
    "ATAN": lambda x: math.atan(x) / DEGREE,
    "SQRT": math.sqrt,
    "ABS": abs,
    "LN": math.log,
    "EXP": math.exp,
}
FUNCTIONS: Mapping[str, tuple[int, Callable[..., float]]] = {
    name: (1, checked(name, function)) for name, function in _OF_ONE.items()
}
"""Functions of one number that all languages have, with angles in degrees."""

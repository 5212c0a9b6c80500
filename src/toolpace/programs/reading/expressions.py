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

Function = Callable[..., object]
Node = TypeVar("Node", bound=float | Function)
"""A number, or a function of what holds the variables."""
NONE: tuple[int, Function] = (0, lambda: None)


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
    bracketed: ClassVar[frozenset[str]] = frozenset()
    """Operators that need brackets behind a sign, a function or themselves: which goes first is not said."""
    opening, closing = "(", ")"
    deepest: ClassVar[int] = 60
    """Brackets, functions and signs within each other: more is no expression that anybody wrote."""
    longest: ClassVar[int] = 500
    """Operators that one parser reads, since values of long sums are worked out from within."""
    cure: ClassVar[str] = "write a number, a variable or an expression"
    """Where a value is missing."""
    symbol: str
    """The next token where it can be a mark or the name of an operator, else empty."""
    depth = length = 0
    """Of what is being read."""

    @abstractmethod
    def step(self) -> None:
        """Go past the next token."""

    @abstractmethod
    def found(self) -> str:
        """The next token, in messages."""

    @abstractmethod
    def operand(self) -> Node:
        """A value that begins with neither sign nor bracket: a number, a variable, a function."""

    def expression(self, least: int = 0) -> Node:
        """Values joined by operators that bind more than `least`. Raises BlockError."""
        before = self.symbol
        left = self.value()
        while True:
            name = self.symbol
            binding, function = self.operators.get(name, NONE)
            if binding <= least:
                return left
            if name in self.bracketed and (before == name or before in self.signs or before in self.functions):
                raise BlockError(f"{name} needs brackets here: which part goes first is not said")
            self.length += 1
            if self.length > self.longest:
                raise BlockError(f"more than {self.longest} operators in an expression: split it")
            self.step()
            left = self.joined(name, function, left, self.expression(binding))
            before = name

    def value(self) -> Node:
        """An operand or an expression in brackets, with signs before it. Raises BlockError."""
        self.depth += 1
        if self.depth > self.deepest:
            raise BlockError(f"more than {self.deepest} brackets and signs within each other: split the expression")
        symbol = self.symbol
        if symbol == self.opening:
            self.step()
            made = self.expression()
            self.need(self.closing)
        elif symbol in self.signs:
            self.step()
            function, made = self.signs[symbol], self.value()
            if function is not None:
                made = cast(Node, compiled(function, made))
        else:
            made = self.operand()
        self.depth -= 1
        return made

    def joined(self, name: str, function: Function, left: Node, right: Node) -> Node:
        """The node of an operator."""
        if isinstance(left, float):
            if isinstance(right, float):
                return cast(Node, function(left, right))
            return cast(Node, lambda variables: function(left, right(variables)))
        if isinstance(right, float):
            return cast(Node, lambda variables: function(left(variables), right))
        return cast(Node, lambda variables: function(left(variables), right(variables)))

    def call(self, name: str, arguments: list[Node]) -> Node:
        """The node of a function. Raises BlockError where it takes another number of arguments."""
        count, function = self.functions[name]
        if len(arguments) != count:
            plural = "" if count == 1 else "s"
            raise BlockError(f"{name} takes {count} argument{plural}, not {len(arguments)}: correct them")
        return cast(Node, compiled(function, *arguments))

    def enumerated(self, closing: str) -> list[Node]:
        """Expressions between commas, up to the closing mark, which is passed. Raises BlockError."""
        made = [self.expression()]
        while self.passes(","):
            made.append(self.expression())
        self.need(closing)
        return made

    def passes(self, mark: str) -> bool:
        """Go past this mark, if it is next."""
        if self.symbol != mark:
            return False
        self.step()
        return True

    def need(self, mark: str) -> None:
        """Go past this mark. Raises BlockError where another token is next."""
        if not self.passes(mark):
            raise BlockError(f"'{mark}' is missing before {self.found()}: write it there")

    def missing(self) -> BlockError:
        """The error where no value begins."""
        return BlockError(f"a value is missing before {self.found()}: {self.cure}")


class TextParser(ExpressionParser[Node]):
    """Takes its tokens out of a text, one ahead."""

    token: ClassVar[re.Pattern[str]]
    """One token, as a group with the name of its kind."""

    def __init__(self, text: str, at: int = 0) -> None:
        self.text = text
        self.go_to(at)

    def go_to(self, at: int) -> None:
        """Look at the token behind a place; kind and symbol are empty where there is none."""
        self.end = at
        self.step()

    def step(self) -> None:
        """Go past the next token."""
        self.at = at = self.end
        match = self.token.match(self.text, at)
        if match is None:
            self.kind = self.symbol = ""
        else:
            self.kind = kind = match.lastgroup or ""
            self.symbol, self.end = match[kind], match.end()

    def found(self) -> str:
        """The text that is left."""
        rest = self.text[self.at : self.at + 20].strip()
        return f"'{rest}'" if rest else "the end of the block"


def compiled(function: Function, *nodes: float | Function) -> object:
    """The node of a function of nodes; a number where all of them are."""
    if len(nodes) == 1:
        node = nodes[0]
        return function(node) if isinstance(node, float) else lambda variables: function(node(variables))
    if all(isinstance(node, float) for node in nodes):
        return function(*nodes)
    values = [constant(node) if isinstance(node, float) else node for node in nodes]
    return lambda variables: function(*[value(variables) for value in values])


def constant(value: object) -> Callable[[object], object]:
    """A function that has this value whatever the variables are."""
    return lambda variables: value


# What numbers come to


def checked(name: str, function: Callable[[float], float]) -> Callable[[float], float]:
    """A function of one number that raises BlockError where it has no value."""

    def run(value: float) -> float:
        try:
            return function(value)
        except (ArithmeticError, ValueError):
            raise BlockError(f"{name} of {value:g} is no number: check the expression and its variables") from None

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
    if math.isinf(a):
        raise BlockError(f"a remainder of {a:g} is no number: check the expression and its variables")
    return math.fmod(a, b)


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


_OF_ONE: Mapping[str, Callable[[float], float]] = {
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

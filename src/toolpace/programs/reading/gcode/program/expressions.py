"""Expressions of variables, parsed by binding powers (Pratt 1973) into functions.

After the documents of LinuxCNC (Parameters and Expressions) and Fanuc (Custom Macro B): brackets are [ ], angles are
in degrees, and a variable may be empty, which counts as zero wherever it is reckoned with.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from toolpace.programs.reading.gcode.program.increments import rounded
from toolpace.programs.reading.gcode.program.operations import (
    BITS,
    FUNCTIONS,
    LONG,
    OPERATIONS,
    TOWARDS_ZERO,
    TRUTH,
    WHOLE_REMAINDER,
    long_degrees,
)
from toolpace.programs.reading.gcode.program.words import WordError, bounded

if TYPE_CHECKING:
    from toolpace.programs.reading.gcode.program.variables import Variables

Node: TypeAlias = "float | Reference | Callable[[Variables], float]"
"""A constant, a variable, or what is made of them."""
MOST_NESTED = 60
"""Brackets and signs within each other: more is no expression that anybody wrote."""
EQUAL = 1e-4
"""Difference of two numbers that EQ takes for none (LinuxCNC, "Binary Operators")."""
ATAN_TO_360 = "ASIN and ATAN give angles from 0 to 360 degrees (parameter 6004#0 = 0 of Fanuc; with 1 below zero too)"
ATAN_SIGNED = "ASIN and ATAN give angles from -180 to 180 degrees"
_TOKEN = re.compile(r"[ \t]*+(?:([0-9]++(?:\.[0-9]*+)?|\.[0-9]++)|([A-Z]++)|(\*\*|[-+*/\[\]#<,]))")
_NAME = re.compile(r"(?:_(?:HAL|INI)\[[^>\[\]#]{1,100}\][^>\[\]#]{0,100}|[^>\[\]#]{1,200})>")


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
    """A value as a whole number; WordError where it is none."""
    if not abs(value) <= 1e9 or abs(value - round(value)) >= 1e-4:
        raise WordError(f"{what} must be a whole number, not {value:g}: correct it")
    return round(value)


def value_of(node: Node, variables: Variables) -> float | None:
    """What a node comes to; None where it is an empty variable."""
    if isinstance(node, float):
        return node
    return node.value(variables) if isinstance(node, Reference) else node(variables)


def _function(node: Node) -> Callable[[Variables], float]:
    return (lambda variables: node) if isinstance(node, float) else node


class Parser:
    """Reads values and expressions of one block from a place on."""

    def __init__(
        self,
        text: str,
        at: int = 0,
        *,
        bits: bool = False,
        letter: str = "",
        strict: bool = False,
        whole_remainder: bool = False,
        to_360: bool = False,
    ) -> None:
        """bits: AND, OR and XOR work on bits and bind like * and + (Fanuc); else on truth, last of all (LinuxCNC).

        letter: with a number behind it it is a variable too (E254 of MillPlus). strict: expressions are
        those of LinuxCNC's interpreter, whose ATAN takes two values. whole_remainder: MOD takes whole numbers. to_360:
        no angle that ASIN and ATAN of two values give is below zero.
        """
        self.to_360 = to_360
        self.address = ""
        """The letter of the word whose value is read, to whose least increment ROUND then rounds (Custom Macro B)."""
        self.text, self.at, self.bits, self.letter, self.strict = text, at, bits, letter, strict
        self.operations = OPERATIONS | (BITS if bits else TRUTH) | (WHOLE_REMAINDER if whole_remainder else {})
        self.functions = FUNCTIONS | (TOWARDS_ZERO if bits else {}) | (LONG if strict else {})
        self.depth = 0
        self.end = at
        """Where the token that was looked at last ends."""

    def peek(self) -> tuple[str, str]:
        """Kind (number, name, mark, or nothing) and text of the next token, without taking it."""
        match = _TOKEN.match(self.text, self.at)
        if match is None:
            return "", ""
        self.end = match.end()
        for kind, text in zip(("number", "name", "mark"), match.groups()):
            if text is not None:
                return kind, text
        return "", ""

    def take(self, mark: str) -> None:
        """Go past a mark that has to stand here."""
        if self.peek() != ("mark", mark):
            raise WordError(f"'{mark}' is missing before '{self.text[self.at : self.at + 20]}': correct the expression")
        self.at = self.end

    def lacks_value(self) -> bool:
        """Whether no value begins here."""
        kind, text = self.peek()
        if kind == "name":
            return "[" not in self.text[self.end : self.end + 3] and text != self.letter
        return not kind or text in ("]", "/", "*", "**", "<")

    def value(self) -> Node:
        """A number, a variable, an expression in brackets, or a function of one, with signs before it."""
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise WordError(f"an expression is nested more than {MOST_NESTED} deep: split it")
        kind, text = self.peek()
        if kind == "number":
            self.at = self.end
            found: Node = bounded(float(text))
        elif kind == "name":
            found = self._named(text)
        elif text == "#":
            self.at = self.end
            found = self._reference()
        elif text == "[":
            self.at = self.end
            found = self.expression()
            self.take("]")
        elif text in ("-", "+"):
            self.at = self.end
            inner = self.value()
            found = inner if text == "+" else _applied(lambda a: -a, inner)
        else:
            raise WordError(
                f"a value is missing before '{self.text[self.at : self.at + 20]}': write a number, # or [ ]"
            )
        self.depth -= 1
        return found

    def expression(self, least: int = 0) -> Node:
        """Values joined by operations that bind at least so strongly."""
        left = self.value()
        while True:
            text = self._operator()
            power, operation = self.operations.get(text, (0, None))
            if operation is None or power <= least:
                return left
            self.at = self.end
            right = self.expression(power)
            if text in ("EQ", "NE"):
                left = _equal(text, left, right) if self.bits else _near(text, left, right)
            else:
                left = _combined(operation, left, right)

    def _operator(self) -> str:
        """The next token; of letters that begin with an operation that operation, since no blank need follow it."""
        kind, text = self.peek()
        if kind == "name" and text not in self.operations:
            for name in self.operations:
                if text.startswith(name) and name.isalpha():
                    self.end -= len(text) - len(name)
                    return name
        return text

    def _named(self, name: str) -> Node:
        self.at = self.end
        if name == self.letter and self.peek()[0] == "number":
            number = self.value()
            assert isinstance(number, float)
            return Reference(whole(number, f"the number behind {name}"))
        if name == "ATAN" or (name == "POW" and self.bits):
            return self._of_two(name)
        if name == "EXISTS":
            self.take("[")
            self.take("#")
            reference = self._reference()
            self.take("]")
            return lambda variables: float(variables.exists(reference.key(variables)))
        function = self.functions.get(name)
        if function is None:
            raise WordError(f"'{name[:20]}' is no function that is known here: write the value out")
        self.take("[")
        inner = self.expression()
        self.take("]")
        if name == "ROUND" and self.bits and self.address:
            letter, value = self.address, _function(inner)
            return lambda variables: rounded(value(variables), variables.increment(letter))
        return self._turned(_applied(function, inner), name) if name == "ASIN" else _applied(function, inner)

    def _of_two(self, name: str) -> Node:
        """ATAN[a]/[b], ATAN[a]; Fanuc has ATAN[a,b] and POW[a,b] too (B-64304EN, "Arithmetic and logic operation")."""
        self.take("[")
        first = self.expression()
        inside = self.bits and (name == "POW" or self.peek() == ("mark", ","))
        if inside:
            self.take(",")
        else:
            self.take("]")
            if self.peek() != ("mark", "/") and not self.strict:
                return _applied(lambda a: math.degrees(math.atan(a)), first)
            self.take("/")
            self.take("[")
        second = self.expression()
        self.take("]")
        if name == "POW":
            return _combined(OPERATIONS["**"][1], first, second)
        degrees = long_degrees if self.strict else math.degrees
        return self._turned(_combined(lambda a, b: degrees(math.atan2(a, b)), first, second), name)

    def _turned(self, node: Node, name: str) -> Node:
        """The angle [deg] of a function, by the controller's range where it is below zero."""
        if not self.bits:
            return node
        angle, shown = _function(node), ATAN_TO_360 if self.to_360 else ATAN_SIGNED

        def within(variables: Variables) -> float:
            found = angle(variables)
            if found >= 0.0:
                return found
            variables.say(shown)
            return found + 360.0 if self.to_360 else found

        return within

    def _reference(self) -> Reference:
        """What stands behind #."""
        _, text = self.peek()
        if text == "<":
            match = _NAME.match(self.text, self.end)
            if match is None:
                raise WordError("the name of a variable must end with '>': write it like #<depth>")
            self.at = match.end()
            return Reference("".join(match[0][:-1].split()))
        inner = self.value()
        if isinstance(inner, float):
            return Reference(whole(inner, "the number of a variable"))
        return Reference(_function(inner))


def _applied(function: Callable[[float], float], inner: Node) -> float | Callable[[Variables], float]:
    if isinstance(inner, float):
        return float(function(inner))
    return lambda variables: function(inner(variables))


def _combined(
    operation: Callable[[float, float], float],
    left: Node,
    right: Node,
) -> float | Callable[[Variables], float]:
    if isinstance(left, float):
        if isinstance(right, float):
            return operation(left, right)
        return lambda variables: operation(left, right(variables))
    if isinstance(right, float):
        return lambda variables: operation(left(variables), right)
    return lambda variables: operation(left(variables), right(variables))


def _equal(
    name: str,
    left: Node,
    right: Node,
) -> Callable[[Variables], float]:
    """An empty variable is equal to an empty one only, not to zero (Fanuc)."""
    wanted = name == "EQ"
    return lambda variables: float((value_of(left, variables) == value_of(right, variables)) == wanted)


def _near(name: str, left: Node, right: Node) -> float | Callable[[Variables], float]:
    """Numbers are equal that differ by less than EQUAL (LinuxCNC)."""
    wanted = name == "EQ"
    return _combined(lambda a, b: float((abs(a - b) < EQUAL) == wanted), left, right)

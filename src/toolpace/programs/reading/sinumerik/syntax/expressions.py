"""Expressions by precedence climbing (Pratt 1973), compiled to functions of the memory.

Priorities (NC Programming 12/2019, 3.1.3.3), from what binds most: NOT B_NOT; * / DIV MOD; + -; B_AND; B_XOR; B_OR;
AND; XOR; OR; <<; and the comparisons last, so that (A==1) AND (B==2) needs its brackets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.sinumerik.syntax import frame_functions
from toolpace.programs.reading.sinumerik.syntax.lexer import (
    END,
    LETTER,
    NAME,
    NUMBER,
    SIGN,
    SYSTEM,
    TEXT,
    WORD,
    SyntaxFault,
    Token,
)
from toolpace.programs.reading.sinumerik.syntax.values import (
    CONSTANTS,
    FUNCTIONS,
    Axis,
    Compiled,
    Memory,
    Row,
    Value,
    ValueFault,
    above,
    equal,
    nonzero,
    real,
    text,
    whole,
)

DEEPEST = 40
"""Brackets and signs within each other."""


def _chain(a: Value, b: Value) -> Value:
    if not isinstance(a, tuple) or not isinstance(b, tuple) or isinstance(a, Axis) or isinstance(b, Axis):
        raise ValueFault("`:` joins frames, like CTRANS(X,1):CROT(Z,30): correct it")
    return affine.product(a, b)


_Operation = Callable[[Value, Value], Value]
OPERATIONS: dict[str, tuple[int, _Operation]] = {
    "*": (90, lambda a, b: real(a) * real(b)),
    "/": (90, lambda a, b: real(a) / nonzero(b)),
    "DIV": (90, lambda a, b: math.trunc(real(real(a) / nonzero(b)))),
    "MOD": (90, lambda a, b: math.fmod(real(a), nonzero(b))),
    ":": (90, _chain),
    "+": (80, lambda a, b: real(a) + real(b)),
    "-": (80, lambda a, b: real(a) - real(b)),
    "B_AND": (70, lambda a, b: whole(a) & whole(b)),
    "B_XOR": (65, lambda a, b: whole(a) ^ whole(b)),
    "B_OR": (60, lambda a, b: whole(a) | whole(b)),
    "AND": (55, lambda a, b: bool(real(a)) and bool(real(b))),
    "XOR": (50, lambda a, b: bool(real(a)) != bool(real(b))),
    "OR": (45, lambda a, b: bool(real(a)) or bool(real(b))),
    "<<": (40, lambda a, b: (text(a) + text(b))[:400]),
    "==": (30, equal),
    "<>": (30, lambda a, b: not equal(a, b)),
    ">": (30, above),
    "<": (30, lambda a, b: above(b, a)),
    ">=": (30, lambda a, b: not above(b, a)),
    "<=": (30, lambda a, b: not above(a, b)),
}
UNARY: dict[str, Callable[[Value], Value]] = {
    "-": lambda a: -real(a),
    "+": real,
    "NOT": lambda a: not bool(real(a)),
    "B_NOT": lambda a: ~whole(a),
}


def constant(value: Value) -> Compiled:
    """A function that always has this value."""
    return lambda memory: value


def literal(place: int) -> Compiled:
    """A function that has the value of a constant of the block at hand."""
    return lambda memory: memory.literals[place]


class Parser:
    """Reads the tokens of one block, one after the other."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0

    @property
    def token(self) -> Token:
        """The next token."""
        return self.tokens[self.at]

    def take(self) -> Token:
        """The next token, which is passed."""
        token = self.tokens[self.at]
        self.at += token.kind != END
        return token

    def sign(self, wanted: str) -> bool:
        """Pass this sign, if it is next."""
        token = self.tokens[self.at]
        found = token.kind == SIGN and token.text == wanted
        self.at += found
        return found

    def need(self, wanted: str) -> None:
        """Pass this sign; SyntaxFault where another token is next."""
        if not self.sign(wanted):
            raise SyntaxFault(f"'{wanted}' is missing before {self.found()}: write it there")

    def found(self) -> str:
        """The next token, in messages."""
        return self.token.text[:30] if self.token.kind == END else f"'{self.token.text[:30]}'"

    def expression(self, least: int = 0) -> Compiled:
        """An expression whose operators bind at least so much."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise SyntaxFault(f"the expression has more than {DEEPEST} brackets within each other: split it")
        left = self._operand()
        while True:
            token = self.token
            known = OPERATIONS.get(token.text) if token.kind in (SIGN, NAME) else None
            if known is None or known[0] < max(least, 1):
                break
            self.take()
            left = _joined(known[1], left, self.expression(known[0] + 1))
        self.depth -= 1
        return left

    def assigned(self) -> Compiled:
        """What an element of an array is given: an expression, or SET(...) and REP(...) for those behind it too."""
        name, bracket = self.token, self.tokens[min(self.at + 1, len(self.tokens) - 1)]
        if name.kind != NAME or name.text not in ROWS or bracket.text != "(":
            return self.expression()
        self.take()
        self.take()
        return self.row(name.text)

    def row(self, name: str) -> Compiled:
        """The values of SET or REP; the opening bracket was passed."""
        arguments = self.arguments()
        given = [argument for argument in arguments if argument is not None]
        if not given or len(given) < len(arguments) or (name == "REP" and len(given) > 1):
            raise SyntaxFault(f"{name} takes {'one value' if name == 'REP' else 'values'}: write it like {name}(5)")
        return lambda memory: Row(tuple(value(memory) for value in given), name == "REP")

    def arguments(self) -> list[Compiled | None]:
        """Arguments in brackets, None for each that is left out; the opening bracket was passed."""
        found: list[Compiled | None] = []
        if self.sign(")"):
            return found
        while True:
            empty = self.token.kind == SIGN and self.token.text in (",", ")")
            found.append(None if empty else self.expression())
            if self.sign(")"):
                return found
            self.need(",")

    def index(self) -> list[Compiled]:
        """Indices in square brackets; the opening one was passed."""
        found = [self.expression()]
        while self.sign(","):
            found.append(self.expression())
        self.need("]")
        return found

    def _operand(self) -> Compiled:
        token = self.take()
        if token.kind == NUMBER:
            return literal(int(token.value)) if token.marked else constant(token.value)
        if token.kind == TEXT:
            return constant(token.text)
        if token.kind == SIGN and token.text == "(":
            inner = self.expression()
            self.need(")")
            return inner
        if token.text in UNARY and token.kind in (SIGN, NAME):
            return _applied(UNARY[token.text], self.expression(100))
        if token.kind in (WORD, LETTER):
            return self._parameter(token)
        if token.kind == NAME:
            return self._named(token.text)
        if token.kind == SYSTEM:
            return _system(token.text, self.index() if self.sign("[") else [])
        self.at -= token.kind != END
        raise SyntaxFault(f"a value is missing before {self.found()}: write a number, a variable or an expression")

    def _parameter(self, token: Token) -> Compiled:
        if token.text == "R" and self.sign("["):
            (index,) = self.index()[:1]
            return lambda memory: memory.r.get(r_number(index(memory)), 0.0)
        if token.text[0] == "R" and token.text[1:].isdigit():
            number = r_number(token.value)
            return lambda memory: memory.r.get(number, 0.0)
        if token.kind == LETTER:
            return lambda memory: memory.letter(token.text)
        if token.text[1:].isdigit():
            return constant(Axis(token.text))
        raise SyntaxFault(f"'{token.text[:30]}' is no value: write a number, R1, or a variable")

    def _named(self, name: str) -> Compiled:
        if name in CONSTANTS:
            return constant(CONSTANTS[name])
        if name in FUNCTIONS or name in frame_functions.FUNCTIONS:
            self.need("(")
            given = self.arguments()
            if any(argument is None for argument in given):
                raise SyntaxFault(f"{name} lacks an argument: write it")
            arguments = [argument for argument in given if argument is not None]
            if name in frame_functions.FUNCTIONS:
                return lambda memory: frame_functions.made(name, [a(memory) for a in arguments], memory.unit)
            count, function = FUNCTIONS[name]
            if len(arguments) != count:
                raise SyntaxFault(f"{name} takes {count} arguments, not {len(arguments)}: correct them")
            return lambda memory: function(*[real(argument(memory)) for argument in arguments])
        if self.sign("["):
            indices = self.index()
            return lambda memory: memory.variable(name, tuple(whole(index(memory)) for index in indices))
        if self.token.kind == SIGN and self.token.text == "(":
            raise SyntaxFault(f"{name[:30]}(..) is no function that is read: write what it gives")
        return Named(name)


@dataclass(frozen=True)
class Named:
    """The value of a variable that stands alone: what a subprogram can be handed over by reference."""

    name: str

    def __call__(self, memory: Memory) -> Value:
        """The value as it is now."""
        return memory.variable(self.name, ())


ROWS = ("SET", "REP")
MOST_R = 32_536
"""Of MD28050, which says how many a machine has."""


def r_number(value: Value) -> int:
    """Number of an R parameter."""
    found = whole(value)
    if not 0 <= found < MOST_R:
        raise ValueFault(f"R{found} is no R parameter (alarm 12290): controls have at most R0 to R{MOST_R - 1}")
    return found


def _joined(operation: _Operation, left: Compiled, right: Compiled) -> Compiled:
    return lambda memory: operation(left(memory), right(memory))


def _applied(operation: Callable[[Value], Value], operand: Compiled) -> Compiled:
    return lambda memory: operation(operand(memory))


def _system(name: str, indices: list[Compiled]) -> Compiled:
    return lambda memory: memory.system(name, tuple(index(memory) for index in indices))

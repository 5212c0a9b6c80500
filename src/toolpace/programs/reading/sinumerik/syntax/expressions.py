"""Expressions of Sinumerik, compiled to functions of the memory."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from toolpace.common.units import DEGREE
from toolpace.programs.reading import expressions
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.expressions import (
    BlockError,
    ExpressionParser,
    away_from_zero,
    divided,
    half_away_from_zero,
    remainder,
)
from toolpace.programs.reading.sinumerik.syntax.lexer import (
    END,
    LETTER,
    NAME,
    NUMBER,
    SIGN,
    TEXT,
    WORD,
    Token,
)
from toolpace.programs.reading.sinumerik.syntax.values import (
    FRAME_FUNCTIONS,
    Axis,
    Compiled,
    Memory,
    Row,
    Value,
    above,
    equal,
    frame,
    real,
    text,
    whole,
)


def _of_reals(count: int, function: Callable[..., float]) -> Callable[..., float]:
    """A function of values, which have to be numbers."""
    return (lambda value: function(real(value))) if count == 1 else (lambda *values: function(*map(real, values)))


def _chain(a: Value, b: Value) -> Value:
    if not isinstance(a, tuple) or not isinstance(b, tuple) or isinstance(a, Axis) or isinstance(b, Axis):
        raise BlockError("`:` joins frames, like CTRANS(X,1):CROT(Z,30): correct it")
    return affine.product(a, b)


OPERATIONS: dict[str, tuple[int, Callable[[Value, Value], Value]]] = {
    "*": (90, lambda a, b: real(a) * real(b)),
    "/": (90, lambda a, b: divided(real(a), real(b))),
    "DIV": (90, lambda a, b: math.trunc(real(divided(real(a), real(b))))),
    "MOD": (90, lambda a, b: remainder(real(a), real(b))),
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
"""How much operators bind, and what they make of two values (NC Programming 12/2019, 3.1.3.3): comparisons bind least,
so that (A==1) AND (B==2) needs its brackets."""
UNARY: dict[str, Callable[[Value], Value]] = {
    "-": lambda a: -real(a),
    "+": real,
    "NOT": lambda a: not bool(real(a)),
    "B_NOT": lambda a: ~whole(a),
}
_OF_NUMBERS: dict[str, tuple[int, Callable[..., float]]] = {
    **{name: expressions.FUNCTIONS[name] for name in ("SIN", "COS", "TAN", "ASIN", "ACOS", "SQRT", "ABS", "LN", "EXP")},
    "ATAN2": (2, lambda y, x: math.atan2(y, x) / DEGREE),
    "POT": (1, lambda x: x * x),
    "TRUNC": (1, lambda x: float(math.trunc(x))),
    "ROUND": (1, half_away_from_zero),
    "ROUNDUP": (1, away_from_zero),
    "MINVAL": (2, min),
    "MAXVAL": (2, max),
    "BOUND": (3, lambda low, high, x: min(max(x, low), high)),
}
FUNCTIONS = {name: (count, _of_reals(count, function)) for name, (count, function) in _OF_NUMBERS.items()}
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


def constant(value: Value) -> Compiled:
    """A function that always has this value."""
    return lambda memory: value


def literal(place: int) -> Compiled:
    """A function that has the value of a constant of the block at hand."""
    return lambda memory: memory.literals[place]


class Parser(ExpressionParser[Compiled]):
    """Reads the tokens of one block, one after the other."""

    operators, functions, signs = OPERATIONS, FUNCTIONS, UNARY
    deepest = 40

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens = tokens
        self.go_to(0)

    def go_to(self, at: int) -> None:
        """Let this token be the next."""
        self.at, self.token = at, self.tokens[at]
        self.symbol = "" if self.token.kind == TEXT else self.token.text

    def step(self) -> None:
        """Go past the next token."""
        self.go_to(self.at + 1)

    def take(self) -> Token:
        """The next token, which is passed."""
        token = self.token
        if token.kind != END:
            self.step()
        return token

    def found(self) -> str:
        """The next token, in messages."""
        return self.token.text[:30] if self.token.kind == END else f"'{self.token.text[:30]}'"

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
            raise BlockError(f"{name} takes {'one value' if name == 'REP' else 'values'}: write it like {name}(5)")
        return lambda memory: Row(tuple(value(memory) for value in given), name == "REP")

    def arguments(self) -> list[Compiled | None]:
        """Arguments in brackets, None for each that is left out; the opening bracket was passed."""
        found: list[Compiled | None] = []
        if self.passes(")"):
            return found
        while True:
            empty = self.token.kind == SIGN and self.token.text in (",", ")")
            found.append(None if empty else self.expression())
            if self.passes(")"):
                return found
            self.need(",")

    def operand(self) -> Compiled:
        """A number, a text, a variable, or a function."""
        token = self.token
        if token.kind in (SIGN, END):
            raise self.missing()
        self.step()
        if token.kind == NUMBER:
            return literal(int(token.value)) if token.marked else constant(token.value)
        if token.kind == TEXT:
            return constant(token.text)
        if token.kind in (WORD, LETTER):
            return self._parameter(token)
        if token.kind == NAME:
            return self._named(token.text)
        return _system(token.text, self.enumerated("]") if self.passes("[") else [])

    def _parameter(self, token: Token) -> Compiled:
        if token.text == "R" and self.passes("["):
            (index,) = self.enumerated("]")[:1]
            return lambda memory: memory.r.get(r_number(index(memory)), 0.0)
        if token.text[0] == "R" and token.text[1:].isdigit():
            number = r_number(token.value)
            return lambda memory: memory.r.get(number, 0.0)
        if token.kind == LETTER:
            return lambda memory: memory.letter(token.text)
        if token.text[1:].isdigit():
            return constant(Axis(token.text))
        raise BlockError(f"'{token.text[:30]}' is no value: write a number, R1, or a variable")

    def _named(self, name: str) -> Compiled:
        if name in CONSTANTS:
            return constant(CONSTANTS[name])
        if name in FUNCTIONS or name in FRAME_FUNCTIONS:
            self.need("(")
            given = self.arguments()
            if any(argument is None for argument in given):
                raise BlockError(f"{name} lacks an argument: write it")
            arguments = [argument for argument in given if argument is not None]
            if name in FRAME_FUNCTIONS:
                return lambda memory: frame(name, [a(memory) for a in arguments], memory.unit)
            return self.call(name, arguments)
        if self.passes("["):
            indices = self.enumerated("]")
            return lambda memory: memory.variable(name, tuple(whole(index(memory)) for index in indices))
        if self.token.kind == SIGN and self.token.text == "(":
            raise BlockError(f"{name[:30]}(..) is no function that is read: write what it gives")
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
        raise BlockError(f"R{found} is no R parameter (alarm 12290): controls have at most R0 to R{MOST_R - 1}")
    return found


def _system(name: str, indices: list[Compiled]) -> Compiled:
    return lambda memory: memory.system(name, tuple(index(memory) for index in indices))

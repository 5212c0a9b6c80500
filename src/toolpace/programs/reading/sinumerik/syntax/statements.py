"""A block from its line: labels, words, assignments, calls."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.syntax.blocks import (
    ADDRESSES,
    FORMS,
    Assignment,
    Block,
    Call,
    Line,
    Word,
    flow_block,
)
from toolpace.programs.reading.sinumerik.syntax.expressions import Parser, constant, r_number
from toolpace.programs.reading.sinumerik.syntax.lexer import (
    END,
    FIGURE,
    LETTER,
    MARK,
    NAME,
    NUMBER,
    SIGN,
    SYSTEM,
    TEXT,
    WORD,
    Token,
    number,
    tokens,
    without_comment,
)
from toolpace.programs.reading.sinumerik.syntax.values import Compiled

_HEAD = re.compile(
    r"[ \t]*(?P<skip>/[0-9]?)?[ \t]*(?:(?P<number>[N:])[ \t]*(?P<digits>[0-9]+))?[ \t]*(?P<late>/[0-9]?)?[ \t]*"
    r"(?:(?P<label>[A-Z_][A-Z_][A-Z0-9_]*)[ \t]*:(?!=))?[ \t]*",
    re.IGNORECASE,
)
_CONSTANT = re.compile(
    rf"""[A-Z_$][A-Z_][A-Z0-9_]*+ | '[^']*' | [A-Z][0-9]++(?=[ \t]*=(?!=)) | [GMRLNPH][ \t]*[-+]?[0-9.]++
    | ([A-Z])[ \t]*([-+]?{FIGURE}) | ({FIGURE})""",
    re.VERBOSE,
)
"""Constants in capitals: of words that are no code, name or parameter, and within expressions."""
_PLAIN = re.compile(rf"(?:[ \t]*+(?:[GM][0-9]++|[A-FI-KQS-Z](?:[0-9]=)?[-+]?{FIGURE}))++[ \t]*+")
"""A line of codes and words with constants alone, as most lines of long programs are."""
_OF_PLAIN = re.compile(rf"(?<=[A-FI-KQS-Z=])[-+]?{FIGURE}(?!=)")
"""The constants of such a line."""
_CODES = ("G", "M")
KEPT = 1 << 14
"""Compiled blocks that are kept, for loops and subprograms: those of a whole long program would fill memory."""


class Head(NamedTuple):
    """What stands before the words of a block."""

    rest: str
    """The words."""
    number: str = ""
    """N10 in capitals, without leading zeros."""
    label: str = ""
    skip: bool = False
    """Whether `/` stands before it."""


def head(line: str) -> Head:
    """Number, label and `/` of a line, and the rest of its block without comment."""
    text = without_comment(line)
    if text[:1] == "%" and text.strip() == "%":
        text = ""  # the mark with which tapes began and ended; posts still write it
    found = _HEAD.match(text)
    assert found is not None
    skip, kind, digits, late, label = found.groups()
    rest = text[found.end() :] if found.end() else text
    number = f"{kind.upper()}{int(digits[-9:])}" if kind else ""
    return Head(rest, number, label.upper() if label else "", bool(skip or late))


def line(text: str) -> Line:
    """What the rest of a line says: the block of its shape, with its constants. A fault is part of the block."""
    upper = text.upper()
    # texts keep their letters: only blocks without them have a shape
    if '"' not in text and MARK not in text and len(upper) == len(text):
        try:
            shape, literals = _shape(upper)
            found = _shaped(shape)
        except BlockError as error:
            return Line(Block(fault=str(error)))
        if found is not None:
            return Line(found, literals)
    return Line(_exact(text))


def _shape(text: str) -> tuple[str, tuple[float, ...]]:
    """A line with marks for its constants, and these. Raises BlockError."""
    if _PLAIN.fullmatch(text):
        return _OF_PLAIN.sub(MARK, text), tuple(map(number, _OF_PLAIN.findall(text)))
    literals: list[float] = []

    def mark(match: re.Match[str]) -> str:
        letter, of_letter, alone = match.groups()
        if letter:
            literals.append(number(of_letter))
            return str(letter) + MARK
        if alone:
            literals.append(number(alone))
            return MARK
        return match[0]

    return _CONSTANT.sub(mark, text), tuple(literals)


@lru_cache(maxsize=KEPT)
def _shaped(shape: str) -> Block | None:
    """The block of a shape, whose constants are marks; None where it has to be read with its constants.

    Flow has, since the end of FOR and the defaults of PROC are asked for at other blocks; faults too, to show them.
    """
    try:
        found = _Reader(tokens(shape)).block()
    except BlockError:
        return None
    return None if found.flow is not None else found


@lru_cache(maxsize=KEPT)
def _exact(text: str) -> Block:
    if MARK in text:
        return Block(fault="the block has a character that cannot be printed: remove it")
    try:
        return _Reader(tokens(text)).block()
    except BlockError as error:
        return Block(fault=str(error))


def code(letter: str, value: float) -> str:
    """G1 of G01."""
    if not 0 <= value < 1e6 or value != int(value):
        raise BlockError(f"{letter}{value:g} is no code: they are whole numbers, like {letter}1")
    return f"{letter}{int(value)}"


def _refuse_twice(words: list[Word]) -> None:
    if len(words) > 1:
        seen = [word.address for word in words if not word.indices]
        if len(set(seen)) < len(seen):
            twice = next(address for address in seen if seen.count(address) > 1)
            raise BlockError(f"{twice} stands twice in one block: remove one")


class _Reader(Parser):
    """Reads the rest of a block."""

    def __init__(self, tokens: list[Token]) -> None:
        super().__init__(tokens)
        self.codes: list[str] = []
        self.words: list[Word] = []
        self.assignments: list[Assignment] = []
        self.calls: list[Call] = []

    def block(self) -> Block:
        """All of it."""
        flow = flow_block(self)
        if flow is not None:
            if self.token.kind != END:
                raise BlockError(f"{self.found()} has no meaning behind {flow.kind}: write it in a block of its own")
            return Block(flow=flow)
        while self.token.kind != END:
            self._element(self.take())
        _refuse_twice(self.words)
        plain = not self.assignments and not self.calls
        plain = plain and all(word.literal >= 0 for word in self.words)
        return Block(tuple(self.codes), tuple(self.words), tuple(self.assignments), tuple(self.calls), plain=plain)

    def _element(self, token: Token) -> None:
        if token.kind == WORD:
            self._word(token)
        elif token.kind == LETTER:
            self._letter(token)
        elif token.kind == NAME:
            self._name(token.text)
        elif token.kind == SYSTEM:
            index = tuple(self.enumerated("]")) if self.passes("[") else ()
            self.need("=")
            self.assignments.append(Assignment(token.text, index, self.expression()))
        elif token.text == "(":
            raise BlockError("a bracket stands alone: comments begin with ; on this control")
        elif token.kind == TEXT:
            raise BlockError(f'the text "{token.text[:20]}" belongs to nothing: write it like MSG("text")')
        else:
            cure = "numbers have a decimal point, like X10.5" if token.text == "," else "write words like X10 or X=R1+5"
            raise BlockError(f"'{token.text[:30]}' has no meaning here: {cure}")

    def _word(self, token: Token) -> None:
        letter, figure = token.text[0], token.text[1:]
        if self.passes("="):
            if letter == "R" and figure.isdigit():
                number = r_number(token.value)
                self.assignments.append(Assignment("R", (constant(number),), self.expression()))
            elif letter in _CODES and figure.isdigit():
                self._ignored_value(f"{letter}{figure}=")
            elif figure.isdigit():
                self._numbered(token.text)
            else:
                raise BlockError(f"'{token.text[:30]}=' names no address: write X=... or X1=...")
        elif letter in _CODES:
            self.codes.append(code(letter, token.value))
        elif letter == "L":
            self.calls.append(Call(token.text))
        elif letter == "R":
            raise BlockError(f"'{token.text[:30]}' does nothing: assign it, like R1=5")
        elif letter == "P" and self.calls:
            self.calls[-1] = self.calls[-1]._replace(times=constant(token.value))
        else:
            place = int(token.value) if token.marked else -1
            self.words.append(Word(letter, place, None if token.marked else constant(token.value)))

    def _letter(self, token: Token) -> None:
        letter = token.text
        if letter == "R" and self.passes("["):
            index = tuple(self.enumerated("]"))
            self.need("=")
            self.assignments.append(Assignment("R", index, self.expression()))
        elif self.passes("["):
            index = tuple(self.enumerated("]"))
            self.need("=")
            self._value(letter, index)
        elif self.passes("="):
            if letter == "M":
                self._ignored_value("M=")
            elif letter == "P" and self.calls:
                self.calls[-1] = self.calls[-1]._replace(times=self.expression())
            else:
                self._value(letter)
        else:
            raise BlockError(f"letter {letter} has no number after it: write one, like {letter}1.5")

    def _name(self, name: str) -> None:
        if self.passes("="):
            if name in ADDRESSES:
                self._value(name)
            else:
                self.assignments.append(Assignment(name, (), self.expression()))
        elif self.passes("["):
            index = tuple(self.enumerated("]"))
            self.need("=")
            if name in ADDRESSES:
                self._value(name, index)
            else:
                self.assignments.append(Assignment(name, index, self.assigned()))
        elif self.passes("("):
            try:
                self.calls.append(Call(name, tuple(self.arguments()), True))
            except BlockError as fault:
                raise BlockError(f"{fault}; brackets hold what {name[:20]} is given, comments begin with ;") from None
        else:
            self.codes.append(name)

    def _numbered(self, address: str) -> None:
        """A3=..., which no variable is called: a constant alone stays one."""
        value, behind = self.tokens[self.at : self.at + 2] if self.token.kind != END else (self.token, self.token)
        if value.kind == NUMBER and value.marked and behind.kind != SIGN:
            self.words.append(Word(address, int(self.take().value)))
        else:
            self._value(address)

    def _value(self, address: str, index: tuple[Compiled, ...] = ()) -> None:
        form = ""
        if self.token.kind == NAME and self.token.text in FORMS:
            form = self.take().text
            self.need("(")
            value = self.expression()
            self.need(")")
        elif address == "PO" and self.passes("("):
            self.words.append(Word(address, -1, constant(0.0), "", index, tuple(self.arguments())))
            return
        else:
            value = self.expression()
        self.words.append(Word(address, -1, value, form, index))

    def _ignored_value(self, address: str) -> None:
        self.words.append(Word(address, -1, self.expression()))

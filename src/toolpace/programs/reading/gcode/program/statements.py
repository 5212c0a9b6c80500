"""Flow statements: Custom Macro B of Fanuc, O-words of LinuxCNC."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.expressions import Node, Parser, Reference

_KINDS = (
    *("SUB", "ENDSUB", "RETURN", "CALL", "WHILE", "ENDWHILE", "DO", "IF", "ELSEIF", "ELSE", "ENDIF"),
    *("REPEAT", "ENDREPEAT", "BREAK", "CONTINUE"),
)
_KIND = "|".join(r"[ \t]*+".join(kind) for kind in _KINDS)
"""O-words, with blanks anywhere: they mean nothing there ("o100 end if")."""
O_WORD = re.compile(rf"O[ \t]*+(<[^<>]{{1,200}}>|[0-9]{{1,9}})[ \t]*+({_KIND})(?![A-Z])")
_COMPUTED = re.compile(r"O[ \t]*+(?=[\[#])")
_UNKNOWN_O = re.compile(r"O[ \t]*+(?:[0-9]++|<[^<>]*+>)[ \t]*+([A-Z]++)")
_CALL = re.compile(r"[ \t]*+C[ \t]*+A[ \t]*+L[ \t]*+L(?![A-Z])")
_CONDITIONS = ("while", "if", "elseif", "repeat")
_WITH_RESULT = ("return", "endsub")
HEADER = re.compile(r"[O:][ \t]*+(?:[0-9]|<|[A-Z])")
_MACRO = re.compile(r"(IF|WHILE|DO|END|GOTO)(?![A-Z])")
_NAMED = re.compile(r"<[A-Z0-9_.+-]{1,60}>")
"""The name of a program, on controls that name them."""
_OUTPUT = re.compile(r"(?:POPEN|PCLOS|DPRNT|BPRNT|SETVN)(?![A-Z])")
_LOOPS = (1, 2, 3)


class Statement(NamedTuple):
    """What a block does to the flow of the program."""

    kind: str
    name: str = ""
    """Of an O-word."""
    value: Node | None = None
    """Condition, label or number of times."""
    arguments: tuple[Node, ...] = ()
    label: Node | None = None
    """Where a condition jumps to."""
    assignments: tuple[tuple[Reference, Node], ...] = ()
    number: Node | None = None
    """Of a subprogram that is called by a number that is reckoned."""


Assignments = Callable[[str], list[tuple[Reference, Node]]]
"""Reads a text of assignments."""


def statement(text: str, parser: Callable[[str, int], Parser], assignments: Assignments) -> Statement | None:
    """The statement that a block is; None where it has words. Raises BlockError."""
    if text[0] in "O:":
        match = O_WORD.match(text)
        if match:
            name = match[1]
            name = "".join(name[1:-1].split()) if name[0] == "<" else str(int(name))
            return _o_word(name, "".join(match[2].split()).lower(), parser(text, match.end()))
        computed = _COMPUTED.match(text)
        if computed:
            return _computed_call(parser(text, computed.end()))
        if HEADER.match(text) and "=" not in text:
            return Statement("header", text[1:].strip())
        raise BlockError("O is followed by neither a number nor a name: write it like O1000")
    if text[0] == "<":
        return Statement("header", text.strip("<> \t")) if _NAMED.fullmatch(text) else None
    match = _MACRO.match(text)
    if match:
        return _macro(match[1], text, parser(text, match.end()), assignments)
    return Statement("output") if _OUTPUT.match(text) else None


def _o_word(name: str, kind: str, parser: Parser) -> Statement:
    values: list[Node] = []
    while parser.symbol == "[":
        values.append(parser.value())
    if kind in _CONDITIONS and len(values) != 1:
        raise BlockError(f"{kind} takes one value in [ ]: write it like o100 {kind} [#1 LT 5]")
    most = len(values) if kind == "call" else 1 if kind in (*_CONDITIONS, *_WITH_RESULT) else 0
    rest = parser.text[parser.at :].strip()
    if rest or len(values) > most:
        raise BlockError(f"'{(rest or '[')[:20]}' has no meaning behind {kind}: write values in [ ], and nothing else")
    if kind == "call":
        return Statement(kind, name, arguments=tuple(values))
    return Statement(kind, name, values[0] if values else None)


def _computed_call(parser: Parser) -> Statement:
    """o[#1*10] call: the only O-word of which the label may be reckoned, since those of a file are found beforehand."""
    number = parser.value()
    match = _CALL.match(parser.text, parser.at)
    if match is None:
        raise BlockError("a label that is reckoned can be called, and nothing else: write a number or a name behind O")
    parser.go_to(match.end())
    return _o_word("", "call", parser)._replace(number=number)


def refuse_unknown_o_word(text: str) -> None:
    """Raise BlockError where a word stands behind an O-number: a misspelt call would be passed over."""
    found = _UNKNOWN_O.match(text)
    if found:
        raise BlockError(f"{found[1][:20]} is no O-word: write sub, call, while, do, if, repeat or one that ends these")


def _macro(kind: str, text: str, parser: Parser, assignments: Assignments) -> Statement:
    if kind == "GOTO":
        return Statement("goto", value=_last(parser))
    if kind == "END" or kind == "DO":
        return Statement(kind.lower(), str(_loop(parser)))
    parser.need("[")
    condition = parser.expression()
    parser.need("]")
    rest = text[parser.at :].lstrip()
    parser.go_to(len(text) - len(rest))
    if kind == "WHILE":
        if not rest.startswith("DO"):
            raise BlockError("DO is missing behind WHILE [ ]: write it like WHILE [#1 LT 5] DO1")
        parser.go_to(parser.at + 2)
        return Statement("while do", str(_loop(parser)), condition)
    if rest.startswith("GOTO"):
        parser.go_to(parser.at + 4)
        return Statement("if goto", value=condition, label=_last(parser))
    if rest.startswith("THEN"):
        return Statement("if then", value=condition, assignments=tuple(assignments(rest[4:].strip())))
    raise BlockError("GOTO or THEN is missing behind IF [ ]: write it like IF [#1 EQ 0] GOTO 100")


def _loop(parser: Parser) -> int:
    number = _last(parser)
    if number not in _LOOPS:
        raise BlockError("DO and END take the numbers 1, 2 and 3: write WHILE [ ] DO1 and END1")
    return int(number)


def _last(parser: Parser) -> Node:
    value = parser.value()
    if parser.text[parser.at :].strip():
        raise BlockError(f"'{parser.text[parser.at :].strip()[:20]}' has no meaning there: write it in another block")
    return value

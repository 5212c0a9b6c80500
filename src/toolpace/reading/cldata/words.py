"""Splits cutter-location data (APT, CLSF) into statements, and says which of them move nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from toolpace.reading.source import Source

_NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)(?:[ED][-+]?[0-9]++)?"
NUMBER = re.compile(_NUMBER)
_MAJOR = re.compile(r"(?:[A-Z0-9_]+\)\s*)?([A-Z][A-Z0-9_-]*(?: PATH)?)\s*(?:/\s*(.*))?", re.DOTALL)
_SEPARATOR = re.compile(r"\s*,\s*|\s+")

STOPS = frozenset(("STOP", "OPSTOP", "SPINDL", "COOLNT", "LOADTL", "LOAD", "TURRET", "TOOLNO", "CLAMP"))
"""Statements for which a controller comes to rest."""
ENDS = frozenset(("FINI",))
PASSED = frozenset(
    (
        "AUTOPS",
        "CLDIST",
        "CLPRNT",
        "CLSF",
        "CUTTER",
        "DISPLY",
        "END",
        "END-OF-PATH",
        "HEAD",
        "INTOL",
        "LEADER",
        "LETTER",
        "LINTOL",
        "LPRINT",
        "MACHIN",
        "MULTAX",
        "NOPOST",
        "OPTION",
        "OUTTOL",
        "PAINT",
        "PARTNO",
        "PPFUN",
        "PPRINT",
        "PREFUN",
        "PRINT",
        "REMARK",
        "SELECT",
        "SEQNO",
        "SET",
        "TITLE",
        "TLDATA",
        "TMARK",
        "TOLER",
        "TOOL PATH",
        "TPRINT",
        "UNIT",
    )
)
"""Statements without meaning for motion: counted."""
FREE_TEXT = frozenset(("PARTNO", "PPRINT", "REMARK", "TITLE", "LETTER", "TPRINT", "PPFUN"))
"""Statements whose text follows without a slash."""
CANCELLED_BY = frozenset(("OFF", "CANCEL", "NOMORE"))
"""Minor words that make a statement of motion end something that never began here, such as CYCLE/OFF."""
CANCELLABLE = frozenset(("CYCLE", "CUTCOM", "TRACUT", "COPY", "TRANS", "ROTATE", "THICK"))


class Statement(NamedTuple):
    """A major word and the words after its slash, in capitals, with the line on which it starts."""

    line: int
    major: str
    minors: list[str]


def statements(source: Source) -> Iterator[Statement]:
    """Statements of a program: `$` goes on in the next line, what follows it is ignored; `$$` begins a comment."""
    pending, first = "", 0
    for line, text in enumerate(source.lines, start=1):
        text = text.upper()
        if "$" in text:
            text = text.partition("$$")[0].rstrip()
            if "$" in text:
                first = first or line
                pending += text.partition("$")[0] + " "
                continue
            if pending and not text.strip():
                # A comment between the parts of a statement does not end it.
                continue
        if pending:
            text, line, pending, first = pending + text, first, "", 0
        text = text.strip()
        if text:
            yield _statement(source, text, line)
    if pending:
        source.fail("the program is cut off: '$' says this statement goes on, but the file ends", first)


def numbers(source: Source, statement: Statement, minors: list[str] | None = None) -> list[float]:
    """The words of a statement as numbers; ProgramError where one is none."""
    words = statement.minors if minors is None else minors
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
        for word in words:
            if not NUMBER.fullmatch(word):
                what = "is empty" if not word else f"'{word[:20]}' is no number"
                source.fail(
                    f"a number of {statement.major} {what}: write numbers like -12.5, between commas",
                    statement.line,
                )
            values.append(float(word.replace("D", "E")))
    for value in values:
        if not -1e9 < value < 1e9:
            source.fail(
                f"number {value:g} of {statement.major} is not finite or beyond 1e9: correct it",
                statement.line,
            )
    return values


def _statement(source: Source, text: str, line: int) -> Statement:
    if text.startswith("GOTO/"):
        return Statement(line, "GOTO", _split(text[5:]))
    for word in FREE_TEXT:
        if text.startswith(word):
            return Statement(line, word, [text[len(word) :]])
    match = _MAJOR.fullmatch(text)
    if match is None:
        source.fail("this is no statement of the form WORD or WORD/...: correct or remove it", line)
    return Statement(line, match[1], _split(match[2] or ""))


def _split(text: str) -> list[str]:
    text = text.strip()
    return _SEPARATOR.split(text) if text else []

"""Tokens of a block: words, names, numbers, texts, signs.

Siemens, NC Programming (12/2019), 2.2 and 2.3: blanks between words are optional, capitals do not matter, a comment
runs from `;` to the end of the line, and round brackets hold arguments, never comments.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError

WORD, LETTER, NAME, SYSTEM, NUMBER, TEXT, SIGN, END = "word", "letter", "name", "$", "number", "text", "sign", "end"
LONGEST = 4096
"""Most characters of a block; the control takes 512."""

MARK = "\x01"
"""Stands for a constant number in the shape of a block."""
FIGURE = r"(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:EX[-+]?[0-9]++)?"
_FIGURE = rf"(?:{FIGURE}|{MARK})"
_TOKEN = re.compile(
    rf"""[ \t]*(?:
      (?P<text>"[^"]*")
    | (?P<system>\$[A-Z_][A-Z0-9_]*)
    | (?P<name>[A-Z_][A-Z_][A-Z0-9_]*)
    | (?P<letter>[A-Z])[ \t]*(?P<value>[-+]?{_FIGURE})?
    | (?P<number>{_FIGURE})
    | '(?P<base>[HB])(?P<digits>[0-9A-F]+)'
    | (?P<sign><<|==|<>|>=|<=|[-+*/=<>()\[\],:])
    )""",
    re.VERBOSE,
)
_COMMENT = re.compile(r'((?:[^;"]|"[^"]*")*+)(?:;.*)?', re.DOTALL)


class Token(NamedTuple):
    """One token of a block."""

    kind: str
    text: str
    """In capitals, but for texts."""
    value: float = 0.0
    """Of words and numbers; of a mark, its place among the constants of the block."""

    @property
    def marked(self) -> bool:
        """Whether its number is a mark."""
        return self.text[-1:] == MARK


LAST = Token(END, "the end of the block")


def without_comment(line: str) -> str:
    """The block without its comment and outer blanks."""
    if ";" not in line:
        return line.strip()
    match = _COMMENT.fullmatch(line)
    # a quote without partner: the comment begins at the first semicolon all the same
    return (match[1] if match else line.split(";", 1)[0]).strip()


def number(text: str) -> float:
    """The value of a figure such as 1.5EX-3; of a mark, zero."""
    if text[-1] == MARK:
        return 0.0
    if "E" not in text and "e" not in text:
        return float(text)
    mantissa, _, exponent = text.upper().partition("EX")
    if not -300 <= int(exponent[:6]) <= 300:
        raise BlockError(f"number {text[:20]} is out of range: correct its exponent")
    return float(f"{mantissa}e{exponent}")


def tokens(block: str) -> list[Token]:
    """Tokens of a block without comment, and one that says that it ends. Raises BlockError."""
    if len(block) > LONGEST:
        raise BlockError(f"the block has {len(block)} characters, at most {LONGEST} are read: split it")
    upper = block.upper()
    if len(upper) != len(block):
        raise BlockError("the block has letters that no control has: write names in plain letters")
    found: list[Token] = []
    marks = 0
    at, end = 0, len(block)
    while at < end:
        match = _TOKEN.match(upper, at)
        if match is None:
            raise BlockError(_reason(block[at:].lstrip()))
        token = _token(match, block)
        if token.marked and token.kind != TEXT:
            token, marks = token._replace(value=float(marks)), marks + 1
        found.append(token)
        at = match.end()
        while at < end and block[at] in " \t":
            at += 1
    found.append(LAST)
    return found


def _token(match: re.Match[str], block: str) -> Token:
    kind = match.lastgroup
    letter = match["letter"]
    if letter:
        value = match["value"]
        return Token(LETTER, letter) if value is None else Token(WORD, letter + value, number(value))
    if kind == "name":
        return Token(NAME, match["name"])
    if kind == "sign":
        return Token(SIGN, match["sign"])
    if kind == "number":
        return Token(NUMBER, match["number"], number(match["number"]))
    if kind == "system":
        return Token(SYSTEM, match["system"])
    if kind == "text":
        return Token(TEXT, block[match.start("text") + 1 : match.end("text") - 1])
    base, digits = match["base"], match["digits"]
    if len(digits) > 64 or (base == "B" and set(digits) - {"0", "1"}):
        raise BlockError(f"'{base}{digits[:20]}' is no number: write 'HFF' or 'B101'")
    return Token(NUMBER, digits, float(int(digits, 16 if base == "H" else 2)))


def _reason(rest: str) -> str:
    if rest.startswith('"'):
        return 'a text has no end: close it with " in its block'
    return f"'{rest[0]}' has no meaning here: remove it, or write it as a comment behind ;"

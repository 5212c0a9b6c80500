"""Splits a block of G-code into letters and numbers."""

from __future__ import annotations

import re

_NUMBER = r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)"
_WORD = re.compile(rf"([A-Z])[ \t]*({_NUMBER})")
_BLOCK = re.compile(rf"[ \t]*(?:[A-Z][ \t]*{_NUMBER}[ \t]*)*+")
_COMMENT = re.compile(r"\([^()]*\)")
_NAME = re.compile(r"[A-Z_][A-Z_]+")


class WordError(ValueError):
    """A block that is no row of letters and numbers; the message says where and what to write."""


def without_comments(line: str) -> str:
    """The block in capitals, without `( )` and `;` comments and outer blanks."""
    if "(" in line or ")" in line or ";" in line:
        semicolon = line.find(";")
        if semicolon >= 0 and "(" not in line[:semicolon]:
            line = line[:semicolon]
        line = _COMMENT.sub(" ", line)
        line = line.split(";", 1)[0]
        if "(" in line or ")" in line:
            raise WordError("a comment's bracket has no partner: close the comment on its line, and do not nest them")
    return line.upper().strip()


def words(block: str) -> list[tuple[str, str]]:
    """Letters and the text of their numbers, in order, of a block in capitals without comments."""
    match = _BLOCK.match(block)
    end = match.end() if match else 0
    if end != len(block):
        raise WordError(_reason(block, block[end:]))
    return _WORD.findall(block)


def _reason(block: str, rest: str) -> str:
    if any(mark in rest for mark in "#[]=<>") or block.startswith("O"):
        return (
            "variables, expressions, subroutines and loops are not read: "
            "export the program with plain numbers and every block written out"
        )
    name = _NAME.match(rest)
    if name and not re.match(r"[A-Z]E[-+]?[0-9]", rest):
        return (
            f"'{name[0][:20]}' is no letter with a number, and might move something: "
            "G-code words are read, like X1.5; conversational and other control languages are not"
        )
    if rest[0].isalpha() and rest[0].isascii():
        return f"letter {rest[0]} has no number after it: write one, like {rest[0]}1.5"
    if rest[0] in "+-.0123456789":
        return f"number '{rest.split()[0][:20]}' has no letter before it: write it like X1.5"
    return f"'{rest[0]}' has no meaning in G-code: remove it, or write it as a comment in ( )"

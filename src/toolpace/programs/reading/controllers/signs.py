"""A program's text without comments, for the search of signs."""

from __future__ import annotations

import re
from collections.abc import Iterable

from toolpace.programs.reading.controllers.plain_motions import PLAIN

_BRACKETS = re.compile(r"[()]")
_BRACKETS_BEHIND_A_BLANK = re.compile(r"(?:^|(?<=[\s\d.]))\([^()]*+\)")


class Text:
    """Lines of a program, in capitals; without plain motions, which most lines are and which tell nothing."""

    def __init__(self, lines: Iterable[str]) -> None:
        self._lines = [line.upper() for line in lines if not PLAIN.fullmatch(line)]
        self.whole = "\n".join(self._lines)
        """With the comments: what a post says of itself stands there."""
        self._without: dict[str, str] = {}

    def of(self, language: str) -> str:
        """Without what is a comment in a language; a semicolon begins one in each of them, or ends the block."""
        if language not in self._without:
            strip = {"word-address": _without_brackets, "sinumerik": _without_free_brackets}.get(language)
            code = (line.partition(";")[0] for line in self._lines)
            self._without[language] = "\n".join(map(strip, code) if strip else code)
        return self._without[language]


def _without_brackets(line: str) -> str:
    """Without what stands in round brackets, nested ones too; one that stays open ends with the line."""
    if "(" not in line:
        return line
    kept, depth, begin = [], 0, 0
    for bracket in _BRACKETS.finditer(line):
        if bracket[0] == "(":
            if depth == 0:
                kept.append(line[begin : bracket.start()])
            depth += 1
        elif depth:
            depth -= 1
            if depth == 0:
                begin = bracket.end()
    if depth == 0:
        kept.append(line[begin:])
    return "".join(kept)


def _without_free_brackets(line: str) -> str:
    """Without what stands in brackets behind a blank or a number.

    To Sinumerik brackets are arguments of the name before them; others are comments of another control.
    """
    return _BRACKETS_BEHIND_A_BLANK.sub("()", line)

"""F in programs of Sinumerik."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from toolpace.controls.export.feeds.word_address import NUMBER, WordAddress

_BEFORE_COMMENT = re.compile(r'(?:[^;"]|"[^"]*")*+')
_TEXT = re.compile(r'"[^"]*"')


@dataclass(frozen=True)
class Sinumerik(WordAddress):
    """Sinumerik: F100, F=R1; brackets hold arguments, and ; alone begins a comment."""

    _NAMED: ClassVar[re.Pattern[str]] = re.compile(
        r"(?<![A-Z0-9_$])(?:CYCLE|MCALL|HOLES|POCKET|SLOT|IF|ELSE|ENDIF|WHILE|FOR|LOOP|REPEAT|UNTIL|CASE|GOTO|CALL|DEF|PROC)",
        re.IGNORECASE,
    )
    _FEED: ClassVar[re.Pattern[str]] = re.compile(
        rf"(?<![A-Z0-9_$])F[ \t]*(?:{NUMBER}(?:EX[-+]?[0-9]+)?|=[ \t]*(?:{NUMBER}|R[0-9]+)(?![ \t]*[-+*/(\[]))",
        re.IGNORECASE,
    )
    _OTHER: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z0-9_$])F[ \t]*=", re.IGNORECASE)

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """All but those of threads, cycles and statements, and those whose F is an expression."""
        codes = [_bare(line) for line in lines]
        return [
            able and self._NAMED.search(code) is None and not self._unknown(code)
            for able, code in zip(super().editable(lines), codes)
        ]

    def _code(self, line: str) -> str:
        return _bare(line)

    def _place(self, code: str) -> tuple[int, int] | None:
        match = self._FEED.search(code)
        return None if match is None else match.span()

    def _unknown(self, code: str) -> bool:
        return self._OTHER.search(code) is not None and self._FEED.search(code) is None


def _bare(line: str) -> str:
    """A line with its comment and its texts blanked out; a ; within a text begins no comment."""
    match = _BEFORE_COMMENT.match(line)
    end = match.end() if match else len(line)
    return _TEXT.sub(lambda text: '"' + "." * (len(text[0]) - 2) + '"', line[:end]) + " " * (len(line) - end)

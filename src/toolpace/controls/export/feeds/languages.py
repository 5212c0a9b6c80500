"""Feed words in cutter-location data, Klartext and Sinumerik programs, and the table of all languages."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from toolpace.controls.export.feeds.word_address import NUMBER, WordAddress
from toolpace.controls.export.feeds.words import FeedWords

_BEFORE_COMMENT = re.compile(r'(?:[^;"]|"[^"]*")*+')
_TEXT = re.compile(r'"[^"]*"')


@dataclass(frozen=True)
class Cldata:
    """APT and CLSF: FEDRAT stands before the motion, in a statement of its own."""

    inverse: ClassVar[bool] = False
    decimals: ClassVar[int] = 4
    _MOTION: ClassVar[re.Pattern[str]] = re.compile(r"^\s*GOTO\s*/", re.IGNORECASE)
    _FEED: ClassVar[re.Pattern[str]] = re.compile(r"^\s*FEDRAT\s*/", re.IGNORECASE)

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """GOTO, but in drilling cycles, whose feed stands in CYCLE."""
        found, cycle = [], False
        for line in lines:
            words = line.upper().replace(" ", "")
            if words.startswith("CYCLE/"):
                cycle = not words.startswith("CYCLE/OFF") and not words.startswith("CYCLE/NOMORE")
            found.append(not cycle and self._MOTION.match(line) is not None)
        return found

    def feed_in(self, line: str) -> str:
        """The whole statement."""
        return line.strip() if self._FEED.match(line) and "$" not in line else ""

    def with_feed(self, line: str, feed: str, inverse: bool) -> list[str]:
        """FEDRAT before the line, which stays as it is."""
        return [f"FEDRAT/{feed},MMPM", line]

    def mode_in(self, line: str) -> str:
        """Empty: there is no such word."""
        return ""

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """The statement again."""
        return feed


@dataclass(frozen=True)
class Klartext:
    """Heidenhain: F1234 behind the coordinates and before M; FMAX is a rapid, F behind M128 belongs to M128."""

    inverse: ClassVar[bool] = False
    decimals: ClassVar[int] = 3
    _PATHS: ClassVar[re.Pattern[str]] = re.compile(
        r"^[ \t/]*(?:[0-9]+[ \t]+)?[ \t/]*(?:LN|LP|L|CTP|CT|CR|CP|C|RND|CHF|APPR[ \t]+[A-Z]+|DEP[ \t]+[A-Z]+)(?=[ \t])",
        re.IGNORECASE,
    )
    _FEED: ClassVar[re.Pattern[str]] = re.compile(
        r"(?<![A-Z0-9])F[ \t]*(?:AUTO|[UZ]?[ \t]*(?:[-+]?(?:[0-9]++[.,]?[0-9]*+|[.,][0-9]++|Q[LRS]?[0-9]++)))",
        re.IGNORECASE,
    )
    _FUNCTION: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z0-9])M[ \t]*[0-9Q]", re.IGNORECASE)

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """Blocks of the contour."""
        return [self._PATHS.match(line) is not None and "~" not in line for line in lines]

    def feed_in(self, line: str) -> str:
        """F with its value."""
        at = self._FEED.search(line, 0, self._words_end(line))
        return at[0] if at and self._PATHS.match(line) else ""

    def with_feed(self, line: str, feed: str, inverse: bool) -> list[str]:
        """F replaced, or added before the first M."""
        end = self._words_end(line)
        at = self._FEED.search(line, 0, end)
        if at:
            return [line[: at.start()] + f"F{feed}" + line[at.end() :]]
        head = line[:end].rstrip()
        return [f"{head} F{feed}{line[len(head) : end]}{line[end:]}"]

    def mode_in(self, line: str) -> str:
        """Empty: there is no such word."""
        return ""

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """A line without coordinates."""
        return f"L {feed}"

    def _words_end(self, line: str) -> int:
        """Where the first M or the comment begins."""
        code = line.split(";", 1)[0]
        match = self._FUNCTION.search(code)
        return match.start() if match else len(code)


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


LANGUAGES: dict[str, FeedWords] = {
    "word-address": WordAddress(),
    "sinumerik": Sinumerik(),
    "heidenhain": Klartext(),
    "cldata": Cldata(),
}
"""Language of a controller, or `cldata`, to its words."""

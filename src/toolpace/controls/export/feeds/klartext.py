"""F in programs of Heidenhain (Klartext)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar


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

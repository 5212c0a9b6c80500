"""The feed of cutter-location data: FEDRAT, a statement of its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar


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

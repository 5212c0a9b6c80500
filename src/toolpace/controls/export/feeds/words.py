"""The interface to feed words of one language: find, replace, add."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Protocol


class FeedWords(Protocol):
    """The words of one language."""

    inverse: ClassVar[bool]
    """Whether it has inverse times (G93)."""
    decimals: ClassVar[int]
    """Most decimals of an F."""

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """Which lines can bear an F of their own for one motion."""

    def feed_in(self, line: str) -> str:
        """The F of a line as it is written; empty where it has none."""

    def mode_in(self, line: str) -> str:
        """The word of a line that tells what F means (G93, G94, G95); empty where it has none."""

    def with_feed(self, line: str, feed: str, inverse: bool) -> list[str]:
        """The line with another F, or with one added; lines that must stand before it come first."""

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """A line that sets an F again that was found before, behind blocks that had F of their own."""

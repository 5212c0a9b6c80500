"""What may stand between the motions of a program and the moves, such as cutter compensation."""

from __future__ import annotations

from typing import Protocol

from toolpace.reading.control.moves import Rate
from toolpace.reading.curves.arcs import Arc


class Stage(Protocol):
    """Lays other ways in place of those that the program tells."""

    compensates: bool
    """Whether the program's contour is being followed beside it; else the way back to it is still to come."""

    @property
    def kept(self) -> list[float]:
        """Words (3 + rotary) that axes keep which a motion in machine coordinates does not name."""

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary)."""

    def redirect(self, end: list[float]) -> None:
        """The last motion of the program, which was straight, ends earlier."""

    def other_motion(self, what: str) -> None:
        """A motion that is no line and no arc of a contour comes next, or coordinates change."""

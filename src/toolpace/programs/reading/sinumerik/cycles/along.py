"""Motions along one hole, the parts of drilling cycles."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.sinumerik.state import State


@dataclass(frozen=True)
class Levels:
    """The first five arguments of every cycle of holes: RTP, RFP, SDIS, DP, DPR [m]."""

    back: float
    reference: float
    top: float
    """Reference plane and safety distance: the rapid ends here."""
    bottom: float


class Along:
    """The hole under the tool, with the levels of its cycle."""

    def __init__(self, control: Control, state: State, axis: int, levels: Levels) -> None:
        self.control, self.state, self.axis, self.levels = control, state, axis, levels

    def over(self) -> None:
        """Rapid to the safety distance."""
        self.rapid(self.levels.top)

    def rapid(self, level: float) -> None:
        """Rapid to a level."""
        self.control.straight(self._at(level), 1 << self.axis, rapid=True)

    def feed(self, level: float, speed: float = 0.0) -> None:
        """Go to a level at a speed [m/s]; at the feed of the program where it is zero."""
        if speed == 0.0:
            number = self.state.inverse if self.control.feed.mode == INVERSE else None
            self.control.straight(self._at(level), 1 << self.axis, rapid=False, number=number)
        else:
            with self.control.feed.held(speed):
                self.control.straight(self._at(level), 1 << self.axis, rapid=False)

    def pause(self, seconds: float) -> None:
        """Wait, where there is anything to wait."""
        if seconds:
            self.control.dwell(seconds)

    def _at(self, level: float) -> list[float]:
        words = list(self.control.words)
        words[self.axis] = level
        return words

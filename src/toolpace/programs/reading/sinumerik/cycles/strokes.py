"""The strokes of drilling cycles along one hole, and the depths at which those of CYCLE83 end."""

from __future__ import annotations

from dataclasses import dataclass

from toolpace.common.units import MILLIMETRE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import MOST_PECKS
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import ValueFault

TOO_MANY = "CYCLE83 takes more than 10000 strokes, or none: check its depths"


SLACK = 1e-9
"""Share of a stroke that rounding may add to a depth, or take from it."""


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


def strokes_of(whole: float, first: float, less: float) -> list[float]:
    """Depths [m] at which the strokes of CYCLE83 end: each is shorter by `less`, down to that; the last two are equal.

    Where `less` is zero all strokes but the last are as long as the first. The last two are cut alike where what is
    left is no longer than twice `less`: each is then longer than half of it.
    """
    found: list[float] = []
    depth, stroke = 0.0, min(first, whole)
    if stroke <= 0.0 or whole / max(min(stroke, less or stroke), 1e-12) > MOST_PECKS:
        raise ValueFault(TOO_MANY)
    while _longer(whole - depth, stroke):
        depth += stroke
        found.append(depth)
        if less:
            stroke = max(stroke - less, less)
            rest = whole - depth
            if _longer(rest, stroke) and not _longer(rest, 2.0 * less):
                stroke = rest / 2.0
    return [*found, whole]


def strokes_by_factor(whole: float, first: float, factor: float, least: float) -> list[float]:
    """Depths [m] at which the strokes of CYCLE83 end where each is `factor` times the last one, but at least `least`.

    Where a stroke would be shorter than `least`, what is left is drilled in strokes of that length.
    """
    found: list[float] = []
    depth, stroke = 0.0, min(first, whole)
    if stroke <= 0.0:
        raise ValueFault(TOO_MANY)
    while _longer(whole - depth, stroke):
        depth += stroke
        found.append(depth)
        stroke = max(stroke * factor, min(least, first))
        if len(found) >= MOST_PECKS:
            raise ValueFault(f"{TOO_MANY}, or write the least stroke, its argument 14 (_MDEP)")
    return [*found, whole]


def _longer(length: float, other: float) -> bool:
    """Whether a length is longer than another one, rounding aside."""
    return length > other * (1.0 + SLACK)


def stop_distance(whole: float) -> float:
    """How far above the last depth the rapid ends: 0.6 mm to 30 mm of depth, then a fiftieth, at most 7 mm."""
    return 0.6 * MILLIMETRE if whole <= 30.0 * MILLIMETRE else min(whole / 50.0, 7.0 * MILLIMETRE)

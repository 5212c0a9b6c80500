"""The active feed: mode, F, and the feed of a motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from toolpace.common.errors import FeedMissingError
from toolpace.common.units import DEGREE, MILLIMETRE, MINUTE
from toolpace.programs.reading.control.moves import Rate
from toolpace.programs.reading.feeds import feed_fault
from toolpace.programs.reading.source import Source

SENSES = {"M3": 1, "M4": -1, "M5": 0, "M13": 1, "M14": -1}
"""M functions by which the spindle turns: clockwise seen from it, counterclockwise, not at all."""
PER_MINUTE, INVERSE, PER_REVOLUTION, PER_TOOTH = "per minute", "inverse time", "per revolution", "per tooth"
"""Modes of feed: lengths a minute, the time of each block, lengths a turn of the spindle, or a tooth of the tool."""
TURNING = ("xyz", "vector")
"""What F divides in a block that turns outside tip mode: the way of X, Y, Z, or of lengths (in its unit) and degrees
as one."""


class FeedRules(NamedTuple):
    """What differs from controller to controller."""

    turning: str = "xyz"
    inverse_seconds: bool = False
    """Whether F under inverse time is the seconds of the block, not how many such blocks take a minute."""
    kept: bool = False
    """Whether F stays in force when the mode of feed changes."""
    forgotten: bool = False
    """Whether F is forgotten at each word of a mode, that in force too."""


class Feed:
    """Mode, F and spindle speed as they stand at a point of the program."""

    def __init__(self, source: Source, rules: FeedRules, default: float | None) -> None:
        self.source, self.rules, self.default = source, rules, default
        self.mode = PER_MINUTE
        self.value: float | None = None
        """F [m/s], or [m] a revolution or a tooth; in inverse time it is not remembered."""
        self.turn = 0.0
        """The same F as degrees a minute [rad/s]."""
        self.unit = MILLIMETRE
        """Of lengths when F was given [m]."""
        self.spindle = 0.0
        """Turns of the spindle a second."""
        self.teeth: int | None = None
        """Of the tool in the spindle, where that is known."""

    def set_mode(self, mode: str) -> None:
        """An F of one mode says nothing in another."""
        if (mode != self.mode and not self.rules.kept) or self.rules.forgotten:
            self.value = None
        self.mode = mode

    def set(self, number: float, unit: float, line: int) -> None:
        """Remember F in units [m] and degrees, a minute, a revolution or a tooth."""
        if not 0 < number <= 1e9:
            self.source.fail(f"feed F{number:g} must be above zero (and at most 1e9): correct F", line)
        self.unit = unit
        if self.mode in (PER_REVOLUTION, PER_TOOTH):
            self.value, self.turn = number * unit, number * DEGREE
        elif self.mode == PER_MINUTE:
            self.value, self.turn = number * unit / MINUTE, number * DEGREE / MINUTE
            fault = feed_fault(self.value)
            if fault and number > 1.0:
                self.source.fail(fault, line)

    @contextmanager
    def held(self, speed: float, turn: float = math.inf) -> Iterator[None]:
        """For some motions a speed [m/s] and a rotation in place [rad/s] of their own; then what was in force."""
        before = self.mode, self.value, self.turn
        self.mode, self.value, self.turn = PER_MINUTE, speed, turn
        try:
            yield
        finally:
            self.mode, self.value, self.turn = before

    def rate(self, number: float | None, line: int, length: float = 0.0, turned: float = 0.0) -> Rate:
        """Rate of a motion at feed whose block has F `number` in inverse time, or none.

        `length` [m] and `turned` [rad]: its way in X, Y, Z and in the rotary joints, outside tip mode; else zero.
        """
        if self.mode == INVERSE:
            if number is not None:
                return Rate(time=number if self.rules.inverse_seconds else MINUTE / number)
            if self.default is None:
                needs = "feed missing: under G93 every G1, G2, G3 needs its own F [1/min], or give --feed 3000mm/min"
                self.source.fail(needs, line, FeedMissingError)
        elif self.value is not None:
            speed, turn = self.value, self.turn
            if self.mode in (PER_REVOLUTION, PER_TOOTH):
                times = self._times_a_second(line)
                speed, turn = speed * times, turn * times
            if self.rules.turning == "vector" and length > 0.0 and turned > 0.0:
                way = math.hypot(length / self.unit, turned / DEGREE)
                return Rate(time=way * self.unit / speed)
            return Rate(speed, turn)
        if self.default is None:
            self.source.fail(
                "feed missing: no F above zero before this motion; write one, or give --feed 3000mm/min"
                " (feed= in Python)",
                line,
                FeedMissingError,
            )
        # Of rotations in place a length per minute says nothing: the axes' own limits rule them.
        return Rate(self.default)

    def _times_a_second(self, line: int) -> float:
        """How many turns, or teeth, a second the feed is for."""
        what = "tooth" if self.mode == PER_TOOTH else "revolution"
        if self.spindle <= 0.0:
            self.source.fail(f"a feed per {what} needs the spindle speed: write S before it, or a feed a minute", line)
        if self.mode == PER_REVOLUTION:
            return self.spindle
        if self.teeth is None:
            self.source.fail(
                "a feed per tooth needs the number of teeth: write teeth in the tool's table of the set-up sheet", line
            )
        return self.spindle * self.teeth

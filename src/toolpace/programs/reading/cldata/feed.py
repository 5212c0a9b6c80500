"""Feeds of cutter-location data: FEDRAT, and feeds per revolution."""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.common.errors import FeedMissingError
from toolpace.common.units import INCH, MILLIMETRE, MINUTE
from toolpace.programs.reading.cldata.words import NUMBER, Statement, figure
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

FOOT = 12 * INCH
PER_MINUTE = {"MMPM": MILLIMETRE, "IPM": INCH, "MPM": 1.0, "FPM": FOOT, "PERMIN": None, "UPM": None}
PER_REVOLUTION = {"MMPR": MILLIMETRE, "IPR": INCH, "FPR": FOOT, "PERREV": None, "UPR": None}
"""Length units of the forms of FEDRAT; None stands for the unit of the program."""
LONGEST_DELAY = 86400.0
"""A day [s]: a longer delay is a slip of units."""
_TURNING = frozenset(
    ("RPM", "CLW", "CCLW", "FWD", "REV", "ON", "OFF", "RANGE", "LOW", "MEDIUM", "HIGH", "AUTO", "MAXRPM")
)
_INVERSE = ("INVERS", "AUTO", "ON", "OFF")


class Feed(NamedTuple):
    """A feed as it was written; `ClFeed.caps` makes a speed of it."""

    value: float
    """[m/s], [m] a revolution, or motions a second."""
    kind: str
    """`time`, `revolution` or `inverse`."""


class Caps(NamedTuple):
    """What bounds a motion."""

    speed: float
    """Most speed of the tip [m/s]."""
    least_time: float = 0.0
    """[s]"""


class ClFeed:
    """FEDRAT and SPINDL as they stand at a point of the program."""

    def __init__(self, source: Source, default: float | None, findings: Findings) -> None:
        self.source, self.findings = source, findings
        self.feed: Feed | None = None if default is None else Feed(default, "time")
        self.revolutions: float | None = None
        """Spindle speed [1/s]."""

    def set(self, statement: Statement, unit: float) -> None:
        """FEDRAT/250 FEDRAT/MMPM,250 FEDRAT/250,MMPM, with IPM, PERMIN, MMPR, IPR, PERREV, and INVERS as well.

        With INVERS,AUTO the post-processor works the inverse times out of the feed: the feed is what holds.
        """
        value, form, inverse = None, "", False
        for word in statement.minors:
            if word in PER_MINUTE or word in PER_REVOLUTION:
                form = word
            elif NUMBER.fullmatch(word) and value is None:
                value = figure(word)
            elif word in _INVERSE:
                inverse = True
            else:
                known = ", ".join((*PER_MINUTE, *PER_REVOLUTION))
                cure = f"give one number and one of {known}"
                self.findings.refused(f"FEDRAT/{word[:20]}", statement.line, cure)
                # What is refused is told at the end, and no motion before it shall be told to have no feed.
                self.feed = self.feed or Feed(math.inf, "time")
        if value is None and inverse:
            return
        if value is None:
            self.source.fail("FEDRAT has no number: write it like FEDRAT/MMPM,250", statement.line)
        explicit = inverse and not form and "AUTO" not in statement.minors and "OFF" not in statement.minors
        if not form and not explicit:
            self.findings.assumed("FEDRAT without a unit is taken a minute")
        self.feed = self.of(value, "INVERS" if explicit else form, unit, statement)

    def of(self, value: float, form: str, unit: float, statement: Statement) -> Feed:
        """The feed of a number and a word such as MMPM; no word: a minute, in the unit of the program."""
        if not 0 < value <= 1e9:
            word = statement.major
            self.source.fail(f"feed {value:g} must be above zero (and at most 1e9): correct {word}", statement.line)
        if form in ("FPM", "FPR"):
            self.findings.assumed(f"{form} is taken for feet {'a minute' if form == 'FPM' else 'a revolution'}")
        if form == "INVERS":
            self.findings.assumed("FEDRAT/INVERS with a number is taken for motions a minute: each takes its inverse")
            return Feed(value / MINUTE, "inverse")
        if form in PER_REVOLUTION:
            return Feed(value * (PER_REVOLUTION[form] or unit), "revolution")
        return Feed(value * (PER_MINUTE.get(form) or unit) / MINUTE, "time")

    def spindle(self, statement: Statement) -> None:
        """SPINDL/2000,RPM,CLW and its like: the one number is the speed where the words are of turning."""
        if statement.major != "SPINDL":
            return
        figures = [word for word in statement.minors if NUMBER.fullmatch(word)]
        others = [word for word in statement.minors if not NUMBER.fullmatch(word)]
        if len(figures) == 1 and _TURNING.issuperset(others):
            speed = figure(figures[0])
            self.revolutions = speed / MINUTE if 0 < speed < 1e9 else None
        elif figures:
            # A speed of the surface, SFM or SMM: the revolutions follow from a diameter that is not told.
            self.revolutions = None

    def caps(self, line: int, feed: Feed | None = None) -> Caps:
        """What bounds a motion that is no rapid: `feed`, else FEDRAT."""
        feed = feed or self.feed
        if feed is None:
            self.source.fail(
                "feed missing: no FEDRAT before this motion; write one, or give --feed 3000mm/min (feed= in Python)",
                line,
                FeedMissingError,
            )
        if feed.kind == "inverse":
            return Caps(math.inf, 1.0 / feed.value)
        if feed.kind == "revolution":
            return Caps(feed.value * self._turning("FEDRAT per revolution", line))
        return Caps(feed.value)

    def delay(self, statement: Statement) -> float:
        """Seconds of DELAY/2 or DELAY/5,REV."""
        words = [word for word in statement.minors if word != "REV"]
        if len(words) != 1 or not NUMBER.fullmatch(words[0]):
            self.source.fail("DELAY takes one number, its seconds: write it like DELAY/0.5", statement.line)
        return self.seconds(figure(words[0]), "REV" in statement.minors, "DELAY", statement.line)

    def seconds(self, value: float, revolutions: bool, word: str, line: int) -> float:
        """Time [s] of a wait that is written in seconds or in revolutions."""
        time = value / self._turning(f"{word} in revolutions", line) if revolutions else value
        if not 0 <= time <= LONGEST_DELAY:
            self.source.fail(f"{word} waits {time:g} s, not between 0 and a day: its number is seconds", line)
        return time

    def _turning(self, what: str, line: int) -> float:
        if self.revolutions is None:
            self.source.fail(f"{what} needs the spindle speed: write SPINDL/2000,RPM before it, or per minute", line)
        return self.revolutions

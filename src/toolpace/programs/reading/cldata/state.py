"""Units, coordinate system, feed and spindle speed in force in cutter-location data."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from toolpace.common.errors import FeedMissingError
from toolpace.common.units import INCH, MILLIMETRE, MINUTE
from toolpace.programs.reading.cldata.words import CANCELLED_BY, FRAMES, NUMBER, Statement, cure, figure, numbers
from toolpace.programs.reading.feeds import LONGEST_DWELL
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

UNITS = {"MM": MILLIMETRE, "INCHES": INCH, "INCH": INCH, "IN": INCH, "CM": 1e-2, "M": 1.0}
SYSTEMS = frozenset(("MSYS", "CAMERA", "->CSYS"))
"""Statements that say where the system of the points lies: the same one says nothing, another one moves them."""
_UNIT = re.compile(r"^[ \t]*+UNITS?[ \t]*+/", re.IGNORECASE | re.MULTILINE)
_FEED_UNIT = re.compile(r"^[ \t]*+(?:FEDRAT|CYCLE)[^\n$]*?\b(MMPM|MMPR|IPM|IPR)\b", re.IGNORECASE | re.MULTILINE)
_ROW = 4
"""Numbers in a row of a matrix of CATIA and of TRACUT."""
_IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
FOOT = 12 * INCH
PER_MINUTE = {"MMPM": MILLIMETRE, "IPM": INCH, "MPM": 1.0, "FPM": FOOT, "PERMIN": None, "UPM": None}
PER_REVOLUTION = {"MMPR": MILLIMETRE, "IPR": INCH, "FPR": FOOT, "PERREV": None, "UPR": None}
"""Length units of the forms of FEDRAT; None stands for the unit of the program."""
SENSES = {"CLW": 1, "FWD": 1, "CCLW": -1, "REV": -1, "OFF": 0, "ON": 1}
_TURNING = frozenset(
    ("RPM", "CLW", "CCLW", "FWD", "REV", "ON", "OFF", "RANGE", "LOW", "MEDIUM", "HIGH", "AUTO", "MAXRPM")
)
_INVERSE = ("INVERS", "AUTO", "ON", "OFF")


class ClFrame:
    """The unit and the coordinate system as they stand at a point of the program."""

    def __init__(self, source: Source, findings: Findings, follow: bool = False) -> None:
        self.source, self.findings, self.follow = source, findings, follow
        self.unit = self._unit_unsaid("\n".join(source.lines))
        self._systems: dict[str, tuple[float, ...]] = {}
        self._rows: list[float] | None = None
        """Numbers of CATIA's matrix that were read; None outside one."""
        self.centre_line = False
        """Whether the program says that its points are of the tool's centre line, so that CUTCOM has no offset."""

    def units(self, statement: Statement) -> None:
        """UNITS/MM and its like."""
        name = statement.minors[0] if statement.minors else ""
        if name not in UNITS:
            self.source.fail(f"UNITS/{name[:20]} is not known: use UNITS/MM or UNITS/INCHES", statement.line)
        self.unit = UNITS[name]

    def system(self, statement: Statement, moved: bool) -> None:
        """MSYS, CSYS: counted; a change after points (`moved`) would shift them against each other, and is refused."""
        word = statement.major.removeprefix("->")
        self.findings.ignored(word)
        self._compare(word, tuple(numbers(self.source, statement)), statement.line, moved)

    def note(self, statement: Statement, moved: bool) -> None:
        """What comments hold: `centerline data` (NX), and the matrix of a system after `*CATIA0` and its name."""
        text = statement.text.lower()
        if self._rows is not None:
            words = statement.text.split()
            if len(words) == _ROW and all(NUMBER.fullmatch(word.upper()) for word in words):
                self._rows += [figure(word.upper()) for word in words]
                if len(self._rows) == len(_IDENTITY):
                    self._compare("$$*CATIA0", tuple(self._rows), statement.line, moved)
                    self._rows = None
            elif self._rows:
                self._rows = None
        if text.startswith("*catia0"):
            self._rows = []
        elif text == "centerline data":
            self.centre_line = True

    def shift(self, statement: Statement) -> None:
        """TRACUT, TRANS, ROTATE and their like: counted where they say nothing, else refused."""
        word = statement.major
        figures = [figure(minor) for minor in statement.minors if NUMBER.fullmatch(minor)]
        nothing = figures != [] and not any(figures)
        cancelled = statement.minors[:1] != [] and statement.minors[0] in CANCELLED_BY
        if cancelled or (word in FRAMES and (nothing or tuple(figures) == _IDENTITY)):
            self.findings.ignored(word)
        else:
            self.findings.refused(word, statement.line, cure(word))

    def geometry(self, statement: Statement) -> None:
        """`$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_CENTER` of Creo."""
        self.centre_line = "OUTPUT_ON_CENTER" in statement.minors

    def cutcom(self, statement: Statement) -> None:
        """CUTCOM: no offset where the points are of the centre line (--compensation program says so), else refused."""
        if self.follow or self.centre_line or (statement.minors[:1] != [] and statement.minors[0] in CANCELLED_BY):
            self.findings.ignored("CUTCOM")
            if self.centre_line:
                self.findings.assumed("CUTCOM offsets nothing: the points are of the tool's centre line")
        else:
            self.findings.refused("CUTCOM", statement.line, cure("CUTCOM"))

    def _compare(self, word: str, values: tuple[float, ...], line: int, moved: bool) -> None:
        before = self._systems.setdefault(word, values)
        same = len(before) == len(values) and all(math.isclose(a, b, abs_tol=1e-9) for a, b in zip(before, values))
        if not same and moved:
            self.findings.refused(word, line, cure("MSYS"))
        self._systems[word] = values

    def _unit_unsaid(self, text: str) -> float:
        """The unit of lengths until UNITS says it; without UNITS that of the feeds."""
        if _UNIT.search(text):
            return MILLIMETRE
        feed = _FEED_UNIT.search(text)
        inches = feed is not None and feed[1].upper() in ("IPM", "IPR")
        reason = f", the unit of its feeds ({feed[1].upper()})" if feed else ""
        self.findings.assumed(f"without UNITS lengths are taken in {'inches' if inches else 'millimetres'}{reason}")
        return INCH if inches else MILLIMETRE


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
        self.sense = 1
        """Of the spindle: 1 clockwise (CLW), -1 counterclockwise (CCLW), 0 where it stands (OFF)."""

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
                allowed = ", ".join((*PER_MINUTE, *PER_REVOLUTION))
                self.findings.refused(f"FEDRAT/{word[:20]}", statement.line, f"give one number and one of {allowed}")
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
        for word in statement.minors:
            self.sense = SENSES.get(word, self.sense)
        figures = [word for word in statement.minors if NUMBER.fullmatch(word)]
        if figures and "OFF" not in statement.minors:
            self.sense = self.sense or 1
        others = [word for word in statement.minors if not NUMBER.fullmatch(word)]
        if len(figures) == 1 and _TURNING.issuperset(others):
            speed = figure(figures[0])
            self.revolutions = speed / MINUTE if 0 < speed < 1e9 else None
        elif figures:
            # A speed of the surface, SFM or SMM: the revolutions follow from a diameter that is not told.
            self.revolutions = None

    @property
    def signed_revolutions(self) -> float:
        """Turns of the spindle per second [1/s], above zero clockwise; nan where nothing tells them."""
        if self.sense == 0:
            return 0.0
        return math.nan if self.revolutions is None else self.sense * self.revolutions

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
        if not 0 <= time <= LONGEST_DWELL:
            self.source.fail(f"{word} waits {time:g} s, not between 0 and a day: its number is seconds", line)
        return time

    def _turning(self, what: str, line: int) -> float:
        if self.revolutions is None:
            self.source.fail(f"{what} needs the spindle speed: write SPINDL/2000,RPM before it, or per minute", line)
        return self.revolutions

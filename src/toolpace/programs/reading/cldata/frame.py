"""The unit and coordinate system of cutter-location data."""

from __future__ import annotations

import math
import re

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.cldata.meanings import CANCELLED_BY, FRAMES, cure
from toolpace.programs.reading.cldata.words import NUMBER, Statement, figure, numbers
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
        known = self._systems.setdefault(word, values)
        same = len(known) == len(values) and all(math.isclose(a, b, abs_tol=1e-9) for a, b in zip(known, values))
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

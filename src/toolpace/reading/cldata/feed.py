"""The feed of cutter-location data: FEDRAT in its forms, and the spindle speed for feeds per revolution."""

from __future__ import annotations

from toolpace.reading.cldata.words import NUMBER, Statement
from toolpace.reading.source import Source
from toolpace.units import INCH, MILLIMETRE, MINUTE

PER_MINUTE = {"MMPM": MILLIMETRE, "IPM": INCH, "MPM": 1.0, "PERMIN": None, "UPM": None}
PER_REVOLUTION = {"MMPR": MILLIMETRE, "IPR": INCH, "PERREV": None, "UPR": None}
"""Length units of the forms of FEDRAT; None stands for the unit of the program."""
_TURNING = frozenset(("RPM", "CLW", "CCLW", "ON", "OFF", "RANGE", "LOW", "MEDIUM", "HIGH", "AUTO", "MAXRPM"))


class ClFeed:
    """FEDRAT and SPINDL as they stand at a point of the program."""

    def __init__(self, source: Source, default: float | None) -> None:
        self.source, self.default = source, default
        self.value: float | None = None
        """[m/s], or [m] a revolution."""
        self.per_revolution = False
        self.revolutions: float | None = None
        """Spindle speed [1/s]."""

    def set(self, statement: Statement, unit: float) -> None:
        """FEDRAT/250 FEDRAT/MMPM,250 FEDRAT/250,MMPM, with IPM, PERMIN, MMPR, IPR, PERREV as well."""
        value, length, self.per_revolution = None, unit, False
        for word in statement.minors:
            if word in PER_MINUTE:
                length = PER_MINUTE[word] or unit
            elif word in PER_REVOLUTION:
                length, self.per_revolution = PER_REVOLUTION[word] or unit, True
            elif NUMBER.fullmatch(word) and value is None:
                value = float(word.replace("D", "E"))
            else:
                known = ", ".join((*PER_MINUTE, *PER_REVOLUTION))
                self.source.fail(
                    f"'{word[:20]}' in FEDRAT is not read: give one number and one of {known}", statement.line
                )
        if value is None:
            self.source.fail("FEDRAT has no number: write it like FEDRAT/MMPM,250", statement.line)
        if not 0 < value <= 1e9:
            self.source.fail(f"feed {value:g} must be above zero (and at most 1e9): correct FEDRAT", statement.line)
        self.value = value * length if self.per_revolution else value * length / MINUTE

    def spindle(self, statement: Statement) -> None:
        """SPINDL/2000,RPM,CLW and its like: the one number is the speed where the words are of turning."""
        if statement.major != "SPINDL":
            return
        figures = [word for word in statement.minors if NUMBER.fullmatch(word)]
        others = [word for word in statement.minors if not NUMBER.fullmatch(word)]
        if len(figures) == 1 and _TURNING.issuperset(others):
            speed = float(figures[0].replace("D", "E"))
            self.revolutions = speed / MINUTE if 0 < speed < 1e9 else None

    def speed(self, line: int) -> float:
        """Speed of the tip [m/s] on a motion that is no rapid."""
        if self.value is None:
            if self.default is None:
                self.source.fail(
                    "feed missing: no FEDRAT before this motion; write one, or give --feed 3000mm/min "
                    "(feed= in Python)",
                    line,
                )
            return self.default
        if not self.per_revolution:
            return self.value
        return self.value * self._turning("FEDRAT per revolution", line)

    def delay(self, statement: Statement) -> float:
        """Seconds of DELAY/2 or DELAY/5,REV."""
        words = [word for word in statement.minors if word != "REV"]
        if len(words) != 1 or not NUMBER.fullmatch(words[0]):
            self.source.fail("DELAY takes one number, its seconds: write it like DELAY/0.5", statement.line)
        time = float(words[0].replace("D", "E"))
        return time / self._turning("DELAY in revolutions", statement.line) if "REV" in statement.minors else time

    def _turning(self, what: str, line: int) -> float:
        if self.revolutions is None:
            self.source.fail(f"{what} needs the spindle speed: write SPINDL/2000,RPM before it, or per minute", line)
        return self.revolutions

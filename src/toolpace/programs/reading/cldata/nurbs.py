"""The NURBS record of NX."""

from __future__ import annotations

import numpy as np

from toolpace.programs.reading.cldata.words import Statement, numbers
from toolpace.programs.reading.curves.splines import Spline, SplineError
from toolpace.programs.reading.source import Source

PARTS = frozenset(("KNOT", "CNTRL", "WEIGHT"))


class NurbsRecord:
    """NURBS/, KNOT/.., CNTRL/.. of NX: cubic, without weights, from the present point on.

    The present point is the first control point. The curve begins with the knot 0 four times; of the knots that are
    written the last is 1 and stands for four: count(CNTRL) = count(KNOT) + 2 (measured on CLSF files of NX).
    """

    def __init__(self, source: Source, line: int, *, refused: bool = False) -> None:
        self.source, self.line, self.refused = source, line, refused
        self.last = line
        """Line of its last statement."""
        self._knots: list[float] = []
        self._points: list[list[float]] = []

    def add(self, statement: Statement, unit: float) -> bool:
        """Take a KNOT or CNTRL; false where it says what is not read: axes, weights."""
        self.last = statement.line
        if self.refused:
            return True
        values = numbers(self.source, statement)
        if statement.major == "KNOT":
            self._knots += values
            return True
        if statement.major != "CNTRL" or len(values) != 3:
            self.refused = True
            return False
        if max(map(abs, values)) * unit > 1e3:
            self.source.fail("this control point is more than a kilometre away: check the numbers", statement.line)
        self._points.append([value * unit for value in values])
        return True

    def curve(self, start: tuple[float, float, float]) -> Spline:
        """The curve [m] from the present point; ProgramError where its numbers do not fit together."""
        if not self._knots or not self._points:
            self.source.fail("NURBS is not followed by KNOT and CNTRL: the program is cut off", self.line)
        if abs(self._knots[-1] - 1) > 1e-6:
            self.source.fail(f"the last KNOT of NURBS is {self._knots[-1]:g}, not 1: correct it", self.line)
        try:
            return Spline.clamped(np.array(self._knots[:-1]), np.array([start, *self._points]))
        except SplineError as error:
            self.source.fail(f"NURBS: {error}", self.line)

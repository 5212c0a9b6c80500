"""Straight motion of cutter-location data: GOTO, GODLTA, FROM, GOHOME."""

from __future__ import annotations

from toolpace.programs.reading.cldata.circles import Circle, circle_arc
from toolpace.programs.reading.cldata.drilling import Drilling
from toolpace.programs.reading.cldata.feed import ClFeed
from toolpace.programs.reading.cldata.frame import ClFrame
from toolpace.programs.reading.cldata.track import RAPID, Point, Track
from toolpace.programs.reading.cldata.words import Statement, numbers
from toolpace.programs.reading.curves.arcs import Arc
from toolpace.programs.reading.curves.splines import Spline
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source

UPRIGHT = (0.0, 0.0, 1.0)
"""The tool axis with which a program and each TOOL PATH begin."""


class ClMotion:
    """RAPID, a CIRCLE that waits for its end, and the tool axis, as they stand; moves are made on the track."""

    def __init__(self, source: Source, track: Track, feed: ClFeed, frame: ClFrame, findings: Findings) -> None:
        self.source, self.track, self.feed, self.frame, self.findings = source, track, feed, frame, findings
        self.drilling = Drilling(source, track, feed, findings)
        self.rapid = False
        self.circle: Circle | None = None
        self._axis_reset = False
        """Whether the axis is the one that an operation begins with, and was another one before."""

    def begin_operation(self) -> None:
        """Each TOOL PATH begins with an upright tool, and without a cycle."""
        self.drilling.end()
        self._axis_reset = self.track.axis != UPRIGHT
        self.track.axis = UPRIGHT

    def goto(self, statement: Statement) -> None:
        """GOTO: a line, the end of a circle, or a hole."""
        tip = self._point(statement)
        if self._axis_reset:
            self.findings.assumed("a TOOL PATH that names no tool axis begins with 0,0,1")
            self._axis_reset = False
        if self.drilling.active:
            self.rapid = False
            self.drilling.hole(tip, statement.line)
        else:
            self.move(tip, statement.line)

    def start(self, statement: Statement) -> None:
        """FROM: where the program, or a later operation of it, starts."""
        tip = self._point(statement)
        if self.track.points and not self.track.begins:
            self.findings.refused("FROM", statement.line, "it names the start, but points stand before it: write GOTO")
        elif self.track.points:
            self.findings.assumed("FROM within the program is taken for a rapid, with a stop before it")
            self.track.stop()
        self.track.move(tip, statement.line, RAPID)

    def home(self, statement: Statement) -> None:
        """GOHOME: a rapid to a point; without one the motion is the machine's own."""
        if not statement.minors:
            self.findings.assumed("GOHOME without a point is the machine's own motion, and left out")
            self.track.stop()
            return
        self.findings.assumed("GOHOME is taken for a rapid")
        self.rapid = True
        self.move(self._point(statement), statement.line)

    def increment(self, statement: Statement) -> None:
        """GODLTA/dx,dy,dz[,i,j,k], or one number along the tool axis."""
        values = numbers(self.source, statement)
        tip, line = self.track.tip, statement.line
        if tip is None:
            self.source.fail("GODLTA before any position: begin with GOTO or FROM", line)
        if len(values) not in (1, 3, 6):
            takes = "it takes dx, dy, dz, perhaps i, j, k, or one along the axis"
            self.source.fail(f"GODLTA has {len(values)} numbers: {takes}", line)
        if self.drilling.active:
            self.findings.refused("GODLTA within CYCLE", line, "end the cycle before it with CYCLE/OFF")
        if len(values) == 1:
            self.findings.assumed("GODLTA with one number goes along the tool axis")
            i, j, k = self.track.unit_axis(line)
            values = [values[0] * i, values[0] * j, values[0] * k]
        if len(values) == 6:
            self.set_axis((values[3], values[4], values[5]))
        unit = self.frame.unit
        self.move((tip[0] + values[0] * unit, tip[1] + values[1] * unit, tip[2] + values[2] * unit), line)

    def tool_axis(self, statement: Statement) -> None:
        """TLAXIS/i,j,k: holds until another one."""
        values = numbers(self.source, statement)
        if len(values) != 3:
            self.source.fail(f"TLAXIS has {len(values)} numbers: it takes i, j, k", statement.line)
        self.set_axis((values[0], values[1], values[2]))

    def set_axis(self, axis: Point) -> None:
        """The program names the tool axis."""
        self.track.axis, self._axis_reset = axis, False

    def move(self, tip: Point, line: int, curve: Arc | Spline | None = None) -> None:
        """Go to a point [m], along the circle that waits for its end where there is one."""
        if self.circle is not None and self.track.tip is not None:
            curve, self.circle = circle_arc(self.source, self.circle, self.track.tip, tip), None
        rapid, self.rapid = self.rapid or self.track.tip is None, False
        self.findings.arcs += isinstance(curve, Arc)
        self.track.move(tip, line, RAPID if rapid else self.feed.caps(line), curve)

    def _point(self, statement: Statement) -> Point:
        """Tip [m] of a statement with x, y, z, and perhaps the tool axis, which then holds."""
        values = numbers(self.source, statement)
        if len(values) > 6 and len(values) % 3 == 0 and self.circle is not None:
            # Points along the circle; the last is its end.
            values = values[-3:]
        elif len(values) > 6:
            word = f"{statement.major} with {len(values)} numbers"
            self.findings.refused(word, statement.line, "it takes x, y, z, i, j, k: leave out what follows")
            values = values[:6]
        if len(values) == 6:
            self.set_axis((values[3], values[4], values[5]))
        elif len(values) != 3:
            takes = "it takes x, y, z, or x, y, z, i, j, k"
            self.source.fail(f"{statement.major} has {len(values)} numbers: {takes}", statement.line)
        unit = self.frame.unit
        return values[0] * unit, values[1] * unit, values[2] * unit

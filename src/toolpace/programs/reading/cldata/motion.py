"""Motions of cutter-location data: points, lines, circles, arcs of CATIA and NURBS."""

from __future__ import annotations

from toolpace.programs.reading.arcs import Arc
from toolpace.programs.reading.cldata.curves import Circle, NurbsRecord, circle, circle_arc, driven
from toolpace.programs.reading.cldata.cycles import Drilling
from toolpace.programs.reading.cldata.state import ClFeed, ClFrame
from toolpace.programs.reading.cldata.track import RAPID, Point, Track
from toolpace.programs.reading.cldata.words import Statement, cure, numbers
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import Spline

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


class ClCurves:
    """Statements that together are one curve, until it is whole and a motion."""

    def __init__(self, source: Source, motion: ClMotion, findings: Findings) -> None:
        self.source, self.motion, self.findings = source, motion, findings
        self._tangent: Point | None = None
        """Direction in which CATIA's next arc begins (INDIRV)."""
        self._nurbs: NurbsRecord | None = None
        self._movnrb: int | None = None
        """How many points there were when MOVNRB began; None outside."""

    def circle(self, statement: Statement) -> None:
        """CIRCLE: waits for the GOTO to its end."""
        record = circle(self.source, statement, self.motion.frame.unit, self.findings)
        if self.motion.track.tip is None:
            self.source.fail("CIRCLE before any position: begin with GOTO or FROM", statement.line)
        if not self._refused_in_cycle(statement):
            self.motion.circle = record

    def direction(self, statement: Statement) -> None:
        """INDIRV/u,v,w: how the next arc of CATIA begins."""
        values = numbers(self.source, statement)
        if len(values) != 3:
            self.source.fail(f"INDIRV has {len(values)} numbers: it takes u, v, w", statement.line)
        self._tangent = (values[0], values[1], values[2])

    def drive(self, statement: Statement) -> None:
        """TLON,GOFWD/ of CATIA: an arc; other drives are the contours of APT's source, and refused."""
        tip, tangent, self._tangent = self.motion.track.tip, self._tangent, None
        found = driven(statement, tip, tangent, self.motion.frame.unit) if tip and tangent else None
        if found is None or tip is None:
            self.findings.refused(statement.major, statement.line, cure("GOFWD"))
            return
        record, end = found
        if not self._refused_in_cycle(statement):
            self.motion.move(end, statement.line, circle_arc(self.source, record, tip, end))

    def nurbs(self, statement: Statement) -> None:
        """NURBS: begins a curve; FNURBS is refused, with the statements that belong to it."""
        refused = statement.major != "NURBS"
        if refused:
            self.findings.refused(statement.major, statement.line, cure(statement.major))
        else:
            refused = self._refused_in_cycle(statement)
        self._nurbs = NurbsRecord(self.source, statement.line, refused=refused)

    def part(self, statement: Statement) -> None:
        """KNOT and CNTRL of the curve that was begun."""
        if self._nurbs is None:
            self.findings.refused(statement.major, statement.line, "no NURBS stands before it: complete the program")
        elif not self._nurbs.add(statement, self.motion.frame.unit):
            self.findings.refused("NURBS with axes or weights", statement.line, "let the CAM system write GOTO points")

    def end(self) -> None:
        """Another statement follows: a NURBS that was begun is whole."""
        record, self._nurbs = self._nurbs, None
        if record is None or record.refused:
            return
        tip = self.motion.track.tip
        if tip is None:
            self.source.fail("NURBS before any position: begin with GOTO or FROM", record.line)
        spline = record.curve(tip)
        x, y, z = spline.points[-1].tolist()
        self.motion.move((x, y, z), record.last, spline)

    def points_of_spline(self, statement: Statement) -> None:
        """MOVNRB of Creo: the GOTO points between its ON and OFF stand for its spline."""
        self.findings.ignored("MOVNRB")
        points = self.motion.track.points
        if "ON" in statement.minors:
            self._movnrb = points
        elif "OFF" in statement.minors:
            if self._movnrb == points:
                self.findings.refused("MOVNRB", statement.line, "no GOTO points stand for its spline: write them")
            self._movnrb = None
        self.findings.assumed("MOVNRB: the GOTO points stand for its spline")

    def _refused_in_cycle(self, statement: Statement) -> bool:
        if self.motion.drilling.active:
            word = f"{statement.major} within CYCLE"
            self.findings.refused(word, statement.line, "end the cycle before it with CYCLE/OFF")
        return self.motion.drilling.active

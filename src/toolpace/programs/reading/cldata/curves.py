"""Curves of cutter-location data: CIRCLE, CATIA arcs, NURBS, MOVNRB."""

from __future__ import annotations

from toolpace.programs.reading.cldata.circles import circle, circle_arc, driven
from toolpace.programs.reading.cldata.meanings import cure
from toolpace.programs.reading.cldata.motion import ClMotion
from toolpace.programs.reading.cldata.nurbs import NurbsRecord
from toolpace.programs.reading.cldata.track import Point
from toolpace.programs.reading.cldata.words import Statement, numbers
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.source import Source


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

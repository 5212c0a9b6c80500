"""Motions of cutter-location data: points, lines, circles, arcs and splines of NX, Creo and CATIA, NURBS."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np

from toolpace.programs.reading.arcs import MOST_TURNS, Arc, ArcError, Vector, arc_about
from toolpace.programs.reading.cldata.cycles import Drilling
from toolpace.programs.reading.cldata.state import ClFeed, ClFrame
from toolpace.programs.reading.cldata.track import RAPID, Point, Track
from toolpace.programs.reading.cldata.words import NUMBER, Statement, cure, figure, numbers
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.points import FARTHEST
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import CurveError, Spline

BARE_NUMBERS, CREO_NUMBERS, NX_NUMBERS = 6, 7, 11
"""How many numbers a CIRCLE has: centre, direction; with radius; NX adds two of tolerance and two of the tool."""
CLOSED = 1e-7
"""Ends closer than this [m] close a circle of CATIA: it writes five decimals."""
TANGENT = 0.1
"""Least share of a direction that lies along the circle: with less it does not tell which way round."""
_N = rf"\s*+{NUMBER.pattern}\s*+"
_SEVEN, _SIX, _FOUR, _THREE = (rf"({_N}(?:,{_N}){{{count - 1}}})" for count in (7, 6, 4, 3))
_IN_PLANE = re.compile(
    rf"\(\s*CIRCLE\s*/{_FOUR}\)\s*,\s*ON\s*(?:,\s*([12])\s*,\s*INTOF\s*)?,\s*\(\s*LINE\s*/{_SIX}\)\s*"
)
_CYLINDER = re.compile(rf"\(\s*CYLNDR\s*/{_SEVEN}\)\s*,\s*ON\s*(?:,\s*([12])\s*,\s*INTOF\s*)?,\s*\(\s*PLANE\s*/.*")
_POINT = re.compile(rf"\(\s*POINT\s*/{_THREE}\)")
PARTS = frozenset(("KNOT", "CNTRL", "WEIGHT"))
UPRIGHT = (0.0, 0.0, 1.0)
"""The tool axis with which a program and each TOOL PATH begin."""


class Circle(NamedTuple):
    """A CIRCLE statement that waits for its end."""

    line: int
    centre: Point
    """[m]"""
    normal: Point
    """Unit vector about which the motion turns by the right-hand rule."""
    radius: float
    """[m]; nan where it is that of the start"""
    turns: int = 1


def circle(source: Source, statement: Statement, unit: float, findings: Findings) -> Circle:
    """CIRCLE/x,y,z,i,j,k,r (Creo) or with t,f,d,e[,TIMES,n] (NX).

    Siemens' description of the CLSF record (CLSF Manager, CIRCLE) gives its direction for clockwise motion:
    clockwise for one who looks at the tip of the vector, so against the right-hand rule. PTC's has seven numbers
    and follows it; so do six, without a radius (SolidWorks CAM: the fillets of its contours tell). TIMES,n asks for n
    turns of a helix, and is NX's.
    """
    words, turns = statement.minors, 1
    if "TIMES" in words:
        at = words.index("TIMES")
        count = numbers(source, statement, words[at + 1 :])
        if len(count) != 1 or count[0] != int(count[0]) or not 1 <= count[0] <= MOST_TURNS:
            source.fail(f"TIMES takes one whole number from 1 to {MOST_TURNS}", statement.line)
        words, turns = words[:at], int(count[0])
        findings.assumed("TIMES of CIRCLE is taken for how often it is gone round")
    values = numbers(source, statement, words)
    if len(values) < BARE_NUMBERS:
        source.fail(f"CIRCLE has {len(values)} numbers: it takes centre, direction and radius", statement.line)
    length = math.hypot(*values[3:6])
    if abs(length - 1) > 0.02:
        source.fail(f"the direction of CIRCLE has length {length:.4g}, not 1: correct it", statement.line)
    sense = -1.0
    if len(values) == BARE_NUMBERS:
        sense, values = 1.0, [*values, math.nan]
        findings.assumed("CIRCLE with six numbers turns about its vector by the right-hand rule, from where it starts")
    elif len(values) == CREO_NUMBERS and "TIMES" not in statement.minors:
        sense = 1.0
        findings.assumed("CIRCLE with seven numbers turns about its vector by the right-hand rule, as in Creo")
    elif len(values) != NX_NUMBERS:
        findings.assumed("CIRCLE turns clockwise about its vector, as in NX")
    i, j, k = (sense * value / length for value in values[3:6])
    x, y, z = (value * unit for value in values[:3])
    return Circle(statement.line, (x, y, z), (i, j, k), abs(values[6]) * unit, turns)


def circle_arc(source: Source, record: Circle, start: Vector, end: Vector) -> Arc:
    """Arc from start to end [m] about a circle; ProgramError where they are not on it."""
    try:
        arc = arc_about(start, end, record.centre, record.normal, record.turns)
    except ArcError as error:
        source.fail(str(error), record.line)
    if abs(arc.r0 - record.radius) > max(5e-5, 5e-3 * record.radius):
        source.fail(
            f"CIRCLE says radius {record.radius * 1e3:.6g} mm, but it starts {arc.r0 * 1e3:.6g} mm from its axis: "
            "check the centre and the radius",
            record.line,
        )
    return arc


def driven(statement: Statement, start: Point, tangent: Point, unit: float) -> tuple[Circle, Point] | None:
    """Circle and end [m] of CATIA's TLON,GOFWD/ from `start` in direction `tangent`; None for other forms.

    The drive is a circle in XY that ends on the ray from the centre to the second point of the line, or a cylinder
    that ends at the last point of the plane. `2,INTOF` names the second crossing, which that point is then.
    """
    text = statement.text.upper()
    plain = _IN_PLANE.fullmatch(text)
    if plain is not None:
        x, y, _, radius = _figures(plain[1], unit)
        to_x, to_y = (b - a for a, b in zip(_figures(plain[3], unit)[:2], _figures(plain[3], unit)[3:5]))
        away = math.hypot(to_x, to_y)
        if away < 1e-12:
            return None
        centre, normal = (x, y, start[2]), (0.0, 0.0, 1.0)
        end = (x + radius * to_x / away, y + radius * to_y / away, start[2])
    else:
        match = _CYLINDER.fullmatch(text)
        points = _POINT.findall(text)
        if match is None or not points:
            return None
        values = _figures(match[1], 1.0)
        length = math.hypot(*values[3:6])
        if abs(length - 1) > 0.02:
            return None
        centre = (values[0] * unit, values[1] * unit, values[2] * unit)
        normal = (values[3] / length, values[4] / length, values[5] / length)
        radius = values[6] * unit
        x, y, z = _figures(points[-1], unit)
        end = (x, y, z)
    a, b, c = (start[axis] - centre[axis] for axis in range(3))
    i, j, k = normal
    if not all(map(math.isfinite, (*centre, *normal, *end, radius))):
        return None
    forward = (j * c - k * b) * tangent[0] + (k * a - i * c) * tangent[1] + (i * b - j * a) * tangent[2]
    if not abs(forward) > TANGENT * math.hypot(a, b, c) * math.hypot(*tangent):
        return None
    if math.dist(start, end) < CLOSED:
        end = start
    sense = math.copysign(1.0, forward)
    return Circle(statement.line, centre, (sense * i, sense * j, sense * k), abs(radius)), end


def _figures(text: str, unit: float) -> list[float]:
    """Numbers between commas, as lengths [m]."""
    return [figure(word.strip()) * unit for word in text.split(",")]


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
        if max(map(abs, values)) * unit > FARTHEST:
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
        except CurveError as error:
            self.source.fail(f"NURBS: {error}", self.line)


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

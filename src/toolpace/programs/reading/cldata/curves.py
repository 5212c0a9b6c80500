"""Arcs and splines from the records of curves that NX, Creo and CATIA write."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np

from toolpace.programs.reading.arcs import MOST_TURNS, Arc, ArcError, Vector, arc_about
from toolpace.programs.reading.cldata.words import NUMBER, Statement, figure, numbers
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

Point = tuple[float, float, float]
_N = rf"\s*+{NUMBER.pattern}\s*+"
_SEVEN, _SIX, _FOUR, _THREE = (rf"({_N}(?:,{_N}){{{count - 1}}})" for count in (7, 6, 4, 3))
_IN_PLANE = re.compile(
    rf"\(\s*CIRCLE\s*/{_FOUR}\)\s*,\s*ON\s*(?:,\s*([12])\s*,\s*INTOF\s*)?,\s*\(\s*LINE\s*/{_SIX}\)\s*"
)
_CYLINDER = re.compile(rf"\(\s*CYLNDR\s*/{_SEVEN}\)\s*,\s*ON\s*(?:,\s*([12])\s*,\s*INTOF\s*)?,\s*\(\s*PLANE\s*/.*")
_POINT = re.compile(rf"\(\s*POINT\s*/{_THREE}\)")
PARTS = frozenset(("KNOT", "CNTRL", "WEIGHT"))


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

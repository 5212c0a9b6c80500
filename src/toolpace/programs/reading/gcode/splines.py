"""Splines: LinuxCNC's G5, G5.1, G5.2; Fanuc's G6.2."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.motion import MotionReader
from toolpace.programs.reading.gcode.program.words import Numbers
from toolpace.programs.reading.splines import Bezier, CurveError, curves_of, even_knots

CUBIC, QUADRATIC, NURBS, BY_KNOTS = "cubic spline", "quadratic spline", "nurbs", "nurbs by knots"
SPLINES = (CUBIC, QUADRATIC, NURBS, BY_KNOTS)
NEAR = 1e-5
"""How far a spline may begin from where the tool is [m]: programs round."""
_USUAL_ORDER = {NURBS: 3, BY_KNOTS: 4}
_MOST_POINTS = 100_000
"""Control points of a spline: a bound on what a program may ask for, not a rule of a control."""


@dataclass
class Opened:
    """A NURBS whose blocks are not all read."""

    kind: str
    line: int
    number: float | None
    """Its F under inverse time."""
    order: int
    points: list[list[float]] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    knots: list[float] = field(default_factory=list)
    named: int = 0
    end: list[float] = field(default_factory=list)
    """Words (3 + rotary) of the last control point."""


class Splines:
    """Reads the blocks of a spline, and moves along it when it is whole."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader) -> None:
        self.control, self.state, self.motion = control, state, motion
        self.opened: Opened | None = None
        self.behind: tuple[float, float] | None = None
        """From the end of the last cubic back to its second control point [m]; none where the last was another."""

    def begin(self, meaning: str) -> None:
        """A word of a spline stands in the block at hand."""
        if self.state.motion != CUBIC:
            self.behind = None
        self.state.motion, self.state.cycle = meaning, None

    def execute(self, numbers: Numbers, number: float | None) -> None:
        """One block under a word of splines. Raises BlockError, CurveError."""
        if not numbers:
            return
        kind = self.state.motion
        if kind == CUBIC:
            self._cubic(numbers, number)
        elif kind == QUADRATIC:
            self._quadratic(numbers, number)
        else:
            self._point(numbers, number, str(kind))

    def _curve(self, inner: list[list[float]], target: list[float], named: int, number: float | None) -> None:
        start = self.control.words[:3]
        self.control.spline([Bezier.plain([start, *inner, target[:3]])], named, number)

    def _target(self, numbers: Numbers) -> tuple[list[float], int]:
        target, named = self.motion.target(numbers)
        if target[3:] != self.control.words[3:]:
            raise BlockError("a spline cannot turn the rotary axes: let the CAM system write lines")
        return target, named

    def _offset(self, numbers: Numbers, letters: str) -> tuple[float, float] | None:
        """Two distances in the plane [m]; None where neither is given."""
        values = [numbers.pop(letter, None) for letter in letters]
        if values == [None, None]:
            return None
        if None in values:
            raise BlockError(f"of {letters[0]} and {letters[1]} one is missing: a spline takes both")
        return (values[0] or 0.0) * self.state.unit, (values[1] or 0.0) * self.state.unit

    def _need_plane(self) -> None:
        if self.state.plane:
            raise BlockError("splines lie in the plane of G17: write it before them")

    def _cubic(self, numbers: Numbers, number: float | None) -> None:
        """G5 X Y I J P Q: control points by their distances from the start and from the end."""
        self._need_plane()
        first, second = self._offset(numbers, "IJ"), self._offset(numbers, "PQ")
        if second is None:
            raise BlockError("G5 needs its second control point: write P and Q, from the end to it")
        if first is None:
            if self.behind is None:
                raise BlockError("the first G5 needs its first control point: write I and J, from the start to it")
            first = (-self.behind[0], -self.behind[1])
        start = self.control.words[:3]
        target, named = self._target(numbers)
        inner = [[start[0] + first[0], start[1] + first[1], start[2]]]
        inner.append([target[0] + second[0], target[1] + second[1], target[2]])
        self._curve(inner, target, named, number)
        self.behind = second

    def _quadratic(self, numbers: Numbers, number: float | None) -> None:
        """G5.1 X Y I J: the control point by its distance from the start."""
        self._need_plane()
        off = self._offset(numbers, "IJ")
        if off is None:
            raise BlockError("G5.1 needs its control point: write I and J, from the start to it")
        start = self.control.words[:3]
        target, named = self._target(numbers)
        self._curve([[start[0] + off[0], start[1] + off[1], start[2]]], target, named, number)

    def _point(self, numbers: Numbers, number: float | None, kind: str) -> None:
        """A control point: with its weight P (G5.2), or with a knot K and its weight R (G6.2)."""
        made = self._opened(numbers, number, kind)
        weight = numbers.pop("P" if kind == NURBS else "R", 1.0)
        if kind == BY_KNOTS:
            if "K" not in numbers:
                raise BlockError("a block of G6.2 needs its knot: write K")
            made.knots.append(numbers.pop("K"))
            if not numbers and made.points:
                return
        elif not numbers:
            made.weights[0] = weight  # of the place where the spline begins
            return
        if not self.state.absolute:
            raise BlockError("control points under G91 are not read: write them under G90")
        present = self.control.words
        self.control.words = made.end or present
        try:
            made.end, named = self._target(numbers)
        finally:
            self.control.words = present
        made.named |= named
        made.points.append(made.end[:3])
        made.weights.append(weight)
        if len(made.points) > _MOST_POINTS:
            raise BlockError(f"a spline of more than {_MOST_POINTS} control points is not read: write several")

    def _opened(self, numbers: Numbers, number: float | None, kind: str) -> Opened:
        if self.opened is None:
            if kind == NURBS:
                self._need_plane()
            order = numbers.pop("L" if kind == NURBS else "P", _USUAL_ORDER[kind])
            if order != int(order):
                raise BlockError("the order of a spline is a whole number: correct it")
            self.opened = Opened(kind, self.control.line, number, int(order))
            if kind == NURBS:  # it begins where the tool is
                self.opened.points, self.opened.weights = [list(self.control.words[:3])], [1.0]
        return self.opened

    def close(self) -> None:
        """Move along the spline that was opened, if any: a block with another word follows, or the program ends."""
        made, self.opened = self.opened, None
        if made is None:
            return
        control, here = self.control, self.control.line
        control.line = made.line
        try:
            off = math.dist(made.points[0], control.words[:3]) if made.points else 0.0
            if off > NEAR:
                raise CurveError(f"the spline begins {off * 1e3:.4g} mm from where the tool is: go to its first point")
            knots = made.knots or even_knots(made.order, len(made.points))
            control.spline(curves_of(made.order, knots, made.points, made.weights), made.named, made.number)
        except CurveError as error:
            control.source.fail(str(error), made.line)
        finally:
            control.line = here

"""BSPLINE: block positions as control points."""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.sinumerik.syntax.values import Unread, ValueFault
from toolpace.programs.reading.sinumerik.word_values import Words, number
from toolpace.programs.reading.splines import CurveError, curves_of, even_knots

CURE = "let the CAM system write lines and arcs"
HEAVIEST = 3.0
"""Most weight PW."""


class BSplines:
    """Gathers control points until another motion follows, then moves along the spline."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.points: list[list[float]] = []
        self.weights: list[float] = []
        self.steps: set[float] = set()
        """Distances of knots (PL) that are written."""
        self.end: list[float] = []
        """Words (3 + rotary) of the last control point."""
        self.named = self.line = 0
        self.degree = 3

    def point(self, target: list[float], named: int, words: Words, inverse: float | None) -> None:
        """One block: the target (3 + rotary) is the next control point. Raises Unread, ValueFault."""
        control = self.control
        if inverse is not None:
            raise Unread("BSPLINE under G93", "write G94")
        if target[3:] != control.words[3:]:
            raise Unread("BSPLINE that turns rotary axes", CURE)
        degree = number(words, "SD")
        weight, step = number(words, "PW", 1.0), number(words, "PL")
        if not self.points:
            self.points, self.weights, self.steps = [list(control.words[:3])], [1.0], set()
            self.degree, self.named, self.line = 3, 0, control.line
        if degree is not None:
            if degree not in (2.0, 3.0):
                raise ValueFault(f"SD={degree:g} is no degree of BSPLINE: write SD=2 or SD=3")
            self.degree = int(degree)
        if weight is None or not 0.0 < weight <= HEAVIEST:
            raise ValueFault(f"PW is the weight of a control point, above 0 and at most {HEAVIEST:g}: correct it")
        if step is not None:
            if step <= 0.0:
                raise ValueFault(f"PL={step:g} is no distance of knots (alarms 10891, 14093): write one above zero")
            self.steps.add(step)
        self.points.append(target[:3])
        self.weights.append(weight)
        self.end, self.named = list(target), self.named | named

    def close(self) -> None:
        """Move along what was gathered, if anything. Raises ProgramError."""
        points, self.points, self.end = self.points, [], []
        if not points:
            return
        control, here = self.control, self.control.line
        if len(self.steps) > 1:
            control.findings.refused("PL=", self.line, f"which span each PL belongs to is not known: {CURE}")
            return
        control.findings.assumed("knots of BSPLINE are evenly spaced between its ends, where it touches its points")
        control.line = self.line
        try:
            # a spline of few points is of a lower degree
            order = min(self.degree + 1, len(points))
            control.spline(curves_of(order, even_knots(order, len(points)), points, self.weights), self.named)
        except CurveError as error:
            control.source.fail(str(error), self.line)
        finally:
            control.line = here

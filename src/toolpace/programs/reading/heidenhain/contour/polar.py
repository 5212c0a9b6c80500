"""Polar blocks: LP, CP, CTP."""

from __future__ import annotations

import math

from toolpace.common.units import DEGREE
from toolpace.programs.reading.curves.arcs import arc_about
from toolpace.programs.reading.heidenhain.contour.circles import SAME, Circles
from toolpace.programs.reading.heidenhain.contour.motion import Axis, Step
from toolpace.programs.reading.heidenhain.klartext.expressions import evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError
from toolpace.programs.reading.heidenhain.klartext.words import PathWords
from toolpace.programs.reading.heidenhain.state import OF_AXIS

MOST_TURNS = 15.0
"""Of one helix: 5400 degrees are the most that the control takes."""
FROM_HERE = (
    "a polar block behind another motion or CC, without PR or PA or with incremental ones, takes the distance and the "
    "angle of the place where the tool is"
)
POLAR = ("PR", "IPR", "PA", "IPA")


class Polar:
    """Points by radius and angle about the pole."""

    def __init__(self, circles: Circles) -> None:
        self.circles = circles
        self.control, self.state, self.motion = circles.control, circles.state, circles.motion

    def polar_line(self, words: PathWords) -> Step:
        """LP: straight to a polar point."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "LP", POLAR)

        def run() -> None:
            self.circles.need_pole()
            rapid = self.circles.begin(words)
            target, named = self.polar(words, axes)
            self.motion.straight(target, named, rapid)

        return run

    def polar_arc(self, words: PathWords) -> Step:
        """CP: about the pole to an angle; with IPA over several turns, and with Z a helix."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "CP", ("PA", "IPA"))
        by = words.others.get("IPA")
        if by is None and "PA" not in words.others:
            raise BlockError("CP needs the angle of its end: write PA or IPA")

        def run() -> None:
            self.circles.need_pole()
            rapid = self.circles.begin(words)
            target, named = self.polar(words, axes, arc=True)
            turned = 0.0 if by is None else self.circles.limited(evaluate(by)) * DEGREE
            sense = words.sense or (int(math.copysign(1, turned)) if turned else 0)
            if by is not None and not turned:
                raise BlockError("IPA of CP is zero: write its angle, of a full circle 360")
            if not sense:
                raise BlockError("CP needs its sense: write DR+ or DR-")
            if turned * sense < 0.0:
                raise BlockError("IPA and DR of CP have different signs: correct one")
            if abs(turned) > MOST_TURNS * 2.0 * math.pi + 1e-9:
                raise BlockError("IPA is more than 5400 degrees: divide the helix")
            axis = self.circles.pole_axis
            normal = [float(sense) if k == axis else 0.0 for k in range(3)]
            made = arc_about(self.control.words, target, self.state.pole, normal, tolerance=self.circles.radii)
            if turned:
                made = made._replace(sweep=abs(turned))
            self.circles.arc(made, target, named, rapid)

        return run

    def polar_tangent(self, words: PathWords) -> Step:
        """CTP: tangent arc to a polar point."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "CTP", POLAR)

        def run() -> None:
            self.circles.need_pole()
            if self.circles.pole_axis != self.state.tool_axis:
                raise BlockError("CTP is read in the plane across the tool only: write CP or C here")
            rapid = self.circles.begin(words)
            target, named = self.polar(words, axes)
            self.circles.along_tangent(target, named, rapid)

        return run

    def polar(self, words: PathWords, axes: list[Axis], *, arc: bool = False) -> tuple[list[float], int]:
        """Words (3 + rotary) of a polar point, the end of an arc about the pole or not: what is not given stays as it
        is here. Raises BlockError."""
        target, named = self.motion.target(axes)
        state, others = self.state, words.others
        if others.keys() >= {"PA", "IPA"} or others.keys() >= {"PR", "IPR"}:
            raise BlockError("a polar block has PA or IPA, and PR or IPR: remove one")
        first, second = OF_AXIS[self.circles.pole_axis]
        if named & (1 << first | 1 << second):
            raise BlockError("a polar block takes the coordinate across its plane beside PR and PA only")
        du = self.control.words[first] - state.pole[first]
        dv = self.control.words[second] - state.pole[second]
        radius, angle = math.hypot(du, dv), math.atan2(dv, du)
        here = [self.control.words[first], self.control.words[second], state.pole[first], state.pole[second]]
        if "PA" not in others and radius < SAME:
            raise BlockError("from the pole itself a polar block needs the angle of its end: write PA")
        if not arc and here != state.polar_end and not others.keys() >= {"PR", "PA"}:
            self.control.findings.assumed(FROM_HERE)
        if "PR" in others:
            radius = self.circles.limited(evaluate(others["PR"])) * state.unit
        elif "IPR" in others:
            radius += self.circles.limited(evaluate(others["IPR"])) * state.unit
        if "PA" in others:
            angle = self.circles.limited(evaluate(others["PA"])) * DEGREE
        elif "IPA" in others:
            angle += self.circles.limited(evaluate(others["IPA"])) * DEGREE
        target[first] = state.pole[first] + radius * math.cos(angle)
        target[second] = state.pole[second] + radius * math.sin(angle)
        state.polar_end = [target[first], target[second], *here[2:]]
        return target, named | 1 << first | 1 << second

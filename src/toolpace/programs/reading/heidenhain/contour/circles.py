"""Arcs and polar blocks: CC, C, CR, CT, LP, CP, CTP."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.programs.reading.arcs import (
    PLANE_ACROSS,
    ROUNDING,
    SPIRAL_SAID,
    Arc,
    Tolerance,
    arc_about,
    centre_of_radius,
    plane_arc,
    tangent_centre,
)
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Axis, Motion, Step
from toolpace.programs.reading.heidenhain.parameters import LARGEST, evaluate
from toolpace.programs.reading.heidenhain.state import OF_AXIS, State
from toolpace.programs.reading.heidenhain.words import PathWords

PAIRS = {0b110: 0, 0b101: 1, 0b011: 2}
"""Two of X, Y, Z as bits, to the axis across them."""

SHORT = "a CR whose R is shorter than half the way to its end, within what the control allows, is half a circle"
POLE_STAYS = "a CC before a change of coordinates keeps the figures that it was written with, in the new ones"
MOST_TURNS = 15.0
"""Of one helix: 5400 degrees are the most that the control takes."""
FROM_HERE = (
    "a polar block behind another motion or CC, without PR or PA or with incremental ones, takes the distance and the "
    "angle of the place where the tool is"
)
POLAR = ("PR", "IPR", "PA", "IPA")


class Circles:
    """Arcs about a pole, by radius, tangent."""

    def __init__(self, control: Control, state: State, motion: Motion) -> None:
        self.control, self.state, self.motion = control, state, motion
        option = control.controller.option
        self.radii = Tolerance(option("arc_radii_mm", 0.016) * MILLIMETRE, 0.0)
        """Of the radii at the ends of an arc, also in programs in inches."""

    def pole(self, words: PathWords) -> Step:
        """CC: no motion."""
        axes = self.motion.resolved(words)
        if any(axis[0] > 2 for axis in axes):
            raise BlockError("CC takes X, Y and Z only: remove the rotary axis")

        def run() -> None:
            state = self.state
            target, named = self.motion.target(axes)
            if not named:
                state.pole = self.control.words[:3]
            elif named.bit_count() == 1 and not state.pole_is_set:
                raise BlockError("the first CC names one coordinate, and it takes two of X, Y and Z: write both")
            elif named.bit_count() == 1:
                self.control.findings.assumed("a CC of one coordinate keeps the other one of the CC before")
            for slot, _, _, _ in axes:
                state.pole[slot] = target[slot]
            state.pole_is_set, state.pole_in = True, self.control.placement
            across = PAIRS.get(named)
            state.pole_across = None if across == state.tool_axis else across
            if named == 7:
                state.pole_in_space = True
                self.control.findings.assumed(
                    "a CC of three coordinates and the arcs behind it lie across the axis that start, centre and end "
                    "share"
                )

        return run

    @property
    def pole_axis(self) -> int:
        """The axis across which the pole's plane lies: the two coordinates of CC tell it, else it is the tool's."""
        across = self.state.pole_across
        return self.state.tool_axis if across is None else across

    def need_pole(self) -> None:
        """Raises BlockError where no CC came before."""
        if not self.state.pole_is_set:
            raise BlockError("there is no CC before this block: write one, it is the centre and the pole")
        if self.state.pole_in != self.control.placement:
            self.control.findings.assumed(POLE_STAYS)

    def about_pole(self, words: PathWords) -> Step:
        """C: to a point about the pole."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "C", ())
        sense = self.sense(words)

        def run() -> None:
            self.need_pole()
            rapid = self.begin(words)
            target, named = self.motion.target(axes)
            axis = self.across(target)
            start, pole, plane = self.control.words, self.state.pole, PLANE_ACROSS[axis]
            self.arc(plane_arc(start, target, pole, plane, sense < 0, tolerance=self.radii), target, named, rapid)

        return run

    def across(self, target: list[float]) -> int:
        """The axis across which an arc about the pole lies."""
        state, start, pole = self.state, self.control.words, self.state.pole
        if not state.pole_in_space:
            return self.pole_axis
        shared = [k for k in range(3) if abs(start[k] - pole[k]) < ROUNDING and abs(target[k] - pole[k]) < ROUNDING]
        level = abs(start[state.tool_axis] - target[state.tool_axis]) < ROUNDING
        if not shared and level:
            return state.tool_axis  # an ordinary arc again: its CC names the plane alone
        if len(shared) > 1 and state.came_from and self.control.moved_in == self.control.placement:
            # the centre stands between both ends: the motion before tells the plane, which it lies in
            shared = [k for k in shared if abs(start[k] - state.came_from[k]) < ROUNDING]
        if len(shared) != 1:
            raise BlockError("CC of three coordinates: start, centre and end do not share just one of X, Y, Z")
        return shared[0]

    def of_radius(self, words: PathWords) -> Step:
        """CR: to a point with a radius; a negative one asks for the longer way."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "CR", ("R",))
        sense, size = self.sense(words), words.others.get("R")
        if size is None:
            raise BlockError("CR needs its radius R: write one")

        def run() -> None:
            rapid = self.begin(words)
            target, named = self.motion.target(axes)
            start, plane = self.control.words, PLANE_ACROSS[self.state.tool_axis]
            radius = self.limited(evaluate(size)) * self.state.unit
            first, second = OF_AXIS[self.state.tool_axis]
            half = 0.5 * math.hypot(target[first] - start[first], target[second] - start[second])
            if half - abs(radius) > SPIRAL_SAID:
                self.control.findings.assumed(SHORT)
            centre = centre_of_radius(start, target, radius, plane, sense < 0, self.radii)
            self.arc(plane_arc(start, target, centre, plane, sense < 0), target, named, rapid)

        return run

    def tangent_arc(self, words: PathWords) -> Step:
        """CT: to a point, beginning in the direction in which the last element ended."""
        axes = self.motion.resolved(words)
        self.motion.only(words, "CT", ())

        def run() -> None:
            rapid = self.begin(words)
            target, named = self.motion.target(axes)
            self.along_tangent(target, named, rapid)

        return run

    def along_tangent(self, target: list[float], named: int, rapid: bool) -> None:
        """The arc from here that keeps the direction; a straight way where the end lies ahead."""
        start = self.control.words
        first, second = OF_AXIS[self.state.tool_axis]
        if self.control.moved_in != self.control.placement:
            cure = "write C or CR: whether the control keeps the direction of the element before is not known here"
            self.control.refuse("a tangent arc behind a change of coordinates", cure)
            self.motion.straight(target, named, rapid)
            return
        u, v = self.direction()
        du, dv = target[first] - start[first], target[second] - start[second]
        plane = PLANE_ACROSS[self.state.tool_axis]
        found = tangent_centre(start, target, (u, v), plane, ROUNDING)
        if found is None:
            if du * u + dv * v < 0.0:
                raise BlockError("the end of a tangent arc lies straight behind its start: write C or CR")
            self.motion.straight(target, named, rapid)
            return
        self.arc(plane_arc(start, target, found[0], plane, found[1]), target, named, rapid)

    def direction(self) -> tuple[float, float]:
        """Unit vector in the plane in which the last motion ended. Raises BlockError."""
        state, first_second = self.state, OF_AXIS[self.state.tool_axis]
        arc = state.came_by
        ended: Sequence[float] = (0.0, 0.0, 0.0)
        if arc is not None:
            ended = arc.last_direction()
        elif state.came_from:
            ended = [a - b for a, b in zip(self.control.words[:3], state.came_from)]
        u, v = (ended[k] for k in first_second)
        length = math.hypot(u, v)
        if length < ROUNDING:
            raise BlockError("a tangent arc needs an element before it that moves in its plane")
        return u / length, v / length

    def begin(self, words: PathWords) -> bool:
        """Take compensation and feed; returns whether the block is a rapid."""
        self.motion.compensation.take(words.side)
        return self.motion.set_feed(words)

    def arc(self, arc: Arc, target: list[float], named: int, rapid: bool) -> None:
        """Move along it."""
        self.motion.corners.refuse()
        first, second = (k for k in range(3) if abs(arc.u[k]) + abs(arc.w[k]) > ROUNDING)
        self.motion.need_even_scale(first, second)
        self.motion.contour_begins(list(arc.w))
        before = self.control.words
        self.control.arc(target, named, arc, rapid=rapid)
        self.state.came_from, self.state.came_by = before, arc

    @staticmethod
    def sense(words: PathWords) -> int:
        """DR+ or DR-. Raises BlockError where a block has none."""
        if not words.sense:
            raise BlockError("the arc has no sense: write DR+ or DR-")
        return words.sense

    @staticmethod
    def limited(value: float) -> float:
        """The value. Raises BlockError where it is beyond any machine."""
        if not abs(value) <= LARGEST:
            raise BlockError(f"{value:.6g} is beyond any machine: check its figures")
        return value


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
            if abs(turned) > MOST_TURNS * 2.0 * math.pi + ROUNDING:
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
        if "PA" not in others and radius < ROUNDING:
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

"""APPR and DEP: approach and departure (TNC 640, Klartext, 6.3)."""

from __future__ import annotations

import cmath
import math
import re
from contextlib import nullcontext
from dataclasses import dataclass
from typing import NamedTuple

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_ACROSS, ROUNDING, plane_arc
from toolpace.programs.reading.compensation.tool_centre_path import leave_here
from toolpace.programs.reading.control.feed import PER_MINUTE
from toolpace.programs.reading.control.moves import RAPID
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.circles import POLAR, Circles, Polar
from toolpace.programs.reading.heidenhain.contour.straight_lines import Axis, Step
from toolpace.programs.reading.heidenhain.parameters import Value, evaluate
from toolpace.programs.reading.heidenhain.state import OF_AXIS
from toolpace.programs.reading.heidenhain.words import PathWords

_FORM = re.compile(r"(P?)(LT|LN|CT|LCT)(?![A-Z])")


class Form(NamedTuple):
    """How the way runs."""

    name: str
    """LT, LN: straight on, or across the contour; CT: an arc; LCT: a line, and an arc that touches it."""
    polar: bool

    @staticmethod
    def of(text: str) -> tuple[Form, str]:
        """The form that a text begins with, and the rest. Raises BlockError."""
        found = _FORM.match(text)
        if found is None:
            raise BlockError("APPR and DEP are followed by LT, LN, CT or LCT: write one of them")
        return Form(found[2], bool(found[1])), text[found.end() :]


NEEDS = {"LT": ("LEN",), "LN": ("LEN",), "CT": ("CCA", "R"), "LCT": ("R",)}
"""Words that each form takes."""
CURE = "write the approach as L and CR blocks: it is read before a motion in the plane of the tool axis"


@dataclass
class Approach:
    """An approach that waits for the direction in which its contour begins.

    Until then it stands as a straight way to the contour's first point, of `rows` motions: in the plane, then along
    the tool axis.
    """

    form: str
    sizes: dict[str, float]
    side: int
    radius: float
    """To be compensated [m]."""
    start: list[float]
    """Words (3 + rotary) where it begins."""
    rows: int
    moves: int
    """How many motions there were when it was read."""
    line: int
    speeds: tuple[float, float] | None
    """Its own feed [m/s] and rotation [rad/s]; none where it is a length a turn."""


class Approaches:
    """Reads both, and lays an approach when its contour begins."""

    def __init__(self, circles: Circles, polar: Polar) -> None:
        self.circles, self.polar = circles, polar
        self.control, self.state, self.motion = circles.control, circles.state, circles.motion
        self.waiting: Approach | None = None
        self.motion.approaches = self

    # APPR

    def approach(self, form: Form, words: PathWords) -> Step:
        """APPR LT, LN, CT, LCT, and by polar points PLT, PLN, PCT, PLCT. Raises BlockError."""
        axes = self._axes("APPR", form, words)

        def run() -> None:
            control, moves = self.control, self.control.moves
            self.motion.corners.refuse()
            if not len(moves):
                raise BlockError("APPR needs a place to begin at: position before it")
            if control.stage is not None and control.stage.compensates:
                raise BlockError("APPR under RL or RR: end the contour before it with DEP, or with R0")
            sizes = self._sizes(form.name, words)
            self.state.side = words.side or self.state.side
            radius = self.motion.compensation.radius()
            rapid = moves.rows[-1][moves.kind] == RAPID
            target, named = self.polar.polar(words, axes) if form.polar else self.motion.target(axes)
            start, axis = control.words, self.state.tool_axis
            level = list(target)
            level[axis] = start[axis]
            control.straight(level, named, rapid=rapid)
            rows = 1
            if abs(target[axis] - start[axis]) > ROUNDING:
                control.straight(target, named, rapid=rapid)
                rows = 2
            self.motion.set_feed(words)
            self.waiting = Approach(
                form.name, sizes, self._side(), radius, start, rows, len(moves), control.line, self._speeds()
            )
            self.state.came_from, self.state.came_by = [], None

        return run

    def lay(self, way: list[float]) -> None:
        """A contour begins in the direction `way` (3,), where the approach that waits ends. Raises BlockError."""
        found, self.waiting = self.waiting, None
        assert found is not None
        control, state = self.control, self.state
        first, second = OF_AXIS[state.tool_axis]
        tangent = complex(way[first], way[second])
        if found.moves != len(control.moves) or abs(tangent) < ROUNDING:
            control.findings.refused("APPR", found.line, CURE)
            return
        tangent /= abs(tangent)
        contour, end = control.words, list(control.words)
        # the way and its sizes are those of the centre
        beside = complex(end[first], end[second]) + found.radius * _turned(found.side) * tangent
        end[first], end[second] = beside.real, beside.imag
        at, begin = beside, complex(found.start[first], found.start[second])
        touch, centre = _approach(found, at, begin, tangent)
        places = []
        for height in (found.start, end)[2 - found.rows :]:
            place = list(end)
            place[first], place[second], place[state.tool_axis] = touch.real, touch.imag, height[state.tool_axis]
            places.append(place)
        control.redirect(places)
        self._finish(end, centre, found)
        if found.radius:
            self._follow(contour, tangent, found)

    def _follow(self, contour: list[float], tangent: complex, found: Approach) -> None:
        """Compensate from here on, where the centre is beside the contour's first point."""
        control, state = self.control, self.state
        first, second = OF_AXIS[state.tool_axis]
        control.words = contour
        self.motion.compensation.begin(found.radius)
        follower = self.motion.compensation.follower
        assert follower is not None
        follower.begin_across(tangent)
        back = _turned(found.side) * tangent if found.form == "LN" else -tangent
        state.came_from, state.came_by = list(contour), None
        state.came_from[first] += back.real
        state.came_from[second] += back.imag

    def _finish(self, end: list[float], centre: complex | None, found: Approach) -> None:
        """From the help point to the contour."""
        control, state = self.control, self.state
        before = control.words
        state.came_from, state.came_by = before, None
        if math.dist(before, end) < ROUNDING:
            return
        with control.feed.held(*found.speeds) if found.speeds else nullcontext():
            if centre is None:
                control.straight(end, 0, rapid=False)
            else:
                self._arc(end, centre, found.side, found.sizes)

    def _arc(self, end: list[float], centre: complex, side: int, sizes: dict[str, float]) -> None:
        control, state = self.control, self.state
        first, second = OF_AXIS[state.tool_axis]
        before = control.words
        about = list(before[:3])
        about[first], about[second] = centre.real, centre.imag
        clockwise = side * sizes["R"] < 0.0
        made = plane_arc(before, end, about, PLANE_ACROSS[state.tool_axis], clockwise)
        control.arc(end, 0, made)
        state.came_from, state.came_by = before, made

    def refuse(self) -> None:
        """The program ends, and no contour came."""
        found, self.waiting = self.waiting, None
        if found is not None:
            self.control.findings.refused("APPR", found.line, CURE)

    # DEP

    def departure(self, form: Form, words: PathWords) -> Step:
        """DEP LT, LN, CT, LCT, PLCT; it ends the compensation. Raises BlockError."""
        axes = self._axes("DEP", form, words)

        def run() -> None:
            control, state = self.control, self.state
            self.motion.corners.refuse()
            rapid = self.motion.set_feed(words)
            sizes, side = self._sizes(form.name, words), self._side()
            u, v = self.circles.direction()
            target, named = self.polar.polar(words, axes) if form.polar else self.motion.target(axes)
            follower = self.motion.compensation.follower
            if follower is not None:
                leave_here(follower)
            first, second = OF_AXIS[state.tool_axis]
            at = complex(control.words[first], control.words[second])
            goal = complex(target[first], target[second])
            touch, centre = _departure(form.name, sizes, side, at, goal, complex(u, v))
            level = list(control.words)
            level[first], level[second] = touch.real, touch.imag
            if centre is None:
                self.motion.straight(level, named, rapid)
            else:
                self._arc(level, centre, side, sizes)
            if form.name == "LCT":
                aside = list(target)
                aside[state.tool_axis] = control.words[state.tool_axis]
                self.motion.straight(aside, named, rapid)
            if abs(target[state.tool_axis] - control.words[state.tool_axis]) > ROUNDING:
                lifted = list(control.words)
                lifted[state.tool_axis] = target[state.tool_axis]
                self.motion.straight(lifted, named, rapid)
            state.side = "R0"

        return run

    # Words

    def _axes(self, name: str, form: Form, words: PathWords) -> list[Axis]:
        self.motion.only(words, f"{name} {form.name}", (*NEEDS[form.name], *(POLAR if form.polar else ())))
        return self.motion.resolved(words)

    def _sizes(self, form: str, words: PathWords) -> dict[str, float]:
        """LEN and R [m], CCA [rad]."""
        found = {}
        for name in NEEDS[form]:
            length: Value | None = words.others.get(name)
            if length is None:
                raise BlockError(f"{name} is missing: {form} takes {' and '.join(NEEDS[form])}")
            value = self.circles.limited(evaluate(length)) * (DEGREE if name == "CCA" else self.state.unit)
            if abs(value) < ROUNDING or (name == "CCA" and not 0.0 < value < 2.0 * math.pi):
                raise BlockError(f"{name} of {form} is none that can be: correct it")
            found[name] = value
        return found

    def _speeds(self) -> tuple[float, float] | None:
        feed = self.control.feed
        return (feed.value, feed.turn) if feed.mode == PER_MINUTE and feed.value is not None else None

    def _side(self) -> int:
        """1 where the tool goes at the left of the contour; at R0 the control takes the right."""
        return 1 if self.state.side == "RL" else -1


def _turned(side: int) -> complex:
    """Turn of a direction to the side of the tool."""
    return 1j * side


def _approach(found: Approach, at: complex, begin: complex, tangent: complex) -> tuple[complex, complex | None]:
    """The help point, and the centre of the arc from there, of an approach to `at`. Raises BlockError."""
    sizes, aside = found.sizes, _turned(found.side)
    if found.form == "LT":
        return at - sizes["LEN"] * tangent, None
    if found.form == "LN":
        return at + sizes["LEN"] * aside * tangent, None
    centre = at + sizes["R"] * aside * tangent
    sense = math.copysign(1.0, found.side * sizes["R"])
    if found.form == "CT":
        return centre + (at - centre) * cmath.exp(-1j * sense * sizes["CCA"]), centre
    away = centre - begin
    return begin + _touching(away, sizes["R"], "LCT", -sense), centre


def _departure(
    form: str, sizes: dict[str, float], side: int, at: complex, goal: complex, tangent: complex
) -> tuple[complex, complex | None]:
    """The end of a departure, or the end of its arc, and the centre of that. Raises BlockError."""
    aside = _turned(side)
    if form == "LT":
        return at + sizes["LEN"] * tangent, None
    if form == "LN":
        return at + sizes["LEN"] * aside * tangent, None
    centre = at + sizes["R"] * aside * tangent
    sense = math.copysign(1.0, side * sizes["R"])
    if form == "CT":
        return centre + (at - centre) * cmath.exp(1j * sense * sizes["CCA"]), centre
    return goal - _touching(goal - centre, sizes["R"], "LCT", sense), centre


def _touching(away: complex, radius: float, form: str, sense: float) -> complex:
    """Way along a tangent of a circle, as long as between its touching point and a point `away` from the centre."""
    distance = abs(away)
    if distance <= abs(radius):
        raise BlockError(f"the circle of {form} reaches over the place from which it is gone to: make R smaller")
    direction = away / distance * cmath.exp(1j * sense * math.asin(abs(radius) / distance))
    return direction * math.sqrt(distance * distance - radius * radius)

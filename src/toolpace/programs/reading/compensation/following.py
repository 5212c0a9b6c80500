"""Compensation with one element of look-ahead, with the corner rules of a control."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

from toolpace.programs.reading.compensation.corners import ROUNDED, TANGENT, Corners, Followed
from toolpace.programs.reading.compensation.elements import (
    SAME,
    Element,
    Line,
    Turn,
    is_behind,
    turning,
    turning_away,
    unit,
)
from toolpace.programs.reading.compensation.meetings import between, gone, offset
from toolpace.programs.reading.compensation.rules import AROUND, TOUCHING, Rules
from toolpace.programs.reading.compensation.stage import Laid
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import FEED, Rate
from toolpace.programs.reading.curves.arcs import Arc

ACROSS_ALONE = "across the plane, which is not read where a block without a motion shifts the tool: move it elsewhere"
BEGINS_STRAIGHT = "compensation begins with a straight motion, and this is an arc: write a line before it"


class Follower(Corners):
    """The stage between the words that begin and end a compensation."""

    def __init__(self, control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
        super().__init__(control, side, radius, plane, rules)
        self.at = self.begun = self.point(control.reached())
        self.speed = Rate(), FEED
        """Rate and kind of the last element."""
        self.entering: Line | None = None
        """The motion that leads to the contour, until the contour is there."""
        self.paused = False
        """Whether the program has stopped since then."""
        self.leads_across = False
        """Whether a line leads across the contour to where the next element begins."""
        if rules.assumed:
            control.findings.assumed(rules.assumed)

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary). Raises ProgramError."""
        if start[3:] != end[3:]:
            self.fail("a rotary axis turns under cutter compensation, which is not read: let the CAM system compensate")
        if rate.time:
            self.fail("a time of a block (G93) under cutter compensation is not read: write a feed a minute")
        path = self.element(start, end, arc)
        if path is None or (arc is None and abs(path.end - path.start) < SAME):
            if self.leads_across and self.rules.shifts:
                self.fail(f"a motion {ACROSS_ALONE}")
            self.waiting.append(self.add(self.at, start, end, None, rate, kind))
            self.idle += self.last is not None or self.entering is not None
        elif self.last is None and self.entering is None and not self.leads_across:
            self._enter(path, start, end, rate, kind)
        else:
            self._follow(path, start, end, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """The last element, a line, ends earlier: its corner was cut or rounded by the program."""
        point = self.point(end)
        if self.entering is not None:
            self.entering = replace(self.entering, end=point)
            self._shift_ends(point)
        elif self.last is not None:
            element = replace(self.last.element, end=point)
            way = self._way(element)
            self.last = replace(self.last, element=element, way=way)
            self._shift_ends(way.end)

    def other_motion(self, what: str) -> None:
        """ProgramError: what it does to the offset is not sure."""
        self.fail(f"{what} under cutter compensation is not read: end the compensation before it")

    def pause(self) -> None:
        """The contour ends here, or the program. Raises ProgramError where its last element was a gouge."""
        last, was_paused, self.paused = self.last, self.paused, True
        if last is None or was_paused:
            return
        if gone(last.way, last.begins, last.way.end) < -ROUNDED:
            self.refuse_gouge()
        self.see(between(last.way, last.begins, last.way.end))

    def behind_block(self, moved: bool) -> None:
        """A block of the program has ended, with or without a motion."""
        begun = self.last is not None or self.entering is not None
        if not moved:
            self.idle += begun
            self.leads_across = self.leads_across or (self.rules.shifts and not begun)
        elif not begun and self.rules.shifts and not self.leads_across:
            self.fail(f"compensation begins beside a motion {ACROSS_ALONE}")

    def resume(self, at: complex) -> None:
        """Compensation goes on behind a suppression, from a point of the plane."""
        self.at, self.last, self.waiting, self.leads_across = at, None, [], True
        self.idle, self.paused = 0, False

    # The ends of the contour

    def begin_across(self, along: complex) -> None:
        """The centre stands across the beginning of the contour, at the program's point, and goes along there."""
        corner = self.point(self.control.words)
        self.entering = Line(corner - along, corner)

    def _enter(self, path: Element, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        if not isinstance(path, Line):
            self.fail(BEGINS_STRAIGHT)
        self.entering, self.paused = path, False
        begun = self.at
        self.wait(self.add(path.end, start, end, Line(begun, path.end), rate, kind), begun)

    def _arrive(
        self, entering: Line, path: Element, way: Element, start: list[float], words: list[float], rate: Rate,
        kind: float,
    ) -> None:  # fmt: skip
        """Go from the line that enters to where the first element begins."""
        corner = path.start
        turned = -self.side * turning(entering.begins, path.begins)
        if self.rules.ends == TOUCHING and is_behind(self.begun, corner, path.begins, self.side):
            along = self.touching(corner - self.begun, 1)
            line = Line(self.begun, corner + self.radius * 1j * self.side * along)
            came = Followed(Line(corner - along, corner), line, self.begun)
            self.go_round(came, path, way, turning_away(along, path.begins, self.side), start, words, rate, kind)
        elif self.rules.ends == AROUND and turned > TANGENT:
            self.round_in_lines(Followed(entering, entering, self.begun), path, way, start, words, rate, kind)
        else:
            self.finish(way.start)

    def touching(self, way: complex, sense: int) -> complex:
        """Direction of the line that touches the circle about a contour's end, by the way to it (sense 1) or from (-1).

        Raises ProgramError where that is shorter than the radius.
        """
        if abs(way) <= self.radius:
            self.fail("the place beside the contour lies within the tool's radius of its end: go farther away")
        return unit(way) * cmath.exp(1j * sense * self.side * math.asin(self.radius / abs(way)))

    # Corners

    def _follow(self, path: Element, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        if self.idle > self.rules.most_idle:
            self.fail(
                f"{self.idle} blocks before this one move nothing in the plane of the compensation, and the control "
                f"looks over {self.rules.most_idle} of them: write them elsewhere"
            )
        if self.paused:
            self.fail("M0 or M1 stands before this element, and the control does not look over it: move it elsewhere")
        way = self._way(path)
        words = self.at_corner(start, end)
        if self.entering is not None:
            self._arrive(self.entering, path, way, start, words, rate, kind)
            self.entering = None
        elif self.leads_across:
            if self.rules.shifts and not isinstance(path, Line):
                self.fail(BEGINS_STRAIGHT)
            self.lines([way.start], start, words, rate, kind)
            self.leads_across = False
        else:
            assert self.last is not None
            self.corner(self.last, path, way, start, words, rate, kind)
        begun = self.at
        laid = self.add(way.end, start, end, between(way, begun, way.end), self._rate(path, rate), kind)
        self.wait(laid, begun)
        self.last, self.idle, self.speed = Followed(path, way, begun), 0, (rate, kind)

    def _way(self, path: Element) -> Element:
        found = offset(path, self.side * self.radius)
        if found is None:
            assert isinstance(path, Turn)
            self.fail(
                f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into this arc of radius "
                f"{path.radius * 1e3:.6g} mm, and {self.rules.gouge}: take a smaller tool, or write a larger arc"
            )
        return found

    def trimmed(self, laid: Laid, end: complex) -> Element | None:
        """The motion that waits, to another end."""
        if laid.path is None:
            return None
        if isinstance(laid.path, Line) or self.last is None:
            return Line(self.begun, end)
        return between(self.last.way, self.begun, end)

    def _shift_ends(self, end: complex) -> None:
        """Move the ends of what waits, and let it wait on."""
        waiting = self.waiting
        self.move_end(end)
        self.waiting = waiting

    def _rate(self, path: Element, rate: Rate) -> Rate:
        """Speed of the centre on an element."""
        return rate._replace(speed=rate.speed * self.rules.share_of_feed(path, self.side, self.radius))

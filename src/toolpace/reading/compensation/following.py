"""Compensation that looks one element ahead: corners by the rules of a control."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from typing import NoReturn

from toolpace.reading.compensation.elements import SAME, Element, Line, Turn, is_behind, turning, turning_away, unit
from toolpace.reading.compensation.meetings import beyond, gone, meetings, offset, swept_between
from toolpace.reading.compensation.rules import ARC, AROUND, MEETING, TOUCHING, Rules
from toolpace.reading.compensation.stage import Laid, OffsetStage
from toolpace.reading.control.control import Control
from toolpace.reading.control.moves import Rate
from toolpace.reading.curves.arcs import Arc

TANGENT = 2e-3
"""Turn of a corner that is none [rad]: the way is shifted along itself, and beside itself by 5e-7 of the radius."""
BACK = math.radians(179.0)
"""Turn from which on a contour goes back on itself."""
ROUNDED = 2e-6
"""How far a way may go back before it is a gouge [m]: programs are rounded."""


@dataclass(frozen=True)
class Followed:
    """An element of the program and its offset way."""

    element: Element
    way: Element
    begins: complex
    """Where the centre's way along it begins."""


class Follower(OffsetStage):
    """The stage between the words that begin and end a compensation."""

    def __init__(self, control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
        super().__init__(control, side, radius, plane)
        self.at = self.begun = self.point(control.reached())
        self.rules = rules
        self.last: Followed | None = None
        self.entering: Line | None = None
        """The motion that leads to the contour, until the contour is there."""
        self.idle = 0
        """Blocks since the last element that moved nothing in the plane."""
        self.paused = False
        """Whether the program has stopped since then."""
        self.resumes = False
        """Whether a line leads to the next element, behind a suppression."""
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
            self.waiting.append(self.add(self.at, start, end, None, rate, kind))
            self.idle += self.last is not None or self.entering is not None
        elif self.last is None and self.entering is None and not self.resumes:
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
        self.paused = True
        if self.last is not None and gone(self.last.way, self.last.begins, self.last.way.end) < -ROUNDED:
            self._refuse_gouge()

    def idle_block(self) -> None:
        """A block that has moved nothing."""
        self.idle += self.last is not None or self.entering is not None

    def resume(self, at: complex) -> None:
        """Compensation goes on behind a suppression, from a point of the plane."""
        self.at, self.last, self.waiting, self.resumes = at, None, [], True
        self.idle, self.paused = 0, False

    # The ends of the contour

    def begin_across(self, along: complex) -> None:
        """The centre stands across the beginning of the contour, at the program's point, and goes along there."""
        corner = self.point(self.control.words)
        self.entering = Line(corner - along, corner)

    def _enter(self, path: Element, start: list[float], end: list[float], rate: Rate, kind: float) -> None:
        if not isinstance(path, Line):
            self.fail("compensation begins with a straight motion, and this is an arc: write a line before it")
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
        elif self.resumes:
            self.lines([way.start], start, words, rate, kind)
            self.resumes = False
        else:
            assert self.last is not None
            self._corner(self.last, path, way, start, words, rate, kind)
        begun = self.at
        laid = self.add(way.end, start, end, self._between(way, begun, way.end), self._rate(path, rate), kind)
        self.wait(laid, begun)
        self.last, self.idle = Followed(path, way, begun), 0

    def _corner(
        self, last: Followed, path: Element, way: Element, start: list[float], words: list[float], rate: Rate,
        kind: float,
    ) -> None:  # fmt: skip
        corner = path.start
        turned = self.side * turning(last.element.ends, path.begins)
        if abs(turned) <= TANGENT:
            aside = unit(last.element.ends + path.begins) * 1j * self.side
            self.finish(corner + self.radius * aside)
        elif abs(turned) > BACK:
            self.fail("the contour goes back on itself at the corner before this block: write an arc or a line between")
        elif turned > 0.0:
            self.finish(self._inside(last.way, way, corner))
        else:
            self.go_round(last, path, way, -turned, start, words, rate, kind)

    def _inside(self, before: Element, behind: Element, corner: complex) -> complex:
        """The point next to an inside corner where two ways meet, which both are cut back to. Raises ProgramError."""
        found = [
            point for point in meetings(before, behind)
            if min(gone(behind, behind.start, point), gone(before, point, before.end)) >= -ROUNDED
        ]  # fmt: skip
        if not found:
            self._refuse_gouge()
        return min(found, key=lambda point: abs(point - corner))

    def go_round(
        self, last: Followed, path: Element, way: Element, turned: float, start: list[float], words: list[float],
        rate: Rate, kind: float,
    ) -> None:  # fmt: skip
        """Go round an outside corner that turns by so much [rad]."""
        corner = path.start
        by = self._by(turned)
        if by == ARC:
            self.finish(last.way.end)
            turn = Turn(last.way.end, way.start, corner, -self.side * turned)
            self.add(way.start, start, words, turn, rate, kind)
        elif by == MEETING:
            near = corner + self.radius * unit(last.element.ends + path.begins) * 1j * self.side
            found = meetings(last.way, way)
            if not found:
                self.fail("the ways beside this outside corner do not meet: write a rounder corner, or one of lines")
            self.finish(min(found, key=lambda point: abs(point - near)))
        else:
            self.round_in_lines(last, path, way, start, words, rate, kind)

    def round_in_lines(
        self, last: Followed, path: Element, way: Element, start: list[float], words: list[float], rate: Rate,
        kind: float,
    ) -> None:  # fmt: skip
        """Go round an outside corner by the tangents of both ways; lines lead from an arc and to it."""
        points = beyond(path.start, last.element.ends, path.begins, self.side * self.radius)
        points = points if isinstance(last.element, Line) else [last.way.end, *points]
        points = points if isinstance(path, Line) else [*points, way.start]
        if self.idle and len(points) > 1:
            self.fail(
                "a block that moves nothing in the plane stands at an outside corner that the control goes round "
                "in several lines: write it elsewhere"
            )
        self.finish(points[0])
        self.lines(points[1:], start, words, rate, kind)

    def _by(self, turned: float) -> str:
        """How an outside corner that turns by so much [rad] is gone round."""
        rules = self.rules
        if rules.outside == ARC and turned <= rules.slight:
            self.control.findings.assumed(rules.said_of_limits)
            return MEETING
        if rules.outside == MEETING and turned > rules.most_met:
            self.control.findings.assumed(rules.said_of_limits)
            return ARC
        return rules.outside

    # Motions

    def lines(self, points: list[complex], start: list[float], words: list[float], rate: Rate, kind: float) -> None:
        for point in points:
            self.add(point, start, words, Line(self.at, point), rate, kind)

    def at_corner(self, start: list[float], end: list[float]) -> list[float]:
        """Words at a corner: across the plane the block begins behind it."""
        words = list(end)
        normal = 3 - self.first - self.second
        words[normal] = start[normal]
        return words

    def finish(self, end: complex) -> None:
        """Settle the end of the last element. Raises ProgramError where its way would go backwards."""
        last = self.last
        if last is not None and self.entering is None and gone(last.way, last.begins, end) < -ROUNDED:
            self._refuse_gouge()
        self.move_end(end)

    def _refuse_gouge(self) -> NoReturn:
        self.fail(
            f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into the contour before this block, and "
            f"{self.rules.gouge}: take a smaller tool, or write a rounder or longer contour"
        )

    def _way(self, path: Element) -> Element:
        found = offset(path, self.side * self.radius)
        if found is None:
            assert isinstance(path, Turn)
            self.fail(
                f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into this arc of radius "
                f"{path.radius * 1e3:.6g} mm, and {self.rules.gouge}: take a smaller tool, or write a larger arc"
            )
        return found

    def _between(self, way: Element, begun: complex, end: complex) -> Element:
        """The part of an offset way from point to point."""
        if isinstance(way, Line):
            return Line(begun, end)
        angle = swept_between(way, begun, end)
        return Turn(begun, end, way.centre, way.sense * angle) if angle > SAME else Line(begun, end)

    def trimmed(self, laid: Laid, end: complex) -> Element | None:
        """The motion that waits, to another end."""
        if laid.path is None:
            return None
        if isinstance(laid.path, Line) or self.last is None:
            return Line(self.begun, end)
        return self._between(self.last.way, self.begun, end)

    def _shift_ends(self, end: complex) -> None:
        """Move the ends of what waits, and let it wait on."""
        waiting = self.waiting
        self.move_end(end)
        self.waiting = waiting

    def _rate(self, path: Element, rate: Rate) -> Rate:
        """Speed of the centre on an element."""
        return rate._replace(speed=rate.speed * self.rules.share_of_feed(path, self.side, self.radius))

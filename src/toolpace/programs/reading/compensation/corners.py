"""Corners of a contour, by the rules of a control."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NoReturn

from toolpace.programs.reading.compensation.crossings import crosses
from toolpace.programs.reading.compensation.elements import Element, Line, Turn, turning, unit
from toolpace.programs.reading.compensation.meetings import between, beyond, gone, meetings
from toolpace.programs.reading.compensation.rules import ARC, MEETING, Rules
from toolpace.programs.reading.compensation.stage import OffsetStage
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import Rate

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


class Corners(OffsetStage):
    """Goes from the way beside one element to that beside the next."""

    def __init__(self, control: Control, side: int, radius: float, plane: int, rules: Rules) -> None:
        super().__init__(control, side, radius, plane)
        self.rules = rules
        self.last: Followed | None = None
        """The last element, whose end waits; None before the first."""
        self.idle = 0
        """Blocks since the last element that moved nothing in the plane."""
        self.pieces: list[Element] = []
        """Of the way so far, where the control looks whether it crosses itself."""

    def corner(
        self, last: Followed, path: Element, way: Element, start: list[float], words: list[float], rate: Rate,
        kind: float,
    ) -> None:  # fmt: skip
        """Go from the last element's way to that of the next. Raises ProgramError where the tool does not fit."""
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
            self.refuse_gouge()
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
            self.see(turn)
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

    def lines(self, points: list[complex], start: list[float], words: list[float], rate: Rate, kind: float) -> None:
        """Lay lines of the centre from where it is to points of the plane."""
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
        if last is not None and gone(last.way, last.begins, end) < -ROUNDED:
            self.refuse_gouge()
        if last is not None:
            self.see(between(last.way, last.begins, end))
        self.move_end(end)

    def see(self, piece: Element) -> None:
        """A piece of the way is settled. Raises ProgramError where it crosses one that the control looks at."""
        most = self.rules.looks_ahead
        if not most:
            return
        if any(crosses(piece, other) for other in self.pieces[-most:]):
            self.fail(
                f"the way of the tool's centre crosses itself within {most} elements, and the control, which looks "
                "ahead, leaves out what lies between: take a smaller tool, or end looking ahead before this contour"
            )
        self.pieces.append(piece)

    def refuse_gouge(self) -> NoReturn:
        self.fail(
            f"the tool of radius {self.radius * 1e3:.6g} mm does not fit into the contour before this block, and "
            f"{self.rules.gouge}: take a smaller tool, or write a rounder or longer contour"
        )

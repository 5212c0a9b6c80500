"""Corners of a compensated way, from the intersections of offset elements."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import NoReturn

from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.compensation.elements import Element, Line, Turn, swept, turning, unit
from toolpace.programs.reading.compensation.stage import ARC, MEETING, OffsetStage, Rules
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import Rate

TANGENT = 2e-3
"""Turn of a corner that is none [rad]: the way is shifted along itself, and beside itself by 5e-7 of the radius."""
BACK = math.radians(179.0)
"""Turn from which on a contour goes back on itself."""
ROUNDED = 2e-6
"""How far a way may go back before it is a gouge [m]: programs are rounded."""
AT_END = 1e-6
"""Within which of the end of a piece it is met, and not crossed [m]."""
TOUCHING = 1e-3
"""Sine of the angle below which two pieces touch, and do not cross."""


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


def offset(element: Element, aside: float) -> Element | None:
    """The way at a distance to the left [m], below zero to the right; None where an arc has no room for it."""
    if isinstance(element, Line):
        shift = 1j * element.begins * aside
        return Line(element.start + shift, element.end + shift)
    radii = [abs(end - element.centre) - element.sense * aside for end in (element.start, element.end)]
    if min(radii) < ROUNDING:
        return None
    start, end = (
        element.centre + radius * (point - element.centre) / abs(point - element.centre)
        for radius, point in zip(radii, (element.start, element.end))
    )
    return Turn(start, end, element.centre, element.sweep)


def meetings(before: Element, behind: Element) -> list[complex]:
    """The points in which two ways meet, as lines and circles without ends."""
    if isinstance(before, Line):
        return _lines(before, behind) if isinstance(behind, Line) else _line_and_circle(before, behind)
    if isinstance(behind, Line):
        return _line_and_circle(behind, before)
    return _circles(before.centre, before.radius, behind.centre, behind.radius)


def _lines(first: Line, second: Line) -> list[complex]:
    across = (first.begins.conjugate() * second.begins).imag
    if abs(across) < ROUNDING:
        return []
    along = ((second.start - first.start).conjugate() * second.begins).imag / across
    return [first.start + along * first.begins]


def _line_and_circle(line: Line, turn: Turn) -> list[complex]:
    foot = line.start + ((turn.centre - line.start) * line.begins.conjugate()).real * line.begins
    reach = _half_chord(turn.radius, abs(turn.centre - foot))
    return [] if reach is None else [foot - reach * line.begins, foot + reach * line.begins]


def _circles(centre: complex, radius: float, other: complex, other_radius: float) -> list[complex]:
    apart = abs(other - centre)
    if apart < ROUNDING:
        return []
    direction = (other - centre) / apart
    along = (apart * apart + radius * radius - other_radius * other_radius) / (2.0 * apart)
    reach = _half_chord(radius, abs(along))
    return [] if reach is None else [centre + direction * complex(along, side * reach) for side in (-1.0, 1.0)]


def _half_chord(radius: float, distance: float) -> float | None:
    """Half of the chord at a distance from the centre of a circle; of a touching line, but for a rounding, 0."""
    square = (radius - distance) * (radius + distance)
    if square < -2.0 * radius * ROUNDING:
        return None
    return math.sqrt(max(square, 0.0))


def beyond(corner: complex, before: complex, behind: complex, aside: float) -> list[complex]:
    """Where tangents of two offset ways meet beyond an outside corner; two points where that is farther than the
    radius.

    before, behind: unit directions at the corner. aside: distance to the left [m], below zero to the right.
    """
    first, second = corner + 1j * aside * before, corner + 1j * aside * behind
    radius, turned = abs(aside), abs(cmath.phase(behind * before.conjugate()))
    farther = radius * math.tan(0.5 * turned)
    if farther > radius * (1.0 + 1e-9):
        return [first + radius * before, second - radius * behind]
    return [first + farther * before]


def gone(way: Element, start: complex, end: complex) -> float:
    """Length from point to point along a way [m], below zero backwards; of an arc less than half a turn either way of
    its own ends."""
    if isinstance(way, Line):
        return ((end - start) * way.begins.conjugate()).real
    return way.radius * swept_between(way, start, end)


def swept_between(way: Turn, start: complex, end: complex) -> float:
    """Angle in an arc's sense from one point near its start to another near its end [rad]."""
    cut = way.sense * cmath.phase((start - way.centre) / (way.start - way.centre))
    left = way.sense * cmath.phase((way.end - way.centre) / (end - way.centre))
    return abs(way.sweep) - cut - left


def between(way: Element, begun: complex, end: complex) -> Element:
    """The part of an offset way from point to point."""
    if isinstance(way, Line):
        return Line(begun, end)
    angle = swept_between(way, begun, end)
    return Turn(begun, end, way.centre, way.sense * angle) if angle > ROUNDING else Line(begun, end)


def crosses(first: Element, second: Element) -> bool:
    """Whether two pieces of a way cross under an angle, or one ends on the other; ends that meet are no crossing."""
    for point in meetings(first, second):
        angle = (_along(first, point).conjugate() * _along(second, point)).imag
        depths = _depth(first, point), _depth(second, point)
        if abs(angle) > TOUCHING and max(depths) > AT_END and min(depths) > -AT_END:
            return True
    return False


def _along(piece: Element, point: complex) -> complex:
    """Unit direction of a piece at one of its points."""
    if isinstance(piece, Line):
        return piece.begins
    spoke = point - piece.centre
    return 1j * piece.sense * spoke / abs(spoke)


def _depth(piece: Element, point: complex) -> float:
    """How far from the nearer end of a piece a point of its line or circle is [m], below zero beyond it."""
    if isinstance(piece, Line):
        gone, length = ((point - piece.start) * piece.begins.conjugate()).real, abs(piece.end - piece.start)
    else:
        angle = abs(swept(piece.start - piece.centre, point - piece.centre, piece.sense))
        gone, length = piece.radius * angle, piece.radius * min(abs(piece.sweep), 2.0 * math.pi)
        gone = 0.0 if abs(point - piece.start) < AT_END else gone
    return min(gone, length - gone)

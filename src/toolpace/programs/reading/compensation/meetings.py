"""Intersections of the offset curves of two elements."""

from __future__ import annotations

import cmath
import math

from toolpace.programs.reading.compensation.elements import SAME, Element, Line, Turn


def offset(element: Element, aside: float) -> Element | None:
    """The way at a distance to the left [m], below zero to the right; None where an arc has no room for it."""
    if isinstance(element, Line):
        shift = 1j * element.begins * aside
        return Line(element.start + shift, element.end + shift)
    radii = [abs(end - element.centre) - element.sense * aside for end in (element.start, element.end)]
    if min(radii) < SAME:
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
    if abs(across) < SAME:
        return []
    along = ((second.start - first.start).conjugate() * second.begins).imag / across
    return [first.start + along * first.begins]


def _line_and_circle(line: Line, turn: Turn) -> list[complex]:
    foot = line.start + ((turn.centre - line.start) * line.begins.conjugate()).real * line.begins
    reach = _half_chord(turn.radius, abs(turn.centre - foot))
    return [] if reach is None else [foot - reach * line.begins, foot + reach * line.begins]


def _circles(centre: complex, radius: float, other: complex, other_radius: float) -> list[complex]:
    apart = abs(other - centre)
    if apart < SAME:
        return []
    direction = (other - centre) / apart
    along = (apart * apart + radius * radius - other_radius * other_radius) / (2.0 * apart)
    reach = _half_chord(radius, abs(along))
    return [] if reach is None else [centre + direction * complex(along, side * reach) for side in (-1.0, 1.0)]


def _half_chord(radius: float, distance: float) -> float | None:
    """Half of the chord at a distance from the centre of a circle; of a touching line, but for a rounding, 0."""
    square = (radius - distance) * (radius + distance)
    if square < -2.0 * radius * SAME:
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
    return Turn(begun, end, way.centre, way.sense * angle) if angle > SAME else Line(begun, end)

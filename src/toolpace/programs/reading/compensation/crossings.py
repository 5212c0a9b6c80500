"""Where the way of the centre crosses itself, which controls that look ahead do not go along."""

from __future__ import annotations

import math

from toolpace.programs.reading.compensation.elements import Element, Line, swept
from toolpace.programs.reading.compensation.meetings import meetings

AT_END = 1e-6
"""Within which of the end of a piece it is met, and not crossed [m]."""
TOUCHING = 1e-3
"""Sine of the angle below which two pieces touch, and do not cross."""


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

"""Contour elements in a plane: lines and arcs, points as complex numbers [m]."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from toolpace.programs.reading.arcs import ONE_RAY, PLANE_AXES, ROUNDING, Arc


@dataclass(frozen=True)
class Line:
    """A straight element."""

    start: complex
    end: complex

    @property
    def begins(self) -> complex:
        """Unit direction at its start."""
        return unit(self.end - self.start)

    @property
    def ends(self) -> complex:
        """Unit direction at its end."""
        return self.begins


@dataclass(frozen=True)
class Turn:
    """A circular arc; it may make whole turns more than once."""

    start: complex
    end: complex
    centre: complex
    sweep: float
    """[rad], counter-clockwise above zero."""

    @property
    def sense(self) -> int:
        """1 counter-clockwise, -1 clockwise."""
        return 1 if self.sweep > 0.0 else -1

    @property
    def radius(self) -> float:
        """At its end [m]."""
        return abs(self.end - self.centre)

    @property
    def begins(self) -> complex:
        """Unit direction at its start."""
        return unit(self.start - self.centre) * 1j * self.sense

    @property
    def ends(self) -> complex:
        """Unit direction at its end."""
        return unit(self.end - self.centre) * 1j * self.sense

    def holds(self, side: int) -> bool:
        """Whether what goes at this side of it (1 left, -1 right) is within its circle."""
        return side == self.sense

    def between(self, start: complex, end: complex) -> Turn:
        """An arc about the same centre in the same sense, with as many whole turns, from point to point."""
        whole = math.ceil(abs(self.sweep) / (2.0 * math.pi) - ONE_RAY) - 1
        return Turn(start, end, self.centre, swept(start - self.centre, end - self.centre, self.sense, whole))


Element = Line | Turn


def unit(vector: complex) -> complex:
    """The direction of a vector; zero of none."""
    length = abs(vector)
    return vector / length if length > 0.0 else 0j


def swept(begin: complex, end: complex, sense: int, whole: int = 0) -> float:
    """Angle from one spoke to another in a sense [rad], and whole turns more; spokes on one ray make a full turn."""
    angle = sense * cmath.phase(end / begin) % (2.0 * math.pi)
    angle = angle if angle > ONE_RAY else 2.0 * math.pi
    return sense * (angle + 2.0 * math.pi * whole)


def turning(before: complex, behind: complex) -> float:
    """Angle from a direction to another, to the left above zero [rad]."""
    return cmath.phase(behind * before.conjugate())


def turning_away(before: complex, behind: complex, side: int) -> float:
    """Angle from a direction to another, away from a side (1 left, -1 right), up to a whole turn [rad]."""
    return -side * turning(before, behind) % (2.0 * math.pi)


def is_behind(place: complex, end: complex, along: complex, side: int) -> bool:
    """Whether a place is not at this side (1 left, -1 right) of the tangent `along` at the end of an element."""
    return ((place - end) * (1j * side * along).conjugate()).real < -ROUNDING


def element_of(start: list[float], end: list[float], arc: Arc | None, plane: int) -> Element | None:
    """The element of a motion in a plane; None where nothing moves in it, or where an arc lies in another plane."""
    first, second = PLANE_AXES[plane]
    a, b = complex(start[first], start[second]), complex(end[first], end[second])
    if arc is None:
        return Line(a, b) if a != b else None
    u, w = complex(arc.u[first], arc.u[second]), complex(arc.w[first], arc.w[second])
    if abs(abs(u) - 1.0) > ROUNDING or abs(abs(w) - 1.0) > ROUNDING:
        return None
    left = (u.conjugate() * w).imag > 0.0
    return Turn(a, b, complex(arc.centre[first], arc.centre[second]), arc.sweep if left else -arc.sweep)


def arc_of(turn: Turn, start: list[float], end: list[float], plane: int) -> Arc:
    """The arc in space between words (3 + rotary) whose plane coordinates are the ends of a turn.

    Radii that differ between the ends make a spiral.
    """
    first, second = PLANE_AXES[plane]
    normal = 3 - first - second
    a, b = turn.start - turn.centre, turn.end - turn.centre
    spoke = a / abs(a)
    across = spoke * 1j * turn.sense
    centre, u, w, rise = [0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3
    for vector, value in ((centre, turn.centre), (u, spoke), (w, across)):
        vector[first], vector[second] = value.real, value.imag
    centre[normal], rise[normal] = start[normal], end[normal] - start[normal]
    return Arc(_three(centre), _three(u), _three(w), abs(a), abs(b), abs(turn.sweep), _three(rise))


def _three(values: list[float]) -> tuple[float, float, float]:
    return values[0], values[1], values[2]

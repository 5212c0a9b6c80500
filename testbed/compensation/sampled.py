"""The way of the centre along a contour, found by sampling distances, and by bisection: no geometry of the reader.

At an inside corner both elements are cut back to where the tool, on its way beside one, first keeps its radius from
the other. At an outside one the rules of the control are written out.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from testbed.compensation.contours import TURN, Contour, Element, R

SAMPLES = 1500
KEPT = 1e-7
"""By what a distance may be less than the radius [mm]."""
NO_CORNER, BACK = 2e-3, math.radians(179.0)
CHORD = 1e-4
"""How far an arc is from the chords that it is laid in [mm]."""


class NoFitError(Exception):
    """The tool does not fit, or the control's rules say nothing."""


@dataclass(frozen=True)
class Rule:
    """Of outside corners and of the beginning and the end."""

    outside: str
    """"arcs", "met", or "lines": Fanuc's, up to a right angle met, beyond by the radius along both tangents."""
    slight: float = 0.0
    """Turn up to which arcs are left out [rad]."""
    most_met: float = math.pi
    """Turn from which on there are arcs all the same [rad]."""
    around: bool = False
    """Whether the beginning and the end go round as corners do (type B)."""


def way(contour: Contour, rule: Rule) -> np.ndarray:
    """Places (n,) of the centre, from the entry to the place that it leaves to. Raises NoFitError."""
    elements, side = contour.elements, contour.side
    for element in elements:
        if element.centre is not None and abs(element.start - element.centre) <= element.sense * side * R + 1e-6:
            raise NoFitError("an arc has no room")
    begins, ends = [0.0] * len(elements), [1.0] * len(elements)
    between: list[list[complex]] = [[] for _ in elements]
    for k, (before, behind) in enumerate(pairwise(elements)):
        turned = side * cmath.phase(_direction(behind, 0.0) / _direction(before, 1.0))
        if abs(turned) > BACK:
            raise NoFitError("the contour goes back on itself")
        if turned > NO_CORNER:
            ends[k], begins[k + 1] = _inside(before, behind, side)
        elif turned < -NO_CORNER:
            ends[k], begins[k + 1], between[k] = _outside(before, behind, side, -turned, rule)
    if any(end < begin - KEPT for begin, end in zip(begins, ends)):
        raise NoFitError("an element would go backwards")
    found = [np.array([contour.entry])]
    if rule.around:
        first = elements[0]
        along = (first.start - contour.entry) / abs(first.start - contour.entry)
        found.append(np.array(_tangents(first.start, along, _direction(first, 0.0), side), dtype=complex))
    for k, element in enumerate(elements):
        found += [_laid(element, begins[k], ends[k], side), np.array(between[k], dtype=complex)]
    if rule.around:
        last = elements[-1]
        along = (contour.away - last.end) / abs(contour.away - last.end)
        found.append(np.array(_tangents(last.end, _direction(last, 1.0), along, side), dtype=complex))
    return np.concatenate([*found, [contour.away]])


def _direction(element: Element, share: float) -> complex:
    return complex(element.along(np.array([share]))[0])


def _place(element: Element, share: float, side: int) -> complex:
    return complex(element.beside(np.array([share]), side)[0])


def _laid(element: Element, begin: float, end: float, side: int) -> np.ndarray:
    """Points along a part of the way beside an element."""
    pieces = 1
    if element.centre is not None:
        radius = abs(_place(element, 0.0, side) - element.centre)
        pieces += int(element.sweep * abs(end - begin) / math.sqrt(8.0 * CHORD / max(radius, 1e-3)))
    return element.beside(np.linspace(begin, end, pieces + 1), side)


def _inside(before: Element, behind: Element, side: int) -> tuple[float, float]:
    """Shares of both at which they are cut back."""

    def first_clear(of: Element, other: Element, backwards: bool) -> float:
        def share(step: np.ndarray) -> np.ndarray:
            return 1.0 - step if backwards else step

        def clear(step: np.ndarray) -> np.ndarray:
            return other.distance(of.beside(share(step), side)) >= R - KEPT

        steps = np.linspace(0.0, 1.0, SAMPLES + 1)
        is_clear = clear(steps)
        if not is_clear.any():
            raise NoFitError("an inside corner takes a whole element away")
        k = int(np.argmax(is_clear))
        low, high = steps[max(k - 1, 0)], steps[k]
        return float(share(np.array(_bisected(lambda step: bool(clear(np.array([step]))[0]), low, high))))

    end, begin = first_clear(before, behind, True), first_clear(behind, before, False)
    if abs(_place(before, end, side) - _place(behind, begin, side)) > 2e-3:
        raise NoFitError("the ways are cut back to two places")
    return end, begin


def _bisected(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Where what does not hold at a figure, and holds at another, begins to."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def _outside(
    before: Element, behind: Element, side: int, turned: float, rule: Rule
) -> tuple[float, float, list[complex]]:
    """Shares of both where they end and begin, and the points between them."""
    corner, along, onward = behind.start, _direction(before, 1.0), _direction(behind, 0.0)
    if rule.outside == "lines":
        return 1.0, 0.0, _tangents(corner, along, onward, side)
    by_arc = turned > rule.slight if rule.outside == "arcs" else turned > rule.most_met
    if by_arc:
        spoke = 1j * side * R * along
        return 1.0, 0.0, [corner + spoke * cmath.exp(-1j * side * turned * k / 60) for k in range(61)]
    if before.centre is None and behind.centre is None:
        return 1.0, 0.0, [corner + 1j * side * R * along + R * math.tan(0.5 * turned) * along]
    return *_met(before, behind, side), []


def _tangents(corner: complex, along: complex, onward: complex, side: int) -> list[complex]:
    """Points of lines that go on beside a corner, by the radius at most; none where it is no outside one."""
    turned = -side * cmath.phase(onward / along)
    if turned <= NO_CORNER:
        return []
    first, second = corner + 1j * side * R * along, corner + 1j * side * R * onward
    beyond = R * math.tan(0.5 * turned)
    return [first + beyond * along] if beyond <= R * (1.0 + 1e-9) else [first + R * along, second - R * onward]


def _met(before: Element, behind: Element, side: int) -> tuple[float, float]:
    """Shares beyond the ends of both, where their ways meet as whole lines and circles."""

    def aside(of: Element, share: np.ndarray, other: Element) -> np.ndarray:
        places = of.beside(share, side)
        if other.centre is None:
            return ((places - _place(other, 0.0, side)) / _direction(other, 0.0)).imag
        return np.abs(places - other.centre) - abs(_place(other, 0.0, side) - other.centre)

    def first(of: Element, other: Element, begin: float, sense: float) -> float:
        reach = TURN / of.sweep if of.centre is not None else 60.0 * R / of.length
        shares = begin + sense * np.linspace(1e-9, 1.0, 6000) * reach
        values = aside(of, shares, other)
        changes = np.flatnonzero(np.signbit(values[1:]) != np.signbit(values[:-1]))
        if not len(changes):
            raise NoFitError("the ways do not meet")
        k = int(changes[0])
        was = bool(np.signbit(values[k]))
        return _bisected(
            lambda share: bool(np.signbit(aside(of, np.array([share]), other)[0])) != was,
            float(shares[k]), float(shares[k + 1]),
        )  # fmt: skip

    end, begin = first(before, behind, 1.0, 1.0), first(behind, before, 0.0, -1.0)
    if abs(_place(before, end, side) - _place(behind, begin, side)) > 2e-3:
        raise NoFitError("the ways meet at two places")
    return end, begin


def apart(first: np.ndarray, second: np.ndarray) -> float:
    """The farthest that a point of one way is from the chords of the other [mm]."""
    return max(_farthest(first, second), _farthest(second, first))


def _farthest(points: np.ndarray, line: np.ndarray) -> float:
    starts, ways = line[:-1], np.diff(line)
    lengths = np.maximum(np.abs(ways) ** 2, 1e-30)
    share = np.clip(((points[:, None] - starts) * ways.conj()).real / lengths, 0.0, 1.0)
    return float(np.abs(points[:, None] - starts - share * ways).min(axis=1).max())

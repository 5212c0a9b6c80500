"""Rows, circles and grids of holes: HOLES1, HOLES2, CYCLE801 (Programming Manual Cycles, 2.3)."""

from __future__ import annotations

import math
from collections.abc import Iterator

from toolpace.reading.control.control import Control
from toolpace.reading.sinumerik.given import Arguments
from toolpace.reading.sinumerik.state import State
from toolpace.reading.sinumerik.syntax.values import Unread, Value, ValueFault
from toolpace.units import DEGREE

MOST = 10_000
"""Holes of a pattern."""


def places(name: str, values: list[Value | None], control: Control, state: State) -> Iterator[list[float]]:
    """Words (3 + rotary) of the holes of a pattern, in their order; each as high as the one before was left."""
    arguments = Arguments(name, values, 16)
    points = {"HOLES1": _row, "HOLES2": _circle, "CYCLE801": _grid}[name](arguments)
    first, second = ((0, 1), (2, 0), (1, 2))[state.plane]
    for a, b in points:
        words = list(control.words)
        words[first], words[second] = a * state.unit, b * state.unit
        yield words


def _count(arguments: Arguments, place: int) -> int:
    count = arguments.code(place)
    if not 1 <= count <= MOST:
        raise ValueFault(f"{arguments.name} needs the number of its holes, from 1 to {MOST}, as argument {place + 1}")
    return count


def _row(arguments: Arguments) -> list[tuple[float, float]]:
    """SPCA, SPCO, STA1, FDIS, DBH, NUM: reference, angle, distance of the first, of the others, number."""
    a, b = arguments.number(0), arguments.number(1)
    angle, first, step = arguments.number(2) * DEGREE, arguments.number(3), arguments.number(4)
    along = [first + step * k for k in range(_count(arguments, 5))]
    return [(a + d * math.cos(angle), b + d * math.sin(angle)) for d in along]


def _circle(arguments: Arguments) -> list[tuple[float, float]]:
    """CPA, CPO, RAD, STA1, INDA, NUM: centre, radius, first angle, step (0: evenly round), number."""
    a, b, radius = arguments.number(0), arguments.number(1), arguments.number(2)
    count = _count(arguments, 5)
    step = (arguments.number(4) or 360.0 / count) * DEGREE
    start = arguments.number(3) * DEGREE
    angles = [start + step * k for k in range(count)]
    return [(a + radius * math.cos(angle), b + radius * math.sin(angle)) for angle in angles]


def _grid(arguments: Arguments) -> list[tuple[float, float]]:
    """SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2: reference, angle, distances and numbers of columns and rows.

    The way through them is not in the manual: row by row, there and back. Frames and gaps are refused.
    """
    columns, rows = _count(arguments, 5), _count(arguments, 6)
    if columns * rows > MOST:
        raise ValueFault(f"CYCLE801 makes {columns * rows} holes, and at most {MOST} are read: correct the numbers")
    if any(arguments.number(place) for place in (7, 9, 10)) or arguments.text(11):
        raise Unread("CYCLE801 with _VARI, _ANG1, _ANG2 or _HIDE", "write the places as blocks of their own")
    angle = arguments.number(2) * DEGREE
    c, s = math.cos(angle), math.sin(angle)
    found = []
    for row in range(rows):
        for place in range(columns):
            column = place if row % 2 == 0 else columns - 1 - place
            along, across = column * arguments.number(3), row * arguments.number(4)
            found.append((arguments.number(0) + along * c - across * s, arguments.number(1) + along * s + across * c))
    return found

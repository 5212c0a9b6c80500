"""Hole patterns: HOLES1, HOLES2, CYCLE801."""

from __future__ import annotations

import math
from collections.abc import Iterator

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_AXES
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.cycles import Place, laid_out, on_circle, on_grid
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value
from toolpace.programs.reading.sinumerik.word_values import Arguments

MOST = 10_000
"""Holes of a pattern."""
NEARER_END = "HOLES1 begins at the end of its row that is nearer to the tool (Programming Guide Cycles)"


def places(name: str, values: list[Value | None], control: Control, state: State) -> Iterator[list[float]]:
    """Words (3 + rotary) of the holes of a pattern, in their order; each as high as the one before was left."""
    arguments = Arguments(name, values, 16)
    first, second = PLANE_AXES[state.plane]
    here = control.words[first] / state.unit, control.words[second] / state.unit
    if name == "HOLES1":
        points = _row(arguments)
        if math.dist(here, points[-1]) < math.dist(here, points[0]):
            control.findings.assumed(NEARER_END)
            points.reverse()
    elif name == "HOLES2":
        points = _circle(arguments)
        if arguments.number(6):
            control.findings.assumed("HOLES2 goes straight from hole to hole, whatever its argument 7 says")
    else:
        points = _grid(arguments, here)
    for a, b in points:
        words = list(control.words)
        words[first], words[second] = a * state.unit, b * state.unit
        yield words


def _count(arguments: Arguments, place: int) -> int:
    count = arguments.code(place)
    if not 1 <= count <= MOST:
        raise BlockError(f"{arguments.name} needs the number of its holes, from 1 to {MOST}, as argument {place + 1}")
    return count


def _row(arguments: Arguments) -> list[Place]:
    """SPCA, SPCO, STA1, FDIS, DBH, NUM: reference, angle, distance of the first, of the others, number."""
    a, b = arguments.number(0), arguments.number(1)
    angle, first, step = arguments.number(2) * DEGREE, arguments.number(3), arguments.number(4)
    along = [first + step * k for k in range(_count(arguments, 5))]
    return [(a + d * math.cos(angle), b + d * math.sin(angle)) for d in along]


def _circle(arguments: Arguments) -> list[Place]:
    """CPA, CPO, RAD, STA1, INDA, NUM: centre, radius, first angle, step (0: evenly round), number."""
    a, b, radius = arguments.number(0), arguments.number(1), arguments.number(2)
    count = _count(arguments, 5)
    step = (arguments.number(4) or 360.0 / count) * DEGREE
    start = arguments.number(3) * DEGREE
    angles = [start + step * k for k in range(count)]
    return on_circle(a, b, radius, angles)


def _grid(arguments: Arguments, here: Place) -> list[Place]:
    """SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2: reference, angle, distances and numbers of columns and rows.

    As Siemens' own cycle: from the corner that is nearer to the tool `here`, along the shorter distance first, there
    and back. Frames and gaps are refused.
    """
    columns, rows = _count(arguments, 5), _count(arguments, 6)
    if columns * rows > MOST:
        raise BlockError(f"CYCLE801 makes {columns * rows} holes, and at most {MOST} are read: correct the numbers")
    if any(arguments.number(place) for place in (7, 9, 10)) or arguments.text(11):
        raise Unread("CYCLE801 with _VARI, _ANG1, _ANG2 or _HIDE", "write the places as blocks of their own")
    angle = arguments.number(2) * DEGREE
    c, s = math.cos(angle), math.sin(angle)
    a, b = arguments.number(0), arguments.number(1)
    u, v = here[0] - a, here[1] - b
    along = _nearer_first(columns, abs(arguments.number(3)), u * c + v * s)
    across = _nearer_first(rows, abs(arguments.number(4)), v * c - u * s)
    if abs(arguments.number(3)) <= abs(arguments.number(4)):
        found = on_grid(along, across)
    else:
        found = [(x, y) for y, x in on_grid(across, along)]
    return laid_out(found, a, b, angle)


def _nearer_first(count: int, step: float, here: float) -> list[float]:
    """Multiples of a step, from the end that is nearer."""
    found = [step * k for k in range(count)]
    return found if here <= found[-1] / 2.0 else found[::-1]

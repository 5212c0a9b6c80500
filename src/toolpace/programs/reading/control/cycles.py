"""Canned drilling cycles as motions, and patterns of holes as places."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.moves import FEED, RAPID, Rate, Stroke, StrokeTable
from toolpace.programs.reading.control.state import ALL

MOST_PECKS = 10_000
"""Strokes of one hole: more is a slip, and would fill memory."""
MOST_HOLES = 100_000
"""Of one block, or of one pattern."""
RAPID_OUT, FEED_OUT, FEED_BACK = "rapid", "feed", "feed back"
"""Ways out: at rapid, at feed to the top, at feed to the level that is gone back to."""
FREE = Rate()
Place = tuple[float, float]
"""Of a hole, along both axes of its plane, in the unit of the program or in m."""
MOST = 4_000_000
"""Motions of all holes of a program: more is a slip of a peck, and would fill memory."""


class Drilling(NamedTuple):
    """One cycle; levels are coordinates of the program along the drill axis [m]."""

    top: float
    """Where the feed begins (R)."""
    bottom: float
    back: float
    """Level that is gone back to behind the hole."""
    start: float | None = None
    """Level at which cutting begins, where there is a hole down to it already; None: the top."""
    start_speed: float = 0.0
    """Of the way from the top to it [m/s]; 0: rapid."""
    over: float | None = None
    """Level at which the tool arrives over the hole, straight from where it is; None: at its own, or the top where
    that is above."""
    axis: int = 2
    """Of X, Y, Z, the one along which the tool goes."""
    ends: tuple[float, ...] = ()
    """Depths below the top at which strokes end [m], where pecks do not tell them."""
    peck: float = 0.0
    """Most depth of a stroke [m]; 0: the whole hole in one."""
    first_peck: float = 0.0
    """The same of the first stroke, where it differs."""
    peck_less: float = 0.0
    """By how much each stroke is shorter than the one before [m]."""
    least_peck: float = 0.0
    chip_break: float = 0.0
    """How far a stroke is gone back to break the chip [m]; 0: back to the top."""
    breaks_at_feed: bool = False
    """Whether that is at feed, as it is where the spindle reverses."""
    clearance: float = 0.0
    """How far above the last depth the rapid ends with which the next stroke begins [m]."""
    dwell: float = 0.0
    """At the bottom [s]."""
    over_top: bool = False
    """Whether the way back between pecks leads above the top where these are shorter than it."""
    peck_dwell: float = 0.0
    """After each stroke but the last [s]."""
    top_dwell: float = 0.0
    """Each time that the top is gone back to between strokes [s]."""
    full_after: int = 0
    """Chips that are broken before a stroke is gone back to the top; 0: it never is."""
    out: str = RAPID_OUT
    out_speed: float = 0.0
    """Of the way out at feed [m/s]; 0: the feed in force."""
    stops: bool = False
    """Whether the spindle stops or reverses at the bottom, and where chips are broken: so does the motion."""


def depths(cycle: Drilling) -> list[float]:
    """Depths below the top [m] of the ends of the strokes, the whole depth last."""
    if cycle.ends:
        return list(cycle.ends)
    whole = abs(cycle.top - cycle.bottom)
    peck = cycle.first_peck or cycle.peck
    if peck <= 0.0 or peck >= whole:
        return [whole]
    found: list[float] = []
    depth = 0.0
    while depth + peck < whole - 1e-9 and len(found) < MOST_PECKS:
        depth += peck
        found.append(depth)
        shorter = (cycle.peck if len(found) == 1 and cycle.first_peck else peck) - cycle.peck_less
        peck = max(shorter, cycle.least_peck or cycle.peck_less or peck * 1e-3, 1e-6)
    return [*found, whole]


def drill(control: Control, cycle: Drilling, hole: list[float], number: float | None = None) -> None:
    """Drill at the words `hole` (3 + rotary): its place in the plane counts, levels are the cycle's.

    Rapid over the hole; rapid to the top; strokes at feed; out to the level `back`.
    """
    try:
        strokes = _strokes(cycle)
    except OverflowError:
        control.source.fail(
            f"this hole takes more than {MOST_PECKS} strokes: check its depth and its peck", control.line
        )
    along(control, hole, cycle.axis, [_over(control, cycle), *strokes], number)


def _down(cycle: Drilling) -> float:
    return 1.0 if cycle.bottom > cycle.top else -1.0


def _over(control: Control, cycle: Drilling) -> Stroke:
    """Rapid over the hole, from below the top by way of it."""
    present = control.words[cycle.axis]
    if cycle.over is not None:
        return Stroke(cycle.over)
    if (cycle.top - present) * _down(cycle) >= 0.0:
        return Stroke(present)
    # from below the top the tool rises before it goes sideways
    along(control, control.words, cycle.axis, [Stroke(cycle.top)])
    return Stroke(cycle.top)


@lru_cache(maxsize=16)
def _strokes(cycle: Drilling) -> tuple[Stroke, ...]:
    """The strokes of a hole, from the rapid to its top on; OverflowError where they are too many."""
    ends = depths(cycle)
    if len(ends) > MOST_PECKS:
        raise OverflowError
    return (
        *_to_start(cycle),
        *(stroke for k in range(len(ends) - 1) for stroke in _peck(cycle, ends, k)),
        *_out(cycle),
    )


def _to_start(cycle: Drilling) -> list[Stroke]:
    """To the top, and on to where cutting begins."""
    if cycle.start is None:
        return [Stroke(cycle.top)]
    return [Stroke(cycle.top), Stroke(cycle.start, rapid=not cycle.start_speed, speed=cycle.start_speed)]


def _peck(cycle: Drilling, ends: list[float], k: int) -> list[Stroke]:
    """Stroke k, and the way back behind it; `ends` are depths below the top [m]."""
    down, depth, least = _down(cycle), ends[k], -math.inf if cycle.over_top else 0.0
    cut = Stroke(cycle.top + down * depth, rapid=False, stop=cycle.stops, dwell=cycle.peck_dwell)
    if cycle.chip_break and not (cycle.full_after and (k + 1) % (cycle.full_after + 1) == 0):
        level = cycle.top + down * max(depth - cycle.chip_break, least)
        return [cut, Stroke(level, rapid=not (cycle.stops or cycle.breaks_at_feed), stop=cycle.stops)]
    level = cycle.top + down * max(depth - cycle.clearance, least)
    return [cut, Stroke(cycle.top, dwell=cycle.top_dwell), Stroke(level)]


def _out(cycle: Drilling) -> list[Stroke]:
    """The last stroke, and out."""
    level = cycle.top + _down(cycle) * abs(cycle.top - cycle.bottom)
    found = [Stroke(level, rapid=False, stop=cycle.stops, dwell=cycle.dwell)]
    if cycle.out != RAPID_OUT:
        level = cycle.top if cycle.out == FEED_OUT else cycle.back
        found.append(Stroke(level, rapid=False, speed=cycle.out_speed))
    return [*found, Stroke(cycle.back)]


def bore_backwards(control: Control, cycle: Drilling, hole: list[float], aside: list[float], middle: float) -> None:
    """Bore a hole from below, from `bottom` up to the level `middle`; the tool goes through it beside its axis.

    aside: the place (3 + rotary) beside the hole at which the tool goes down and up; levels count as in `drill`.
    After LinuxCNC's interpreter, `convert_cycle_g87`.
    """
    axis, bottom = cycle.axis, cycle.bottom
    along(control, hole, axis, [_over(control, cycle), Stroke(cycle.top)])
    along(control, aside, axis, [Stroke(cycle.top, stop=True), Stroke(bottom)])
    along(control, hole, axis, [Stroke(bottom, stop=True), Stroke(middle, rapid=False)])
    along(control, hole, axis, [Stroke(bottom, rapid=False, stop=True)])
    along(control, aside, axis, [Stroke(bottom), Stroke(cycle.back)])
    along(control, hole, axis, [Stroke(cycle.back)])


def fine_bore(control: Control, cycle: Drilling, hole: list[float], beside: list[float]) -> None:
    """Bore a hole, and go out beside its axis so that the tool does not mark it.

    B-63944EN-2, "Fine boring cycle (G76)": at the bottom the spindle stops oriented, and the tool goes aside
    at rapid. beside: the place (3 + rotary) of the way out.
    """
    down = Stroke(cycle.bottom, rapid=False, stop=True, dwell=cycle.dwell)
    along(control, hole, cycle.axis, [_over(control, cycle), Stroke(cycle.top), down])
    along(control, beside, cycle.axis, [Stroke(cycle.bottom), Stroke(cycle.back)])
    along(control, hole, cycle.axis, [Stroke(cycle.back)])


def back_bore(control: Control, cycle: Drilling, hole: list[float], beside: list[float]) -> None:
    """Bore from `top`, which lies below, up to `bottom`; in and out the tool goes beside the axis of the hole.

    B-63944EN-2, "Back boring cycle (G87)": over the hole, oriented and shifted, down to R, back to the axis, up to Z at
    feed, oriented and shifted again, out to the initial level, back to the axis.
    """
    present = control.words[cycle.axis]
    along(control, hole, cycle.axis, [Stroke(present, stop=True)])
    along(control, beside, cycle.axis, [Stroke(present), Stroke(cycle.top)])
    up = Stroke(cycle.bottom, rapid=False, stop=True, dwell=cycle.dwell)
    along(control, hole, cycle.axis, [Stroke(cycle.top, stop=True), up])
    along(control, beside, cycle.axis, [Stroke(cycle.bottom), Stroke(cycle.back)])
    along(control, hole, cycle.axis, [Stroke(cycle.back)])


def along(
    control: Control, words: list[float], axis: int, strokes: Iterable[Stroke], number: float | None = None
) -> None:
    """Move to level after level on the line through words (3 + rotary) along X, Y or Z (0, 1, 2).

    number: F of the block, where feed is by inverse time.
    """
    placement, strokes = control.placement, tuple(strokes)
    if not placement.tip_mode:
        control.need_linear_joints()
    if control.stage is not None:
        control.stage.other_motion("a cycle of holes")
    control.check_dwell(max(stroke.dwell for stroke in strokes))
    by_feed = any(not stroke.rapid and not stroke.speed for stroke in strokes)
    rate = control.feed.rate(number, control.line) if by_feed else FREE
    control.words, control.named = list(words), ALL
    control.words[axis] = 0.0
    moves, at_zero = control.moves, placement.place(control.words)
    way = tuple(row[axis] for row in placement.matrix)
    moves.in_strokes += len(strokes)
    if moves.in_strokes > MOST:
        control.source.fail(f"holes make more than {MOST} motions up to here: check their pecks", control.line)
    moves.strokes[len(moves)] = _table(strokes, rate, way)
    moves.add(at_zero, FREE, control.line, RAPID, placement.tip_mode, ALL, placement.tool_length)
    control.words[axis] = strokes[-1].level


@lru_cache(maxsize=16)
def _table(strokes: tuple[Stroke, ...], rate: Rate, way: tuple[float, ...]) -> StrokeTable:
    """Strokes along a way (3,), those at the feed in force at this rate."""
    rates = [FREE if each.rapid else Rate(each.speed) if each.speed else rate for each in strokes]
    return StrokeTable(
        np.outer([each.level for each in strokes], way),
        np.array(rates),
        np.array([RAPID if each.rapid else FEED for each in strokes]),
        np.array([each.stop or each.dwell > 0.0 for each in strokes]),
        np.array([each.dwell for each in strokes]),
    )


def on_circle(x: float, y: float, radius: float, angles: Iterable[float]) -> list[Place]:
    """Places on a circle about (x, y) at angles [rad]."""
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def on_grid(columns: Sequence[float], rows: Sequence[float], *, border: bool = False) -> list[Place]:
    """Places of columns along u and rows along v, row after row to and fro; border: of inner rows the ends alone."""
    found = []
    for k, v in enumerate(rows):
        row = columns if not border or k in (0, len(rows) - 1) else columns[:: max(len(columns) - 1, 1)]
        found += [(u, v) for u in row[:: -1 if k % 2 else 1]]
    return found


def laid_out(places: Iterable[Place], x: float, y: float, angle: float) -> list[Place]:
    """Places turned by an angle [rad] and shifted to the origin (x, y)."""
    c, s = math.cos(angle), math.sin(angle)
    return [(x + u * c - v * s, y + u * s + v * c) for u, v in places]

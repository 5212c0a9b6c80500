"""Canned cycles of holes, written out as the motions that they stand for."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass

from toolpace.reading.control.control import Control

MOST_PECKS = 10_000
"""Strokes of one hole: more is a slip, and would fill memory."""
RAPID_OUT, FEED_OUT, FEED_BACK = "rapid", "feed", "feed back"
"""Ways out: at rapid, at feed to the top, at feed to the level that is gone back to."""


@dataclass(frozen=True)
class Drilling:
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
    peck: float = 0.0
    """Most depth of a stroke [m]; 0: the whole hole in one."""
    first_peck: float = 0.0
    """The same of the first stroke, where it differs."""
    peck_less: float = 0.0
    """By how much each stroke is shorter than the one before [m]."""
    least_peck: float = 0.0
    chip_break: float = 0.0
    """How far a stroke is gone back to break the chip [m]; 0: back to the top."""
    clearance: float = 0.0
    """How far above the last depth the rapid ends with which the next stroke begins [m]."""
    dwell: float = 0.0
    """At the bottom [s]."""
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
    """Whether the spindle stops or reverses at the bottom: so does the motion, and chips are broken at feed."""


def depths(cycle: Drilling) -> list[float]:
    """Depths below the top [m] of the ends of the strokes, the whole depth last."""
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
    axis, line = cycle.axis, control.line
    strokes = depths(cycle)
    if len(strokes) > MOST_PECKS:
        control.source.fail(f"this hole takes more than {MOST_PECKS} strokes: check its depth and its peck", line)
    down = 1.0 if cycle.bottom >= cycle.top else -1.0

    def to(level: float, rapid: bool) -> None:
        words = list(hole)
        words[axis] = level
        control.straight(words, 7, rapid=rapid, number=number)

    _arrive(control, cycle, hole, down)
    for k, depth in enumerate(strokes):
        to(cycle.top + down * depth, False)
        if k + 1 == len(strokes):
            break
        if cycle.peck_dwell:
            control.dwell(cycle.peck_dwell)
        if cycle.stops:
            control.stop()
        if cycle.chip_break and not (cycle.full_after and (k + 1) % (cycle.full_after + 1) == 0):
            to(cycle.top + down * max(depth - cycle.chip_break, 0.0), not cycle.stops)
            if cycle.stops:
                control.stop()
        else:
            to(cycle.top, True)
            if cycle.top_dwell:
                control.dwell(cycle.top_dwell)
            to(cycle.top + down * max(depth - cycle.clearance, 0.0), True)
    if cycle.dwell:
        control.dwell(cycle.dwell)
    if cycle.stops:
        control.stop()
    if cycle.out != RAPID_OUT:
        with control.feed.held(cycle.out_speed) if cycle.out_speed else nullcontext():
            to(cycle.top if cycle.out == FEED_OUT else cycle.back, False)
    to(cycle.back, True)


def _arrive(control: Control, cycle: Drilling, hole: list[float], down: float) -> None:
    """Rapid over the hole, then to the top, and on to where cutting begins."""
    axis = cycle.axis
    present = control.words[axis]
    over = list(hole)
    if cycle.over is not None:
        over[axis] = cycle.over
    elif (cycle.top - present) * down >= 0.0:
        over[axis] = present
    else:  # from below the top the tool rises before it goes sideways
        over[axis] = cycle.top
        control.straight([*control.words[:axis], cycle.top, *control.words[axis + 1 :]], 7, rapid=True)
    control.straight(over, 7, rapid=True)
    over = list(hole)
    over[axis] = cycle.top
    control.straight(over, 7, rapid=True)
    if cycle.start is not None:
        over[axis] = cycle.start
        with control.feed.held(cycle.start_speed) if cycle.start_speed else nullcontext():
            control.straight(over, 7, rapid=not cycle.start_speed)


def bore_backwards(control: Control, cycle: Drilling, hole: list[float], aside: list[float], middle: float) -> None:
    """Bore a hole from below, from `bottom` up to the level `middle`; the tool goes through it beside its axis.

    aside: the place (3 + rotary) beside the hole at which the tool goes down and up; levels count as in `drill`.
    After LinuxCNC's interpreter, `convert_cycle_g87`.
    """

    def to(place: list[float], level: float, rapid: bool) -> None:
        words = list(place)
        words[cycle.axis] = level
        control.straight(words, 7, rapid=rapid)

    _arrive(control, cycle, hole, -1.0)
    to(aside, cycle.top, True)
    control.stop()
    to(aside, cycle.bottom, True)
    to(hole, cycle.bottom, True)
    control.stop()
    to(hole, middle, False)
    to(hole, cycle.bottom, False)
    control.stop()
    to(aside, cycle.bottom, True)
    to(aside, cycle.back, True)
    to(hole, cycle.back, True)

"""The input blocks of LinuxCNC's planner, and its table of segments."""

from __future__ import annotations

from typing import NamedTuple

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

LINE, ARC, ROUNDING = 0, 1, 2
"""Kinds of segments; a rounding is the arc that the planner puts into a corner."""
OVERLAPPED, EXACT, REST, TANGENT = 0, 1, 2, 3
"""How a segment ends: overlapped by the next, exactly on its end, at rest, at speed into the next."""
SMALL_WAY, SMALL_SPEED, SMALL_TIME = 1e-12, 1e-8, 1e-12
"""[mm], [mm/s], [s]"""
TANGENTIAL = 0.5
"""Share of the acceleration that arcs leave to changes of speed."""
SIDEWAYS = 0.75**0.5
"""Share of it that is left across."""

(
    BLOCK, KIND, ENDING, RAPID, TURNS, LENGTH, NOMINAL, DONE, ASKED, TOP, ACCELERATION, TANGENT_SHARE, TOLERANCE, SPEED,
    FINAL, KINK, KINK_AFTER, KINK_BEFORE, OVERLAPS, FIXED, PEAK, PERIOD, SPLIT, LEAVING, GONE, STARTED, RAMPED, SLOWING,
    OVERLAPPING, RADIUS, SWEEP,
) = range(31)  # fmt: skip
"""Columns of the table of segments: block it is of, kind, ending, whether it is a rapid, whether rotary axes move;
length, length before roundings, way done; speed asked for, most speed, acceleration, its share along an arc;
tolerance; speed, planned final speed; most speed at a kink with the next, shares of acceleration that kinks behind and
before take; whether the one before overlaps it, whether its length is final, whether its end is a peak of the plan;
period of its cycle, whether the next cycle ends it, its speed then, whether it is done; whether it was begun, is
ramped, is on its last slowing down, is overlapping the next; radius and sweep of an arc."""
COLUMNS = 31


OF_KIND, OF_RAPID, OF_TURNS, OF_LENGTH, OF_ASKED, OF_TOP, OF_ACCELERATION, OF_RADIUS, OF_SWEEP = range(9)
OF_ENDING, OF_TOLERANCE, OF_WAIT = range(9, 12)
"""Columns of figures of blocks: LINE or ARC, whether it is a rapid, whether rotary axes move (2: they alone); length
[mm, or deg where X, Y, Z stand]; speed asked for, within the axes' limits; most speed by them; acceleration; radius and
sweep of an arc; OVERLAPPED, EXACT or REST, by the mode in force; tolerance of blending [mm], 0: none; how long it waits
at rest behind the block [s], below zero: it goes on."""
BEGIN, END, CORNER, CENTRE, NORMAL, RISE = range(6)
"""Vectors of blocks: unit directions of X, Y, Z at start and end, zero where they stand; place of the start [mm]; of an
arc its centre, the normal about which it turns, and its rise."""


class Blocks(NamedTuple):
    """n blocks as the interpreter hands them on."""

    figures: Floats
    """(n, 12)"""
    vectors: Floats
    """(n, 6, 3)"""


class Control(NamedTuple):
    """Settings of the controller."""

    cycle: float
    """Servo period [s]."""
    velocity: Floats
    """(3,) limits of X, Y, Z [mm/s]."""
    acceleration: Floats
    """(3,) [mm/s^2]."""
    path_velocity: float
    """MAX_LINEAR_VELOCITY [mm/s]."""
    override: float
    """MAX_FEED_OVERRIDE: corners are planned for feeds so much higher."""
    kink: float
    """ARC_BLEND_KINK_RATIO: share of the acceleration that a kink in tangents may take."""
    depth: int
    """ARC_BLEND_OPTIMIZATION_DEPTH: segments that are looked ahead."""
    gap: int
    """ARC_BLEND_GAP_CYCLES: a line that is left with fewer cycles becomes part of the rounding behind it."""
    ramp_frequency: float
    """ARC_BLEND_RAMP_FREQ [Hz]: shorter segments are ramped from speed to speed."""


@jit()
def acceleration_of(q: Floats, k: int) -> float:
    """Of a segment along its way, less what kinks, overlaps and curvature take."""
    share: float = 1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE])
    if q[k, OVERLAPS] or q[k, ENDING] == OVERLAPPED:
        share *= 0.5
    if q[k, KIND] != LINE:
        share *= q[k, TANGENT_SHARE]
    found: float = q[k, ACCELERATION] * share
    return found


@jit()
def most_speed(q: Floats, k: int, control: Control, override: float) -> float:
    """Of a segment at a feed override."""
    speed: float = min(q[k, ASKED] * override, q[k, TOP])
    # a limit of the path's speed is for lengths
    return speed if q[k, TURNS] == 2.0 else min(speed, control.path_velocity)


@jit()
def end_with(q: Floats, k: int, new: int, ending: int) -> None:
    """Set how a segment meets the next."""
    q[k, ENDING] = ending
    q[new, OVERLAPS] = 1.0 if ending == OVERLAPPED else 0.0

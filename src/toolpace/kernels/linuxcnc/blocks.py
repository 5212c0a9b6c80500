"""The input blocks of LinuxCNC's planner, with straight ones joined, its table of segments, and vectors of X, Y, Z.

Straight blocks of one feed are joined within a tolerance as its canon does: LinuxCNC's documents, "G64 P Q" ("naive cam
detector").
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
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
    BLOCK, KIND, ENDING, RAPID, TURNS, LENGTH, NOMINAL, DONE, REQUESTED, TOP, ACCELERATION, TANGENT_SHARE, TOLERANCE,
    SPEED, FINAL, KINK, KINK_AFTER, KINK_BEFORE, OVERLAPS, FIXED, PEAK, PERIOD, SPLIT, LEAVING, GONE, STARTED, RAMPED,
    SLOWING, OVERLAPPING, RADIUS, SWEEP, JERK,
) = range(32)  # fmt: skip
"""Columns of the table of segments: block it is of, kind, ending, whether it is a rapid, whether rotary axes move;
length, length before roundings, way done; requested speed, most speed, acceleration, its share along an arc;
tolerance; speed, planned final speed; most speed at a kink with the next, shares of acceleration that kinks behind and
before take; whether the one before overlaps it, whether its length is final, whether its end is a peak of the plan;
period of its cycle, whether the next cycle ends it, its speed then, whether it is done; whether it was begun, is
ramped, is on its last slowing down, is overlapping the next; radius and sweep of an arc; jerk along it."""
COLUMNS = 32


OF_KIND, OF_RAPID, OF_TURNS, OF_LENGTH, OF_REQUESTED, OF_TOP, OF_ACCELERATION, OF_RADIUS, OF_SWEEP = range(9)
OF_ENDING, OF_TOLERANCE, OF_WAIT, OF_JERK = range(9, 13)
"""Columns of figures of blocks: LINE or ARC, whether it is a rapid, whether rotary axes move (2: they alone); length
[mm, or deg where X, Y, Z stand]; requested speed, within the axes' limits; most speed by them; acceleration; radius and
sweep of an arc; OVERLAPPED, EXACT or REST, by the mode in force; tolerance of blending [mm], 0: none; how long it waits
at rest behind the block [s], below zero: it goes on; jerk along it."""
BEGIN, END, CORNER, CENTRE, NORMAL, RISE = range(6)
"""Vectors of blocks: unit directions of X, Y, Z at start and end, +X where they turn in place; place of the start [mm];
of an arc its centre, the normal about which it turns, and its rise."""
Vector = tuple[float, float, float]
ORIGIN = (0.0, 0.0, 0.0)
MOST = 101
"""Points of a chain."""


class Blocks(NamedTuple):
    """n blocks as the interpreter hands them on."""

    figures: Floats
    """(n, 13)"""
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
    jerk: float
    """MAX_LINEAR_JERK [mm/s^3]; 0: the planner that keeps no jerk (PLANNER_TYPE = 0)."""
    peak_scale: float
    """SCURVE_PEAK_SCALE: share of the speed that a segment reaches from rest to rest, for the speeds at its ends."""


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
    speed: float = min(q[k, REQUESTED] * override, q[k, TOP])
    # a limit of the path's speed is for lengths
    return speed if q[k, TURNS] == 2.0 else min(speed, control.path_velocity)


@jit()
def end_with(q: Floats, k: int, new: int, ending: int) -> None:
    """Set how a segment meets the next."""
    q[k, ENDING] = ending
    q[new, OVERLAPS] = 1.0 if ending == OVERLAPPED else 0.0


@jit()
def of_block(b: Blocks, j: int, which: int) -> Vector:
    """A vector of a block."""
    return b.vectors[j, which, 0], b.vectors[j, which, 1], b.vectors[j, which, 2]


@jit()
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit()
def norm(a: Vector) -> float:
    """Length."""
    return math.sqrt(dot(a, a))


@jit()
def along(a: Vector, share: float, b: Vector) -> Vector:
    """a + share b"""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]


@jit()
def from_to(a: Vector, b: Vector) -> Vector:
    """b - a"""
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@jit()
def unit(a: Vector) -> Vector:
    """Direction; zero of a vector without length."""
    size = norm(a)
    return along(ORIGIN, 1.0 / size if size > 0.0 else 0.0, a)


@jit()
def across(a: Vector, b: Vector) -> Vector:
    """Direction of the cross product; zero where both are parallel."""
    return unit((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


@jit()
def between(a: Vector, b: Vector) -> float:
    """Angle."""
    return math.acos(max(-1.0, min(1.0, dot(unit(a), unit(b)))))


@jit()
def on_circle(b: Blocks, j: int, angle: float) -> Vector:
    """Place of block j's arc at an angle from its start."""
    centre = of_block(b, j, CENTRE)
    spoke = from_to(centre, of_block(b, j, CORNER))
    place = along(centre, math.cos(angle), spoke)
    place = along(place, math.sin(angle) * norm(spoke), across(of_block(b, j, NORMAL), spoke))
    return along(place, angle / b.figures[j, OF_SWEEP], of_block(b, j, RISE))


@jit()
def chain_ends(place: Floats, tolerance: Floats, alone: Bools, cut: Bools) -> Ints:
    """Rows at which blocks end.

    place: (n, 3) of X, Y, Z at the end of each row, from row 0, where it starts. tolerance: (n,), 0 where rows stay as
    they are. alone: (n,) rows that are joined with no other. cut: (n,) rows behind which a block ends in any case.
    """
    n = len(place)
    ends = np.empty(n, dtype=np.int64)
    count = 0
    first = 1  # of the chain
    for i in range(1, n):
        if i > first and (alone[i] or not joins(place, tolerance[i], first, i)):
            ends[count] = i - 1
            count += 1
            first = i
        if alone[i] or cut[i]:
            ends[count] = i
            count += 1
            first = i + 1
    if first < n:
        ends[count] = n - 1
        count += 1
    return ends[:count]


@jit(inline=True)
def joins(place: Floats, tolerance: float, first: int, i: int) -> bool:
    """Whether the rows from `first` up to i may be one block."""
    if tolerance <= 0.0 or i - first >= MOST:
        return False
    base = point(place, first - 1)
    way = from_to(base, point(place, i))
    square = dot(way, way)
    if square == 0.0:
        return False
    for k in range(first, i):
        spoke = from_to(base, point(place, k))
        share = min(max(dot(way, spoke) / square, 0.0), 1.0)
        if norm(along(spoke, -share, way)) > tolerance:
            return False
    return True


@jit(inline=True)
def point(place: Floats, i: int) -> Vector:
    """Place of a row."""
    return place[i, 0], place[i, 1], place[i, 2]

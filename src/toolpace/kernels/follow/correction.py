"""The correction of each joint: the minimum-time motion to its target within its share of the limits.

A motion from any state ramps to a speed, keeps it and ramps to rest; or, where it is slowing down already and a little
way is left, it eases off first. Where it ends grows with that speed, or with the time of easing off, which are found
between two that enclose them; see Haschke, Weitnauer, Ritter, "On-line planning of time-optimal, jerk-limited
trajectories", IROS 2008, doi 10.1109/IROS.2008.4650924.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.layout import (
    AIM,
    CORRECTION,
    FEED,
    FEED_SHARE,
    FEED_SOON,
    JOINTS,
    LEVER,
    PERIOD,
    PLACE,
    SCRATCH,
    SHARE,
    TAU,
    TIP_PER_LINEAR,
    TURNING_SOON,
)
from toolpace.kernels.follow.pace import cell_at, moved, ramp
from toolpace.kernels.jit import jit

MOST_SHARE = 0.9
"""Share of the pace up to which the feed takes it off: the tool always goes on."""
HALVINGS = 60
"""Steps between two speeds that enclose the one that is sought: as far as floating-point numbers go."""

SMALL = 1e-6
"""Way that counts as none, over what the acceleration makes in a period."""


@jit()
def correct(piece: Floats, state: Floats) -> None:
    """Move the correction for one period towards its aim."""
    feed = piece[cell_at(piece, state[TAU]) + FEED_SOON] * piece[FEED_SHARE]
    place = piece[PLACE : PLACE + 5].view(np.int64)
    limits = state[SCRATCH : SCRATCH + 3]
    for k in range(JOINTS):
        j = place[k]
        limits[0] = min(piece[SHARE + j], feed / (piece[LEVER] if k < 2 else piece[TIP_PER_LINEAR]))
        limits[1], limits[2] = piece[SHARE + JOINTS + j], piece[SHARE + 2 * JOINTS + j]
        of_joint = state[CORRECTION + 4 * j : CORRECTION + 4 * j + 4]
        approach(of_joint, state[AIM + j], limits, piece[PERIOD])


@jit()
def feed_of_correction(piece: Floats, state: Floats) -> float:
    """Share of the pace that keeps the feed: the correction moves, and carried by a turning workpiece it adds to the
    speed of the tip in proportion to the pace."""
    cell = cell_at(piece, state[TAU])
    moving = motion_of_tip(piece, state, 1) / piece[cell + FEED]
    carried = motion_of_tip(piece, state, 0) * piece[cell + TURNING_SOON]
    share: float = min(moving + carried / (1.0 + carried), MOST_SHARE)
    return share


@jit()
def motion_of_tip(piece: Floats, state: Floats, order: int) -> float:
    """Most motion of the tip [m] or speed [m/s] for the correction's value or its derivative of first order."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    linear, turning = 0.0, 0.0
    for k in range(JOINTS):
        own = state[CORRECTION + 4 * place[k] + order]
        if k < 2:
            turning += abs(own) * piece[LEVER]
        else:
            linear += own * own
    motion: float = math.sqrt(linear) * piece[TIP_PER_LINEAR] + turning
    return motion


@jit()
def stop(v: float, a: float, limits: Floats) -> float:
    """The way to rest, as short as it can be [m]."""
    return ramp(v, a, 0.0, limits[1], limits[2])[4]


@jit()
def way_by(v: float, a: float, speed: float, limits: Floats) -> float:
    """The way to rest by way of a speed that is reached and left at once [m]."""
    return ramp(v, a, speed, limits[1], limits[2])[4] + ramp(speed, 0.0, 0.0, limits[1], limits[2])[4]


@jit()
def eased_off(v: float, a: float, way: float, limits: Floats) -> float:
    """How long to ease off with the full jerk before the ramp to rest, to make a way [s]; v > 0 > a."""
    low, high = 0.0, -a / limits[2]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        x, v1, a1 = moved(0.0, v, a, limits[2], middle)
        if x + stop(v1, a1, limits) <= way:
            low = middle
        else:
            high = middle
    return low


@jit()
def cruised(v: float, a: float, way: float, limits: Floats) -> tuple[float, float]:
    """The speed to ramp to, and how long to keep it [s], to make a way > 0 that is longer than that to a stop."""
    fastest = limits[0]
    low = max(v + 0.5 * a * abs(a) / limits[2], 0.0)
    if low >= fastest:
        # the limit was lowered: where keeping to it leads too far, the way is made in two steps
        left = way - way_by(v, a, fastest, limits)
        return (fastest, left / fastest) if left > 0.0 else (low, 0.0)
    left = way - way_by(v, a, fastest, limits)
    if left >= 0.0:
        return fastest, left / fastest
    high = fastest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if way_by(v, a, middle, limits) <= way:
            low = middle
        else:
            high = middle
    return low, 0.0


@jit()
def approach(state: Floats, target: float, limits: Floats, period: float) -> None:
    """Move a state (4,) of position and three derivatives for one period on the quickest way to rest at the target.

    limits: (3,) of velocity, acceleration and jerk. They hold all the time where they hold at the start; a limit of
    velocity that has been lowered is reached as fast as the others allow. The fourth is the jerk at the end.
    """
    most, jerk = limits[1], limits[2]
    v, a = state[1], state[2]
    way = target - state[0]
    sign = 1.0 if way > stop(v, a, limits) else -1.0
    # as seen in the direction in which way is left
    v, a, way = sign * v, sign * a, sign * way
    first, speed, even = 0.0, 0.0, 0.0
    if way > stop(v, a, limits):
        eased = v + 0.5 * a * abs(a) / jerk
        if a < 0.0 and eased > 0.0 and way < way_by(v, a, eased, limits):
            first = eased_off(v, a, way, limits)
        else:
            speed, even = cruised(v, a, way, limits)
    x, v, a = moved(0.0, v, a, jerk, min(first, period))
    j, left = jerk, period - min(first, period)
    up, up_first, up_even, up_last, _ = ramp(v, a, speed, most, jerk)
    down, down_first, down_even, down_last, _ = ramp(speed, 0.0, 0.0, most, jerk)
    for k in range(7):
        if left <= 0.0:
            break
        if k == 0:
            t, j = up_first, up * jerk
        elif k == 1:
            t, j = up_even, 0.0
        elif k == 2:
            t, j = up_last, -up * jerk
        elif k == 3:
            t, j = even, 0.0
        elif k == 4:
            t, j = down_first, down * jerk
        elif k == 5:
            t, j = down_even, 0.0
        else:
            t, j = down_last, -down * jerk
        t = min(t, left)
        x, v, a = moved(x, v, a, j, t)
        left -= t
    if left > 0.0 and abs(way - x) <= SMALL * most * period * period:
        # at rest: what rounding has left is dropped
        x, v, a, j = way, 0.0, 0.0, 0.0
    state[0] = target if x == way else state[0] + sign * x
    state[1], state[2], state[3] = sign * v, sign * a, sign * j

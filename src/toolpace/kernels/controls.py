"""Speeds and times of a program's moves on a control with look-ahead or with filters; chains that a compressor joins.

With look-ahead, corners are rounded within their tolerance and speeds change at constant acceleration between them.
With filters, each move is a pulse of velocity that moving averages smooth, and corners are blended by overlap.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

HALVINGS = 24
"""Of a share of the speed of a filtered corner: beyond single precision."""
MOST = 100
"""Moves of a chain."""
ROUNDING = 1e-9
"""Share of a tolerance by which sums of lengths may be off."""


@jit()
def corner_speeds(
    cruise: Floats,
    length: Floats,
    first: Floats,
    last: Floats,
    stop: Bools,
    room: Floats,
    acceleration: Floats,
    jerk: Floats,
    way: Floats,
) -> tuple[Floats, Floats]:
    """Most speed at the start and at the end of each move (n,), by the corners alone.

    A corner is a change of the axes' velocity, by D_j at full speed. At a share f of it the change takes the time
    t = max_j f D_j / a_j at constant acceleration, and meanwhile the way leaves the corner by f |D| t / 8; where jerk
    limits it, t = max_j 2 (f D_j / j_j)^(1/2) and f |D| t / 12. Both keep within the tolerance. At constant
    acceleration it reaches t / 2 to either side, and at most half of each move, so that chords of a circle of radius
    r are driven at (a r)^(1/2).

    cruise, length: (n,) speed and way of the moves. first, last: (n, axes) rates of the axes at their start and end,
    a unit of way. stop: (n,) rest at the end. room: (n,) tolerance there, of the tip [m]. acceleration, jerk: (axes,).
    way: (axes,) what a unit of an axis leaves of the path [m], for axes that turn an allowance.
    """
    n, axes = first.shape
    begin, end = np.zeros(n), np.zeros(n)
    for i in range(1, n - 1):
        if stop[i]:
            continue
        here, there = cruise[i], cruise[i + 1]
        if length[i] > 0.0 and length[i + 1] > 0.0:
            here = there = min(here, there)
        by_acceleration, by_jerk, off = 0.0, 0.0, 0.0
        for k in range(axes):
            change = abs(first[i + 1, k] * there - last[i, k] * here)
            by_acceleration = max(by_acceleration, change / acceleration[k])
            by_jerk = max(by_jerk, change / jerk[k])
            off += (change * way[k]) ** 2
        off = math.sqrt(off)
        share = 1.0
        if off > 0.0 and by_acceleration > 0.0:
            share = min(share, math.sqrt(8.0 * room[i] / (off * by_acceleration)))
            if by_jerk > 0.0:
                share = min(share, (6.0 * room[i] / (off * math.sqrt(by_jerk))) ** (2.0 / 3.0))
        reach = 0.0
        if length[i] > 0.0:
            reach = max(reach, here / length[i])
        if length[i + 1] > 0.0:
            reach = max(reach, there / length[i + 1])
        if by_acceleration > 0.0 and reach > 0.0:
            share = min(share, 1.0 / math.sqrt(by_acceleration * reach))
        end[i], begin[i + 1] = share * here, share * there
    return begin, end


@jit()
def ramps(cruise: Floats, length: Floats, acceleration: Floats, begin: Floats, end: Floats, depth: int) -> None:
    """Lower the speeds at the ends of the moves until each can be reached from its neighbours, in place.

    acceleration: (n,) along each move. depth: a control that knows so many moves ahead can stop at the end of the
    last; 0: it knows all.
    """
    n = len(cruise)
    for i in range(n - 1, 0, -1):
        most = math.sqrt(end[i] ** 2 + 2.0 * acceleration[i] * length[i])
        if begin[i] > most:
            if i > 1 and begin[i] > 0.0:
                end[i - 1] *= most / begin[i]
            begin[i] = most
    if depth > 0:
        for i in range(1, n):
            most, last = 0.0, min(i + depth, n)
            for k in range(last - 1, i - 1, -1):
                most = min(most, end[k])
                most = math.sqrt(most**2 + 2.0 * acceleration[k] * length[k])
            if begin[i] > most:
                if i > 1 and begin[i] > 0.0:
                    end[i - 1] *= most / begin[i]
                begin[i] = most
    for i in range(1, n):
        most = math.sqrt(begin[i] ** 2 + 2.0 * acceleration[i] * length[i])
        if end[i] > most:
            if i < n - 1 and end[i] > 0.0:
                begin[i + 1] *= most / end[i]
            end[i] = most


@jit()
def times_of(cruise: Floats, length: Floats, acceleration: Floats, begin: Floats, end: Floats) -> Floats:
    """Time of each move (n,) [s]: from its first to its last speed by way of the highest it reaches."""
    n = len(cruise)
    times = np.zeros(n)
    for i in range(1, n):
        a, v0, v1 = acceleration[i], begin[i], end[i]
        top = min(cruise[i], math.sqrt(0.5 * (v0 * v0 + v1 * v1) + a * length[i]))
        if top <= 0.0 or length[i] <= 0.0:
            continue
        ramped = (2.0 * top * top - v0 * v0 - v1 * v1) / (2.0 * a)
        times[i] = (2.0 * top - v0 - v1) / a + max(length[i] - ramped, 0.0) / top
    return times


@jit()
def blended_speeds(
    cruise: Floats,
    length: Floats,
    first: Floats,
    last: Floats,
    stop: Bools,
    room: Floats,
    acceleration: Floats,
    jerk: Floats,
    way: Floats,
    ramp: float,
    smoothing: float,
) -> Floats:
    """Most speed (n,) of the pulses about the corner at the end of each move.

    The filters see a window as long as they are: a change D of the mean velocity from its first to its second half
    leaves the path by |D| (ramp / 8 + smoothing^2 / (24 ramp)), its acceleration is D_j / ramp and its jerk
    D_j / (ramp smoothing). The speed is found by halving, since the window grows with it. Arguments as of
    `corner_speeds`; ramp >= smoothing: lengths of the moving averages [s].
    """
    n = len(cruise)
    deviation = ramp / 8.0 + smoothing * smoothing / (24.0 * ramp)
    speeds = np.zeros(n)
    mean = np.empty((2, first.shape[1]))
    for i in range(1, n - 1):
        if stop[i]:
            continue
        top = min(cruise[i], cruise[i + 1])
        low, high = 0.0, 1.0
        for halving in range(HALVINGS):
            share = 1.0 if halving == 0 else 0.5 * (low + high)
            v = share * top
            _mean_rates(length, first, last, stop, i, 0.5 * v * ramp, mean)
            off, held = 0.0, True
            for k in range(first.shape[1]):
                change = v * abs(mean[1, k] - mean[0, k])
                off += (change * way[k]) ** 2
                if change > acceleration[k] * ramp or change > jerk[k] * ramp * smoothing:
                    held = False
            if held and math.sqrt(off) * deviation <= room[i]:
                low = share
                if halving == 0:
                    break
            else:
                high = share
        speeds[i] = low * top
    return speeds


@jit()
def _mean_rates(
    length: Floats, first: Floats, last: Floats, stop: Bools, corner: int, reach: float, mean: Floats
) -> None:
    """Mean rates of the axes over a way before and a way behind the end of move `corner`, into mean (2, axes)."""
    mean[0], mean[1] = last[corner], first[corner + 1]
    for side in range(2):
        step, k = (-1, corner) if side == 0 else (1, corner + 1)
        left, passed = reach, 0.0
        while left > 0.0 and 0 < k < len(length):
            part = min(left, length[k])
            if part > 0.0:
                for axis in range(first.shape[1]):
                    rate = 0.5 * (first[k, axis] + last[k, axis])
                    mean[side, axis] = (mean[side, axis] * passed + rate * part) / (passed + part)
                passed += part
            left -= part
            if (side == 0 and stop[k - 1]) or (side == 1 and stop[k]):
                break
            k += step


@jit()
def pulse_times(cruise: Floats, length: Floats, speeds: Floats, window: float) -> Floats:
    """Time of each move (n,) [s]: its pulse, lowered to the speed of a corner while the corner is in the filters.

    speeds: (n,) of the corner at the end of each move; 0 at rest. window: length of all filters [s], half of which a
    move waits at either end for rest.
    """
    n = len(cruise)
    times = np.zeros(n)
    for i in range(1, n):
        if length[i] <= 0.0:
            continue
        left = length[i]
        for v in (speeds[i - 1], speeds[i]):
            if v <= 0.0:
                times[i] += 0.5 * window
            elif v < cruise[i]:
                part = min(0.5 * length[i], 0.5 * v * window)
                times[i] += part / v
                left -= part
        times[i] += left / cruise[i]
    return times


@jit()
def chains_of(place: Floats, tolerance: Floats, alone: Bools, cut: Bools) -> Ints:
    """The chain (n,) that each move belongs to, from 0 on.

    place: (n, axes) of the axes at the end of each move, in lengths; row 0 is where the first one starts. tolerance:
    (n,). alone: (n,) moves that are joined with no other. cut: (n,) moves behind which a chain ends in any case.
    """
    n = len(place)
    chain = np.zeros(n, dtype=np.int64)
    first = 1
    for i in range(1, n):
        begins = i == first or alone[i] or alone[i - 1] or cut[i - 1] or not _joins(place, tolerance[i], first, i)
        if begins:
            first = i
        chain[i] = chain[i - 1] + begins
    return chain


@jit()
def _joins(place: Floats, tolerance: float, first: int, i: int) -> bool:
    """Whether the moves from `first` up to i stay within the tolerance of the line from end to end."""
    if tolerance <= 0.0 or i - first >= MOST:
        return False
    axes, square = place.shape[1], 0.0
    for k in range(axes):
        square += (place[i, k] - place[first - 1, k]) ** 2
    if square == 0.0:
        return False
    for row in range(first, i):
        along = 0.0
        for k in range(axes):
            along += (place[row, k] - place[first - 1, k]) * (place[i, k] - place[first - 1, k])
        share, off = min(max(along / square, 0.0), 1.0), 0.0
        for k in range(axes):
            spoke = place[row, k] - place[first - 1, k]
            off += (spoke - share * (place[i, k] - place[first - 1, k])) ** 2
        if off > (tolerance * (1.0 + ROUNDING)) ** 2:
            return False
    return True

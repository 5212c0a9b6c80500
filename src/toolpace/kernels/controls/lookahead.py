"""Speeds of a control with look-ahead: rounded corners, constant acceleration between them."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit


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

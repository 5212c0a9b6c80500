"""Speeds at corners that a control rounds within a tolerance, each change of velocity in three phases."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

HALVINGS = 40


@jit()
def rounded_speeds(
    cruise: Floats,
    length: Floats,
    first: Floats,
    last: Floats,
    stop: Bools,
    room: Floats,
    acceleration: Floats,
    jerk: Floats,
    way: Floats,
) -> Floats:
    """Most speed (n,) at the end of each move, by the roundings alone; 0 at rest.

    At a corner the axes' velocities change by v D_j: with jerk up to an acceleration, that acceleration, and jerk down;
    all take the same time, and no axis exceeds its limits. Meanwhile the way leaves the corner by `deviation`, which
    stays within the tolerance. A rounding reaches half of each move at most, as it is at constant acceleration: chords
    of a circle of radius r are driven at (a r)^(1/2), since a compressor makes a curve of them.

    cruise, length: (n,) speed and way of the moves. first, last: (n, axes) rates of the axes at their start and end,
    a unit of way. stop: (n,) rest at the end. room: (n,) tolerance there, of the tip [m]. acceleration, jerk: (axes,).
    way: (axes,) what a unit of an axis leaves of the path [m], for axes that turn an allowance.
    """
    n, axes = first.shape
    speeds = np.zeros(n)
    change = np.zeros(axes)
    for i in range(1, n - 1):
        if stop[i]:
            continue
        top = cruise[i + 1] if length[i] <= 0.0 else cruise[i]
        if length[i + 1] > 0.0:
            top = min(top, cruise[i + 1])
        reach = math.inf
        if length[i] > 0.0:
            reach = length[i]
        if length[i + 1] > 0.0:
            reach = min(reach, length[i + 1])
        off, steepest = 0.0, 0.0
        for k in range(axes):
            change[k] = abs(first[i + 1, k] - last[i, k])
            off += (change[k] * way[k]) ** 2
            steepest = max(steepest, change[k] / acceleration[k])
        if steepest > 0.0:
            top = min(top, math.sqrt(reach / steepest))
        off = math.sqrt(off)
        if deviation(top, change, off, acceleration, jerk) <= room[i]:
            speeds[i] = top
            continue
        low, high = 0.0, top
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if deviation(middle, change, off, acceleration, jerk) <= room[i]:
                low = middle
            else:
                high = middle
        speeds[i] = low
    return speeds


@jit()
def deviation(speed: float, change: Floats, off: float, acceleration: Floats, jerk: Floats) -> float:
    """How far a rounding leaves its corner [m].

    change: (axes,) D_j. off: |D| in lengths. The acceleration builds up within a time t, stays for p - t, and falls
    within t: p = max(A, J^(1/2)) and t = J / p, where A = max v D_j / a_j and J = max v D_j / j_j. No axis exceeds its
    limits then. Its velocity changes by a p, and the way to the middle is a (t^2 / 6 + t h / 2 + h^2 / 2), 2 h = p - t.
    """
    by_acceleration, by_jerk = 0.0, 0.0
    for k in range(len(change)):
        by_acceleration = max(by_acceleration, speed * change[k] / acceleration[k])
        by_jerk = max(by_jerk, speed * change[k] / jerk[k])
    period = max(by_acceleration, math.sqrt(by_jerk))
    if period <= 0.0:
        return 0.0
    phase = by_jerk / period
    steady = 0.5 * (period - phase)
    shape = phase * phase / 6.0 + 0.5 * phase * steady + 0.5 * steady * steady
    return float(speed * off * shape / period)

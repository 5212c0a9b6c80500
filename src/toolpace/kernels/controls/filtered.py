"""Speeds of a control that filters: pulses of velocity smoothed by moving averages, corners blended by overlap."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

HALVINGS = 24


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

    The filters see the velocity of a window as long as they are: a change D of it across the window leaves the path
    by |D| (ramp / 8 + smoothing^2 / (24 ramp)), its acceleration is D_j / ramp and its jerk D_j / (ramp smoothing).
    The speed is found by halving, since the window grows with it. Arguments as of `lookahead.corner_speeds`;
    ramp >= smoothing: lengths of the moving averages [s].
    """
    n, axes = first.shape
    deviation = ramp / 8.0 + smoothing * smoothing / (24.0 * ramp)
    speeds = np.zeros(n)
    for i in range(1, n - 1):
        if stop[i]:
            continue
        top = min(cruise[i], cruise[i + 1])
        low, high = 0.0, 1.0
        for halving in range(HALVINGS):
            share = 1.0 if halving == 0 else 0.5 * (low + high)
            v = share * top
            reach = 0.5 * v * ramp
            before, left = i, reach
            while before > 1 and left > length[before] and not stop[before - 1]:
                left -= length[before]
                before -= 1
            after, left = i + 1, reach
            while after < n - 1 and left > length[after] and not stop[after]:
                left -= length[after]
                after += 1
            off, held = 0.0, True
            for k in range(axes):
                change = v * abs(first[after, k] - last[before, k])
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
def pulse_times(cruise: Floats, length: Floats, stop: Bools, speeds: Floats, window: float) -> Floats:
    """Time of each move (n,) [s]: its pulse, lowered to the speed of a corner while the corner is in the filters.

    window: length of all filters [s], which a stop costs, too.
    """
    n = len(cruise)
    times = np.zeros(n)
    # by place along all moves: where a corner's speed holds, from its place less to its place and half a window's way
    for i in range(1, n):
        times[i] = length[i] / cruise[i] if length[i] > 0.0 and cruise[i] < np.inf else 0.0
        if stop[i] or i == n - 1:
            times[i] += window
    slowest = cruise.copy()
    share = np.zeros(n)
    for i in range(1, n - 1):
        if stop[i] or not speeds[i] < max(cruise[i], cruise[i + 1]):
            continue
        for step in (-1, 1):
            left = 0.5 * speeds[i] * window
            k = i if step < 0 else i + 1
            while 0 < k < n and left > 0.0:
                part = min(left, length[k])
                if length[k] > 0.0 and speeds[i] < cruise[k] and speeds[i] > 0.0:
                    if speeds[i] < slowest[k]:
                        slowest[k] = speeds[i]
                    share[k] = min(share[k] + part, length[k])
                left -= length[k]
                k += step
                if k < 1 or k >= n or (step < 0 and stop[k]) or (step > 0 and stop[k - 1]):
                    break
    for i in range(1, n):
        if share[i] > 0.0:
            times[i] += share[i] * (1.0 / slowest[i] - 1.0 / cruise[i])
    return times

"""Speeds of a filtering control: velocity pulses smoothed by moving averages, corners blended by overlap."""

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

    The filters see a window as long as they are: a change D of the mean velocity from its first to its second half
    leaves the path by |D| (ramp / 8 + smoothing^2 / (24 ramp)), its acceleration is D_j / ramp and its jerk
    D_j / (ramp smoothing). The speed is found by halving, since the window grows with it. Arguments as of
    `lookahead.corner_speeds`; ramp >= smoothing: lengths of the moving averages [s].
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

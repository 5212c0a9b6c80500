"""Speeds and accelerations at the reference points of the genetic planner.

The paper sets them "in advance" and does not say how. Here speeds are lowered until the most comfortable law of every
interval keeps to the limits, then raised again as long as that stays so; the accelerations follow from the speeds.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.planners.quintic_interval import Interval, comfortable, interval_of


@jit()
def slopes(h: Floats, speed: Floats, acceleration: Floats, fixed: Ints) -> None:
    """Preset accelerations (n + 1,) in place: half the slope of the squared speed, without overshoot, if not fixed.

    The slope is that of a monotone cubic interpolant: the weighted harmonic mean of the neighbouring chords.
    """
    for k in range(1, len(speed) - 1):
        if fixed[k]:
            continue
        left = (speed[k] ** 2 - speed[k - 1] ** 2) / h[k - 1]
        right = (speed[k + 1] ** 2 - speed[k] ** 2) / h[k]
        if left * right <= 0.0:
            acceleration[k] = 0.0
        else:
            w1, w2 = 2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]
            acceleration[k] = 0.5 * (w1 + w2) / (w1 / left + w2 / right)


@jit()
def preset(
    intervals: Interval, speed: Floats, acceleration: Floats, fixed: Ints, reserve: float, most: int
) -> tuple[Floats, int, float, int]:
    """Lower the preset speeds (n + 1,) in place until every interval has a law with at most `reserve` usage.

    intervals: n of them; `fixed` (n + 1,) points stay as they are.
    Returns the periods (n,) of those laws, -1 or the interval where none was found, its usage and what it is of.
    """
    h = intervals.x[:, -1].copy()
    n = len(h)
    period, value, which = np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64)
    dirty = np.ones(n, dtype=np.bool_)
    ends = np.empty(4)
    before = np.empty(n + 1)
    bad = -1
    for _ in range(most):
        copy(acceleration, before)
        slopes(h, speed, acceleration, fixed)
        for k in range(n + 1):
            if acceleration[k] != before[k]:
                dirty[max(k - 1, 0)] = True
                dirty[min(k, n - 1)] = True
        bad = -1
        for k in range(n):
            if dirty[k]:
                ends[0], ends[1], ends[2], ends[3] = speed[k], acceleration[k], speed[k + 1], acceleration[k + 1]
                period[k], value[k], which[k] = comfortable(interval_of(intervals, k), ends, reserve)
                dirty[k] = False
            if value[k] > reserve and (bad < 0 or value[k] > value[bad]):
                bad = k
        if bad < 0:
            break
        moved = False
        for k in range(n):
            if value[k] <= reserve:
                continue
            excess = min(max(value[k] / reserve, 1.0), 8.0)
            factor = max(excess ** (-0.2), 0.85) * 0.999
            top = max(speed[k], speed[k + 1])
            for p in (k, k + 1):
                if not fixed[p] and speed[p] > 0.0 and (speed[p] > 0.8 * top or fixed[2 * k + 1 - p]):
                    speed[p] *= factor
                    moved = True
                    dirty[max(p - 1, 0)] = True
                    dirty[min(p, n - 1)] = True
        if not moved:
            break
    if bad < 0:
        return period, -1, 0.0, 0
    return period, bad, value[bad], which[bad]


@jit()
def raise_hill(speed: Floats, fixed: Ints, top: int, width: int, step: float) -> None:
    """Raise speeds (n + 1,) in place by a share `step` at point `top`, less and less over `width` points beside it."""
    for i in range(max(top - width + 1, 1), min(top + width, len(speed) - 1)):
        if not fixed[i]:
            speed[i] *= 1.0 + step * (1.0 - abs(i - top) / width)


@jit()
def all_comfortable(
    intervals: Interval, top: int, width: int, speed: Floats, acceleration: Floats, reserve: float, period: Floats
) -> bool:
    """Whether the intervals as far as `width` + 1 around a point have laws of at most `reserve` usage, and the periods.

    The nearest ones come first: where a hill is too high, it is so about its top.
    """
    n = len(period)
    ends = np.empty(4)
    for away in range(width + 1):
        for j in (top - 1 - away, top + away):
            if not 0 <= j < n:
                continue
            ends[0], ends[1], ends[2], ends[3] = speed[j], acceleration[j], speed[j + 1], acceleration[j + 1]
            period[j], value, _ = comfortable(interval_of(intervals, j), ends, reserve)
            if value > reserve:
                return False
    return True


@jit()
def raise_speeds(
    intervals: Interval, speed: Floats, acceleration: Floats, fixed: Ints, reserve: float, period: Floats
) -> None:
    """Raise preset speeds in place, single ones and hills of several, as long as every interval keeps a law.

    Arrays as in `preset`, whose result `period` is brought up to date.
    """
    h = intervals.x[:, -1].copy()
    n = len(h)
    trial_speed, trial_acceleration, trial_period = speed.copy(), acceleration.copy(), period.copy()
    rounds = max(2, min(12, 1200 // n))
    # what failed fails again, unless something has changed near by since
    changed, failed = np.zeros(n + 1, dtype=np.int64), np.zeros((4, n + 1), dtype=np.int64)
    clock = 0
    for step in (0.12, 0.06, 0.03, 0.015):
        failed[:] = -1
        for _ in range(rounds):
            raised = 0
            for i in range(4):
                width = 8 >> i
                for k in range(1, n):
                    low, high = max(k - width - 1, 0), min(k + width + 1, n)
                    clock += 1
                    if failed[i, k] > changed[max(low - 1, 0) : min(high + 2, n + 1)].max():
                        continue
                    copy(speed, trial_speed)
                    raise_hill(trial_speed, fixed, k, width, step)
                    copy(acceleration, trial_acceleration)
                    slopes(h, trial_speed, trial_acceleration, fixed)
                    if all_comfortable(intervals, k, width, trial_speed, trial_acceleration, reserve, trial_period):
                        raised += 1
                        copy(trial_speed, speed)
                        copy(trial_acceleration, acceleration)
                        copy(trial_period[low:high], period[low:high])
                        changed[low : high + 1] = clock
                    else:
                        failed[i, k] = clock
            if raised == 0:
                break

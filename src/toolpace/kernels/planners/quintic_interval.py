"""Quintic time laws over intervals of a path: what they take of the limits, and speeds that leave some.

Source: Wu, Li, Liu, Perez, ACC 2009, section II.C: over the time period T of an interval the parameter moves as the
quintic that has the preset speed and acceleration at both reference points.

Nodes of an interval lie at distances x (nodes,) from its start; `share` (nodes, 6, m) holds the path derivatives
there over the limits: q'/v, q''/a, q'/a, q'''/j, 3 q''/j, q'/j; `pace` (nodes,) one over the speed cap.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

BACKWARDS = 1e6
"""Usage of a law that runs backwards, plus how far."""
STRIDES = 20
"""Equal times at which a law must run forwards, beside the nodes."""
SEARCH = 40
"""Periods tried for the most comfortable law of an interval."""


@jit()
def law(h: float, v0: float, a0: float, v1: float, a1: float, period: float) -> tuple[float, ...]:
    """C1 to C5, Eq. (7b), of the quintic in t / period from 0 to h with speeds and accelerations at its ends."""
    c1, c2 = v0 * period, a0 * period * period / 2.0
    d1, d2, d3 = h - c1 - c2, v1 * period - c1 - 2.0 * c2, a1 * period * period / 2.0 - c2
    return c1, c2, 10.0 * d1 - 4.0 * d2 + d3, -15.0 * d1 + 7.0 * d2 - 2.0 * d3, 6.0 * d1 - 3.0 * d2 + d3


@jit()
def usage(x: Floats, share: Floats, pace: Floats, ends: Floats, period: float) -> tuple[float, int]:
    """Largest value over limit at the nodes, and what it is of: 0 feed, then 1 + kind * m + joint; -1 backwards.

    ends (4,): speed and acceleration at the start, then at the end.
    """
    n, m = len(x), share.shape[2]
    h = x[n - 1]
    c1, c2, c3, c4, c5 = law(h, ends[0], ends[1], ends[2], ends[3], period)
    # from rest and to rest the third derivative decides which way the first and last step go
    if ends[0] == 0.0 and ends[1] == 0.0 and c3 <= 0.0:
        return BACKWARDS + abs(c3) / h, -1
    if ends[2] == 0.0 and ends[3] == 0.0 and 6.0 * c3 + 24.0 * c4 + 60.0 * c5 <= 0.0:
        return BACKWARDS + abs(6.0 * c3 + 24.0 * c4 + 60.0 * c5) / h, -1
    for j in range(1, STRIDES):
        tau = j / STRIDES
        v = c1 + tau * (2.0 * c2 + tau * (3.0 * c3 + tau * (4.0 * c4 + tau * 5.0 * c5)))
        if v <= 0.0:
            return BACKWARDS + abs(v) / h, -1
    worst, which = 0.0, 0
    tau = 0.0
    for j in range(n):
        if j == n - 1:
            tau = 1.0
        elif j > 0:
            low, high = tau, 1.0
            slope = c1 + tau * (2.0 * c2 + tau * (3.0 * c3 + tau * (4.0 * c4 + tau * 5.0 * c5)))
            guess = tau + (x[j] - x[j - 1]) / slope if slope > 0.0 else 2.0
            tau = guess if low < guess < high else 0.5 * (low + high)
            for _ in range(60):
                rest = tau * (c1 + tau * (c2 + tau * (c3 + tau * (c4 + tau * c5)))) - x[j]
                if abs(rest) <= 1e-11 * h:
                    break
                if rest > 0.0:
                    high = tau
                else:
                    low = tau
                slope = c1 + tau * (2.0 * c2 + tau * (3.0 * c3 + tau * (4.0 * c4 + tau * 5.0 * c5)))
                guess = tau - rest / slope if slope > 0.0 else -1.0
                tau = guess if low < guess < high else 0.5 * (low + high)
        v = (c1 + tau * (2.0 * c2 + tau * (3.0 * c3 + tau * (4.0 * c4 + tau * 5.0 * c5)))) / period
        a = (2.0 * c2 + tau * (6.0 * c3 + tau * (12.0 * c4 + tau * 20.0 * c5))) / period**2
        d = (6.0 * c3 + tau * (24.0 * c4 + tau * 60.0 * c5)) / period**3
        if v < -1e-9 * h / period or ((v <= 0.0) and 0 < j < n - 1):
            return BACKWARDS + abs(v) * period / h, -1
        if v * pace[j] > worst:
            worst, which = v * pace[j], 0
        for i in range(m):
            value = abs(share[j, 0, i] * v)
            if value > worst:
                worst, which = value, 1 + i
            value = abs(share[j, 1, i] * v * v + share[j, 2, i] * a)
            if value > worst:
                worst, which = value, 1 + m + i
            value = abs(share[j, 3, i] * v * v * v + share[j, 4, i] * v * a + share[j, 5, i] * d)
            if value > worst:
                worst, which = value, 1 + 2 * m + i
    return worst, which


@jit()
def comfortable(x: Floats, share: Floats, pace: Floats, ends: Floats, enough: float) -> tuple[float, float, int]:
    """The period of least usage, that usage, and what it is of; the search ends early where `enough` is met."""
    mean = 2.0 * x[-1] / (ends[0] + ends[2])
    best, period, which = np.inf, mean, 0
    for k in range(SEARCH):
        # from the mean speed outwards
        step = (k + 1) // 2 * (1.0 if k % 2 else -1.0)
        trial = mean * 1.035**step
        value, kind = usage(x, share, pace, ends, trial)
        if value < best:
            best, period, which = value, trial, kind
            if best <= enough:
                return period, best, which
    width = 0.035 * period
    for _ in range(5):
        for sign in (-1.0, 1.0):
            trial = period + 0.5 * sign * width
            value, kind = usage(x, share, pace, ends, trial)
            if value < best:
                best, period, which = value, trial, kind
                if best <= enough:
                    return period, best, which
                break
        width *= 0.5
    return period, best, which


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
    x: Floats, share: Floats, pace: Floats, speed: Floats, acceleration: Floats, fixed: Ints, reserve: float, most: int
) -> tuple[Floats, int, float, int]:
    """Lower the preset speeds (n + 1,) in place until every interval has a law with at most `reserve` usage.

    x (n, nodes), share (n, nodes, 6, m), pace (n, nodes) by interval; `fixed` (n + 1,) points stay as they are.
    Returns the periods (n,) of those laws, -1 or the interval where none was found, its usage and what it is of.
    """
    n = len(x)
    h = x[:, -1].copy()
    period, value, which = np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.int64)
    dirty = np.ones(n, dtype=np.bool_)
    ends = np.empty(4)
    before = np.empty(n + 1)
    bad = -1
    for _ in range(most):
        before[:] = acceleration
        slopes(h, speed, acceleration, fixed)
        for k in range(n + 1):
            if acceleration[k] != before[k]:
                dirty[max(k - 1, 0)] = True
                dirty[min(k, n - 1)] = True
        bad = -1
        for k in range(n):
            if dirty[k]:
                ends[0], ends[1], ends[2], ends[3] = speed[k], acceleration[k], speed[k + 1], acceleration[k + 1]
                period[k], value[k], which[k] = comfortable(x[k], share[k], pace[k], ends, reserve)
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
def raise_speeds(
    x: Floats,
    share: Floats,
    pace: Floats,
    speed: Floats,
    acceleration: Floats,
    fixed: Ints,
    reserve: float,
    period: Floats,
) -> None:
    """Raise preset speeds in place, single ones and hills of several, as long as every interval keeps a law.

    Arrays as in `preset`, whose result `period` is brought up to date.
    """
    n = len(x)
    h = x[:, -1].copy()
    ends, trial_speed, trial_acceleration = np.empty(4), speed.copy(), acceleration.copy()
    trial_period = period.copy()
    rounds = max(2, min(12, 1200 // n))
    for step in (0.12, 0.06, 0.03, 0.015):
        for _ in range(rounds):
            raised = 0
            for width in (8, 4, 2, 1):
                for k in range(1, n):
                    trial_speed[:] = speed
                    for i in range(max(k - width + 1, 1), min(k + width, n)):
                        if not fixed[i]:
                            trial_speed[i] *= 1.0 + step * (1.0 - abs(i - k) / width)
                    trial_acceleration[:] = acceleration
                    slopes(h, trial_speed, trial_acceleration, fixed)
                    fine = True
                    for j in range(max(k - width - 1, 0), min(k + width + 1, n)):
                        ends[0], ends[1] = trial_speed[j], trial_acceleration[j]
                        ends[2], ends[3] = trial_speed[j + 1], trial_acceleration[j + 1]
                        trial_period[j], value, _ = comfortable(x[j], share[j], pace[j], ends, reserve)
                        if value > reserve:
                            fine = False
                            break
                    if fine:
                        raised += 1
                        speed[:] = trial_speed
                        acceleration[:] = trial_acceleration
                        for j in range(max(k - width - 1, 0), min(k + width + 1, n)):
                            period[j] = trial_period[j]
            if raised == 0:
                break

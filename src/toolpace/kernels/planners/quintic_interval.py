"""The limit utilisation of quintic time laws over path intervals.

Source: Wu, Li, Liu, Perez, ACC 2009, section II.C: over the time period T of an interval the parameter moves as the
quintic that has the preset speed and acceleration at both reference points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

BACKWARDS = 1e6
"""Usage of a law that runs backwards, plus how far."""
STRIDES = 20
"""Equal times at which a law must run forwards, beside the nodes."""
SEARCH = 40
"""Periods tried for the most comfortable law of an interval."""


class Interval(NamedTuple):
    """What an interval asks of the limits at its nodes; of several intervals, with a dimension more in front."""

    x: Floats
    """(nodes,) distances from the start of the interval."""
    share: Floats
    """(nodes, 6, m) path derivatives over the limits: q'/v, q''/a, q'/a, q'''/j, 3 q''/j, q'/j."""
    pace: Floats
    """(nodes,) one over the speed cap."""


@jit()
def interval_of(several: Interval, k: int) -> Interval:
    """One of several intervals."""
    return Interval(several.x[k], several.share[k], several.pace[k])


@jit()
def speed_at(c: tuple[float, float, float, float, float], tau: float) -> float:
    """Derivative at tau of the quintic with the coefficients C1 to C5."""
    c1, c2, c3, c4, c5 = c
    return c1 + tau * (2.0 * c2 + tau * (3.0 * c3 + tau * (4.0 * c4 + tau * 5.0 * c5)))


@jit()
def time_at(c: tuple[float, float, float, float, float], x: float, guess: float, low: float, accuracy: float) -> float:
    """Time in [low, 1] at which the quintic with the coefficients C1 to C5 passes x: Newton, held in by bisection."""
    c1, c2, c3, c4, c5 = c
    high = 1.0
    tau = guess if low < guess < high else 0.5 * (low + high)
    for _ in range(60):
        rest = tau * (c1 + tau * (c2 + tau * (c3 + tau * (c4 + tau * c5)))) - x
        if abs(rest) <= accuracy:
            break
        if rest > 0.0:
            high = tau
        else:
            low = tau
        slope = speed_at(c, tau)
        guess = tau - rest / slope if slope > 0.0 else -1.0
        tau = guess if low < guess < high else 0.5 * (low + high)
    return tau


@jit()
def law(
    h: float, v0: float, a0: float, v1: float, a1: float, period: float
) -> tuple[float, float, float, float, float]:
    """C1 to C5, Eq. (7b), of the quintic in t / period from 0 to h with speeds and accelerations at its ends."""
    c1, c2 = v0 * period, a0 * period * period / 2.0
    d1, d2, d3 = h - c1 - c2, v1 * period - c1 - 2.0 * c2, a1 * period * period / 2.0 - c2
    return c1, c2, 10.0 * d1 - 4.0 * d2 + d3, -15.0 * d1 + 7.0 * d2 - 2.0 * d3, 6.0 * d1 - 3.0 * d2 + d3


@jit()
def usage_at(interval: Interval, j: int, v: float, a: float, d: float, worst: float, which: int) -> tuple[float, int]:
    """Largest of `worst` and the values over limit at node j with ds/dt = v and two more derivatives, and of what."""
    _, share, pace = interval
    m = share.shape[2]
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
def usage(interval: Interval, ends: Floats, period: float, enough: float, first: int) -> tuple[float, int, int]:
    """Largest value over limit at the nodes; what it is of: 0 feed, then 1 + kind * m + joint, -1 backwards; its node.

    ends (4,): speed and acceleration at the start, then at the end. Where `enough` is reached, the search ends with
    what was found so far; it begins at the node `first`, unless that is -1.
    """
    x = interval.x
    n = len(x)
    h = x[n - 1]
    c = law(h, ends[0], ends[1], ends[2], ends[3], period)
    _, c2, c3, c4, c5 = c
    # from rest and to rest the third derivative decides which way the first and last step go
    if ends[0] == 0.0 and ends[1] == 0.0 and c3 <= 0.0:
        return BACKWARDS + abs(c3) / h, -1, -1
    if ends[2] == 0.0 and ends[3] == 0.0 and 6.0 * c3 + 24.0 * c4 + 60.0 * c5 <= 0.0:
        return BACKWARDS + abs(6.0 * c3 + 24.0 * c4 + 60.0 * c5) / h, -1, -1
    for j in range(1, STRIDES):
        tau = j / STRIDES
        v = speed_at(c, tau)
        if v <= 0.0:
            return BACKWARDS + abs(v) / h, -1, -1
    worst, which, node = 0.0, 0, first
    if 0 < first < n - 1:
        tau = time_at(c, x[first], x[first] / h, 0.0, 1e-11 * h)
        v = speed_at(c, tau) / period
        a = (2.0 * c2 + tau * (6.0 * c3 + tau * (12.0 * c4 + tau * 20.0 * c5))) / period**2
        d = (6.0 * c3 + tau * (24.0 * c4 + tau * 60.0 * c5)) / period**3
        worst, which = usage_at(interval, first, v, a, d, worst, which)
        if worst >= enough:
            return worst, which, first
        worst, which = 0.0, 0
    tau = 0.0
    for j in range(n):
        if j == n - 1:
            tau = 1.0
        elif j > 0:
            slope = speed_at(c, tau)
            guess = tau + (x[j] - x[j - 1]) / slope if slope > 0.0 else 2.0
            tau = time_at(c, x[j], guess, tau, 1e-11 * h)
        v = speed_at(c, tau) / period
        a = (2.0 * c2 + tau * (6.0 * c3 + tau * (12.0 * c4 + tau * 20.0 * c5))) / period**2
        d = (6.0 * c3 + tau * (24.0 * c4 + tau * 60.0 * c5)) / period**3
        if v < -1e-9 * h / period or ((v <= 0.0) and 0 < j < n - 1):
            return BACKWARDS + abs(v) * period / h, -1, -1
        here, kind = usage_at(interval, j, v, a, d, worst, which)
        if here > worst:
            worst, which, node = here, kind, j
            if worst >= enough:
                break
    return worst, which, node


@jit()
def comfortable(interval: Interval, ends: Floats, enough: float) -> tuple[float, float, int]:
    """The period of least usage, that usage, and what it is of; the search ends early where `enough` is met."""
    mean = 2.0 * interval.x[-1] / (ends[0] + ends[2])
    best, period, which, node = np.inf, mean, 0, -1
    for k in range(SEARCH):
        # from the mean speed outwards
        step = (k + 1) // 2 * (1.0 if k % 2 else -1.0)
        trial = mean * 1.035**step
        value, kind, at = usage(interval, ends, trial, best, node)
        node = at if at >= 0 else node
        if value < best:
            best, period, which = value, trial, kind
            if best <= enough:
                return period, best, which
    width = 0.035 * period
    for _ in range(5):
        for sign in (-1.0, 1.0):
            trial = period + 0.5 * sign * width
            value, kind, at = usage(interval, ends, trial, best, node)
            node = at if at >= 0 else node
            if value < best:
                best, period, which = value, trial, kind
                if best <= enough:
                    return period, best, which
                break
        width *= 0.5
    return period, best, which

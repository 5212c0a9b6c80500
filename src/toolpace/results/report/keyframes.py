"""Keyframes: joint positions and velocities at so many times that a cubic between each two shows the motion.

    repeat
        look within each stretch: is the cubic through position and velocity of both ends within the tolerance?
        no: halve the stretch

The tolerance grows where there would be too many for a page.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.motion.trajectory import Trajectory
from toolpace.results.report.packed_arrays import LARGEST

TICK = 1e-5
"""Times are multiples of it [s]; of a larger one where a page could not number them all."""
FINE = 1e-6
"""Most distance of a joint from its motion [m], [rad]: less than a screen shows of a machine that fills it."""
COARSER = 4.0
"""By how much the tolerance grows from one try to the next."""
MOST = 40_000
"""Keyframes in a page."""
LONGEST = 0.1
"""Between two keyframes at first [s], and between those of a long motion as many times that as keep them few."""
INSIDE = (0.25, 0.5, 0.75)
"""Shares of a stretch at which the cubic is held against the motion."""


@dataclass(frozen=True)
class Keyframes:
    """n keyframes of m joints."""

    t: Floats
    """(n,) ascending, from 0 to the duration [s]."""
    q: Floats
    """(n, m) [m], [rad]"""
    qd: Floats
    """(n, m) [m/s], [rad/s]"""
    tolerance: float
    """Most distance of a joint from its motion where it was looked at [m], [rad]."""
    tick: float
    """All times but the last are multiples of it [s]."""


def keyframes(trajectory: Trajectory, most: int = MOST) -> Keyframes:
    """Those of a motion, `most` of them at the most."""
    tolerance = FINE
    while True:
        found = _within(trajectory, tolerance, most)
        if found is not None:
            return found
        tolerance *= COARSER


def _within(trajectory: Trajectory, tolerance: float, most: int) -> Keyframes | None:
    """Those that are within a tolerance; None where these are too many."""
    end = trajectory.duration
    count = int(min(max(np.ceil(end / LONGEST), 2), max(most // 2, 2)))
    tick = max(TICK, end / LARGEST)
    # so many stops that they alone would be too many are found like all else
    starts = trajectory.starts if len(trajectory.starts) <= most // 4 else np.zeros(0)
    grid = np.concatenate([np.linspace(0.0, end, count + 1)[:-1], starts[starts < end]])
    ticks = np.unique(np.append(np.round(grid / tick), np.ceil(end / tick)).astype(np.int64))
    t = np.minimum(ticks * tick, end)
    q, qd = _motion(trajectory, t)
    # a new keyframe is put into the middle of its stretch, and both halves are looked at again
    waiting = np.ones(len(t) - 1, dtype=np.bool_)
    while waiting.any():
        left = np.flatnonzero(waiting)
        poor = left[_is_off(trajectory, t, q, qd, left, tolerance)]
        middle = (ticks[poor] + ticks[poor + 1]) // 2
        poor, middle = poor[middle > ticks[poor]], middle[middle > ticks[poor]]
        if len(t) + len(poor) > most:
            return None
        between = np.minimum(middle * tick, end)
        q_new, qd_new = _motion(trajectory, between)
        waiting = np.zeros(len(t) - 1, dtype=np.bool_)
        waiting[poor] = True
        waiting = np.insert(waiting, poor, True)
        ticks, t = np.insert(ticks, poor + 1, middle), np.insert(t, poor + 1, between)
        q, qd = np.insert(q, poor + 1, q_new, axis=0), np.insert(qd, poor + 1, qd_new, axis=0)
    return Keyframes(t, q, qd, tolerance, tick)


def _motion(trajectory: Trajectory, t: Floats) -> tuple[Floats, Floats]:
    motion = trajectory.at(t)
    return motion.q, motion.qd


def _is_off(trajectory: Trajectory, t: Floats, q: Floats, qd: Floats, left: np.ndarray, tolerance: float) -> Bools:
    """(k,) whether the cubic of each stretch that begins at keyframe `left` (k,) leaves the motion."""
    off = np.zeros(len(left), dtype=np.bool_)
    length = (t[left + 1] - t[left])[:, None]
    for share in INSIDE:
        true = trajectory.at(t[left] + share * length[:, 0]).q
        shown = cubic(q[left], qd[left] * length, q[left + 1], qd[left + 1] * length, share)
        off |= (np.abs(shown - true) > tolerance).any(axis=1)
    return off


def cubic(begin: Floats, slope: Floats, end: Floats, end_slope: Floats, share: float) -> Floats:
    """Hermite's cubic at a share of its stretch; slopes are over the whole stretch."""
    u, w = share, 1.0 - share
    value: Floats = w * w * (begin * (1.0 + 2.0 * u) + slope * u) + u * u * (end * (1.0 + 2.0 * w) - end_slope * w)
    return value

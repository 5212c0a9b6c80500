"""The utilisation of limits, travel and feed by a rejoin motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.feed import feed_at, feed_changes, feed_used, tip_velocity
from toolpace.deflection.rejoin.joint_splines import Problem
from toolpace.deflection.rejoin.stop import StopTogether
from toolpace.deflection.rejoin.superposed import RestartFromRest, SuperposedRejoin
from toolpace.deflection.rejoin_motion import RejoinMotion
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.rows import Rows
from toolpace.planning.limit_tolerances import DETOUR, PROMISED

SAMPLES, FINAL = 6, 64
"""Looks in each step of a way: while one is searched, and before it is taken."""
CLOSER, BETWEEN = 3, 9
"""Closer looks at what lies beside a jump of the jerk, and the instants of each between two."""
JUMP, NEAR = 0.01, 0.95
"""Change of the jerk between two instants, over its limit, that may hide more where it is so near the limit."""
RISE = 1.1
"""Times the feed to which the acceleration of the start may carry the tip while all joints brake in proportion."""
START_RISE = 1.001
"""Times the use of a row at the start, where it is above its limit, that is rounding of the looks after it."""
ROUNDING = 1e-9
"""Of positions against travel [m or rad]."""


@dataclass(frozen=True, eq=False)
class LimitCheck:
    """What a way uses of its limits."""

    joints: float
    feed: float
    inside: bool
    """Whether it keeps to travel."""
    above: float
    """Until when the tip is above the feed at the start [s]."""

    @property
    def passes(self) -> bool:
        """Whether it holds all."""
        return self.inside and self.joints <= DETOUR and self.feed <= DETOUR


def check_limits(problem: Problem, rejoin: SuperposedRejoin | RestartFromRest, samples: int) -> LimitCheck:
    """At a way, so many times in each step."""
    inner = np.arange(samples) / samples
    t = np.append((rejoin.times[:-1, None] + np.diff(rejoin.times)[:, None] * inner).ravel(), rejoin.duration)
    q, *rates = rejoin.motion(t)
    low, high = problem.travel.T
    inside = bool((q >= low - ROUNDING).all() and (q <= high + ROUNDING).all())
    limits = [getattr(problem.limits, kind) for kind in KINDS]
    joints = max(float((np.abs(rate) / limit).max()) for rate, limit in zip(rates, limits))
    if samples == FINAL:
        joints = max(joints, at_jumps(rejoin, t, rates[2] / limits[2], limits[2]))
    if problem.limits.rows:
        joints = max(joints, rows_used(problem.limits, np.stack([q, *rates])))
    feed, above = 0.0, 0.0
    if problem.machine is not None:
        allowed = feed_at(problem.commanded.run, rejoin.abreast(t))
        if np.isfinite(allowed).any():
            ratio = np.linalg.norm(tip_velocity(problem.machine, q, rates[0]), axis=1) / allowed
            changes = feed_changes(rejoin, t) if samples == FINAL else t[:0]
            if len(changes):
                order = np.argsort(np.append(t, changes), kind="stable")
                ratio = np.append(ratio, feed_used(rejoin, problem.machine, changes))[order]
                t = np.append(t, changes)[order]
            # what the start is above the feed by cannot be changed at once: it may not rise, but for its acceleration
            over = np.logical_and.accumulate(ratio > DETOUR)
            most = ratio[0] * 1.05 if over[0] else 1.0
            excused = over & (ratio <= most)
            if isinstance(rejoin.before, StopTogether):
                excused |= (t < rejoin.wait) & (ratio > DETOUR) & (ratio <= RISE)
            if excused.any():
                above = float(t[min(int(np.flatnonzero(excused)[-1]) + 1, len(t) - 1)])
            feed = float(np.where(excused, 0.0, ratio).max())
    return LimitCheck(joints, feed, inside, above)


def row_use(rows: Sequence[Rows], motion: Floats) -> Floats:
    """(n,) the largest share of rows, torques and limits over speed that a motion (4, n, m) over time uses.

    With the time as the parameter of the path ds/dt is 1. DETOUR stands for what is promised of them: the motion that
    is rejoined may use as much.
    """
    state, q = np.zeros((4, motion.shape[1])), np.ascontiguousarray(motion)
    state[1] = 1.0
    used: Floats = np.max([each.ratio(q, state) for each in rows], axis=0, initial=0.0) * (DETOUR / PROMISED)
    return used


def rows_used(limits: Limits, motion: Floats) -> float:
    """The largest share of rows, torques and limits over speed, of what a motion (4, n, m) over time is free to choose.

    In the pose that was found the accelerations commanded may take more than a limit, and no command changes that at
    once: it may not rise, and is excused until it is within the limit. Jerk may change at once.
    """
    worst = 0.0
    for each in limits.rows:
        use = row_use((each,), motion)
        if each.order == 1:
            use[np.logical_and.accumulate(use > DETOUR) & (use <= use[0] * START_RISE)] = 0.0
        worst = max(worst, float(use.max()))
    return worst


def at_jumps(rejoin: RejoinMotion, t: Floats, share: Floats, jerk: Floats) -> float:
    """Most that jerks come to beside their jumps: `share` (n, m) of the limits at times (n,), looked at closer."""
    worst = 0.0
    for _ in range(CLOSER):
        steep = (np.abs(np.diff(share, axis=0)) > JUMP) & (np.maximum(np.abs(share[1:]), np.abs(share[:-1])) > NEAR)
        k = np.flatnonzero(steep.any(axis=1))
        if len(k) == 0:
            break
        ends = np.stack([t[k], t[k + 1]])
        t = np.unique(ends[0] + (ends[1] - ends[0]) * np.linspace(0.0, 1.0, BETWEEN)[:, None])
        share = rejoin.motion(t)[3] / jerk
        worst = max(worst, float(np.abs(share).max()))
    return worst

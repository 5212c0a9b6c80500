"""A verdict on a run from its set-points, the machine and the plan; nothing of the follower's own reckoning counts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.followed.cases import Case
from toolpace.common.arrays import Bools, Floats
from toolpace.deflection.following import Follower, Status
from toolpace.kernels.follow import layout as at

MOST = 1.0 + 1e-4
"""Of a limit."""
SEEN = 1e-15
"""What a position may be off by for rounding, of its size."""


@dataclass(frozen=True)
class Verdict:
    """Worst figures of a run."""

    limits: Floats
    """(3,) most velocity, acceleration and jerk over their limits, by differences of the set-points."""
    feed: float
    """Most speed of the tip over the feed that is allowed, the stated excess included."""
    travel: float
    """How far a joint is beyond its travel, or the correction beyond its range [m or rad]."""
    off_path: float
    """How far set-points less their correction are from the plan, over what is stated."""
    ended: bool
    reason: Status
    """What was said last, where the path was not gone through."""
    said: Status
    """All that was said."""
    jumps: int

    @property
    def fine(self) -> bool:
        """Whether all is kept."""
        kept = max(*self.limits, self.feed, self.off_path) <= MOST and self.travel <= 1e-9
        return bool(kept and (self.ended or self.reason & (Status.STOPPING | Status.HELD)))


def judged(follower: Follower, case: Case, override: Floats, out: Floats) -> Verdict:
    """The verdict on a run (n, OUTPUTS) from rest at the start of the plan; override (k,) is 1 after its end."""
    status = out[:, at.STATUS].astype(np.int64)
    q, own = out[:, at.Q : at.Q + 5], out[:, at.OUT_CORRECTION : at.OUT_CORRECTION + 5]
    if not np.isfinite(out).all():
        raise AssertionError("a set-point is not a number")
    start = case.trajectory.at(0.0).q
    whole = np.vstack([np.tile(start, (3, 1)), q])
    jumped = np.concatenate([np.zeros(3, dtype=bool), (status & Status.JUMPED) > 0])
    machine, period = case.machine, follower.period
    limits = (machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk)
    used = np.array([worst(whole, jumped, order, period, limit) for order, limit in enumerate(limits, 1)])
    plan_time = np.minimum(out[:, at.PATH_TIME], case.trajectory.duration)
    path = case.trajectory.at(plan_time).q
    stated = follower.off_the_plan + 1e-9
    low, high = machine.travel.T
    most = np.where(machine.is_rotary, follower.piece[at.MOST_TURN], follower.piece[at.MOST])
    beyond = max(float((q - high).max()), float((low - q).max()), float((np.abs(own) - most).max()))
    said = Status(int(np.bitwise_or.reduce(status)))
    return Verdict(
        used,
        feed_used(follower, case, whole[2:], override, out),
        beyond,
        float(np.abs(q - own - path).max()) / stated,
        bool(status[-1] & Status.ENDED),
        Status(int(status[-1])),
        said,
        int(jumped.sum()),
    )


def worst(q: Floats, jumped: Bools, order: int, period: float, limit: Floats) -> float:
    """Most of a derivative over its limit (m,), by differences that span no jump of state."""
    difference = np.abs(np.diff(q, order, axis=0))
    for k in range(order):
        difference[jumped[order - k : len(q) - k]] = 0.0
    rounding = 2.0**order * SEEN * np.maximum(np.abs(q).max(axis=0), 0.1)
    return float((np.maximum(difference - rounding, 0.0) / (period**order * limit)).max())


def feed_used(follower: Follower, case: Case, q: Floats, override: Floats, out: Floats) -> float:
    """Most speed of the tip over what is allowed: feed times override, or pace where that is behind, and the stated
    excess of the feed."""
    tip = case.machine.forward(q)[0]
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / follower.period
    speed[(out[:, at.STATUS].astype(np.int64) & Status.JUMPED) > 0] = 0.0
    time = np.concatenate([[0.0], out[:, at.PATH_TIME]])
    # the spline through the samples blends over half a sample and more: at the border of two blocks either feed holds
    reach = 4.0 * float(follower.piece[at.STEP]) * follower.pace
    ends = [case.feed(np.clip(time + shift, 0.0, case.trajectory.duration)) for shift in (-reach, reach)]
    feed = np.maximum(*ends)
    feed = np.maximum(feed[1:], feed[:-1])
    pace = np.concatenate([[1.0], out[:, at.OUT_PACE]])
    asked = np.ones(len(out))
    asked[: len(override)] = np.clip(np.nan_to_num(override[: len(out)]), 0.0, 1.2)
    pace = np.maximum(np.maximum(pace[1:], pace[:-1]), asked) * follower.pace
    allowed = feed * (pace + follower.feed_excess) + 2.0 * SEEN / follower.period
    return float((speed / allowed).max())

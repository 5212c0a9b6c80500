"""Whether a detour can be driven: limits of the joints, feed of the tip, travel."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats
from toolpace.deflect.commanded import CommandedMotion
from toolpace.deflect.detour import Detour
from toolpace.deflect.feed import FeedExcess, feed_at, tip_velocity
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine
from toolpace.planning.guarantee import DETOUR

CARRIED = 0.2
"""How far ahead the carrying on is looked at where nothing passes else [s]."""
MORE_EXCESS = 1.1
"""What the tip is then allowed, over the excess that was seen: between the samples it may be a little more."""
TIP_SAMPLES = 81
"""Places along the quintic at which the tip is looked at; the peak between three of them is that of a parabola."""
CLOSE_SAMPLES = 9
"""Places in the first two steps of these, closer towards the start, where the tip may just touch the feed."""
CARRY_STEP = 2e-3
"""Time between two looks at the tip while the joints carry on: it moves there as the commanded motion does [s]."""
IN_TRAVEL = 1e-9
"""How far out of travel a joint may be by rounding [m or rad]."""
REST_TO_REST = (1.875, 5.7735, 60.0)
"""Peak of the first three derivatives of the quintic 10 t^3 - 15 t^4 + 6 t^5 from 0 to 1: 15/8, 10/sqrt(3), 60."""


class Feasibility:
    """Whether a detour keeps to the limits of joints, feed and travel, and how far those were from it that do not."""

    def __init__(
        self, commanded: CommandedMotion, limits: Limits, machine: Machine | None, time: float, offset: Floats
    ) -> None:
        """Take the motion, and its time at which its joints are found at an `offset` (m,)."""
        self.commanded, self.machine, self.time, self.offset = commanded, machine, time, offset
        self.feed = feed_at(commanded, machine, time)
        self.limits = np.stack([getattr(limits, kind) for kind in KINDS])
        """(3, m) of velocity, acceleration and jerk."""
        self.nearest, self.nearest_of = np.inf, "a limit"
        """Least usage seen of a detour that did not pass, and of what."""
        self.excess = FeedExcess.at_start(machine, self.feed, commanded.motion(np.array([time])), offset)

    def detour(self, carry: float, period: float, rejoin: float) -> Detour:
        """The one that carries on for `carry` [s] and is back at the time `rejoin` of the law after `period` more."""
        return Detour(self.commanded, self.time, self.offset, carry, period, rejoin)

    def relax(self) -> bool:
        """Allow what the tip passes the feed by if the joints just carry on for a while; whether that is more."""
        if self.machine is None or not np.isfinite(self.feed):
            return False
        motion = self.commanded.motion(self.time + np.linspace(0.0, CARRIED, TIP_SAMPLES))
        speed = np.linalg.norm(tip_velocity(self.machine, motion[0] + self.offset, motion[1]), axis=1)
        more = MORE_EXCESS * float(speed.max() - self.feed)
        if more <= self.excess.speed:
            return False
        self.excess = FeedExcess(self.feed, more, self.excess.growth)
        return True

    def joint_usage(self, carry: float, rejoin: Floats, period: Floats) -> Floats:
        """(n,) usage of the quintics alone, to rejoin at times (n,) in periods (n,)."""
        from toolpace.kernels.planners.quintic_bridge import usages

        start = self.commanded.motion(np.array([self.time + carry]))[:3, 0]
        start[0] += self.offset
        order = np.argsort(rejoin, kind="stable")
        ends = np.empty((len(rejoin), 3, len(self.offset)))
        ends[order] = self.commanded.motion(rejoin[order])[:3].transpose(1, 0, 2)
        out: Floats = usages(np.ascontiguousarray(start), ends, np.ascontiguousarray(period), self.limits)
        return out

    def needed(self) -> float:
        """Time that a quintic from rest to rest over the offset takes within the limits [s]."""
        off = np.abs(self.offset)
        v, a, j = (peak * off / limit for peak, limit in zip(REST_TO_REST, self.limits))
        return float(max(v.max(), np.sqrt(a).max(), np.cbrt(j).max()))

    def path_usage(self, detour: Detour) -> float:
        """Usage of feed and travel along a detour: above 1 where the tip is too fast or a joint leaves its travel."""
        if self.machine is None:
            return 0.0
        even = detour.carry + detour.period * np.linspace(0.0, 1.0, TIP_SAMPLES)
        # closer at the start, where the tip may just touch the feed
        close = detour.carry + (even[2] - detour.carry) * np.linspace(0.0, 1.0, CLOSE_SAMPLES) ** 2
        t = np.concatenate([np.arange(0.0, detour.carry, CARRY_STEP), close[:-1], even[2:]])
        q, qd = detour.motion(t)[:2]
        low, high = self.machine.travel.T
        if (q < low - IN_TRAVEL).any() or (q > high + IN_TRAVEL).any():
            return np.inf
        if not np.isfinite(self.feed):
            return 0.0
        speed = np.linalg.norm(tip_velocity(self.machine, q, qd), axis=1)
        ratio = speed / self.excess.allowed(t, detour.carry, detour.period)
        left, middle, right = ratio[-TIP_SAMPLES + 2 : -2], ratio[-TIP_SAMPLES + 3 : -1], ratio[-TIP_SAMPLES + 4 :]
        # the peak between samples is that of the parabola through three of them
        bend = 2.0 * middle - left - right
        peak = (bend > 0.0) & (middle >= left) & (middle >= right)
        between = middle[peak] + (right[peak] - left[peak]) ** 2 / (8.0 * bend[peak])
        return float(max(ratio.max(), between.max(initial=0.0)))

    def passes(self, detour: Detour, joints: float | None = None) -> bool:
        """Whether the detour is within all limits; `joints` is its usage of theirs if it is commanded already."""
        if joints is None:
            joints = float(self.joint_usage(detour.carry, np.array([detour.rejoin]), np.array([detour.period]))[0])
        worst = joints if joints > DETOUR else max(joints, self.path_usage(detour))
        passed = worst <= DETOUR
        if not passed:
            self.note(worst, "the joints' limits" if joints > DETOUR else "feed or travel")
        return passed

    def note(self, usage: float, of: str) -> None:
        """Remember the nearest of what did not pass."""
        if usage < self.nearest:
            self.nearest, self.nearest_of = usage, of

"""The commanded joint motion at the instant of a deflection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.motion import joint_motion
from toolpace.motion.laws.law import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun

STILL = 1e-9
"""Speed of the parameter that counts as rest, relative to its mean: far below any speed of a motion under way, and far
above the rounding that is left of it where a law ends."""


@dataclass(frozen=True)
class CommandedMotion:
    """A run with the time law that was to be followed on it; it keeps to the limits."""

    run: AxisRun
    law: TimeLaw

    @classmethod
    def of(cls, trajectory: Trajectory, index: int) -> CommandedMotion:
        """That of one run of a trajectory."""
        return cls(trajectory.axis_path.runs[index], trajectory.laws[index])

    def place(self, t: Floats) -> Floats:
        """(n,) parameters at sorted times (n,) of the law, held in its range."""
        s: Floats = np.clip(self.law.at(np.clip(t, 0.0, self.law.duration))[0], self.run.s0, self.run.s1)
        return s

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at sorted times (n,) of the law, held in its range."""
        state = self.law.at(np.clip(t, 0.0, self.law.duration))
        state[0] = np.clip(state[0], self.run.s0, self.run.s1)
        moving = joint_motion(self.run.evaluate(state[0]), state)
        return np.stack([moving.q, moving.qd, moving.qdd, moving.qddd])

    def paced(self, clock: Floats) -> Floats:
        """(4, n, m) the same on a clock (4, n) with its rates; at rest before the law's start and behind its end."""
        q, v, a, j = self.motion(clock[0])
        rest = (clock[0] >= self.law.duration) | (clock[0] < 0.0)
        v[rest], a[rest], j[rest] = 0.0, 0.0, 0.0
        r, r1, r2 = clock[1:, :, None]
        return np.stack([q, r * v, r * r * a + r1 * v, r**3 * j + 3.0 * r * r1 * a + r2 * v])

    def still(self, speed: Floats) -> Bools:
        """(n,) whether these speeds of the parameter are those of rest, but for rounding."""
        resting: Bools = np.abs(speed) <= STILL * (self.run.s1 - self.run.s0) / self.law.duration
        return resting


def moment(trajectory: Trajectory, time: float) -> tuple[int, float]:
    """Run and time on its law's clock at a time of the trajectory; in a dwell the end of the law."""
    index = int(np.clip(np.searchsorted(trajectory.starts, time, side="right") - 1, 0, len(trajectory.laws) - 1))
    return index, min(time - float(trajectory.starts[index]), trajectory.laws[index].duration)

"""The commanded motion at the instant of a deflection, and the motion that rejoins it.

Where the paper joins deflection and projection by a quintic with the same velocity and acceleration at both, here the
joints start as they are moving and arrive with the motion that the commanded time law has at the point of rejoining: no
joint is asked for a jump of velocity or acceleration at either end.

        found o.__
                  `--jerk constant in each of some steps--.
    ===== run =============================================x======> run goes on, law goes on
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.motion import joint_motion
from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun

STILL = 1e-9
"""Speed of the parameter that counts as rest, relative to its mean: far below any speed of a motion under way, and far
above the rounding that is left of it where a law ends."""


class RejoinMotion(ABC):
    """Joint motion from a state to that of the commanded motion at `rejoin`."""

    commanded: CommandedMotion
    left: float
    """When the path was left, and when it is rejoined, both on the clock of the commanded law [s]."""
    rejoin: float
    times: Floats
    """(n + 1,) ends of steps since the start, between which the motion is smooth; the last is the duration [s]."""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])

    @property
    def lost(self) -> float:
        """By how much the rest of the motion comes later than without the detour [s]."""
        return self.duration - (self.rejoin - self.left)

    @abstractmethod
    def clock(self, t: Floats) -> Floats:
        """(n,) times on the clock of the commanded law that the tool is abreast of, at times since the start [s]."""

    @abstractmethod
    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at sorted times (n,) since the start."""

    def abreast(self, t: Floats) -> Floats:
        """(n,) parameters of the run that the tool is abreast of at times since the start."""
        return self.commanded.place(self.clock(t))


@dataclass(frozen=True, eq=False)
class Detour(RejoinMotion):
    """Joint motion with constant jerk in each step."""

    commanded: CommandedMotion
    left: float
    rejoin: float
    times: Floats
    knots: Floats
    """(3, n + 1, m) positions, velocities, accelerations at the ends of the steps."""
    jerks: Floats
    """(n, m) in the steps."""

    def clock(self, t: Floats) -> Floats:
        """The time that has passed in the same share, from the leaving to the rejoining."""
        on: Floats = self.left + (self.rejoin - self.left) * np.clip(t / self.duration, 0.0, 1.0)
        return on

    def motion(self, t: Floats) -> Floats:
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.jerks) - 1)
        x = (t - self.times[k])[:, None]
        q, v, a = self.knots[:, k]
        j = self.jerks[k]
        return np.stack([q + x * (v + x * (a / 2.0 + x * j / 6.0)), v + x * (a + x * j / 2.0), a + x * j, j])


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

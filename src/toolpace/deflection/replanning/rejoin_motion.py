"""The interface of a rejoin motion, and the one with joints as cubic splines of time.

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

from toolpace.common.arrays import Floats
from toolpace.deflection.replanning.commanded import CommandedMotion


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

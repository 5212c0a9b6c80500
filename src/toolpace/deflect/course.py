"""From a state in motion back onto a run: each joint a cubic spline of time.

Where the paper joins deflection and projection by a quintic with the same velocity and acceleration at both, here the
joints start as they are moving and arrive with the motion that the commanded time law has at the point of rejoining: no
joint is asked for a jump of velocity or acceleration at either end.

        found o.__
                  `--jerk constant in each of some steps--.
    ===== run =============================================x======> run goes on, law goes on
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats
from toolpace.deflect.commanded import CommandedMotion


@dataclass(frozen=True, eq=False)
class Detour:
    """Joint motion from a state to that of the commanded motion at `rejoin`, with constant jerk in each step."""

    commanded: CommandedMotion
    left: float
    """When the path was left, and when it is rejoined, both on the clock of the commanded law [s]."""
    rejoin: float
    times: Floats
    """(n + 1,) of the steps' ends since the start; the last is the duration [s]."""
    knots: Floats
    """(3, n + 1, m) positions, velocities, accelerations there."""
    jerks: Floats
    """(n, m) in the steps."""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])

    @property
    def lost(self) -> float:
        """By how much the rest of the motion comes later than without the detour [s]."""
        return self.duration - (self.rejoin - self.left)

    def abreast(self, t: Floats) -> Floats:
        """(n,) parameters of the run that the tool is abreast of at times since the start.

        The commanded law's at the time that has passed in the same share, from the leaving to the rejoining.
        """
        clock = self.left + (self.rejoin - self.left) * np.clip(t / self.duration, 0.0, 1.0)
        return self.commanded.place(clock)

    def motion(self, t: Floats) -> Floats:
        """(4, n, m) joints and three time derivatives at times (n,) since the start."""
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.jerks) - 1)
        x = (t - self.times[k])[:, None]
        q, v, a = self.knots[:, k]
        j = self.jerks[k]
        return np.stack([q + x * (v + x * (a / 2.0 + x * j / 6.0)), v + x * (a + x * j / 2.0), a + x * j, j])

"""Time laws from quintics of time between reference points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.laws.law import Probe, TimeLaw

INSIDE = 65
"""States that a probe takes in each interval, both ends included."""


class QuinticLaw(TimeLaw):
    """s(t) through reference points with given speeds and accelerations, Eq. (7b) in t / T_i over each period T_i.

    Position, speed and acceleration are continuous; the third derivative jumps at the points.
    """

    def __init__(
        self, s: Floats, speed: Floats, acceleration: Floats, periods: Floats, jerk: Floats | None = None
    ) -> None:
        """Take the points (n + 1,), the speeds and accelerations there, and the periods (n,) between [s].

        `jerk` (n,) is given where the law is a cubic in each period: in one of microseconds, the rounding of two points
        is more than what the third derivative moves them by.
        """
        from toolpace.kernels.motion.quintic import coefficients

        self.s, self.speed, self.acceleration, self.periods = s, speed, acceleration, periods
        self.times = np.concatenate([[0.0], np.cumsum(periods)])
        """(n + 1,) when the points are passed [s]."""
        for value in vars(self).values():
            value.flags.writeable = False
        self.polynomials = coefficients(self.times, s[:, None], speed[:, None], acceleration[:, None])
        if jerk is not None:
            self.polynomials[:, 3:, 0] = 0.0
            self.polynomials[:, 3, 0] = jerk * periods**3 / 6.0
        self.s0, self.s1 = float(s[0]), float(s[-1])
        self.duration = float(self.times[-1])

    def at(self, t: Floats) -> Floats:
        from toolpace.kernels.motion.quintic import evaluate

        state: Floats = evaluate(self.times, self.polynomials, np.ascontiguousarray(t, dtype=float))[:, :, 0]
        state[0] = np.clip(state[0], self.s0, self.s1)
        return state

    def probes(self) -> Iterator[Probe]:
        yield self.probe()

    def probe(self) -> Probe:
        """States between which nothing is hidden."""
        from toolpace.kernels.motion.quintic import evaluate

        n = len(self.periods)
        tau = np.linspace(0.0, 1.0, INSIDE)
        weight = np.full(INSIDE, 1.0 / (INSIDE - 1))
        weight[[0, -1]] /= 2.0
        state = np.empty((4, n, INSIDE))
        for k in range(n):
            # each interval on its own, so that its last state is that of its left side
            local = np.array([0.0, self.periods[k]])
            state[:, k] = evaluate(local, self.polynomials[k : k + 1], tau * self.periods[k])[:, :, 0]
            state[0, k, 0], state[0, k, -1] = self.s[k], self.s[k + 1]
        right = np.ones((n, INSIDE))
        right[:, -1] = 0.0
        share = self.periods[:, None] * weight
        return Probe(state.reshape(4, -1), right.ravel(), share.ravel())

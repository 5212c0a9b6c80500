"""A time law slowed down by a constant factor."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.laws.law import Probe, TimeLaw


class SlowedLaw(TimeLaw):
    """A law in which everything takes `pace` times as long."""

    def __init__(self, law: TimeLaw, pace: float) -> None:
        self.law, self.pace = law, pace
        self.s0, self.s1, self.duration = law.s0, law.s1, law.duration * pace
        self._powers = (1.0 / pace) ** np.arange(4.0)[:, None]

    @property
    def jumps(self) -> Floats:
        s, jump = self.law.jumps
        return np.stack([s, jump / self.pace**2])

    def at(self, t: Floats) -> Floats:
        state: Floats = self.law.at(t / self.pace) * self._powers
        return state

    def times_at(self, s: Floats) -> Floats:
        return self.law.times_at(s) * self.pace

    def states_at(self, s: Floats) -> Floats:
        state: Floats = self.law.states_at(s) * self._powers
        return state

    def probes(self) -> Iterator[Probe]:
        for probe in self.law.probes():
            yield Probe(probe.state * self._powers, probe.right, probe.share * self.pace)

"""The time law of a path whose parameter is time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.laws.law import CELLS_AT_A_TIME, FEWEST_PROBES, Probe, TimeLaw


class ClockLaw(TimeLaw):
    """s = t + s0: what moves, and how it comes to rest, is all in the path."""

    def __init__(self, nodes: Floats) -> None:
        """Take the times (n,) between which the path is smooth [s]."""
        self.nodes = nodes
        self.nodes.flags.writeable = False
        self.s0, self.s1 = float(nodes[0]), float(nodes[-1])
        self.duration = self.s1 - self.s0

    def at(self, t: Floats) -> Floats:
        one, none = np.ones(len(t)), np.zeros(len(t))
        return np.stack([np.clip(self.s0 + t, self.s0, self.s1), one, none, none])

    def probes(self) -> Iterator[Probe]:
        inside = np.linspace(0.0, 1.0, FEWEST_PROBES)
        weight = np.full(FEWEST_PROBES, 1.0 / (FEWEST_PROBES - 1))
        weight[[0, -1]] *= 0.5
        for first in range(0, len(self.nodes) - 1, CELLS_AT_A_TIME):
            ends = self.nodes[first : first + CELLS_AT_A_TIME + 1]
            length = np.diff(ends)[:, None]
            s = ends[:-1, None] + length * inside
            s[:, -1] = ends[1:]
            right = np.ones_like(s)
            right[:, -1] = 0.0
            none = np.zeros(s.size)
            yield Probe(np.stack([s.ravel(), none + 1.0, none, none]), right.ravel(), (length * weight).ravel())

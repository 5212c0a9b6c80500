"""Time laws with constant acceleration along the path in each cell."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.laws.law import CELLS_AT_A_TIME, Probe, TimeLaw, probes_a_cell


class LinearLaw(TimeLaw):
    """z = (ds/dt)^2 linear in s between nodes: d2s/dt2 is constant in each cell, and s(t) a parabola.

    Acceleration jumps at the nodes, so no number bounds the jerk there.
    """

    def __init__(self, nodes: Floats, z: Floats) -> None:
        """Take the nodes (n,) and z there, above zero but for the ends [1/s^2 times the square of s]."""
        self.nodes, self.z = nodes, z
        self.speed = np.sqrt(z)
        """(n,) ds/dt at the nodes."""
        periods = 2.0 * np.diff(nodes) / (self.speed[1:] + self.speed[:-1])
        self.acceleration = np.diff(self.speed) / periods
        """(n - 1,) d2s/dt2 in the cells."""
        self.times = np.concatenate([[0.0], np.cumsum(periods)])
        """(n,) when the nodes are passed [s]."""
        self.inside = np.linspace(0.0, 1.0, probes_a_cell(len(nodes)))
        """(k,) shares of a cell at which it is probed."""
        for value in vars(self).values():
            value.flags.writeable = False
        self.s0, self.s1 = float(nodes[0]), float(nodes[-1])
        self.duration = float(self.times[-1])

    def slowed(self, by: float) -> LinearLaw:
        """The same motion with z divided by a factor everywhere; only between two rests."""
        return LinearLaw(self.nodes, self.z / by)

    @property
    def jumps(self) -> Floats:
        """(2, n): every node, and by how much d2s/dt2 jumps there; from and to zero at an end at rest."""
        first, last = (self.acceleration[k] if self.z[k] == 0.0 else 0.0 for k in (0, -1))
        return np.stack([self.nodes, np.abs(np.concatenate([[first], np.diff(self.acceleration), [last]]))])

    def at(self, t: Floats) -> Floats:
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.acceleration) - 1)
        tau = np.clip(t, 0.0, self.duration) - self.times[k]
        speed, acceleration = self.speed[k], self.acceleration[k]
        s = np.clip(self.nodes[k] + tau * (speed + acceleration * tau / 2.0), self.nodes[k], self.nodes[k + 1])
        return np.stack([s, np.maximum(speed + acceleration * tau, 0.0), acceleration, np.zeros(len(k))])

    def probes(self) -> Iterator[Probe]:
        count = len(self.acceleration)
        for first in range(0, count, CELLS_AT_A_TIME):
            cells = np.arange(first, min(first + CELLS_AT_A_TIME, count))
            state, right = self.states_within(cells)
            speed = state[1].reshape(len(cells), -1)
            steps = 2.0 * (self.nodes[cells + 1] - self.nodes[cells])[:, None] * np.diff(self.inside)
            steps = steps / (speed[:, 1:] + speed[:, :-1])
            share = np.zeros_like(speed)
            share[:, :-1] += steps / 2.0
            share[:, 1:] += steps / 2.0
            yield Probe(state, right, share.ravel())

    def states_within(self, cells: Ints) -> tuple[Floats, Floats]:
        """(4, m k) states at the k places `inside` each of m cells, and 0 for those on the left side of a break."""
        low, high = self.nodes[cells][:, None], self.nodes[cells + 1]
        s = low + (high[:, None] - low) * self.inside
        s[:, -1] = high
        z = self.z[cells][:, None] * (1.0 - self.inside) + self.z[cells + 1][:, None] * self.inside
        right = np.ones_like(s)
        right[:, -1] = 0.0
        acceleration = np.repeat(self.acceleration[cells], len(self.inside))
        return np.stack([s.ravel(), np.sqrt(z.ravel()), acceleration, np.zeros(s.size)]), right.ravel()

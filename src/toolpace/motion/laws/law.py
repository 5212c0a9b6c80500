"""The interface of a time law: the path parameter and its derivatives over time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, gate_methods, number
from toolpace.common.value_objects import one_line
from toolpace.path.fit.speed_weights import SpeedWeights

PROBES = 20_000
"""Probes of a whole law, shared among its cells."""
FEWEST_PROBES, MOST_PROBES = 9, 257
"""Probes of one cell: more where a coarse mesh leaves much room between nodes."""
CELLS_AT_A_TIME = 10_000
"""Cells of a spline that are probed in one piece, to keep memory low."""
SLOWEST = 0.02
"""Least speed in the weights of a fit, as a share of the highest: what is passed more slowly weighs next to nothing."""
STEPS_OF_MEAN, MOST_STEPS = 4, 1_000_000
"""Places in the time over which that speed is a mean, and most of them in all."""
HALVINGS = 80
"""Of a duration until no time between two numbers is left: 53 for its digits, and the rest for times next to zero."""


@dataclass(frozen=True, eq=False, repr=False)
class Probe:
    """States of a time law, dense enough to see every peak between them."""

    state: Floats
    """(4, n): s, ds/dt, d2s/dt2, d3s/dt3."""
    right: Floats
    """(n,) of bool-like: 1 where the state belongs to the right side of a break at s, else 0."""
    share: Floats
    """(n,) time that each state stands for [s]; sums to the duration."""

    def __repr__(self) -> str:
        return one_line(self, f"{self.state.shape[1]} states")


class TimeLaw(ABC):
    """s(t) from s0 to s1, three times differentiable but for jumps of the third derivative."""

    s0: float
    s1: float
    duration: float
    """[s]"""

    def __repr__(self) -> str:
        return one_line(self, f"s {self.s0:.6g} to {self.s1:.6g} in {self.duration:.6g} s")

    def __init_subclass__(cls) -> None:
        """Have arrays of times and places that a caller gives go through the gate."""
        gate_methods(cls, ("at",), "t")
        gate_methods(cls, ("states_at", "times_at"), "s")

    @property
    def jumps(self) -> Floats:
        """(2, k) values of s where d2s/dt2 jumps, and by how much; none where the third derivative is bounded."""
        return np.empty((2, 0))

    @abstractmethod
    def at(self, t: Floats) -> Floats:
        """(4, n): s and three time derivatives at sorted times t (n,) in [0, duration]."""

    @abstractmethod
    def probes(self) -> Iterator[Probe]:
        """States between which nothing is hidden, in pieces that do not take much memory."""

    def lost_in_dips(self) -> float:
        """Time [s] that is lost in cells in which the pace falls far below that of both their nodes, to none at times.

        A law whose limits hold at the nodes alone may lose hours so; one whose limits hold everywhere does not.
        """
        return 0.0

    def states_at(self, s: Floats) -> Floats:
        """(4, n) the states in which places s (n,) in order are passed."""
        return self.at(self.times_at(s))

    def times_at(self, s: Floats) -> Floats:
        """(n,) when places s (n,) in order are passed [s], by bisection."""
        low, high = np.zeros(len(s)), np.full(len(s), self.duration)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            before = self.at(middle)[0] < s
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        times: Floats = 0.5 * (low + high)
        return times

    def speed_weights(self, smoothed: float, ramp: float, power: float) -> SpeedWeights:
        """Weights of a fit by the speed of this law, a mean over the time `smoothed` [s].

        ramp: time in which an acceleration builds up [s]; power: of ds/dt, see `SpeedWeights`.
        """
        count = int(np.clip(np.ceil(STEPS_OF_MEAN * self.duration / smoothed), 2, MOST_STEPS)) + 1
        t = np.linspace(0.0, self.duration, count)
        before = self.at(np.maximum(t - 0.5 * smoothed, 0.0))
        after = self.at(np.minimum(t + 0.5 * smoothed, self.duration))
        pace = (after[:3] - before[:3]) / smoothed
        least = SLOWEST * pace[0].max()
        pace[1:, pace[0] < least] = 0.0
        pace[0] = np.maximum(pace[0], least)
        return SpeedWeights(self.at(t)[0] - self.s0, pace, ramp, power)

    def passing_time(self, s: float) -> float:
        """When s is passed [s], by bisection; the start or the end where s is at or beyond it.

        Raises UsageError for what is no number.
        """
        s = number(s, f"{type(self).__name__}.passing_time: s", endless=True)
        low, high = 0.0, self.duration
        if s <= self.s0:
            return low
        if s >= self.s1:
            return high
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if self.at(np.array([middle]))[0, 0] < s:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)


gate_methods(TimeLaw, ("states_at", "times_at"), "s")


def probes_a_cell(nodes: int) -> int:
    """At how many places each cell of a law with so many nodes is probed."""
    return int(np.clip(PROBES // nodes, FEWEST_PROBES, MOST_PROBES))

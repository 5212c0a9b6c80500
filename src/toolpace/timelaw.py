"""How the path parameter moves over time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
PROBES = 20_000
FEWEST_PROBES, MOST_PROBES = 9, 65
"""Probes of a whole law, and of one of its cells: more where a coarse mesh leaves much room between nodes."""
CELLS_AT_A_TIME = 10_000
"""Cells of a spline that are probed in one piece, to keep memory low."""


@dataclass(frozen=True)
class Probe:
    """States of a time law, dense enough to see every peak between them."""

    state: Floats
    """(4, n): s, ds/dt, d2s/dt2, d3s/dt3."""
    right: Floats
    """(n,) of bool-like: 1 where the state belongs to the right side of a break at s, else 0."""
    share: Floats
    """(n,) time that each state stands for [s]; sums to the duration."""


class TimeLaw(ABC):
    """s(t) from s0 to s1, three times differentiable but for jumps of the third derivative."""

    s0: float
    s1: float
    duration: float
    """[s]"""

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


def probes_a_cell(nodes: int) -> int:
    """At how many places each cell of a law with so many nodes is probed."""
    return int(np.clip(PROBES // nodes, FEWEST_PROBES, MOST_PROBES))


class SplineLaw(TimeLaw):
    """(ds/dt)^2 a twice differentiable cubic spline of s; next to rest, ds/dt has a constant third derivative.

    Between nodes, time is the integral of ds / sqrt(z), by Gauss' rule with eight points; its inverse by Newton.
    """

    def __init__(self, nodes: Floats, c: Floats, rest: tuple[float, float]) -> None:
        """Take the spline's knots (n,), its coefficients (n + 2,) and the lengths of the rest cells (0: in motion)."""
        from toolpace.kernels import speedlaw

        self.nodes, self.c, self.rest = nodes, c, rest
        self.inside = (1.0 - np.cos(np.linspace(0.0, np.pi, probes_a_cell(len(nodes))))) / 2.0
        """(k,) shares of a cell at which it is probed: closer together next to the nodes, where peaks hide."""
        self.cells = speedlaw.polynomials(nodes, c)
        """(n - 1, 4) z in each cell as a polynomial of s - nodes[k]."""
        self.times = speedlaw.node_times(nodes, self.cells, rest[0], rest[1])
        """(n,) when the nodes are passed [s]."""
        self.s0, self.s1 = nodes[0] - rest[0], nodes[-1] + rest[1]
        end = speedlaw.end_speed(nodes, self.cells)
        self.duration = float(self.times[-1] + (3.0 * rest[1] / end if rest[1] > 0.0 else 0.0))

    def slowed(self, by: float) -> SplineLaw:
        """The same motion with z divided by a factor everywhere; only between two rests."""
        return SplineLaw(self.nodes, self.c / by, self.rest)

    def z_at_nodes(self) -> Floats:
        """(n,) (ds/dt)^2 at the nodes."""
        last = self.cells[-1] @ np.power(self.nodes[-1] - self.nodes[-2], np.arange(4.0))
        return np.append(self.cells[:, 0], last)

    def dips(self) -> npt.NDArray[np.bool_]:
        """(n - 1,) cells in which z falls far below its values at both nodes: too long for the motion in them."""
        from toolpace.kernels import speedlaw

        marks: npt.NDArray[np.bool_] = speedlaw.dips(self.nodes, self.cells, self.inside)
        return marks

    def at(self, t: Floats) -> Floats:
        from toolpace.kernels import speedlaw

        t = np.ascontiguousarray(t, dtype=float)
        state: Floats = speedlaw.states(
            t, self.nodes, self.cells, self.times, self.rest[0], self.rest[1], self.duration
        )
        return state

    def probes(self) -> Iterator[Probe]:
        from toolpace.kernels import speedlaw

        last = len(self.nodes) - 1
        for first in range(0, last, CELLS_AT_A_TIME):
            state, right, share = speedlaw.probe(
                self.nodes, self.cells, self.times, self.rest[0], self.rest[1], self.duration, self.inside, first,
                min(first + CELLS_AT_A_TIME, last),
            )  # fmt: skip
            yield Probe(state, right, share)

    def states_within(self, cells: Ints) -> tuple[Floats, Floats]:
        """(4, m k) states at the k places `inside` each of m cells, and 0 for those on the left side of a break."""
        from toolpace.kernels import speedlaw

        state, right = speedlaw.within(self.nodes, self.cells, cells, self.inside)
        return state, right

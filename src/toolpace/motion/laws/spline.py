"""Time laws with (ds/dt)^2 as a cubic spline of s: those of the optimal planner."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.motion.laws.law import CELLS_AT_A_TIME, Probe, TimeLaw, probes_a_cell


class SplineLaw(TimeLaw):
    """(ds/dt)^2 a twice differentiable cubic spline of s; next to rest, ds/dt has a constant third derivative.

    Between nodes, time is the integral of ds / sqrt(z), exact to rounding (kernels/motion/spline_law.py), and s at a
    time its inverse: positions are the integral of the velocities on any mesh.
    """

    def __init__(self, nodes: Floats, c: Floats, rest: tuple[float, float]) -> None:
        """Take the spline's knots (n,), its coefficients (n + 2,) and the lengths of the rest cells (0: in motion)."""
        from toolpace.kernels.motion import spline_law

        self.nodes, self.c, self.rest = nodes, c, rest
        self.inside = (1.0 - np.cos(np.linspace(0.0, np.pi, probes_a_cell(len(nodes))))) / 2.0
        """(k,) shares of a cell at which it is probed: closer together next to the nodes, where peaks hide."""
        self.cells = spline_law.polynomials(nodes, c)
        """(n - 1, 4) z in each cell as a polynomial of s - nodes[k]."""
        begin = 3.0 * rest[0] / math.sqrt(self.cells[0, 0]) if rest[0] > 0.0 else 0.0
        panels = spline_law.panels_of(nodes, self.cells, begin)
        self.times = spline_law.node_times(panels, nodes)
        """(n,) when the nodes are passed [s]."""
        self.s0, self.s1 = nodes[0] - rest[0], nodes[-1] + rest[1]
        end = spline_law.end_speed(nodes, self.cells)
        self.duration = float(self.times[-1] + (3.0 * rest[1] / end if rest[1] > 0.0 else 0.0))
        self._law = spline_law.Law(nodes, self.cells, self.times, panels, float(rest[0]), float(rest[1]), self.duration)

    def slowed(self, by: float) -> SplineLaw:
        """The same motion with z divided by a factor everywhere; only between two rests."""
        return SplineLaw(self.nodes, self.c / by, self.rest)

    def z_at_nodes(self) -> Floats:
        """(n,) (ds/dt)^2 at the nodes."""
        last = self.cells[-1] @ np.power(self.nodes[-1] - self.nodes[-2], np.arange(4.0))
        return np.append(self.cells[:, 0], last)

    def dips(self) -> Bools:
        """(n - 1,) cells in which z falls far below its values at both nodes: too long for the motion in them."""
        from toolpace.kernels.motion import spline_law

        return spline_law.dips(self.nodes, self.cells, self.inside)

    def lost_in_dips(self) -> float:
        dips = self.dips()
        ends = np.sqrt(self.z_at_nodes())
        spent, level = np.diff(self.times)[dips], (2.0 * np.diff(self.nodes) / (ends[:-1] + ends[1:]))[dips]
        return float((spent - level).sum())

    def at(self, t: Floats) -> Floats:
        from toolpace.kernels.motion import spline_law

        t = np.ascontiguousarray(t, dtype=float)
        return spline_law.states(t, self._law)

    def states_at(self, s: Floats) -> Floats:
        from toolpace.kernels.motion import spline_law

        return spline_law.states_at(np.ascontiguousarray(s), self._law)

    def probes(self) -> Iterator[Probe]:
        from toolpace.kernels.motion import spline_law

        last = len(self.nodes) - 1
        for first in range(0, last, CELLS_AT_A_TIME):
            state, right, share = spline_law.probe(self._law, self.inside, first, min(first + CELLS_AT_A_TIME, last))
            yield Probe(state, right, share)

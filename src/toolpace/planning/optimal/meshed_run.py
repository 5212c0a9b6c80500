"""A run on its mesh: what there is of the whole of it. Problems, which take much memory, are cut from it."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import EndState
from toolpace.planning.guarantee import ALLOWED
from toolpace.planning.mesh.guess import Guess, ramp_time
from toolpace.planning.mesh.nodes import cut_cells
from toolpace.planning.optimal.dips import on_finer_mesh
from toolpace.planning.optimal.problem import OnMesh, Problem, discretise
from toolpace.planning.peaks import cell_peaks
from toolpace.workers import Workers

LEAST_REACH = 40
"""Fewest nodes on either side of a place that is mended."""
KEPT = 12_000
"""Nodes up to which the problem of the whole run is kept."""
BESIDE = 2
"""Knots on either side of a stretch that its basis functions know."""
INSIDE = EndState(1.0)
"""Any motion, where a stretch ends inside the run."""


class MeshedRun(OnMesh):
    """The mesh of a run, by how much its limits are lowered at each node, and about when the nodes are passed."""

    def __init__(
        self,
        run: AxisRun,
        limits: Limits,
        nodes: Floats,
        ends: tuple[EndState, EndState],
        highest: float,
        passed: tuple[Floats, Floats],
        ramp: float,
    ) -> None:
        """Take the nodes from s0 to s1, and the highest z that the limits allow anywhere at steady speed.

        `passed`: parameters, and about when they are passed [s]; `ramp`: in which time an acceleration builds up [s].
        """
        inner = nodes[1 if ends[0].at_rest else 0 : -1 if ends[1].at_rest else len(nodes)]
        super().__init__(inner, (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1])), ends)
        self.run, self.limits, self.ends, self.highest = run, limits, ends, highest
        self.lowered = np.ones((len(inner), 3))
        self.clock, self.ramp = np.interp(self.nodes, *passed), ramp
        self._whole = discretise(run, limits, nodes, *ends, highest) if len(nodes) <= KEPT else None

    @classmethod
    def after_guess(
        cls, run: AxisRun, limits: Limits, nodes: Floats, ends: tuple[EndState, EndState], rough: Guess
    ) -> MeshedRun:
        """The run on these nodes, before anything is known of it but a first idea of its motion."""
        highest = max(rough.highest, ends[0].speed ** 2, ends[1].speed ** 2)
        return cls(run, limits, nodes, ends, highest, (rough.s, rough.t), min(ramp_time(limits), rough.t[-1]))

    @property
    def is_long(self) -> bool:
        """Whether the run is too long to be solved in one piece."""
        return self._whole is None

    def problem(self, low: int, high: int) -> Problem:
        """The problem of the nodes `low` to `high`, everything outside staying as it is (see Problem.stretch)."""
        if self._whole is not None:
            return self._whole.stretch(low, high)
        first, last = max(low - BESIDE, 0), min(high + BESIDE, len(self.nodes) - 1)
        start = self.ends[0] if first == 0 else INSIDE
        end = self.ends[1] if last == len(self.nodes) - 1 else INSIDE
        nodes = self.with_ends(self.nodes[first : last + 1], start, end)
        part = discretise(self.run, self.limits, nodes, start, end, self.highest)
        part.lower(self.lowered[first : last + 1])
        return part.stretch(low - first, high - first)

    def with_ends(self, nodes: Floats, start: EndState, end: EndState) -> Floats:
        """The nodes with those at rest, where the run itself starts or ends so."""
        before = [self.run.s0] if start.at_rest else []
        after = [self.run.s1] if end.at_rest else []
        return np.concatenate([before, nodes, after])

    def around(self, first: Ints, last: Ints, ramps: float) -> tuple[Ints, Ints]:
        """Nodes from so many ramp times before the nodes `first` to as many after the nodes `last`."""
        low = np.searchsorted(self.clock, self.clock[first] - ramps * self.ramp)
        high = np.searchsorted(self.clock, self.clock[last] + ramps * self.ramp)
        return (
            np.maximum(np.minimum(low, first - LEAST_REACH), 0),
            np.minimum(np.maximum(high, last + LEAST_REACH), len(self.nodes) - 1),
        )

    def tighten(self, peak: Floats, overshoot: float, reach: int) -> None:
        """Lower the limits around the cells whose peaks (cells, 3) by kind pass what is allowed.

        They are lowered `overshoot` times as far as they were passed, since the solution moves on, and as far as
        `reach` nodes to either side: a limit that is lowered at single nodes only is passed between them.
        """
        excess = np.ones((len(self.nodes), 3))
        over = np.where(peak > ALLOWED, 1.0 + overshoot * (peak - 1.0), 1.0)
        for shift in range(1 - reach, reach + 1):
            low, high = max(shift, 0), min(len(over) + shift, len(excess))
            np.maximum(excess[low:high], over[low - shift : high - shift], out=excess[low:high])
        self.lower(excess)

    def peaks(self, law: SplineLaw, cells: Ints | None = None, workers: Workers | None = None) -> Floats:
        """(n, 3) largest usage of a law in the given cells (default: in all), by speed, acceleration and jerk."""
        return cell_peaks(self.run, self.limits, law, cells, workers)

    def lower(self, by: Floats) -> None:
        """Divide the limits at the nodes by the factors (nodes, 3) of speed, acceleration and jerk."""
        self.lowered *= by
        if self._whole is not None:
            self._whole.lower(by)

    def cut(self, law: SplineLaw, parts: Ints) -> tuple[MeshedRun, Floats]:
        """The run with its cells cut into so many parts (cells,), and the coefficients of the same law on that mesh.

        Where nothing is cut, it is this run itself, its nodes passed when the law passes them.
        """
        if parts.max() == 1:
            self.clock = law.times
            return self, law.c
        nodes = cut_cells(self.nodes, parts)
        passed = law.nodes, law.times
        finer = MeshedRun(
            self.run, self.limits, self.with_ends(nodes, *self.ends), self.ends, self.highest, passed, self.ramp
        )
        finer.lower(np.repeat(self.lowered, np.append(parts, 1), axis=0))
        c, least = on_finer_mesh(law, finer.nodes)
        return finer, np.maximum(c, least)

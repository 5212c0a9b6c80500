"""A run on its mesh: what there is of the whole of it. Problems, which take much memory, are cut from it."""

from __future__ import annotations

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import EndState
from toolpace.planning.guarantee import ALLOWED
from toolpace.planning.mesh.guess import Guess, ramp_time
from toolpace.planning.mesh.nodes import cut_cells
from toolpace.planning.optimal.dips import on_finer_mesh
from toolpace.planning.optimal.problem import OnMesh, Problem, discretise, with_rows_between
from toolpace.planning.peaks import Look, Peaks
from toolpace.workers import Workers

LEAST_REACH = 40
"""Fewest nodes on either side of a place that is mended."""
KEPT = 12_000
"""Nodes up to which the problem of the whole run is kept."""
BESIDE = 2
"""Knots on either side of a stretch that its basis functions know."""
INSIDE = EndState(1.0)
"""Any motion, where a stretch ends inside the run."""


SAME_PLACE = 0.12
"""Share of a cell up to which two places are one: the row there is lowered, and no other put beside it."""
BESIDE_NODE = 0.02
"""Share of a cell that a place between two nodes keeps from them."""


class MeshedRun(OnMesh):
    """The mesh of a run, its places with rows between the nodes, by how much limits are lowered, and about when the
    nodes are passed."""

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
        self.between, self.lowered_between = np.empty(0), np.empty((0, 3))
        self.rows_kept: int | None = None
        """How many rows of a kind a point has in a problem, where not those of all joints."""
        self.look = Look(run, limits, self.nodes)
        self.clock, self.ramp = np.interp(self.nodes, *passed), ramp
        self._at_nodes = discretise(run, limits, nodes, *ends, highest) if len(nodes) <= KEPT else None
        self._whole = self._at_nodes

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
        return self._at_nodes is None

    def problem(self, low: int, high: int, c: Floats) -> Problem:
        """The problem of the nodes `low` to `high`, everything outside staying as in c (see Problem.stretch)."""
        part = self._stretch(low, high)
        return part.of_most_used(c[low : high + 3], self.rows_kept) if self.rows_kept else part

    def _stretch(self, low: int, high: int) -> Problem:
        """The same with all rows."""
        if self._whole is not None:
            return self._whole.stretch(low, high)
        first, last = max(low - BESIDE, 0), min(high + BESIDE, len(self.nodes) - 1)
        start = self.ends[0] if first == 0 else INSIDE
        end = self.ends[1] if last == len(self.nodes) - 1 else INSIDE
        nodes = self.with_ends(self.nodes[first : last + 1], start, end)
        part = discretise(self.run, self.limits, nodes, start, end, self.highest)
        mine = slice(*np.searchsorted(self.between, self.nodes[[first, last]]))
        part = with_rows_between(part, self.run, self.limits, self.between[mine])
        part.lower(self.lowered[first : last + 1], self.lowered_between[mine])
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

    def hold(self, peaks: Peaks, wrong: Bools, share: float, most: float, reach: int) -> None:
        """Put rows where the cells marked `wrong` pass a limit most, or lower those that are there, for each kind.

        Limits are lowered by `share` of what they are passed by, at most by `most` of themselves, since the solution
        moves on; by as much at `reach` nodes to either side too.
        """
        cell, kind = np.nonzero((peaks.used > ALLOWED) & wrong[:, None])
        by = 1.0 + np.minimum(share * (peaks.used[cell, kind] - 1.0), most)
        length = np.diff(self.nodes)[cell]
        place = self.nodes[cell] + np.clip(peaks.place[cell, kind], BESIDE_NODE, 1.0 - BESIDE_NODE) * length
        nodes_by = np.ones_like(self.lowered)
        for shift in range(1 - reach, reach + 1):
            at = cell + shift
            inside = (at >= 0) & (at < len(nodes_by))
            np.maximum.at(nodes_by, (at[inside], kind[inside]), by[inside])
        between, lowered = merged(
            np.concatenate([self.between, place]),
            np.concatenate([self.lowered_between, np.ones((len(place), 3))]),
            np.concatenate([np.zeros(len(self.between)), SAME_PLACE * length]),
        )
        nearest = np.clip(np.searchsorted(between, place), 1, max(len(between) - 1, 1)) - 1
        after = np.minimum(nearest + 1, len(between) - 1)
        nearest = np.where(np.abs(between[after] - place) < np.abs(between[nearest] - place), after, nearest)
        by_place = np.ones_like(lowered)
        np.maximum.at(by_place, (nearest, kind), by)
        self.lowered, self.between, self.lowered_between = self.lowered * nodes_by, between, lowered * by_place
        self._renew()

    def _renew(self) -> None:
        """Make the problem of the whole run anew, where there is one."""
        if self._at_nodes is not None:
            self._whole = with_rows_between(self._at_nodes, self.run, self.limits, self.between)
            self._whole.lower(self.lowered, self.lowered_between)

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
        finer.lowered = np.repeat(self.lowered, np.append(parts, 1), axis=0)
        apart = ~np.isin(self.between, finer.nodes)
        finer.between, finer.lowered_between = self.between[apart], self.lowered_between[apart]
        finer._renew()
        c, least = on_finer_mesh(law, finer.nodes)
        return finer, np.maximum(c, least)


def merged(places: Floats, lowered: Floats, apart: Floats) -> tuple[Floats, Floats]:
    """Places (k,) in order without those new ones that lie next to another, and what belongs to them.

    `apart` (k,) is the least distance of a new place to others, zero for one that is there already.
    """
    order = np.argsort(places, kind="stable")
    places, lowered, apart = places[order], lowered[order], apart[order]
    while True:
        near = np.diff(places) < np.maximum(apart[1:], apart[:-1])
        # of two new ones the second goes, of an old and a new one the new one
        drop = np.zeros(len(places), dtype=np.bool_)
        drop[1:] = near & (apart[1:] > 0.0)
        drop[:-1] |= near & (apart[1:] == 0.0)
        drop[1:] &= ~drop[:-1]
        if not drop.any():
            return places, lowered
        places, lowered, apart = places[~drop], lowered[~drop], apart[~drop]

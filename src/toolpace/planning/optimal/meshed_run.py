"""A run on its mesh, with rows of limits between its nodes, and laws of it on finer meshes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.kernels.motion import cubic_spline
from toolpace.kernels.optimal import limit_rows
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import ALLOWED
from toolpace.planning.mesh.initial_guess import Guess, ramp_time
from toolpace.planning.mesh.nodes import cut_cells
from toolpace.planning.optimal.problem import OnMesh, Problem, discretise, with_rows_between
from toolpace.planning.optimal.solve import pinned
from toolpace.planning.path_at_probes import CachedPath
from toolpace.planning.peaks import LimitCheck, Peaks
from toolpace.planning.planned_run import EndState

LEAST_REACH = 20
"""Fewest nodes on either side of a place that is mended."""
KEPT = 20_000
"""Nodes up to which the problem of the whole run is kept."""
BESIDE = 2
"""Knots on either side of a stretch that its basis functions know."""
INSIDE = EndState(1.0)
"""Any motion, where a stretch ends inside the run."""
NOTHING = 1e-3
"""Share of z at the nodes of a cell below which it has fallen to nothing inside: there a parabola touches zero, and
is not told from it by cutting the cell."""
FLOOR = 0.3
"""What z starts from on a finer mesh where it dips between two nodes, as a share of z at the nodes."""
MOST_SPLITS = 6
SHORTEST = 1e3
"""Cells that are cut no further, as a multiple of the rounding of s."""


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
        cache: CachedPath | None = None,
        before: tuple[LimitCheck, Ints] | None = None,
    ) -> None:
        """Take the nodes from s0 to s1, and the highest z that the limits allow anywhere at steady speed.

        `passed`: parameters, and about when they are passed [s]; `ramp`: in which time an acceleration builds up [s];
        `cache`: what is known of the path already, which a run that is too long for one problem does not keep;
        `before`: what was checked on a mesh whose cells have been cut into so many parts (cells,) for this one.
        """
        inner = nodes[1 if ends[0].at_rest else 0 : -1 if ends[1].at_rest else len(nodes)]
        super().__init__(inner, (float(inner[0] - nodes[0]), float(nodes[-1] - inner[-1])), ends)
        self.run, self.limits, self.ends, self.highest = run, limits, ends, highest
        self.lowered = np.ones((len(inner), 3))
        self.between = RowsBetween()
        self._cache = (cache or CachedPath(run)) if len(nodes) <= KEPT else None
        self.look = LimitCheck(run, limits, self.nodes, self._cache, before)
        self.clock, self.ramp = np.interp(self.nodes, *passed), ramp
        self._discretised = discretise(run, limits, nodes, *ends, highest, self._cache) if self._cache else None
        """The problem of the whole run with its limits as they are given; None where it is too long for one."""
        self._whole = self._discretised

    @classmethod
    def after_guess(
        cls, run: AxisRun, limits: Limits, nodes: Floats, ends: tuple[EndState, EndState], rough: Guess,
        cache: CachedPath | None = None,
    ) -> MeshedRun:  # fmt: skip
        """The run on these nodes, before anything is known of it but a first idea of its motion."""
        highest = max(rough.highest, ends[0].speed ** 2, ends[1].speed ** 2)
        ramp = min(ramp_time(limits), rough.t[-1])
        return cls(run, limits, nodes, ends, highest, (rough.s, rough.t), ramp, cache)

    @property
    def is_long(self) -> bool:
        """Whether the run is too long to be solved in one piece."""
        return self._discretised is None

    def problem(self, low: int, high: int) -> Problem:
        """The problem of the nodes `low` to `high`, everything outside staying as it is (see Problem.stretch)."""
        if self._whole is not None:
            return self._whole.stretch(low, high)
        first, last = max(low - BESIDE, 0), min(high + BESIDE, len(self.nodes) - 1)
        start = self.ends[0] if first == 0 else INSIDE
        end = self.ends[1] if last == len(self.nodes) - 1 else INSIDE
        nodes = self.with_ends(self.nodes[first : last + 1], start, end)
        part = discretise(self.run, self.limits, nodes, start, end, self.highest)
        mine = self.between.inside(self.nodes[first], self.nodes[last])
        part = with_rows_between(part, self.run, self.limits, mine.place)
        return part.lowered(self.lowered[first : last + 1], mine.lowered).stretch(low - first, high - first)

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

    def hold(self, peaks: Peaks, wrong: Bools, fresh: Bools, urge: float) -> None:
        """Hold the cells marked `wrong` where they pass limits most; with an `urge` above 1, lower their nodes too.

        Cells that are `fresh` have just been cut.
        """
        held = self.between.held(self.nodes, peaks, wrong, fresh, urge)
        if urge > 1.0:
            over = np.where((peaks.used > ALLOWED) & wrong[:, None], 1.0 + urge * (peaks.used - 1.0), 1.0)
            self.lowered[:-1] *= over
            self.lowered[1:] *= over
        if self._discretised is not None:
            new = held.beside(self._discretised.place[self._discretised.inside])
            self._discretised = with_rows_between(self._discretised, self.run, self.limits, new)
            self._whole = self._discretised.lowered(self.lowered, held.lowered)
        self.between = held

    def cut(self, law: SplineLaw, parts: Ints) -> tuple[MeshedRun, Floats]:
        """The run with its cells cut into so many parts (cells,), and the coefficients of the same law on that mesh.

        What is lowered, and the rows between, count once the next are held. Where nothing is cut, it is this run,
        its nodes passed when the law passes them.
        """
        if parts.max() == 1:
            self.clock = law.times
            return self, law.c
        nodes = cut_cells(self.nodes, parts)
        passed = law.nodes, law.times
        finer = MeshedRun(
            self.run, self.limits, self.with_ends(nodes, *self.ends), self.ends, self.highest, passed, self.ramp,
            self._cache, (self.look, parts),
        )  # fmt: skip
        finer.lowered = np.repeat(self.lowered, np.append(parts, 1), axis=0)
        finer.between = self.between.among(finer.nodes)
        c, least = on_finer_mesh(law, finer.nodes)
        # What is raised next to a rest must still fit to it: the core keeps by how much it does not.
        return finer, pinned(finer, np.maximum(c, least))


def no_places() -> Floats:
    """None."""
    return np.empty(0)


def no_factors() -> Floats:
    """None."""
    return np.empty((0, 3))


@dataclass(frozen=True)
class RowsBetween:
    """Places between nodes whose limits are held by rows of their own."""

    place: Floats = field(default_factory=no_places)
    """(k,) s, ascending."""
    lowered: Floats = field(default_factory=no_factors)
    """(k, 3) by what the limits of speed, acceleration and jerk are divided."""

    def among(self, nodes: Floats) -> RowsBetween:
        """Those that are not at nodes (n,)."""
        return self._of(~np.isin(self.place, nodes))

    def inside(self, low: float, high: float) -> RowsBetween:
        """Those between two places."""
        return self._of(slice(*np.searchsorted(self.place, [low, high])))

    def beside(self, places: Floats) -> Floats:
        """(j,) places of those that are not at some places (n,), ascending."""
        new: Floats = self.place[np.append(places, np.nan)[np.searchsorted(places, self.place)] != self.place]
        return new

    def _of(self, which: Bools | slice) -> RowsBetween:
        return RowsBetween(self.place[which], self.lowered[which])

    def held(self, nodes: Floats, peaks: Peaks, wrong: Bools, fresh: Bools, urge: float) -> RowsBetween:
        """With rows where the cells marked `wrong` pass a limit most, for each kind, and lower where there is one.

        A cell marked `fresh` has just been cut from one that passed by far: it gets a row whatever. `urge` is how much
        more than usual limits are lowered.
        """
        used, place = peaks.used, peaks.place
        return RowsBetween(
            *limit_rows.held(nodes, self.place, self.lowered, used, place, wrong, fresh, urge, ALLOWED)
        )


def without_undershoot(law: SplineLaw) -> SplineLaw:
    """The same z over a finer mesh, where it falls too far inside a cell; raised where it falls to nothing."""
    for _ in range(MOST_SPLITS):
        dips = law.dips()
        if not dips.any():
            break
        short = too_short(law.nodes)
        parts = np.where(dips & ~short, 4, 1)
        finer = cut_cells(law.nodes, parts)
        c, least = on_finer_mesh(law, finer)
        z = law.z_at_nodes()
        fallen = dips & (short | (lowest_z(law) <= NOTHING * np.minimum(z[:-1], z[1:])))
        if fallen.any():
            # all that touches the cells that have fallen
            near = np.convolve(np.repeat(fallen, parts), np.ones(4)) > 0.0
            c = np.where(near, np.maximum(c, least), c)
            for end, (one, two) in enumerate(((0, 1), (-1, -2))):
                if law.rest[end] > 0.0:
                    c[two] = c[one] * (1.0 + 4.0 * abs(finer[two] - finer[one]) / (9.0 * law.rest[end]))
        law = SplineLaw(finer, c, law.rest)
    return law


def on_finer_mesh(law: SplineLaw, finer: Floats) -> tuple[Floats, Floats]:
    """Coefficients of the same z over a finer mesh (n,), and what they should not be below (n + 2,)."""
    c = cubic_spline.on_finer_knots(law.nodes, law.cells, finer)
    # one that has its three knots still is the same to the last digit: cells without a new knot are not checked again
    at = np.searchsorted(law.nodes, finer)
    old = (law.nodes[at] == finer) & (np.append(-1, at[:-1]) == at - 1)
    same = np.flatnonzero(old[1:] & old[:-1]) + 1
    c[same] = law.c[at[same]]
    least: Floats = FLOOR * np.interp(cubic_spline.control_points(finer), law.nodes, law.z_at_nodes())
    return c, least


def too_short(nodes: Floats) -> npt.NDArray[np.bool_]:
    """(n - 1,) cells that numbers do not resolve when they are cut."""
    short: npt.NDArray[np.bool_] = np.diff(nodes) < SHORTEST * np.spacing(np.abs(nodes).max())
    return short


def lowest_z(law: SplineLaw) -> Floats:
    """(n - 1,) least z in each cell, at the places where it is probed."""
    x = np.diff(law.nodes)[:, None] * law.inside
    a = law.cells.T[:, :, None]
    z: Floats = (a[0] + x * (a[1] + x * (a[2] + x * a[3]))).min(axis=1)
    return z

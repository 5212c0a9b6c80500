"""What a motion really uses of its limits, between the nodes too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.kernels.motion import between_nodes, usage
from toolpace.kernels.optimal import first_guess
from toolpace.laws.linear import LinearLaw
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.motion.look import IN_A_STRETCH, unexplained
from toolpace.motion.usage import ratios_along
from toolpace.workers import Workers

CHUNK = 5_000
"""Cells whose usage is worked out at a time, to keep memory low."""
KEPT_CELLS = 20_000
"""Cells of a mesh up to which the path at its probes is kept from one look to the next."""
UNLIKE = 1e-6
"""Share of a limit up to which the path may differ from what its derivatives at the nodes tell of it."""
BENT = 1e-4
"""How far the cap on ds/dt may be from a polynomial of the third degree in a cell, relative to itself; one of the
fourth is taken, and beyond this it is asked at each probe."""
CHASED_FROM, MOST_CHASED = 9, 500
"""Places in such a cell between which what hides is chased, and cells after which no more is."""
VAGUE_ABOVE, CLOSELY = 0.98, 65
"""Usage from which such a cell is looked at closely, and the number of its probes then."""
FASTER = 4.0
"""How much of the z at steady speed a motion may have."""


@dataclass(frozen=True)
class Peaks:
    """Largest usage of limits cell by cell, by speed, acceleration and jerk, and where."""

    used: Floats
    """(n, 3) value over limit."""
    place: Floats
    """(n, 3) as shares of the cells."""


class Look:
    """Looks between the nodes of one mesh.

    The path is asked at the nodes and in the middle of the cells. Where the middle, and what the positions gain, are as
    the derivatives at the nodes say, these tell the path at all probes; elsewhere it is asked at each of them.
    """

    def __init__(self, run: AxisRun, limits: Limits, nodes: Floats) -> None:
        self.run, self.limits, self.nodes = run, limits, nodes
        self.unlike = np.zeros(len(nodes) - 1, dtype=np.bool_)
        """(n,) cells in which the path, or its cap, does more than what is known at the nodes says, as far as seen."""
        self.hiding = np.zeros(len(nodes) - 1, dtype=np.bool_)
        """(n,) those in which the path does."""
        self.hints = places_about(
            np.setdiff1d(run.hints[(run.hints > nodes[0]) & (run.hints < nodes[-1])], nodes), nodes
        )
        """(k,) places between nodes where the path's derivatives may bend, and between two such: probes of a cell may
        all miss a top there."""
        self._at_hints: tuple[Floats, Floats] | None = None
        """The path (4, k, m) there, and its cap (k,)."""
        self._kept: dict[int, tuple[Floats, Floats]] = {}
        """By the first cell of a chunk: three derivatives (3, n k, m) of the path, and caps (n k,) on ds/dt."""

    def peaks(self, law: SplineLaw, workers: Workers | None = None) -> Peaks:
        """The peaks in all cells."""
        last = len(self.nodes) - 1

        def of_chunk(first: int) -> Peaks:
            which = np.arange(first, min(first + CHUNK, last))
            path = self._kept.get(first) or self._path(which, law.inside)
            if last <= KEPT_CELLS:
                self._kept[first] = path
            return self._of(which, law, *path)

        return self._with_hints(law, joined((workers or Workers()).each(of_chunk, range(0, last, CHUNK))))

    def _with_hints(self, law: SplineLaw, peaks: Peaks) -> Peaks:
        """The peaks, or what is used at hints where that is more."""
        if not len(self.hints):
            return peaks
        limits = self.limits
        if self._at_hints is None:
            q, cap = self.run.with_cap(self.hints)
            self._at_hints = np.ascontiguousarray(q), cap
        of_joints = limits.velocity, limits.acceleration, limits.jerk
        ratio = usage.ratios(self._at_hints[0], law.states_at(self.hints), self._at_hints[1], *of_joints)
        return self._with(peaks, self.hints, by_kind(ratio, len(limits)))

    def _with(self, peaks: Peaks, s: Floats, of_kinds: Floats) -> Peaks:
        """The peaks, or what is used (k, 3) at the places s (k,) where that is more."""
        used, place = peaks.used.copy(), peaks.place.copy()
        cell = np.clip(np.searchsorted(self.nodes, s) - 1, 0, len(self.nodes) - 2)
        share = (s - self.nodes[cell]) / np.diff(self.nodes)[cell]
        for k in np.flatnonzero((of_kinds > used[cell]).any(axis=1)):
            higher = of_kinds[k] > used[cell[k]]
            used[cell[k], higher], place[cell[k], higher] = of_kinds[k, higher], share[k]
        return Peaks(used, place)

    def peaks_in(self, law: SplineLaw, cells: Ints, workers: Workers | None = None) -> Peaks:
        """The peaks in some cells, the path being asked at every probe."""

        def of_part(first: int) -> Peaks:
            which = cells[first : first + CHUNK]
            return self._of(which, law, *self._asked(which, law.inside))

        return joined((workers or Workers()).each(of_part, range(0, len(cells), CHUNK)))

    def confirmed(self, law: SplineLaw, peaks: Peaks, workers: Workers | None = None) -> Peaks:
        """The peaks, looked for again in cells where the path does more than the nodes say."""
        cells = np.flatnonzero(self.unlike)
        if not len(cells):
            return peaks
        near = cells[peaks.used[cells].max(axis=1) > VAGUE_ABOVE]
        closely = SplineLaw(law.nodes, law.c, law.rest)
        closely.inside = (1.0 - np.cos(np.linspace(0.0, np.pi, CLOSELY))) / 2.0
        again = self.peaks_in(closely, near, workers)
        used, place = peaks.used.copy(), peaks.place.copy()
        higher = again.used > used[near]
        used[near] = np.where(higher, again.used, used[near])
        place[near] = np.where(higher, again.place, place[near])
        return self.with_hidden(law, Peaks(used, place))

    def with_hidden(self, law: SplineLaw, peaks: Peaks) -> Peaks:
        """The peaks, with what hides between the probes of cells where the path does more than the nodes say."""
        cells = np.flatnonzero(self.hiding)[:MOST_CHASED]
        if not len(cells):
            return peaks
        found: list[tuple[Floats, Floats]] = []

        def look(places: Floats) -> tuple[Floats, Floats]:
            state = law.states_at(places)
            state[0] = places
            ratio, path = ratios_along(self.run, self.limits, state, np.ones(len(places)))
            found.append((places, by_kind(ratio, len(self.limits))))
            return path, state[1]

        share = np.linspace(0.0, 1.0, CHASED_FROM)
        places = self.nodes[cells][:, None] + np.diff(self.nodes)[cells][:, None] * share
        path, speed = look(places.ravel())
        path = path.reshape(4, len(cells), CHASED_FROM, -1)
        of_low, of_high = (
            np.ascontiguousarray(part.reshape(4, -1, part.shape[3])) for part in (path[:, :, :-1], path[:, :, 1:])
        )
        speed = speed.reshape(places.shape)
        swift = np.maximum(speed[:, :-1], speed[:, 1:]).ravel()
        low, high = places[:, :-1].ravel(), places[:, 1:].ravel()
        unexplained(self.run, self.limits, low, high, of_low, of_high, swift, look)
        s, of_kinds = (np.concatenate(parts) for parts in zip(*found))
        return self._with(peaks, s, of_kinds)

    def _path(self, which: Ints, inside: Floats) -> tuple[Floats, Floats]:
        """Derivatives and caps at the shares `inside` of the cells `which`, which follow each other."""
        limits, nodes = self.limits, self.nodes[which[0] : which[-1] + 2]
        of_joints = limits.velocity, limits.acceleration, limits.jerk
        length, count = np.diff(nodes), len(nodes)
        broken = np.flatnonzero(np.isin(nodes, self.run.breaks))
        s = np.concatenate([nodes, nodes[:-1] + length / 2.0, np.nextafter(nodes[broken], -np.inf)])
        q, cap = self.run.with_cap(np.clip(s, self.run.s0, self.run.s1))
        middle, cap_middle = np.ascontiguousarray(q[:, count : 2 * count - 1]), cap[count : 2 * count - 1].copy()
        high, cap_high = q[:, :count].copy(), cap[:count].copy()
        high[:, broken], cap_high[broken] = q[:, 2 * count - 1 :], cap[2 * count - 1 :]
        ends = np.ascontiguousarray(q[:, : count - 1]), np.ascontiguousarray(high[:, 1:])

        fastest, steady, _ = first_guess.pointwise(np.ascontiguousarray(q), *of_joints, cap)
        z = np.minimum(fastest, FASTER * steady)[: 2 * count - 1]
        z = np.maximum(np.maximum(z[: count - 1], z[1:count]), z[count:])
        z[z == np.inf] = 0.0
        unlike = ~(between_nodes.unlike(nodes[:-1], *ends, middle, length, z, *of_joints) <= UNLIKE)
        unlike[np.clip(np.searchsorted(nodes, self.run.breaks) - 1, 0, count - 2)] |= ~np.isin(self.run.breaks, nodes)
        self.hiding[which] = unlike
        out = np.empty((3, len(which) * len(inside), q.shape[2]))
        between_nodes.path_between(np.arange(len(which)), *ends, length, inside, out)
        if self.run.smooth_cap:
            quarters = [self.run.speed_cap(nodes[:-1] + share * length) for share in (0.25, 0.75)]
            five = np.stack([cap[: count - 1], quarters[0], cap_middle, quarters[1], cap_high[1:]])
            told, bend = caps_between(five, inside)
            caps = told.ravel()
            unlike |= ~(bend <= BENT)
        else:
            caps = self.run.speed_cap(np.clip(probes(nodes, inside), self.run.s0, self.run.s1))
        self.unlike[which] = unlike
        if unlike.any():
            at = (np.flatnonzero(unlike)[:, None] * len(inside) + np.arange(len(inside))).ravel()
            out[:, at], caps[at] = self._asked(which[unlike], inside)
        return out, caps

    def _asked(self, which: Ints, inside: Floats) -> tuple[Floats, Floats]:
        """Derivatives and caps at the shares `inside` of some cells, asked at each."""
        s = probes(np.stack([self.nodes[which], self.nodes[which + 1]], axis=1), inside)
        q, cap = self.run.with_cap(np.clip(s, self.run.s0, self.run.s1))
        return np.ascontiguousarray(q[1:]), cap

    def _of(self, which: Ints, law: SplineLaw, q: Floats, cap: Floats) -> Peaks:
        """The peaks in cells whose path is known."""
        limits = self.limits
        return Peaks(
            *usage.spline_peaks(
                which, q, cap, law.nodes, law.cells, law.inside, limits.velocity, limits.acceleration, limits.jerk
            )
        )


def places_about(hints: Floats, nodes: Floats) -> Floats:
    """(k,) hints between nodes, and places in the stretches from them to the next of either kind."""
    if not len(hints):
        return hints
    ends = np.union1d(hints, nodes)
    at = np.searchsorted(ends, hints)
    beside = np.unique(np.concatenate([at - 1, at]))
    stretch = ends[beside, None] + (ends[beside + 1] - ends[beside])[:, None] * IN_A_STRETCH
    return np.union1d(hints, stretch.ravel())


def probes(nodes: Floats, inside: Floats) -> Floats:
    """(n k,) places at the shares `inside` (k,) of cells, their ends taken from inside.

    The cells are those between nodes (n + 1,), or given by both their ends (n, 2).
    """
    low, high = (nodes[:-1], nodes[1:]) if nodes.ndim == 1 else (nodes[:, 0], nodes[:, 1])
    s = low[:, None] + (high - low)[:, None] * inside
    s[:, -1] = np.nextafter(high, -np.inf)
    return np.asarray(s.ravel())


def caps_between(caps: Floats, inside: Floats) -> tuple[Floats, Floats]:
    """(n, k) caps on ds/dt at the shares `inside` (k,) of cells, from those at five even places of each (5, n).

    A feed over the speed of the tip: the square of its inverse is taken for a polynomial of the fourth degree. Returns
    with them how far, relative to itself, it is (n,) from one of the third.
    """
    square = np.square(1.0 / caps)
    order = np.vander(np.linspace(0.0, 1.0, 5), 5)
    told = square.T @ np.linalg.solve(order.T, np.vander(inside, 5).T)
    bend = np.abs(np.array([1.0, -4.0, 6.0, -4.0, 1.0]) @ square)
    least = square.min(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1.0 / np.sqrt(np.maximum(told, 0.5 * least[:, None])), np.where(least > 0.0, bend / least, bend)


def joined(parts: list[Peaks]) -> Peaks:
    """The peaks of parts one after the other."""
    if not parts:
        return Peaks(np.empty((0, 3)), np.empty((0, 3)))
    return Peaks(np.concatenate([part.used for part in parts]), np.concatenate([part.place for part in parts]))


def peaks_of(run: AxisRun, limits: Limits, law: LinearLaw, cells: Ints) -> Floats:
    """(n, 3) largest usage in the given cells of a law of linear z, by speed, acceleration and jerk."""
    state, right = law.states_within(cells)
    return by_kind(usage.peaks(law.inside, limit_ratios(run, limits, state, right)), len(limits))


def by_kind(ratios: Floats, joints: int) -> Floats:
    """(n, 3) largest of speed, acceleration and jerk of (n, 1 + 3 joints) values over limits."""
    kinds = np.split(ratios, [1 + joints, 1 + 2 * joints], axis=1)
    return np.stack([kind.max(axis=1) for kind in kinds], axis=1)

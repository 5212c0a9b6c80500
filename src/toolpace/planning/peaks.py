"""Peaks of limit utilisation between the nodes of a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.workers import Workers
from toolpace.kernels.motion import usage, utilisation_peaks
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.motion.laws import LinearLaw, SplineLaw
from toolpace.motion.usage import IN_A_STRETCH, beside_tops, ratios_along, ratios_of, unexplained
from toolpace.path.axis_run import AxisRun
from toolpace.planning.path_at_probes import CachedPath, PathAtProbes, probes

CHUNK = 5_000
"""Cells whose usage is worked out at a time, to keep memory low."""
KEPT_CELLS = 20_000
"""Cells of a mesh up to which the path at its probes is kept from one look to the next."""
CHASED_FROM, BEGUN_FROM, MOST_CHASED = 9, 33, 500
"""Places in such a cell between which what hides is chased, in the last look at least, and cells after which no more is
before it."""
VAGUE_ABOVE, CLOSELY = 0.98, 65
"""Usage from which such a cell is looked at closely, and the number of its probes then."""


@dataclass(frozen=True)
class Peaks:
    """Largest usage of limits cell by cell, by speed, acceleration and jerk, and where."""

    used: Floats
    """(n, 3) value over limit."""
    place: Floats
    """(n, 3) as shares of the cells."""


class LimitCheck:
    """Looks between the nodes of one mesh."""

    def __init__(
        self,
        run: AxisRun,
        limits: Limits,
        nodes: Floats,
        cache: CachedPath | None = None,
        before: tuple[LimitCheck, Ints] | None = None,
    ) -> None:
        """Take the nodes (n,) of the mesh, and what is known of the path already; `before`: the check of a mesh whose
        cells have been cut into so many parts (cells,) for this one: what was found in those that were not still holds.
        """
        self.run, self.limits, self.nodes = run, limits, nodes
        self.path = PathAtProbes(run, limits, nodes, cache)
        hints, breaks = (
            np.setdiff1d(each[(each > nodes[0]) & (each < nodes[-1])], nodes) for each in (run.hints, run.breaks)
        )
        about = places_about(np.union1d(hints, breaks), nodes)
        self.hints = np.union1d(np.union1d(hints, about), np.nextafter(breaks, -np.inf))
        """(k,) places between nodes where the path's derivatives may bend or its cap may jump, and between two such:
        probes of a cell may all miss a top there."""
        self._beside = np.isin(self.hints, np.setdiff1d(about, np.union1d(hints, breaks)))
        """(k,) those between: of no use where ends and middle of the cell tell its path."""
        self._of_hint = np.searchsorted(nodes, self.hints) - 1
        """(k,) their cells."""
        self._kept: dict[int, tuple[Floats, Floats]] = {}
        """By the first cell of a chunk: three derivatives (n, 3, m, k) of the path, and caps (n, k) on ds/dt."""
        self._last: tuple[Floats, Peaks] | None = None
        """The cells of the law that was looked at last, and its peaks at the probes and hints."""
        if before is not None and before[0]._last is not None:
            self._take_over(before[0], *before[0]._last, before[1])

    def _take_over(self, check: LimitCheck, cells: Floats, peaks: Peaks, parts: Ints) -> None:
        """Take what was found in cells that are still whole, from the check of a mesh before they were cut."""
        whole = parts == 1
        self.path.take_over(check.path, parts)
        found = Peaks(np.repeat(peaks.used, parts, axis=0), np.repeat(peaks.place, parts, axis=0))
        self._last = np.repeat(np.where(whole[:, None], cells, np.nan), parts, axis=0), found

    def peaks(self, law: SplineLaw, workers: Workers | None = None) -> Peaks:
        """The peaks in all cells; only those in which z is not as it was in the law before are looked at."""
        last, cells, workers = len(self.nodes) - 1, law.cells, workers or Workers()
        if self.path.is_outgrown(law):
            self._kept, self._last = {}, None
        changed = np.ones(last, dtype=np.bool_) if self._last is None else (cells != self._last[0]).any(axis=1)

        def of_chunk(first: int) -> Peaks:
            which = np.arange(first, min(first + CHUNK, last))
            mine = changed[which]
            whole = bool(mine.all())
            if first in self._kept:
                path = self._kept[first]
                return self._of(which[mine], law, *(path if whole else (each[mine] for each in path)))
            path = self.path.interpolated(which[mine], law.inside, law)
            if last <= KEPT_CELLS and whole:
                self._kept[first] = path
            return self._of(which[mine], law, *path)

        chunks = [first for first in range(0, last, CHUNK) if changed[first : first + CHUNK].any()]
        peaks = joined(workers.each(of_chunk, chunks))
        if self._last is not None:
            used, place = self._last[1].used.copy(), self._last[1].place.copy()
            used[changed], place[changed] = peaks.used, peaks.place
            peaks = Peaks(used, place)
        peaks = self._with_hints(law, peaks, changed)
        self._last = cells, peaks
        return peaks

    def _with_hints(self, law: SplineLaw, peaks: Peaks, changed: Bools) -> Peaks:
        """The peaks, or what is used at hints in the `changed` cells where that is more."""
        places = self.hints[changed[self._of_hint] & (self.path.unlike[self._of_hint] | ~self._beside)]
        for first in range(0, len(places), CHUNK):
            s = places[first : first + CHUNK]
            q, cap = self.path.cache.with_cap(s)
            ratio = ratios_of(np.ascontiguousarray(q), cap, self.limits, law.states_at(s))
            peaks = self._with(peaks, s, by_kind(ratio, self.limits))
        return peaks

    def _with(self, peaks: Peaks, s: Floats, of_kinds: Floats) -> Peaks:
        """The peaks, or what is used (k, 3) at the places s (k,) where that is more."""
        used, place = peaks.used.copy(), peaks.place.copy()
        cell = np.clip(np.searchsorted(self.nodes, s) - 1, 0, len(self.nodes) - 2)
        share = (s - self.nodes[cell]) / np.diff(self.nodes)[cell]
        for kind in range(3):
            order = np.lexsort((of_kinds[:, kind], cell))
            # of each cell the place where most is used
            top = order[np.append(cell[order][1:] != cell[order][:-1], True)[: len(order)]]
            top = top[of_kinds[top, kind] > used[cell[top], kind]]
            used[cell[top], kind], place[cell[top], kind] = of_kinds[top, kind], share[top]
        return Peaks(used, place)

    def peaks_in(self, law: SplineLaw, cells: Ints, workers: Workers | None = None) -> Peaks:
        """The peaks in some cells, the path being asked at every probe."""

        def of_part(first: int) -> Peaks:
            which = cells[first : first + CHUNK]
            return self._of(which, law, *self.path.evaluated(which, law.inside))

        return joined((workers or Workers()).each(of_part, range(0, len(cells), CHUNK)))

    def confirmed(self, law: SplineLaw, peaks: Peaks, workers: Workers | None = None) -> Peaks:
        """The peaks, looked for again in cells where the path does more than the nodes say."""
        cells = np.flatnonzero(self.path.unlike)
        if not len(cells):
            return peaks
        near = cells[largest(peaks.used[cells]) > VAGUE_ABOVE]
        closely = SplineLaw(law.nodes, law.c, law.rest)
        closely.inside = between(CLOSELY)
        again = self.peaks_in(closely, near, workers)
        used, place = peaks.used.copy(), peaks.place.copy()
        higher = again.used > used[near]
        used[near] = np.where(higher, again.used, used[near])
        place[near] = np.where(higher, again.place, place[near])
        found = Peaks(used, place)
        # a cap tells nothing of what it does between places; a path tells enough for few to begin with
        begun = between(BEGUN_FROM) if len(law.inside) < BEGUN_FROM else law.inside
        for which, shares in ((self.path.hiding, begun), (~self.path.hiding, law.inside)):
            mine = cells[which[cells]]
            for first in range(0, len(mine), CHUNK):
                found = self._with_narrow_features(law, found, mine[first : first + CHUNK], shares)
        return found

    def with_hidden(self, law: SplineLaw, peaks: Peaks) -> Peaks:
        """The peaks, with what hides between the probes of cells where the path does more than the nodes say."""
        cells = np.flatnonzero(self.path.hiding)[:MOST_CHASED]
        return self._with_narrow_features(law, peaks, cells, np.linspace(0.0, 1.0, CHASED_FROM))

    def _with_narrow_features(self, law: SplineLaw, peaks: Peaks, cells: Ints, shares: Floats) -> Peaks:
        """The peaks, with what is found in some cells from places at these shares (k,) on, as `closer_look` does it."""
        if not len(cells):
            return peaks
        found: list[tuple[Floats, Floats]] = []

        def look(places: Floats) -> tuple[Floats, Floats]:
            state = law.states_at(places)
            state[0] = places
            ratio, path = ratios_along(self.run, self.limits, state, np.ones(len(places)))
            found.append((places, ratio))
            return path, state[1]

        places = self.nodes[cells][:, None] + np.diff(self.nodes)[cells][:, None] * shares
        path, speed = look(places.ravel())
        path = path.reshape(4, len(cells), len(shares), -1)
        of_low, of_high = (
            np.ascontiguousarray(part.reshape(4, -1, part.shape[3])) for part in (path[:, :, :-1], path[:, :, 1:])
        )
        speed = speed.reshape(places.shape)
        swift = np.maximum(speed[:, :-1], speed[:, 1:]).ravel()
        low, high = places[:, :-1].ravel(), places[:, 1:].ravel()
        unexplained(self.run, self.limits, low, high, of_low, of_high, swift, look)
        beside_tops(places.ravel(), found[0][1], np.diff(places, append=places[:, -1:]).ravel()[:-1] > 0.0, look)
        s, ratios = (np.concatenate(parts) for parts in zip(*found))
        return self._with(peaks, s, by_kind(ratios, self.limits))

    def _of(self, which: Ints, law: SplineLaw, q: Floats, cap: Floats) -> Peaks:
        """The peaks in cells whose path is known."""
        limits = self.limits
        of_joints = limits.velocity, limits.acceleration, limits.jerk
        peaks = Peaks(
            *utilisation_peaks.spline_peaks(which, q, cap, law.nodes, law.cells, law.inside, *of_joints)
        )
        return self._with_rows(peaks, which, law) if limits.rows and len(which) else peaks

    def _with_rows(self, peaks: Peaks, which: Ints, law: SplineLaw) -> Peaks:
        """The peaks in cells, or those of rows of one's own where these are higher; the path is asked at each probe."""
        begin, length = law.nodes[which], np.diff(law.nodes)[which]
        a, x = law.cells[which].T[:, :, None], length[:, None] * law.inside
        z = np.maximum(a[0] + x * (a[1] + x * (a[2] + x * a[3])), 0.0)
        slope, bend = a[1] + x * (2.0 * a[2] + 3.0 * x * a[3]), 2.0 * a[2] + 6.0 * x * a[3]
        s = np.clip(probes(begin, begin + length, law.inside), self.run.s0, self.run.s1)
        state = np.stack([s, *(part.ravel() for part in (np.sqrt(z), slope / 2.0, bend * np.sqrt(z) / 2.0))])
        q = np.ascontiguousarray(self.run.evaluate(s))
        used, place = peaks.used.copy(), peaks.place.copy()
        for rows in self.limits.rows:
            of_lines, kind = rows.line_ratios(q, state), rows.order
            ratio = of_lines.min(axis=2)
            highest = by_cell(ratio.max(axis=1), which).argmax(axis=1)
            tops = [(usage.peaks(law.inside, ratio).max(axis=1), law.inside[highest])]
            if of_lines.shape[2] > 1:
                tops.append(tops_at_corners(by_cell(of_lines, which), law.inside))
            for top, there in tops:
                higher = top > used[:, kind]
                used[higher, kind], place[higher, kind] = top[higher], there[higher]
        return Peaks(used, place)


def by_cell(values: Floats, cells: Ints) -> Floats:
    """(cells, probes, ...) of values (cells probes, ...)."""
    out: Floats = values.reshape(len(cells), -1, *values.shape[1:])
    return out


def tops_at_corners(ratios: Floats, inside: Floats) -> tuple[Floats, Floats]:
    """(cells,) highest tops, and their shares of the cells, of ratios (cells, probes, k, choices) of which the least of
    the choices counts: where one takes over from another between two probes, straight between these."""
    low, high = ratios[:, :-1], ratios[:, 1:]
    first, second = (part.argmin(axis=3)[..., None] for part in (low, high))
    (a0, a1), (b0, b1) = (
        [np.take_along_axis(part, choice, axis=3)[..., 0] for part in (low, high)] for choice in (first, second)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (b0 - a0) / ((b0 - a0) + (a1 - b1))
        top = np.nan_to_num(a0 + share * (a1 - a0), nan=0.0, posinf=0.0, neginf=0.0)
    top = top.max(axis=2)
    at = top.argmax(axis=1)
    which = np.arange(len(top))
    return top[which, at], 0.5 * (inside[at] + inside[at + 1])


def between(count: int) -> Floats:
    """(count,) shares of a cell, closer together next to its ends."""
    shares: Floats = (1.0 - np.cos(np.linspace(0.0, np.pi, count))) / 2.0
    return shares


def places_about(hints: Floats, nodes: Floats) -> Floats:
    """(k,) hints between nodes, and places in the stretches from them to the next of either kind."""
    if not len(hints):
        return hints
    ends = np.union1d(hints, nodes)
    at = np.searchsorted(ends, hints)
    beside = np.unique(np.concatenate([at - 1, at]))
    stretch = ends[beside, None] + (ends[beside + 1] - ends[beside])[:, None] * IN_A_STRETCH
    return np.union1d(hints, stretch.ravel())


def largest(used: Floats) -> Floats:
    """(n,) largest usage (n, 3) of any kind."""
    worst: Floats = np.maximum(np.maximum(used[:, 0], used[:, 1]), used[:, 2])
    return worst


def joined(parts: list[Peaks]) -> Peaks:
    """The peaks of parts one after the other."""
    if not parts:
        return Peaks(np.empty((0, 3)), np.empty((0, 3)))
    if len(parts) == 1:
        return parts[0]
    return Peaks(np.concatenate([part.used for part in parts]), np.concatenate([part.place for part in parts]))


def peaks_of(run: AxisRun, limits: Limits, law: LinearLaw, cells: Ints) -> Floats:
    """(n, 3) largest usage in the given cells of a law of linear z, by speed, acceleration and jerk."""
    state, right = law.states_within(cells)
    return by_kind(usage.peaks(law.inside, limit_ratios(run, limits, state, right)), limits)


def by_kind(ratios: Floats, limits: Limits) -> Floats:
    """(n, 3) largest of speed, acceleration and jerk of (n, k) values over limits."""
    return np.stack([ratios[:, limits.orders == order].max(axis=1) for order in range(3)], axis=1)

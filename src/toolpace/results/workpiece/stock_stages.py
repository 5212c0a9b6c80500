"""The surface of the stock at many moments of a motion, as crossings of a lattice with their lifetimes.

    rays a coarse cell apart along the axes of the part; a lattice of points in the middle of the cells
    for each stage, all equally long:
        cut the rays along the motion of that stage
        in the box that the tool has passed: where the side changes between two neighbours of the lattice, a ray
        tells the place; what is no longer so has ended with the stage before
    at a stage: surface nets (Gibson, Constrained elastic surface nets, 1998) of the crossings that are there then

Most of the surface stays from stage to stage, so a thousand stages are hardly more than the first and the last.
player/stock.js makes the same surface in a browser.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.simulate import ToolInUse
from toolpace.cutting.stock.dexels import FRAME, DexelStock
from toolpace.cutting.tool_profile import ToolProfile

POINTS = 110
"""Of the lattice along the longest side of the stock."""
SHARES = 63
"""Steps in which the place of a crossing is kept: of the way between two neighbours."""
SHORTEST, MOST = 0.02, 1000
"""Least length of a stage [s], and most stages."""
FLAT = 1.5 / SHARES
"""Of a stock whose faces are along the lattice, crossings of one direction in a cube are on one face where they differ
by less, in cells: edges are then met exactly. Where it was cut, crossings do not tell an edge from a round wall."""
RIGHT = 1e-9
"""How far the normal of a face may be off an axis."""


@dataclass(frozen=True)
class StockStages:
    """n crossings of a lattice, each with the stages in which it is there."""

    origin: Floats
    """(3,) the first point of the lattice [m]; it is in air."""
    step: Floats
    """(3,) from point to point [m]."""
    points: Ints
    """(3,) along each axis."""
    duration: float
    """Of all stages together [s]."""
    stages: int
    """Stage k is the stock at k shares of the duration: 0 before the motion, `stages` after it."""
    axis: Ints
    """(n,) along which it crosses: ascending."""
    edge: Ints
    """(n,) number of the lower point: ascending for each axis."""
    place: Ints
    """(n,) of the way to the next point, in SHARES."""
    leaves: Bools
    """(n,) whether the material is below it."""
    first: Ints
    """(n,) stage from which it is there."""
    end: Ints
    """(n,) stage from which it no longer is."""
    square: bool = False
    """Whether all faces of the stock were along the lattice before it was cut."""

    def stage_at(self, t: float) -> int:
        """The last stage that is complete at a time [s]."""
        return int(np.clip(np.floor(t / self.duration * self.stages + 1e-9), 0, self.stages))

    def surface(self, stage: int) -> tuple[Floats, Bools]:
        """Triangles (n, 3, 3) [m] at a stage, counterclockwise seen from outside, and whether each was cut (n,)."""
        there = (self.first <= stage) & (stage < self.end)
        axis, edge = self.axis[there], self.edge[there]
        lower = np.stack(np.unravel_index(edge, self.points), axis=1)
        where = lower.astype(np.float64)
        where[np.arange(len(axis)), axis] += self.place[there] / SHARES
        # the four cubes about an edge, counterclockwise about its axis
        cubes = np.repeat(lower[:, None], 4, axis=1)
        rows = np.arange(len(axis))
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for corner, across in ((1, (u,)), (2, (u, v)), (3, (v,))):
            for d in across:
                cubes[rows, corner, d] -= 1
        names = np.ravel_multi_index(tuple(np.moveaxis(cubes, 2, 0)), tuple(self.points))
        quads = np.where(self.leaves[there, None], names, names[:, ::-1])
        vertex, order = _vertices(names, where, axis, (self.first[there] > 0) | (not self.square))
        square = self.origin + self.step * vertex[np.searchsorted(order, quads)]
        cut = np.tile(self.first[there] > 0, 2)
        return np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]]), cut


def _vertices(names: Ints, where: Floats, axis: Ints, free: Bools) -> tuple[Floats, Ints]:
    """Of each cube that crossings (n, 3) touch, by `names` (n, 4), its vertex; and the names of these cubes.

    The middle of its crossings; at an edge of faces along the lattice, without any `free` crossing, where they meet.
    """
    order, which = np.unique(names.ravel(), return_inverse=True)
    count = len(order)
    spots, along = np.repeat(where, 4, axis=0), np.repeat(axis, 4)
    number = np.bincount(which, minlength=count)
    middle = np.stack([np.bincount(which, spots[:, d], count) for d in range(3)], axis=1) / number[:, None]
    own, flat = np.full((count, 3), np.nan), np.bincount(which, np.repeat(free, 4), count) == 0.0
    for d in range(3):
        mine = along == d
        low, high = np.full(count, np.inf), np.full(count, -np.inf)
        np.minimum.at(low, which[mine], spots[mine, d])
        np.maximum.at(high, which[mine], spots[mine, d])
        seen = np.isfinite(low)
        flat[seen] &= high[seen] - low[seen] <= FLAT
        own[seen, d] = 0.5 * (low[seen] + high[seen])
    return np.where(flat[:, None] & np.isfinite(own), own, middle), order


Cut = tuple[Stations, ToolInUse]
"""A stretch of the motion, and the tool that cuts along it."""


def stages_of(triangles: Floats, cuts: Sequence[Cut], duration: float, before: Sequence[Cut] = ()) -> StockStages:
    """The stages of a stock, a closed mesh (n, 3, 3) [m], that is cut along stretches in the order of time.

    before: stretches along which it was cut before. Raises UsageError for a mesh that is no stock.
    """
    work = _Work(triangles)
    for stations, tool in before:
        work.cut(stations, tool.profile)
    work.look(tuple((0, n) for n in work.stock.field.cells.tolist()), 0)
    stages = int(np.clip(duration / SHORTEST, 1, MOST))
    borders = duration * np.arange(1, stages + 1) / stages
    for stage, stations, tool in _by_stage(cuts, borders):
        work.cut(stations, tool.profile)
        work.look(work.passed(stations, tool.profile), stage)
    return work.finished(duration, stages)


def _by_stage(cuts: Sequence[Cut], borders: Floats) -> Iterator[tuple[int, Stations, ToolInUse]]:
    """The stretches in pieces that end with a stage (its number), each from where the one before ends."""
    for stations, tool in cuts:
        stage = np.minimum(np.searchsorted(borders, stations.time, side="left"), len(borders) - 1)
        ends = [0, *(np.flatnonzero(np.diff(stage[1:])) + 1).tolist(), len(stations) - 1]
        for a, b in pairwise(ends):
            if b > a:
                yield int(stage[b]) + 1, stations.part(a, b + 1), tool


class _Work:
    """Cuts the stock, and keeps the crossings."""

    def __init__(self, triangles: Floats) -> None:
        sides = np.ptp(triangles, axis=(0, 1))
        # rays of a stock are along the rows of FRAME: turned by it, they are along the axes of the part
        self.stock = DexelStock.mesh(triangles @ FRAME, float(sides.max()) / POINTS)
        field = self.stock.field
        self.origin, self.step = field.origin - 0.5 * field.step, field.step
        self.points = field.cells + 2
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        largest, size = np.abs(normal).max(axis=1), np.linalg.norm(normal, axis=1)
        self.square = bool((largest >= (1.0 - RIGHT) * size).all())
        self.inside = np.zeros(self.points, np.bool_)
        self.place = [np.full(self.points, -1, np.int8) for _ in range(3)]
        self.leaves = [np.zeros(self.points, np.bool_) for _ in range(3)]
        self.first = [np.zeros(self.points, np.int32) for _ in range(3)]
        self.ended: list[Ints] = []

    def cut(self, stations: Stations, profile: ToolProfile) -> None:
        """Cut along stations; of those that are closer than half a cell one stands for all."""
        reach = stations.tip + profile.length * stations.axis
        moves = np.maximum(*(np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (stations.tip, reach)))
        way = np.concatenate([[0.0], np.cumsum(moves)])
        kept = np.diff(np.floor(way / (0.5 * self.step.min())), prepend=-1.0) > 0.0
        kept[[0, -1]] = True
        thinned = stations.where(kept)
        self.stock.cut(profile, replace(thinned, tip=thinned.tip @ FRAME, axis=thinned.axis @ FRAME))

    def passed(self, stations: Stations, profile: ToolProfile) -> tuple[tuple[int, int], ...]:
        """Range of the cells along each axis that the tool has passed."""
        ends = np.concatenate([stations.tip, stations.tip + profile.length * stations.axis])
        low, high = ends.min(axis=0) - profile.radius, ends.max(axis=0) + profile.radius
        field = self.stock.field
        begin = np.clip(np.floor((low - field.origin) / field.step) - 1, 0, field.cells).astype(int)
        end = np.clip(np.ceil((high - field.origin) / field.step) + 1, 0, field.cells).astype(int)
        return tuple(zip(begin.tolist(), end.tolist()))

    def look(self, cells: tuple[tuple[int, int], ...], stage: int) -> None:
        """Find the crossings in a range of cells, and keep what has ended."""
        from toolpace.kernels.cutting.lattice import mark_inside

        if any(a >= b for a, b in cells):
            return
        field = self.stock.field
        columns, rows, levels = (np.arange(a, b) for a, b in cells)
        found = np.zeros(tuple(b - a for a, b in cells), np.bool_)
        mark_inside(field, columns, rows, self.origin[2] + self.step[2] * (levels + 1.0), found)
        # point i of the lattice is in the middle of cell i - 1
        self.inside[tuple(slice(a + 1, b + 1) for a, b in cells)] = found
        box = tuple(slice(a, b + 2) for a, b in cells)
        for d in range(3):
            self._look_along(d, box, stage)

    def _look_along(self, d: int, box: tuple[slice, ...], stage: int) -> None:
        """The crossings along one axis between points of the lattice."""
        from toolpace.kernels.cutting.lattice import ends_between

        box = tuple(slice(s.start, s.stop - 1) if k == d else s for k, s in enumerate(box))
        beyond = tuple(slice(s.start + 1, s.stop + 1) if k == d else s for k, s in enumerate(box))
        leaves = self.inside[box] & ~self.inside[beyond]
        crosses = leaves | (self.inside[beyond] & ~self.inside[box])
        at = np.argwhere(crosses) + [s.start for s in box]
        field, u, v = self.stock.field, (d + 1) % 3, (d + 2) % 3
        rays = field.first[d] + (at[:, v] - 1) * field.cells[u] + at[:, u] - 1
        low = self.origin[d] + self.step[d] * at[:, d]
        places = np.empty(len(at))
        ends_between(field, rays, low, low + self.step[d], places)
        new = np.full(crosses.shape, -1, np.int8)
        new[crosses] = np.clip(np.round(SHARES * (places - low) / self.step[d]), 0, SHARES)
        old, old_leaves, first = self.place[d][box], self.leaves[d][box], self.first[d][box]
        # what moves by rounding stays
        same = (np.abs(old - new) <= 1) & ((old < 0) == (new < 0)) & ((old_leaves == leaves) | (new < 0))
        ended = ~same & (old >= 0) & (first < stage)
        if ended.any():
            index = np.argwhere(ended) + [s.start for s in box]
            self._end(d, np.ravel_multi_index(tuple(index.T), tuple(self.points)), stage)
        self.place[d][box] = np.where(same, old, new)
        self.leaves[d][box] = np.where(same, old_leaves, leaves)
        self.first[d][box] = np.where(same, first, stage)

    def _end(self, d: int, edge: Ints, stage: int) -> None:
        """Keep crossings that end with a stage."""
        place, leaves, first = self.place[d].ravel(), self.leaves[d].ravel(), self.first[d].ravel()
        rows = np.full(len(edge), d), edge, place[edge], leaves[edge], first[edge], np.full(len(edge), stage)
        self.ended.append(np.stack([each.astype(np.int64) for each in rows]))

    def finished(self, duration: float, stages: int) -> StockStages:
        """All crossings, in order."""
        for d in range(3):
            self._end(d, np.flatnonzero(self.place[d] >= 0), stages + 1)
        rows = np.concatenate(self.ended, axis=1)
        axis, edge, place, leaves, first, end = rows[:, np.lexsort((rows[4], rows[1], rows[0]))]
        return StockStages(
            self.origin, self.step, self.points, duration, stages, axis, edge, place, leaves > 0, first, end,
            self.square,
        )  # fmt: skip

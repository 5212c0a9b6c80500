"""Which points are within a stock: a box, a cylinder or a closed mesh, larger all round by its uncertainty."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints

COLUMNS = 16, 512
"""Columns along each side in which the triangles of a mesh are kept: least and most."""
AT_ONCE = 1 << 21
"""Pairs of a point and a triangle that are looked at in one piece."""


class Stock(Protocol):
    """Tells which points (k, 3) are within the stock, or no further from it than a margin [m]."""

    def __call__(self, place: Floats, margin: float = 0.0, /) -> Bools: ...


def box_stock(low: Floats, high: Floats, uncertainty: float) -> Stock:
    """A box between its least and its most corner (3,) [m]; its edges are round where it is larger."""

    def within(place: Floats, margin: float = 0.0) -> Bools:
        off = np.maximum(np.maximum(low - place, place - high), 0.0)
        return np.asarray(np.linalg.norm(off, axis=1) <= uncertainty + margin)

    return within


def cylinder_stock(lower: Floats, upper: Floats, diameter: float, uncertainty: float) -> Stock:
    """A cylinder between the centres of its ends (3,) [m]."""
    length = float(np.linalg.norm(upper - lower))

    def within(place: Floats, margin: float = 0.0) -> Bools:
        along = (place - lower) @ ((upper - lower) / length)
        beside = np.sqrt(np.maximum(np.einsum("kc,kc->k", place - lower, place - lower) - along**2, 0.0))
        off = np.maximum(np.maximum(-along, along - length), 0.0), np.maximum(beside - 0.5 * diameter, 0.0)
        return np.asarray(np.hypot(*off) <= uncertainty + margin)

    return within


class MeshStock:
    """A stock of closed bodies, whose triangles (n, 3, 3) go counterclockwise seen from outside [m].

    A point is within it where a ray from it leaves bodies more often than it enters them: bodies that overlap count
    once. Rays go askew, so that none is along a face that people draw. Triangles are kept in columns along the rays.
    """

    def __init__(self, triangles: Floats, uncertainty: float, most_margin: float = 0.0) -> None:
        self.uncertainty = uncertainty
        self.origin = triangles.min(axis=(0, 1))
        self.frame = _askew()
        self.triangles: Floats = (triangles - self.origin) @ self.frame.T
        room = uncertainty + most_margin + 1e-9
        low, high = self.triangles.min(axis=1) - room, self.triangles.max(axis=1) + room
        self.low, sides = low.min(axis=0)[:2], np.ptp(np.concatenate([low, high]), axis=0)[:2]
        self.count = int(np.clip(math.sqrt(len(triangles)), *COLUMNS))
        self.size = sides / self.count
        first, last = (self._column(each[:, :2]) for each in (low, high))
        wide = last - first + 1
        cells = wide[:, 0] * wide[:, 1]
        owner = np.repeat(np.arange(len(cells)), cells)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(cells) - cells, cells)
        row, column = first[owner, 0] + within // wide[owner, 1], first[owner, 1] + within % wide[owner, 1]
        key = row * self.count + column
        order = np.argsort(key, kind="stable")
        self.owner: Ints = owner[order]
        self.first: Ints = np.searchsorted(key[order], np.arange(self.count**2 + 1))

    def __call__(self, place: Floats, margin: float = 0.0, /) -> Bools:
        """(k,) which points (k, 3) are within it, or within a margin of it [m]."""
        at = (place - self.origin) @ self.frame.T
        found = np.zeros(len(at), dtype=np.bool_)
        column = self._column(at[:, :2])
        inside = ((at[:, :2] >= self.low) & (at[:, :2] <= self.low + self.count * self.size)).all(axis=1)
        point = np.flatnonzero(inside)
        key = column[point, 0] * self.count + column[point, 1]
        counts = self.first[key + 1] - self.first[key]
        ends = np.cumsum(counts)
        begin = 0
        while begin < len(point):
            end = max(int(np.searchsorted(ends, (ends[begin - 1] if begin else 0) + AT_ONCE, "right")), begin + 1)
            some = slice(begin, end)
            which = np.repeat(np.arange(begin, end), counts[some])
            offset = np.arange(len(which)) - np.repeat(np.cumsum(counts[some]) - counts[some], counts[some])
            triangle = self.triangles[self.owner[self.first[key[which]] + offset]]
            found[point[some]] = self._within(at[point[which]], triangle, which - begin, end - begin, margin)
            begin = end
        return found

    def _column(self, place: Floats) -> Ints:
        """(k, 2) the column of points (k, 2)."""
        found: Ints = np.clip((place - self.low) / self.size, 0, self.count - 1).astype(np.int64)
        return found

    def _within(self, place: Floats, triangle: Floats, owner: Ints, count: int, margin: float) -> Bools:
        """(count,) which points are within, by pairs of one (m, 3) and a triangle (m, 3, 3)."""
        leaves = np.bincount(owner, _crossing(place, triangle), count) > 0.5
        room = self.uncertainty + margin
        if room <= 0.0:
            return leaves
        far = ~leaves[owner]
        near = np.zeros(count, dtype=np.bool_)
        near[owner[far][_square_distance(place[far], triangle[far]) <= room**2]] = True
        return leaves | near


def _askew() -> Floats:
    """Three directions (3, 3), along none that people draw."""
    ray = np.array([0.2718, 0.3141, 0.9094])
    ray /= np.linalg.norm(ray)
    first = np.cross(ray, [0.5772, 0.8165, 0.0])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(ray, first), ray])


def _crossing(place: Floats, triangle: Floats) -> Floats:
    """(m,) 1 where the ray upwards from a point (m, 3) leaves a body through its triangle (m, 3, 3), -1 where it
    enters one, else 0."""
    a, b, c = (triangle[:, k] - place for k in range(3))
    sides = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    turn = sides[0] + sides[1] + sides[2]
    inside = ((sides[0] > 0.0) & (sides[1] > 0.0) & (sides[2] > 0.0)) | (
        (sides[0] < 0.0) & (sides[1] < 0.0) & (sides[2] < 0.0)
    )
    above = sides[0] * a[:, 2] + sides[1] * b[:, 2] + sides[2] * c[:, 2]
    return np.where(inside & (above * turn > 0.0), np.sign(turn), 0.0)


def _square_distance(place: Floats, triangle: Floats) -> Floats:
    """(m,) squared distance [m2] of points (m, 3) to triangles (m, 3, 3)."""
    corners = [triangle[:, k] for k in range(3)]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    size = np.maximum(np.einsum("mc,mc->m", normal, normal), 1e-60)
    above = np.einsum("mc,mc->m", place - corners[0], normal) ** 2 / size
    inside = np.ones(len(place), dtype=np.bool_)
    nearest = np.full(len(place), np.inf)
    for p, q in zip(corners, (*corners[1:], corners[0])):
        edge, way = q - p, place - p
        inside &= np.einsum("mc,mc->m", np.cross(edge, way), normal) >= 0.0
        share = np.einsum("mc,mc->m", way, edge) / np.maximum(np.einsum("mc,mc->m", edge, edge), 1e-60)
        off = way - np.clip(share, 0.0, 1.0)[:, None] * edge
        nearest = np.minimum(nearest, np.einsum("mc,mc->m", off, off))
    return np.where(inside, above, nearest)

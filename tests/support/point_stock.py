"""A stock of points, taken away one by one where a tool is: slow, simple, and with no code of the dexels."""

from __future__ import annotations

import numpy as np

from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.simulation.stock_range import Solids
from toolpace.cutting.tool_profile import ToolProfile


def radius_at(solid: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Of a solid of revolution at a height above the tip [m]; below zero where there is none."""
    radius = np.full(np.shape(height), -1.0)
    for z0, z1, a, b, arc, _ in solid:
        here = (height >= z0) & (height <= z1)
        straight = a + b * height
        bowed = a + np.sqrt(np.maximum(arc**2 - (height - b) ** 2, 0.0))
        radius = np.where(here, bowed if arc > 0.0 else straight, radius)
    return radius


def outline(solid: np.ndarray, count: int = 80) -> np.ndarray:
    """(k, 2) points of the half section of a solid, radius and height, with both ends closed."""
    low, high = solid[0, 0], solid[-1, 1]
    height = np.linspace(low, high, count)
    radius = radius_at(solid, height)
    lower, upper = (
        np.column_stack([np.linspace(0.0, r, 20), np.full(20, z)]) for r, z in ((radius[0], low), (radius[-1], high))
    )
    return np.concatenate([lower, np.column_stack([radius, height]), upper])


class PointStock:
    """Points in the middle of cells, each of which stands for the volume of a cell."""

    def __init__(self, points: np.ndarray, cell: float) -> None:
        self.points, self.cell, self.resolution = points, cell, cell

    @classmethod
    def box(cls, low: object, high: object, cell: float) -> PointStock:
        low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        count = np.maximum(np.round((high - low) / cell).astype(int), 1)
        axes = [low[k] + (np.arange(count[k]) + 0.5) * (high[k] - low[k]) / count[k] for k in range(3)]
        return cls(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3), cell)

    def volume(self) -> float:
        return len(self.points) * self.cell**3

    def copy(self) -> PointStock:
        return PointStock(self.points, self.cell)

    def within(self, solid: np.ndarray, tip: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which points are in a solid at a pose, and their radius and height there (k, 2)."""
        off = self.points - tip
        height = off @ axis
        near = np.flatnonzero((height >= solid[0, 0]) & (height <= solid[-1, 1]))
        across = np.sqrt(np.maximum((off[near] ** 2).sum(axis=1) - height[near] ** 2, 0.0))
        inside = across <= radius_at(solid, height[near])
        return near[inside], np.column_stack([across, height[near]])[inside]

    def cut(self, profile: ToolProfile, stations: Stations) -> EngagementTable:
        n = len(stations)
        removed, width, depth, penetration = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 2))
        slices: list[np.ndarray] = [np.zeros(0, dtype=np.int64)] * n
        feed = np.array([1.0, 0.0, 0.0])
        for k in range(n):
            tip, axis = stations.tip[k], stations.axis[k]
            penetration[k] = [self._depth(solids, tip, axis) for solids in (profile.shank, profile.holder)]
            step = tip - stations.tip[max(k - 1, 0)]
            step = step - (step @ axis) * axis
            if np.linalg.norm(step) > 1e-12:
                feed = step / np.linalg.norm(step)
            hit, place = self.within(profile.cutting, tip, axis)
            if len(hit):
                side = (self.points[hit] - tip) @ np.cross(axis, feed)
                removed[k] = len(hit) * self.cell**3
                width[k], depth[k] = np.ptp(side) + self.cell, np.ptp(place[:, 1]) + self.cell
                slices[k] = np.unique((place[:, 1] / self.cell).astype(np.int64))
                self.points = np.delete(self.points, hit, axis=0)
        count = sum(map(len, slices))
        return EngagementTable(
            slice_height=self.cell, feed_direction=np.zeros((n, 3)), across=np.ones(n), along=np.zeros(n),
            first_arc=np.cumsum([0, *map(len, slices)]), slice=np.concatenate(slices), entry=np.zeros(count),
            exit=np.full(count, 2.0 * np.pi), bottom=np.zeros(n), removed=removed, width=width, depth=depth,
            penetration=penetration,
        )  # fmt: skip

    def depth_in_material(self, solids: Solids, stations: Stations) -> np.ndarray:
        return np.array([self._depth(solids, tip, axis) for tip, axis in zip(stations.tip, stations.axis)])

    def _depth(self, solids: Solids, tip: np.ndarray, axis: np.ndarray) -> float:
        """How far within the solids their deepest point is."""
        deepest = 0.0
        for solid in solids:
            _, place = self.within(solid, tip, axis)
            for some in np.array_split(place, len(place) // 2000 + 1) if len(place) else ():
                off = np.linalg.norm(some[:, None] - outline(solid)[None], axis=2).min(axis=1)
                deepest = max(deepest, float(off.max()))
        return deepest

    def triangles(self) -> np.ndarray:
        return np.zeros((0, 3, 3))

"""A stock of voxels, cut one by one: slow, simple, and with no code of the dexels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.engagement.table import Engagement
from toolpace.cutting.simulation.simulate import ToolInUse
from toolpace.programs.tool_figures import ToolFigures


@dataclass(frozen=True)
class Part:
    """Cutting part, shank or holder of a tool."""

    figures: ToolFigures
    name: str

    def span(self) -> tuple[float, float]:
        """From where to where above the tip it is [m]."""
        figures = self.figures
        out = figures.stick_out or figures.flute_length or figures.diameter
        flutes = figures.flute_length or out
        holder = sum(piece.length for piece in figures.holder)
        return {"cutting": (0.0, flutes), "shank": (flutes, out), "holder": (out, out + holder)}[self.name]

    def radius(self, height: np.ndarray) -> np.ndarray:
        """Of the part at a height above the tip [m]; below zero where there is none."""
        figures, (low, high) = self.figures, self.span()
        if self.name == "cutting":
            whole, corner = 0.5 * figures.diameter, figures.corner_radius
            if figures.kind == "ball":
                corner = whole
            below = np.clip(corner - height, 0.0, corner)
            radius = whole - corner + np.sqrt(np.maximum(corner**2 - below**2, 0.0))
        elif self.name == "shank":
            radius = np.full(height.shape, 0.5 * (figures.shank_diameter or figures.diameter))
        else:
            radius, base = np.full(height.shape, -1.0), low
            for piece in figures.holder:
                share = np.clip((height - base) / piece.length, 0.0, 1.0)
                wide = 0.5 * (piece.lower_diameter + share * (piece.upper_diameter - piece.lower_diameter))
                radius = np.where((height >= base) & (height <= base + piece.length), wide, radius)
                base += piece.length
        return np.where((height >= low) & (height <= high), radius, -1.0)


@dataclass(frozen=True)
class Parts:
    cutting: Part
    shank: Part | None
    holder: Part | None


def tool_in_use(figures: ToolFigures) -> ToolInUse:
    parts = {name: Part(figures, name) for name in ("cutting", "shank", "holder")}
    there = {name: part if part.span()[1] > part.span()[0] else None for name, part in parts.items()}
    return ToolInUse(figures, Parts(parts["cutting"], there["shank"], there["holder"]))


class VoxelStock:
    def __init__(self, low: np.ndarray, material: np.ndarray, cell: float) -> None:
        self.low, self.material, self.cell = np.asarray(low, dtype=float), material, cell
        axes = [low[k] + (np.arange(material.shape[k]) + 0.5) * cell for k in range(3)]
        self.points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    @classmethod
    def box(cls, low: object, high: object, cell: float, room: float = 0.0) -> VoxelStock:
        """A box, in a field that is larger by `room` all round."""
        low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        count = np.ceil((high - low + 2.0 * room) / cell - 1e-9).astype(int)
        made = cls(low - room, np.ones(count, dtype=bool), cell)
        made.material = ((made.points > low) & (made.points < high)).all(axis=-1)
        return made

    @property
    def volume(self) -> float:
        return float(self.material.sum()) * self.cell**3

    def copy(self) -> VoxelStock:
        return VoxelStock(self.low, self.material.copy(), self.cell)

    def inside(self, part: Part, tip: np.ndarray, axis: np.ndarray) -> np.ndarray:
        off = self.points - tip
        height = off @ axis
        square = np.maximum((off**2).sum(axis=-1) - height**2, 0.0)
        radius = part.radius(height)
        return (radius >= 0.0) & (square <= radius**2)

    def cut(self, tool: Parts, stations: Stations) -> Engagement:
        n = len(stations)
        removed, width, depth, penetration = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 2))
        feed = np.array([1.0, 0.0, 0.0])
        for k in range(n):
            tip, axis = stations.tip[k], stations.axis[k]
            for at, part in enumerate((tool.shank, tool.holder)):
                if part is not None:
                    penetration[k, at] = self._depth(part, tip, axis, self._distance())
            if k:
                step = tip - stations.tip[k - 1]
                step = step - (step @ axis) * axis
                if np.linalg.norm(step) > 1e-12:
                    feed = step / np.linalg.norm(step)
            hit = self.material & self.inside(tool.cutting, tip, axis)
            if hit.any():
                points = self.points[hit]
                removed[k] = hit.sum() * self.cell**3
                height, side = (points - tip) @ axis, (points - tip) @ np.cross(axis, feed)
                width[k], depth[k] = np.ptp(side) + self.cell, np.ptp(height) + self.cell
                self.material &= ~hit
        none = np.zeros(0)
        return Engagement(
            slice_height=self.cell, feed_direction=np.zeros((n, 3)), across=np.ones(n), along=np.zeros(n),
            first_arc=np.zeros(n + 1, dtype=np.int64), slice=np.zeros(0, dtype=np.int64), entry=none, exit=none,
            bottom=np.zeros(n), removed=removed, width=width, depth=depth, penetration=penetration,
        )  # fmt: skip

    def remove(self, part: Part, stations: Stations) -> float:
        before = self.volume
        for tip, axis in zip(stations.tip, stations.axis):
            self.material &= ~self.inside(part, tip, axis)
        return before - self.volume

    def depth_in_material(self, part: Part, stations: Stations) -> np.ndarray:
        distance = self._distance()
        return np.array([self._depth(part, tip, axis, distance) for tip, axis in zip(stations.tip, stations.axis)])

    def _distance(self) -> np.ndarray:
        padded = np.pad(self.material, 1)
        return ndimage.distance_transform_edt(padded)[1:-1, 1:-1, 1:-1] * self.cell

    def _depth(self, part: Part, tip: np.ndarray, axis: np.ndarray, distance: np.ndarray) -> float:
        inside = self.inside(part, tip, axis) & self.material
        return float(distance[inside].max()) if inside.any() else 0.0

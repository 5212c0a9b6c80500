"""Which part of a tool's surface is in material at one instant, from all poses of the motion before it.

A point of the surface of the tool is in material where it is within the stock, and no earlier pose of any tool has
reached it. There are no cells: stock and tools are closed forms, and the only discrete thing is how close the earlier
poses are. The back of the tool, which its own last pose has just left, is told by the motion along the surface's
normal. Ends of arcs are bisected.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.programs.tool_figures import ToolFigures

ANGLES = 180
"""Angles about the axis at which the surface is looked at first."""
BISECTIONS = 12
"""Of an end of an arc: to a twentieth of a hundredth of a degree."""
HEIGHTS, COARSE_ANGLES, FINER = 100, 48, 10
"""At which it is looked for how far up the tool is in material."""
POSES = 256
"""Earlier poses that are looked at in one piece."""
GAP = 1e-9
"""Closer to an earlier tool than that is within it [m]."""

Stock = Callable[[Floats], Bools]
"""Tells which points (k, 3) are within the stock."""


@dataclass(frozen=True)
class Shape:
    """The cutting part of a tool in heights above its tip, in closed form."""

    radius: Callable[[Floats], Floats]
    """(n,) at heights (n,) [m]."""
    reach: float
    """How far up its edge goes [m]."""
    widest: float
    """[m]"""

    def normal(self, height: Floats) -> tuple[Floats, Floats]:
        """Of the surface at heights (n,): its part across the axis and its part along it."""
        step = 1e-6 * self.widest
        low, high = np.maximum(height - step, 0.0), np.minimum(height + step, self.reach)
        slope = (self.radius(high) - self.radius(low)) / (high - low)
        length = np.hypot(1.0, slope)
        return 1.0 / length, -slope / length


def shape_of(tool: ToolFigures) -> Shape | None:
    """The shape of a tool; None of a kind that is not judged."""
    half, corner = 0.5 * tool.diameter, 0.5 * tool.diameter if tool.kind == "ball" else tool.corner_radius
    reach = tool.flute_length or tool.stick_out or 10.0 * tool.diameter
    cone = tool.taper if tool.kind == "taper" else 0.0
    if tool.kind not in ("flat", "bull", "ball", "face", "taper") or (tool.kind != "taper" and tool.taper > 0.0):
        return None
    begin, low = corner * (1.0 - math.sin(cone)), half - corner * (1.0 - math.cos(cone))

    def radius(height: Floats) -> Floats:
        within = np.clip(corner - height, 0.0, corner)
        on_corner = half - corner + np.sqrt(np.maximum(corner**2 - within**2, 0.0))
        found: Floats = np.where(height < begin, on_corner, low + (height - begin) * math.tan(cone))
        return found

    return Shape(radius, reach, half + reach * math.tan(cone))


@dataclass(frozen=True)
class Poses:
    """n poses of the tools in the order of time, close to each other."""

    tip: Floats
    """(n, 3) [m]"""
    axis: Floats
    """(n, 3)"""
    tool: Ints
    """(n,) index of the shape; -1 where it has none."""


@dataclass(frozen=True)
class Section:
    """What of the tool is in material at one instant."""

    height: Floats
    """(k,) middle of each slice [m]."""
    slice_height: float
    arcs: tuple[tuple[int, float, float], ...]
    """Slice, entry and exit [rad]: from the normal on the left of the feed, clockwise seen from the spindle."""

    @property
    def immersion(self) -> Floats:
        """(k,) angle in material of each slice [rad]."""
        found = np.zeros(len(self.height))
        for j, entry, leave in self.arcs:
            found[j] += leave - entry
        return found


class Surface:
    """The surface of the tool at pose k, which moves with a velocity (3,) [m/s] while its axis turns with an angular
    velocity (3,) [rad/s], among what all poses before it have left of the stock."""

    def __init__(
        self, k: int, poses: Poses, shapes: tuple[Shape, ...], stock: Stock, velocity: Floats, turning: Floats
    ) -> None:
        self.shape, self.tip, self.axis = shapes[poses.tool[k]], poses.tip[k], poses.axis[k]
        self.poses, self.shapes, self.stock = poses, shapes, stock
        self.velocity, self.turning = velocity, turning
        self.feed, self.left = across(velocity, self.axis)
        self.before = near(k, poses, shapes)

    def in_material(self, height: Floats, angle: Floats) -> Bools:
        """(n,) whether it moves into material at heights (n,) [m] and angles (n,) [rad]."""
        sine, cosine = self.shape.normal(height)
        direction = np.cos(angle)[:, None] * self.left + np.sin(angle)[:, None] * self.feed
        place = self.tip + height[:, None] * self.axis + self.shape.radius(height)[:, None] * direction
        moves = self.velocity + np.cross(self.turning, place - self.tip)
        found: Bools = np.einsum("kc,kc->k", moves, sine[:, None] * direction + cosine[:, None] * self.axis) > 0.0
        found[found] = self.stock(place[found])
        found[found] = ~reached(place[found], self.before, self.poses, self.shapes)
        return found

    def top(self) -> float:
        """How far up it is in material [m], to a thousandth of its edge; 0 where it is nowhere."""
        step, turn = self.shape.reach / HEIGHTS, 2.0 * math.pi / COARSE_ANGLES
        height = np.repeat((np.arange(HEIGHTS) + 0.5) * step, COARSE_ANGLES)
        angle = np.tile((np.arange(COARSE_ANGLES) + 0.5) * turn, HEIGHTS)
        within = np.flatnonzero(self.in_material(height, angle))
        if not len(within):
            return 0.0
        low = float(height[within[-1]])
        finer = np.linspace(low, low + step, FINER + 1)
        height, angle = np.repeat(finer, ANGLES), np.tile((np.arange(ANGLES) + 0.5) * 2.0 * math.pi / ANGLES, FINER + 1)
        within = np.flatnonzero(self.in_material(np.minimum(height, self.shape.reach), angle))
        return float(height[within[-1]]) if len(within) else low

    def section(self, heights: Floats) -> Section:
        """The arcs at the middles of slices `heights` (m,) [m]."""
        count, step = len(heights), 2.0 * math.pi / ANGLES
        angle = np.tile((np.arange(ANGLES) + 0.5) * step, count)
        inside = self.in_material(np.repeat(heights, ANGLES), angle).reshape(count, ANGLES)
        row, column = np.nonzero(inside != np.roll(inside, 1, axis=1))
        high, enters = (column + 0.5) * step, inside[row, column]
        low = high - step
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = self.in_material(heights[row], middle) == enters
            high, low = np.where(same, middle, high), np.where(same, low, middle)
        edge, turn = 0.5 * (low + high), 2.0 * math.pi
        arcs = [(j, 0.0, turn) for j in range(count) if inside[j].all()]
        for j in range(count):
            entries, exits = edge[(row == j) & enters], edge[(row == j) & ~enters]
            for entry in entries.tolist():
                behind = exits[exits > entry]
                leave = float(behind.min()) if len(behind) else float(exits.min()) + turn
                arcs.append((j, entry % turn, entry % turn + leave - entry))
        return Section(heights, float(heights[1] - heights[0]), tuple(arcs))


def across(velocity: Floats, axis: Floats) -> tuple[Floats, Floats]:
    """The direction of the feed across the axis, and that on the left of it, (3,) each."""
    feed = velocity - (velocity @ axis) * axis
    length = float(np.linalg.norm(feed))
    if length < 1e-9 * max(float(np.linalg.norm(velocity)), 1e-12):
        feed = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        length = float(np.linalg.norm(feed))
    feed = feed / length
    return feed, np.cross(axis, feed)


def near(k: int, poses: Poses, shapes: tuple[Shape, ...]) -> Ints:
    """Earlier poses whose tool can have reached the tool of pose k, the last first."""
    widest = np.array([shape.widest for shape in shapes] + [0.0])
    own = shapes[poses.tool[k]]
    off = poses.tip[:k] - poses.tip[k]
    # the tip of a tool may be far below: it reaches up to the end of its edge
    reach = np.array([shape.reach for shape in shapes] + [0.0])[poses.tool[:k]]
    along = np.einsum("nc,nc->n", off, poses.axis[:k])
    beside = np.linalg.norm(off - along[:, None] * poses.axis[:k], axis=1)
    # a tilted axis brings the end of the edge over by its length
    tilt = np.linalg.norm(poses.axis[:k] - poses.axis[k], axis=1)
    wide = own.widest + widest[poses.tool[:k]] + own.reach * tilt
    found = (poses.tool[:k] >= 0) & (beside < wide) & (along < own.reach + wide) & (along > -reach - wide)
    return np.flatnonzero(found)[::-1]


def reached(place: Floats, before: Ints, poses: Poses, shapes: tuple[Shape, ...]) -> Bools:
    """(k,) which points (k, 3) a tool has been at in the poses `before` (n,)."""
    found = np.zeros(len(place), dtype=np.bool_)
    left = np.arange(len(place))
    # about the tool, squares lose few digits
    origin = place[0] if len(place) else np.zeros(3)
    for begin in range(0, len(before), POSES):
        if not len(left):
            break
        some = before[begin : begin + POSES]
        tip, axis = poses.tip[some] - origin, poses.axis[some]
        at = place[left] - origin
        height = at @ axis.T - np.einsum("nc,nc->n", tip, axis)
        square = np.einsum("kc,kc->k", at, at)[:, None] - 2.0 * at @ tip.T + np.einsum("nc,nc->n", tip, tip) - height**2
        hit = np.zeros(len(left), dtype=np.bool_)
        for tool in np.unique(poses.tool[some]).tolist():
            shape, mine = shapes[tool], poses.tool[some] == tool
            z, r = height[:, mine], square[:, mine]
            beside = (z > GAP) & (z < shape.reach) & (r < shape.widest**2)
            row, column = np.nonzero(beside)
            rim = np.maximum(shape.radius(z[row, column]) - GAP, 0.0)
            hit[row[r[row, column] < rim**2]] = True
        found[left[hit]] = True
        left = left[~hit]
    return found

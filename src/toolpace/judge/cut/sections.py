"""Which part of a tool's surface is in material at one instant, from all poses of the motion before it.

A point of the surface of the tool is in material where it is within the stock, and no earlier pose of any tool has
reached it. There are no cells: stock and tools are closed forms, and the only discrete thing is how close the earlier
poses are. The back of the tool, which its own last pose has just left, is told by the motion along the surface's
normal. Ends of arcs are bisected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.cut.shapes import Shape
from toolpace.judge.cut.stocks import Stock

TURN = 2.0 * math.pi
ANGLES = 120
"""Angles about the axis at which the surface is looked at first."""
BISECTIONS = 13
"""Of an end of an arc: to a twentieth of a hundredth of a degree."""
BANDS, BANDS_OF_PIECE, BANDS_OF_FLAT = 32, 4, 8
"""Of the surface that may be in material, at least: in all, of a piece of the meridian, and of the flat of the end."""
LENGTHS, COARSE_ANGLES = 64, 48
"""At which it is looked for how far up the tool is in material; lengths are closer to each other near the end."""
GAP = 1e-9
"""Closer to an earlier tool than that is within it [m]."""
SLIDES = 1e-3
"""Share of the motion: where the surface moves outwards by less at any angle, it slides."""
BLOCK = 256
"""Poses of the motion that one box is about."""


@dataclass(frozen=True)
class Poses:
    """n poses of the tools in the order of time, close to each other."""

    tip: Floats
    """(n, 3) [m]"""
    axis: Floats
    """(n, 3)"""
    tool: Ints
    """(n,) index of the shape; -1 where it has none."""

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Least and most tip (blocks, 3) of each BLOCK of them, whatever the tool."""
        first = np.arange(0, len(self.tip), BLOCK)
        return np.minimum.reduceat(self.tip, first), np.maximum.reduceat(self.tip, first)


@dataclass(frozen=True)
class Section:
    """What of the tool is in material at one instant, in bands of its surface."""

    edges: Floats
    """(bands, 2) lengths of the meridian at both ends of each [m]."""
    arcs: tuple[tuple[int, float, float], ...]
    """Band, entry and exit [rad]: from the normal on the left of the feed, clockwise seen from the spindle."""


class ToolMotion:
    """A tool at one instant: its tip moves with a velocity (3,) [m/s], its axis turns with an angular velocity (3,)
    [rad/s]. Angles are about the axis, from the left of the feed, clockwise seen from the spindle."""

    def __init__(self, shape: Shape, tip: Floats, axis: Floats, velocity: Floats, turning: Floats) -> None:
        self.shape, self.tip, self.axis, self.velocity, self.turning = shape, tip, axis, velocity, turning
        self.along = float(velocity @ axis)
        self.swing = np.cross(turning, axis)
        self.feed, self.left = across(velocity, axis)
        self.speed = float(np.linalg.norm(velocity)) + shape.reach * float(np.linalg.norm(self.swing))

    def times(self, factor: float) -> ToolMotion:
        """The same, so many times as fast."""
        return ToolMotion(self.shape, self.tip, self.axis, factor * self.velocity, factor * self.turning)

    def angle_of_feed(self, feed: Floats) -> float:
        """By how much angles are larger here than those about another direction of the feed (3,) [rad]."""
        left = np.cross(self.axis, feed)
        return math.atan2(float(left @ self.feed), float(left @ self.left))

    def direction(self, angle: Floats) -> Floats:
        """(..., 3) across the axis at angles (...)."""
        return np.cos(angle)[..., None] * self.left + np.sin(angle)[..., None] * self.feed

    def place(self, length: Floats, angle: Floats) -> Floats:
        """(m, k, 3) of the surface at lengths of the meridian (m,) and angles (m, k) or (k,) [m]."""
        radius, height, _ = self.shape.at(length)
        middle = self.tip + height[:, None] * self.axis
        found: Floats = middle[:, None] + radius[:, None, None] * self.direction(angle)
        return found

    def outward_terms(self, length: Floats) -> Floats:
        """(m, 3) how fast the surface moves along its normal at lengths (m,): by the cosine and the sine of its angle,
        and at all [m/s]; 0 where it slides at all angles."""
        radius, height, kappa = self.shape.at(length)
        sine, cosine = np.sin(kappa)[:, None], np.cos(kappa)
        lever = height * sine[:, 0] + radius * cosine
        sideways = sine * (self.velocity - self.along * self.axis) + lever[:, None] * self.swing
        terms = np.column_stack([sideways @ self.left, sideways @ self.feed, -cosine * self.along])
        most = np.hypot(terms[:, 0], terms[:, 1]) + terms[:, 2]
        found: Floats = np.where((most > SLIDES * self.speed)[:, None], terms, 0.0)
        return found

    def outwards(self, length: Floats, angle: Floats) -> Floats:
        """(m, k) how fast it does at lengths (m,) and angles (m, k) or (k,) [m/s]."""
        cosine, sine, whole = self.outward_terms(length).T[:, :, None]
        found: Floats = cosine * np.cos(angle) + sine * np.sin(angle) + whole
        return found


class Surface:
    """The surface of the tool at pose k of a motion, among what all poses before it have left of the stock."""

    def __init__(self, motion: ToolMotion, k: int, poses: Poses, shapes: tuple[Shape, ...], stock: Stock) -> None:
        self.motion, self.shape = motion, motion.shape
        self.stock = stock
        self.swept = SweptTools(near(motion, k, poses, shapes), poses, shapes)

    def in_material(self, length: Floats, angle: Floats, margin: float = 0.0, room: float = 0.0) -> Bools:
        """(m, k) whether it moves into material at lengths (m,) of the meridian [m] and angles (m, k) or (k,) [rad];
        into that of a stock which is larger by a margin [m], and of which earlier tools have left more by `room` [m].
        """
        found: Bools = self.motion.outwards(length, angle) > 0.0
        place = self.motion.place(length, angle)[found]
        inside = self.stock(place, margin)
        inside[inside] = ~self.swept(place[inside], GAP + room)
        found[found] = inside
        return found

    def top(self) -> float:
        """The meridian's length up to which it is in material [m]; 0 where it is nowhere."""
        flat = self.shape.flat
        side = flat + (self.shape.length - flat) * (np.arange(1, LENGTHS + 1) / LENGTHS) ** 2
        end = flat * (np.arange(BANDS_OF_FLAT) + 0.5) / BANDS_OF_FLAT if flat > 0.0 else np.zeros(0)
        low, high, lengths = 0.0, self.shape.length, np.concatenate([end, side])
        for _ in range(3):
            within = np.flatnonzero(self._anywhere(lengths))
            if len(within):
                low = float(lengths[within[-1]])
            elif low == 0.0:
                return 0.0
            beyond = lengths[lengths > low]
            high = float(beyond[0]) if len(beyond) else high
            lengths = np.linspace(low, high, 12)[1:-1]
        return 0.5 * (low + high)

    def _anywhere(self, lengths: Floats) -> Bools:
        """(m,) whether it is in material at any angle, at lengths (m,)."""
        return np.asarray(self.seen_at(lengths, COARSE_ANGLES).any(axis=1))

    def section(self) -> Section:
        """Its arcs, by bands up to where it is in material."""
        edges = bands_of(self.shape, self.top())
        return Section(edges, self.arcs(edges.mean(axis=1)))

    def seen_at(
        self, lengths: Floats, count: int, margin: float = 0.0, first: float = 0.0, room: float = 0.0
    ) -> Bools:
        """(m, count) whether it is in material at lengths (m,), at so many angles from the first on; see
        `in_material`."""
        return self.in_material(lengths, first + (np.arange(count) + 0.5) * TURN / count, margin, room)

    def arcs(self, lengths: Floats) -> tuple[tuple[int, float, float], ...]:
        """Those at lengths (m,): which, entry and exit [rad]."""
        count, step = len(lengths), TURN / ANGLES
        inside = self.seen_at(lengths, ANGLES)
        row, column = np.nonzero(inside != np.roll(inside, 1, axis=1))
        high, enters = (column + 0.5) * step, inside[row, column]
        low = high - step
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = self.in_material(lengths[row], middle[:, None])[:, 0] == enters
            high, low = np.where(same, middle, high), np.where(same, low, middle)
        edge = 0.5 * (low + high)
        arcs = [(j, 0.0, TURN) for j in range(count) if inside[j].all()]
        for j in range(count):
            entries, exits = edge[(row == j) & enters], edge[(row == j) & ~enters]
            for entry in entries.tolist():
                behind = exits[exits > entry]
                leave = float(behind.min()) if len(behind) else float(exits.min()) + TURN
                arcs.append((j, entry % TURN, entry % TURN + leave - entry))
        return tuple(arcs)


def bands_of(shape: Shape, top: float) -> Floats:
    """(bands, 2) both ends of the bands of a meridian up to a length [m]; each is in one piece of it."""
    rows = [np.zeros((0, 2))]
    whole = max(top - shape.flat, 1e-12)
    for low, high in zip(shape.begin[:-1].tolist(), np.minimum(shape.begin[1:], top).tolist()):
        if high > low:
            share = math.ceil(BANDS * (high - low) / whole)
            count = BANDS_OF_FLAT if high <= shape.flat else max(share, BANDS_OF_PIECE)
            edges = np.linspace(low, high, count + 1)
            rows.append(np.column_stack([edges[:-1], edges[1:]]))
    return np.concatenate(rows)


def across(velocity: Floats, axis: Floats) -> tuple[Floats, Floats]:
    """The direction of the feed across the axis, and that on the left of it, (3,) each."""
    feed = velocity - (velocity @ axis) * axis
    length = float(np.linalg.norm(feed))
    if length < 1e-6 * max(float(np.linalg.norm(velocity)), 1e-12):
        feed = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        length = float(np.linalg.norm(feed))
    feed = feed / length
    return feed, np.cross(axis, feed)


def near(motion: ToolMotion, k: int, poses: Poses, shapes: tuple[Shape, ...]) -> Ints:
    """Poses before pose k whose tool can have reached its tool, the last first."""
    widest = np.array([shape.widest for shape in shapes] + [0.0])
    reach = np.array([shape.reach for shape in shapes] + [0.0])
    own = motion.shape
    low, high = poses.boxes
    room = own.widest + own.reach + float(widest.max()) + float(reach.max())
    box = np.flatnonzero(((low <= motion.tip + room) & (high >= motion.tip - room)).all(axis=1))
    rows = (box[:, None] * BLOCK + np.arange(BLOCK)).ravel()
    rows = rows[rows < k]
    tool, axis = poses.tool[rows], poses.axis[rows]
    off = poses.tip[rows] - motion.tip
    # the tip of a tool may be far below: it reaches up to the end of its edge
    along = np.einsum("nc,nc->n", off, axis)
    beside = np.linalg.norm(off - along[:, None] * axis, axis=1)
    # a tilted axis brings the end of the edge over by its length
    tilt = np.linalg.norm(axis - motion.axis, axis=1)
    wide = own.widest + widest[tool] + own.reach * tilt
    found = (tool >= 0) & (beside < wide) & (along < own.reach + wide) & (along > -reach[tool] - wide)
    kept: Ints = rows[found][::-1]
    return kept


class SweptTools:
    """Where tools have been in some poses of a motion (n,)."""

    def __init__(self, some: Ints, poses: Poses, shapes: tuple[Shape, ...]) -> None:
        from toolpace.kernels.judge.swept_tools import Solids, ToolPoses, groups

        pieces = [
            np.column_stack([each.height[:-1], each.radius, np.sin(each.kappa), np.cos(each.kappa), each.curvature])
            for each in shapes
        ]
        first = np.cumsum([0, *map(len, pieces)])
        reach, widest = (np.array([getattr(each, name) for each in shapes]) for name in ("reach", "widest"))
        self.solids = Solids(np.concatenate(pieces), first, reach, widest)
        self.poses = ToolPoses(poses.tip[some], poses.axis[some], poses.tool[some])
        self.groups = groups(self.poses, self.solids)

    def __call__(self, place: Floats, depth: float = GAP) -> Bools:
        """(k,) which points (k, 3) one has been at, deeper than a depth within it [m]."""
        from toolpace.kernels.judge.swept_tools import reached

        return reached(place, self.poses, self.groups, self.solids, depth)

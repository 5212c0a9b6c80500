"""What set-points cut at instants of the judge's own choice: the section of the material, and what the tool takes.

Nothing of the stock's cells, of engagement or of forces of the accused is used: see `sections.py`, `turning.py`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.cut.beam import ToolBeam
from toolpace.judge.cut.sections import Poses, Section, Surface, SweptTools, ToolMotion, near
from toolpace.judge.cut.shapes import Shape, shape_of
from toolpace.judge.cut.stocks import Stock
from toolpace.judge.cut.turning import Cutting, loads_of
from toolpace.machine.cutting_tool import Coefficients
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

CLOSE = 0.1e-3
"""Most between two poses of the swept tools [m]: a mill of 2 mm leaves ridges of a micrometre between them."""
NEAR = 4
"""Places on each side of one at which a cut is looked at that is known to a cell."""
HEIGHTS, AROUND, BESIDE = 24, 48, 0.3
"""Of a tool's surface at which it is looked for material that stays, and how far outside it, as a share of a cell."""
STANDS = 1e-9
"""Less than that the tip does not move from one set-point to the next but one [m]."""


@dataclass(frozen=True)
class CutPromise:
    """What a plan says of its cut, and what it is of."""

    feeds: str
    """program, air, learned or limits."""
    stock: Stock | None
    """The largest that there may be; None where it is a guess, on which no speed may be raised."""
    tools: Sequence[ToolFigures | None]
    """Of each operation."""
    limits: Mapping[str, Mapping[str, float]]
    """By tool, "" for all, in SI."""
    coefficients: Mapping[str, Coefficients]
    """Of what is cut, likewise."""
    teachers: Mapping[str, Sequence[tuple[float, float, float]]]
    """By tool: chip [m], area of the chips [m2] and length of the edge [m] that places take which teach."""
    resolution: float
    """Size of a cell of the stock that the plan was made with [m]."""
    margin: float = 0.0
    """By how much more than the stock its cells may be in material: by one, where it is grown by an uncertainty [m]."""
    spindle: Mapping[str, Sequence[tuple[float, float]]] = field(default_factory=dict)
    """Most power [W] and torque [N m] that the spindle gives, over turns per second [1/s]: by the name of the limit."""

    finishing: bool = True
    """Whether speeds may be raised where a surface is made that stays."""
    uncertainty: float = 0.0
    """By how much `stock` is larger than the one that is told [m]."""

    def limits_of(self, tool: str, turns: float) -> dict[str, float]:
        """Those of a tool at turns of the spindle per second [1/s]: its own, and what the spindle gives where forces
        are known."""
        found = {**self.limits.get("", {}), **self.limits.get(tool, {})}
        for name, curve in self.spindle.items() if self.coefficients_of(tool) is not None else ():
            speeds, most = zip(*curve)
            found[name] = min(found.get(name, math.inf), float(np.interp(turns, speeds, most)))
        return found

    def coefficients_of(self, tool: str) -> Coefficients | None:
        """Of what a tool cuts; None where they are not told."""
        return self.coefficients.get(tool, self.coefficients.get(""))


@dataclass(frozen=True)
class Instant:
    """What the judge found at one time."""

    row: int
    """The set-point."""
    time: float
    """[s]"""
    block: int
    tool: str
    """As the program calls it."""
    speed: float
    """Of the tip [m/s]."""
    feed: float
    """The highest of the program in this block [m/s]."""
    limits: Mapping[str, float]
    """Of its loads, in SI."""
    loads: Mapping[str, float]
    """In SI, by the names of limits; "layer" is what is cut on the mean over the height of the cut [m]."""


class CutJudge:
    """Sees the cut of a motion of a promise at some instants. Of a tool that bends, on a path that is compensated for
    it, `bent` (n, 3) is where its tip is in truth at the set-points, to within `room` [m]."""

    def __init__(
        self, points: SetPoints, toolpath: ToolPath, promise: CutPromise, bent: Floats | None = None, room: float = 0.0
    ) -> None:
        self.points, self.toolpath, self.promise = points, toolpath, promise
        self.tip: Floats = points.tip if bent is None else bent
        self.give = None if bent is None else bent - points.tip
        self.room = room
        self.shapes: tuple[Shape, ...] = tuple(shape_of(tool) for tool in promise.tools if tool is not None)
        there = np.array([tool is not None for tool in promise.tools], dtype=np.bool_)
        self.shape_of_operation = np.where(there, np.cumsum(there) - 1, -1)
        self.beams = [None if tool is None or tool.stick_out is None else ToolBeam(tool) for tool in promise.tools]
        self.operation, self.rapid = self._of_blocks()
        self.poses, self.row = self._poses()
        self._found: dict[tuple[int, float | None], Instant] = {}

    @property
    def unseen(self) -> list[str]:
        """Tools at feed whose shape is not known."""
        at_feed = np.unique(self.toolpath.operation[1:][~self.toolpath.rapid[1:]]).tolist()
        return sorted({self.toolpath.operations[k].tool for k in at_feed if self.shape_of_operation[k] < 0})

    def _of_blocks(self) -> tuple[Ints, Bools]:
        """(n,) the operation of each set-point, and whether it is at rapid, by the line that it names."""
        path = self.toolpath
        lines = int(max(path.block.max(), self.points.block.max(initial=0))) + 1
        operation, rapid = np.zeros(lines, dtype=np.int64), np.zeros(lines, dtype=np.bool_)
        operation[path.block], rapid[path.block] = path.operation, path.rapid
        return operation[self.points.block], rapid[self.points.block]

    def _poses(self) -> tuple[Poses, Ints]:
        """Poses of the whole motion, at most CLOSE apart, and the set-point (n,) at or before each."""
        tip, axis, reach = self.tip, self.points.axis, max([each.reach for each in self.shapes], default=0.0)
        moves = np.maximum(
            np.linalg.norm(np.diff(tip, axis=0), axis=1),
            np.linalg.norm(np.diff(tip + reach * axis, axis=0), axis=1),
        )
        way = np.concatenate([[0.0], np.cumsum(moves)])
        kept = np.unique(np.concatenate([[0], np.flatnonzero(np.diff(np.floor(way / CLOSE))) + 1, [len(way) - 1]]))
        parts = np.maximum(np.ceil(np.diff(way[kept]) / CLOSE), 1.0).astype(np.int64)
        cell = np.repeat(np.arange(len(parts)), parts)
        share = (np.arange(len(cell)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[cell]
        low, high = kept[cell], kept[cell + 1]
        between = [each[low] + share[:, None] * (each[high] - each[low]) for each in (tip, axis)]
        row = low + np.floor(share * (high - low)).astype(np.int64)
        unit = between[1] / np.linalg.norm(between[1], axis=1)[:, None]
        return Poses(between[0], unit, self.shape_of_operation[self.operation[row]]), row

    @cached_property
    def moving(self) -> Ints:
        """(n,) set-points at feed at which a tool moves that is judged, neighbours in the same operation."""
        tip = self.tip
        moves = np.linalg.norm(tip[2:] - tip[:-2], axis=1) > STANDS
        same = (self.operation[2:] == self.operation[:-2]) & ~self.rapid[:-2] & ~self.rapid[2:]
        found: Ints = np.flatnonzero(moves & same & (self.shape_of_operation[self.operation[1:-1]] >= 0)) + 1
        return found

    @cached_property
    def speed(self) -> Floats:
        """(n,) of the tip at set-points, by those before and behind [m/s]; 0 at the first and the last."""
        found = np.zeros(len(self.points))
        dt = float(self.points.t[1] - self.points.t[0])
        found[1:-1] = np.linalg.norm(self.points.tip[2:] - self.points.tip[:-2], axis=1) / (2.0 * dt)
        return found

    @cached_property
    def feed(self) -> Floats:
        """(n,) the highest of the program in the block of each set-point [m/s]."""
        path = self.toolpath
        highest = np.zeros(int(max(path.block.max(), self.points.block.max(initial=0))) + 1)
        np.maximum.at(highest, path.block[~path.rapid], path.most_speed[~path.rapid])
        found: Floats = highest[self.points.block]
        return found

    def instants(self, count: int, seed: int = 0, rows: Ints | None = None) -> list[Instant]:
        """What is found at so many of the set-points `rows` (n,), one anywhere in each of as many equal parts; None:
        of all at feed."""
        rows = self.moving if rows is None else rows
        if not len(rows):
            return []
        rng = np.random.default_rng(seed)
        at = rows[((np.arange(count) + rng.random(count)) / count * len(rows)).astype(np.int64)]
        return [self.instant(row) for row in np.unique(at).tolist()]

    def instant(self, row: int, speed: float | None = None) -> Instant:
        """What is found at a set-point; what would be, were the tip as fast as a `speed` [m/s]."""
        if (row, speed) not in self._found:
            surface, points, tool = self.surface(row), self.points, self.tool_at(row)
            own = float(self.speed[row])
            times = 1.0 if speed is None else speed / own
            # what is compensated is the deflection at the speed of the motion
            give = self.give[row] if speed is None and self.give is not None else None
            self._found[row, speed] = Instant(
                row, float(points.t[row]), int(points.block[row]), tool, times * own, float(self.feed[row]),
                self.promise.limits_of(tool, self.turns(row)),
                self.loads(row, surface, surface.section(), times, give),
            )  # fmt: skip
        return self._found[row, speed]

    def loads(
        self, row: int, surface: Surface, section: Section, times: float, give: Floats | None
    ) -> dict[str, float]:
        """What the tool takes in a section at a set-point, at a multiple of its speed; give: see `loads_of`."""
        operation = int(self.operation[row])
        tool, beam = self.promise.tools[operation], self.beams[operation]
        assert tool is not None
        cutting = Cutting(tool, self.promise.coefficients_of(self.tool_at(row)), self.turns(row))
        found = loads_of(section, cutting, surface.motion.times(times), beam, give)
        _, ends, _ = surface.shape.at(section.edges.ravel())
        high = max(float(np.ptp(ends)) if len(ends) else 0.0, self.promise.resolution)
        found["layer"] = found["removal_rate"] / max(times * float(self.speed[row]) * high, 1e-30)
        return found

    def rows_near(self, row: int, way: float) -> list[int]:
        """Set-points before and behind one, as far as the tip moves by `way` [m] and goes on cutting: NEAR each."""
        tip, found = self.tip, {row}
        for step in (-1, 1):
            off = np.linalg.norm(tip[row::step] - tip[row], axis=1)
            beyond = np.flatnonzero((off > way) | (self.operation[row::step] != self.operation[row]))
            reach = min(int(beyond[0]) if len(beyond) else len(off) - 1, max(len(off) - 2, 0))
            found |= {row + step * k * reach // NEAR for k in range(NEAR + 1)}
        return sorted(found)

    def surface(self, row: int) -> Surface:
        """The surface of the tool at a set-point, in what those before it have left."""
        points, dt = self.points, float(self.points.t[1] - self.points.t[0])
        operation = int(self.operation[row])
        axis = points.axis[row]
        velocity = (self.tip[row + 1] - self.tip[row - 1]) / (2.0 * dt)
        turning = np.cross(axis, (points.axis[row + 1] - points.axis[row - 1]) / (2.0 * dt))
        shape = self.shapes[self.shape_of_operation[operation]]
        motion = ToolMotion(shape, self.tip[row], axis, velocity, turning)
        assert self.promise.stock is not None
        before = int(np.searchsorted(self.row, row, side="left"))
        return Surface(motion, before, self.poses, self.shapes, self.promise.stock)

    def staying(self, row: int) -> int:
        """How many points of the tool's surface at a set-point have material close outside them that stays to the end.
        """
        motion = self.surface(row).motion
        shape, share = motion.shape, (np.arange(HEIGHTS) + 0.5) / HEIGHTS
        # closer to each other near the end, where most is cut
        of_flat = shape.flat * share if shape.flat > 0.0 else share[:0]
        length = np.concatenate([of_flat, shape.flat + (shape.length - shape.flat) * share**2])
        angle, kappa = (np.arange(AROUND) + 0.5) * 2.0 * math.pi / AROUND, shape.at(length)[2][:, None, None]
        outwards = np.sin(kappa) * motion.direction(angle) - np.cos(kappa) * motion.axis
        place = (motion.place(length, angle) + BESIDE * self.promise.resolution * outwards).reshape(-1, 3)
        assert self.promise.stock is not None
        place = place[self.promise.stock(place, -self.promise.uncertainty)]
        after = near(motion, len(self.poses.tip), self.poses, self.shapes)
        return int((~SweptTools(after, self.poses, self.shapes)(place)).sum())

    def tool_at(self, row: int) -> str:
        """The tool of a set-point, as the program calls it."""
        return self.toolpath.operations[int(self.operation[row])].tool

    def turns(self, row: int) -> float:
        """Of the spindle per second at a set-point [1/s]."""
        speed = self.toolpath.spindle[self.toolpath.block == self.points.block[row]]
        of_block = np.abs(speed[np.isfinite(speed) & (speed != 0.0)])
        tool = self.promise.tools[int(self.operation[row])]
        told = None if tool is None else tool.spindle_speed
        return float(of_block[-1]) if len(of_block) else abs(told or 1.0)

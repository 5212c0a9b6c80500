"""The cut of set-points, judged: its engagement found anew at instants of the judge's own choice, and what was promised
of its loads held against a tool that is turned through in time.

Nothing of the stock's cells, of engagement or of forces of the accused is used: see `sections.py`, `turning.py`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.cut.sections import Poses, Section, Shape, Stock, Surface, shape_of
from toolpace.judge.cut.turning import Cutting, loads_of
from toolpace.judge.verification import Check
from toolpace.machine.cutting_tool import Coefficients
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

INSTANTS = 24
"""That are judged."""
CLOSE = 0.1e-3
"""Most between two poses of the swept tools [m]: a mill of 2 mm leaves ridges of a micrometre between them."""
SLICES = 16
"""Of the tool, up to where it can be in material."""
STEEP = 0.02
"""Share of a motion along the axis from which the flat end of a tool cuts, which is not judged."""
HELD = 0.01
"""Share of a limit by which a load may pass it: what the cells of the accused stock do to an engagement."""
LEARNED = 0.03
"""Share by which a load may pass that of its teacher: cells tell both to about a hundredth."""
SPEED = 1e-4
"""Share of a speed by which set-points may pass it, as all limits."""
STATIONS, IMMERSION = 12, 0.03
"""Stations of a file that are looked at, and the share of a turn by which their engagement may be off the judge's: at
an entry or an exit it changes by that from one set-point to the next, and cells tell edges to half of their size."""
THIN = 0.05
"""Share of a cell: what is cut thinner on the mean counts as air."""
PLACE = 1e-5
"""How far a station may be from the way of the tip [m]."""
NOT_JUDGED = "not judged: the stock is a mesh or a guess, or the tool bends"
UNITS = {
    "chip": "m", "feed_per_tooth": "m", "removal_rate": "m3/s", "force": "N", "torque": "N m", "power": "W",
    "moment": "N m", "stress": "Pa", "deflection": "m", "surface_deflection": "m", "compensated_deflection": "m",
    "feed_marks": "m",
}  # fmt: skip


@dataclass(frozen=True)
class CutPromise:
    """What a plan says of its cut, and what it is of."""

    feeds: str
    """air, learned or limits."""
    stock: Stock
    """The largest that there may be."""
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

    def limits_of(self, tool: str) -> dict[str, float]:
        """Those of a tool."""
        return {**self.limits.get("", {}), **self.limits.get(tool, {})}


@dataclass(frozen=True)
class Instant:
    """What the judge found at one time."""

    row: int
    """The set-point."""
    operation: int
    speed: float
    """Of the tip [m/s]."""
    section: Section
    loads: Mapping[str, float]


def round_stock(
    box: tuple[Floats, Floats] | None, cylinder: tuple[Floats, Floats, float] | None, uncertainty: float
) -> Stock:
    """A stock that is a box (least and most corner) or a cylinder (both ends, and its diameter) [m], larger by its
    uncertainty all round."""

    def within_box(place: Floats) -> Bools:
        assert box is not None
        off = np.maximum(np.maximum(box[0] - place, place - box[1]), 0.0)
        return np.asarray(np.linalg.norm(off, axis=1) <= uncertainty)

    def within_cylinder(place: Floats) -> Bools:
        assert cylinder is not None
        lower, upper, diameter = cylinder
        length = float(np.linalg.norm(upper - lower))
        along = (place - lower) @ ((upper - lower) / length)
        beside = np.sqrt(np.maximum(np.einsum("kc,kc->k", place - lower, place - lower) - along**2, 0.0))
        off = np.maximum(np.maximum(-along, along - length), 0.0), np.maximum(beside - 0.5 * diameter, 0.0)
        return np.asarray(np.hypot(*off) <= uncertainty)

    return within_box if box is not None else within_cylinder


class CutJudge:
    """Sees the cut of a motion at some instants."""

    def __init__(self, points: SetPoints, toolpath: ToolPath, promise: CutPromise) -> None:
        self.points, self.toolpath, self.promise = points, toolpath, promise
        shapes = [None if tool is None else shape_of(tool) for tool in promise.tools]
        self.shapes: tuple[Shape, ...] = tuple(shape for shape in shapes if shape is not None)
        self.shape_of_operation = np.cumsum([shape is not None for shape in shapes]) - 1
        self.shape_of_operation[[shape is None for shape in shapes]] = -1
        self.operation, self.rapid = self._of_blocks()
        self.poses, self.row = self._poses()
        self._found: dict[int, Instant | None] = {}

    @property
    def unseen(self) -> list[str]:
        """Tools at feed whose shape is not judged."""
        at_feed = np.unique(self.toolpath.operation[1:][~self.toolpath.rapid[1:]]).tolist()
        tools = [self.promise.tools[k] for k in at_feed if self.shape_of_operation[k] < 0]
        return sorted({each.kind for each in tools if each is not None})

    def _of_blocks(self) -> tuple[Ints, Bools]:
        """(n,) the operation of each set-point, and whether it is at rapid, by the line that it names."""
        path = self.toolpath
        lines = int(max(path.block.max(), self.points.block.max(initial=0))) + 1
        operation, rapid = np.zeros(lines, dtype=np.int64), np.zeros(lines, dtype=np.bool_)
        operation[path.block], rapid[path.block] = path.operation, path.rapid
        return operation[self.points.block], rapid[self.points.block]

    def _poses(self) -> tuple[Poses, Ints]:
        """Poses of the whole motion, at most CLOSE apart, and the set-point (n,) at or before each."""
        tip, axis, reach = self.points.tip, self.points.axis, max([each.reach for each in self.shapes], default=0.0)
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

    def instants(self, count: int = INSTANTS, seed: int = 0) -> list[Instant]:
        """What is found at so many instants at feed, one anywhere in each of as many equal parts of that time."""
        tip = self.points.tip
        inner = np.arange(1, len(tip) - 1)
        moves = np.linalg.norm(tip[2:] - tip[:-2], axis=1) > 1e-9
        same = (self.operation[2:] == self.operation[:-2]) & ~self.rapid[:-2] & ~self.rapid[2:]
        may = inner[moves & same & (self.shape_of_operation[self.operation[1:-1]] >= 0)]
        if not len(may):
            return []
        rng = np.random.default_rng(seed)
        at = may[((np.arange(count) + rng.random(count)) / count * len(may)).astype(np.int64)]
        found = (self.instant(int(row)) for row in np.unique(at))
        return [each for each in found if each is not None]

    def instant(self, row: int) -> Instant | None:
        """What is found at a set-point; None where the flat end of the tool cuts."""
        if row not in self._found:
            self._found[row] = self._instant(row, float(self.points.t[1] - self.points.t[0]))
        return self._found[row]

    def _instant(self, row: int, dt: float) -> Instant | None:
        points, operation = self.points, int(self.operation[row])
        tool = self.promise.tools[operation]
        assert tool is not None
        velocity = (points.tip[row + 1] - points.tip[row - 1]) / (2.0 * dt)
        axis = points.axis[row]
        turning = np.cross(axis, (points.axis[row + 1] - points.axis[row - 1]) / (2.0 * dt))
        speed = float(np.linalg.norm(velocity))
        shape = self.shapes[self.shape_of_operation[operation]]
        ends_flat = float(shape.radius(np.zeros(1))[0]) > 1e-6
        if ends_flat and float(velocity @ axis) < -STEEP * speed:
            return None
        # the pose itself, behind all before it
        k = int(np.searchsorted(self.row, row, side="left"))
        poses = Poses(
            np.concatenate([self.poses.tip[:k], points.tip[row : row + 1]]),
            np.concatenate([self.poses.axis[:k], points.axis[row : row + 1]]),
            np.append(self.poses.tool[:k], self.shape_of_operation[operation]),
        )
        surface = Surface(k, poses, self.shapes, self.promise.stock, velocity, turning)
        top = surface.top()
        if top == 0.0:
            return Instant(row, operation, speed, Section(np.zeros(0), 0.0, ()), {})
        section = surface.section((np.arange(SLICES) + 0.5) / SLICES * top)
        name = self.toolpath.operations[operation].tool
        coefficients = self.promise.coefficients.get(name, self.promise.coefficients.get(""))
        cutting = Cutting(tool, shape, coefficients, self._turns(row, tool))
        return Instant(row, operation, speed, section, loads_of(section, cutting, velocity, axis, turning))

    def tool_of(self, instant: Instant) -> str:
        """As the program calls it."""
        return self.toolpath.operations[instant.operation].tool

    def feed(self, instant: Instant) -> float:
        """The highest feed of the program in the block of an instant [m/s]."""
        path = self.toolpath
        own = path.most_speed[(path.block == self.points.block[instant.row]) & ~path.rapid]
        return float(own.max(initial=0.0))

    def _turns(self, row: int, tool: ToolFigures) -> float:
        """Of the spindle per second at a set-point [1/s]."""
        speed = self.toolpath.spindle[self.toolpath.block == self.points.block[row]]
        of_block = np.abs(speed[np.isfinite(speed) & (speed != 0.0)])
        return float(of_block[-1]) if len(of_block) else abs(tool.spindle_speed or 1.0)


def cut_checks(
    judge: CutJudge, file: Mapping[str, Floats | Ints], instants: int, stations: int
) -> list[Check]:
    """Whether what was promised of the cut is held at so many instants of the judge's choice, and whether speeds and
    engagement, at so many stations, in the `file` of a plan (cut_limits.npz) are those of its motion."""
    found = judge.instants(instants)
    checks = [engagement_check(judge, file, stations)]
    if judge.promise.feeds == "limits":
        checks += limit_checks(judge, found)
    if judge.promise.feeds == "air":
        checks.append(air_check(judge, found))
    if judge.promise.feeds == "learned":
        checks.append(learned_check(judge, found))
    return [*checks, speed_check(judge, found, file)]


def limit_checks(judge: CutJudge, found: Sequence[Instant]) -> list[Check]:
    """The worst instant of each limit, of all tools."""
    points = judge.points
    worst: dict[str, Check] = {}
    for each in found:
        for name, limit in judge.promise.limits_of(judge.tool_of(each)).items():
            value = float(each.loads.get(name, 0.0))
            time, block = float(points.t[each.row]), int(points.block[each.row])
            ok = bool(value <= limit * (1.0 + HELD))
            check = Check(f"{name.replace('_', ' ')} of the cut", value, limit, UNITS[name], ok, time, block)
            if name not in worst or check.ratio > worst[name].ratio:
                worst[name] = check
    return list(worst.values())


def speed_check(judge: CutJudge, found: Sequence[Instant], file: Mapping[str, Floats | Ints]) -> Check:
    """Whether the tip is anywhere faster than a file says that its cut allows."""
    points, worst = judge.points, Check("speed by the cut", 0.0, math.inf, "m/s", True)
    for each in found:
        time, block = float(points.t[each.row]), int(points.block[each.row])
        way = int(np.searchsorted(file["station time"], time))
        if not 0 < way < len(file["station time"]):
            continue
        most = float(file["station most"][max(way - 1, 0) : way + 2].max())
        check = Check("speed by the cut", each.speed, most, "m/s", each.speed <= most * (1.0 + SPEED), time, block)
        if check.ratio > worst.ratio:
            worst = check
    return worst


def air_check(judge: CutJudge, found: Sequence[Instant]) -> Check:
    """Whether nothing is cut where the tip is faster than the program's feed; a layer below THIN of a cell is
    nothing."""
    points, worst = judge.points, Check("cut above the feed", 0.0, THIN * judge.promise.resolution, "m", True)
    for each in found:
        if each.speed <= judge.feed(each) * (1.0 + SPEED) or not each.loads:
            continue
        high = max(len(each.section.height) * each.section.slice_height, judge.promise.resolution)
        layer = each.loads["removal_rate"] / (each.speed * high)
        time, block = float(points.t[each.row]), int(points.block[each.row])
        if layer > worst.value:
            ok = layer <= worst.limit
            worst = Check(worst.what, layer, worst.limit, "m", ok, time, block, note="layer on the mean")
    return worst


def learned_check(judge: CutJudge, found: Sequence[Instant]) -> Check:
    """Whether chip, area and edge are all within those of one teacher, wherever the tip is faster than the program's
    feed."""
    points, worst = judge.points, Check("load over its teacher's", 0.0, 1.0 + LEARNED, "", True)
    for each in found:
        if each.speed <= judge.feed(each) * (1.0 + SPEED) or not each.loads:
            continue
        own = np.array([each.loads[name] for name in ("chip", "area", "edge")])
        teachers = np.array(judge.promise.teachers.get(judge.tool_of(each), ())).reshape(-1, 3)
        share = float((own / teachers).max(axis=1).min(initial=math.inf))
        time, block = float(points.t[each.row]), int(points.block[each.row])
        if share > worst.value:
            worst = Check(worst.what, share, worst.limit, "", share <= worst.limit, time, block)
    return worst


def engagement_check(judge: CutJudge, file: Mapping[str, Floats | Ints], stations: int) -> Check:
    """Whether the engagement in a file is that of the motion: of some of its stations, the share of a turn in material,
    as a mean over the height."""
    name, count = "engagement of the cut", len(file["station time"])
    first = np.concatenate([[0], np.cumsum(file["engagement arcs"])]).astype(np.int64)
    rng = np.random.default_rng(count)
    worst = Check(name, 0.0, IMMERSION, "", True)
    for i in np.unique(rng.integers(0, count, stations)).tolist():
        time = float(file["station time"][i])
        row = int(np.clip(np.searchsorted(judge.points.t, time), 1, len(judge.points) - 2))
        way = float(np.linalg.norm(judge.points.tip[row + 1] - judge.points.tip[row - 1]))
        off = float(np.linalg.norm(judge.points.tip[row] - file["station tip"][i]))
        block = int(judge.points.block[row])
        if off > way + PLACE:
            return Check(name, off, way, "m", False, time, block, note="a station is not on the way of the tip")
        seen = judge.instant(row) if way > 0.0 else None
        if seen is None:
            continue
        arcs, high = slice(first[i], first[i + 1]), float(file["engagement slice_height"][i])
        angle = file["engagement exit"][arcs] - file["engagement entry"][arcs]
        said = np.bincount(file["engagement slice"][arcs], angle).astype(np.float64)
        share = immersion_off(said, high, seen.section) / (2.0 * math.pi)
        if share > worst.value:
            worst = Check(name, share, IMMERSION, "", share <= IMMERSION, time, block, note="share of a turn")
    return worst


def immersion_off(said: Floats, slice_height: float, section: Section) -> float:
    """By how much angles in material (k,), slice by slice from the tip on, are off those of a section, as a mean over
    the slices whose middle is certainly below or above its top [rad]."""
    top = len(section.height) * section.slice_height
    count = max(len(said), math.ceil(top / slice_height), 1)
    middle = (np.arange(count) + 0.5) * slice_height
    right = np.interp(middle, section.height, section.immersion, right=0.0) if top > 0.0 else np.zeros(count)
    clear = np.abs(middle - top) > 0.5 * slice_height + section.slice_height
    off = np.abs(np.pad(said, (0, count - len(said))) - right)
    return float(off[clear].mean()) if clear.any() else 0.0


def checks_of_cut(
    points: SetPoints, toolpath: ToolPath, promise: CutPromise | None, file: Mapping[str, Floats | Ints]
) -> list[Check]:
    """The checks of the cut of set-points along a tool path with the program's own feeds; see `cut_checks`."""
    if promise is None:
        return [Check("cut", math.nan, 0.0, "", True, note=NOT_JUDGED)]
    judge = CutJudge(points, toolpath, promise)
    checks = cut_checks(judge, file, INSTANTS, STATIONS)
    if unseen := judge.unseen:
        checks.append(Check("cut", math.nan, 0.0, "", True, note=f"not judged: {', '.join(unseen)}"))
    return checks

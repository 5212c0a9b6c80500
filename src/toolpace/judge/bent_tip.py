"""The bent tip at each set-point, from cutting forces and rotations of both chains joint by joint.

Which way of the program a set-point is on tells whether it cuts. It is found by matching the motion with the program:
at first within the tolerance and the most that the tool can bend at the feeds of the program, then again with the tip
that this bends, within an eighth of it.

The mean force is an integral over the angles of immersion, tooth by tooth and height by height; the peak is looked for
over a turn, with an integral along each edge.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.alignment import Lost, align
from toolpace.judge.rows import motion_row, way_begins
from toolpace.judge.seen_motion import ways
from toolpace.judge.verification import Check
from toolpace.machine.cutting_tool import Cut, CuttingTool
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

FINER = 8
"""By how much less the tool may be off once it is known how it bends."""
PARTS = 128
"""Cells over the length of a blend."""
STEEPEST = 0.05
"""Most bending over the length of its blend."""
SINES = math.sin(math.pi / 36.0), math.sin(math.pi / 12.0)
"""Of the angle of 5 degrees between motion and tool axis up to which nothing is cut, and of 15, from which all is."""
OVER = 1.05
"""By how much the speed may be above the feed of the program where the force of the largest feed is asked for."""
ANGLES, HEIGHTS = 240, 12
"""Places of the integral over the immersion, by Gauss and Legendre, and of that along an edge in the material."""
TURN = 900
"""Angles of a turn at which the peak is looked for."""
SLICE = 0.04
"""Lag of the helix over a slice [rad]."""
CHIPS = 25
"""Feeds per tooth at which the force is worked out; between them it is interpolated."""


@functools.cache
def gauss(count: int) -> tuple[Floats, Floats]:
    """Places and weights (count,) of the rule on [-1, 1]: worked out only where a tool bends, since it takes long."""
    places, weights = np.polynomial.legendre.leggauss(count)
    return places, weights


@dataclass(frozen=True)
class BentTool:
    """The tool in this program on this machine."""

    tool: CuttingTool
    machine: Machine
    toolpath: ToolPath

    def tips(
        self, points: SetPoints, tip: Floats, axis: Floats, line: Floats, owner: Ints, tolerances: Floats, dt: float
    ) -> Floats | Lost:
        """Bent tips (n, 3) [m] of set-points with `tip` and `axis`; Lost where they are not this program's.

        line, owner: the program, as `program_line` gives it in the narrowest of the `tolerances` (n, 2) [m], [rad] of
        its points.
        """
        units = tolerances.min(axis=0)
        cuts, of_way = self.cuts()
        tables = [] if self.tool.engaged is not None else [
            ForceTable(cut, self.tool.force, OVER * self.largest_chip(cut, of_way == k)) for k, cut in enumerate(cuts)
        ]
        give = float(np.linalg.norm(self.tool.compliance, ord=2))
        most = give * max((float(np.linalg.norm(table.forces, axis=1).max()) for table in tables), default=0.0)
        most = most if self.tool.engaged is None else self.most_engaged(of_way)
        along = self.ways_of(line[:, :3] * units[0], owner)
        bent = tip
        for slack in (most, most / FINER):
            wide = np.array([units[0] + slack, units[1]])
            scale = np.repeat(wide / units, 3)
            room = (tolerances[owner[1:]] - units) / wide
            motion = motion_row(points, np.hstack([bent, axis]) / np.repeat(wide, 3), self.machine.limits.largest, dt)
            found = align(motion.poses, np.ascontiguousarray(line / scale), 1.0 + 1e-3, motion.allowance, room)
            if isinstance(found, Lost):
                return found
            place = found.there.place[motion.row]
            middle = np.floor(0.5 * (place[:-1] + place[1:])).astype(np.int64)
            way = of_way[owner[np.minimum(middle + 1, len(owner) - 1)]]
            between = np.interp(0.5 * (place[:-1] + place[1:]), np.arange(len(along)), along)
            bent = tip + self.deflection(points, bent, axis, way, tables, between)
        return bent

    def cuts(self) -> tuple[list[Cut], Ints]:
        """The cuts that there are, and which of them acts on the way to each point (n,); -1 for none."""
        program, tool = self.toolpath, self.tool
        moved = np.sqrt(((program.tip - way_begins(program)) ** 2).sum(axis=1)) > 0.0
        fed = moved & ~program.rapid & (np.isfinite(program.feed) | (program.least_time > 0.0))
        cuts: list[Cut] = []
        of_way = np.full(len(program), -1, dtype=np.int64)
        for k, operation in enumerate(program.operations):
            cut = tool.operations.get(operation.name, tool.cut)
            if cut is None or (tool.only and operation.tool not in tool.only):
                continue
            of_way[fed & (program.operation == k)] = len(cuts)
            cuts.append(cut)
        return cuts, of_way

    def most_engaged(self, of_way: Ints) -> float:
        """The most that the tool can bend in its engagement at the feeds of the program [m]."""
        assert self.tool.engaged is not None
        most = self.largest_speed((of_way >= 0).astype(float)) * OVER
        slope, constant = self.tool.engaged.slope, self.tool.engaged.constant
        size = np.maximum(np.abs(constant), np.abs(most * slope + constant))
        return float(np.sqrt((size**2).sum(axis=1)).max())

    def ways_of(self, tips: Floats, owner: Ints) -> Floats:
        """(m,) way of the tip along the program up to places of it (m, 3) on the ways to the points `owner` [m]."""
        whole = np.cumsum(np.sqrt(((self.toolpath.tip - way_begins(self.toolpath)) ** 2).sum(axis=1)))
        found: Floats = whole[owner] - np.sqrt(((self.toolpath.tip[owner] - tips) ** 2).sum(axis=1))
        return np.maximum.accumulate(found)

    def largest_chip(self, cut: Cut, ways: Floats) -> float:
        """The largest feed per tooth that the program asks for on some ways (n,) [m]."""
        return self.largest_speed(ways) / (cut.cutter.teeth * cut.spindle_speed)

    def largest_speed(self, ways: Floats) -> float:
        """The largest speed that it asks for there [m/s]."""
        program = self.toolpath
        length = np.sqrt(((program.tip - way_begins(program)) ** 2).sum(axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = np.minimum(program.feed, np.where(program.least_time > 0.0, length / program.least_time, np.inf))
        speed = speed[ways.astype(bool) & np.isfinite(speed)]
        return float(speed.max(initial=0.0))

    def deflection(
        self, points: SetPoints, bent: Floats, axis: Floats, way: Ints, tables: list[ForceTable],
        between: Floats,
    ) -> Floats:  # fmt: skip
        """(n, 3) [m] at each set-point, where the steps (n - 1,) are of the cuts `way`, and so far along the
        program as `between` (n - 1,) [m]; blended."""
        step = ways(points.tool_length, bent, axis, 0, len(points) - 1)
        turn = tool_in_workpiece(self.machine, 0.5 * (points.q[:-1] + points.q[1:]))
        spindle = turn[:, :, 2]
        across = step - (step * spindle).sum(axis=1, keepdims=True) * spindle
        length = np.sqrt((across**2).sum(axis=1))
        whole_length = np.sqrt((step**2).sum(axis=1))
        sine = length / np.where(whole_length > 0.0, whole_length, 1.0)
        steps = np.diff(points.t)
        give = np.zeros_like(step)
        for k, table in enumerate(tables):
            on = np.flatnonzero((way == k) & (sine > SINES[0]))
            cutter = table.cut.cutter
            force = table.at(length[on] / steps[on] / (cutter.teeth * table.cut.spindle_speed))
            ahead = across[on] / length[on, None]
            force *= np.minimum((sine[on, None] - SINES[0]) / (SINES[1] - SINES[0]), 1.0)
            left = np.cross(spindle[on], ahead)
            whole = force[:, :1] * ahead + force[:, 1:2] * left + force[:, 2:] * spindle[on]
            in_tool = np.einsum("nba,nb->na", turn[on], whole) @ self.tool.compliance
            give[on] = np.einsum("nab,nb->na", turn[on], in_tool)
        if self.tool.engaged is not None:
            law, on = self.tool.engaged, np.flatnonzero((way >= 0) & (sine > SINES[0]))
            ahead = across[on] / length[on, None]
            axes = np.stack([ahead, np.cross(spindle[on], ahead), spindle[on]], axis=1)
            speed = whole_length[on] / steps[on]
            part = np.minimum((sine[on] - SINES[0]) / (SINES[1] - SINES[0]), 1.0)
            for k in range(3):
                size = np.interp(between[on], law.way, law.slope[:, k]) * speed
                size += np.interp(between[on], law.way, law.constant[:, k])
                give[on] += (part * size)[:, None] * axes[:, k]
        way_of_tip = np.concatenate(([0.0], np.cumsum(whole_length)))
        return blended(way_of_tip, give, self.tool.blend)

    def check(self, largest: float) -> Check:
        """Whether bending is small beside the length over which it builds up."""
        limit = STEEPEST * self.tool.blend
        note = "tip and program are compared with the tool bent by it"
        return Check("bending of the tool", largest, limit, "m", largest <= limit, note=note)


def blended(way: Floats, value: Floats, length: float) -> Floats:
    """(n, 3) at places (n,) the mean of a value (n - 1, 3) of the ways between them under a quadratic B-spline.

    It is worked out on a grid about each stretch of the way where there is any; elsewhere it is nothing.
    """
    found = np.zeros((len(way), value.shape[1]))
    some = np.flatnonzero((value != 0.0).any(axis=1) & (np.diff(way) > 0.0))
    if not len(some):
        return found
    apart = np.flatnonzero(way[some[1:]] > way[some[:-1] + 1] + 2.0 * length)
    first, last = some[np.concatenate(([0], apart + 1))], some[np.concatenate((apart, [len(some) - 1]))]
    whole = np.concatenate((np.zeros((1, value.shape[1])), np.cumsum(value * np.diff(way)[:, None], axis=0)))
    cell = length / PARTS
    weight = np.diff(_share_before(np.arange(-PARTS // 2, PARTS // 2 + 1) / PARTS))
    for a, b in zip(first, last):
        low, high = way[a] - length, way[b + 1] + length
        edges = low + cell * np.arange(int(np.ceil((high - low) / cell)) + 2)
        part = slice(np.searchsorted(way, low), np.searchsorted(way, high, side="right"))
        near = slice(max(a - 1, 0), b + 2)
        for c in range(value.shape[1]):
            mean = np.diff(np.interp(edges, way[near], whole[near, c])) / cell
            # an edge between two cells has as many of them on both sides
            at_edges = np.convolve(mean, weight)[PARTS // 2 - 1 :][: len(edges)]
            found[part, c] = np.interp(way[part], edges, at_edges)
    return found


def _share_before(x: Floats) -> Floats:
    """Share of a quadratic B-spline of length 1 about 0 that lies before x."""
    u = 3.0 * np.clip(x, -0.5, 0.5)
    outer = (1.5 - np.abs(u)) ** 3 / 6.0
    inner = 0.5 + 0.75 * u - u**3 / 3.0
    found: Floats = np.where(np.abs(u) <= 0.5, inner, np.where(u < 0.0, outer, 1.0 - outer))
    return found


def tool_in_workpiece(machine: Machine, q: Floats) -> Floats:
    """(n, 3, 3) columns x, y, z of the spindle housing as the part sees them, at joint positions (n, m).

    z is the tool axis; with all joints at zero x is the bed's x, as far as it is across.
    """
    chain = machine.file.chain
    part = _turned(machine, q, chain.workpiece) @ _columns(chain.workpiece_x, chain.workpiece_z)
    housing = _turned(machine, q, chain.tool) @ _housing(np.array(chain.tool_axis, dtype=float))
    found: Floats = np.swapaxes(part, 1, 2) @ housing
    return found


def _turned(machine: Machine, q: Floats, names: Sequence[str]) -> Floats:
    """(n, 3, 3) what the rotary joints of a chain turn, the one nearest the bed first."""
    turn = np.tile(np.eye(3), (len(q), 1, 1))
    for name in names:
        joint = machine.file.joints[name]
        if joint.kind != "rotary":
            continue
        u = np.array(joint.direction, dtype=float)
        u /= np.sqrt(u @ u)
        angle = q[:, machine.joints.index(name)]
        along = np.outer(u, u)
        beside = np.cross(u, np.eye(3)).T
        cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
        turn = turn @ (along + cosine * (np.eye(3) - along) + sine * beside)
    return turn


def _columns(x: Sequence[float], z: Sequence[float]) -> Floats:
    """(3, 3) columns of a frame given by its x and z, made square."""
    k = np.array(z, dtype=float) / np.linalg.norm(z)
    j = np.cross(k, np.array(x, dtype=float))
    j /= np.linalg.norm(j)
    return np.column_stack([np.cross(j, k), j, k])


def _housing(axis: Floats) -> Floats:
    """(3, 3) columns of the frame of the spindle housing in the bed, at zero."""
    k = axis / np.linalg.norm(axis)
    j = np.cross(k, [1.0, 0.0, 0.0])
    j = j / np.linalg.norm(j) if np.linalg.norm(j) > 1e-6 else np.array([0.0, 1.0, 0.0])
    return np.column_stack([np.cross(j, k), j, k])


@dataclass(frozen=True)
class ForceTable:
    """Forces along the feed, its normal and the tool axis [N], over feeds per tooth up to `most` [m]."""

    cut: Cut
    kind: str
    most: float
    chips: Floats = field(init=False)
    forces: Floats = field(init=False)

    def __post_init__(self) -> None:
        chips = max(self.most, 1e-9) * np.linspace(1e-7, 1.0, CHIPS)
        one = self.mean if self.kind == "mean" else self.peak
        object.__setattr__(self, "chips", chips)
        object.__setattr__(self, "forces", np.array([one(float(chip)) for chip in chips]))

    def at(self, chip: Floats) -> Floats:
        """(n, 3) forces at feeds per tooth (n,); none without a feed."""
        found = np.column_stack([np.interp(chip, self.chips, column) for column in self.forces.T])
        found[~(chip > 0.0)] = 0.0
        return found

    @property
    def angles(self) -> tuple[float, float]:
        """Between which the material is; from the normal on the left, over the front, to the right."""
        how = self.cut.engagement
        if how.milling == "slot":
            return 0.0, math.pi
        radius = 0.5 * self.cut.cutter.diameter
        wide = math.pi / 2 - math.asin((radius - how.radial_depth) / radius)
        return (0.0, wide) if how.milling == "up" else (math.pi - wide, math.pi)

    def mean(self, chip: float) -> Floats:
        """(3,) mean over a turn."""
        start, end = self.angles
        nodes, weights = gauss(ANGLES)
        phi = 0.5 * (end - start) * nodes + 0.5 * (end + start)
        share = 0.5 * (end - start) * weights / (2.0 * math.pi)
        # without runout all heights are alike
        count = math.floor(abs(self.lag(self.depth)) / SLICE) + 1 if self.cut.cutter.runout > 0.0 else 1
        z = self.depth * (np.arange(count) + 0.5) / count
        total = np.zeros(3)
        for tooth in range(self.cut.cutter.teeth):
            per_depth = self.edge(tooth, phi[:, None], z[None, :], chip).mean(axis=1)
            total += share @ per_depth
        return total * self.depth

    def peak(self, chip: float) -> Floats:
        """(3,) along the mean, as large as the force is at most across the tool."""
        total = np.zeros((TURN, 3))
        for tooth in range(self.cut.cutter.teeth):
            ahead = 2.0 * math.pi * (np.arange(TURN) / TURN + tooth / self.cut.cutter.teeth)
            # an edge may be in the material with its tip some turns ahead
            for turns in range(math.ceil(abs(self.lag(self.depth)) / (2.0 * math.pi)) + 1):
                sense = 1.0 if self.cut.cutter.helix >= 0.0 else -1.0
                total += self.along_edge(tooth, ahead % (2.0 * math.pi) + sense * 2.0 * math.pi * turns, chip)
        mean = self.mean(chip)
        largest = math.sqrt(float((total[:, :2] ** 2).sum(axis=1).max()))
        return mean * (largest / math.hypot(mean[0], mean[1]))

    def along_edge(self, tooth: int, phi: Floats, chip: float) -> Floats:
        """(n, 3) force of an edge whose tip is at angles phi (n,), summed up over what of it is in the material."""
        start, end = self.angles
        slope = self.lag(1.0)
        if slope == 0.0:
            low = np.zeros(len(phi))
            high = np.where((phi >= start) & (phi <= end), self.depth, 0.0)
        else:
            ends = np.sort([(phi - end) / slope, (phi - start) / slope], axis=0)
            low, high = np.clip(ends, 0.0, self.depth)
        nodes, weights = gauss(HEIGHTS)
        z = 0.5 * (high - low)[:, None] * nodes + 0.5 * (high + low)[:, None]
        force = self.edge(tooth, phi[:, None] - slope * z, z, chip)
        summed: Floats = np.einsum("nzc,z->nc", force, weights) * (0.5 * (high - low))[:, None]
        return summed

    @property
    def depth(self) -> float:
        """Of the cut along the axis [m]."""
        return self.cut.engagement.axial_depth

    def lag(self, z: float) -> float:
        """By how much an edge lags behind its tip at a height [rad]."""
        return 2.0 * math.tan(self.cut.cutter.helix) / self.cut.cutter.diameter * z

    def edge(self, tooth: int, phi: Floats, z: Floats, chip: float) -> Floats:
        """(..., 3) force per depth [N/m] of an edge at angles phi and heights z, in the material."""
        k = self.cut.coefficients
        thick = self.thickness(tooth, phi, z, chip)
        here = thick > 0.0
        forward = np.stack([np.cos(phi), -np.sin(phi)], axis=-1)
        outward = np.stack([np.sin(phi), np.cos(phi)], axis=-1)
        back = here * (k.tangential * thick + k.tangential_edge)
        inward = here * (k.radial * thick + k.radial_edge)
        down = here * (k.axial * thick + k.axial_edge)
        across = -back[..., None] * forward - inward[..., None] * outward
        if not self.cut.clockwise:
            across = across * np.array([1.0, -1.0])
        return np.concatenate([across, -down[..., None]], axis=-1)

    def thickness(self, tooth: int, phi: Floats, z: Floats, chip: float) -> Floats:
        """What is left of the chip by the teeth that passed before: by the one of them that reached furthest."""
        cutter = self.cut.cutter
        lag = self.lag(1.0) * z
        surfaces = []
        for before in range(1, cutter.teeth + 1):
            other = tooth + before
            surfaces.append(self.reach(other, lag) - before * chip * np.sin(phi))
        left: Floats = self.reach(tooth, lag) - np.max(np.broadcast_arrays(*surfaces), axis=0)
        return left

    def reach(self, tooth: int, lag: Floats) -> Floats:
        """By how much an edge is further out than without runout [m]."""
        cutter = self.cut.cutter
        where = 2.0 * math.pi * (tooth % cutter.teeth) / cutter.teeth - lag
        out: Floats = cutter.runout * np.cos(where - cutter.runout_angle)
        return out

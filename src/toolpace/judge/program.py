"""Checks of a motion's distance from its program, in order, and of the side on which its tip must be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.alignment import Alignment, BothWays, Lost, align
from toolpace.judge.bent_tip import BentTool
from toolpace.judge.feed_check import FeedUse, block_check, feed_use
from toolpace.judge.passage_times import Passages, Passing
from toolpace.judge.rows import MotionRow, Stretch, joined, motion_row, program_line
from toolpace.judge.seen_motion import SeenMotion
from toolpace.judge.tool import forward_kinematics
from toolpace.judge.verification import Check
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPointSource
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

GRACE = 1e-3
"""Share of a tolerance granted for the chords of arcs and rotations, on both sides, and for rounding."""


@dataclass(frozen=True)
class ProgramJudgement:
    """The checks, and the largest deviations of both directions."""

    checks: list[Check]
    tip_deviation: float
    axis_deviation: float
    feed_use: FeedUse | None = None
    """Of the tip; None where the program has no feeds, or the motion is not its."""
    passages: Passages | None = None
    """When it passes the points of the program; None where the motion is not its."""
    bending: float = 0.0
    """The most that the tool bends [m]."""


class JudgedProgram:
    """A program that motions are judged against, each block by its own tolerances."""

    def __init__(
        self, toolpath: ToolPath, machine: Machine, tip: Tolerances, axis: Tolerances, tool: CuttingTool | None
    ) -> None:
        """Take the tolerances of tip [m] and axis [rad], and the tool where it bends: it is then the bent tip that must
        be where the program says; feeds are those of the tip itself."""
        self.toolpath, self.machine = toolpath, machine
        along = np.stack((tip.tip_beside_chords(toolpath), axis.axis_along(toolpath)), axis=1)
        self.tolerances = ProgramTolerances(along)
        self.units = self.tolerances.least
        self.line, self.owner = program_line(toolpath, machine, *self.units.tolist())
        self.outward = tip.outward_along(toolpath)
        self.bent = BentTool(tool, machine, toolpath) if tool is not None else None

    def poses(self, tip: Floats, axis: Floats) -> Floats:
        """(n, 6) of tips and axes (n, 3), in the narrowest tolerances."""
        found: Floats = np.empty((len(tip), 6))
        np.divide(tip, self.units[0], out=found[:, :3])
        np.divide(axis, self.units[1], out=found[:, 3:])
        return found

    def judge(self, seen: SeenMotion, stretches: list[Stretch], points: SetPointSource) -> ProgramJudgement:
        """The verdict on a motion of which these are the rows; `points` are all of it where the tool bends."""
        dt, bending, lost = seen.peaks.dt, 0.0, None
        if self.bent is None:
            motion = joined(stretches, seen.t, self.poses(*forward_kinematics(seen.end, self.machine))[-1])
        else:
            every = points.rows(0, len(points))
            tip, axis = forward_kinematics(every, self.machine)
            where = self.bent.tips(every, tip, axis, self.line, self.owner, self.tolerances.along, dt)
            lost, there = (where, tip) if isinstance(where, Lost) else (None, where)
            motion = motion_row(every, self.poses(there, axis), self.machine.limits, dt)
            bending = float(np.sqrt(((there - tip) ** 2).sum(axis=1)).max())
        room = (1.0 + GRACE) * (self.tolerances.along[self.owner[1:]] / self.units - 1.0)
        found = lost or align(motion.poses, self.line, 1.0 + GRACE, motion.allowance, room)
        judge = _Judge(seen, self.toolpath, motion, self.owner, self.tolerances)
        if isinstance(found, Lost):
            return judge.lost(found)
        return self.matched(seen, motion, found, judge, bending)

    def matched(
        self, seen: SeenMotion, motion: MotionRow, found: BothWays, judge: _Judge, bending: float
    ) -> ProgramJudgement:
        """The verdict on a motion that goes with the program."""
        toolpath, owner, dt = self.toolpath, self.owner, seen.peaks.dt
        tip_unit, axis_unit = self.units
        checks = judge.nearness(found)
        if self.outward is not None:
            unit = float(tip_unit)
            checks.append(side_check(seen, motion, found.there, self.line, owner, self.outward, unit, GRACE * unit))
        passing = Passing(seen, toolpath, motion, found.back, np.flatnonzero(np.diff(owner, append=len(toolpath)) > 0))
        use = feed_use(seen, toolpath, motion, found.there, owner, self.tolerances.along)
        checks += [use.check(seen)] if use is not None else []
        checks += passing.least_times(dt) + passing.stops(self.machine, dt)
        checks += block_check(seen, toolpath, motion, found.there, owner)
        worst_tip = max(float(way.tip.max()) for way in (found.there, found.back)) * tip_unit
        worst_axis = max(float(way.axis.max()) for way in (found.there, found.back)) * axis_unit
        checks += [self.bent.check(bending)] if self.bent is not None else []
        return ProgramJudgement(checks, worst_tip, _angle(worst_axis), use, passing.passages(), bending)


@dataclass(frozen=True)
class ProgramTolerances:
    """How far a motion may be from its program."""

    along: Floats
    """(n, 2) of tip [m] and tool axis [rad] on the way to each point of the program."""

    @property
    def least(self) -> Floats:
        """(2,) the narrowest of tip and axis: all distances count in these."""
        least: Floats = self.along.min(axis=0)
        return least


@dataclass(frozen=True)
class _Judge:
    """What all comparisons with a program share."""

    seen: SeenMotion
    toolpath: ToolPath
    motion: MotionRow
    owner: Ints
    """Program point of each point of the line."""
    tolerances: ProgramTolerances

    def nearness(self, found: BothWays) -> list[Check]:
        """Both directions, tip and axis."""
        checks = []
        for way, matched in (("set-points to program", found.there), ("program to set-points", found.back)):
            own = self.own(matched, matched is found.there)
            for half, (part, off, unit) in enumerate((("tip", matched.tip, "m"), ("axis", matched.axis, "rad"))):
                least = float(self.tolerances.least[half])
                k = int(np.argmax(off / own[:, half]))
                row, point = self.place(matched, k, matched is found.there)
                value, tolerance = float(off[k]) * least, float(own[k, half])
                value = _angle(value) if part == "axis" else value
                granted = float(self.motion.allowance[row : row + 2].max()) * least
                ok = value <= tolerance * (1.0 + GRACE) + granted or not found.deviations
                time, block = float(self.motion.early[row]), int(self.toolpath.block[point])
                checks.append(Check(f"{part}, {way}", value, tolerance, unit, ok, time, block, noise=granted))
        if found.deviations and all(check.ok for check in checks):
            checks.append(self.out_of_order(found))
        return checks

    def own(self, matched: Alignment, there: bool) -> Floats:
        """(n, 2) the tolerances at the place of each pose of a row [m], [rad]; where two meet in a pose, the less."""
        along, last = self.tolerances.along, len(self.owner) - 1
        if there:
            found: Floats = along[self.owner[np.minimum(matched.place.astype(np.int64) + 1, last)]]
            # a place at a pose is on the way before it, too
            at_pose = matched.place == np.floor(matched.place)
            before = along[self.owner[np.clip(matched.place.astype(np.int64), 1, last)]]
            return np.where(at_pose[:, None], np.maximum(found, before), found)
        after = along[self.owner[np.minimum(np.arange(last + 1) + 1, last)]]
        return np.minimum(along[self.owner[np.maximum(np.arange(last + 1), 1)]], after)

    def place(self, matched: Alignment, k: int, there: bool) -> tuple[int, int]:
        """The pose of the motion and the program point that pose k of a row and its place belong to."""
        other = int(matched.place[k])
        if there:
            return k, int(self.owner[min(other + 1, len(self.owner) - 1)])
        return other, int(self.owner[k])

    def out_of_order(self, found: BothWays) -> Check:
        """Each place is near enough by itself, but not one after the other."""
        row, distance = max(found.deviations, key=lambda each: each[1])
        _, point = self.place(found.there, row, True)
        time, block = float(self.motion.early[row]), int(self.toolpath.block[point])
        least, limit = float(self.tolerances.least[0]), float(self.tolerances.along[point, 0])
        value = distance * least + limit - least
        return Check("tip, in order", value, limit, "m", False, time, block, note="or the axis, in proportion")

    def lost(self, lost: Lost) -> ProgramJudgement:
        """One check that fails: the motion is that of another program."""
        time = float(self.motion.early[lost.pose])
        least = self.tolerances.least
        tip, axis = (float(each) for each in lost.distance * least)
        note = "at least; the motion is not that of this program, and is not compared with it beyond this place"
        check = Check(
            "tip or axis, set-points to program", tip, float(least[0]), "m", False, time,
            int(self.seen.block[self.motion.first[lost.pose]]), note=note,
        )  # fmt: skip
        return ProgramJudgement([check], tip, _angle(axis))


def _angle(chord: float) -> float:
    """The angle between two unit vectors, from the length of the chord."""
    return 2.0 * math.asin(min(chord / 2.0, 1.0))


def side_check(
    seen: SeenMotion,
    motion: MotionRow,
    there: Alignment,
    line: Floats,
    owner: Ints,
    outward: Floats,
    unit: float,
    granted: float,
) -> Check:
    """How deep the tip gets below the planes through its places on the program, upright on the normals `outward` (n, 3)
    of the program's points.

    A pose of the motion may belong to several places within tolerance: that on which it is the furthest out counts.
    `line` (m, 6) is the program in tolerances of which the tip's is `unit` [m], with the point `owner` (m,) that each
    pose is or leads to; `granted` [m] is what may be below.
    """
    normals = along_line(outward, owner)
    pose = np.repeat(np.arange(len(there.place)), np.diff(there.begin))
    above = [_above(motion.poses, line, normals, np.arange(len(there.place)), there.place)]
    low, high = (_above(motion.poses, line, normals, pose, each[: len(pose)]) for each in (there.low, there.high))
    above.append(np.maximum.reduceat(np.maximum(low, high), there.begin[:-1]))
    depth = -unit * np.maximum(*above) - unit * motion.allowance
    k = int(np.argmax(depth))
    deepest = max(float(depth[k]), 0.0)
    block = int(seen.block[motion.first[k]])
    return Check(
        "tip, on the wrong side", deepest, granted, "m", deepest <= granted, float(motion.early[k]), block,
        noise=float(motion.allowance[k]) * unit,
    )  # fmt: skip


def along_line(outward: Floats, owner: Ints) -> Floats:
    """(m, 3) unit vectors at the poses of a program's line, from those at its points (n, 3)."""
    begins = np.flatnonzero(np.diff(owner, prepend=-1) > 0)
    count = np.diff(np.append(begins, len(owner)))
    share = (np.arange(len(owner)) - np.repeat(begins, count) + 1.0) / np.repeat(count, count)
    before = outward[np.maximum(owner - 1, 0)]
    return _unit(before + share[:, None] * (outward[owner] - before))


def _above(poses: Floats, line: Floats, normals: Floats, pose: Ints, place: Floats) -> Floats:
    """(k,) how far poses lie above places of the line, along the normals there [tolerances]."""
    here = np.clip(np.floor(place).astype(np.int64), 0, len(line) - 2)
    share = (place - here)[:, None]
    tip = line[here, :3] + share * (line[here + 1, :3] - line[here, :3])
    normal = _unit(normals[here] + share * (normals[here + 1] - normals[here]))
    return np.asarray(np.einsum("ka,ka->k", poses[pose, :3] - tip, normal))


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))

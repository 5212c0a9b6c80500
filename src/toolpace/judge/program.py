"""Checks of a motion's distance from its program, in order, and of the side on which its tip must be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.alignment import BothWays, Lost, align, room_at_poses
from toolpace.judge.alignment.sections import Section, Sections, Steps
from toolpace.judge.alignment.sweep import Line
from toolpace.judge.bent_tip import BentTool
from toolpace.judge.feed_check import FeedUse, WrongBlocks, untold_feeds
from toolpace.judge.passage_times import Passages, Passing, SectionPassages, joined_stays, waiting
from toolpace.judge.rows import MotionRow, joined, program_line, stretches_of
from toolpace.judge.seen_motion import SeenMotion
from toolpace.judge.tool import forward_kinematics, way_lengths
from toolpace.judge.verification import Check
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPointSource
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

GRACE = 1e-3
"""Share of a tolerance granted for the chords of arcs and rotations, on both sides, and for rounding."""
WITHIN = 1.0 + GRACE
"""What is near [tolerances]."""


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
        self.along = along
        """(p, 2) tolerances of tip [m] and axis [rad] on the way to each point."""
        self.units = along.min(axis=0)
        """(2,) the narrowest of them: all distances count in these."""
        line, self.owner = program_line(toolpath, machine, *self.units.tolist())
        room = WITHIN * (along[self.owner[1:]] / self.units - 1.0)
        self.line = Line(line, np.zeros(len(line)), room)
        outward = tip.outward_along(toolpath)
        self.normals = along_line(outward, self.owner) if outward is not None else None
        self.bent = BentTool(tool, machine, toolpath) if tool is not None else None
        self.last_poses = np.flatnonzero(np.diff(self.owner, append=len(toolpath)) > 0)
        """(p,) pose of the line that each point is."""
        self.waiting = waiting(toolpath)
        self.waiting_poses = self.last_poses[self.waiting]

    def poses(self, tip: Floats, axis: Floats) -> Floats:
        """(n, 6) of tips and axes (n, 3), in the narrowest tolerances."""
        found: Floats = np.empty((len(tip), 6))
        np.divide(tip, self.units[0], out=found[:, :3])
        np.divide(axis, self.units[1], out=found[:, 3:])
        return found

    def sections(self, steps: int) -> Sections:
        """What takes the sections of a motion of so many steps."""
        return Sections(self.line, WITHIN, steps)

    def judge(
        self, seen: SeenMotion, sections: Sections | None, points: SetPointSource, figures: bool = False
    ) -> ProgramJudgement:
        """The verdict on a motion, from its sections, or from `points`, all of it, where the tool bends; `figures`:
        with what those of a plan are judged by."""
        bending = 0.0
        if sections is not None and sections.follows:
            parts = sections.each(lambda section: self._part(section, seen, figures))
        else:
            if sections is None:
                steps, motion, found, bending = self._bent(points, seen.peaks.dt)
            else:
                steps, motion, found = sections.whole()
            if isinstance(found, Lost):
                return self._lost(found, motion, steps)
            parts = [self._part(Section(steps, motion, slice(0, len(self.line.poses)), found, True), seen, figures)]
        return self._judgement(parts, seen, bending)

    def _bent(self, source: SetPointSource, dt: float) -> tuple[Steps, MotionRow, BothWays | Lost, float]:
        """All of a motion whose tool bends, and the most that it does [m]."""
        assert self.bent is not None
        points = source.rows(0, len(source))
        tip, axis = forward_kinematics(points, self.machine)
        tips = self.bent.tips(points, tip, axis, self.line.poses, self.owner, self.along, dt)
        there = tip if isinstance(tips, Lost) else tips
        stretches = stretches_of(points, self.poses(there, axis), self.machine.limits.largest, dt)
        motion = joined(stretches, points.t, stretches[-1].poses[-1])
        found: BothWays | Lost
        if isinstance(tips, Lost):
            found = tips
        else:
            found = align(motion.poses, self.line.poses, WITHIN, motion.allowance, self.line.room)
        speed = way_lengths(points, tip, axis) / np.diff(points.t)
        steps = Steps(stretches[0], points.t, points.block.copy(), np.concatenate((speed[:1], speed, speed[-1:])))
        return steps, motion, found, float(np.sqrt(((there - tip) ** 2).sum(axis=1)).max())

    def _part(self, section: Section, seen: SeenMotion, figures: bool) -> _Part:
        """What is to be said of a section."""
        part, motion, there, toolpath = section.program, section.motion, section.found.there, self.toolpath
        owner, use, depth = self.owner[part], None, None
        if np.isfinite(toolpath.feed[1:]).any():
            assert seen.tool is not None
            use = FeedUse.of(section, toolpath, owner, seen.tool.farthest, figures)
        if self.normals is not None:
            depth = Depth.of(section, self.line.poses[part], self.normals[part], float(self.units[0]))
        waited = self.waiting_poses[(self.waiting_poses >= part.start) & (self.waiting_poses < part.stop)]
        deviations = [
            (far, float(motion.early[row]), int(owner[min(int(there.place[row]) + 1, len(owner) - 1)]))
            for row, far in section.found.deviations
        ]
        return _Part(
            part, Farthest.of(section, self.along, self.units, owner),
            NearestOfPoses.of(section, self.line.room[part.start : part.stop - 1]), deviations,
            SectionPassages.of(section, waited - part.start), use, WrongBlocks.of(section, toolpath, owner), depth,
        )  # fmt: skip

    def _judgement(self, parts: list[_Part], seen: SeenMotion, bending: float) -> ProgramJudgement:
        """The verdict on a motion that goes with the program."""
        toolpath, dt, poses = self.toolpath, seen.peaks.dt, len(self.line.poses)
        nearest = NearestOfPoses.of_all([(part.program, part.nearest) for part in parts], poses)
        if not np.isfinite(nearest.apart).all():
            raise AssertionError("two rows are near each other, but not the other way round")
        there = [max((part.farthest[half] for part in parts), key=lambda each: each.ratio) for half in (0, 1)]
        back = nearest.farthest(self.along, self.units, self.owner)
        checks = self._nearness(there, back, [each for part in parts for each in part.deviations])
        depths = [part.depth for part in parts if part.depth is not None]
        if depths:
            checks.append(max(depths, key=lambda each: each.depth).check(GRACE * float(self.units[0])))
        passing = self._passing(parts, seen)
        use, uses = None, [part.use for part in parts if part.use is not None]
        if uses:
            use = FeedUse.of_all(uses, untold_feeds(toolpath, self.along))
            checks.append(use.worst)
        checks += passing.least_times(dt) + passing.stops(self.machine, dt)
        checks.append(WrongBlocks.check([part.wrong for part in parts]))
        checks += [self.bent.check(bending)] if self.bent is not None else []
        worst = [max(*(part.farthest[half].most for part in parts), back[half].most) for half in (0, 1)]
        return ProgramJudgement(checks, worst[0], _angle(worst[1]), use, passing.passages(), bending)

    def _passing(self, parts: list[_Part], seen: SeenMotion) -> Passing:
        """When the points of the program are passed, from all sections."""
        early, late = np.full(len(self.line.poses), np.inf), np.full(len(self.line.poses), -np.inf)
        stays = {pose: np.empty((0, 2)) for pose in self.waiting_poses.tolist()}
        for part in parts:
            passages = part.passages
            np.minimum(early[part.program], passages.early, out=early[part.program])
            np.maximum(late[part.program], passages.late, out=late[part.program])
            for pose, more in passages.stays.items():
                stays[part.program.start + pose] = joined_stays(stays[part.program.start + pose], more)
        of_points = dict(zip(self.waiting.tolist(), stays.values()))
        return Passing(seen, self.toolpath, early[self.last_poses], late[self.last_poses], of_points)

    def _nearness(
        self, there: Sequence[Farthest], back: Sequence[Farthest], deviations: list[tuple[float, float, int]]
    ) -> list[Check]:
        """Both directions, tip and axis; `deviations` are distances [tolerances], times [s] and points at which the
        motion leaves the program."""
        checks = []
        for way, pair in (("set-points to program", there), ("program to set-points", back)):
            for part, unit, far in zip(("tip", "axis"), ("m", "rad"), pair):
                value = _angle(far.off) if part == "axis" else far.off
                ok = value <= far.tolerance * (1.0 + GRACE) + far.granted or not deviations
                block = int(self.toolpath.block[far.point])
                what = f"{part}, {way}"
                checks.append(Check(what, value, far.tolerance, unit, ok, far.time, block, noise=far.granted))
        if deviations and all(check.ok for check in checks):
            # each place is near enough by itself, but not one after the other
            distance, time, point = max(deviations, key=lambda each: each[0])
            least, limit = float(self.units[0]), float(self.along[point, 0])
            value, block = distance * least + limit - least, int(self.toolpath.block[point])
            note = "or the axis, in proportion"
            checks.append(Check("tip, in order", value, limit, "m", False, time, block, note=note))
        return checks

    def _lost(self, lost: Lost, motion: MotionRow, steps: Steps) -> ProgramJudgement:
        """One check that fails: the motion is that of another program."""
        tip, axis = (float(each) for each in lost.distance * self.units)
        note = "at least; the motion is not that of this program, and is not compared with it beyond this place"
        check = Check(
            "tip or axis, set-points to program", tip, float(self.units[0]), "m", False,
            float(motion.early[lost.pose]), int(steps.block[motion.first[lost.pose]]), note=note,
        )  # fmt: skip
        return ProgramJudgement([check], tip, _angle(axis))


class _Part(NamedTuple):
    """What is kept of a section."""

    program: slice
    farthest: tuple[Farthest, Farthest]
    nearest: NearestOfPoses
    deviations: list[tuple[float, float, int]]
    passages: SectionPassages
    use: FeedUse | None
    wrong: WrongBlocks
    depth: Depth | None


class Farthest(NamedTuple):
    """Where one of motion and program is the farthest from the other for its tolerance, in tip or axis."""

    off: float
    """[m], or the length of the chord of an angle."""
    tolerance: float
    """[m] or [rad]"""
    granted: float
    """For where the motion may be between set-points, likewise."""
    time: float
    """[s]"""
    point: int
    """Of the program."""
    most: float
    """The largest of all distances, whatever their tolerances, as `off`."""

    @property
    def ratio(self) -> float:
        """Distance over tolerance."""
        return self.off / self.tolerance

    @classmethod
    def of(cls, section: Section, along: Floats, units: Floats, owner: Ints) -> tuple[Farthest, Farthest]:
        """That of the poses of a section, in tip and axis, with tolerances `along` (p, 2) the points, in `units` (2,);
        poses of its part of the program belong to the points `owner` (m,)."""
        motion, there, last = section.motion, section.found.there, len(owner) - 1
        behind = owner[np.minimum(there.place.astype(np.int64) + 1, last)]
        # a place at a pose is on the way before it, too
        before = along[owner[np.clip(there.place.astype(np.int64), 1, last)]]
        at_pose = there.place == np.floor(there.place)
        own = np.where(at_pose[:, None], np.maximum(along[behind], before), along[behind])
        granted = np.maximum(motion.allowance, np.append(motion.allowance[1:], 0.0))
        return _farthest(section.own(len(own)), (there.tip, there.axis), own, units, granted, motion.early, behind)


class NearestOfPoses(NamedTuple):
    """Of each pose of the program, or of a part of it, the nearest place of the motion."""

    tip: Floats
    """(m,) distance of the tip [tolerances]."""
    axis: Floats
    """(m,) of the tool axis [tolerances]."""
    apart: Floats
    """(m,) the larger of both, over its radius: infinite of poses that the motion cannot be at."""
    granted: Floats
    """(m,) for where the motion may be between set-points [tolerances]."""
    time: Floats
    """(m,) when the motion is there [s]."""

    @classmethod
    def of(cls, section: Section, room: Floats) -> NearestOfPoses:
        """Those of a section, whose ways of the program have `room` (m - 1, 2) beyond the radius."""
        motion, back, wide = section.motion, section.found.back, 1.0 + room_at_poses(room)
        row = back.place.astype(np.int64)
        granted = np.maximum(motion.allowance, np.append(motion.allowance[1:], 0.0))
        apart = np.maximum(back.tip / wide[:, 0], back.axis / wide[:, 1])
        return cls(back.tip, back.axis, apart, granted[row], motion.early[row])

    @classmethod
    def of_all(cls, parts: list[tuple[slice, NearestOfPoses]], poses: int) -> NearestOfPoses:
        """Those of a whole program, from those of its parts."""
        whole = cls(*(np.full(poses, np.inf) for _ in cls._fields))
        for part, nearest in parts:
            nearer = nearest.apart <= whole.apart[part]
            for column, values in zip(whole, nearest):
                column[part][nearer] = values[nearer]
        return whole

    def farthest(self, along: Floats, units: Floats, owner: Ints) -> tuple[Farthest, Farthest]:
        """The farthest for its tolerance, in tip and axis; see `Farthest.of`."""
        pose = np.arange(len(owner))
        behind, before = owner[np.minimum(pose + 1, len(owner) - 1)], owner[np.maximum(pose, 1)]
        own = np.minimum(along[behind], along[before])
        return _farthest(len(owner), (self.tip, self.axis), own, units, self.granted, self.time, owner)


def _farthest(
    count: int, off: tuple[Floats, Floats], own: Floats, units: Floats, granted: Floats, time: Floats, point: Ints
) -> tuple[Farthest, Farthest]:
    """The farthest of the first poses, so many, in tip and axis: by distances, own tolerances, what is granted, times
    and points of each."""
    found = []
    for half, unit in enumerate(units.tolist()):
        k = int(np.argmax(off[half][:count] / own[:count, half]))
        found.append(
            Farthest(
                float(off[half][k]) * unit, float(own[k, half]), float(granted[k]) * unit, float(time[k]),
                int(point[k]), float(off[half].max()) * unit,
            )
        )  # fmt: skip
    return found[0], found[1]


def _angle(chord: float) -> float:
    """The angle between two unit vectors, from the length of the chord."""
    return 2.0 * math.asin(min(chord / 2.0, 1.0))


class Depth(NamedTuple):
    """Where the tip gets the deepest below the planes through its places on the program, upright on the program's
    normals."""

    depth: float
    """[m]"""
    granted: float
    """For where the motion may be between set-points [m]."""
    time: float
    """[s]"""
    block: int

    @classmethod
    def of(cls, section: Section, line: Floats, normals: Floats, unit: float) -> Depth:
        """That of a section.

        A pose of the motion may belong to several places within tolerance: that on which it is the furthest out counts.
        `line` (m, 6) is the section's part of the program in tolerances of which the tip's is `unit` [m], `normals`
        (m, 3) are its.
        """
        motion, there = section.motion, section.found.there
        pose = np.repeat(np.arange(len(there.place)), np.diff(there.begin))
        above = [_above(motion.poses, line, normals, np.arange(len(there.place)), there.place)]
        low, high = (_above(motion.poses, line, normals, pose, each[: len(pose)]) for each in (there.low, there.high))
        above.append(np.maximum.reduceat(np.maximum(low, high), there.begin[:-1]))
        depth = -unit * np.maximum(*above) - unit * motion.allowance
        k = int(np.argmax(depth[: section.own(len(depth))]))
        block = int(section.steps.block[motion.first[k]])
        return cls(float(depth[k]), float(motion.allowance[k]) * unit, float(motion.early[k]), block)

    def check(self, granted: float) -> Check:
        """The check, where the tip may be so far below [m]."""
        deepest = max(self.depth, 0.0)
        return Check(
            "tip, on the wrong side", deepest, granted, "m", deepest <= granted, self.time, self.block,
            noise=self.granted,
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

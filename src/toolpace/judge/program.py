"""The motion against the program: how near they are, in order, and all that follows from where each set-point is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.cuttingtool import CuttingTool
from toolpace.judge.alignment import Alignment, BothWays, Lost, align
from toolpace.judge.bending.bent import BentTool
from toolpace.judge.operations import Passages
from toolpace.judge.pace import FeedUse, block_check, feed_use
from toolpace.judge.passing import Passing
from toolpace.judge.rows import MotionRow, motion_row, program_line
from toolpace.judge.verification import Check
from toolpace.machine.machine import Machine
from toolpace.setpoints import SetPoints
from toolpace.toolpath import ToolPath

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


def program_checks(
    points: SetPoints,
    machine: Machine,
    toolpath: ToolPath,
    tip: Floats,
    axis: Floats,
    tip_tolerance: float,
    axis_tolerance: float,
    dt: float,
    tool: CuttingTool | None = None,
) -> ProgramJudgement:
    """Judge set-points, with their forward kinematics `tip` and `axis`, against the program.

    With a tool that bends, it is the bent tip that must be where the program says; feeds are those of the tip itself.
    """
    line, owner = program_line(toolpath, machine, tip_tolerance, axis_tolerance)
    bent = BentTool(tool, machine, toolpath) if tool is not None else None
    where: Floats | Lost = tip
    if bent is not None:
        where = bent.tips(points, tip, axis, line, owner, np.array([tip_tolerance, axis_tolerance]), dt)
    there = tip if isinstance(where, Lost) else where
    poses = np.hstack((there / tip_tolerance, axis / axis_tolerance))
    motion = motion_row(points, poses, machine.limits, dt)
    found = where if isinstance(where, Lost) else align(motion.poses, line, 1.0 + GRACE, motion.allowance)
    judge = _Judge(points, toolpath, motion, owner, tip_tolerance, axis_tolerance)
    if isinstance(found, Lost):
        return judge.lost(found)
    checks = judge.nearness(found)
    passing = Passing(points, toolpath, motion, found.back, np.flatnonzero(np.diff(owner, append=len(toolpath)) > 0))
    use = feed_use(points, toolpath, motion, found.there, owner, tip)
    checks += [use.check(points)] if use is not None else []
    checks += passing.least_times(dt) + passing.stops(machine, dt)
    checks += block_check(points, toolpath, motion, found.there, owner)
    worst_tip = max(float(way.tip.max()) for way in (found.there, found.back)) * tip_tolerance
    worst_axis = max(float(way.axis.max()) for way in (found.there, found.back)) * axis_tolerance
    bending = float(np.sqrt(((there - tip) ** 2).sum(axis=1)).max())
    checks += [bent.check(bending)] if bent is not None else []
    return ProgramJudgement(checks, worst_tip, _angle(worst_axis), use, passing.passages(), bending)


@dataclass(frozen=True)
class _Judge:
    """What all comparisons with a program share."""

    points: SetPoints
    toolpath: ToolPath
    motion: MotionRow
    owner: Ints
    """Program point of each point of the line."""
    tip_tolerance: float
    axis_tolerance: float

    def nearness(self, found: BothWays) -> list[Check]:
        """Both directions, tip and axis."""
        checks = []
        for way, matched in (("set-points to program", found.there), ("program to set-points", found.back)):
            for part, off, tolerance, unit in (
                ("tip", matched.tip, self.tip_tolerance, "m"),
                ("axis", matched.axis, self.axis_tolerance, "rad"),
            ):
                k = int(np.argmax(off))
                row, point = self.place(matched, k, matched is found.there)
                value = float(off[k]) * tolerance
                value = _angle(value) if part == "axis" else value
                granted = float(self.motion.allowance[row : row + 2].max()) * tolerance
                ok = value <= tolerance * (1.0 + GRACE) + granted or not found.deviations
                time, block = float(self.motion.early[row]), int(self.toolpath.block[point])
                checks.append(Check(f"{part}, {way}", value, tolerance, unit, ok, time, block, noise=granted))
        if found.deviations and all(check.ok for check in checks):
            checks.append(self.out_of_order(found))
        return checks

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
        value, limit = distance * self.tip_tolerance, self.tip_tolerance
        return Check("tip, in order", value, limit, "m", False, time, block, note="or the axis, in proportion")

    def lost(self, lost: Lost) -> ProgramJudgement:
        """One check that fails: the motion is that of another program."""
        time = float(self.motion.early[lost.pose])
        tip, axis = lost.distance * self.tip_tolerance, lost.distance * self.axis_tolerance
        note = "at least; the motion is not that of this program, and is not judged by it beyond this place"
        check = Check(
            "tip or axis, set-points to program", tip, self.tip_tolerance, "m", False, time,
            int(self.points.block[self.motion.first[lost.pose]]), note=note,
        )  # fmt: skip
        return ProgramJudgement([check], tip, _angle(axis))


def _angle(chord: float) -> float:
    """The angle between two unit vectors, from the length of the chord."""
    return 2.0 * math.asin(min(chord / 2.0, 1.0))

"""The command `verify`: a plan judged again, from the files in its folder."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import cast

import msgspec
import numpy as np

from toolpace.cli.console import Steps
from toolpace.cli.options import AS_WRITTEN, Reading
from toolpace.common.errors import UsageError, printable
from toolpace.common.files import changed, is_folder, reason
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.judge import Check, Verification, verify_plan
from toolpace.judge.figures import DEFAULT_AXIS_DEG, DEFAULT_TIP_MM, told_tolerances, with_table
from toolpace.machine.machine import Machine
from toolpace.motion.sampling import Sampling, each_block, grids
from toolpace.motion.set_point_files import read_set_points
from toolpace.motion.setpoints import Block, SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.motion.trajectory_file import TRAJECTORY, read_trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.follow_run import FollowRun
from toolpace.path.run import SplineRun
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.setup_file import setup_text
from toolpace.programs.speed_profile import ways_between
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath
from toolpace.results import write
from toolpace.results.write import NOTHING_STATED, PlanRecord, StatedPromise
from toolpace.results.write.result import copy_name

ROUNDED = 1e-12
"""Share by which the feed of a way may be off that a profile of speed limits, which is straight between two places."""
MOST_OFF = 1.0
"""Grids of rounding by which path and laws may be off the set-points: half of one, and what computers round by."""


def verify_folder(
    folder: Path, steps: Steps, reading: Reading = AS_WRITTEN, stated: StatedPromise = NOTHING_STATED
) -> tuple[PlanRecord, Verification]:
    """Judge the files in a folder by the machine and the program in it: set-points, figures, and the table if it is
    there. The program is read as it was for the plan, but for what `reading` says; stated: what is known of the promise
    of its cut. Raises UsageError where that is stated of a plan whose cut promises nothing."""
    if not is_folder(folder):
        raise UsageError(f"{folder}: no such folder; give the one that `toolpace plan` wrote")
    refuse_pipes(folder)
    record = write.read_plan(folder)
    program = program_in(folder, record)
    write.refuse_without_set_points(folder, "verified again (plan.json has the result of the first verification)")
    with steps.step("reading") as step:
        machine = Machine.load(folder / write.MACHINE)
        setpoints = read_set_points(folder, machine)
        options = read_as_planned(folder, record, reading)
        tool = write.bent_tool(folder, record.bending)
        toolpath = None
        if program is not None:
            toolpath = read_source(Source.load(program), machine, record.dialect, options, feed=record.feed)
        cut = write.read_cut(folder, record.cut_limits)
        if cut is None and stated != NOTHING_STATED:
            raise UsageError(
                f"{folder}: nothing is promised of its cut; leave out --limit, --max-deflection and --material"
            )
        profile = None if cut is None else write.profile_of(cut)
        programmed = toolpath
        if toolpath is not None and profile is not None:
            toolpath = toolpath.fed_by(profile)
        step.note = f"{len(setpoints)} set-points" + (f", {toolpath.blocks} blocks" if toolpath else "")
    tip: float | Tolerances = (record.tip_tolerance_mm or DEFAULT_TIP_MM) * MILLIMETRE
    axis: float | Tolerances = (record.axis_tolerance_deg or DEFAULT_AXIS_DEG) * DEGREE
    tip = tip if record.tip_tolerances is None else told_tolerances(record.tip_tolerances, tip=True)
    axis = axis if record.axis_tolerances is None else told_tolerances(record.axis_tolerances, tip=False)
    with steps.step("verifying"):
        figures = msgspec.to_builtins(record)
        record = msgspec.structs.replace(record, reading=write.reading_record(options))
        found = verify_plan(setpoints, machine, toolpath, figures, tip, axis, tool, setup_text(options.setup))
        table = folder / write.TABLE
        found = with_table(found, table, setpoints, machine) if table.exists() else found
        try:
            words = changed(folder)
        except OSError as error:
            raise UsageError(f"{folder}: cannot read: {reason(error)}") from None
        if found.checks[0].ok and (folder / TRAJECTORY).exists():
            own = trajectory_checks(folder, machine, setpoints, toolpath, bends=tool is not None)
            found = replace(found, checks=(*found.checks, *own))
        if cut is not None and record.cut_limits is not None and programmed is not None and found.checks[0].ok:
            with steps.step("verifying the cut"):
                from toolpace.judge.cut import Bent

                assert toolpath is not None
                tolerances = Tolerances.of(tip, "tip_tolerance"), Tolerances.of(axis, "axis_tolerance")
                own = write.judged_cut(
                    record.cut_limits, cut, setpoints, programmed, options.setup, machine,
                    bent=None if tool is None else Bent(tool, machine, toolpath, *tolerances), stated=stated,
                )  # fmt: skip
                # what the plan says of its verification counts its cut too
                alike = all(check.ok for check in own) or record.verified is not False
                others = tuple(check for check in found.checks if alike or check.what != "plan.json verified")
                found = replace(found, checks=(*others, *own))
        seal = Check("seal", 0.0, 0.0, "", not words, note=words or "files are as they were written")
        return record, replace(found, checks=(*found.checks, seal))


def trajectory_checks(
    folder: Path, machine: Machine, points: SetPoints, toolpath: ToolPath | None, *, bends: bool
) -> tuple[Check, ...]:
    """Whether path and speed laws of a plan come to its set-points: positions to a rounding, blocks, and the end; and
    whether its feeds and least times are those of the program."""
    path, laws = read_trajectory(folder / TRAJECTORY, machine)
    off, at = largest_difference(Trajectory(path, machine.limits, laws), points)
    time, block = float(points.t[at]), int(points.block[at])
    check = Check(TRAJECTORY, off, MOST_OFF, "", off <= MOST_OFF, time, block, note="grids off the set-points")
    if toolpath is None:
        return (check,)
    words, block = other_feed(path, toolpath, bends=bends)
    note = words or "those of the program"
    return check, Check(f"{TRAJECTORY} feeds", 0.0, 0.0, "", not words, block=block, note=note)


def largest_difference(trajectory: Trajectory, points: SetPoints) -> tuple[float, int]:
    """By how many grids of their rounding positions differ at most, and the set-point where they do so the most.

    Infinite where there are more or fewer of them, or where one names a block that is not run at it or beside it.
    """
    dt, count = float(points.t[1] - points.t[0]), len(points)
    sampling = Sampling(trajectory, dt, on_grid=True)
    if len(sampling) != count:
        return math.inf, min(len(sampling), count) - 1
    grid, found = grids(trajectory.limits, dt)[0], {}

    def compare(block: Block) -> None:
        begin, end, first = block.begin, block.end, block.first
        mine = slice(begin - first, end - first)
        off = (np.abs(block.near.q[mine] - points.q[begin:end]) / grid).max(axis=1)
        # two set-points are of the blocks beside them, too
        beside = np.pad(block.near.block, 1, mode="edge")[begin - first : end - first + 2]
        given = points.block[begin:end]
        off[(given != beside[:-2]) & (given != beside[1:-1]) & (given != beside[2:])] = math.inf
        worst = int(np.argmax(off))
        found[begin] = float(off[worst]), begin + worst

    each_block(sampling, (compare,))
    return max((found[begin] for begin in sorted(found)), key=lambda each: each[0])


def other_feed(path: AxisPath, toolpath: ToolPath, *, bends: bool) -> tuple[str, int]:
    """What is said where a path's blocks, feeds or least times are not those of the program, and the block; empty where
    they are.

    Of a tool that bends the path has blocks of its own, slower by what the tip is bent: none may be quicker. A profile
    of speed must be that of the program; the feed of a way that it limits need only be above it.
    """
    before, lines, profile = 0, toolpath.block[1:], toolpath.speed_profile
    limited = np.zeros(len(toolpath), dtype=np.bool_)
    if profile is not None:
        most = profile.most_of_ways(len(toolpath))
        limited = np.isfinite(most) & (toolpath.feed == most)
    for run in path.runs:
        spline = cast(SplineRun, cast(FollowRun, run).run)
        entry, block = spline.entry, spline.block
        known = np.isin(block, lines) & (len(entry) == len(block))
        if not known.all():
            return "a block that the program has not", int(block[np.argmin(known)])
        if bends:
            highest = {int(line): float(toolpath.feed[1:][lines == line].max()) for line in np.unique(block)}
            same = spline.feed <= np.array([highest[int(line)] for line in block])
        elif entry[0] <= before or (np.diff(entry) <= 0).any() or entry[-1] >= len(toolpath):
            return "its blocks lead to points out of their order", int(block[0])
        else:
            feed = toolpath.feed[entry]
            above = limited[entry] & (spline.feed >= feed * (1.0 - ROUNDED))
            same = (block == toolpath.block[entry]) & (above | (spline.feed == feed))
            same &= spline.least_time == toolpath.least_time[entry]
            before = int(entry[-1])
            wanted = None if profile is None else profile.along(ways_between(entry), spline.block_start)
            if spline.speed_profile != wanted:
                return "not the speeds that the cut of the program allows", int(block[0])
        if not same.all():
            return "not the block, feed and least time of the program", int(block[np.argmin(same)])
    return "", 0


def refuse_pipes(folder: Path) -> None:
    """Raise UsageError where a name in a folder is that of a pipe or a device: reading it might never end."""
    try:
        with os.scandir(folder) as entries:
            strange = sorted(each.name for each in entries if Path(each).exists() and not plain(each))
    except OSError as error:
        raise UsageError(f"{folder}: cannot read: {reason(error)}") from None
    if strange:
        raise UsageError(
            f"{printable(str(folder / strange[0]))}: is a pipe or a device, not a file; plan again, into a new folder"
        )


def plain(entry: os.DirEntry[str]) -> bool:
    """Whether it is a file or a folder, or leads to one."""
    return entry.is_file() or entry.is_dir()


def read_as_planned(folder: Path, record: PlanRecord, reading: Reading) -> ReadOptions:
    """How the program was read for a plan, but for what is asked for now."""
    then, now = write.read_again(folder, record.reading), reading.options(None)
    return replace(
        then,
        controller=now.controller if reading.controller is not None else then.controller,
        others=() if reading.controller is not None else then.others,
        setup=now.setup if reading.setup is not None else then.setup,
        skip_unknown=now.skip_unknown or then.skip_unknown,
        lenient=now.lenient or then.lenient,
        compensation=now.compensation or then.compensation,
        most_blocks=now.most_blocks if reading.max_blocks is not None else then.most_blocks,
        columns=now.columns or then.columns,
        units=now.units or then.units,
    )


def program_in(folder: Path, record: PlanRecord) -> Path | None:
    """The copy of the program in the folder of a plan; None where plan.json names none. Raises UsageError where it
    names a file elsewhere, or another than the copy."""
    name = record.program_file
    if not name:
        return None
    right = copy_name(Path(record.program))
    if name != right:
        raise UsageError(
            f"{folder / 'plan.json'}: program_file is {name!r}, where the copy of {record.program!r} is {right!r}; "
            "plan again to write it anew"
        )
    return folder / name

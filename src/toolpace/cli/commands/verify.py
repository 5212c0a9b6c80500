"""The command `verify`: a plan judged again, from the files in its folder."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from toolpace.cli.console import Steps
from toolpace.cli.options import AS_WRITTEN, Reading
from toolpace.common.errors import UsageError, printable
from toolpace.common.files import changed, is_folder, reason
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.judge import Check, Verification, verify_plan
from toolpace.judge.figures import DEFAULT_AXIS_DEG, DEFAULT_TIP_MM, told_tolerances
from toolpace.judge.table import with_table
from toolpace.machine.machine import Machine
from toolpace.motion.files.set_point_files import read_set_points
from toolpace.motion.files.trajectory_file import TRAJECTORY, read_trajectory
from toolpace.motion.sampling import grids
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.setup_file import setup_text
from toolpace.programs.tolerances import Tolerances
from toolpace.results import write
from toolpace.results.write import PlanRecord
from toolpace.results.write.result import copy_name

MOST_OFF = 1.0
"""Grids of rounding by which path and laws may be off the set-points: half of one, and what computers round by."""


def verify_folder(folder: Path, steps: Steps, reading: Reading = AS_WRITTEN) -> tuple[PlanRecord, Verification]:
    """Judge the files in a folder by the machine and the program in it: set-points, figures, and the table if it is
    there. The program is read as it was for the plan, but for what `reading` says."""
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
            found = replace(found, checks=(*found.checks, trajectory_check(folder, machine, setpoints)))
        seal = Check("seal", 0.0, 0.0, "", not words, note=words or "files are as they were written")
        return record, replace(found, checks=(*found.checks, seal))


def trajectory_check(folder: Path, machine: Machine, points: SetPoints) -> Check:
    """Whether path and speed laws of a plan come to its set-points: positions to a rounding, blocks, and the end."""
    path, laws = read_trajectory(folder / TRAJECTORY, machine)
    off, at = largest_difference(Trajectory(path, machine.limits, laws), points)
    time, block = float(points.t[at]), int(points.block[at])
    return Check(TRAJECTORY, off, MOST_OFF, "", off <= MOST_OFF, time, block, note="grids off the set-points")


def largest_difference(trajectory: Trajectory, points: SetPoints) -> tuple[float, int]:
    """By how many grids of their rounding positions differ at most, and the set-point where they do so the most.

    Infinite where there are more or fewer of them, or where one names a block that is not run at it or beside it.
    """
    dt = float(points.t[1] - points.t[0])
    sampled = trajectory.sample(dt, on_grid=True)
    if len(sampled) != len(points):
        return math.inf, min(len(sampled), len(points)) - 1
    off = np.zeros(len(points))
    for joint, grid in enumerate(grids(trajectory.limits, dt)[0]):
        np.maximum(off, np.abs(sampled.q[:, joint] - points.q[:, joint]) / grid, out=off)
    beside = np.concatenate([sampled.block[:1], sampled.block, sampled.block[-1:]])
    named = (points.block == beside[:-2]) | (points.block == beside[1:-1]) | (points.block == beside[2:])
    off[~named] = math.inf
    worst = int(np.argmax(off))
    return float(off[worst]), worst


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

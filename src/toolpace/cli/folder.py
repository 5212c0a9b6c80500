"""Commands that take or make a folder: verify, demo, study."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.cli import summary
from toolpace.cli.options import AS_WRITTEN, Reading
from toolpace.cli.steps import Steps
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.jobs import job

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.judge import Check, Verification
    from toolpace.machine.machine import Machine
    from toolpace.motion.setpoints import SetPoints
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.tolerances.tolerances import Tolerances
    from toolpace.results.write import PlanRecord


MOST_OFF = 1.0
"""Grids of rounding by which path and laws may be off the set-points: half of one, and what computers round by."""


def verify_folder(folder: Path, steps: Steps, reading: Reading = AS_WRITTEN) -> tuple[PlanRecord, Verification]:
    """Judge the files in a folder by the machine and the program in it: set-points, figures, and the table if it is
    there. The program is read as it was for the plan, but for what `reading` says."""
    import msgspec

    from toolpace.common.files import changed, is_folder, reason
    from toolpace.judge import Check, verify_plan
    from toolpace.judge.figures import DEFAULT_AXIS_DEG, DEFAULT_TIP_MM, told_tolerances
    from toolpace.judge.table import with_table
    from toolpace.machine.machine import Machine
    from toolpace.motion.set_point_files import read_set_points
    from toolpace.motion.trajectory_file import TRAJECTORY
    from toolpace.programs.reading import Source, read_source
    from toolpace.programs.reading.setup_file import setup_text
    from toolpace.results import write

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
        said = msgspec.to_builtins(record)
        record = msgspec.structs.replace(record, reading=write.reading_record(options))
        found = verify_plan(setpoints, machine, toolpath, said, tip, axis, tool, setup_text(options.setup))
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
    from toolpace.judge import Check
    from toolpace.motion.sampling_difference import largest_difference
    from toolpace.motion.trajectory import Trajectory
    from toolpace.motion.trajectory_file import TRAJECTORY, read_trajectory

    path, laws = read_trajectory(folder / TRAJECTORY, machine)
    off, at = largest_difference(Trajectory(path, machine.limits, laws), points)
    time, block = float(points.t[at]), int(points.block[at])
    return Check(TRAJECTORY, off, MOST_OFF, "", off <= MOST_OFF, time, block, note="grids off the set-points")


def refuse_pipes(folder: Path) -> None:
    """Raise UsageError where a name in a folder is that of a pipe or a device: reading it might never end."""
    from toolpace.common.files import reason

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
    from toolpace.results import write

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
    from toolpace.results.write.result import copy_name

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


def run_demo(out: Path, console: Console) -> int:
    """Write the demo's program, plan it, show the summary, name the report."""
    from toolpace.cli import demo_programs
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import Source
    from toolpace.results import write

    machine = Machine.load(demo_programs.MACHINE)
    steps = Steps(console)
    job.warm_up(steps)
    with steps.step("generating") as step:
        source = Source.from_bytes(demo_programs.impeller_program(machine).encode("ascii"), "impeller.ngc")
        step.note = "the program of an impeller, seven blades"
    task = job.Job(Path(source.name), machine, out, 0.01 * MILLIMETRE, 0.05 * DEGREE, source=source)
    record, verification = job.carry_out(task, steps)
    summary.show_plan(console, record, verification)
    summary.show_files(console, out, job.written(task, record), record)
    report = (out / write.REPORT).resolve()
    console.print(f"\nOpen the report in a browser:\n{printable(str(report))}", soft_wrap=True)
    return job.exit_code(record, verification)


def run_study(out: Path, console: Console) -> int:
    """The paper's simulation study."""
    from toolpace import study

    steps = Steps(console)
    job.warm_up(steps)
    with steps.step("studying") as step:
        study.write_study(out, step)
    console.print(f"Open the study in a browser:\n{printable(str((out / 'study.html').resolve()))}", soft_wrap=True)
    return 0

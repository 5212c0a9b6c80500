"""Commands that take or make a folder: verify, demo, study."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.cli import job, summary
from toolpace.cli.steps import Steps
from toolpace.errors import UsageError, printable
from toolpace.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.judge import Verification


def verify_folder(folder: Path, steps: Steps) -> Verification:
    """Judge the set-points in a folder against the machine and the program in it."""
    from toolpace import write
    from toolpace.judge import verify
    from toolpace.machine.machine import Machine
    from toolpace.reading import read
    from toolpace.setpoints import SetPoints

    if not os.path.isdir(folder):  # noqa: PTH112 (that of Path raises where the name is too long)
        raise UsageError(f"{folder}: no such folder; give the one that `toolpace plan` wrote")
    record = write.read_plan(folder)
    with steps.step("reading") as step:
        machine = Machine.load(folder / write.MACHINE)
        setpoints = SetPoints.load(folder / write.SET_POINTS)
        toolpath = None
        if record.program_file:
            toolpath = read(folder / record.program_file, machine, record.dialect, feed=record.feed)
        step.note = f"{len(setpoints)} set-points" + (f", {toolpath.blocks} blocks" if toolpath else "")
    allowed = {}
    if record.tip_tolerance_mm is not None:
        allowed["tip_tolerance"] = record.tip_tolerance_mm * MILLIMETRE
    if record.axis_tolerance_deg is not None:
        allowed["axis_tolerance"] = record.axis_tolerance_deg * DEGREE
    with steps.step("verifying"):
        return verify(setpoints, machine, toolpath, dt=record.dt_s, **allowed)


def run_demo(out: Path, console: Console) -> int:
    """Write the demo's program, plan it, show the summary, name the report."""
    from toolpace import demo, write
    from toolpace.machine.machine import Machine
    from toolpace.reading import Source

    machine = Machine.load(demo.MACHINE)
    steps = Steps(console)
    job.warm_up(steps)
    with steps.step("generating") as step:
        source = Source.from_bytes(demo.impeller_program(machine).encode("ascii"), "impeller.ngc")
        step.note = "the program of an impeller, seven blades"
    task = job.Job(Path(source.name), machine, out, 0.01 * MILLIMETRE, 0.05 * DEGREE, source=source)
    record, verification = job.carry_out(task, steps)
    summary.show_plan(console, record, verification)
    summary.show_files(console, out, job.written(task))
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

"""What a plan leaves on disk: one folder, whole or not at all, from which it can be judged again."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toolpace.errors import UsageError
from toolpace.files import reason, whole_folder
from toolpace.setpoints import SetPoints
from toolpace.write.csv import write_csv
from toolpace.write.plan_json import PLAN, PlanRecord, plan_record, read_plan, write_plan

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.toolpath import ToolPath
    from toolpace.trajectory import Trajectory

__all__ = ["PlanRecord", "plan_record", "read_plan", "write_all", "write_csv", "write_plan"]

SET_POINTS = "setpoints.npz"
TABLE = "setpoints.csv"
MACHINE = "machine.toml"
REPORT = "report.html"


def write_all(
    directory: str | os.PathLike[str],
    trajectory: Trajectory,
    path: Any,
    toolpath: ToolPath | None,
    machine: Machine,
    setpoints: SetPoints,
    program_path: str | os.PathLike[str] | None = None,
    csv: bool = False,
    report: bool = True,
    progress: Callable[[str, float], None] | None = None,
    *,
    verification: Verification | None = None,
    feed: str | None = None,
    tip_tolerance: float | None = None,
    axis_tolerance: float | None = None,
    dialect: str | None = None,
    step_s: dict[str, float] | None = None,
) -> PlanRecord:
    """Write plan.json, setpoints.npz, machine.toml, a copy of the program (program.<ext>) and, as asked,
    setpoints.csv and report.html; return what plan.json says.

    `path` is the Path (its deviations and fitting time are read), or None. `feed`, `tip_tolerance` [m] and
    `axis_tolerance` [rad] are what the plan was made with, and `dialect` what the program was read as, so that it
    can be judged by the files alone; `step_s` are the times of the steps so far.
    `progress(what, share done)` is called as files are written. Everything is written to a temporary folder
    beside `directory` first; where anything fails (UsageError), nothing is left behind.
    """
    tell = progress or (lambda what, share: None)
    program = Path(program_path) if program_path is not None else None
    copied = f"program{program.suffix}" if program is not None else ""
    record = plan_record(
        trajectory,
        path,
        toolpath,
        machine,
        setpoints,
        verification,
        program=program.name if program is not None else "",
        program_file=copied,
        feed=feed,
        tip_tolerance=tip_tolerance,
        axis_tolerance=axis_tolerance,
        dialect=dialect,
        step_s=step_s,
    )
    with whole_folder(directory) as folder:
        tell("set-points", 0.0)
        setpoints.save(folder / SET_POINTS)
        (folder / MACHINE).write_text(machine.to_toml(), encoding="utf-8")
        if program is not None:
            try:
                shutil.copyfile(program, folder / copied)
            except OSError as error:
                raise UsageError(f"{program}: cannot read: {reason(error)}") from None
        if csv:
            tell("table", 0.1)
            write_csv(folder / TABLE, setpoints, machine)
        if report:
            tell("report", 0.4)
            from toolpace.reporting import write_report

            write_report(folder / REPORT, trajectory, setpoints, toolpath, verification, record.facts())
        write_plan(folder / PLAN, record)
        tell("done", 1.0)
    return record

"""The folder of a plan, written completely or not at all; and its table of set-points, setpoints.csv."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from toolpace.common.errors import UsageError
from toolpace.common.files import reason, sealed_files, whole_file, whole_folder
from toolpace.machine.machine import Machine
from toolpace.motion.sampling import each_block
from toolpace.motion.set_point_files import (
    COMPACT_FILE,
    FULL_FILE,
    MACHINE,
    CompactWriter,
    file_of,
    form_of,
    set_points_file,
)
from toolpace.motion.setpoints import SetPointSource, in_memory
from toolpace.motion.trajectory import Trajectory
from toolpace.motion.trajectory_file import TRAJECTORY, is_writable, write_trajectory
from toolpace.programs.toolpath import ToolPath
from toolpace.results.write.cut_limits import (
    CUT_LIMITS,
    cut_arrays,
    cut_part,
    profile_of,
    read_cut,
    write_cut,
)
from toolpace.results.write.cut_promise import NOTHING_STATED, StatedPromise, judged_cut
from toolpace.results.write.plan_json import PLAN, PlanRecord, read_plan, write_plan
from toolpace.results.write.result import (
    CONTROLLER,
    ENGAGED,
    SETUP,
    TOOL,
    PlanResult,
    SetPointDigest,
    bent_tool,
    copy_name,
    read_again,
    reading_record,
    write_engaged,
    write_reading_options,
)

__all__ = [
    "CONTROLLER", "MACHINE", "NOTHING_STATED", "PLAN", "REPORT", "SETUP", "TABLE", "TOOL", "TRAJECTORY", "WRITING",
    "PlanRecord", "PlanResult", "SetPointDigest", "StatedPromise", "bent_tool", "cut_arrays", "cut_part", "digest_of",
    "judged_cut", "profile_of", "read_again", "read_cut", "read_plan", "reading_record", "refuse_without_set_points",
    "write_csv", "write_folder",
]  # fmt: skip

TABLE = "setpoints.csv"
REPORT = "report.html"
"""Names of the files beside plan.json."""
WRITING = "writing"
"""The step under which plan.json tells the time that the other files took."""
CHUNK = 20_000
"""Rows that are turned into text in one piece, to keep memory low."""
_KINDS = (("", "q", ""), (" velocity", "qd", "/s"), (" acceleration", "qdd", "/s2"), (" jerk", "qddd", "/s3"))
"""What a column holds, the field of SetPoints, and what its unit is divided by."""


def columns(setpoints: SetPointSource, machine: Machine | None) -> tuple[list[str], list[float]]:
    """Names with units, and the factors from SI, of all columns but the last (block)."""
    rotary = machine.is_rotary if machine is not None else [None] * len(setpoints.joints)
    units = [("", 1.0) if r is None else ("deg", 180.0 / math.pi) if r else ("mm", 1e3) for r in rotary]
    names, factors = ["t [s]"], [1.0]
    for kind, _, per in _KINDS:
        for joint, (unit, factor) in zip(setpoints.joints, units):
            shown = f"{unit}{per}" if unit else f"1{per}" if per else "1"
            names.append(f"{joint}{kind} [{shown}]")
            factors.append(factor)
    if setpoints.has_tool:
        names += [f"tip {c} [mm]" for c in "xyz"] + [f"axis {c} [1]" for c in "ijk"]
        factors += [1e3] * 3 + [1.0] * 3
    return names, factors


def write_csv(path: str | os.PathLike[str], setpoints: SetPointSource, machine: Machine | None = None) -> None:
    """Write the table, whole or not at all: time, positions, velocities, accelerations, jerks, tip, axis,
    block.

    Fifteen digits: a jerk found by differences of positions at 1 ms needs them.
    """
    names, factors = columns(setpoints, machine)
    form = "%.15g," * len(names) + "%d\n"
    scale = np.array(factors)
    with whole_file(path) as temporary, temporary.open("w", encoding="ascii", newline="") as stream:
        stream.write(",".join([*names, "block"]) + "\n")
        for start in range(0, len(setpoints), CHUNK):
            points = setpoints.rows(start, min(start + CHUNK, len(setpoints)))
            parts = [points.t[:, None], points.q, points.qd, points.qdd, points.qddd]
            parts += [points.tip, points.axis] if points.has_tool else []
            # Zero has no sign.
            values = np.hstack(parts) * scale + 0.0
            # Block numbers are exact in double precision, so that one format serves the whole row.
            table = np.column_stack((values, points.block))
            stream.write((form * len(table)) % tuple(table.ravel().tolist()))


def write_folder(
    directory: str | os.PathLike[str],
    result: PlanResult,
    *,
    csv: bool = False,
    report: bool = True,
    npz: str = "auto",
    progress: Callable[[float], None] | None = None,
) -> PlanRecord:
    """Write machine.toml, a copy of the program (program.<ext>), controller.toml and setup.toml where it was read with
    them, tool.toml where its bending is compensated, as asked set-points, setpoints.csv and report.html, and last
    plan.json; return what plan.json says.

    `npz` is "full" for setpoints.npz, "compact" for setpoints.compact, "auto" for the one of them that suits their
    number, or "no". With set-points comes trajectory.compact, path and speed laws, where it is a planned program.

    `progress` is called with the share done. Everything is written to a temporary folder beside `directory`, which
    takes its place in one step. What is there already is replaced only where toolpace wrote all of it; where it is
    not, or anything fails (UsageError), all is as it was.
    """
    tell = progress or (lambda share: None)
    began = time.perf_counter()
    digest = result.digest
    if digest is None:
        digest = digest_of(result.machine, result.trajectory, result.setpoints, result.toolpath, report=report, npz=npz)
        each_block(result.setpoints, (digest.take,))
        result = replace(result, digest=digest)
    record = result.record()
    with whole_folder(directory, seal=PLAN) as folder:
        tell(0.0)
        (folder / MACHINE).write_text(result.machine.to_toml(), encoding="utf-8")
        form = form_of(npz, len(result.setpoints), len(result.machine.joints))
        if digest.packed is not None:
            digest.packed.write(folder / COMPACT_FILE)
        elif form == "full":
            in_memory(result.setpoints).save(folder / FULL_FILE)
        if form != "no" and is_writable(result.trajectory.axis_path, result.trajectory.laws):
            write_trajectory(folder / TRAJECTORY, result.trajectory.axis_path, result.trajectory.laws)
        if result.program is not None:
            copy_program(result, folder / result.program_copy)
        write_reading_options(folder, result.options)
        if result.aimed is not None:
            (folder / TOOL).write_bytes(result.aimed.tool.data)
            if result.aimed.tool.engaged is not None:
                write_engaged(folder / ENGAGED, result.aimed.tool.engaged)
        if result.cut_limits is not None:
            write_cut(folder / CUT_LIMITS, result.cut_limits[1])
        if csv:
            tell(0.1)
            write_csv(folder / TABLE, result.setpoints, result.machine)
        if report:
            tell(0.4)
            from toolpace.results.report import write_report

            write_report(
                folder / REPORT, result.trajectory, result.setpoints, result.toolpath, result.verification, record,
                digest.curves, result.program_bytes, result.options.setup, result.cut,
            )  # fmt: skip
        steps = {**record.step_s, WRITING: time.perf_counter() - began}
        record = msgspec.structs.replace(record, step_s=steps)
        write_plan(folder / PLAN, record)
        tell(1.0)
    return record


def digest_of(
    machine: Machine,
    trajectory: Trajectory,
    source: SetPointSource,
    toolpath: ToolPath | None,
    *,
    report: bool,
    npz: str,
) -> SetPointDigest:
    """What will take the set-points of a plan for its folder; see `write_folder`."""
    curves = packed = None
    if report:
        from toolpace.results.report.charts import Curves
        from toolpace.results.report.page import units_of

        curves = Curves(source, trajectory.limits, units_of(trajectory.axis_path.machine, source.joints), toolpath)
    if form_of(npz, len(source), len(machine.joints)) == "compact":
        # who reads them has the machine of the file, whose figures were rounded to decimals
        packed = CompactWriter(source, Machine.from_toml(machine.to_toml()))
    return SetPointDigest(packed, curves)


def copy_program(result: PlanResult, copy: Path) -> None:
    """Put the program beside its plan, as it was read. Raises UsageError where it was not, and cannot be now."""
    data = result.program_bytes
    if data is None:
        assert result.program is not None
        try:
            data = result.program.read_bytes()
        except OSError as error:
            raise UsageError(f"{result.program}: cannot read: {reason(error)}") from None
    copy.write_bytes(data)


def refuse_without_set_points(folder: Path, what: str) -> None:
    """Raise UsageError where the folder of a plan has no set-points: nothing can then be `what`."""
    if set_points_file(folder):
        return
    sealed = sealed_files(folder)
    gone = next((name for name in (FULL_FILE, COMPACT_FILE) if name in sealed), "")
    why = "was taken out of it" if gone else "was not written (--npz no)" if sealed else "is not there"
    raise UsageError(
        f"{folder}: {gone or FULL_FILE} {why}, and without set-points nothing can be {what}; "
        "plan again without --npz no"
    )


def written_files(
    program: Path, record: PlanRecord, *, csv: bool, report: bool, npz: str = "auto", trajectory: bool = True
) -> list[str]:
    """Names of the files of a plan, the one to look at last; `trajectory` tells whether path and laws are there."""
    points = file_of(form_of(npz, record.set_points, len(record.usage.velocity)))
    motion = [points, *[TRAJECTORY] * trajectory] if points else []
    how = [name for name in (record.reading.controller_file, record.reading.setup_file) if name]
    bending = record.bending
    how += [name for name in (bending.tool_file, bending.engaged_file) if name] if bending is not None else []
    how += [record.cut_limits.file] if record.cut_limits is not None else []
    return [PLAN, *motion, MACHINE, copy_name(program), *how] + [TABLE] * csv + [REPORT] * report

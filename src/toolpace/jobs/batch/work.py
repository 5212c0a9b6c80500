"""The work on one job: its folder of results and its row."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from toolpace.common.errors import ToolpaceError, UsageError, printable
from toolpace.common.files import changed, whole_folder
from toolpace.jobs import TimedSteps
from toolpace.jobs.batch.job import ERROR, BatchRow, Prepared, waiting
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.results.write import PLAN, PlanRecord, read_plan

MARK = ".toolpace-batch"
"""A file in the folder of a batch that says which batch it is; locked while one writes there."""
TIMED, INSPECTED = "time.json", "inspect.json"
"""Main files of the folders of jobs that plan nothing."""
DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.EACCES, errno.EPERM)
"""What the system says where a disk takes no more: another worker's may."""


@dataclass(frozen=True)
class Place:
    """The folder of a batch, as a worker must find it."""

    folder: str
    """From the root."""
    token: str
    """What its mark says."""

    def found(self) -> Path:
        """The folder. Raises UsageError where this computer has none there, or another one."""
        try:
            figures = (Path(self.folder) / MARK).read_text(encoding="ascii")
        except (OSError, ValueError):
            figures = ""
        if figures != self.token:
            import socket

            raise UsageError(
                f"computer {socket.gethostname()} does not have the folder {self.folder} of this batch; give --out a "
                "folder on a disk that all workers share"
            )
        return Path(self.folder)


def do_job(place: Place, prepared: Prepared, steps: TimedSteps | None = None) -> BatchRow:
    """Carry out one job, and tell its `steps`; a row in any case."""
    try:
        folder = place.found()
        # A batch that was killed may have left its jobs with the cluster: they end, and are found.
        return done_before(folder, prepared) or _DOERS[prepared.job.what](folder, prepared, steps or TimedSteps())
    except ToolpaceError as error:
        return failed(prepared, error)


def failed(prepared: Prepared, error: ToolpaceError) -> BatchRow:
    """The row of a job that came to nothing."""
    # `from None` hides what was behind an error from people, and keeps it.
    disk = isinstance(error.__context__, OSError) and error.__context__.errno in DISK
    message = str(error).replace(printable(prepared.path), printable(str(prepared.job.program)))
    return msgspec.structs.replace(
        waiting(prepared.job), verdict=ERROR, error=" ".join(message.split()), key=prepared.key, elsewhere=disk
    )


def done_before(folder: Path, prepared: Prepared) -> BatchRow | None:
    """The row of a job whose folder is there, as toolpace wrote it; None where it must be done."""
    try:
        row = _READERS[prepared.job.what](folder, prepared)
    except (ToolpaceError, OSError):
        return None
    return msgspec.structs.replace(row, found=True)


def _plan(folder: Path, prepared: Prepared, steps: TimedSteps) -> BatchRow:
    from toolpace.jobs import plan_steps
    from toolpace.jobs.job import Job

    job = prepared.job
    tip, axis = job.tolerances()
    task = Job(
        program=Path(prepared.path),
        machine=prepared.machine,
        out=folder / prepared.folder,
        tip_tolerance=tip,
        axis_tolerance=axis,
        planner=job.planner,
        effort=job.effort,
        prove_within=job.prove_within,
        feed=job.feed,
        dialect=job.dialect,
        options=prepared.options,
        dt=job.dt,
        csv=job.csv,
        report=job.report,
        npz=str(job.npz),
        tool=prepared.tool,
        source=prepared.source,
    )
    record, _ = plan_steps.carry_out(task, steps)
    return _row_of_plan(prepared, record)


def _row_of_plan(prepared: Prepared, record: PlanRecord) -> BatchRow:
    return msgspec.structs.replace(
        waiting(prepared.job),
        machine=record.machine,
        verdict="verified" if record.verified and record.usage.worst <= PROMISED else "failed",
        duration_s=record.duration_s,
        air_s=None if record.cut is None else record.cut.air_s,
        material_s=None if record.cut is None else record.cut.cutting_s,
        lower_bound_s=record.lower_bound_s,
        gap=record.gap,
        limited_by=record.limited_by,
        blocks=record.blocks,
        folder=prepared.folder,
        key=prepared.key,
    )


def _planned(folder: Path, prepared: Prepared) -> BatchRow:
    return _row_of_plan(prepared, read_plan(_unchanged(folder / prepared.folder, PLAN)))


def _unchanged(folder: Path, main: str) -> Path:
    """The folder of a result. Raises UsageError where it is not there as it was written."""
    if not (folder / main).is_file() or changed(folder):
        raise UsageError(f"{folder}: is not as toolpace wrote it")
    return folder


def _export(folder: Path, prepared: Prepared, steps: TimedSteps) -> BatchRow:
    from toolpace.controls.export import PlannedMotion, target_of, write_export

    try:
        row = _planned(folder, prepared)
    except (ToolpaceError, OSError):
        row = _plan(folder, prepared, steps)
    name = _export_name(prepared)
    target = target_of(prepared.job.to or "", dict(prepared.job.export))
    write_export(PlannedMotion.load(folder / prepared.folder), target, folder / name)
    return msgspec.structs.replace(row, exported=name)


def _exported(folder: Path, prepared: Prepared) -> BatchRow:
    from toolpace.controls.export import EXPORT

    _unchanged(folder / _export_name(prepared), EXPORT)
    return msgspec.structs.replace(_planned(folder, prepared), exported=_export_name(prepared))


def _export_name(prepared: Prepared) -> str:
    return f"{prepared.folder}-{prepared.job.to}"


def _time(folder: Path, prepared: Prepared, steps: TimedSteps) -> BatchRow:
    from toolpace.jobs.timed import TimeRequest, time_record, timed

    job = prepared.job
    request = TimeRequest(
        machine=prepared.machine,
        options=prepared.options,
        model=job.model,
        feed=job.feed,
        dialect=job.dialect,
        tolerances=(job.tip_tolerance, job.axis_tolerance),
        optimum=job.optimum,
    )
    found = timed(prepared.path, request, steps, prepared.source)
    return _row_of_time(prepared, _write(folder, TIMED, prepared, time_record(found, prepared.machine.name)))


def _row_of_time(prepared: Prepared, figures: Mapping[str, Any]) -> BatchRow:
    cut = figures.get("cut") or {}
    return msgspec.structs.replace(
        waiting(prepared.job),
        machine=prepared.machine.name,
        verdict="timed",
        duration_s=figures["total_s"],
        optimum_s=figures["optimum_s"],
        air_s=cut.get("air_s"),
        material_s=cut.get("cutting_s"),
        blocks=figures["blocks"],
        folder=prepared.folder,
        key=prepared.key,
    )


def _timed(folder: Path, prepared: Prepared) -> BatchRow:
    return _row_of_time(prepared, _figures(folder, TIMED, prepared))


def _inspect(folder: Path, prepared: Prepared, steps: TimedSteps) -> BatchRow:
    from toolpace.jobs.inspection import follow_as_planned, inspection_record
    from toolpace.programs.reading.inspection import inspect_source

    job = prepared.job
    found = inspect_source(
        prepared.source, prepared.options, prepared.machines, job.dialect, job.feed, follow_as_planned
    )
    return _row_of_inspection(prepared, _write(folder, INSPECTED, prepared, inspection_record(found)))


def _row_of_inspection(prepared: Prepared, figures: Mapping[str, Any]) -> BatchRow:
    refused = [f"{each['word']} (line {each['line']}): {each['cure']}" for each in figures["refused"]]
    more = f"; and {len(refused) - 1} more" if len(refused) > 1 else ""
    return msgspec.structs.replace(
        waiting(prepared.job),
        machine=", ".join(figures["machines"]) or waiting(prepared.job).machine,
        verdict=ERROR if refused else "read",
        error=f"{refused[0]}{more}" if refused else "",
        blocks=figures["blocks"],
        folder=prepared.folder,
        key=prepared.key,
    )


def _inspected(folder: Path, prepared: Prepared) -> BatchRow:
    return _row_of_inspection(prepared, _figures(folder, INSPECTED, prepared))


def _write(folder: Path, name: str, prepared: Prepared, figures: dict[str, object]) -> dict[str, Any]:
    """Write what was found as the one file of a folder, with its seal."""
    figures = {**figures, "program": printable(str(prepared.job.program))}
    with whole_folder(folder / prepared.folder, seal=name) as temporary:
        (temporary / name).write_bytes(msgspec.json.format(msgspec.json.encode(figures), indent=2) + b"\n")
    return figures


def _figures(folder: Path, name: str, prepared: Prepared) -> dict[str, Any]:
    path = _unchanged(folder / prepared.folder, name) / name
    figures: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return figures


_DOERS: dict[str, Callable[[Path, Prepared, TimedSteps], BatchRow]] = {
    "plan": _plan, "time": _time, "inspect": _inspect, "export": _export
}  # fmt: skip
_READERS: dict[str, Callable[[Path, Prepared], BatchRow]] = {
    "plan": _planned, "time": _timed, "inspect": _inspected, "export": _exported
}  # fmt: skip

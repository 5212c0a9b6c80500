"""The command `export`: its options in SI units, and the list of written files."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console

from toolpace.cli.console import Steps, new_console
from toolpace.cli.options import PlanFolder, Switch
from toolpace.common.errors import UsageError, printable

TargetName = Annotated[
    str,
    Parameter(
        name="--to",
        help="table: CSV or Parquet. linuxcnc-hal: rows for HAL's streamer. linuxcnc-g93: a G93 stream and its guard."
        " beckhoff-fifo: rows for TwinCAT's FIFO axes. program: the same program with the feeds of the plan.",
    ),
]
ExportOut = Annotated[
    str | None,
    Parameter(name=["--out", "-o"], help="Folder for the files; by default PLAN-TARGET in the current folder."),
]
_TIMES = ("period", "pad", "split", "nc_cycle", "plc_cycle")
"""Options that are times."""


@Parameter(name="*")
@dataclass(frozen=True)
class TargetOptions:
    """Options of targets; each target has some of them, and refuses the others."""

    period: Annotated[
        str | None, Parameter(help="Time between rows, or the servo period; by default the plan's time step.")
    ] = None
    resample: Annotated[
        bool, Switch, Parameter(help="Interpolate: rows may lie between the set-points of the plan.")
    ] = False
    columns: Annotated[
        str | None,
        Parameter(help="table: which of t,q,qd,qdd,qddd,tip,axis,block; by default t,q,qd,qdd,block."),
    ] = None
    scale: Annotated[str | None, Parameter(help="table: units of length and angle; by default mm,deg.")] = None
    counts: Annotated[
        str | None,
        Parameter(help="table: increments of the encoders in place of units: X=10000/mm,A=1000/deg,..."),
    ] = None
    format: Annotated[str | None, Parameter(help="table: csv, the default, or parquet.")] = None
    tip: Annotated[bool, Switch, Parameter(help="linuxcnc-g93: write the tip, under M428, in place of joints.")] = False
    digits: Annotated[int | None, Parameter(help="linuxcnc-g93: number of decimals; 9 by default.")] = None
    pad: Annotated[str | None, Parameter(help="linuxcnc-g93: time for the queue to fill; 1s by default.")] = None
    coordinates: Annotated[
        str | None,
        Parameter(help="linuxcnc-g93: axis letters of LinuxCNC's joints, like XYYZ; by default each axis once."),
    ] = None
    guard_output: Annotated[
        int | None, Parameter(help="linuxcnc-g93: digital output that switches its guard on; 3 by default.")
    ] = None
    fifo_rows: Annotated[
        int | None, Parameter(help="beckhoff-fifo: number of rows of the channel's FIFO, as FiFoGetDimension gives.")
    ] = None
    fifo_axes: Annotated[
        int | None, Parameter(help="beckhoff-fifo: number of axes of the channel's FIFO, as FiFoGetDimension gives.")
    ] = None
    nc_cycle: Annotated[
        str | None, Parameter(help="beckhoff-fifo: cycle time of the NC's SAF task; by default that of the rows.")
    ] = None
    plc_cycle: Annotated[
        str | None, Parameter(help="beckhoff-fifo: cycle time of the PLC that fills the FIFO; 10ms by default.")
    ] = None
    inverse_time: Annotated[bool, Switch, Parameter(help="program: feeds as inverse times (G93).")] = False
    split: Annotated[
        str | None, Parameter(help="program: divide straight blocks that take longer into pieces of about this time.")
    ] = None

    def target_options(self) -> dict[str, Any]:
        """Those that were given, in SI and as the targets have them. Raises UsageError."""
        from toolpace.cli import arguments

        found: dict[str, Any] = {}
        for each in fields(self):
            value = getattr(self, each.name)
            if value is None or value is False:
                continue
            if each.name in _TIMES:
                value = arguments.time_option(f"--{each.name.replace('_', '-')}", value)
            elif each.name == "columns":
                value = tuple(part.strip() for part in value.split(","))
            elif each.name == "counts":
                value = increments_by_column(value)
            found[each.name] = value
        return found


AS_USUAL = TargetOptions()
"""Nothing was given."""


def increments_by_column(text: str) -> dict[str, str]:
    """X=10000/mm,A=1000/deg as joints and figures. Raises UsageError."""
    found: dict[str, str] = {}
    for part in text.split(","):
        joint, equals, figure = part.partition("=")
        if not equals or not joint.strip() or joint.strip() in found:
            raise UsageError(f"--counts {part[:40]}: write each joint once, like X=10000/mm,A=1000/deg")
        found[joint.strip()] = figure.strip()
    return found


def export_command(
    directory: PlanFolder,
    /,
    *,
    to: TargetName,
    out: ExportOut = None,
    target: TargetOptions = AS_USUAL,
) -> int:
    """Write a plan as files that a control loads: a table, streams for LinuxCNC, rows of a FIFO, or the program itself.

    The files are read back and compared with the plan before the folder is put in
    place. Each says at its head how to use it. What a target cannot hold is refused.
    docs: from plan to machine.

    For example:

        toolpace export part-plan --to table --period 4ms --columns t,q,qd
        toolpace export part-plan --to linuxcnc-g93 --out part-stream
        toolpace export part-plan --to program --inverse-time
    """
    from toolpace.cli import arguments
    from toolpace.controls.export import PlannedMotion, target_of, write_export
    from toolpace.jobs import plan_steps

    console = new_console()
    writer = target_of(to, target.target_options())
    place = arguments.folder_for_results(export_folder(directory, to) if out is None else out)
    steps = Steps(console)
    if to == "program":
        plan_steps.warm_up(steps)
    with steps.step("loading") as step:
        motion = PlannedMotion.load(Path(directory))
        step.note = f"{len(motion.setpoints)} set-points"
    with steps.step("exporting") as step:
        exported = write_export(motion, writer, place, step)
    show(console, place, list(exported.files), [*exported.notes, *(f"read back: {each}" for each in exported.checks)])
    return 0


def show(console: Console, folder: Path, files: list[str], notes: list[str]) -> None:
    """Notes, a line each, and the files."""
    for note in notes:
        console.print(f"{'':<12} {printable(note)}", soft_wrap=True)
    console.print(f"written      {printable(str(folder))}: {', '.join(files)}", soft_wrap=True)


def export_folder(directory: str, to: str) -> str:
    """part-table for the table of part-plan, here."""
    name = Path(directory).resolve().name.removesuffix("-plan") or "plan"
    return f"{name}-{to}"

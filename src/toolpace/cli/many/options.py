"""The options of the command `batch`, and the jobs that they ask for."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from toolpace.cli import arguments, options
from toolpace.errors import UsageError

if TYPE_CHECKING:
    from toolpace.batching import BatchJob

ProgramsOrJobs = Annotated[
    list[str],
    Parameter(help="Programs, folders of programs, patterns of names, or one file of jobs (.toml)."),
]
What = Annotated[
    str,
    Parameter(
        help="plan; time, on its control, and the optimum; inspect; export: plan, and write files for a control."
    ),
]
Machines = Annotated[
    list[str],
    Parameter(
        name=["--machine", "-m"],
        negative="",
        help="Built-in machine or machine file; named several times, each program is planned on each of them.",
    ),
]
Target = Annotated[str | None, Parameter(name="--to", help="Of export: the target, as of `toolpace export`.")]
Out = Annotated[str, Parameter(name=["--out", "-o"], help="Folder for all; one that a batch has left is gone on with.")]
Address = Annotated[
    str | None,
    Parameter(
        name="--cluster",
        help="Address of a scheduler of dask, like tcp://10.0.0.5:8786; without, workers are started on this computer.",
    ),
]
Workers = Annotated[
    int | None,
    Parameter(help="Workers to start on this computer: one a core by default; 0: this process does it all."),
]
Memory = Annotated[
    str | None, Parameter(help="What each worker that is started may take, like 4GB; by default an equal share of all.")
]


@Parameter(name="*")
@dataclass(frozen=True)
class Each:
    """What each job is planned with; each of these may be given several times, for a job with each."""

    tip_tolerance: Annotated[list[str] | None, Parameter(negative="", help="0.01mm by default.")] = None
    axis_tolerance: Annotated[list[str] | None, Parameter(negative="", help="0.05deg by default.")] = None
    planner: Annotated[list[str] | None, Parameter(negative="", help="optimal by default.")] = None
    effort: Annotated[list[str] | None, Parameter(negative="", help="low, normal (default) or high.")] = None
    feed: Annotated[
        list[str] | None, Parameter(negative="", help="In place of the program's: 120%, 3000mm/min, none.")
    ] = None
    prove: options.Prove = False
    prove_within: options.ProveWithin = "60s"
    bend: options.Bend = None
    tool_length: options.ToolLength = None
    dialect: options.Dialect = None
    model: options.ControlModel = None
    no_optimum: options.NoOptimum = False


AS_USUAL = Each()
NO_MACHINES: list[str] = []
"""Nothing was given."""


def jobs_of(
    programs: list[str],
    what: str,
    machines: list[str],
    to: str | None,
    each: Each,
    files: options.Files,
    reading: options.Reading,
) -> list[BatchJob]:
    """The jobs of a file, or those that the options ask for. Raises UsageError."""
    tables = [program for program in programs if program.endswith(".toml")]
    if not tables:
        return jobs_asked(programs, what, machines, to, each, files, reading)
    if len(programs) > 1:
        raise UsageError(f"{tables[0]}: a file of jobs names all programs itself; give it alone")
    asked = (what, machines, to, each, files, reading)
    if asked != ("plan", NO_MACHINES, None, AS_USUAL, options.USUAL_FILES, options.AS_WRITTEN):
        raise UsageError(
            f"{tables[0]}: what is asked of a job stands in the file, under [all] or [[jobs]], not beside it"
        )
    from toolpace.batching.jobs_file import jobs_of_file

    return jobs_of_file(tables[0])


def jobs_asked(
    programs: list[str],
    what: str,
    machines: list[str],
    to: str | None,
    each: Each,
    files: options.Files,
    reading: options.Reading,
) -> list[BatchJob]:
    """A job of each program, machine, tolerance, planner, effort and feed. Raises UsageError."""
    from toolpace.batching import BatchJob
    from toolpace.batching.programs import programs_in

    named = []
    for program in programs:
        found = programs_in(program)
        if not found:
            raise UsageError(f"{program}: no program is there, or none whose name ends like that of a program")
        named += found
    common = _common(what, to, each, files, reading)
    tips = [
        arguments.tolerances(tip, options.AXIS_TOLERANCE)[0] for tip in each.tip_tolerance or [options.TIP_TOLERANCE]
    ]
    axes = [
        arguments.tolerances(options.TIP_TOLERANCE, axis)[1] for axis in each.axis_tolerance or [options.AXIS_TOLERANCE]
    ]
    planners = [arguments.planner_named(name) for name in each.planner or ["optimal"]]
    efforts = [arguments.effort_named(name) for name in each.effort or ["normal"]]
    feeds: list[str | None] = [arguments.feed_asked(feed) for feed in each.feed] if each.feed else [None]
    on: list[str | None] = [*machines] or [None]
    if not machines and what != "inspect":
        arguments.machine_named(None)
    combinations = itertools.product(named, on, tips, axes, planners, efforts, feeds)
    return [
        BatchJob(
            program=program,
            machine=machine,
            tip_tolerance=tip,
            axis_tolerance=axis,
            planner=planner,
            effort=effort,
            feed=feed,
            **common,
        )
        for program, machine, tip, axis, planner, effort, feed in combinations
    ]


def _common(what: str, to: str | None, each: Each, files: options.Files, reading: options.Reading) -> dict[str, Any]:
    from toolpace import units

    return {
        "what": what,
        "to": to,
        "prove_within": arguments.time_to_prove(each.prove_within, "optimal") if each.prove else None,
        "bend": each.bend,
        "tool_length": None if each.tool_length is None else units.parse_length(each.tool_length),
        "dialect": each.dialect,
        "model": arguments.control_model(each.model),
        "optimum": not each.no_optimum,
        "dt": arguments.time_step(files.dt),
        "csv": files.csv,
        "npz": arguments.npz_wanted(files.npz),
        "report": not files.no_report,
        "controller": reading.controller,
        "setup": reading.setup,
        "skip_unknown": reading.skip_unknown,
        "compensation": reading.compensation or "",
        "max_blocks": reading.max_blocks,
    }

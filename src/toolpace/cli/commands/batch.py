"""The command `batch`: its options, and the jobs of them."""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from toolpace.cli import options
from toolpace.cli.options import HERE, Where
from toolpace.common.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from toolpace.jobs.batch import BatchJob

ProgramsOrJobs = Annotated[
    list[str],
    Parameter(help="Programs, folders of programs, patterns of names, or one file of jobs (.toml)."),
]
What = Annotated[
    str,
    Parameter(
        help="plan. time: on its control, and the optimum. inspect. export: plan, and write files for a control."
    ),
]
Machines = Annotated[
    list[str],
    Parameter(
        name=["--machine", "-m"],
        negative="",
        help="Built-in machine or machine file; may be given several times: each program is planned on each.",
    ),
]
Target = Annotated[str | None, Parameter(name="--to", help="With --what export: the target, as for `toolpace export`.")]
Out = Annotated[
    str, Parameter(name=["--out", "-o"], help="Folder for all jobs; a batch that was stopped there continues.")
]
Memory = Annotated[
    str | None, Parameter(help="Memory of each worker that is started, like 4GB; by default an equal share.")
]


@Parameter(name="*")
@dataclass(frozen=True)
class Each:
    """What each job is planned with; each of these may be given several times, for a job with each."""

    tip_tolerance: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="Tolerance of the tip; by default 0.01mm, or less as the program asks; --what time: the program's.",
        ),
    ] = None
    axis_tolerance: Annotated[
        list[str] | None,
        Parameter(negative="", help="Tolerance of the tool axis; by default 0.05deg, or the program's as of the tip."),
    ] = None
    planner: Annotated[
        list[str] | None, Parameter(negative="", help="optimal (default), genetic or second-order.")
    ] = None
    effort: Annotated[list[str] | None, Parameter(negative="", help="low, normal (default) or high.")] = None
    feed: Annotated[
        list[str] | None, Parameter(negative="", help="Feed in place of the program's: 120%, 3000mm/min, none.")
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


@dataclass(frozen=True)
class BatchRequest:
    """Programs, or a file of jobs, and what is to be done with each."""

    programs: list[str]
    machines: list[str]
    what: str = "plan"
    to: str | None = None
    """Target of an export."""
    each: Each = AS_USUAL
    files: options.Files = options.USUAL_FILES
    reading: options.Reading = options.AS_WRITTEN

    def jobs(self) -> list[BatchJob]:
        """The jobs of the file, or those that the options ask for. Raises UsageError."""
        tables = [program for program in self.programs if program.endswith(".toml")]
        if not tables:
            return self._combined()
        if len(self.programs) > 1:
            raise UsageError(f"{tables[0]}: a file of jobs names all programs itself; give it alone")
        if self != BatchRequest(self.programs, []):
            raise UsageError(
                f"{tables[0]}: what is asked of a job stands in the file, under [all] or [[jobs]], not beside it"
            )
        from toolpace.jobs.batch.jobs_file import jobs_of_file

        return jobs_of_file(tables[0])

    def _combined(self) -> list[BatchJob]:
        """A job of each program, machine, tolerance, planner, effort and feed."""
        from toolpace.cli import arguments

        each, named = self.each, self._programs()
        job = self._job()
        tips: list[float | None] = [
            arguments.even_tolerances(options.Tolerances(tip_tolerance=tip))[0] for tip in each.tip_tolerance or ()
        ]
        axes: list[float | None] = [
            arguments.even_tolerances(options.Tolerances(axis_tolerance=axis))[1] for axis in each.axis_tolerance or ()
        ]
        planners = [arguments.planner_named(name) for name in each.planner or ["optimal"]]
        efforts = [arguments.effort_named(name) for name in each.effort or ["normal"]]
        feeds: list[str | None] = [arguments.feed_option(feed) for feed in each.feed] if each.feed else [None]
        on: list[str | None] = [*self.machines] or [None]
        if not self.machines and self.what != "inspect":
            arguments.machine_named(None)
        combinations = itertools.product(named, on, tips or [None], axes or [None], planners, efforts, feeds)
        return [
            job(
                program=program, machine=machine, tip_tolerance=tip, axis_tolerance=axis, planner=planner,
                effort=effort, feed=feed,
            )
            for program, machine, tip, axis, planner, effort, feed in combinations
        ]  # fmt: skip

    def _programs(self) -> list[str]:
        from toolpace.jobs.batch.jobs_file import programs_in

        found = []
        for program in self.programs:
            files = programs_in(program)
            if not files:
                raise UsageError(f"{program}: no program is there, or none whose name ends like that of a program")
            found += files
        return found

    def _job(self) -> Callable[..., BatchJob]:
        """A job with all that is the same for each."""
        from toolpace.cli import arguments
        from toolpace.common import units
        from toolpace.jobs.batch import BatchJob

        each, files, reading = self.each, self.files, self.reading
        return functools.partial(
            BatchJob,
            what=self.what,
            to=self.to,
            prove_within=arguments.time_to_prove(each.prove_within, "optimal") if each.prove else None,
            bend=each.bend,
            tool_length=None if each.tool_length is None else units.parse_length(each.tool_length),
            dialect=each.dialect,
            model=arguments.control_model(each.model),
            optimum=not each.no_optimum,
            dt=arguments.time_step(files.dt),
            csv=files.csv,
            npz=arguments.form_of_set_points(files.npz),
            report=not files.no_report,
            controller=reading.controller,
            setup=reading.setup,
            skip_unknown=reading.skip_unknown,
            lenient=reading.lenient,
            compensation=reading.compensation or "",
            max_blocks=reading.max_blocks,
            columns=reading.columns,
            units=reading.units,
        )


def batch_command(
    programs: ProgramsOrJobs,
    /,
    *,
    machine: Machines = NO_MACHINES,
    what: What = "plan",
    to: Target = None,
    out: Out = "toolpace-batch",
    where: Where = HERE,
    memory: Memory = None,
    each: Each = AS_USUAL,
    files: options.Files = options.USUAL_FILES,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Plan, time, inspect or export many programs on one or many machines, on all cores or on a cluster.

    Each job has its own folder in --out; batch.html and batch.parquet have one row
    for each job. The same command continues a batch that was stopped: it recognises
    finished jobs by the hash of program, machine, options and version. A program
    that is refused does not stop the others. Exit code 0 if all is planned and
    verified, 1 if a verification failed, 2 if a job has no result.
    docs: many programs.

    For example:

        toolpace batch parts/ -m xyzac-trunnion --out plans
        toolpace batch parts/ -m my-mill.toml -m xyzbc-head --tip-tolerance 5um --tip-tolerance 20um
        toolpace batch jobs.toml --cluster tcp://10.0.0.5:8786 --out /shared/plans
        toolpace batch parts/ --what inspect
        toolpace batch parts/ -m my-mill.toml --what export --to table
    """
    from toolpace.cli.batch_progress import run_jobs

    client = where.client()
    request = BatchRequest(programs, machine, what, to, each, files, reading)
    return run_jobs(request.jobs(), out, client, memory)

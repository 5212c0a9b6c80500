"""The command `batch`, and its display while it runs: its progress, and the outcome of each job."""

from __future__ import annotations

import functools
import itertools
import time
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.text import Text

from toolpace.cli import options
from toolpace.cli.console import cells, named_error, new_console, new_table, short_names
from toolpace.cli.options import HERE, Where
from toolpace.cli.summary import limit_in_words
from toolpace.common.cluster import Pool, open_pool
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.jobs.batch import Batch, BatchJob, BatchRow, run_batch
from toolpace.jobs.batch.folder import batch_folder
from toolpace.results.report.words import at_most

if TYPE_CHECKING:
    from collections.abc import Callable

    from toolpace.jobs.batch import BatchJob

LOOK = 1.0
"""Time between two looks at what runs now [s]."""
RUNNING, SHOWN = 8, 40
"""Jobs that are named while they run, and rows that are shown when all is done; batch.html has all."""
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
NO_MACHINES: list[str] = []
"""Nothing was given."""


def run_jobs(jobs: Sequence[BatchJob], out: str, where: str | int | None, memory: str | None) -> int:
    """Carry out jobs, show how far it is, and what came of them; 0 where all is well, else 1 or 2."""
    console = new_console()
    with batch_folder(out) as place, open_pool(where, memory) as pool:
        _say(console, "batch", f"{counted(len(jobs), 'job')} on {pool.where}")
        if pool.note:
            _say(console, "", pool.note)
        if pool.dashboard:
            _say(console, "dashboard", pool.dashboard)
        shown = _Shown(console, pool, jobs)
        try:
            with shown.live():
                done = run_batch(jobs, place, pool, shown.tell)
        except KeyboardInterrupt:
            ended = f"{shown.ended} of {counted(len(jobs), 'job')}"
            _say(console, "stopped", f"{ended} have ended; the same command continues")
            raise
    _show(console, done)
    return done.exit_code


class _Shown:
    """A line of each job that has ended, and below it how far all is and what runs now."""

    def __init__(self, console: Console, pool: Pool, jobs: Sequence[BatchJob]) -> None:
        self.console, self.pool, self.jobs = console, pool, jobs
        self.names = [printable(name) for name in short_names([str(job.program) for job in jobs])]
        columns = (SpinnerColumn(), BarColumn(bar_width=30), MofNCompleteColumn(), TimeElapsedColumn())
        self.bar = Progress(*columns, TextColumn("{task.description}"), console=console)
        self.task = self.bar.add_task("", total=len(jobs))
        self.looked, self.now = 0.0, Text()
        self.wrong = self.ended = 0

    def live(self) -> Live | nullcontext[None]:
        """What is drawn anew all the time; nothing where there is no terminal."""
        if not self.console.is_terminal:
            return nullcontext()
        return Live(get_renderable=self.drawn, console=self.console, transient=True, refresh_per_second=4)

    def drawn(self) -> RenderableType:
        """The bar, and what runs."""
        if time.monotonic() - self.looked > LOOK:
            self.looked = time.monotonic()
            self.now = self._running()
        return Group(self.bar, self.now)

    def _running(self) -> Text:
        by_worker: dict[str, list[str]] = {}
        for (number, _), worker in self.pool.now():
            by_worker.setdefault(worker, []).append(self.names[number])
        lines = [f"  {worker or 'here'}: {', '.join(labels)}" for worker, labels in sorted(by_worker.items())]
        more = [f"  and {len(lines) - RUNNING} more workers"] if len(lines) > RUNNING else []
        return Text(printable("\n".join(lines[:RUNNING] + more)).replace("\\n", "\n"), style="dim")

    def tell(self, row: BatchRow, done: int) -> None:
        """Of a job that has ended."""
        self.wrong += not row.ok
        self.ended = done
        self.bar.update(self.task, completed=done, description=f"{self.wrong} failed" if self.wrong else "")
        if self.console.is_terminal and row.ok:
            return
        took = "found" if row.found else format_time(row.seconds)
        duration = format_time(row.duration_s) if row.duration_s is not None else ""
        on = f" on {row.machine}" if row.machine else ""
        named = named_error(row.program, row.error) if row.error else f"{row.program}{on}  {duration}"
        line = f"{done}/{len(self.jobs)}  {row.verdict:<9} {took:>8}  {named}"
        self.console.print(Text(printable(line), style="" if row.ok else "red"), soft_wrap=True)


def errors(rows: Iterable[BatchRow]) -> dict[str, list[str]]:
    """What is wrong, once, and the machines with which it is."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if row.error:
            machines = found.setdefault(named_error(row.program, row.error), [])
            machines += [row.machine] if row.machine not in machines else []
    return found


def _say(console: Console, name: str, text: str) -> None:
    console.print(Text(printable(f"{name:<12} {text}")), soft_wrap=True)


def _show(console: Console, done: Batch) -> None:
    """A table, what is not well first, and where all of it is."""
    rows = sorted(done, key=lambda row: -row.exit_code)[:SHOWN]
    timed = any(row.optimum_s is not None for row in rows)
    headings = ("program", "machine", "result", "time", *(["optimum"] if timed else []), "gap", "limited by", "took")
    table = new_table(headings, left=("program", "machine", "result", "limited by"))
    for name, row in zip(short_names([row.program for row in rows]), rows):
        optimum = format_time(row.optimum_s) if row.optimum_s is not None else "-"
        words = (
            name,
            row.machine,
            row.verdict,
            format_time(row.duration_s) if row.duration_s is not None else "-",
            *([optimum] if timed else []),
            at_most(row.gap) if row.gap is not None else "-",
            f"{limit_in_words(row.limit)} {100.0 * row.limited_by[row.limit]:.0f} %" if row.limit else "-",
            "found" if row.found else format_time(row.seconds) if row.seconds else "-",
        )
        table.add_row(*cells(words, "" if row.ok else "red"))
    console.print(table)
    if len(done) > len(rows):
        _say(console, "", f"and {len(done) - len(rows)} more: see batch.html")
    for error, machines in errors(rows).items():
        _say(console, "", f"{error} (on {', '.join(machines)})" if len(machines) > 1 else error)
    well = sum(row.ok for row in done)
    found = sum(row.found for row in done)
    _say(
        console,
        "done",
        f"{well} of {counted(len(done), 'job')}" + (f", {found} of them by an earlier batch" if found else ""),
    )
    _say(console, "written", f"{done.folder}: {', '.join(done.files)}")


@Parameter(name="*")
@dataclass(frozen=True)
class Each:
    """What each job is planned with; each of these may be given several times, for a job with each."""

    tip_tolerance: Annotated[
        list[str] | None,
        Parameter(negative="", help="Tolerance of the tip; by default 0.01mm, or with --what time the program's."),
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
    from toolpace.cli.commands.batch import run_jobs

    client = where.client()
    request = BatchRequest(programs, machine, what, to, each, files, reading)
    return run_jobs(request.jobs(), out, client, memory)

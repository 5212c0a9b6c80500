"""The command `setup`: its options, the search for a set-up, and the table of results."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.box import SIMPLE
from rich.table import Table
from rich.text import Text

from toolpace.cli import options
from toolpace.cli.console import Steps, new_console
from toolpace.cli.options import HERE, Where
from toolpace.common.errors import ToolpaceError, UsageError, printable
from toolpace.common.units import DEGREE, MILLIMETRE, format_time

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.toolpath import ToolPath
    from toolpace.setup_search.choices import Choices
    from toolpace.setup_search.found_set_up import FoundSetUp, PlannedSetUp

Out = Annotated[
    str | None,
    Parameter(name=["--out", "-o"], help="Folder for the results; by default PROGRAM-setup in the current folder."),
]
Plans = Annotated[
    str | None,
    Parameter(name="--plans", help="Write the plan of each set-up that is shown, with its report, into a folder."),
]


@Parameter(name="*")
@dataclass(frozen=True)
class SearchOptions:
    """Among what is searched, and how long."""

    machines: Annotated[
        str | None,
        Parameter(
            help="Several machines, separated by commas: each is searched, and the fastest is taken."
        ),
    ] = None
    choices: Annotated[
        str | None,
        Parameter(
            help="File of choices (.toml): fixture tilts, turns, places, tool lengths, and zones where the machine must"
            " not be."
        ),
    ] = None
    trials: Annotated[int, Parameter(help="How many clampings are tried on each machine, each by a cheap plan.")] = 200
    shown: Annotated[int, Parameter(help="How many of the best are planned in full, and shown.")] = 10
    seed: Annotated[int, Parameter(help="Seed of the search; another one searches in another order.")] = 0
    no_map: Annotated[bool, options.Switch, Parameter(help="Leave the map of the time over x and y out.")] = False

    def check_numbers(self) -> None:
        """Raise UsageError where there is too little, or too much, to search or to show."""
        from toolpace.setup_search.search import FEWEST, MOST_SHOWN

        if self.trials < FEWEST:
            raise UsageError(f"--trials {self.trials}: so few find nothing; give at least {FEWEST}")
        if not 1 <= self.shown <= MOST_SHOWN:
            raise UsageError(f"--shown {self.shown}: give 1 to {MOST_SHOWN}")

    def machines_named(self, machine: str | None, tool_length: str | None) -> list[tuple[str, Machine]]:
        """The machines to search, by name; `machine` where there is but one. Raises UsageError."""
        from toolpace.cli import arguments

        if machine is not None and self.machines is not None:
            raise UsageError("--machine and --machines: give one of both; the first of several is the program's own")
        names = [name.strip() for name in self.machines.split(",")] if self.machines is not None else [machine]
        if len(set(names)) < len(names):
            raise UsageError(f"--machines {self.machines}: one machine is named twice; name each once")
        return [(str(name), arguments.machine_named(name, tool_length)) for name in names]

    def choices_in(self) -> Choices:
        """The choices in the file; the usual ones where none is named."""
        from toolpace.setup_search.choices import Choices, load_choices

        return Choices() if self.choices is None else load_choices(self.choices)


USUAL = SearchOptions()


@dataclass(frozen=True)
class SearchRequest:
    """What is to be searched, checked."""

    program: str
    machines: tuple[tuple[str, Machine], ...]
    """By the names that were given; the part is clamped in them as it is now."""
    choices: Choices
    tolerances: tuple[float, float]
    """Of tip [m] and axis [rad]."""
    trials: int
    seed: int
    shown: int
    """Set-ups that are planned in full."""
    mapped: int
    """Places of the map along x, and along y."""
    client: str | int | None
    out: Path
    feed: str | None
    dialect: str | None
    options: ReadOptions
    plans: Path | None = None
    """Folder for the plans of the set-ups that are shown; None: they are not written."""


def setup_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    search: SearchOptions = USUAL,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    feed: options.Feed = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    out: Out = None,
    plans: Plans = None,
    where: Where = HERE,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Find where to clamp the part, with which fixture and tool, so that a program is fastest within all travels.

    Clampings are tried by cheap plans; the best ten are planned in full. The
    program is read for the machine as it is (of several, the first), and written
    out as tips and tool axes, which hold for any clamping. Collisions are not
    checked: the file of --choices lists the choices, and the zones where the
    machine must not be. docs: where to clamp the part.

    For example:

        toolpace setup part.ngc -m xyzac-trunnion
        toolpace setup part.ngc -m my-mill.toml --choices fixtures.toml --out part-setup
        toolpace setup part.cls --machines xyzac-trunnion,xyzbc-head,my-mill.toml
        toolpace setup part.ngc -m my-mill.toml --shown 3 --plans part-plans
    """
    from toolpace.cli import arguments
    from toolpace.setup_search.search import MAPPED

    search.check_numbers()
    named = search.machines_named(machine, tool_length)
    first, how = arguments.machine_with_setup(named[0][1], reading)
    return run_setup(
        SearchRequest(
            program=program,
            machines=((named[0][0], first), *named[1:]),
            choices=search.choices_in(),
            tolerances=arguments.even_tolerances(tolerances),
            trials=search.trials,
            seed=search.seed,
            shown=search.shown,
            mapped=0 if search.no_map else MAPPED,
            client=where.client(),
            out=arguments.folder_for_results(arguments.default_folder(program, "setup") if out is None else out),
            feed=arguments.feed_option(feed),
            dialect=dialect,
            options=how,
            plans=None if plans is None else arguments.folder_for_results(plans, "--plans"),
        )
    )


def run_setup(request: SearchRequest) -> int:
    """Search each machine, write the folder of the fastest, and say what was found."""
    from toolpace.jobs import plan_steps
    from toolpace.results.write.set_up_folder import write_set_up
    from toolpace.setup_search.search import check_arguments

    console = new_console()
    steps = Steps(console)
    toolpath = read_for_first(request, steps)
    check_arguments(toolpath, request.trials, request.mapped, request.shown)
    for _, each in request.machines:
        request.choices.checked(each)
    plan_steps.warm_up(steps)
    found = [(name, searched(request, toolpath, machine, name, steps)) for name, machine in request.machines]
    fastest = min(
        (each for _, each in found if not isinstance(each, str)), key=lambda each: each.best[0].duration, default=None
    )
    if fastest is None:
        raise UsageError("; ".join(str(why) for _, why in found))
    reports = () if request.plans is None else written_plans(request, request.plans, fastest, console)
    with steps.step("writing"):
        files = write_set_up(request.out, fastest, Path(request.program).name, request.options.setup, found, reports)
    show_found(console, fastest, found)
    console.print(f"written      {printable(str(request.out))}: {', '.join(files)}", soft_wrap=True)
    console.print(f"to plan it   {advice(request)}", soft_wrap=True)
    console.print("             --effort low gives the time above; without it the plan may be faster")
    return 0


def written_plans(request: SearchRequest, folder: Path, found: FoundSetUp, console: Console) -> list[str]:
    """Plan the program in each of the best set-ups, as it was planned in the search, into a folder of its own.

    Returns the names of the reports as they are reached from the folder of the results.
    """
    from toolpace.jobs import job, plan_steps
    from toolpace.results.write import REPORT
    from toolpace.results.write.set_up_folder import PROGRAM, cldata_text
    from toolpace.setup_search.found_set_up import with_sheet

    folder.mkdir(parents=True, exist_ok=True)
    program, reports = folder / PROGRAM, []
    program.write_text(cldata_text(found.toolpath, Path(request.program).name), encoding="utf-8")
    for number, each in enumerate(found.best, start=1):
        console.print(f"\nset-up {number}: {each.clamping.words(each.machine)}")
        machine, out = with_sheet(each.machine, request.options.setup), folder / str(number)
        plan_steps.carry_out(job.Job(program, machine, out, *request.tolerances, effort="low"), Steps(console))
        try:
            reports.append(Path(os.path.relpath(out / REPORT, request.out)).as_posix())
        except ValueError:  # on another drive
            reports.append("")
    console.print()
    return reports


def advice(request: SearchRequest) -> str:
    """The command that plans what was found, as it was planned here."""
    from toolpace.cli import arguments

    words = ["toolpace", "plan", str(request.out / "program.apt"), "-m", str(request.out / "machine.toml")]
    usual = arguments.even_tolerances(options.USUAL_TOLERANCES)
    tip, axis = request.tolerances
    words += ["--tip-tolerance", f"{tip / MILLIMETRE:.12g}mm"] if tip != usual[0] else []
    words += ["--axis-tolerance", f"{axis / DEGREE:.12g}deg"] if axis != usual[1] else []
    return printable(shlex.join([*words, "--effort", "low"]))


def read_for_first(request: SearchRequest, steps: Steps) -> ToolPath:
    """The program as it is read for the first machine."""
    from toolpace.jobs import job, plan_steps

    machine = request.machines[0][1]
    task = job.Job(
        Path(request.program), machine, request.out, *request.tolerances, feed=request.feed, dialect=request.dialect,
        options=request.options,
    )  # fmt: skip
    return plan_steps.read_program(job.loaded(task), steps)


def searched(request: SearchRequest, toolpath: ToolPath, machine: Machine, name: str, steps: Steps) -> FoundSetUp | str:
    """What was found on a machine; why nothing was, where others may have more. Raises ToolpaceError for one alone."""
    from toolpace.setup_search.search import search_setup

    tip, axis = request.tolerances
    several = len(request.machines) > 1
    try:
        with steps.step("searching", name if several else "") as step:
            found = search_setup(
                toolpath, machine, request.choices, tip_tolerance=tip, axis_tolerance=axis, trials=request.trials,
                seed=request.seed, shown=request.shown, mapped=request.mapped, client=request.client, progress=step,
            )  # fmt: skip
            step.note = f"{found.trials} clampings tried, {len(found.best)} planned in full"
        return found
    except ToolpaceError as error:
        if not several:
            raise
        steps.say(str(error))
        return str(error)


def show_found(console: Console, found: FoundSetUp, machines: Sequence[tuple[str, FoundSetUp | str]]) -> None:
    """The machines where there are several, the best set-ups of the fastest, and what limits before and after."""
    if len(machines) > 1:
        from toolpace.results.report.set_up_page import time_on

        table = Table("machine", "time", "given", "gain", "set-up", box=SIMPLE)
        for name, each in sorted(machines, key=time_on):
            if isinstance(each, str):
                table.add_row(Text(name), "", "", "", Text("none fits"))
            else:
                best = each.best[0]
                table.add_row(
                    Text(name),
                    format_time(best.duration),
                    format_time(each.given.duration) if each.given is not None else "cannot be run",
                    gain(best, each.given),
                    Text(best.clamping.words(best.machine)),
                )
        console.print(table)
    table = Table("", "time", "gain", "turn", "tilt", "swing", "x", "y", "z", "tool", "solution", box=SIMPLE)
    for column in table.columns[1:]:
        column.justify = "right"
    for number, planned in enumerate(found.best, start=1):
        table.add_row(*row(number, planned, found.given), style="bold" if number == 1 else "")
    if found.given is not None and found.given not in found.best:
        table.add_row(*row(len(found.best) + 1, found.given, found.given), style="dim")
    console.print(table)
    console.print("turn, tilt, swing in deg from the clamping as given, about the middle of the program;")
    console.print("x, y, z (its shift) and tool (length) in mm; solution: half circle of the second rotary joint")
    console.print()
    if found.given is None:
        console.print(f"as given     {printable(found.why)}", soft_wrap=True)
    else:
        console.print(f"before       {time_and_limits(found.given)}", soft_wrap=True)
    if found.best[0] is found.given:
        console.print("after        no clamping that was tried is faster: leave the part as it is")
    else:
        console.print(f"after        {time_and_limits(found.best[0])}", soft_wrap=True)


def time_and_limits(each: PlannedSetUp) -> str:
    """The time of a set-up, and what limits it."""
    from toolpace.cli.summary import limits_in_words

    return f"{format_time(each.duration)}, limited by {limits_in_words(dict(each.limited_by))}"


def row(number: int, each: PlannedSetUp, present: PlannedSetUp | None) -> list[str]:
    """A line of the table, in mm and deg."""
    clamping = each.clamping
    figures = [angle / DEGREE for _, angle in clamping.angles()]
    figures += [shift / MILLIMETRE for shift in clamping.shift]
    shown = [f"{round(figure, 2) + 0.0:g}" for figure in figures]
    tools = ", ".join(f"{round(length / MILLIMETRE, 2):g}" for length in each.tool_lengths)
    side = {0: "free", 1: "+", -1: "-"}[clamping.side]
    name = "given" if each is present else str(number)
    return [name, format_time(each.duration), gain(each, present), *shown, tools, side]


def gain(each: PlannedSetUp, present: PlannedSetUp | None) -> str:
    """What a set-up saves of the present one's time."""
    return (
        ""
        if present is None or each is present or math.isnan(present.duration)
        else f"{100.0 * (1.0 - each.duration / present.duration):.2f} %"
    )

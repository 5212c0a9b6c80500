"""The search of the command `setup`, and its display."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.table import Table
from rich.text import Text

from toolpace.cli import arguments, options
from toolpace.cli.steps import Steps, new_console
from toolpace.cli.summary import limits_in_words
from toolpace.common.errors import ToolpaceError, UsageError, printable
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.jobs import job

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.toolpath import ToolPath
    from toolpace.setup_search.choices import Choices
    from toolpace.setup_search.found_set_up import FoundSetUp, PlannedSetUp


@dataclass(frozen=True)
class AskedSearch:
    """What is to be searched, checked."""

    program: str
    machines: tuple[tuple[str, Machine], ...]
    """By the names they were asked for; the part is clamped in them as it is now."""
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


def run_setup(asked: AskedSearch) -> int:
    """Search each machine, write the folder of the fastest, and say what was found."""
    from toolpace.results.write.set_up_folder import write_set_up
    from toolpace.setup_search.search import check_arguments

    console = new_console()
    steps = Steps(console)
    toolpath = read_for_first(asked, steps)
    check_arguments(toolpath, asked.trials, asked.mapped, asked.shown)
    for _, each in asked.machines:
        asked.choices.checked(each)
    job.warm_up(steps)
    found = [(name, searched(asked, toolpath, machine, name, steps)) for name, machine in asked.machines]
    fastest = min(
        (each for _, each in found if not isinstance(each, str)), key=lambda each: each.best[0].duration, default=None
    )
    if fastest is None:
        raise UsageError("; ".join(str(why) for _, why in found))
    with steps.step("writing"):
        files = write_set_up(asked.out, fastest, Path(asked.program).name, asked.options.setup, found)
    show_found(console, fastest, found)
    console.print(f"written      {printable(str(asked.out))}: {', '.join(files)}", soft_wrap=True)
    console.print(f"to plan it   {advice(asked)}", soft_wrap=True)
    console.print("             --effort low gives the time above; without it the plan may be faster")
    return 0


def advice(asked: AskedSearch) -> str:
    """The command that plans what was found, as it was planned here."""
    words = ["toolpace", "plan", str(asked.out / "program.apt"), "-m", str(asked.out / "machine.toml")]
    usual = arguments.even_tolerances(options.USUAL_TOLERANCES)
    tip, axis = asked.tolerances
    words += ["--tip-tolerance", f"{tip / MILLIMETRE:.12g}mm"] if tip != usual[0] else []
    words += ["--axis-tolerance", f"{axis / DEGREE:.12g}deg"] if axis != usual[1] else []
    return printable(shlex.join([*words, "--effort", "low"]))


def read_for_first(asked: AskedSearch, steps: Steps) -> ToolPath:
    """The program as it is read for the first machine."""
    machine = asked.machines[0][1]
    task = job.Job(
        Path(asked.program), machine, asked.out, *asked.tolerances, feed=asked.feed, dialect=asked.dialect,
        options=asked.options,
    )  # fmt: skip
    return job.read_program(job.loaded(task), steps)


def searched(asked: AskedSearch, toolpath: ToolPath, machine: Machine, name: str, steps: Steps) -> FoundSetUp | str:
    """What was found on a machine; why nothing was, where others may have more. Raises ToolpaceError for one alone."""
    from toolpace.setup_search.search import search_setup

    tip, axis = asked.tolerances
    several = len(asked.machines) > 1
    try:
        with steps.step("searching", name if several else "") as step:
            found = search_setup(
                toolpath, machine, asked.choices, tip_tolerance=tip, axis_tolerance=axis, trials=asked.trials,
                seed=asked.seed, shown=asked.shown, mapped=asked.mapped, client=asked.client, progress=step,
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


def time_on(machine: tuple[str, FoundSetUp | str]) -> float:
    """How long the program takes on a machine with its best set-up [s]; inf where none fits."""
    return math.inf if isinstance(machine[1], str) else machine[1].best[0].duration


def time_and_limits(each: PlannedSetUp) -> str:
    """The time of a set-up, and what limits it."""
    return f"{format_time(each.duration)}, limited by {limits_in_words(dict(each.limited_by))}"


def row(number: int, each: PlannedSetUp, given: PlannedSetUp | None) -> list[str]:
    """A line of the table, in mm and deg."""
    clamping = each.clamping
    figures = [angle / DEGREE for _, angle in clamping.angles()]
    figures += [shift / MILLIMETRE for shift in clamping.shift]
    shown = [f"{round(figure, 2) + 0.0:g}" for figure in figures]
    tools = ", ".join(f"{round(length / MILLIMETRE, 2):g}" for length in each.tool_lengths)
    side = {0: "free", 1: "+", -1: "-"}[clamping.side]
    name = "given" if each is given else str(number)
    return [name, format_time(each.duration), gain(each, given), *shown, tools, side]


def gain(each: PlannedSetUp, given: PlannedSetUp | None) -> str:
    """What a set-up saves of the given one's time."""
    return (
        ""
        if given is None or each is given or math.isnan(given.duration)
        else f"{100.0 * (1.0 - each.duration / given.duration):.2f} %"
    )

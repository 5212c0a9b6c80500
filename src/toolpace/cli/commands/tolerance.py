"""The command `tolerance`: the duration of a program over the tolerance of its tip, as a table and a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from cyclopts import Parameter

from toolpace.cli import options
from toolpace.cli.console import Steps, new_console, new_table
from toolpace.common.units import format_length, format_time

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.jobs.job import Job

TIPS = "1um,2um,5um,10um,20um,50um"
Tips = Annotated[str, Parameter(help="Tolerances of the tip, separated by commas.")]
Picture = Annotated[
    str | None, Parameter(name=["--out", "-o"], help="Draw duration over tolerance into this file (.svg).")
]
ONE_LENGTH = 1e-9
"""Tolerances that differ by less than this are one [m]: 10um and 0.01mm differ by a rounding."""
WIDTH, HEIGHT = 720, 420
LEFT, RIGHT, TOP, BOTTOM = 84.0, 28.0, 56.0, 58.0
"""Margins [pixels]."""
LINE = "#2f6fed"
LINES = 5
"""About so many lines of equal duration."""


def tolerance_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    tips: Tips = TIPS,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    effort: options.Effort = "normal",
    feed: options.Feed = None,
    out: Picture = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Show what a micrometre costs: the duration of a program over the tolerance of its tip.

    The program is planned within each tolerance. The times are compared with that
    of --tip-tolerance.

    For example:

        toolpace tolerance part.ngc -m xyzac-trunnion
        toolpace tolerance part.ngc -m xyzbc-head --tips 2um,5um,20um --out costs.svg
    """
    from toolpace.cli import arguments
    from toolpace.jobs import job

    tip, axis = arguments.even_tolerances(tolerances)
    within = arguments.tip_tolerances(tips)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    task = job.Job(
        program=Path(program), machine=on, out=Path(), tip_tolerance=tip, axis_tolerance=axis,
        effort=arguments.effort_named(effort), feed=arguments.feed_asked(feed), dialect=dialect, options=how,
    )  # fmt: skip
    picture = arguments.file_for_result("--out", out)
    return run_tolerance(task, within, picture, Steps(new_console()))


class Cost(NamedTuple):
    """How long a program takes within a tolerance of the tip."""

    tip_tolerance: float
    """[m]"""
    duration: float
    """[s]"""


def costs(task: Job, tolerances: Sequence[float], steps: Steps) -> list[Cost]:
    """The duration within each of the ascending tolerances [m]. Raises ToolpaceError.

    A path within a tolerance is one within a wider, which takes it where it finds no faster one.
    """
    from toolpace.common.workers import Progress
    from toolpace.jobs import job
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.program_plan import plan_program
    from toolpace.programs.reading.setup_file import with_cure_of_zero

    task = job.loaded(task)
    job.warm_up(steps)
    toolpath = job.read_program(task, steps)
    found: list[Cost] = []
    for k, tip in enumerate(tolerances):
        with with_cure_of_zero(toolpath.assumed), steps.step("planning") as step:
            planned = plan_program(
                toolpath, task.machine, tip, task.axis_tolerance, effort=task.effort, planner=Optimal(bound=False),
                progress=Progress(step).part(k / len(tolerances), (k + 1) / len(tolerances)),
            )  # fmt: skip
            duration = min([planned.trajectory.duration, *(each.duration for each in found)])
            step.note = f"within {format_length(tip)}: {format_time(duration)}"
        found.append(Cost(tip, duration))
    return found


def apart(tolerances: Sequence[float], usual: float) -> list[float]:
    """The tolerances [m] in ascending order, the usual one among them, each length once."""
    found = [usual]
    for tip in tolerances:
        if all(abs(tip - other) >= ONE_LENGTH for other in found):
            found.append(tip)
    return sorted(found)


def show_costs(console: Console, usual: float, found: Sequence[Cost]) -> None:
    """A row a tolerance: the duration, and what it takes beside the usual one [m] and the one before it."""
    table = new_table(("tip within", "duration", f"against {format_length(usual)}", "saved by 1 µm more"), left=())
    beside = next(each.duration for each in found if each.tip_tolerance == usual)
    for k, each in enumerate(found):
        gain = ""
        if k + 1 < len(found):
            wider = found[k + 1]
            gain = format_time((each.duration - wider.duration) / (wider.tip_tolerance - each.tip_tolerance) * 1e-6)
        table.add_row(
            format_length(each.tip_tolerance), format_time(each.duration),
            f"{100.0 * (each.duration / beside - 1.0):+.2f} %", gain,
        )  # fmt: skip
    console.print()
    console.print(table)


def run_tolerance(task: Job, tolerances: Sequence[float], picture: Path | None, steps: Steps) -> int:
    """Plan a program within each tolerance, that of the job among them, and show what they cost."""
    from toolpace.common.files import whole_file

    assert isinstance(task.tip_tolerance, float)
    within = apart(tolerances, task.tip_tolerance)
    found = costs(replace(task, report=False), within, steps)
    show_costs(steps.console, task.tip_tolerance, found)
    if picture is not None:
        with whole_file(picture) as temporary:
            temporary.write_text(drawn(found, task.program.name), encoding="utf-8")
        steps.console.print(f"written   {picture}", soft_wrap=True)
    return 0


def drawn(found: Sequence[tuple[float, float]], program: str) -> str:
    """The picture (SVG) of pairs of tolerance [m], ascending, and duration [s]."""
    from toolpace.study.svg import INK, SOFT, Drawing

    picture = Drawing(WIDTH, HEIGHT, f"{program}: duration over tolerance of the tip")
    low, high = (math.log(found[k][0]) for k in (0, -1))
    marks = round_values(min(each[1] for each in found), max(each[1] for each in found))

    def at(tolerance: float, duration: float) -> tuple[float, float]:
        across = (math.log(tolerance) - low) / ((high - low) or 1.0)
        up = (duration - marks[0]) / (marks[-1] - marks[0])
        return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    for mark in marks:
        foot, end = at(found[0][0], mark), at(found[-1][0], mark)
        picture.line([foot, end], "#e4e8ee", 1.0)
        picture.words(foot, f"{mark:.6g} s", SOFT, off=(-8.0, 4.0), anchor="end", size=12)
    points = [at(*each) for each in found]
    picture.line(points, LINE, 2.0)
    for (tolerance, _), point in zip(found, points):
        picture.circle(point, 3.5, LINE, "#ffffff")
        picture.words(
            (point[0], HEIGHT - BOTTOM), format_length(tolerance), SOFT, off=(0.0, 20.0), anchor="middle", size=12
        )
    picture.words((LEFT, TOP), f"{program}: what a micrometre costs", INK, off=(0.0, -24.0), size=15, bold=True)
    picture.words((WIDTH - RIGHT, HEIGHT), "tolerance of the tip", SOFT, off=(0.0, -12.0), anchor="end", size=12)
    return picture.svg()


def round_values(low: float, high: float) -> list[float]:
    """Round values, evenly apart, from at most `low` to at least `high`."""
    span = max(high - low, 1e-3 * high)
    rough = span / LINES
    size = 10.0 ** math.floor(math.log10(rough))
    step = next(size * k for k in (1.0, 2.0, 5.0, 10.0) if size * k >= rough)
    first, last = math.floor(low / step), math.ceil(high / step)
    return [step * k for k in range(first, max(last, first + 1) + 1)]

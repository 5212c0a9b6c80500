"""The command `tolerance`: the duration of a program over the tolerance of its tip, as a table, a picture and plans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
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
Plans = Annotated[
    str | None,
    Parameter(name="--plans", help="Write each plan, verified and with its report, and a page of them into a folder."),
]
PAGE, COMPARED = "tolerance.html", "compared.html"
"""Names of the pages in that folder: of the costs, and of the plans side by side."""
STYLE = """
main svg { max-width: 100%; height: auto; } main svg text { fill: var(--soft); }
main svg polyline[stroke="#e4e8ee"] { stroke: var(--line); } tr.usual td { font-weight: 640; }
"""
HEADINGS = ("Tip within", "Time", "Against {}", "Saved by 1 µm more")
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
    plans: Plans = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Show what a micrometre costs: the duration of a program over the tolerance of its tip.

    The program is planned within each tolerance. The times are compared with that
    of --tip-tolerance. With --plans each of them is verified and written, and a page
    plays them together.

    For example:

        toolpace tolerance part.ngc -m xyzac-trunnion
        toolpace tolerance part.ngc -m xyzbc-head --tips 2um,5um,20um --out costs.svg
        toolpace tolerance part.ngc -m my-mill.toml --plans part-tolerances
    """
    from toolpace.cli import arguments
    from toolpace.jobs import job

    tip, axis = arguments.even_tolerances(tolerances)
    within = arguments.tip_tolerances(tips)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    task = job.Job(
        program=Path(program), machine=on, out=Path(), tip_tolerance=tip, axis_tolerance=axis,
        effort=arguments.effort_named(effort), feed=arguments.feed_option(feed), dialect=dialect, options=how,
    )  # fmt: skip
    picture = arguments.file_for_result("--out", out)
    folder = None if plans is None else arguments.folder_for_results(plans, "--plans")
    return run_tolerance(task, within, picture, Steps(new_console()), folder)


class Cost(NamedTuple):
    """How long a program takes within a tolerance of the tip."""

    tip_tolerance: float
    """[m]"""
    duration: float
    """[s]"""
    plan: str = ""
    """Its folder beside the page; empty where it was not written."""


def costs(task: Job, tolerances: Sequence[float], steps: Steps) -> list[Cost]:
    """The duration within each of the ascending tolerances [m]. Raises ToolpaceError.

    A path within a tolerance is one within a wider, which takes it where it finds no faster one.
    """
    from toolpace.common.workers import Progress
    from toolpace.jobs import job, plan_steps
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.program_plan import plan_program
    from toolpace.programs.reading.setup_file import with_cure_of_zero

    task = job.loaded(task)
    plan_steps.warm_up(steps)
    toolpath = plan_steps.read_program(task, steps)
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
    for each, gain in zip(found, saved_by_a_micrometre(found)):
        table.add_row(
            format_length(each.tip_tolerance), format_time(each.duration),
            f"{100.0 * (each.duration / beside - 1.0):+.2f} %", gain,
        )  # fmt: skip
    console.print()
    console.print(table)


def run_tolerance(
    task: Job, tolerances: Sequence[float], picture: Path | None, steps: Steps, plans: Path | None = None
) -> int:
    """Plan a program within each tolerance, that of the job among them, and show what they cost."""
    from toolpace.common.files import write_text

    assert isinstance(task.tip_tolerance, float)
    within, code = apart(tolerances, task.tip_tolerance), 0
    if plans is None:
        found = costs(replace(task, report=False), within, steps)
    else:
        found, code = written_costs(task, within, plans, steps)
    show_costs(steps.console, task.tip_tolerance, found)
    if picture is not None:
        write_text(picture, drawn(found, task.program.name))
        steps.console.print(f"written   {picture}", soft_wrap=True)
    if plans is not None:
        write_pages(plans, task, found)
        steps.console.print(f"written   {plans}: {PAGE}, and a plan for each tolerance", soft_wrap=True)
    return code


def written_costs(task: Job, tolerances: Sequence[float], folder: Path, steps: Steps) -> tuple[list[Cost], int]:
    """Plan in full within each tolerance [m], and write each plan; the durations, and the exit code of the worst."""
    from toolpace.jobs import job, plan_steps

    task, found, codes = job.loaded(task), [], []
    for tip in tolerances:
        name = f"{tip * 1e6:.6g}um"
        steps.console.print(f"\nwithin {format_length(tip)}")
        record, verification = plan_steps.carry_out(
            replace(task, tip_tolerance=tip, out=folder / name), Steps(steps.console)
        )
        found.append(Cost(tip, record.duration_s, name))
        codes.append(plan_steps.exit_code(record, verification))
    return found, max(codes)


def write_pages(folder: Path, task: Job, found: Sequence[Cost]) -> None:
    """Write the page of the costs, and that of the plans side by side where they are few enough."""
    from toolpace.common.files import write_text
    from toolpace.results.compare.page import comparison_page
    from toolpace.results.compare.plans import MOST, compared

    # the usual one first: the others are compared with it
    usual = sorted(found, key=lambda each: each.tip_tolerance != task.tip_tolerance)
    several = 1 < len(found) <= MOST
    if several:
        write_text(folder / COMPARED, comparison_page(compared([folder / each.plan for each in usual])))
    write_text(folder / PAGE, tolerance_page(folder, task.program.name, task.machine.name, found, usual[0]))


def tolerance_page(folder: Path, program: str, machine: str, found: Sequence[Cost], usual: Cost) -> str:
    """The whole HTML text; rows lead to the reports that are in the folder."""
    from html import escape
    from urllib.parse import quote

    from toolpace.common import __version__
    from toolpace.results.report import shell

    def linked(text: str, file: str) -> str:
        return f'<a href="{escape(quote(file))}">{text}</a>' if (folder / file).is_file() else text

    gains = saved_by_a_micrometre(found)
    rows = "".join(
        f'<tr{" class=usual" if each == usual else ""}>'
        f"<td>{linked(format_length(each.tip_tolerance), f'{each.plan}/report.html')}</td>"
        f"<td class=n>{format_time(each.duration)}</td>"
        f"<td class=n>{100.0 * (each.duration / usual.duration - 1.0):+.2f} %</td><td class=n>{gain}</td></tr>"
        for each, gain in zip(found, gains)
    )
    names = (name.format(format_length(usual.tip_tolerance)) for name in HEADINGS)
    head = "".join(f"<th{' class=n' if k else ''}>{name}</th>" for k, name in enumerate(names))
    best, worst = min(found, key=lambda each: each.duration), max(found, key=lambda each: each.duration)
    figures = [
        ("Time", format_time(usual.duration), f"within {format_length(usual.tip_tolerance)}", "big"),
        ("Fastest", format_time(best.duration), f"within {format_length(best.tip_tolerance)}", ""),
        ("Slowest", format_time(worst.duration), f"within {format_length(worst.tip_tolerance)}", ""),
    ]
    together = linked("All of them together, place by place", COMPARED) if (folder / COMPARED).is_file() else ""
    body = (
        f"<header><div><h1>{escape(program)}</h1><p>what a micrometre costs on <b>{escape(machine)}</b></p></div>"
        f'<div class="ends">{shell.THEME_BUTTON}</div></header><main><section class="cards">{shell.cards(figures)}'
        f'</section><section class="panel"><div class="bar-title"><h2>Plans</h2><p class="hint">{together}</p></div>'
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div></section>'
        f'<section class="panel"><h2>Time over tolerance</h2>{drawn(found, program)}</section></main>'
        f"<footer>toolpace {escape(__version__)}</footer>"
    )
    return shell.framed(f"{program}: what a micrometre costs", body, STYLE)


def saved_by_a_micrometre(found: Sequence[Cost]) -> list[str]:
    """Of each tolerance what one micrometre more saves, up to the next one."""
    gains = [
        format_time((each.duration - wider.duration) / (wider.tip_tolerance - each.tip_tolerance) * 1e-6)
        for each, wider in pairwise(found)
    ]
    return [*gains, ""]


def drawn(found: Sequence[Cost], program: str) -> str:
    """The picture (SVG) of tolerances, ascending, and durations."""
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
    points = [at(each[0], each[1]) for each in found]
    picture.line(points, LINE, 2.0)
    for (tolerance, *_), point in zip(found, points):
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

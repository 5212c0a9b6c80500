"""The command `time`: the time of programs on a control, as a page, a table or JSON, and its figures from a log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from toolpace.cli.console import (
    LONGEST_NAME,
    Steps,
    cells,
    named_error,
    new_console,
    new_table,
    print_json,
    short_names,
)
from toolpace.cli.summary import cut_in_words
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import format_length, format_time
from toolpace.jobs.timed import KINDS, Timed, TimeRequest, optimum_of_parts, time_record, timed, timed_or_wrong

if TYPE_CHECKING:
    from toolpace.controls.fitting.least_squares import Fit
    from toolpace.controls.timing.figures import ControlFigures
    from toolpace.controls.timing.program_time import ProgramTime
    from toolpace.programs.reading import Controller

MODELS = {
    "linuxcnc": "its own planner, cycle by cycle",
    "sinumerik": "SOFT or BRISK, corners rounded in three phases within a tolerance",
    "heidenhain": "jerk of axes and path, positions filtered, corners as slow as the filter's error asks for",
    "fanuc": "differences of feed and acceleration at corners, by its parameters",
    "lookahead": "corners rounded within a tolerance, limits of the axes and their jerk",
    "ideal": "the fastest motion within the limits of the axes",
}
"""What each model of a control does, in words."""
FASTER = "the control exceeds limits of joints, or of jerk, that the optimum keeps"
NOT_LEAST = "no limit is seen to be exceeded: the path of the plan is not the fastest within the tolerance"
"""Where an optimum takes longer than the control does, why."""
MOST_PARTS = 60
"""Operations that a page lists."""
POOR = 0.05
"""Share of the duration by which the model may be off on the way; beyond, another model fits better."""


def run_time(programs: Sequence[str], request: TimeRequest, as_json: bool) -> int:
    """Time each program and print what was found; 0 where all could be, else 2. A single one raises ToolpaceError."""
    console = new_console()
    # what is under way is shown beside JSON, too, but not among it
    place = Console(stderr=True, highlight=False, markup=False) if as_json else console
    alone = len(programs) == 1 and not as_json
    found: list[Timed] = []
    for program in programs:
        # as in `cut`, the stock that one program leaves is that of the next
        stock = found[-1].left if found else None
        work = timed if alone else timed_or_wrong
        found.append(work(program, request, Steps(place), stock=stock))
    if as_json:
        print_json([time_record(each, request.machine.name) for each in found])
    else:
        show(console, found, request.machine.name)
    return 2 if any(each.error for each in found) else 0


def show(console: Console, found: Sequence[Timed], machine: str) -> None:
    """A page of one program; of many a table, and below it what is wrong."""
    if len(found) == 1:
        _show_page(console, found[0], machine)
    else:
        _show_table(console, found)
    for each in found:
        if each.error:
            console.print(
                Text(printable(named_error(each.program, each.error) if len(found) > 1 else each.error)), soft_wrap=True
            )


def _show_page(console: Console, found: Timed, machine: str) -> None:
    time = found.time
    if time is None:
        return
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    rows = [
        ("program", f"{found.program}, {found.blocks} blocks"),
        ("machine", machine),
        ("control", f"{found.control or 'none named'}; model {found.model}: {MODELS[found.model]}"),
        ("time", format_time(time.total)),
        *_range(time),
        *((kind.replace("_", " "), format_time(time.sum(kind))) for kind in KINDS if time.sum(kind) > 0.0),
    ]
    if found.cut is not None:
        rows += [("at feed" if k == 0 else "", line) for k, line in enumerate(cut_in_words(found.cut))]
    rows.append(("tolerance", _tolerance(found)))
    if found.optimum is not None:
        rows.append(("optimum", f"{format_time(found.optimum)}, {_saving(time, found.optimum)}"))
    rows += [("exceeds" if k == 0 else "", str(each)) for k, each in enumerate(time.exceeded)]
    if found.optimum_likewise is not None:
        likewise = f"{format_time(found.optimum_likewise)}, {_saving(time, found.optimum_likewise)}"
        rows.append(("likewise", f"{likewise}: the optimum with these limits exceeded as far"))
    rows += [("assumed" if k == 0 else "", sentence) for k, sentence in enumerate(found.assumed)]
    for name, text in rows:
        grid.add_row(name, Text(printable(text), style="bold" if name == "time" else ""))
    console.print(grid)
    if len(time.parts) > 1:
        _show_parts(console, found)


def _range(time: ProgramTime) -> list[tuple[str, str]]:
    """Between which times, and from what: none of the optimum, nor where no figure of the control matters."""
    found = time.range
    if found is None or not found.most > found.least:
        return []
    between = f"{format_time(found.least)} to {format_time(found.most)} ({_percents(time)})"
    between += " with all figures off at once"
    return [("range", f"{between}, mostly from {found.mostly}" if found.mostly else between)]


def _percents(time: ProgramTime) -> str:
    """By how much less or more it may be."""
    if time.range is None:
        return "-"
    ends = time.range.least, time.range.most
    return " to ".join(f"{100.0 * (end / time.total - 1.0):+.1f} %" for end in ends)


def _show_parts(console: Console, found: Timed) -> None:
    assert found.time is not None
    best = optimum_of_parts(found)
    headings = ["operation", "tool", "time", "cutting", "rapid", "dwell", "tool change", "rests"]
    table = new_table([*headings, *(["optimum"] if found.best else [])], left=("operation", "tool"))
    for part, least in list(zip(found.time.parts, best))[:MOST_PARTS]:
        times = (part.time, part.cutting, part.rapid, part.dwell, part.tool_change)
        words = [part.name or "-", part.tool or "-", *(format_time(each) if each else "-" for each in times)]
        words.append(str(part.rests))
        if found.best:
            words.append("-" if least is None else format_time(least + part.tool_change))
        table.add_row(*cells(words))
    console.print(table)
    if len(found.time.parts) > MOST_PARTS:
        console.print(f"and {len(found.time.parts) - MOST_PARTS} more operations: --json has all")


def _show_table(console: Console, found: Sequence[Timed]) -> None:
    planned = [(each.time, each.optimum) for each in found if each.time is not None and each.optimum is not None]
    both = [(time.total, optimum) for time, optimum in planned]
    headings = ["program", "control", "model", "time", "range", "cutting", "rapid"]
    apart = any(each.cut is not None for each in found)
    headings += ["in air"] if apart else []
    headings += ["optimum", "saving"] if both else []
    table = new_table(headings, left=("program", "control", "model"))
    for column in table.columns:
        column.no_wrap = column.justify == "right"
    names = short_names([each.program for each in found])
    table.columns[0].no_wrap = max(map(len, names)) <= LONGEST_NAME
    for name, each in zip(names, found):
        if each.time is None:
            table.add_row(Text(printable(name), style="red"), *["-"] * (len(headings) - 1))
            continue
        time = each.time
        parts = [format_time(seconds) for seconds in (time.sum("cutting"), time.sum("rapid"))]
        times = [format_time(time.total), _percents(time), *parts]
        times += ["-" if each.cut is None else format_time(each.cut.air_s)] if apart else []
        words = [name, each.control or "-", each.model, *times, *(_optimum(time.total, each.optimum) if both else ())]
        table.add_row(*cells(words))
    if len(both) > 1:
        total, optimum = (sum(column) for column in zip(*both))
        table.add_section()
        sums = [format_time(total), *[""] * (3 + apart), *_optimum(total, optimum)]
        table.add_row("all with an optimum", "", "", *sums)
    console.print(table)
    reasons = {FASTER if time.exceeded else NOT_LEAST for time, optimum in planned if optimum > time.total}
    for reason in sorted(reasons):
        console.print(f"saving below zero: {reason}", soft_wrap=True)


def _tolerance(found: Timed) -> str:
    """Within which tolerance of the tip the control goes."""
    told = found.program_tolerance
    if found.model == "fanuc":
        own = "none of the control's own: its parameters say how far corners are rounded"
    elif found.model_tolerance is None:
        own = "the control's own"
    else:
        own = format_length(found.model_tolerance)
    if told is None:
        return f"the program asks for none; {own}"
    least, most = map(format_length, told)
    wanted = least if least == most else f"{least} to {most}"
    return f"{wanted}, as the program asks for" + (f"; {own}" if found.model == "fanuc" else "")


def _optimum(total: float, optimum: float | None) -> tuple[str, str]:
    return ("-", "-") if optimum is None else (format_time(optimum), f"{100.0 * (1.0 - optimum / total):.1f} %")


def _saving(time: ProgramTime, optimum: float) -> str:
    """How much less the optimum takes."""
    share = 1.0 - optimum / time.total
    if share >= 0.0:
        return f"{100.0 * share:.1f} % less"
    return f"{-100.0 * share:.1f} % more: {FASTER if time.exceeded else NOT_LEAST}"


def run_fit(programs: list[str], measured: str, request: TimeRequest, write: str | None) -> int:
    """Find the figures from what was measured of one program, and print them. Raises ToolpaceError."""
    from toolpace.cli import arguments
    from toolpace.common.files import write_text
    from toolpace.controls.fitting.fit import fit_measured
    from toolpace.controls.timing.program_time import figures_for, moves_of
    from toolpace.programs.reading import Source
    from toolpace.programs.reading.languages import with_controller

    if len(programs) != 1:
        raise UsageError(f"--fit {measured}: is measured of one program; give that program alone")
    target = arguments.file_for_result("--write-controller", write)
    source = Source.load(programs[0])
    options, found = with_controller(source, request.dialect, request.options)
    figures = figures_for(options, request.model)
    if figures.model == "ideal":
        raise UsageError("--fit: the model ideal has no figures; choose another --model")
    console = new_console()
    steps = Steps(console)
    with steps.step("reading") as step:
        moves = moves_of(source, request.machine, options, request.feed, request.dialect)
        step.note = f"{programs[0]}: {len(moves)} moves"
    with steps.step("fitting"):
        fitted = fit_measured(measured, moves, request.machine, figures, options.setup.tool_change)
    _say(steps, fitted)
    # whoever takes the file later has not seen what was printed here
    text = "".join(f"# in doubt: {printable(each)}\n" for each in fitted.doubts)
    text += controller_text(found.controller, fitted.figures, target.stem if target is not None else "")
    if target is None:
        console.print(Text(text), soft_wrap=True)
    else:
        write_text(target, text)
        console.print(Text(printable(f"controller's file: {target}; give it with --controller")), soft_wrap=True)
    return 0


def _say(steps: Steps, found: Fit) -> None:
    steps.say(f"measured {format_time(found.measured)}, the model takes {format_time(found.modelled)}")
    steps.say(f"on the way they differ by {format_time(found.misfit)} (root mean square)")
    for each in found.fitted:
        steps.say(str(each))
    for doubt in found.doubts:
        steps.say(f"in doubt: {doubt}")
    if not found.fitted:
        steps.say("the measured times tell of no figure more than was known")
    if found.misfit > POOR * found.measured:
        steps.say("that is a lot: was it measured of this program? Does another --model fit better?")


def controller_text(controller: Controller | None, figures: ControlFigures, name: str) -> str:
    """The text of a controller's file that is like another, with these figures."""
    import msgspec

    from toolpace.common.files.toml import toml_text

    table = msgspec.to_builtins(figures)
    usual = msgspec.to_builtins(type(figures)())
    time = {key: _changed(value, usual[key]) for key, value in table.items() if key == "model" or value != usual[key]}
    head: dict[str, object] = {} if controller is None else {"name": name or f"my-{controller.name}"}
    if controller is not None:
        base = controller.like or controller.name
        head["like"] = base if base in controller.names() else ""
    return toml_text(head | {"time": {key: _rounded(value) for key, value in time.items()}})


def _changed(value: object, usual: object) -> object:
    """Of a maker's table the figures that differ from the usual ones."""
    if isinstance(value, dict) and isinstance(usual, dict):
        return {key: each for key, each in value.items() if each != usual.get(key)}
    return value


def _rounded(value: object) -> object:
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return float(f"{value:.5g}") if isinstance(value, float) else value

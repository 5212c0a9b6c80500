"""The display of the command `time`: page, table, or JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.table import Table
from rich.text import Text

from toolpace.cli.names import named_error, short_names
from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.jobs.timed import KINDS, time_record

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.jobs.timed import Timed

MODELS = {
    "linuxcnc": "its own planner, cycle by cycle",
    "lookahead": "corners rounded within a tolerance, limits of the axes, blocks looked ahead",
    "fir": "pulses of velocity through moving averages, corners blended by overlap",
    "ideal": "the fastest motion within the limits of the axes",
}
"""What each model of a control does, in words."""
FASTER = "the control exceeds limits of joints, or of jerk, that the optimum keeps"
LONGEST_NAME = 40
"""Most characters of a program's name that a table does not break."""
MOST_PARTS = 60
"""Operations that a page lists."""


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
        *((kind.replace("_", " "), format_time(time.sum(kind))) for kind in KINDS if time.sum(kind) > 0.0),
    ]
    if found.optimum is not None:
        rows.append(("optimum", f"{format_time(found.optimum)}, {_saving(time.total, found.optimum)}"))
    rows += [("assumed" if k == 0 else "", sentence) for k, sentence in enumerate(found.assumed)]
    for name, text in rows:
        grid.add_row(name, Text(printable(text), style="bold" if name == "time" else ""))
    console.print(grid)
    if len(time.parts) > 1:
        _show_parts(console, found)


def _show_parts(console: Console, found: Timed) -> None:
    assert found.time is not None
    table = Table(box=SIMPLE, pad_edge=False)
    best = {(each.name, each.tool): each.time for each in found.best}
    headings = ["operation", "tool", "time", "cutting", "rapid", "dwell", "tool change", "rests"]
    for heading in [*headings, *(["optimum"] if best else [])]:
        table.add_column(heading, justify="left" if heading in ("operation", "tool") else "right", overflow="fold")
    for part in found.time.parts[:MOST_PARTS]:
        times = (part.time, part.cutting, part.rapid, part.dwell, part.tool_change)
        cells = [part.name or "-", part.tool or "-", *(format_time(each) if each else "-" for each in times)]
        cells.append(str(part.rests))
        if best:
            least = best.get((part.name, part.tool))
            cells.append("-" if least is None else format_time(least + part.tool_change))
        table.add_row(*(Text(printable(cell)) for cell in cells))
    console.print(table)
    if len(found.time.parts) > MOST_PARTS:
        console.print(f"and {len(found.time.parts) - MOST_PARTS} more operations: --json has all")


def _show_table(console: Console, found: Sequence[Timed]) -> None:
    known = [(each.time.total, each.optimum) for each in found if each.time is not None and each.optimum is not None]
    headings = ["program", "control", "model", "time", "cutting", "rapid", *(["optimum", "saving"] if known else [])]
    table = Table(box=SIMPLE, pad_edge=False)
    for heading in headings:
        left = heading in ("program", "control", "model")
        table.add_column(heading, justify="left" if left else "right", overflow="fold", no_wrap=not left)
    names = short_names([each.program for each in found])
    table.columns[0].no_wrap = max(map(len, names)) <= LONGEST_NAME
    for name, each in zip(names, found):
        if each.time is None:
            table.add_row(Text(printable(name), style="red"), *["-"] * (len(headings) - 1))
            continue
        time = each.time
        times = [format_time(seconds) for seconds in (time.total, time.sum("cutting"), time.sum("rapid"))]
        cells = [name, each.control or "-", each.model, *times, *(_optimum(time.total, each.optimum) if known else ())]
        table.add_row(*(Text(printable(cell)) for cell in cells))
    if len(known) > 1:
        total, optimum = (sum(column) for column in zip(*known))
        table.add_section()
        table.add_row("all with an optimum", "", "", format_time(total), "", "", *_optimum(total, optimum))
    console.print(table)
    if any(optimum > total for total, optimum in known):
        console.print(f"saving below zero: {FASTER}", soft_wrap=True)


def _optimum(total: float, optimum: float | None) -> tuple[str, str]:
    return ("-", "-") if optimum is None else (format_time(optimum), f"{100.0 * (1.0 - optimum / total):.1f} %")


def _saving(total: float, optimum: float) -> str:
    """How much less the optimum takes."""
    share = 1.0 - optimum / total
    if share >= 0.0:
        return f"{100.0 * share:.1f} % less"
    return f"{-100.0 * share:.1f} % more: {FASTER}"


def print_json(found: Sequence[Timed], machine: str) -> None:
    """The JSON list: times in seconds."""
    import msgspec

    records = [time_record(each, machine) for each in found]
    print(msgspec.json.format(msgspec.json.encode(records), indent=2).decode())

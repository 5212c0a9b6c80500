"""The command `inspect`: a page of each program, or a table of many, and a set-up sheet to fill in."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from toolpace.cli.console import LONGEST_NAME, cells, new_console, new_table, print_json, short_names
from toolpace.common.errors import ToolpaceError, printable
from toolpace.common.files import write_text
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.jobs.inspection import follow_as_planned, inspection_record, sheet_to_fill_in
from toolpace.programs.reading.inspection import Inspection, Range, inspect_source, unreadable
from toolpace.programs.reading.source import Source

if TYPE_CHECKING:
    from toolpace.cli.options import Reading
    from toolpace.machine.machine import Machine

NAMED = 3
"""Most machines that a table names."""
SHOWN = 40
"""Most names of ignored words, tools and assumptions on a page; JSON has all."""
NO_MACHINE = "none of the machines that were tried can run it; inspect it alone to see why"


def run_inspect(
    programs: Sequence[str],
    machine: str | None,
    dialect: str | None,
    feed: str | None,
    as_json: bool,
    write_setup: str | None,
    reading: Reading,
) -> int:
    """Inspect each program and print what was found; 0 where nothing is refused, else 2."""
    from toolpace.cli import arguments

    arguments.feed_option(feed)
    sheet = arguments.file_for_result("--write-setup", write_setup)
    machines = _machines(machine, reading)
    options = reading.options(machines[0] if machine is not None else None)
    found = []
    for program in programs:
        try:
            source = Source.load(program)
        except ToolpaceError as error:
            found.append(unreadable(program, error))
            continue
        found.append(inspect_source(source, options, machines, dialect, feed, follow_as_planned))
    if as_json:
        print_json([inspection_record(each) for each in found])
    else:
        show(new_console(), found)
    if sheet is not None:
        write_text(sheet, sheet_to_fill_in(found, machines, lambda machine: reading.options(machine).setup))
        if not as_json:
            print(f"set-up sheet to fill in: {printable(str(sheet))}")
    return 2 if any(each.refused for each in found) else 0


def _machines(name: str | None, reading: Reading) -> list[Machine]:
    """The machine that is named, else all built-in ones, with the part clamped as the set-up sheet says."""
    from toolpace.cli import arguments
    from toolpace.machine.machine import Machine

    names = Machine.names() if name is None else (name,)
    return [arguments.machine_with_setup(Machine.load(each), reading)[0] for each in names]


def show(console: Console, found: Sequence[Inspection]) -> None:
    """A page of one program; of many a table, and below it what is refused."""
    if len(found) == 1:
        console.print(page(found[0]))
        return
    headings = ("program", "dialect", "blocks", "five-axis", "refused", "assumed", "runs on")
    table = new_table(headings, left=("program", "dialect", "runs on"))
    names = short_names([each.program for each in found])
    table.columns[0].no_wrap = max(map(len, names)) <= LONGEST_NAME
    for name, each in zip(names, found):
        words = (
            name, each.dialect or "?", str(each.blocks), str(each.five_axis_blocks), str(len(each.refused)),
            str(len(each.assumed)), _machines_in_words(each),
        )  # fmt: skip
        table.add_row(*cells(words, "red" if each.refused else ""))
    console.print(table)
    for name, each in zip(names, found):
        for refusal in each.refused:
            console.print(Text(printable(f"{name}: {refusal}")), soft_wrap=True)
        for need in each.needs:
            console.print(Text(printable(f"{name}: needs: {need}")), soft_wrap=True)
        if each.tip is not None and each.not_on and not each.machines:
            console.print(Text(printable(f"{name}: {NO_MACHINE}")), soft_wrap=True)


def _machines_in_words(found: Inspection) -> str:
    """The machines that can run it: few by name, many by their number."""
    most = len(found.machines) + len(found.not_on)
    if found.tip is None and found.refused:
        return "not read whole: see below"
    if len(found.machines) <= NAMED:
        return ", ".join(found.machines) or "none"
    return f"{len(found.machines)} of {most} machines"


def page(found: Inspection) -> Table:
    """What a machinist wants to know of one program."""
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    rows = [
        ("program", [found.program]),
        ("dialect", [f"{found.dialect or 'not known'}" + (f": {found.reason}" if found.reason else "")]),
        ("blocks", [f"{found.blocks}, of them {found.five_axis_blocks} turn the tool"]),
    ]
    if found.tip is not None:
        counts = [f"{found.rapids} blocks with rapids", counted(found.arcs, "arc"), counted(found.stops, "stop")]
        counts.append(counted(found.dwells, "dwell") + (f" ({format_time(found.dwell_s)})" if found.dwells else ""))
        rows.append(("", [", ".join(counts)]))
        rows.append(("tools", [_some(found.tools) or "none named"]))
        extent = [f"{axis} {_mm(each)}" for axis, each in zip("XYZ", found.tip)]
        rows.append(("tip", [", ".join(extent)]))
    if found.tilt is not None:
        turned = [f"{name} {_deg(each)}" for name, each in found.rotary.items()]
        rows.append(("tilt", [", ".join([f"{_deg(found.tilt)} from Z", *turned])]))
    ignored = [f"{word} {count}" for word, count in sorted(found.ignored.items(), key=lambda item: -item[1])]
    rows.append(("ignored", [_some(ignored) or "nothing"]))
    rows.append(("refused", [str(each) for each in found.refused] or ["nothing: every word is read"]))
    rows += [("needs", list(found.needs))] if found.needs else []
    rows.append(("assumed", list(found.assumed[:SHOWN]) or ["nothing"]))
    rows.append(("runs on", [", ".join(found.machines) or "none of the machines that were tried"]))
    reasons, cures = _why_not(found.not_on)
    rows += [("not on", reasons), ("cures", cures)]
    for name, lines in rows:
        for k, line in enumerate(lines):
            style = "bold red" if name == "refused" and found.refused else ""
            grid.add_row(name if k == 0 else "", Text(printable(line), style=style))
    return grid


def _why_not(not_on: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Why machines cannot run a program, those with one reason together; and what to do about it, each once."""
    alike: dict[str, list[str]] = {}
    cures: dict[str, None] = {}
    for name, why in not_on.items():
        reason, _, cure = why.rpartition("; ")
        alike.setdefault(reason or cure, []).append(name)
        if reason:
            cures[cure] = None
    return [f"{', '.join(names)}: {reason}" for reason, names in alike.items()], list(cures)


def _some(words: Iterable[str]) -> str:
    words = list(words)
    more = f", and {len(words) - SHOWN} more" if len(words) > SHOWN else ""
    return ", ".join(words[:SHOWN]) + more


def _mm(each: Range) -> str:
    return f"{each[0] * 1e3:.3f} to {each[1] * 1e3:.3f} mm"


def _deg(each: Range) -> str:
    return f"{math.degrees(each[0]):.3f} to {math.degrees(each[1]):.3f} deg"

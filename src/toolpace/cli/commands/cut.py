"""The command `cut`: what programs cut, as a page of tables, JSON, and a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.text import Text

from toolpace.cli import options
from toolpace.cli.console import Steps, cells, new_console, new_table, print_json
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import MILLIMETRE, format_length, format_time, parse_length

if TYPE_CHECKING:
    from toolpace.cutting.simulation.findings import Finding
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.jobs.cut import ProgramCut

FINEST, COARSEST = 1e-6, 20e-3
"""Resolutions that are taken [m]."""
MEMORY = "1GB"
SIZES = {"GB": 1e9, "MB": 1e6, "GiB": 2.0**30, "MiB": 2.0**20}
SHOWN = 12
"""Findings of a program that are listed."""
WORTH = 0.5
"""Feed in air that is listed takes so long at least [s]."""
Resolution = Annotated[
    str | None,
    Parameter(
        help="Size of a cell of the stock, from 1um to 20mm, such as 0.05mm. By default 500 cells along its longest "
        "side, or as many as --memory has room for."
    ),
]
Memory = Annotated[str, Parameter(help="Most memory that the stock may take: 500MB, 2GB.")]
Out = Annotated[
    str | None,
    Parameter(
        name=["--out", "-o"],
        help="Folder for engagement (Parquet), the stock after each operation (STL), figures (cut.json) and a page.",
    ),
]


def cut_command(
    programs: options.Programs,
    /,
    *,
    machine: options.MachineName = None,
    resolution: Resolution = None,
    memory: Memory = MEMORY,
    tolerances: options.Tolerances = options.TIGHTER_TOLERANCES,
    effort: options.Effort = "normal",
    feed: options.Feed = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    json: options.Json = False,
    out: Out = None,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Show what programs cut: time in air and in material, volume, what is left, and collisions.

    Stock and tools are those of the set-up sheet ([stock], [tools]). Each program is
    planned as `plan` does, and cut along that motion. The stock that one program
    leaves is the stock of the next. Without a stock, the box around all cutting moves
    stands in: that is marked, and nothing is concluded from it. Exit code 1 for a
    collision: a rapid, a shank or a holder in material, a gouge, a cut above the flutes.

    For example:

        toolpace cut part.ngc -m xyzac-trunnion --setup setup.toml
        toolpace cut first.nc second.nc -m my-mill.toml --setup setup.toml --resolution 0.1mm
        toolpace cut part.ngc -m xyzac-trunnion --setup setup.toml --json
        toolpace cut part.ngc -m xyzac-trunnion --setup setup.toml --out part-cut
    """
    from toolpace.cli import arguments
    from toolpace.jobs.cut import CutRequest, cut_programs
    from toolpace.results.cut.folder import CutFolder, written_in

    tip, axis = arguments.tolerances(tolerances)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    request = CutRequest(
        machine=on,
        options=how,
        tip_tolerance=tip,
        axis_tolerance=axis,
        effort=arguments.effort_named(effort),
        feed=arguments.feed_option(feed),
        dialect=dialect,
        resolution=None if resolution is None else cell(resolution),
        memory=size(memory),
    )
    console = new_console()
    steps = Steps(Console(stderr=True, highlight=False, markup=False) if json else console)
    if out is None:
        found = cut_programs(programs, request, steps)
        written: list[str] = []
    else:
        place = arguments.folder_for_results(out)
        with written_in(place) as folder:
            target = CutFolder(folder, programs, on.name)
            found = cut_programs(programs, request, steps, target.after_operation)
            with steps.step("writing"):
                written = target.finish(found)
    if json:
        from toolpace.results.cut.record import cut_record

        print_json([cut_record(each.simulation, each.program, on.name) for each in found])
    else:
        for each in found:
            show_cut(console, each, on.name)
        if out is not None:
            console.print(f"\nwritten   {printable(str(Path(out)))}: {', '.join(written)}", soft_wrap=True)
    return 1 if any(each.simulation.collisions for each in found) else 0


def cell(text: str) -> float:
    """The size of a cell [m]. Raises UsageError."""
    try:
        found = parse_length(text)
    except UsageError as error:
        raise UsageError(f"--resolution: {error}") from None
    if not FINEST <= found <= COARSEST:
        raise UsageError(
            f"--resolution {text}: give {format_length(FINEST)} to {format_length(COARSEST)}, such as 0.2mm"
        )
    return found


def size(text: str) -> float:
    """A size of memory [bytes]. Raises UsageError."""
    for unit, scale in SIZES.items():
        number = text.strip().removesuffix(unit).strip()
        if text.strip().endswith(unit) and number.replace(".", "", 1).isdecimal() and float(number) > 0.0:
            return float(number) * scale
    raise UsageError(f"--memory {text[:40]}: give a number and a unit: 500MB, 2GB")


def show_cut(console: Console, found: ProgramCut, machine: str) -> None:
    """The page of one program: what of it is air, a row an operation, and what is wrong."""
    simulation = found.simulation
    console.print()
    _show_figures(console, found, machine)
    headings = ["operation", "tool", "in air", "cutting", "removed", "mean", "peak", "width", "depth"]
    uncertain = any(each.uncertain >= 0.05 for each in simulation.operations)
    if uncertain:
        headings.insert(4, "not sure")
    table = new_table(headings, left=("operation", "tool"))
    table.columns[0].min_width = len(headings[0])
    for each in simulation.operations:
        words = [each.name or "-", each.tool or "-", _time(each.air), _time(each.cutting)]
        words += [_time(each.uncertain)] if uncertain else []
        words += [_volume(each.removed), _rate(each.mean_rate), _rate(each.peak_rate)]
        words += [_length(each.width), _length(each.depth)]
        table.add_row(*cells(words))
    console.print(table)
    console.print("mean and peak removal rate in cm3/min, width and depth in mm\n", style="dim")
    show_findings(console, simulation)


def _show_figures(console: Console, found: ProgramCut, machine: str) -> None:
    from rich.table import Table

    simulation = found.simulation
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column(overflow="fold")
    whole = simulation.air + simulation.cutting + sum(each.uncertain for each in simulation.operations)
    air = f"{format_time(simulation.air)} of {format_time(whole)} at feed"
    if whole > 0.0:
        air += f", {100.0 * simulation.air / whole:.1f} %"
    rows = [("program", found.program), ("machine", machine)]
    if simulation.guessed:
        rows.append(("stock", "GUESSED, the box around all cutting moves: nothing is concluded from it"))
        rows.append(("", "tell the real one on the set-up sheet, in the table [stock]"))
        air += " of the guessed box: not to be relied on"
    stock = f"{_volume(simulation.stock_volume)}, removed {_volume(simulation.removed_volume)}"
    rows.append(("" if simulation.guessed else "stock", f"{stock}, left {_volume(simulation.left_volume)}"))
    rows.append(("in air", air))
    if simulation.above_part is not None:
        above = simulation.above_part
        high = f"at most {format_length(round(above.height, 6))} high, {_volume(above.volume)}"
        rows.append(("left", f"{high}, above the finished part"))
    cells_of = f"cells of {format_length(simulation.resolution)}"
    if simulation.uncertainty > 0.0:
        cells_of += f"; the stock ends within {format_length(simulation.uncertainty)} of where the sheet says"
    rows.append(("known to", cells_of))
    rows += [("assumed" if k == 0 else "", sentence) for k, sentence in enumerate(simulation.assumed)]
    for name, text in rows:
        grid.add_row(name, Text(printable(text), style="bold" if name == "in air" else ""))
    console.print(grid)


def show_findings(console: Console, simulation: CutSimulation) -> None:
    """What is wrong, the worst first, and what could not be seen."""
    from toolpace.common.value_objects import counted

    listed = [each for each in simulation.findings if each.kind != "air" or each.seconds >= WORTH]
    for each in listed[:SHOWN]:
        style = "bold red" if each.collision and each.certain else "red" if each.collision else ""
        console.print(Text(printable(finding_in_words(each)), style=style), soft_wrap=True)
    if len(listed) > SHOWN:
        console.print(f"and {counted(len(listed) - SHOWN, 'more finding')}: --json has all")
    if not simulation.collisions:
        console.print("no collision found" + ("; with the stock none was looked for" if simulation.guessed else ""))
    console.print(
        f"collisions less deep than {format_length(simulation.smallest_contact)} may not be seen", style="dim"
    )


def finding_in_words(each: Finding) -> str:
    """ "line 120: rapid through stock, 2.4 mm deep at X 10.2 Y 5 Z -3.1 (operation rough, T3)"."""
    words = {
        "rapid": "rapid through {body}",
        "holder": "holder in {body}",
        "shank": "shank in {body}",
        "gouge": "cuts into {body}",
        "flute": "cuts above its flutes",
        "left": "left above {body}",
        "air": "cuts nothing",
    }[each.kind].format(body=each.body)
    line = f"line {each.line}" if each.line == each.last_line else f"lines {each.line} to {each.last_line}"
    by = ", ".join(part for part in (each.operation, f"tool {each.tool}" if each.tool else "") if part)
    place = " ".join(f"{letter}{x / MILLIMETRE:.3g}" for letter, x in zip("XYZ", each.place))
    if each.kind == "air":
        return f"{line}: {words} at feed, {format_time(each.seconds)}" + (f" ({by})" if by else "")
    if each.kind == "left":
        may = "" if each.certain else "may be "
        return f"near {line}: {may}{words}, {format_length(round(each.depth, 5))} high at {place}" + (
            f" ({by})" if by else ""
        )
    may = "" if each.certain else "may be: "
    depth = format_length(round(each.depth, 5))
    return f"{line}: {may}{words}, {depth} deep at {place}" + (f" ({by})" if by else "")


def _time(seconds: float) -> str:
    return format_time(seconds) if seconds > 0.0 else "-"


def _volume(volume: float) -> str:
    """ "12.3 cm3"; below one "123 mm3"."""
    return f"{volume * 1e6:.4g} cm3" if volume >= 1e-6 else f"{volume * 1e9:.4g} mm3"


def _rate(rate: float) -> str:
    return f"{rate * 60e6:.3g}" if rate > 0.0 else "-"


def _length(length: float) -> str:
    return f"{length / MILLIMETRE:.3g}" if length > 0.0 else "-"


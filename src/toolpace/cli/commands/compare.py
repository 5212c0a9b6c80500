"""The command `compare`: plans side by side on the terminal, and a page that plays them together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.text import Text

from toolpace.cli.console import Steps, cells, new_console, new_table
from toolpace.common.errors import printable
from toolpace.common.units import format_time

if TYPE_CHECKING:
    from toolpace.results.compare.plans import Compared

Plans = Annotated[list[str], Parameter(help="Two to eight folders that `toolpace plan` wrote.")]
Page = Annotated[
    str | None, Parameter(name=["--page", "-p"], help="Write a page (.html) that plays the plans together.")
]
SHOWN = 20
"""Most operations, and limits, that are listed; the page has all."""
LEAST = 0.005
"""Share of the longest plan from which a limit is listed."""


def compare_command(plans: Plans, /, *, page: Page = None) -> int:
    """Show plans side by side: times by operation and by limit, and a page that plays them together.

    The page has the tools on one time, the time gained over the path against the
    first plan, and the blocks that differ most. The figures are those in the
    folders; nothing is verified again.

    For example:

        toolpace compare part-plan part-plan-5um
        toolpace compare on-trunnion on-head --page compared.html
    """
    from toolpace.cli import arguments
    from toolpace.cli.summary import limit_in_words
    from toolpace.common.files import write_text
    from toolpace.results.compare.page import comparison_page
    from toolpace.results.compare.plans import compared

    target = arguments.file_for_result("--page", page)
    console = new_console()
    found = compared(plans)
    _show_plans(console, found)
    _show(console, found, "operation", found.operations)
    least = LEAST * max(found.durations)
    limits = [
        (limit_in_words(name), times) for name, times in found.limits if max(time or 0.0 for time in times) >= least
    ]
    _show(console, found, "limited by", limits)
    if target is not None:
        with Steps(console).step("drawing"):
            write_text(target, comparison_page(found))
        console.print(Text(printable(f"written      {target}")), soft_wrap=True)
    return 0


def _show_plans(console: Console, found: Compared) -> None:
    from toolpace.results.compare.plans import verdict_words
    from toolpace.results.report.words import at_most

    headings = ("plan", "program", "machine", "time", "against the first", "gap", "verdict")
    table = new_table(headings, left=("plan", "program", "machine", "verdict"))
    first = found.durations[0]
    for number, (name, record) in enumerate(zip(found.names, found.records)):
        words = (
            name,
            record.program,
            record.machine,
            format_time(record.duration_s),
            f"{100.0 * (record.duration_s / first - 1.0):+.2f} %" if number and first > 0.0 else "",
            at_most(record.gap) if record.gap is not None else "-",
            verdict_words(record),
        )
        table.add_row(*(Text(printable(cell), style="red" if cell == "failed" else "") for cell in words))
    console.print(table)


def _show(console: Console, found: Compared, what: str, rows: Sequence[tuple[str, tuple[float | None, ...]]]) -> None:
    if not rows:
        return
    two = len(found.names) == 2
    table = new_table([what, *found.names, *(["difference"] if two else [])], left=())
    table.columns[0].justify = "left"
    for name, times in rows[:SHOWN]:
        words = ["-" if time is None else format_time(time) for time in times]
        if two:
            words.append("-" if None in times else f"{(times[1] or 0.0) - (times[0] or 0.0):+.3f} s")
        table.add_row(*cells([name, *words]))
    console.print(table)
    if len(rows) > SHOWN:
        console.print(f"and {len(rows) - SHOWN} more: --page has all")

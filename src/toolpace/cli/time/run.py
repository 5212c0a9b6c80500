"""The command `time`."""

from __future__ import annotations

from collections.abc import Sequence

from toolpace.cli.steps import Steps
from toolpace.jobs.timed import Asked, timed, timed_or_wrong


def run_time(programs: Sequence[str], asked: Asked, as_json: bool) -> int:
    """Time each program and print what was found; 0 where all could be, else 2. A single one raises ToolpaceError."""
    from rich.console import Console

    from toolpace.cli.steps import new_console
    from toolpace.cli.time import table

    console = new_console()
    # what is under way is shown beside JSON, too, but not among it
    place = Console(stderr=True, highlight=False, markup=False) if as_json else console
    alone = len(programs) == 1 and not as_json
    found = [(timed if alone else timed_or_wrong)(program, asked, Steps(place)) for program in programs]
    if as_json:
        table.print_json(found, asked.machine.name)
    else:
        table.show(console, found, asked.machine.name)
    return 2 if any(each.error for each in found) else 0

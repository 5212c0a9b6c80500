"""The display of a command: steps with their progress, tables, and names of programs in them."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.box import SIMPLE
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.jobs import Step, TimedSteps

WIDTH = 12
"""Of the column of names: that of the longest step, and a space."""
LONGEST_NAME = 40
"""Most characters of a program's name that a table does not break."""


def new_console() -> Console:
    """Where people read: colours and bars on a terminal, plain lines elsewhere, however long they are.

    Square brackets are what they are: names of files are no markup.
    """
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=100)
    return console


def new_table(headings: Sequence[str], left: Sequence[str]) -> Table:
    """A table whose columns stand right, but for those of `left`; cells that are too long are folded."""
    table = Table(box=SIMPLE, pad_edge=False)
    for heading in headings:
        table.add_column(Text(printable(heading)), justify="left" if heading in left else "right", overflow="fold")
    return table


def cells(words: Iterable[str], style: str = "") -> list[Text]:
    """Words as they are printed, a cell each."""
    return [Text(printable(word), style=style) for word in words]


def print_json(records: Sequence[dict[str, object]] | dict[str, object]) -> None:
    """Records as JSON on standard output."""
    import msgspec

    print(msgspec.json.format(msgspec.json.encode(records), indent=2).decode())


class Steps(TimedSteps):
    """Runs steps one after the other, shows them and keeps their times."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self.console = console

    def say(self, text: str) -> None:
        """A line below that of a step."""
        self.console.print(f"{'':<{WIDTH}} {text}", style="dim", soft_wrap=True)

    @contextmanager
    def step(self, name: str, note: str = "") -> Iterator[Step]:
        """Say the `note`, show a bar while the block runs, if there is a terminal; then a line with the step's time.

        A step that is told no share shows how long it has been at it.
        """
        step, began = Step(), time.perf_counter()
        if note:
            self.console.print(printable(f"{name:<{WIDTH}} {note}"), style="dim", soft_wrap=True)
        bar = Progress(
            SpinnerColumn(),
            TextColumn(f"{name:<{WIDTH}}"),
            BarColumn(bar_width=20),
            TimeElapsedColumn(),
            console=self.console,
            transient=True,
            disable=not self.console.is_terminal,
        )
        with bar:
            task = bar.add_task(name, total=None)
            step.share = lambda share: bar.update(task, total=1.0, completed=min(max(share, 0.0), 1.0))
            yield step
        took = time.perf_counter() - began
        self.seconds[name] = self.seconds.get(name, 0.0) + took
        note = f"  {step.note}" if step.note else ""
        self.console.print(f"{name:<{WIDTH}} {format_time(took):>10}{note}", soft_wrap=True)


def short_names(programs: Sequence[str]) -> list[str]:
    """The names without the folder in which all of them lie; as they are where some are relative and some not."""
    if len({Path(program).is_absolute() for program in programs}) != 1:
        return list(programs)
    folder = os.path.commonpath([Path(program).parent for program in programs])
    return [os.path.relpath(program, folder) if folder else program for program in programs]


def named_error(program: str, error: str) -> str:
    """What is wrong with a program, with its name before it where the error does not begin with it."""
    return error if error.startswith(program) else f"{program}: {error}"

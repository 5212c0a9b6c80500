"""The progress display of a job's steps."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.jobs.steps import Step, TimedSteps

WIDTH = 12
"""Of the column of names: that of the longest step, and a space."""


def new_console() -> Console:
    """Where people read: colours and bars on a terminal, plain lines elsewhere, however long they are.

    Square brackets are what they are: names of files are no markup.
    """
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=100)
    return console


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
        said = f"  {step.note}" if step.note else ""
        self.console.print(f"{name:<{WIDTH}} {format_time(took):>10}{said}", soft_wrap=True)

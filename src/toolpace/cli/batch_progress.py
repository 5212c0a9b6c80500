"""The display of a batch while it runs: its progress, and the outcome of each job."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import nullcontext

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.text import Text

from toolpace.cli.console import cells, named_error, new_console, new_table, short_names
from toolpace.cli.summary import limit_in_words
from toolpace.common.cluster import Pool, open_pool
from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.jobs.batch import Batch, BatchJob, BatchRow, run_batch
from toolpace.jobs.batch.folder import batch_folder
from toolpace.results.report.words import at_most

LOOK = 1.0
"""Time between two looks at what runs now [s]."""
RUNNING, SHOWN = 8, 40
"""Jobs that are named while they run, and rows that are shown when all is done; batch.html has all."""


def run_jobs(jobs: Sequence[BatchJob], out: str, where: str | int | None, memory: str | None) -> int:
    """Carry out jobs, show how far it is, and what came of them; 0 where all is well, else 1 or 2."""
    console = new_console()
    with batch_folder(out) as place, open_pool(where, memory) as pool:
        _say(console, "batch", f"{counted(len(jobs), 'job')} on {pool.where}")
        if pool.note:
            _say(console, "", pool.note)
        if pool.dashboard:
            _say(console, "dashboard", pool.dashboard)
        shown = _Shown(console, pool, jobs)
        try:
            with shown.live():
                done = run_batch(jobs, place, pool, shown.tell)
        except KeyboardInterrupt:
            ended = f"{shown.ended} of {counted(len(jobs), 'job')}"
            _say(console, "stopped", f"{ended} have ended; the same command continues")
            raise
    _show(console, done)
    return done.exit_code


class _Shown:
    """A line of each job that has ended, and below it how far all is and what runs now."""

    def __init__(self, console: Console, pool: Pool, jobs: Sequence[BatchJob]) -> None:
        self.console, self.pool, self.jobs = console, pool, jobs
        self.names = [printable(name) for name in short_names([str(job.program) for job in jobs])]
        columns = (SpinnerColumn(), BarColumn(bar_width=30), MofNCompleteColumn(), TimeElapsedColumn())
        self.bar = Progress(*columns, TextColumn("{task.description}"), console=console)
        self.task = self.bar.add_task("", total=len(jobs))
        self.looked, self.now = 0.0, Text()
        self.wrong = self.ended = 0

    def live(self) -> Live | nullcontext[None]:
        """What is drawn anew all the time; nothing where there is no terminal."""
        if not self.console.is_terminal:
            return nullcontext()
        return Live(get_renderable=self.drawn, console=self.console, transient=True, refresh_per_second=4)

    def drawn(self) -> RenderableType:
        """The bar, and what runs."""
        if time.monotonic() - self.looked > LOOK:
            self.looked = time.monotonic()
            self.now = self._running()
        return Group(self.bar, self.now)

    def _running(self) -> Text:
        by_worker: dict[str, list[str]] = {}
        for (number, _), worker in self.pool.now():
            by_worker.setdefault(worker, []).append(self.names[number])
        lines = [f"  {worker or 'here'}: {', '.join(labels)}" for worker, labels in sorted(by_worker.items())]
        more = [f"  and {len(lines) - RUNNING} more workers"] if len(lines) > RUNNING else []
        return Text(printable("\n".join(lines[:RUNNING] + more)).replace("\\n", "\n"), style="dim")

    def tell(self, row: BatchRow, done: int) -> None:
        """Of a job that has ended."""
        self.wrong += not row.ok
        self.ended = done
        self.bar.update(self.task, completed=done, description=f"{self.wrong} failed" if self.wrong else "")
        if self.console.is_terminal and row.ok:
            return
        took = "found" if row.found else format_time(row.seconds)
        duration = format_time(row.duration_s) if row.duration_s is not None else ""
        on = f" on {row.machine}" if row.machine else ""
        named = named_error(row.program, row.error) if row.error else f"{row.program}{on}  {duration}"
        line = f"{done}/{len(self.jobs)}  {row.verdict:<9} {took:>8}  {named}"
        self.console.print(Text(printable(line), style="" if row.ok else "red"), soft_wrap=True)


def errors(rows: Iterable[BatchRow]) -> dict[str, list[str]]:
    """What is wrong, once, and the machines with which it is."""
    found: dict[str, list[str]] = {}
    for row in rows:
        if row.error:
            machines = found.setdefault(named_error(row.program, row.error), [])
            machines += [row.machine] if row.machine not in machines else []
    return found


def _say(console: Console, name: str, text: str) -> None:
    console.print(Text(printable(f"{name:<12} {text}")), soft_wrap=True)


def _show(console: Console, done: Batch) -> None:
    """A table, what is not well first, and where all of it is."""
    rows = sorted(done, key=lambda row: -row.exit_code)[:SHOWN]
    timed = any(row.optimum_s is not None for row in rows)
    apart = any(row.air_s is not None for row in rows)
    times = [*(["optimum"] if timed else []), *(["in air"] if apart else [])]
    headings = ("program", "machine", "result", "time", *times, "gap", "limited by", "took")
    table = new_table(headings, left=("program", "machine", "result", "limited by"))
    for name, row in zip(short_names([row.program for row in rows]), rows):
        optimum = format_time(row.optimum_s) if row.optimum_s is not None else "-"
        words = (
            name,
            row.machine,
            row.verdict,
            format_time(row.duration_s) if row.duration_s is not None else "-",
            *([optimum] if timed else []),
            *(["-" if row.air_s is None else format_time(row.air_s)] if apart else []),
            at_most(row.gap) if row.gap is not None else "-",
            f"{limit_in_words(row.limit)} {100.0 * row.limited_by[row.limit]:.0f} %" if row.limit else "-",
            "found" if row.found else format_time(row.seconds) if row.seconds else "-",
        )
        table.add_row(*cells(words, "" if row.ok else "red"))
    console.print(table)
    if len(done) > len(rows):
        _say(console, "", f"and {len(done) - len(rows)} more: see batch.html")
    for error, machines in errors(rows).items():
        _say(console, "", f"{error} (on {', '.join(machines)})" if len(machines) > 1 else error)
    well = sum(row.ok for row in done)
    found = sum(row.found for row in done)
    _say(
        console,
        "done",
        f"{well} of {counted(len(done), 'job')}" + (f", {found} of them by an earlier batch" if found else ""),
    )
    _say(console, "written", f"{done.folder}: {', '.join(done.files)}")

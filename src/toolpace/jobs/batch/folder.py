"""The folder of a batch, written by one batch at a time: its tables, and its page of one row a job."""

from __future__ import annotations

import math
import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote

import msgspec

from toolpace.common import __version__
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, whole_file
from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.jobs.batch.job import BAD, ERROR, GOOD, WAITING, BatchRow
from toolpace.jobs.batch.work import INSPECTED, MARK, TIMED, Place
from toolpace.kernels.lock import FileLock, NoLocksError
from toolpace.results.report import shell
from toolpace.results.report.words import at_most, limit_words, percent

TABLE, PARQUET, PAGE = "batch.json", "batch.parquet", "batch.html"
"""Names of the tables beside the folders of the jobs."""
RESULTS = {"plan": "report.html", "export": "report.html", "time": TIMED, "inspect": INSPECTED}
"""What a row leads to, in the folder of its job."""
RECORD = "plan.json"
"""What it leads to where the report is left out."""
HEADINGS = (
    ("Program", ""), ("Machine", ""), ("Result", ""), ("Time", "n"), ("Optimum", "n"), ("In air", "n"), ("Gap", "n"),
    ("Blocks", "n"), ("Tip", "n"), ("Axis", "n"), ("Feed", ""), ("Took", "n"), ("Limited by, or what is wrong", ""),
)  # fmt: skip
OPTIONAL = {"Optimum", "In air", "Gap", "Feed", "Limited by, or what is wrong", "Machine"}
"""Columns that are left out where no row has anything in them."""
Number = TypeVar("Number", int, float)
Cell = tuple[str, float | None, str]
"""HTML, the figure that it is sorted by or None for words, and its class."""


@contextmanager
def batch_folder(out: str | os.PathLike[str]) -> Iterator[Place]:
    """The folder for a batch, made where it is missing; one that a batch has left is gone on with.

    Raises UsageError where it holds anything else, or another batch writes there now.
    """
    folder = Path(out)
    try:
        if folder.is_dir() and any(folder.iterdir()) and not (folder / MARK).is_file():
            raise UsageError(f"{out}: is not empty, and no batch was written there; give another folder")
        folder.mkdir(parents=True, exist_ok=True)
        mark = folder.resolve() / MARK
        with FileLock(mark) as lock:
            if not _taken(lock):
                raise UsageError(f"{out}: another batch writes there now; wait for it, or give another folder")
            if not mark.read_text(encoding="ascii"):
                mark.write_text(secrets.token_hex(16), encoding="ascii")
            yield Place(str(mark.parent), mark.read_text(encoding="ascii"))
    except (OSError, ValueError) as error:
        raise UsageError(f"{out}: cannot be written: {reason(error)}; give another folder") from None


def _taken(lock: FileLock) -> bool:
    """Whether the folder is ours; so too where there are no locks and nobody can be kept out."""
    try:
        return lock.take()
    except NoLocksError:
        return True


def write_tables(folder: Path, rows: Sequence[BatchRow]) -> list[str]:
    """Write the tables of a batch, each whole or not at all; return their names, the page last."""

    written = [TABLE]
    figures = {"toolpace_version": __version__, "jobs": rows}
    with whole_file(folder / TABLE) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(figures), indent=1) + b"\n")
    if write_rows(folder / PARQUET, rows):
        written.append(PARQUET)
    with whole_file(folder / PAGE) as temporary:
        temporary.write_text(batch_page(folder, rows), encoding="utf-8")
    return [*written, PAGE]


def write_rows(file: Path, rows: Sequence[BatchRow]) -> bool:
    """Write the rows as a table for other programs; False, and nothing written, where pyarrow is not installed."""
    try:
        import pyarrow as pa
        import pyarrow.parquet
    except ImportError:
        return False
    text = (
        "program", "machine", "what", "planner", "effort", "feed", "verdict", "error", "folder", "exported", "key",
        "worker",
    )  # fmt: skip
    figures = (
        "tip_tolerance_mm", "axis_tolerance_deg", "duration_s", "optimum_s", "air_s", "material_s", "lower_bound_s",
        "gap", "seconds",
    )  # fmt: skip
    columns = {name: pa.array([getattr(row, name) for row in rows], pa.string()) for name in text}
    columns |= {name: pa.array([getattr(row, name) for row in rows], pa.float64()) for name in figures}
    columns["limit"] = pa.array([row.limit for row in rows], pa.string())
    shares = [list(row.limited_by.items()) for row in rows]
    columns["limited_by"] = pa.array(shares, pa.map_(pa.string(), pa.float64()))
    columns["blocks"] = pa.array([row.blocks for row in rows], pa.int64())
    columns["found"] = pa.array([row.found for row in rows], pa.bool_())
    with whole_file(file) as temporary:
        pyarrow.parquet.write_table(pa.table(columns), temporary)
    return True


def batch_page(folder: Path, rows: Sequence[BatchRow]) -> str:
    """The whole HTML text; rows lead to the files of their jobs that are in the folder of the batch."""
    table = [_cells(folder, row) for row in rows]
    shown = [k for k, (name, _) in enumerate(HEADINGS) if name not in OPTIONAL or any(cells[k][0] for cells in table)]
    head = "".join(f'<th class="{HEADINGS[k][1]}">{HEADINGS[k][0]}</th>' for k in shown)
    done = sum(row.verdict != WAITING for row in rows)
    fields = {
        "lead": f"{counted(len(rows), 'job')}, {done} of them ended",
        "verdict": _badge(rows),
        "cards": _cards(rows),
        "head": head,
        "rows": "\n".join(f"<tr>{''.join(_html(cells[k]) for k in shown)}</tr>" for cells in table),
    }
    return shell.whole_page("toolpace.jobs.batch", "page", "Batch", fields)


def _badge(rows: Sequence[BatchRow]) -> str:
    wrong = sum(not row.ok for row in rows)
    waiting = sum(row.verdict == WAITING for row in rows)
    if not wrong:
        return '<span class="badge good">all is well</span>'
    if waiting == wrong:
        return f'<span class="badge quiet">{waiting} not run yet</span>'
    return f'<span class="badge bad">{wrong - waiting} of {len(rows)} failed</span>'


def _cards(rows: Sequence[BatchRow]) -> str:
    times = [row.duration_s for row in rows if row.duration_s is not None]
    cards = [("Jobs done", str(sum(row.ok for row in rows)), f"of {len(rows)}", "big")]
    cards += [
        (label, str(count), note, "")
        for label, count, note in (
            ("Failed", sum(row.verdict in BAD for row in rows), "the verification"),
            ("Errors", sum(row.verdict == ERROR for row in rows), "no result; the table gives the reason"),
            ("Not run", sum(row.verdict == WAITING for row in rows), "the same command continues with them"),
            ("Found", sum(row.found for row in rows), "done by an earlier batch"),
        )
        if count
    ]
    if times:
        cards.append(("Total time", format_time(sum(times)), f"of {counted(len(times), 'motion')}", ""))
    gaps = [row.gap for row in rows if row.gap is not None]
    if gaps:
        cards.append(("Largest gap", at_most(max(gaps)), "of a time to the lower bound on its mesh", ""))
    took = sum(row.seconds for row in rows)
    if took:
        cards.append(("Computed in", format_time(took), "sum of all workers", ""))
    return shell.cards(cards)


def _cells(folder: Path, row: BatchRow) -> list[Cell]:
    """In the order of the headings."""
    verdict = "good" if row.verdict in GOOD else "quiet" if row.verdict == WAITING else "bad"
    limits = ", ".join(
        f"{limit_words(name)} {percent(share)}"
        for name, share in sorted(row.limited_by.items(), key=lambda item: -item[1])[:2]
        if share >= 0.01
    )
    return [
        (_linked(folder, row), None, ""),
        (escape(row.machine), None, ""),
        (escape(row.verdict), None, verdict),
        _figure(row.duration_s, format_time),
        _figure(row.optimum_s, format_time),
        _figure(row.air_s, format_time),
        _figure(row.gap, at_most),
        _figure(row.blocks, str),
        _figure(row.tip_tolerance_mm, lambda value: f"{1e3 * value:.4g} µm"),
        _figure(row.axis_tolerance_deg, lambda value: f"{value:.4g}°"),
        (escape(row.feed or ""), None, ""),
        ("found", 0.0, "n quiet") if row.found else _figure(row.seconds or None, format_time),
        (f'<span class="why">{escape(row.error)}</span>' if row.error else escape(limits), None, "limits"),
    ]


def _figure(value: Number | None, show: Callable[[Number], str]) -> Cell:
    if value is None:
        return "", math.inf, "n"
    return escape(show(value)), float(value), "n"


def _linked(folder: Path, row: BatchRow) -> str:
    """The program, leading to what came of it: to the report, or where there is none to the figures."""
    files = (f"{row.folder}/{name}" for name in ((RESULTS[row.what],) if row.report else ()) + (RECORD,))
    target = next((name for name in files if row.folder and (folder / name).is_file()), "")
    return f'<a href="{escape(quote(target))}">{escape(row.program)}</a>' if target else escape(row.program)


def _html(cell: Cell) -> str:
    text, value, kind = cell
    by = "" if value is None else ' data-value=""' if math.isinf(value) else f' data-value="{value!r}"'
    return f'<td class="{kind}"{by}>{text}</td>'

"""The folder of a batch, written by one batch at a time."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import msgspec

from toolpace.common import __version__
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, whole_file
from toolpace.jobs.batch.result_row import BatchRow
from toolpace.jobs.batch.work import MARK, Place
from toolpace.kernels.lock import FileLock

TABLE, PARQUET, PAGE = "batch.json", "batch.parquet", "batch.html"
"""Names of the tables beside the folders of the jobs."""


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
            if not lock.take():
                raise UsageError(f"{out}: another batch writes there now; wait for it, or give another folder")
            if not mark.read_text(encoding="ascii"):
                mark.write_text(secrets.token_hex(16), encoding="ascii")
            yield Place(str(mark.parent), mark.read_text(encoding="ascii"))
    except (OSError, ValueError) as error:
        raise UsageError(f"{out}: cannot be written: {reason(error)}; give another folder") from None


def write_tables(folder: Path, rows: Sequence[BatchRow]) -> list[str]:
    """Write the tables of a batch, each whole or not at all; return their names, the page last."""
    from toolpace.jobs.batch.page import batch_page

    written = [TABLE]
    said = {"toolpace_version": __version__, "jobs": rows}
    with whole_file(folder / TABLE) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(said), indent=1) + b"\n")
    if write_rows(folder / PARQUET, rows):
        written.append(PARQUET)
    with whole_file(folder / PAGE) as temporary:
        temporary.write_text(batch_page(rows), encoding="utf-8")
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
    figures = ("tip_tolerance_mm", "axis_tolerance_deg", "duration_s", "optimum_s", "lower_bound_s", "gap", "seconds")
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

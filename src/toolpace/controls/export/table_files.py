"""Columns of numbers as files that are written and read back: comma-separated values, or Parquet."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError


@dataclass(frozen=True)
class Column:
    """One column of a table."""

    name: str
    unit: str
    values: Floats
    """(n,) in SI."""
    factor: float
    whole: bool = False
    """Whether it holds whole numbers."""

    def part(self, rows: slice) -> Floats:
        """The values of some rows, in the column's unit; zero has no sign."""
        scaled: Floats = self.values[rows] * self.factor
        return (np.rint(scaled) if self.whole else scaled) + 0.0


def heading(columns: Sequence[Column]) -> str:
    """The line of names: `t [s],X [mm],...`."""
    return ",".join(column.name if column.unit == "1" else f"{column.name} [{column.unit}]" for column in columns)


def write_comma_separated(file: Path, head: Sequence[str], columns: Sequence[Column], pieces: Iterable[slice]) -> None:
    """Write the table; fifteen digits, since a jerk found by differences of positions at 1 ms needs them."""
    form = ",".join("%d" if column.whole else "%.15g" for column in columns) + "\n"
    with file.open("w", encoding="utf-8", newline="\n") as stream:
        stream.writelines(f"# {line}\n" for line in head)
        stream.write(heading(columns) + "\n")
        for rows in pieces:
            table = np.column_stack([column.part(rows) for column in columns])
            stream.write((form * len(table)) % tuple(table.ravel().tolist()))


def read_comma_separated(file: Path, columns: Sequence[Column], rows: int) -> Iterator[Floats]:
    """The numbers again, `rows` at a time. Raises VerificationError where there are none, or other columns."""
    with file.open(encoding="utf-8") as stream:
        line = stream.readline()
        while line.startswith("#"):
            line = stream.readline()
        if line.rstrip("\n") != heading(columns):
            raise VerificationError(
                f"{file.name}: read back it has other columns; nothing was written; is the disk sound?"
            )
        while lines := list(itertools.islice(stream, rows)):
            try:
                yield np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
            except ValueError:
                raise VerificationError(
                    f"{file.name}: read back it holds what is no number; nothing was written; is the disk sound?"
                ) from None


def arrow() -> Any:
    """The library. Raises UsageError, naming the extra, where it is missing."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise UsageError(
            "--format parquet needs pyarrow, which is not installed: pip install 'toolpace[parquet]', or give "
            "--format csv"
        ) from None
    return pyarrow


def write_parquet(
    file: Path, head: Sequence[str], columns: Sequence[Column], sha256: Mapping[str, str], pieces: Iterable[slice]
) -> None:
    """Write the table: one column each, the unit in the metadata of its field, the header in that of the table."""
    pa = arrow()
    fields = [
        pa.field(column.name, pa.int64() if column.whole else pa.float64(), metadata={"unit": column.unit})
        for column in columns
    ]
    metadata = {"toolpace": "\n".join(head), **{f"sha256 of {what}": value for what, value in sha256.items()}}
    schema = pa.schema(fields, metadata=metadata)
    with pa.parquet.ParquetWriter(file, schema) as writer:
        for rows in pieces:
            parts = [column.part(rows).astype(np.int64) if column.whole else column.part(rows) for column in columns]
            writer.write_table(pa.table(parts, schema=schema))


def read_parquet(file: Path, columns: Sequence[Column]) -> Iterator[Floats]:
    """The numbers again, a group of rows at a time. Raises VerificationError where there are none, or other columns."""
    pa = arrow()
    try:
        with pa.parquet.ParquetFile(file) as source:
            units = [(each.metadata or {}).get(b"unit", b"1").decode() for each in source.schema_arrow]
            names = [
                name if unit == "1" else f"{name} [{unit}]" for name, unit in zip(source.schema_arrow.names, units)
            ]
            if ",".join(names) != heading(columns):
                raise VerificationError(f"{file.name}: read back it has other columns; nothing was written")
            for group in range(source.num_row_groups):
                table = source.read_row_group(group)
                yield np.column_stack([np.asarray(each, dtype=np.float64) for each in table.columns])
    except (pa.ArrowException, OSError) as error:
        raise VerificationError(f"{file.name}: cannot be read back ({error}); nothing was written") from None

"""A table as Parquet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError
from toolpace.controls.export.comma_separated import Numbers, heading


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
    file: Path, head: Sequence[str], columns: Sequence[Numbers], sha256: Mapping[str, str], pieces: Iterable[slice]
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


def read_parquet(file: Path, columns: Sequence[Numbers]) -> Iterator[Floats]:
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

"""A table as comma-separated values with a commented header."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import VerificationError


class Numbers(Protocol):
    """A column, as far as a file needs it."""

    @property
    def name(self) -> str: ...

    @property
    def unit(self) -> str: ...

    @property
    def whole(self) -> bool: ...

    def part(self, rows: slice) -> Floats:
        """Values of some rows, in the column's unit."""


def heading(columns: Sequence[Numbers]) -> str:
    """The line of names: `t [s],X [mm],...`."""
    return ",".join(column.name if column.unit == "1" else f"{column.name} [{column.unit}]" for column in columns)


def write_comma_separated(file: Path, head: Sequence[str], columns: Sequence[Numbers], pieces: Iterable[slice]) -> None:
    """Write the table; fifteen digits, since a jerk found by differences of positions at 1 ms needs them."""
    form = ",".join("%d" if column.whole else "%.15g" for column in columns) + "\n"
    with file.open("w", encoding="utf-8", newline="\n") as stream:
        stream.writelines(f"# {line}\n" for line in head)
        stream.write(heading(columns) + "\n")
        for rows in pieces:
            table = np.column_stack([column.part(rows) for column in columns])
            stream.write((form * len(table)) % tuple(table.ravel().tolist()))


def read_comma_separated(file: Path, columns: Sequence[Numbers], rows: int) -> Iterator[Floats]:
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

"""Target `table`: set-points as columns at a fixed period, as comma-separated values or Parquet."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError, did_you_mean
from toolpace.common.units import format_time
from toolpace.controls.export.rows import (
    CHUNK,
    Rows,
    Scale,
    refuse_coarse,
    refuse_no_cycle,
    rows_every,
    scale_of,
    tool_changes,
)
from toolpace.controls.export.target import PlannedMotion, ReadBack, Written, provenance, start_in_words

COLUMNS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")
"""What a table can hold: time, joints and their derivatives, tip and tool axis in the workpiece frame, line number."""
USUAL = ("t", "q", "qd", "qdd", "block")
"""Positions, and velocities and accelerations as feed-forward."""
FORMATS = ("csv", "parquet")
ROUNDING = 2e-14
"""Relative rounding of fifteen digits, and of the change of units."""
_RATES = {"q": ("", ""), "qd": (" velocity", "/s"), "qdd": (" acceleration", "/s2"), "qddd": (" jerk", "/s3")}


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


@dataclass(frozen=True, kw_only=True)
class Table:
    """Set-points as CSV or Parquet."""

    name: ClassVar[str] = "table"
    period: float | None = None
    """Time between rows [s]; None: that of the plan."""
    resample: bool = False
    """Whether rows may lie between set-points."""
    columns: tuple[str, ...] = USUAL
    scale: str = "mm,deg"
    counts: Mapping[str, str] = field(default_factory=dict)
    """Increments for each unit of each joint, like {"X": "10000/mm"}; positions are whole numbers then."""
    format: str = "csv"

    def __post_init__(self) -> None:
        refuse_no_cycle("--period", self.period)
        for column in self.columns:
            if column not in COLUMNS:
                raise UsageError(f"--columns {column[:40]}: there is no such column; {did_you_mean(column, COLUMNS)}")
        if not self.columns or len(set(self.columns)) != len(self.columns):
            raise UsageError(f"--columns: name each column once, of {', '.join(COLUMNS)}")
        if self.format not in FORMATS:
            raise UsageError(f"--format {self.format[:40]}: give one of {', '.join(FORMATS)}")
        if self.format == "parquet":
            arrow()

    @property
    def file(self) -> str:
        """Its name."""
        return f"table.{self.format}"

    def write(self, motion: PlannedMotion, folder: Path) -> Written:
        """Write the table with its header."""
        rows, scale = self._rows(motion)
        refuse_coarse(motion, rows.points, scale)
        columns = self._columns(rows, scale)
        notes = self._notes(motion, rows, scale)
        head = provenance(motion, "Table of set-points") + self._how_to_use(motion, rows) + notes
        if self.format == "csv":
            write_comma_separated(folder / self.file, head, columns, _pieces(len(rows.points)))
        else:
            write_parquet(folder / self.file, head, columns, motion.sha256, _pieces(len(rows.points)))
        return Written([self.file], notes)

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Read it back, and compare each number with the plan's."""
        rows, scale = self._rows(motion)
        columns = self._columns(rows, scale)
        file = folder / self.file
        if self.format == "csv":
            tables = read_comma_separated(file, columns, CHUNK)
        else:
            tables = read_parquet(file, columns)
        worst, at = 0.0, 0
        for table in tables:
            part = slice(at, at + len(table))
            right = np.column_stack([column.part(part) for column in columns])
            if right.shape != table.shape:
                worst = np.inf
                break
            worst = max(worst, float((np.abs(table - right) / np.maximum(np.abs(right), 1e-300)).max(initial=0.0)))
            at += len(table)
        worst = worst if at == len(rows.points) else np.inf
        return [ReadBack("largest relative difference of a number", worst, ROUNDING).raise_if_failed(file)]

    def _rows(self, motion: PlannedMotion) -> tuple[Rows, Scale]:
        if not motion.setpoints.has_tool and {"tip", "axis"} & set(self.columns):
            raise UsageError("--columns tip and axis: the plan has no tool; leave them out")
        scale = scale_of(motion, self.scale, self.counts)
        return rows_every(motion, self.period or motion.dt, self.resample), scale

    def _columns(self, rows: Rows, scale: Scale) -> list[Column]:
        points, found = rows.points, []
        for name in self.columns:
            if name == "t":
                found.append(Column("t", "s", points.t, 1.0))
            elif name == "block":
                found.append(Column("block", "1", points.block.astype(np.float64), 1.0, True))
            elif name == "tip":
                unit, factor = scale.length
                found += [Column(f"tip {c}", unit, points.tip[:, i], factor) for i, c in enumerate("xyz")]
            elif name == "axis":
                found += [Column(f"axis {c}", "1", points.axis[:, i], 1.0) for i, c in enumerate("ijk")]
            else:
                kind, per = _RATES[name]
                for j, joint in enumerate(points.joints):
                    whole = scale.counted[j] and name == "q"
                    unit = f"{scale.units[j]}{per}"
                    found.append(Column(f"{joint}{kind}", unit, getattr(points, name)[:, j], scale.factors[j], whole))
        return found

    def _how_to_use(self, motion: PlannedMotion, rows: Rows) -> list[str]:
        return [
            f"one row every {format_time(rows.period)} ({rows.period:.9g} s), {len(rows.points)} rows, the "
            "first at rest",
            f"bring the machine to the first row before: {start_in_words(motion)}",
            "take one row a period, without filter, look-ahead or limit of jerk behind it: they would smooth it again",
            "velocities and accelerations are those of the motion at the row's time, for feed-forward",
            "run it in the air first, and compare the positions of the control with the table",
        ]

    def _notes(self, motion: PlannedMotion, rows: Rows, scale: Scale) -> list[str]:
        notes = []
        if rows.error.any():
            worst = motion.by_joint(rows.error)
            notes.append(f"rows lie between set-points of the plan: interpolated, off by at most {worst}")
        sag = motion.by_joint(rows.sag)
        notes.append(f"a control that moves straight from row to row deviates from the motion by at most {sag}")
        if changes := tool_changes(motion):
            named = ", ".join(map(str, changes))
            notes.append(f"the plan changes its tool {named}: stop there, where it rests, put the tool in, and go on")
        if any(scale.counted):
            rounded = motion.by_joint(scale.resolution)
            notes.append(f"positions are rounded to whole increments, by at most {rounded}")
        return notes


def _pieces(rows: int) -> Iterator[slice]:
    return (slice(start, min(start + CHUNK, rows)) for start in range(0, rows, CHUNK))

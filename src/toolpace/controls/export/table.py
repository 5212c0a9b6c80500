"""Target `table`: set-points as columns at a fixed period."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import format_time
from toolpace.controls.export.column_units import Scale, refuse_coarse, scale_of
from toolpace.controls.export.motion import PlannedMotion, provenance, start_in_words
from toolpace.controls.export.rows import CHUNK, Rows, refuse_no_cycle, rows_every
from toolpace.controls.export.table_files import (
    Column,
    arrow,
    read_comma_separated,
    read_parquet,
    write_comma_separated,
    write_parquet,
)
from toolpace.controls.export.target import ReadBack, Written
from toolpace.controls.export.tool_changes import tool_changes

COLUMNS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")
"""What a table can hold: time, joints and their derivatives, tip and tool axis in the workpiece frame, line number."""
USUAL = ("t", "q", "qd", "qdd", "block")
"""Positions, and velocities and accelerations as feed-forward."""
FORMATS = ("csv", "parquet")
ROUNDING = 2e-14
"""Relative rounding of fifteen digits, and of the change of units."""
_RATES = {"q": ("", ""), "qd": (" velocity", "/s"), "qdd": (" acceleration", "/s2"), "qddd": (" jerk", "/s3")}


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

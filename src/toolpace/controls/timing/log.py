"""A log of axis positions over time."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.common.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

TIMES = ("t", "time")
LEAST_ROWS = 20
STEADY = 0.2
"""Most share by which times between rows may differ from their median."""
STILL = 1e-9
"""Way of an axis [m, rad] that is none."""


@dataclass(frozen=True)
class MotionLog:
    """Joint positions at equal times, from the last row at rest to the first at rest again."""

    dt: float
    """Time between rows [s]."""
    q: Floats
    """(n, joints) [m, rad]; nan for joints that the log does not have."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.dt * (len(self.q) - 1)


def load_log(path: str | Path, machine: Machine) -> MotionLog:
    """A table (CSV): a column `t` in seconds, and one in mm or degrees for each joint, by its name.

    Other columns are passed over. Raises UsageError naming file, line and cure.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            lines = csv.reader(stream)
            columns, time = _columns(next(lines, []), machine, str(path))
            wanted = [time, *columns.values()]
            rows = [_row(row, wanted, number, str(path)) for number, row in enumerate(lines, start=2) if row]
    except OSError as error:
        raise UsageError(f"log {path}: cannot be read ({reason(error)}); check the path") from None
    except (UnicodeDecodeError, csv.Error):
        raise UsageError(f"log {path}: no table of text (CSV, UTF-8); export it as one") from None
    if len(rows) < LEAST_ROWS:
        raise UsageError(f"log {path}: has {len(rows)} rows, at least {LEAST_ROWS} are needed; log the whole program")
    table = np.array(rows)
    q = np.full((len(table), len(machine.joints)), np.nan)
    for column, name in enumerate(columns, start=1):
        joint = machine.joints.index(name)
        q[:, joint] = table[:, column] * (DEGREE if machine.is_rotary[joint] else MILLIMETRE)
    return trimmed(_step(table[:, 0], str(path)), q, str(path))


def _columns(header: Sequence[str], machine: Machine, source: str) -> tuple[dict[str, int], int]:
    names = [name.strip() for name in header]
    time = next((names.index(name) for name in TIMES if name in names), None)
    joints = {name: names.index(name) for name in machine.joints if name in names}
    if time is None or not joints:
        raise UsageError(
            f"log {source}: its first line must name the columns: t (seconds) and joints of machine '{machine.name}' "
            f"({', '.join(machine.joints)}), in mm and degrees"
        )
    return joints, time


def _row(row: Sequence[str], wanted: Sequence[int], number: int, source: str) -> list[float]:
    try:
        values = [float(row[column]) for column in wanted]
    except (ValueError, IndexError):
        values = [math.nan]
    if not all(map(math.isfinite, values)):
        raise UsageError(f"log {source}:{number}: a figure is missing or not finite; remove the line, or log anew")
    return values


def _step(t: Floats, source: str) -> float:
    steps = np.diff(t)
    step = float(np.median(steps))
    wrong = np.flatnonzero(np.abs(steps - step) > STEADY * max(step, 0.0))
    if step <= 0.0 or len(wrong):
        line = int(wrong[0]) + 3 if len(wrong) else 3
        raise UsageError(f"log {source}:{line}: times must rise in equal steps (here {step:g} s); log at a fixed rate")
    return float(t[-1] - t[0]) / (len(t) - 1)


def trimmed(dt: float, q: Floats, source: str = "log") -> MotionLog:
    """The rows from the last at rest to the first at rest again. Raises UsageError where no axis moves."""
    moving = np.flatnonzero(np.nanmax(np.abs(np.diff(q, axis=0)), axis=1) > STILL)
    if not len(moving):
        raise UsageError(f"log {source}: no axis moves in it")
    if moving[-1] + 2 - moving[0] < LEAST_ROWS:
        raise UsageError(f"log {source}: the axes move in fewer than {LEAST_ROWS} rows of it; log the whole program")
    return MotionLog(dt, q[moving[0] : moving[-1] + 2])

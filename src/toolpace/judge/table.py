"""A check of setpoints.csv against the set-points."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.judge.verification import Check, Verification
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints

ROUNDING = 2e-14
"""Relative rounding of fifteen digits, and of the change of units."""
CHUNK = 50_000
"""Rows that are read at once, to keep memory low."""
COLUMNS = (("", "q", ""), (" velocity", "qd", "/s"), (" acceleration", "qdd", "/s2"), (" jerk", "qddd", "/s3"))


def with_table(found: Verification, path: Path, points: SetPoints, machine: Machine) -> Verification:
    """A verification with the check of the table added."""
    return replace(found, checks=(*found.checks, table_check(path, points, machine)))


def table_check(path: Path, points: SetPoints, machine: Machine) -> Check:
    """Whether each number of the table is that of the set-points, in millimetres and degrees."""
    names, factors = _columns(points, machine)
    values = [points.t[:, None], points.q, points.qd, points.qdd, points.qddd, points.tip, points.axis]
    values.append(points.block[:, None].astype(np.float64))
    try:
        with path.open(encoding="ascii") as stream:
            head = stream.readline().rstrip("\r\n").split(",")
            if head != names:
                return _wrong("its columns are not those of set-points in mm and deg")
            row = 0
            while row < len(points):
                lines = list(itertools.islice(stream, min(CHUNK, len(points) - row)))
                if not lines:
                    break
                table = np.loadtxt(lines, delimiter=",", ndmin=2)
                part = slice(row, row + len(table))
                right = np.hstack([value[part] for value in values]) * factors
                if table.shape != right.shape or not _same(table, right):
                    return _wrong(f"rows {row + 1} to {row + len(table)} hold other numbers than the set-points")
                row += len(table)
            if row < len(points) or stream.read(1):
                return _wrong(f"it has not as many rows as there are set-points ({len(points)})")
    except OSError as error:
        raise UsageError(f"{path}: cannot read: {reason(error)}") from None
    except ValueError:
        return _wrong("it holds what is no number")
    return Check("setpoints.csv", 0.0, 0.0, "", True, note="as the set-points")


def _wrong(note: str) -> Check:
    return Check("setpoints.csv", 0.0, 0.0, "", False, note=note)


def _same(table: Floats, right: Floats) -> bool:
    return bool((np.abs(table - right) <= ROUNDING * np.abs(right) + 1e-300).all())


def _columns(points: SetPoints, machine: Machine) -> tuple[list[str], Floats]:
    """Names with units, and the factors from SI."""
    names, factors = ["t [s]"], [1.0]
    for kind, _, per in COLUMNS:
        for joint, rotary in zip(points.joints, machine.is_rotary):
            names.append(f"{joint}{kind} [{'deg' if rotary else 'mm'}{per}]")
            factors.append(180.0 / math.pi if rotary else 1e3)
    if points.has_tool:
        names += [f"tip {c} [mm]" for c in "xyz"] + [f"axis {c} [1]" for c in "ijk"]
        factors += [1e3] * 3 + [1.0] * 3
    return [*names, "block"], np.array([*factors, 1.0])

"""setpoints.csv: set-points as a table in millimetres and degrees."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.files import whole_file
from toolpace.motion.setpoints import SetPointSource

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

CHUNK = 20_000
"""Rows that are turned into text in one piece, to keep memory low."""
_KINDS = (("", "q", ""), (" velocity", "qd", "/s"), (" acceleration", "qdd", "/s2"), (" jerk", "qddd", "/s3"))
"""What a column holds, the field of SetPoints, and what its unit is divided by."""


def columns(setpoints: SetPointSource, machine: Machine | None) -> tuple[list[str], list[float]]:
    """Names with units, and the factors from SI, of all columns but the last (block)."""
    rotary = machine.is_rotary if machine is not None else [None] * len(setpoints.joints)
    units = [("", 1.0) if r is None else ("deg", 180.0 / math.pi) if r else ("mm", 1e3) for r in rotary]
    names, factors = ["t [s]"], [1.0]
    for kind, _, per in _KINDS:
        for joint, (unit, factor) in zip(setpoints.joints, units):
            shown = f"{unit}{per}" if unit else f"1{per}" if per else "1"
            names.append(f"{joint}{kind} [{shown}]")
            factors.append(factor)
    if setpoints.has_tool:
        names += [f"tip {c} [mm]" for c in "xyz"] + [f"axis {c} [1]" for c in "ijk"]
        factors += [1e3] * 3 + [1.0] * 3
    return names, factors


def write_csv(path: str | os.PathLike[str], setpoints: SetPointSource, machine: Machine | None = None) -> None:
    """Write the table, whole or not at all: time, positions, velocities, accelerations, jerks, tip, axis,
    block.

    Fifteen digits: a jerk found by differences of positions at 1 ms needs them.
    """
    names, factors = columns(setpoints, machine)
    form = "%.15g," * len(names) + "%d\n"
    scale = np.array(factors)
    with whole_file(path) as temporary, temporary.open("w", encoding="ascii", newline="") as stream:
        stream.write(",".join([*names, "block"]) + "\n")
        for start in range(0, len(setpoints), CHUNK):
            points = setpoints.rows(start, min(start + CHUNK, len(setpoints)))
            parts = [points.t[:, None], points.q, points.qd, points.qdd, points.qddd]
            parts += [points.tip, points.axis] if points.has_tool else []
            # Zero has no sign.
            values = np.hstack(parts) * scale + 0.0
            # Block numbers are exact in double precision, so that one format serves the whole row.
            table = np.column_stack((values, points.block))
            stream.write((form * len(table)) % tuple(table.ravel().tolist()))

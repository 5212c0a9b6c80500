"""Tool changes in a plan, which exports of rows refuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time
from toolpace.controls.export.motion import PlannedMotion
from toolpace.controls.export.rows import quintic
from toolpace.motion.setpoints import SetPoints

SAME = 2
"""Time steps within which a change by name and one by length are one."""
NAMED = 5
"""Changes that a message names."""


@dataclass(frozen=True, eq=False)
class ToolChange:
    """The machine stands at `time`, and goes on with another tool."""

    time: float
    """[s]"""
    tool: str
    """Its name; empty where it is not known."""
    q: Floats
    """(m,) where the joints stand [m, rad]."""

    def __str__(self) -> str:
        return f"to tool {self.tool or 'of another length'} at {format_time(self.time)}"


def tool_changes(motion: PlannedMotion) -> list[ToolChange]:
    """The changes of a plan in the order of time; the tool that it begins with is none."""
    found = _by_name(motion)
    times = np.array([each.time for each in found])
    for row in _by_length(motion).tolist():
        if not len(times) or np.abs(times - motion.setpoints.t[row]).min() > SAME * motion.dt:
            found.append(_at_rest(motion, row))
    return sorted(found, key=lambda each: each.time)


def refuse_tool_changes(motion: PlannedMotion, name: str) -> None:
    """Raise UsageError where rows that are played without a stop would run through a change of the tool."""
    changes = tool_changes(motion)
    if changes:
        named = ", ".join(map(str, changes[:NAMED])) + (", ..." if len(changes) > NAMED else "")
        raise UsageError(
            f"--to {name}: the plan changes its tool ({named}), and its rows are played without a stop for that; plan "
            "what each tool does as a program of its own, or take --to linuxcnc-g93, which stops, --to program, or "
            "--to table, which gives the times"
        )


def tool_lengths(motion: PlannedMotion, points: SetPoints) -> Floats:
    """(n,) of the tool in the spindle at set-points of a plan [m]."""
    own, of_points = motion.machine.tool_length, points.tool_length
    lengths: Floats = np.where(np.isnan(of_points), own, of_points) if len(of_points) else np.full(len(points), own)
    return lengths


def _by_name(motion: PlannedMotion) -> list[ToolChange]:
    """Those between operations of different tools that have names."""
    found: list[ToolChange] = []
    time, tool = 0.0, ""
    for each in () if motion.record is None else motion.record.operations:
        if each.tool and tool and each.tool != tool:
            found.append(ToolChange(time, each.tool, _stands(motion, time)))
        tool = each.tool or tool
        time += each.time_s
    return [each for each in found if 0.0 < each.time < motion.duration]


def _by_length(motion: PlannedMotion) -> Ints:
    """(k,) rows of the first set-points of a tool of another length."""
    rows: Ints = np.flatnonzero(np.diff(tool_lengths(motion, motion.setpoints))) + 1
    return rows


def _stands(motion: PlannedMotion, time: float) -> Floats:
    """(m,) where the joints are at a time, between two set-points [m, rad]."""
    share = time / motion.dt
    k = min(int(share), len(motion.setpoints) - 2)
    q: Floats = quintic(motion.setpoints, np.array([k]), np.array([min(share - k, 1.0)]), motion.dt)[0][0]
    return q


def _at_rest(motion: PlannedMotion, row: int) -> ToolChange:
    """The change before a set-point: at the slowest one beside it."""
    points = motion.setpoints
    around = np.arange(max(row - SAME, 0), min(row + SAME, len(points)))
    slowest = int(around[np.argmin(np.abs(points.qd[around] / motion.machine.limits.velocity).max(axis=1))])
    return ToolChange(float(points.t[slowest]), "", points.q[slowest])

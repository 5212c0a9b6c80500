"""A set-up verified by a full plan, with a bound, within travel and zones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import ReachError
from toolpace.common.units import format_time
from toolpace.common.value_objects import one_line
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.clamping import AS_GIVEN, Clamping
from toolpace.setup_search.trial import Task, zones_entered

LOOKS = 200_000
"""Set-points by which travel is judged at most."""
SHORTEST = 1e-3
"""Between two of them [s]."""


@dataclass(frozen=True, eq=False, repr=False)
class PlannedSetUp:
    """A set-up that was planned in full, within all travels and outside of all forbidden zones."""

    clamping: Clamping
    machine: Machine
    """With the part clamped so, and this tool."""
    duration: float
    """[s]"""
    lower_bound: float
    """Of the duration on its mesh [s]."""
    limited_by: Mapping[str, float]
    """Share of the duration in which each limit binds, largest first."""
    used: Floats
    """(m, 2) lowest and highest position of each joint [m or rad]."""
    tool_lengths: tuple[float, ...]
    """Of its tools, from the spindle nose to the tip, as they follow each other in the program [m]."""

    @property
    def gap(self) -> float:
        """How far the duration may be from the best on its mesh."""
        return self.duration / self.lower_bound - 1.0 if self.lower_bound > 0.0 else np.inf

    def __repr__(self) -> str:
        return one_line(self, f"{self.machine.name}: {self.clamping.words(self.machine)}", format_time(self.duration))


def confirmed(task: Task, clamping: Clamping) -> PlannedSetUp:
    """A clamping planned in full. Raises ToolpaceError where it is beyond travel, or no motion exists."""
    return planned(task, task.toolpath, clamping)


def given_as_written(task: Task, toolpath: ToolPath) -> PlannedSetUp:
    """The program as it is written, rotary joints and all, on the machine as it is. Raises ToolpaceError."""
    return planned(task, toolpath, AS_GIVEN)


def planned(task: Task, toolpath: ToolPath, clamping: Clamping) -> PlannedSetUp:
    """See `confirmed`."""
    from toolpace.path.axis_path import AxisPath, check_travel
    from toolpace.path.path import Path
    from toolpace.planning.planner import plan

    machine = clamping.on(task.machine, task.centre)
    axis_path = AxisPath.follow(Path.fit(toolpath, task.tip_tolerance, task.axis_tolerance, machine), machine)
    check_travel(axis_path, toolpath.source)
    trajectory = plan(axis_path, machine)
    used = positions_used(trajectory, machine, task, toolpath.source)
    lengths = np.where(np.isnan(toolpath.tool_length), machine.tool_length, toolpath.tool_length)
    return PlannedSetUp(
        clamping, machine, trajectory.duration, trajectory.lower_bound, trajectory.limited_by(), used,
        tuple(dict.fromkeys(lengths.tolist())),
    )  # fmt: skip


def positions_used(trajectory: Trajectory, machine: Machine, task: Task, source: str) -> Floats:
    """(m, 2) lowest and highest position of each joint. Raises ReachError beyond travel and in a forbidden zone."""
    points = trajectory.sample(max(SHORTEST, trajectory.duration / LOOKS))
    machine.check_travel(points.q, points.block, source)
    if zones_entered(machine, task.forbidden, points.q) > 0.0:
        names = [zone.name for zone in task.forbidden if zone.entered(machine.joints, points.q).any()]
        raise ReachError(
            f"{source or 'tool path'}: the machine would enter the forbidden zone {names[0]}; clamp the part elsewhere"
        )
    return np.stack([points.q.min(axis=0), points.q.max(axis=0)], axis=1)

"""The time of each operation: cutting, rapids, dwells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.laws import TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun
from toolpace.programs.toolpath import ToolPath


@dataclass(frozen=True)
class OperationTime:
    """The time of one operation."""

    name: str
    tool: str
    cutting: float
    """Of its ways at feed [s]."""
    rapid: float
    """Of its rapids [s]."""
    dwell: float
    """Of waiting [s]."""
    stops: int
    """Times at rest in it, or at its end, both ends of the program left out."""

    @property
    def time(self) -> float:
        """All of it [s]."""
        return self.cutting + self.rapid + self.dwell


def operation_times(trajectory: Trajectory, toolpath: ToolPath) -> list[OperationTime]:
    """The time of each operation that has a way or a dwell; none where the motion does not follow the tool path.

    A way, its stop and its dwell belong to the operation of the point that it leads to. The parts sum up to the
    duration.
    """
    count = len(toolpath.operations)
    moving = np.zeros((2, count))
    for run, law in zip(trajectory.axis_path.runs, trajectory.laws):
        entry = run.entries()[1]
        if not len(entry) or entry.max() >= len(toolpath):
            return []
        moving += _of_run(run, law, toolpath)
    cutting, rapid = moving.tolist()
    dwell = np.bincount(toolpath.operation, toolpath.dwell, count).tolist()
    stops = np.bincount(toolpath.operation[1:-1], toolpath.stop[1:-1], count).tolist()
    ways = np.bincount(toolpath.operation[1:], minlength=count)
    return [
        OperationTime(each.name, each.tool, cutting[k], rapid[k], dwell[k], round(stops[k]))
        for k, each in enumerate(toolpath.operations)
        if ways[k] or dwell[k] > 0.0
    ]


def _of_run(run: AxisRun, law: TimeLaw, toolpath: ToolPath) -> Floats:
    """(2, operations) time at feed and at rapid of each operation within one run [s]."""
    start, entry = run.entries()
    count = len(toolpath.operations)
    kind: Ints = toolpath.operation[entry] + count * toolpath.rapid[entry]
    first = np.flatnonzero(np.concatenate([[True], np.diff(kind) != 0]))
    times = np.concatenate([[0.0], law.times_at(start[first[1:]]), [law.duration]])
    return np.bincount(kind[first], np.diff(times), 2 * count).astype(np.float64).reshape(2, count)

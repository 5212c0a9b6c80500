"""The time at which each block of a program is run, from the set-points of its plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

AXIS = 0.1
"""Length [m] by which a change of the tool axis is weighed against one of the tip."""


@dataclass(frozen=True)
class Passes:
    """Stretches of points that belong to one block, in the order in which they are run; a loop's block has several."""

    block: Ints
    """(k,) line number."""
    first: Ints
    """(k,) first of its points; its way begins at the point before."""
    last: Ints
    """(k,) last of its points."""
    rapid: Bools
    """(k,) whether all of it is a rapid."""
    mixed: Bools
    """(k,) whether it has rapids and feeds: cycles do."""
    once: Bools
    """(k,) whether its block is run once only."""

    @classmethod
    def of(cls, toolpath: ToolPath) -> Passes:
        """The passes of a program; the first point, where it begins, belongs to none."""
        block, rapid = toolpath.block[1:], toolpath.rapid[1:]
        head = np.flatnonzero(np.diff(block, prepend=block[0] - 1)) + 1
        last = np.append(head[1:] - 1, len(block))
        rapids = np.add.reduceat(rapid.astype(np.int64), head - 1)
        count = last - head + 1
        names, runs = np.unique(toolpath.block[head], return_counts=True)
        once = np.isin(toolpath.block[head], names[runs == 1])
        return cls(toolpath.block[head], head, last, rapids == count, (rapids > 0) & (rapids < count), once)

    def asked_times(self, toolpath: ToolPath) -> Floats:
        """(k,) what the program's feeds make of each pass [s]: the least time that its ways can take."""
        least = np.maximum(toolpath.way_length[1:] / toolpath.feed[1:], toolpath.least_time[1:])
        times: Floats = np.add.reduceat(least, self.first - 1)
        return times

    def planned_times(self, toolpath: ToolPath, points: SetPoints) -> Floats:
        """(k,) how long the plan is on the way of each pass [s], dwells left out.

        Raises UsageError where the set-points name other blocks than the program.
        """
        ends = self.ends(toolpath, points)
        starts = np.concatenate([points.t[:1], ends[:-1]])
        waits = np.add.reduceat(toolpath.dwell[1:], self.first - 1)
        waits[0] += toolpath.dwell[0]
        times: Floats = ends - starts - waits
        return times

    def ends(self, toolpath: ToolPath, points: SetPoints) -> Floats:
        """(k,) when each pass ends [s], its dwell included: between two set-points, where the end of the block lies.

        Blocks shorter than a time step lie between the same two.
        """
        rows = self._last_rows(points)
        before, behind = pose(points.tip[rows], points.axis[rows]), rows + 1
        step = pose(points.tip[behind], points.axis[behind]) - before
        end = pose(toolpath.tip[self.last], toolpath.axis[self.last])
        length = (step**2).sum(axis=1)
        share = ((end - before) * step).sum(axis=1) / np.maximum(length, 1e-300)
        share = np.where(length > 0.0, np.clip(share, 0.0, 1.0), 0.5)
        times = points.t[rows] + share * (points.t[behind] - points.t[rows])
        times[-1] = points.t[-1]
        found: Floats = np.maximum.accumulate(times)
        return found

    def _last_rows(self, points: SetPoints) -> Ints:
        """(k,) the last set-point of each pass; of a pass that has none, that of the one before."""
        heads = np.flatnonzero(np.diff(points.block, prepend=points.block[0] - 1))
        tails = np.append(heads[1:], len(points)) - 1
        named = points.block[heads]
        rows = np.zeros(len(self.block), dtype=np.int64)
        run, row = 0, 0
        for k, block in enumerate(self.block.tolist()):
            if run < len(named) and named[run] == block:
                row = int(tails[run])
                run += 1
            rows[k] = row
        if run < len(named):
            raise UsageError(
                f"the set-points name block {int(named[run])} where the program has none: they are of another "
                "program; plan again"
            )
        return np.minimum(rows, len(points) - 2)


def pose(tip: Floats, axis: Floats) -> Floats:
    """(n, 6) tip and tool axis as one place [m]."""
    place: Floats = np.hstack([tip, AXIS * axis])
    return place

"""A joint path over time from recorded set-points.

Its parameter is the time of the plan. Between two set-points each joint is the polynomial of degree five with position,
velocity and acceleration of both.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import QuinticAxisRun
from toolpace.programs.toolpath import ToolPath

SHORTEST = 1e-3
"""Share of a time step below which the last one is a part of that before it: a plan ends between two set-points."""
SEEN = 1e-6
"""Joint motion by which the motion of the tip is seen [m or rad]."""


class RecordedRun(QuinticAxisRun):
    """Set-points with one tool, by the time of the plan."""

    def __init__(self, t: Floats, jets: Floats, block: Ints, feed: Floats, machine: Machine) -> None:
        """Take times (n,) [s], joints with two derivatives (3, n, m), block (n,) and its feed (n,) [m/s] of each, inf
        where it is not known; `machine` has the tool of the run."""
        super().__init__(t, jets, np.inf)
        self.block, self.feed, self.machine = block, feed, machine
        self.tool_length = machine.tool_length
        self.blocks = len(np.unique(block))

    def _index(self, s: Floats) -> Ints:
        """(n,) the set-point at or before times s (n,)."""
        at = np.searchsorted(self.points, s, side="right") - 1
        return np.clip(at, 0, len(self.points) - 1).astype(np.int64)

    def speed_cap(self, s: Floats) -> Floats:
        return self.with_cap(s)[1]

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        jets, feed = self.evaluate(s), self.feed[self._index(s)]
        step = SEEN / np.maximum(np.abs(jets[1]).max(axis=1), 1e-12)[:, None]
        ends = [self.machine.forward(jets[0] + sign * step * jets[1])[0] for sign in (0.5, -0.5)]
        speed = np.linalg.norm(ends[0] - ends[1], axis=1) / step[:, 0]
        return jets, np.divide(feed, speed, where=speed > 0.0, out=np.full(len(s), np.inf))

    def block_at(self, s: Floats) -> Ints:
        line: Ints = self.block[self._index(s)]
        return line


def recorded_path(points: SetPoints, machine: Machine, duration: float, toolpath: ToolPath | None) -> AxisPath:
    """The path of set-points of a plan that takes `duration` [s], a run a tool; feeds are those of the program.

    Raises UsageError where the set-points are not of this machine, or of this duration.
    """
    if points.joints != machine.joints:
        raise UsageError(
            f"set-points of {', '.join(points.joints)}, and machine {machine.name} has {', '.join(machine.joints)}"
        )
    if len(points) < 2 or not points.t[-2] <= duration <= points.t[-1] * (1.0 + 1e-9):
        raise UsageError(f"{len(points)} set-points do not end where the plan of {duration:g} s does")
    t, jets = points.t.copy(), np.stack([points.q, points.qd, points.qdd])
    kept = np.ones(len(t), dtype=bool)
    # the plan has come to rest at its end, wherever the last set-point lies
    kept[-2] = len(t) == 2 or duration - t[-2] > SHORTEST * (t[1] - t[0])
    t[-1], jets[1:, -1] = duration, 0.0
    feed = feeds_of(points.block, toolpath)
    lengths = points.tool_length if len(points.tool_length) else np.full(len(t), machine.tool_length)
    t, jets, block, feed, lengths = t[kept], jets[:, kept], points.block[kept], feed[kept], lengths[kept]
    # the tool is changed at rest: the step to the first set-point with another one is the last of the run before
    borders = [0, *(np.flatnonzero(np.diff(lengths)) + 1), len(t) - 1]
    parts = [slice(a, b + 1) for a, b in pairwise(borders) if b > a]
    machines = machine.with_tools(lengths[part.start] for part in parts)
    runs = (RecordedRun(t[p], jets[:, p], block[p], feed[p], each) for p, each in zip(parts, machines))
    return AxisPath(tuple(runs), machine.joints, machine)


def feeds_of(block: Ints, toolpath: ToolPath | None) -> Floats:
    """(n,) feed of blocks (n,) of a program [m/s]: the lowest of each; inf without a feed, and without a program."""
    if toolpath is None:
        return np.full(len(block), np.inf)
    lines, which = np.unique(toolpath.block, return_inverse=True)
    lowest = np.full(len(lines), np.inf)
    np.minimum.at(lowest, which, np.where(toolpath.rapid, np.inf, toolpath.feed))
    at = np.clip(np.searchsorted(lines, block), 0, len(lines) - 1)
    return np.where(lines[at] == block, lowest[at], np.inf)

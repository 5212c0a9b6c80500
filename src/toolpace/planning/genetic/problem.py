"""Intervals of a run between reference points, with the limits inside them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.machine.limits import KINDS, Limits
from toolpace.path.axis_run import AxisRun

NODES = 33
"""Least points of an interval at which the genetic algorithm looks at the limits; the result is checked at more."""
NODES_A_HINT = 8
"""Points for each stretch between two hints of the run, inside which it is smooth."""
MOST_NODES = 257
HINTS_AN_INTERVAL = 3
"""Stretches between hints that an interval spans at most, where the number of intervals is not given."""


def reference_points(run: AxisRun, intervals: int | npt.ArrayLike | None) -> Floats:
    """The points between which the law is one quintic: the breaks of the run, and equal steps between them.

    `intervals`: the least number of intervals, or the points themselves; by default 31, the paper's, or as many as the
    detail of the path asks for.
    """
    if intervals is None or isinstance(intervals, int | np.integer):
        count = max(31, len(run.hints) // HINTS_AN_INTERVAL) if intervals is None else int(intervals)
        if count < 2:
            raise UsageError(f"genetic: {count} intervals; there must be at least 2")
        ends = np.concatenate([[run.s0], run.breaks, [run.s1]])
        longest = (run.s1 - run.s0) / count
        pieces = np.maximum(np.ceil(np.diff(ends) / longest - 1e-9), 1).astype(int)
        steps = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(ends, ends[1:], pieces)]
        return np.concatenate([*steps, [run.s1]])
    points = np.asarray(intervals, dtype=float)
    inner = points[(points > run.s0) & (points < run.s1)]
    points = np.union1d(np.concatenate([[run.s0], inner, [run.s1]]), run.breaks)
    if len(points) < 3:
        raise UsageError(f"genetic: no reference point inside the run from {run.s0:g} to {run.s1:g}")
    return points


class Intervals:
    """A run cut at its reference points (n + 1,), as the kernels take it: what each limit asks for at the nodes."""

    def __init__(self, run: AxisRun, limits: Limits, points: Floats, rest: tuple[bool, bool]) -> None:
        self.run, self.limits, self.points = run, limits, points
        n, m = len(points) - 1, len(limits)
        inside = np.diff(np.searchsorted(run.hints, points)) + 1
        nodes = int(np.clip(NODES_A_HINT * inside.max(initial=1) + 1, NODES, MOST_NODES))
        tau = np.linspace(0.0, 1.0, nodes)
        place = np.broadcast_to(tau, (n, nodes)).copy()
        # from rest the way grows with the cube of time
        place[0] = tau**3 * (4.0 - 3.0 * tau) if rest[0] else tau
        place[-1] = 1.0 - (1.0 - tau) ** 3 * (1.0 + 3.0 * tau) if rest[1] else tau
        h = np.diff(points)
        self.x = place * h[:, None]
        s = points[:-1, None] + self.x
        s[:, -1] = np.nextafter(points[1:], -np.inf)
        q = run.evaluate(s.ravel())
        v, a, j = (getattr(limits, kind) for kind in KINDS)
        table = np.stack([q[1] / v, q[2] / a, q[1] / a, q[3] / j, 3.0 * q[2] / j, q[1] / j], axis=1)
        self.share = np.ascontiguousarray(table.reshape(n, nodes, 6, m))
        self.pace = 1.0 / run.speed_cap(s.ravel()).reshape(n, nodes)

    def interval_name(self, k: int) -> str:
        """Where interval k lies, for messages."""
        low, high = self.points[k], self.points[k + 1]
        block = int(self.run.block_at(np.array([low]))[0])
        where = f" (block {block})" if block else ""
        return f"interval {k + 1} of {len(self.x)}, s = {low:.6g} to {high:.6g}{where}"

    def limit_name(self, which: int) -> str:
        """What a kernel means by the number of a limit."""
        if which < 0:
            return "running backwards"
        if which == 0:
            return "the feed cap"
        kind, joint = divmod(which - 1, len(self.limits))
        return f"the {KINDS[kind]} limit of {self.limits.joints[joint]}"

"""A trajectory sampled for a follower: joints, parameter and feed at equal steps of its own time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolpace.arrays import Floats, Ints
from toolpace.axispath.run import AxisRun
from toolpace.machine.machine import Machine
from toolpace.trajectory import Trajectory

CHUNK = 50_000
"""Samples that are worked out at once, to keep memory low."""
AT_REST = 2
"""Samples after the end, so that the spline through them comes to rest as the plan does."""
TURN = 1e-6
"""Joint motion by which the motion of the tip is seen [m or rad]."""
STANDS = 1e-9
"""Motion of the tip by the parameter below which it stands, over that of the joints: it then has no feed."""


@dataclass(frozen=True, eq=False)
class Samples:
    """The path in time, at n equal steps; the pace may be less than the plan's."""

    step: float
    """Between two samples [s]."""
    q: Floats
    """(n, m) joints."""
    s: Floats
    """(n,) parameter of the path, running on from run to run."""
    feed: Floats
    """(n,) most speed of the tip [m/s]; inf where there is none."""
    reach: Floats
    """(2,) most motion of the tip for a motion of the linear joints together [m/m], and of a rotary one [m/rad]."""


def samples_of(trajectory: Trajectory, machine: Machine, step: float, pace: float) -> Samples:
    """Sample a trajectory, slowed to a `pace`, every `step` [s]; the last lie after its end."""
    count = int(np.ceil(trajectory.duration / pace / step)) + 1 + AT_REST
    q, s = np.empty((count, len(machine.joints))), np.empty(count)
    feed, offsets = np.empty(count), offsets_of(trajectory.axis_path.runs)
    for begin in range(0, count, CHUNK):
        part = slice(begin, min(begin + CHUNK, count))
        t = np.minimum(pace * step * np.arange(part.start, part.stop), trajectory.duration)
        run, place = trajectory.run_at(t), trajectory.parameter(t)
        q[part], s[part] = trajectory.at(t).q, place + offsets[run]
        feed[part] = feeds(trajectory, machine, run, place)
    looked = q[:: max(1, count // 2000)]
    return Samples(step, q, s, feed, reach_of(machine, looked))


def offsets_of(runs: Sequence[AxisRun]) -> Floats:
    """(runs,) what is added to the parameter of each run so that it runs on from the one before; 0 for the first."""
    return np.cumsum([0.0, *(before.s1 - after.s0 for before, after in pairwise(runs))])


def feeds(trajectory: Trajectory, machine: Machine, run: Ints, s: Floats) -> Floats:
    """The feed (n,) [m/s] where the parameter of run (n,) is s (n,)."""
    feed = np.full(len(s), np.inf)
    for k in np.unique(run):
        at, axis_run = np.flatnonzero(run == k), trajectory.axis_path.runs[k]
        place = np.clip(s[at], axis_run.s0, axis_run.s1)
        jets, cap = axis_run.with_cap(place)
        moving = np.abs(jets[1]).max(axis=1)
        scale = TURN / np.maximum(moving, 1e-12)[:, None]
        way = machine.forward(jets[0] + scale * jets[1])[0] - machine.forward(jets[0] - scale * jets[1])[0]
        tip = np.linalg.norm(way, axis=1) / (2.0 * scale[:, 0])
        moves = np.isfinite(cap) & (tip > STANDS * moving)
        feed[at[moves]] = cap[moves] * tip[moves]
    return feed


def reach_of(machine: Machine, q: Floats) -> Floats:
    """`Samples.reach` at joints (n, m)."""
    tip, columns = machine.forward(q)[0], []
    for j in range(q.shape[1]):
        moved = q.copy()
        moved[:, j] += TURN
        columns.append((machine.forward(moved)[0] - tip) / TURN)
    linear = np.stack([columns[j] for j in machine.linear], axis=2)
    turning = max(float(np.linalg.norm(columns[j], axis=1).max()) for j in machine.rotary)
    return np.array([float(np.linalg.norm(linear, ord=2, axis=(1, 2)).max()), turning])

"""A trajectory sampled at equal time steps for a follower, and the joints that it moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time
from toolpace.kernels.follow.layout import JOINTS
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine, check_machine
from toolpace.motion.plan_folder import RecordedRun
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun

CHUNK = 50_000
"""Samples that are worked out at once, to keep memory low."""
SAMPLES_A_PERIOD = 4
"""Samples of the path a period."""
AT_REST = 2
"""Samples after the end, so that the spline through them comes to rest as the plan does."""
LOOKED = 2000
"""Samples at which it is looked at how far a joint moves the tip."""
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
    """(2,) most motion of the tip for a motion of the linear joints together [m/m], and of a rotary one [m/rad], with
    the longest tool."""
    tools: Floats
    """(k, 2) time of the path from which on a tool is in the spindle [s], and by how much it is longer than that of the
    machine file [m]."""


def samples_of(trajectory: Trajectory, driven: FollowedJoints, period: float, pace: float) -> Samples:
    """Sample a trajectory, slowed to a `pace`, for set-points every `period` [s]; the last lie after its end.

    Where it is known at set-points, these are the samples: in between it has been made up.
    """
    step = recorded_step(trajectory, period) / pace or period / SAMPLES_A_PERIOD
    count = int(np.ceil(trajectory.duration / pace / step)) + 1 + AT_REST
    q, s = np.empty((count, len(trajectory.joints))), np.empty(count)
    feed, offsets = np.full(count, np.inf), offsets_of(trajectory.axis_path.runs)
    machines = [] if driven.machine is None else driven.machine.with_tools(trajectory.axis_path.tool_lengths)
    for begin in range(0, count, CHUNK):
        part = slice(begin, min(begin + CHUNK, count))
        t = np.minimum(pace * step * np.arange(part.start, part.stop), trajectory.duration)
        run, place = trajectory.run_at(t), trajectory.parameter(t)
        q[part], s[part] = trajectory.at(t).q, place + offsets[run]
        if machines:
            feed[part] = feeds(trajectory, machines, run, place)
    if driven.machine is None:
        return Samples(step, q, s, feed, np.array([1.0, 0.0]), np.zeros((1, 2)))
    looked = slice(None, None, max(1, count // LOOKED))
    tools = tools_of(trajectory, driven.machine, pace)
    reach = [reach_of(machine, q[looked]) for machine in {id(each): each for each in machines}.values()]
    return Samples(step, q, s, feed, np.max(reach, axis=0), tools)


def tools_of(trajectory: Trajectory, machine: Machine, pace: float) -> Floats:
    """`Samples.tools` of a trajectory slowed to a `pace`: a row where the length changes."""
    lengths = trajectory.axis_path.tool_lengths
    longer = np.where(np.isnan(lengths), 0.0, lengths - machine.tool_length)
    changed = np.flatnonzero(np.diff(longer, prepend=np.nan) != 0.0)
    return np.column_stack([np.where(changed == 0, 0.0, trajectory.starts[changed] / pace), longer[changed]])


def recorded_step(trajectory: Trajectory, period: float) -> float:
    """Time between the set-points that a trajectory was read from [s]; 0 where it is known everywhere.

    Raises UsageError where it is longer than a `period` [s]: the spline through them would begin too fast.
    """
    first = trajectory.axis_path.runs[0]
    if not isinstance(first, RecordedRun):
        return 0.0
    step = float(first.points[1] - first.points[0])
    if step > period * (1.0 + 1e-9):
        raise UsageError(
            f"follower: the set-points of the plan are {format_time(step)} apart, and a period of"
            f" {format_time(period)}; plan with --dt {1e3 * period:g}ms or less, or give a longer period"
        )
    return step


def offsets_of(runs: Sequence[AxisRun]) -> Floats:
    """(runs,) what is added to the parameter of each run so that it runs on from the one before; 0 for the first."""
    return np.cumsum([0.0, *(before.s1 - after.s0 for before, after in pairwise(runs))])


def feeds(trajectory: Trajectory, machines: Sequence[Machine], run: Ints, s: Floats) -> Floats:
    """The feed (n,) [m/s] where the parameter of run (n,) is s (n,); a machine a run, with the tool of that run."""
    feed = np.full(len(s), np.inf)
    for k in np.unique(run):
        at, axis_run, machine = np.flatnonzero(run == k), trajectory.axis_path.runs[k], machines[k]
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


@dataclass(frozen=True, eq=False)
class FollowedJoints:
    """The joints as a law has them: five columns, of which the first `used` are there; the others stand."""

    used: int
    limits: Floats
    """(3, 5) velocity, acceleration and jerk; inf for what is not there."""
    machine: Machine | None
    """None where only limits are known: nothing can be measured of a tool then, nor corrected."""
    frame: Floats
    """(27,) of the kinematic chain; zeros without a machine."""
    group: Ints
    """(3,)"""
    place: Ints
    """(5,)"""

    @property
    def is_rotary(self) -> Bools:
        """(5,)"""
        return self.machine.is_rotary if self.machine is not None else np.zeros(JOINTS, dtype=bool)

    @property
    def travel(self) -> Floats:
        """(5, 2) lowest and highest position [m or rad]."""
        everywhere = np.tile([-np.inf, np.inf], (JOINTS, 1))
        return self.machine.travel if self.machine is not None else everywhere

    def padded(self, values: Floats) -> Floats:
        """Values (n, used) with columns of zeros to (n, 5)."""
        return np.pad(values, ((0, 0), (0, JOINTS - self.used)))


def followed_joints_of(source: Machine | Limits, joints: tuple[str, ...]) -> FollowedJoints:
    """The joints of a machine or of limits that a trajectory of some `joints` is followed with. Raises UsageError."""
    if not isinstance(source, Limits):
        check_machine(source, "follower", "a Machine, or Limits")
    whose = "limits" if isinstance(source, Limits) else f"machine {source.name}"
    of_names = isinstance(source, Limits) and source.joints == tuple(f"q{i + 1}" for i in range(len(source)))
    if source.joints != joints and not (of_names and len(source.joints) == len(joints)):
        cure = "limits of the same joints" if isinstance(source, Limits) else "the machine that it was planned on"
        raise UsageError(
            f"follower: the trajectory moves {', '.join(joints)}, {whose} has {', '.join(source.joints)}; give {cure}"
        )
    if len(joints) > JOINTS:
        raise UsageError(f"follower: the trajectory moves {len(joints)} joints; at most {JOINTS} can be followed")
    limits = source.constants if isinstance(source, Limits) else source.limits
    for kind in KINDS[1:]:
        for joint, limit in zip(joints, getattr(limits, kind)):
            if not np.isfinite(limit):
                raise UsageError(f"follower: {joint} has no limit of {kind}; give {whose} one")
    rows = np.full((3, JOINTS), np.inf)
    rows[:, : len(joints)] = [limits.velocity, limits.acceleration, limits.jerk]
    if isinstance(source, Limits):
        return FollowedJoints(len(joints), rows, None, np.zeros(27), np.zeros(3, dtype=np.int64), np.arange(JOINTS))
    chain = source.geometry
    return FollowedJoints(JOINTS, rows, source, chain.frame.ravel(), chain.group, chain.place)

"""Trajectories: joint motion over time, from a joint path and its time laws; and the time of each operation."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints, numbers
from toolpace.common.errors import UsageError
from toolpace.common.units import SECONDS, ask_about_unit
from toolpace.common.value_objects import counted, named, one_line
from toolpace.common.workers import Workers
from toolpace.machine.limits import Limits
from toolpace.motion import Motion, Usage, closer_look, jerk_jumps
from toolpace.motion.active_limits import BINDING, NOTHING, ActiveLimits, active_limits
from toolpace.motion.laws import TimeLaw
from toolpace.motion.sampling import Sampling
from toolpace.motion.setpoints import ROWS, SetPoints
from toolpace.motion.torques_over_time import continuous_shares, with_ratings
from toolpace.motion.usage import put_joint_motion
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

LONGEST_STEP = 0.2
"""Between set-points [s] that is not asked about: more is a time in ms."""
INTERPOLATED = "of set-points: between them jerks are those of an interpolation, and may exceed what the plan tells"
"""Note of a motion that was loaded."""


@dataclass(frozen=True)
class OpenPlace:
    """A stretch of the motion where the lower bound leaves room: it may be faster there, or the bound too low."""

    start: float
    end: float
    """When it is passed [s]."""
    seconds: float
    """At most so much could be gained there [s]."""
    block: int
    """Block of the program at its start; 0 where there is none."""


@dataclass(frozen=True)
class Skipped:
    """A stretch of the path that the tip leaves out where a replanned motion comes back onto it."""

    start: float
    end: float
    """Parameters of the run, as `replan` takes one to rejoin at."""
    length: float
    """Of the path between [m]; without a machine of the joints' way."""
    off: float
    """How far the path is from the way of the tip there, at most [m]: more than the 10 um that are no leaving out."""
    first_block: int
    last_block: int
    """Blocks of the program at both ends; 0 where there is none."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Motion along an AxisPath: one time law a run, with the dwells between them. It can judge itself."""

    axis_path: AxisPath
    limits: Limits
    laws: tuple[TimeLaw, ...]
    planner: str = "optimal"
    lower_bound: float = 0.0
    """No plan on this mesh, which holds the limits at its nodes, is faster than this [s]; 0 when unknown.

    Another mesh may allow less: of any motion at all `continuous_bound` speaks.
    """
    continuous_bound: float = 0.0
    """No motion that keeps the limits all along the path is faster than this [s], on no mesh; 0 when unknown."""
    open_places: tuple[OpenPlace, ...] = ()
    """Where most of the gap between duration and lower bound lies, in the order of time."""
    notes: tuple[str, ...] = ()
    """Sentences on the runs whose duration was far from its bound: why, and what came of another try."""
    skipped: tuple[Skipped, ...] = ()
    """What a replan leaves out of the path, in its order; empty where it follows all of it."""
    mesh_points: int = 0
    solve_seconds: float = 0.0
    found_usage: Usage | None = None
    """What `usage` tells where the motion is read from set-points: it was found when these were planned."""
    pricing: Callable[[Trajectory], dict[str, float]] | None = None
    """Works out `prices`; None where no planner is at hand that could."""
    starts: Floats = field(init=False)
    """(runs,) when each run starts [s]."""
    duration: float = field(init=False)
    """[s], dwells included."""

    def __post_init__(self) -> None:
        lengths = np.array([law.duration + run.dwell for law, run in zip(self.laws, self.axis_path.runs, strict=True)])
        ends = self.axis_path.first_dwell + np.cumsum(lengths)
        object.__setattr__(self, "starts", np.concatenate([[self.axis_path.first_dwell], ends[:-1]]))
        object.__setattr__(self, "duration", float(ends[-1]))
        self.starts.flags.writeable = False

    def __repr__(self) -> str:
        blocks = sum(run.blocks for run in self.axis_path.runs)
        return one_line(
            self,
            f"{self.duration:.6g} s",
            named(self.joints),
            counted(blocks, "block") if blocks else "",
            f"gap {self.gap * 100.0:.2g} % on its mesh" if self.lower_bound > 0.0 else "",
            f"planner {self.planner}",
            f"leaves out {sum(each.length for each in self.skipped):.3g} m of the path" if self.skipped else "",
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.axis_path.joints

    @property
    def gap(self) -> float:
        """How far the duration may be from the best on this mesh: duration / lower bound - 1; inf without a bound."""
        return self.duration / self.lower_bound - 1.0 if self.lower_bound > 0.0 else np.inf

    def _state(self, t: Floats) -> tuple[Ints, Floats]:
        """Run and state (4, n) of s at times t (n,); at rest while dwelling."""
        if (t[1:] < t[:-1]).any():
            # laws take their times in order
            order = np.argsort(t, kind="stable")
            back = np.argsort(order)
            run, state = self._state(t[order])
            return run[back], state[:, back]
        run = self.run_at(t)
        begins = np.flatnonzero(np.diff(run, prepend=-1))
        found = []
        for begin, end in pairwise([*begins.tolist(), len(t)]):
            k = run[begin]
            law, local = self.laws[k], t[begin:end] - self.starts[k]
            now = law.at(np.clip(local, 0.0, law.duration))
            now[1:, (local < 0.0) | (local > law.duration * (1.0 + 1e-12))] = 0.0
            found.append(now)
        return run, found[0] if len(found) == 1 else np.concatenate([np.zeros((4, 0)), *found], axis=1)

    def run_at(self, t: npt.ArrayLike) -> Ints:
        """Index of the run at a time or at times t (n,) [s], in the shape of t; its dwell is part of it.

        Raises UsageError as `at`.
        """
        run: Ints = np.clip(np.searchsorted(self.starts, _times(t), side="right") - 1, 0, len(self.laws) - 1)
        return run

    def parameter(self, t: npt.ArrayLike) -> Floats:
        """Parameter s of the run that `run_at` tells, at a time or at times t (n,) [s], in the shape of t.

        Raises UsageError as `at`.
        """
        times = _times(t)
        s: Floats = self._state(times.ravel())[1][0]
        return s.reshape(times.shape)

    def state(self, t: float) -> tuple[float, float, float]:
        """s of the run, ds/dt and d2s/dt2 at one time [s]: where a replanning starts. Raises UsageError as `at`."""
        times = _times(t)
        if times.ndim:
            raise UsageError(f"trajectory: {len(times)} times where one is expected; give a number")
        s, v, a, _ = self._state(times.ravel())[1][:, 0]
        return float(s), float(v), float(a)

    def at(self, t: npt.ArrayLike) -> Motion:
        """Motion of the joints, each array (joints,) at one time t [s], (n, joints) at times t (n,) in any order.

        Before the start and after the end the machine rests. Raises UsageError for what is no time.
        """
        times = _times(t)
        motion = self._motion_in_pieces(times.ravel())
        return motion if times.ndim else Motion(motion.q[0], motion.qd[0], motion.qdd[0], motion.qddd[0])

    def _motion_in_pieces(self, t: Floats) -> Motion:
        """Motion at times t, without room for all derivatives of all of them at once."""
        m = len(self.joints)
        motion, block = Motion(*(np.empty((len(t), m)) for _ in range(4))), np.empty(len(t), dtype=np.int64)

        def fill(start: int) -> None:
            part = slice(start, start + ROWS)
            of_part = Motion(motion.q[part], motion.qd[part], motion.qdd[part], motion.qddd[part])
            self.put_motion(t[part], of_part, block[part])

        Workers().each(fill, range(0, len(t), ROWS))
        return motion

    def put_motion(self, t: Floats, motion: Motion, block: Ints) -> Ints:
        """Put the motion and the blocks at times t (n,) where they belong; return the run of each."""
        run, state = self._state(t)
        alone = len(run) > 0 and bool((run == run[0]).all())
        for k in run[:1] if alone else np.unique(run):
            # most stretches of time are of one run, and need no picking
            of_run = slice(None) if alone else run == k
            axis_run, now = self.axis_path.runs[k], state[:, of_run]
            path = axis_run.evaluate(np.clip(now[0], axis_run.s0, axis_run.s1))
            put_joint_motion(path, now, motion, of_run)
            block[of_run] = axis_run.block_at(now[0])
        return run

    def tip(self, t: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Tip [m] and axis, in the workpiece frame, of the tool in the spindle: (3,) at one time t [s], (n, 3) at times
        t (n,).

        Raises UsageError as `at`, and without a machine.
        """
        if self.axis_path.machine is None:
            raise UsageError("trajectory: without a machine there is no tool tip; plan a Path on a Machine")
        q = self.at(t).q
        tip, axis = self._tool(self.axis_path.machine, np.atleast_1d(_times(t)), np.atleast_2d(q))
        return (tip, axis) if q.ndim > 1 else (tip[0], axis[0])

    def _tool(self, machine: Machine, t: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Tip [m] and axis (n, 3) of the tool in the spindle at times t (n,), with the joints at q (n, m)."""
        return machine.forward(q, self.axis_path.tool_lengths[self.run_at(t)])

    def sample(self, dt: float = 1e-3, *, on_grid: bool = False) -> SetPoints:
        """Set-points at equal steps dt [s]; the last lies at or just after the end, at rest.

        With `on_grid` they are rounded, positions by at most 2^-43 m or rad, so that they take little room on disk
        (motion/sampling.py). Raises UsageError where they would not fit into memory.
        """
        sampling = Sampling(self, dt, on_grid=on_grid)
        ask_about_unit(sampling.dt, LONGEST_STEP, "set-points: time step dt", SECONDS)
        return sampling.all()

    @cached_property
    def _judgement(self) -> tuple[Floats, dict[str, float]]:
        """Peak ratios (k,), in the order of `Limits.names`, and the time in which each of them is what binds [s]."""
        names, m = self.limits.names, len(self.joints)
        jerks, count = self.limits.orders == 2, len(names)
        peak, times, of_cap = np.zeros(count), np.zeros(count + 1), defaultdict[str, float](float)
        for run, law in zip(self.axis_path.runs, self.laws):
            # where acceleration may jump, jerk is no limit that could bind
            jumpy = law.jumps.size > 0
            peak[1 + 2 * m : 1 + 3 * m][jerk_jumps(run, self.limits, law)] = np.inf
            for probe in law.probes():
                ratios, _, between = closer_look(run, self.limits, law, probe)
                peak = np.maximum(peak, ratios.max(axis=0))
                if len(between):
                    peak = np.maximum(peak, between.max(axis=0))
                first = np.where(jerks & jumpy, 0.0, ratios).argmax(axis=1)
                binds = ratios[np.arange(len(first)), first] >= BINDING
                times += np.bincount(np.where(binds, first, count), probe.share, len(times))
                capped = binds & (first == 0)
                which, words = run.cap_names(probe.state[0][capped])
                for word, share in zip(words, np.bincount(which, probe.share[capped], len(words))):
                    of_cap[word] += float(share)
        found = {**dict(of_cap), **dict(zip(names[1:], map(float, times[1:-1])))}
        return peak, {**{name: time for name, time in found.items() if time > 0.0}, NOTHING: float(times[-1])}

    def usage(self) -> Usage:
        """Peak value over limit in continuous time, between the set-points and nodes too."""
        if self.found_usage is not None:
            return self.found_usage
        peak, m = self._judgement[0], len(self.joints)
        velocity, acceleration, jerk = (
            dict(zip(self.joints, map(float, peak[1 + i * m : 1 + (i + 1) * m]))) for i in range(3)
        )
        rows = {each.name: float(value) for each, value in zip(self.limits.rows, peak[1 + 3 * m :])}
        return Usage(float(peak[0]), velocity, acceleration, jerk, rows | self._continuous)

    @cached_property
    def _continuous(self) -> dict[str, float]:
        return continuous_shares(self.axis_path, self.limits, self.laws)

    def limited_by(self) -> dict[str, float]:
        """Limits that bind: the share of the duration in which each does, largest first."""
        times = with_ratings(self._judgement[1], self._continuous)
        dwell = self.axis_path.first_dwell + sum(run.dwell for run in self.axis_path.runs)
        if dwell > 0.0:
            times["dwell"] = dwell
        return {n: t / self.duration for n, t in sorted(times.items(), key=lambda item: -item[1]) if t > 0.0}

    def active(self) -> ActiveLimits:
        """How much of each limit is used, over time and path, as arrays; `active().table()` names what binds when.

        At the states at which the laws are probed: of a spline at least nine a cell of its mesh, so that a motion of a
        million cells takes gigabytes.
        """
        return active_limits(self.axis_path, self.limits, self.laws, self.starts)

    def prices(self) -> dict[str, float]:
        """The time that one percent more of each limit would gain [s], by the names of `limited_by`, largest first.

        Of limits that are infinite nothing is told. From the multipliers at the optimum (planning/prices.py): it costs
        a solve on the plan's mesh. Ten percent more gain a little less than ten times as much. Raises UsageError for
        the motion of a planner other than `optimal`, and for one that was loaded or planned back onto its path.
        """
        if self.pricing is None:
            raise UsageError("prices: they are of a motion as `plan` returns it; plan the path again")
        return self.pricing(self)

    @classmethod
    def load(cls, folder: str | os.PathLike[str], *, exact: bool = False) -> Trajectory:
        """The motion in a folder that `toolpace plan --out` wrote, from its set-points, machine and program.

        With `exact` it is the plan itself, to the bit, from path and speed laws in trajectory.compact. Without, it
        passes through all set-points; between two it is the polynomial with position, velocity and acceleration of
        both, some nanometres from the plan at steps of 1 ms; where the plan's jerk jumps between two set-points, the
        polynomial's exceeds it, and `notes` says so. `usage` and bounds are those that plan.json tells. Raises
        UsageError where a file is missing, was changed, or is of another plan.
        """
        from toolpace.motion.laws import ClockLaw
        from toolpace.motion.plan_folder import read_plan_folder

        found = read_plan_folder(folder, exact)
        machine = found.path.machine
        assert machine is not None
        by_clock = tuple(ClockLaw(np.array([run.s0, *run.breaks, run.s1])) for run in found.path.runs)
        return cls(
            found.path,
            machine.limits.over_speed(),
            found.laws or by_clock,
            found.planner,
            found.lower_bound,
            found.continuous_bound,
            mesh_points=found.mesh_points,
            solve_seconds=found.solve_seconds,
            notes=() if exact else (INTERPOLATED,),
            found_usage=Usage(found.feed, found.velocity, found.acceleration, found.jerk, found.motor | found.curves),
        )

    def save(self, path: str | os.PathLike[str], dt: float = 1e-3) -> None:
        """Write the set-points as npz (see SetPoints), whole or not at all."""
        self.sample(dt).save(path)


def _times(t: npt.ArrayLike) -> Floats:
    """One time () or times (n,) as numbers. Raises UsageError for everything else."""
    times = numbers(t, "trajectory: time", ("n",), (), finite=False, unit="s")
    if np.isnan(times).any():
        place = f"[{int(np.argmax(np.isnan(times)))}]" if times.ndim else ""
        raise UsageError(f"trajectory: time{place} is nan; give a number of seconds, or an array (n,) of them")
    return times


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

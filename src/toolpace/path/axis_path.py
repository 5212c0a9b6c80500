"""Joint paths, from runs over a path parameter; and their check against the travel of the joints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number, numbers
from toolpace.common.errors import UsageError
from toolpace.common.value_objects import counted, named, one_line
from toolpace.path.axis_run import AxisRun
from toolpace.path.callable_run import CallableRun, check_derivatives
from toolpace.path.follow_run import FollowRun, branches_of

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly

    from toolpace.machine.machine import Machine
    from toolpace.path.path import Path

PARTS = 4
"""Looks at each piece of a path, and at the way from one hint to the next."""


@dataclass(frozen=True, eq=False, repr=False)
class AxisPath:
    """Runs one after the other, each from rest to rest."""

    runs: tuple[AxisRun, ...]
    joints: tuple[str, ...]
    machine: Machine | None = None
    first_dwell: float = 0.0
    """Time to wait before anything moves [s]."""

    @cached_property
    def tool_lengths(self) -> Floats:
        """(runs,) of the tool in the spindle in each run [m]; nan: as long as the machine's own."""
        return np.array([run.tool_length for run in self.runs])

    def machine_of(self, run: int) -> Machine | None:
        """The machine with the tool that is in the spindle in a run; None where joints are given without one."""
        return None if self.machine is None else self.machine.with_tool(float(self.tool_lengths[run]))

    def __repr__(self) -> str:
        machine = f"machine {self.machine.name}" if self.machine is not None else ""
        return one_line(self, counted(len(self.runs), "run"), named(self.joints), machine)

    @classmethod
    def from_callable(
        cls,
        f: Callable[[Floats, int], npt.ArrayLike],
        s0: float = 0.0,
        s1: float = 1.0,
        *,
        joints: Sequence[str] | None = None,
        speed_cap: float | Callable[[Floats], npt.ArrayLike] = np.inf,
        breaks: npt.ArrayLike = (),
        hints: npt.ArrayLike = (),
    ) -> AxisPath:
        """A path given by a function: f(s (n,), order) -> (n, joints), the order-th derivative for orders 0 to 3.

        `speed_cap` limits ds/dt; `breaks` names the values of s where the third derivative or the cap jumps; `hints`
        (optional) values of s between which the path is simple, such as the knots of a spline: the mesh takes no
        fewer cells. f and `speed_cap` are never called from two threads at once. PathError, with the place, where one
        derivative is not that of the order below, by differences at places along the path.
        """
        s0, s1 = number(s0, "path: s0"), number(s1, "path: s1")
        if not s1 > s0:
            raise UsageError(f"path: s runs from {s0:g} to {s1:g}; it must increase")
        at = np.unique(numbers(breaks, "path: breaks", ("k",)))
        run = CallableRun(f, s0, s1, speed_cap, at, numbers(hints, "path: hints", ("k",)))
        names = joint_names(joints, run.evaluate(np.array([s0, s1])).shape[2])
        check_derivatives(run.evaluate, s0, s1, names)
        return cls((run,), names)

    @classmethod
    def from_waypoints(
        cls,
        q: npt.ArrayLike,
        *,
        s: npt.ArrayLike | None = None,
        joints: Sequence[str] | None = None,
        speed_cap: float | Callable[[Floats], npt.ArrayLike] = np.inf,
        stop: bool = False,
    ) -> AxisPath:
        """A path through joint positions q (n, m) [m or rad], from the first to the last.

        The curve is the natural spline of degree five, four times continuously differentiable, at s (n,) ascending;
        without s, over the chord lengths in the joints, each in shares of its range. Two waypoints make a straight
        line. `stop` stops at every waypoint: straight lines, one run each. `speed_cap` limits ds/dt, as in
        `from_callable`. UsageError for repeated waypoints, for nan, and for shapes that do not fit.
        """
        from toolpace.path.axis_spline import waypoint_runs

        runs = waypoint_runs(q, s, speed_cap, stop)
        return cls(runs, joint_names(joints, runs[0].coefficients.shape[2]))

    @classmethod
    def from_spline(
        cls,
        spline: BSpline | PPoly,
        *,
        joints: Sequence[str] | None = None,
        speed_cap: float | Callable[[Floats], npt.ArrayLike] = np.inf,
    ) -> AxisPath:
        """The path of a spline of scipy.interpolate, s -> (m,) joint positions, from its first parameter to its last.

        Taken are BSpline (and what make_interp_spline and make_smoothing_spline return), CubicSpline and every other
        PPoly; of a scalar spline comes a path of one joint. Knots where the third derivative jumps become breaks.
        PathError where position, slope or curvature jumps at a knot: no motion of bounded jerk could follow.
        UsageError for what is no real spline of joints. `speed_cap` limits ds/dt, as in `from_callable`.
        """
        from toolpace.path.axis_spline import spline_run

        run = spline_run(spline, speed_cap)
        return cls((run,), joint_names(joints, run.coefficients.shape[2]))

    @classmethod
    def follow(cls, path: Path, machine: Machine) -> AxisPath:
        """The joints of a machine that carries tool tip and tool axis along a path."""
        from toolpace.machine.machine import check_machine

        check_machine(machine, "path")
        branches = branches_of(path, machine)
        machines = machine.with_tools(run.tool_length for run in path.runs)
        runs = tuple(FollowRun(run, each, branch) for run, each, branch in zip(path.runs, machines, branches))
        return cls(runs, machine.joints, machine, path.first_dwell)


def joint_names(joints: Sequence[str] | None, count: int) -> tuple[str, ...]:
    """The names that are given, or q1, q2, ... UsageError where they are not as many different ones as joints."""
    if joints is None:
        return tuple(f"q{i + 1}" for i in range(count))
    names = tuple(joints) if isinstance(joints, Iterable) else ()
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise UsageError(f"path: joints is {joints!r}; give a different name for each of {count} joints")
    if len(names) != count:
        raise UsageError(f"path: {len(names)} joint names for {count} joints")
    return names


def check_travel(path: AxisPath, source: str = "", begin: float = -np.inf) -> None:
    """Raise ReachError where a joint of the path's machine leaves its travel, naming the worst one and its line.

    `begin` is the parameter of the first run from which on it is looked at.
    """
    if path.machine is None:
        return
    samples = [_samples(run) for run in path.runs]
    samples[0] = np.append(np.clip(begin, *samples[0][[0, -1]]), samples[0][samples[0] > begin])
    positions = [run.evaluate(s)[0] for run, s in zip(path.runs, samples)]
    blocks = [run.block_at(s) for run, s in zip(path.runs, samples)]
    path.machine.check_travel(np.concatenate(positions), np.concatenate(blocks), source)


@lru_cache(64)
def joint_ranges(run: AxisRun) -> Floats:
    """(2, m) least and largest positions of the joints along a run."""
    q = run.evaluate(_samples(run))[0]
    return np.stack([q.min(axis=0), q.max(axis=0)])


def _samples(run: AxisRun) -> Floats:
    """Parameters at which a run is looked at, ascending."""
    knots = np.unique(np.concatenate([[run.s0], run.hints, run.breaks, [run.s1]]))
    between = knots[:-1, None] + np.diff(knots)[:, None] * np.arange(PARTS) / PARTS
    return np.append(between.ravel(), knots[-1])

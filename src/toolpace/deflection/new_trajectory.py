"""The new trajectory from the instant of a deflection on, and the place where it rejoins the path.

replan: a trajectory, a time, a deflection, its cause
  the state in which the joints are, and the motion that they shall come to:          DeflectedMotion.of
      displaced   the joints as they were found, with the rates they were commanded; the motion as planned
      bending     the joints as commanded; the motion as planned, compensated for the bending
  where to rejoin it: at the projection, at a parameter, or as soon as it can be      rejoin_time
  nothing off?  what remains of the motion
  the detour                                                                          DeflectedMotion.detour
  its law, and that of the way on; on the runs behind all as it was                   timing.law, joined
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, number
from toolpace.common.errors import InfeasibleError, ReachError, UsageError, did_you_mean
from toolpace.deflection.compensation import CompensatedRun, Compensation, check_compensated_travel
from toolpace.deflection.detour import DetourRun, skipped_by, skipped_in_words
from toolpace.deflection.detour_law import Timing, direct_law, timing_of
from toolpace.deflection.measured_pose import MOST, SAME_AXIS, found_tip, offset_in_words, pose_at
from toolpace.deflection.motion_state import MotionState, RemainingMotion, on_path
from toolpace.deflection.projection import project
from toolpace.deflection.rejoin.guaranteed import NOT_BEGUN, Standby
from toolpace.deflection.rejoin.joint_splines import Problem
from toolpace.deflection.rejoin.search import rejoin_of
from toolpace.deflection.rejoin_motion import CommandedMotion
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.laws import TimeLaw
from toolpace.motion.torques_over_time import continuous_shares
from toolpace.motion.trajectory import Skipped, Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.follow_run import FollowRun
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import Planner

if TYPE_CHECKING:
    from toolpace.planning.genetic import Genetic
    from toolpace.planning.optimal.planner import Optimal

CAUSES = ("displaced", "bending")
IN_PLACE = 1e-11
"""How far the joints or the tip may be off and count as in place: rounding of the kinematics [m or rad]."""


def replan(
    trajectory: Trajectory,
    time: float,
    tip: npt.ArrayLike | None = None,
    machine: Machine | None = None,
    *,
    deflection: npt.ArrayLike | None = None,
    most: float = MOST,
    cause: str = "displaced",
    axis: npt.ArrayLike | None = None,
    axis_tolerance: float = SAME_AXIS,
    planner: str | Optimal | Genetic | Planner = "optimal",
    rejoin: str | float = "fastest",
    interval: tuple[float, float] | None = None,
    **options: object,
) -> Trajectory:
    """The motion from `time` [s] on, at which the tip is found at the position `tip` (3,) [m] and the axis at `axis`.

    `tip` and the unit vector `axis`, from tip to spindle, are in the workpiece's frame, that of the program and of
    `Trajectory.tip`. In place of `tip`, `deflection` (3,) [m] is the vector from where the motion has the tip at that
    time, corrections and all, to where it was found, in the same frame. What is more than `most` [m] off is refused.

    `cause` says what was measured:

    "displaced": the joints are not where they were commanded, as in the paper. The motion starts from the position
    that was found, with the velocities and accelerations commanded, and comes back onto the path. Axes that differ by
    no more than `axis_tolerance` [rad] are the same, see `deflected_pose`.

    "bending": the tool or the part bends, the encoders are right, and the joints are as commanded. The set-points go
    on from there without a jump, and come to a motion that is off the path by the opposite of the bending, so that
    the bent tip lies on the path from then on, on all runs to the end. The bending is the measured tip less that of
    the kinematics, a vector in the workpiece's frame, and taken as constant. It moves linear joints only, and the
    rest of the motion takes a little longer for it, so that they keep to their limits; no `axis` is given.

    Without a machine `tip` holds the joints (m,), `deflection` their differences, and `most` is of each, in its unit.
    From its start on the motion keeps to every limit. The feed is that of the block which the tool is abreast of; what
    the tip is above it by at the start, for the joints' velocities cannot change at once, is braked as fast as jerk
    allows and told in the `notes`, and by `axis_path.runs[0].above`; so is what it comes to be above it by where a
    table that turns carries it, found aside, faster than the feed, whatever the joints do. The tool rejoins the path as
    soon as it can ("fastest"), at the parameter `rejoin`, or, as in the paper, at the "projection" of the tip on the
    path or on the `interval` (from s, to s) of it; where no motion rejoins it at full pace there, it rests there and
    comes to that pace behind. A motion that was replanned before goes back to what was planned first. `skipped` of the
    new motion tells which part of the path the tip leaves out.

    `planner` is an object, or in short the name of one with its `options`, as for `plan`: "optimal" times detour and
    the way on anew where the detour costs time, as far as the rejoining needs, and so does a planner of one's own;
    "genetic" (the paper's) the way on to the next reference point; "direct" keeps to the motion from which all start.
    Raises UsageError for arguments that make no sense, and InfeasibleError, with the figures, where no way back within
    limits and travel exists.
    """
    began = clock.perf_counter()
    chosen = ReplanOptions(
        cause=cause, axis=axis, axis_tolerance=axis_tolerance, rejoin=rejoin, interval=interval,
        timing=timing_of(planner, options),
    )  # fmt: skip
    check_replannable(trajectory, time, chosen)
    state = MotionState.of(trajectory, time)
    machine = state.machine_with_tool(machine or trajectory.axis_path.machine)
    position = found_tip(state, machine, time, tip, deflection, most)
    deflected = DeflectedMotion.of(trajectory, time, machine, state, position, chosen)
    place = rejoin_time(deflected.goal, position, chosen)
    if place is None and deflected.is_in_place:
        remaining = state.remaining()
        return deflected.joined(remaining, remaining.rest(), chosen.timing.name, began)
    run = deflected.detour(place)
    law = chosen.timing.law(run, trajectory.limits, direct_law(run))
    return deflected.joined(run, law, chosen.timing.name, began)


@dataclass(frozen=True, eq=False)
class ReplanOptions:
    """The parameters of `replan` that say how; see there."""

    cause: str
    axis: npt.ArrayLike | None
    axis_tolerance: float
    rejoin: str | float
    interval: tuple[float, float] | None
    timing: Timing


@dataclass(frozen=True, eq=False)
class DeflectedMotion:
    """A trajectory at the instant of a deflection: the state that the joints are in, and the motion to come to."""

    trajectory: Trajectory
    time: float
    """[s]"""
    machine: Machine | None
    """With the tool that is in the spindle then."""
    state: MotionState
    """As it was commanded."""
    start: Floats
    """(3, m) positions, velocities and accelerations of the joints from which the new motion starts."""
    compensation: Compensation | None
    """What the motion to come to is compensated for; None for the one on the path."""

    @classmethod
    def of(
        cls, trajectory: Trajectory, time: float, machine: Machine | None, state: MotionState, tip: Floats,
        options: ReplanOptions,
    ) -> DeflectedMotion:  # fmt: skip
        """With the `tip` (3,) at a position [m], without a machine the joints (m,).

        Raises UsageError for what is no axis, and InfeasibleError where the pose or the motion is out of travel.
        """
        start, compensation = state.state(), state.compensation
        if options.cause == "bending":
            compensation = bending_compensation(trajectory, state, start[0], tip, machine)
        else:
            start[0] = pose_at(state, machine, time, tip, options.axis, options.axis_tolerance)
        if compensation is not None and compensation is not state.compensation:
            try:
                begin = float(state.original.place(np.array([state.clock]))[0])
                check_compensated_travel(compensation, on_path_from(trajectory, state), begin)
            except ReachError as error:
                raise InfeasibleError(
                    f"bending at {time:.6g} s: the motion that makes up for it leaves the travel: {error}"
                ) from None
        return cls(trajectory, time, machine, state, start, compensation)

    @cached_property
    def offset(self) -> Floats:
        """(m,) by which the joints are off where they were commanded [m or rad]."""
        off: Floats = self.start[0] - self.state.state()[0]
        return off

    @property
    def is_in_place(self) -> bool:
        """Whether the motion as it was commanded is the one to come to, and the joints are in it."""
        return self.compensation is self.state.compensation and bool(np.abs(self.offset).max() <= IN_PLACE)

    @property
    def pace(self) -> float:
        """Duration of the motion to come to, over that on the path."""
        return self.compensation.pace if self.compensation else 1.0

    @cached_property
    def goal(self) -> CommandedMotion:
        """The motion to come to."""
        return self.compensation.motion(self.state.original) if self.compensation else self.state.original

    def detour(self, place: float | None) -> DetourRun:
        """The detour to the goal, at the time `place` of its law [s]; None: as soon as it can be.

        Raises InfeasibleError where there is none.
        """
        left, lag = self.state.clock * self.pace, self.state.lag
        problem = Problem(self.goal, left, self.start, self.trajectory.limits, self.machine)
        standby = Standby(
            self.state.current, self.state.local, self.offset, lambda wait: self.state.clock_after(wait) * self.pace
        )
        detour = rejoin_of(problem, standby, place, lag)
        if detour is None and place is None and left <= NOT_BEGUN:
            # nothing of the run has been missed: straight to its start, however slow the feed there
            detour = rejoin_of(problem, standby, 0.0, lag)
        if detour is None:
            off = offset_in_words(self.start[0] - problem.end(0.0, 0.0)[0], self.trajectory.joints, self.machine)
            raise InfeasibleError(
                f"deflection at {self.time:.6g} s: no way back to the path within limits and travel; the joints are off"
                f" by {off}; stop the machine, or give more travel"
            )
        return DetourRun(detour, self.machine, lag)

    def joined(self, run: AxisRun, law: TimeLaw, planner: str, began: float) -> Trajectory:
        """The first run with what follows it, compensated as it is."""
        trajectory, behind = self.trajectory, self.state.behind
        runs, laws = trajectory.axis_path.runs[behind:], trajectory.laws[behind:]
        if self.compensation is not self.state.compensation:
            followers = on_path_from(trajectory, self.state)[1:]
            compensated = [self.compensation.motion(each) if self.compensation else each for each in followers]
            runs, laws = tuple(each.run for each in compensated), tuple(each.law for each in compensated)
        detour = run.base if isinstance(run, RemainingMotion) else run
        if isinstance(detour, DetourRun) and detour.leads_to_start:
            whole = detour.detour.commanded
            runs, laws = (whole.run, *runs), (whole.law, *laws)
        notes: list[str] = []
        skipped: tuple[Skipped, ...] = ()
        if isinstance(run, DetourRun):
            share, until = run.above
            if share > 0.0:
                notes.append(f"start above feed by {100.0 * share:.3g} %; below it after {1e3 * until:.3g} ms")
        if isinstance(detour, DetourRun):
            skipped = skipped_by(detour, run.s0)
            notes += [skipped_in_words(each, detour.machine) for each in skipped]
        path = AxisPath((run, *runs), trajectory.joints, trajectory.axis_path.machine)
        notes += rows_above(trajectory.limits, np.stack([*self.start, 0.0 * self.start[0]]))
        rated = continuous_shares(path, trajectory.limits, (law, *laws)).items()
        notes += [f"{name}: the way left takes {100.0 * used:.4g} % of it" for name, used in rated if used > PROMISED]
        return Trajectory(
            path, trajectory.limits, (law, *laws), planner, notes=tuple(notes), skipped=skipped,
            solve_seconds=clock.perf_counter() - began,
        )  # fmt: skip


def rows_above(limits: Limits, start: Floats) -> list[str]:
    """Which rows and torques a motion is above at its start (4, m), and by how much, in words."""
    state = np.array([[0.0], [1.0], [0.0], [0.0]])
    found = [(rows.name, float(rows.ratio(start[:, None], state)[0])) for rows in limits.rows if rows.order == 1]
    return [f"start above {name} by {100.0 * (used - 1.0):.3g} %" for name, used in found if used > PROMISED]


def bending_compensation(
    trajectory: Trajectory, state: MotionState, q: Floats, tip: Floats, machine: Machine | None
) -> Compensation | None:
    """The compensation of a bending, from the joints (m,) commanded and the tip found; the former where none new."""
    bending = tip - (q if machine is None else machine.forward(q[None])[0][0])
    before = state.compensation
    if np.abs(bending + (before.offset if before else 0.0)).max() <= IN_PLACE:
        return before
    if np.abs(bending).max() <= IN_PLACE:
        return None
    return Compensation.of(bending, machine, trajectory.limits, on_path_from(trajectory, state))


def on_path_from(trajectory: Trajectory, state: MotionState) -> list[CommandedMotion]:
    """The motions on the path of the run and of those that follow it, as they were planned first."""
    runs, laws = trajectory.axis_path.runs[state.behind :], trajectory.laws[state.behind :]
    return [state.original, *(on_path(CommandedMotion(*each)) for each in zip(runs, laws))]


def check_replannable(trajectory: Trajectory, time: float, options: ReplanOptions) -> None:
    """Raise UsageError where the trajectory has no such time, or no way back from it could keep to jerk limits."""
    cause = options.cause
    if cause not in CAUSES:
        raise UsageError(f"replan: unknown cause '{cause}'; {did_you_mean(str(cause), CAUSES)}")
    if cause == "bending" and options.axis is not None:
        raise UsageError("replan: a bending is made up for at the tip, and the tool axis stays; leave axis out")
    if not isinstance(time, Real) or isinstance(time, bool):
        raise UsageError(
            f"replan: time is {str(time)[:40]!r}; give seconds: replan(trajectory, time, tip, machine)"
        )
    if not 0.0 <= time <= trajectory.duration:
        shown = max(min(time, 1e300), -1e300)  # a whole number may be too large for a float
        raise UsageError(f"replan: time {shown:g} s is not within the trajectory's {trajectory.duration:.6g} s")
    if trajectory.limits.rows and options.timing.name == "genetic":
        names = ", ".join(rows.name for rows in trajectory.limits.rows)
        raise UsageError(f"replan: the planner 'genetic' does not hold {names}; give 'optimal' or 'direct'")
    if any(law.jumps.size for law in trajectory.laws):
        raise UsageError(
            f"replan: accelerations jump in a plan of planner {trajectory.planner}, so no way back from it can keep to"
            " jerk limits; plan with planner optimal"
        )


def rejoin_time(goal: CommandedMotion, tip: Floats, options: ReplanOptions) -> float | None:
    """When the law of the motion to come to passes the wanted point of rejoining [s]; None where it is free.

    The point is "fastest" (free), "projection" (of the `tip` (3,) [m] on the run, or on the `interval` of it) or a
    parameter of the run.
    """
    rejoin, interval = options.rejoin, options.interval
    if interval is not None and rejoin != "projection":
        raise UsageError("replan: an interval is for a projection on it; give rejoin='projection', or leave it out")
    run = goal.run
    on_path = run.base if isinstance(run, CompensatedRun) else run
    if rejoin == "fastest":
        return None
    if isinstance(rejoin, str):
        if rejoin != "projection":
            raise UsageError(f"replan: rejoin at '{rejoin}'; give 'fastest', 'projection' or a parameter")
        if not isinstance(on_path, FollowRun):
            raise UsageError("replan: a projection needs a path of tip and axis; give the parameter to rejoin at")
        s = project(Path((on_path.run,)), tip, interval=interval).s
    else:
        s = number(rejoin, "replan: rejoin")
        if not run.s0 <= s <= run.s1:
            raise UsageError(f"replan: rejoin at s = {s:g}; the run goes from {run.s0:g} to {run.s1:g}")
    return goal.law.passing_time(s)

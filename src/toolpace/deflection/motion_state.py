"""The state of a motion at an instant, on the path, on a detour or compensated; and what remains of it from there.

However often a motion was replanned, what it goes back to is the one that was planned first: a detour from a detour
asks no detour before it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.deflection.compensation import CompensatedRun, Compensation
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.rejoin_motion import CommandedMotion, moment
from toolpace.machine.machine import Machine
from toolpace.motion.laws import ChainLaw, LawPiece, SlowedLaw, TimeLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_run import AxisRun


@dataclass(frozen=True)
class MotionState:
    """An instant of a trajectory."""

    behind: int
    """Index of the first run behind the original one."""
    current: CommandedMotion
    local: float
    """The time on the clock of its law [s]."""
    original: CommandedMotion
    clock: float
    """The time that the original motion has come to [s]."""
    compensation: Compensation | None
    """How far off the path the commands are, and why; None on it."""
    lag: float
    """By how much the run is late because of detours [s]."""

    @classmethod
    def of(cls, trajectory: Trajectory, time: float) -> MotionState:
        """At a time of the trajectory; in a dwell at the end of the run before it."""
        index, local = moment(trajectory, time)
        run, law = trajectory.axis_path.runs[index], trajectory.laws[index]
        if isinstance(run, RemainingMotion):
            law, local = run.law, run.begin + local
            run = run.base
        current, clock, lag = CommandedMotion(run, law), local, 0.0
        followed, behind = current, index + 1
        if isinstance(run, DetourRun):
            followed, clock = run.detour.commanded, rejoined_clock(run, law, local)
            lag = run.lag + run.detour.lost * min(local / run.detour.duration, 1.0)
            # a detour to the start of the original has that as the next run
            behind += run.leads_to_start
        compensation = followed.run.compensation if isinstance(followed.run, CompensatedRun) else None
        original = on_path(followed)
        pace = compensation.pace if compensation else 1.0
        return cls(behind, current, local, original, clock / pace, compensation, lag)

    def machine_with_tool(self, machine: Machine | None) -> Machine | None:
        """The machine with the tool that is in the spindle at the instant."""
        return None if machine is None else machine.with_tool(self.original.run.tool_length)

    def clock_after(self, wait: float) -> float:
        """The time that the original motion will have come to when the motion has gone on for a while [s]."""
        run, law = self.current.run, self.current.law
        pace = self.compensation.pace if self.compensation else 1.0
        if isinstance(run, DetourRun):
            return rejoined_clock(run, law, min(self.local + wait, law.duration)) / pace
        return self.clock + wait / pace

    def state(self) -> Floats:
        """(3, m) positions, velocities and accelerations commanded."""
        motion: Floats = self.current.motion(np.array([self.local]))[:3, 0]
        return motion

    def remaining(self) -> RemainingMotion:
        """What remains of the motion as it is commanded."""
        return RemainingMotion(self.current.run, self.current.law, self.local)


def on_path(followed: CommandedMotion) -> CommandedMotion:
    """The motion on the path itself, of one that may be compensated."""
    run, law = followed.run, followed.law
    if isinstance(run, CompensatedRun):
        run = run.base
        law = law.law if isinstance(law, SlowedLaw) else law
    return CommandedMotion(run, law)


def rejoined_clock(run: DetourRun, law: TimeLaw, local: float) -> float:
    """The time on the clock of the motion that a detour leads to, at a time of the run's own law [s]."""
    p = law.at(np.array([local]))[0]
    if run.on_detour(p)[0]:
        passed = float(run.time_at(p)[0])
        return float(run.detour.clock(np.array([passed]))[0])
    if isinstance(law, ChainLaw) and local >= law.times[-2]:
        return law.pieces[-1].begin + (local - float(law.times[-2]))
    return run.detour.commanded.law.passing_time(float(p[0]))


class _PartOfRun(AxisRun):
    """A part of a run, on the same parameter."""

    base: AxisRun

    def evaluate(self, s: Floats) -> Floats:
        return self.base.evaluate(s)

    def speed_cap(self, s: Floats) -> Floats:
        return self.base.speed_cap(s)

    def block_at(self, s: Floats) -> Ints:
        return self.base.block_at(s)


class RemainingMotion(_PartOfRun):
    """The rest of a run from where its law is at a time."""

    def __init__(self, base: AxisRun, law: TimeLaw, begin: float) -> None:
        """`begin` is the time on the law's clock [s]."""
        self.base, self.law, self.begin = base, law, begin
        self.s0, self.s1 = float(np.clip(law.at(np.array([begin]))[0, 0], base.s0, base.s1)), base.s1
        self.breaks, self.hints = base.breaks[base.breaks > self.s0], base.hints[base.hints > self.s0]
        self.dwell, self.blocks, self.smooth_cap = base.dwell, base.blocks, base.smooth_cap
        self.tool_length = base.tool_length

    def rest(self) -> TimeLaw:
        """The law of it."""
        return ChainLaw([LawPiece(self.law, self.begin, self.law.duration)])


class Stretch(_PartOfRun):
    """A run between its start and a place, for a planner that shall look no further."""

    def __init__(self, base: AxisRun, end: float) -> None:
        self.base, self.s0, self.s1 = base, base.s0, end
        self.breaks, self.hints = base.breaks[base.breaks < end], base.hints[base.hints < end]
        self.tool_length = base.tool_length

"""The state of a motion at an instant: on the path, on a detour, or compensated.

However often a motion was replanned, what it goes back to is the one that was planned first: a detour from a detour
asks no detour before it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.deflection.replanning.commanded import CommandedMotion, moment
from toolpace.deflection.replanning.compensation import CompensatedRun, Compensation
from toolpace.deflection.replanning.detour import DetourRun
from toolpace.deflection.replanning.remaining_motion import RemainingMotion
from toolpace.machine.machine import Machine
from toolpace.motion.laws.chain import ChainLaw
from toolpace.motion.laws.law import TimeLaw
from toolpace.motion.laws.slowed import SlowedLaw
from toolpace.motion.trajectory import Trajectory


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
    aim: Compensation | None
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
        aim = followed.run.aim if isinstance(followed.run, CompensatedRun) else None
        original = on_path(followed)
        return cls(behind, current, local, original, clock / (aim.pace if aim else 1.0), aim, lag)

    def machine_with_tool(self, machine: Machine | None) -> Machine | None:
        """The machine with the tool that is in the spindle at the instant."""
        return None if machine is None else machine.with_tool(self.original.run.tool_length)

    def clock_after(self, wait: float) -> float:
        """The time that the original motion will have come to when the motion has gone on for a while [s]."""
        run, law = self.current.run, self.current.law
        pace = self.aim.pace if self.aim else 1.0
        if isinstance(run, DetourRun):
            return rejoined_clock(run, law, min(self.local + wait, law.duration)) / pace
        return self.clock + wait / pace

    def state(self) -> Floats:
        """(3, m) positions, velocities and accelerations commanded."""
        motion: Floats = self.current.motion(np.array([self.local]))[:3, 0]
        return motion


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

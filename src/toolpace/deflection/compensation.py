"""Compensation of a constant bending: the path shifted by it, at a speed within the limits.

    tip of the bent tool = tip of the kinematics + bending        so the command is the path - bending

The bending is a vector in the workpiece's frame and taken as constant. That is the frame in which the tip is measured
and the path is given, and in a steady cut along a line the force, and with it the bending, stands still in it; a
bending that turns with the tool or the feed is as constant as these, and is measured again before they turn far.
Rotary joints stay as they are: a bend of the tool turns its axis by far less than it moves the tip.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import InfeasibleError
from toolpace.deflection.rejoin_motion import CommandedMotion
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.machine import Machine
from toolpace.motion import joint_motion
from toolpace.motion.laws import SlowedLaw, TimeLaw
from toolpace.path.axis_path import AxisPath, check_travel, joint_ranges
from toolpace.path.axis_run import AxisRun
from toolpace.planning.limit_tolerances import PROMISED

MOST_PACES = 30
LEAST_SLOWER, MOST_SLOWER = 1.0005, 1.5
"""By how much the pace is lowered at least and at most where a row is passed, and how often."""
BETWEEN = 1.02
"""Rates of joints over those at the probes of their law: between them they may be a little higher."""


@dataclass(frozen=True)
class Compensation:
    """How far the commands are off the path, and by how much slower they run along it for that."""

    offset: Floats
    """(3,) of the tip in the workpiece's frame [m], or without a machine (m,) of the joints: less the bending."""
    machine: Machine | None
    pace: float
    """Duration over that on the path, 1 or a little more."""

    @classmethod
    def of(
        cls, bending: Floats, machine: Machine | None, limits: Limits, rest: Sequence[CommandedMotion]
    ) -> Compensation:
        """Against a bending, on the `rest` of the motion that was planned."""
        by_joints = cls(-bending, machine, 1.0 if machine is None else pace_of(bending, machine, limits, rest))
        return by_joints.within_rows(limits, rest) if limits.rows else by_joints

    def within_rows(self, limits: Limits, rest: Sequence[CommandedMotion]) -> Compensation:
        """With a pace at which rows, torques and limits over speed hold off the path too. Raises InfeasibleError."""
        found = self
        for _ in range(MOST_PACES):
            motions = [found.motion(each) for each in rest]
            worst = max(largest_row_use(motion, limits) for motion in motions)
            if worst <= PROMISED:
                return found
            slower = min(max(worst**0.5, LEAST_SLOWER), MOST_SLOWER)
            found = replace(found, pace=found.pace * slower)
        raise InfeasibleError("bending: what makes up for it keeps rows or torques at no pace; stop the machine")

    def motion(self, original: CommandedMotion) -> CommandedMotion:
        """The motion to be commanded in place of one that keeps to the path."""
        law = original.law if self.pace == 1.0 else SlowedLaw(original.law, self.pace)
        return CommandedMotion(CompensatedRun(original.run, self), law)


class CompensatedRun(AxisRun):
    """A run whose tip is off by a constant vector: rotary joints as they were, the linear ones moved along."""

    def __init__(self, base: AxisRun, compensation: Compensation) -> None:
        self.base, self.compensation = base, compensation
        self.s0, self.s1, self.breaks, self.hints = base.s0, base.s1, base.breaks, base.hints
        self.dwell, self.blocks, self.smooth_cap = base.dwell, base.blocks, base.smooth_cap
        self.tool_length = base.tool_length

    def evaluate(self, s: Floats) -> Floats:
        return self._moved(self.base.evaluate(s))

    def with_cap(self, s: Floats) -> tuple[Floats, Floats]:
        path, cap = self.base.with_cap(s)
        return self._moved(path), cap

    def speed_cap(self, s: Floats) -> Floats:
        return self.base.speed_cap(s)

    def entries(self) -> tuple[Floats, Ints]:
        return self.base.entries()

    def block_at(self, s: Floats) -> Ints:
        return self.base.block_at(s)

    def _moved(self, path: Floats) -> Floats:
        """The joints (4, n, m) with the offset: the tip goes into them linearly."""
        out = path.copy()
        machine = self.compensation.machine
        if machine is None:
            out[0] += self.compensation.offset
            return out
        rotary = np.ascontiguousarray(path[:, :, machine.rotary])
        tip = np.zeros((4, path.shape[1], 3))
        without = machine.linear_jets(tip, rotary)
        tip[0] = self.compensation.offset
        difference = machine.linear_jets(tip, rotary) - without
        out[:, :, machine.linear] += difference[:, :, machine.linear]
        return out


def pace_of(bending: Floats, machine: Machine, limits: Limits, rest: Sequence[CommandedMotion]) -> float:
    """By how much slower to go so that the linear joints keep to their limits off the path too.

    The offset turns with the rotary joints, and its derivatives are at most

        w |d|,   (w^2 + a) |d|,   (w^3 + 3 w a + j) |d|,        w, a, j: what both joints' limits allow, summed

    or what both joints do at most, where a limit is infinite.
    """
    size = most_moved(bending, machine)
    if size == 0.0:
        return 1.0
    rates = np.array([getattr(limits, kind)[machine.rotary].sum() for kind in KINDS])
    if not np.isfinite(rates).all():
        done = np.max([peaks_of(motion.run, motion.law, tuple(machine.rotary)) for motion in rest], axis=0)
        rates = np.where(np.isfinite(rates), rates, BETWEEN * done)
    w, a, j = map(float, rates)
    paces = [1.0]
    for order, (kind, more) in enumerate(zip(KINDS, (w, w * w + a, w**3 + 3.0 * w * a + j)), start=1):
        least = float(getattr(limits, kind)[machine.linear].min())
        paces.append((1.0 + size * more / least) ** (1.0 / order))
    return max(paces)


def most_moved(offset: Floats, machine: Machine) -> float:
    """By how much an offset (3,) of the tip moves a linear joint at most, however the rotary ones stand [m]."""
    # by 1 for a unit of the tip where the linear joints are square to each other
    step = machine.joints_at(np.vstack([np.zeros((1, 3)), np.eye(3)]), np.zeros((4, 2)))
    return float(np.linalg.norm(offset)) * float(np.linalg.norm((step[1:] - step[0])[:, machine.linear], 2))


def check_compensated_travel(compensation: Compensation, rest: Sequence[CommandedMotion], begin: float) -> None:
    """Raise ReachError where a compensated motion leaves the travel: on the `rest` of what was planned, from a
    parameter of the first run on."""
    machine = compensation.machine
    if machine is None:
        return
    moved = np.zeros(len(machine.joints))
    moved[machine.linear] = most_moved(compensation.offset, machine)
    ranges = np.stack([joint_ranges(motion.run) for motion in rest])
    low, high = ranges[:, 0].min(axis=0) - moved, ranges[:, 1].max(axis=0) + moved
    if (low >= machine.travel[:, 0]).all() and (high <= machine.travel[:, 1]).all():
        return
    runs = tuple(compensation.motion(motion).run for motion in rest)
    check_travel(AxisPath(runs, machine.joints, machine), begin=begin)


def largest_row_use(motion: CommandedMotion, limits: Limits) -> float:
    """The largest share of rows, torques and limits over speed that a motion uses at the probes of its law."""
    worst, run = 0.0, motion.run
    for probe in motion.law.probes():
        q = np.ascontiguousarray(run.evaluate(np.clip(probe.state[0], run.s0, run.s1)))
        worst = max(worst, *(float(rows.ratio(q, probe.state).max()) for rows in limits.rows))
    return worst


@lru_cache(8)
def peaks_of(run: AxisRun, law: TimeLaw, columns: tuple[int, ...]) -> Floats:
    """(3,) largest sum of the velocities, accelerations and jerks of some joints: looked at once for a planned run."""
    worst = np.zeros(3)
    for probe in law.probes():
        motion = joint_motion(run.evaluate(np.clip(probe.state[0], run.s0, run.s1)), probe.state)
        values = np.stack([motion.qd, motion.qdd, motion.qddd])[:, :, list(columns)]
        worst = np.maximum(worst, np.abs(values).sum(axis=2).max(axis=1))
    return worst

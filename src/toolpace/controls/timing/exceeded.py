"""Limits of the machine's joints that a control exceeds, by the rules of its maker and by its figures.

* Corners: a Fanuc lets the velocities of axes jump by 1783, a Sinumerik by its overload factor where corners are not
  rounded. The jump takes the time T of the control's cycle, or of what is behind its interpolation. A change D of
  velocity within T takes an acceleration of at least D / T and a jerk of at least 4 D / T^2; one of acceleration takes
  its T-th part.
* Ramps: LinuxCNC (planner 0) and a Sinumerik with BRISK keep no jerk: the acceleration a of an axis begins within a
  cycle, with a jerk of a / T. Factors for rapids, and figures of the controller's file, may be above the machine's
  limits. Each block that takes longer than its speed asks for, and does not keep one speed, counts with the full
  acceleration, which a short ramp does not reach; the speeds of LinuxCNC's blocks are not known. So size and number are
  the most that there may be.
* Blocks: LinuxCNC, and a control with `limits = "words"`, keeps the limits of X, Y, Z and the rotary words where these
  are the tip. What joints then do is told from the mean speed of each block: they do at least that.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.axis_motion import AxisWays, Transitions, axis_ways
from toolpace.controls.timing.blocks import MOST_ACCELERATION, MotionProfile, rests
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.sinumerik import tolerances
from toolpace.machine.limits import Limits
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

SLACK = 1e-6
"""Share of a limit by which it may seem exceeded."""
CYCLE = 1e-3
"""Of a control whose figures have none [s]: about what others take."""


@dataclass(frozen=True)
class ExceededLimit:
    """A limit of a joint of the machine that a control exceeds."""

    kind: str
    """velocity, acceleration, jerk"""
    axis: str
    ratio: float
    """Of the largest over the limit; at least that in corners and blocks, at most that in ramps."""
    where: str
    """corner: between blocks; ramp: wherever the speed of a block rises or falls; block: at the speed of a block."""
    count: int
    """In how many corners or blocks it is exceeded."""
    line: int
    """Line of the program with the worst one, at its end."""

    def __str__(self) -> str:
        noun = "corner" if self.where == "corner" else "block"
        places = f"in {self.count} {noun}{'s' * (self.count != 1)}"
        if self.where == "ramp":
            places = f"in the ramps of at most {self.count} {noun}{'s' * (self.count != 1)}"
        return f"{self.kind} of {self.axis} up to {_times(self.ratio)} its limit {places}, worst at line {self.line}"


def _times(ratio: float) -> str:
    return f"{ratio:.0f} times" if ratio >= 100.0 else f"{ratio:.3g} times"


def exceeded_limits(
    moves: Commanded, machine: Machine, figures: ControlFigures, profile: MotionProfile
) -> tuple[ExceededLimit, ...]:
    """What a control exceeds, the worst of each kind first. What its model does not tell of corners is left out."""
    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    return (
        *_in_blocks(moves, machine, figures, profile),
        *_at_corners(moves, machine, figures, profile, ways),
        *_in_ramps(moves, machine, figures, profile, ways),
    )


def raised_limits(machine: Machine, exceeded: Iterable[ExceededLimit]) -> Limits:
    """The machine's limits, each as high as a control went."""
    own = machine.limits
    limits = {kind: getattr(own, kind).copy() for kind in ("velocity", "acceleration", "jerk")}
    for each in exceeded:
        column = machine.joints.index(each.axis)
        raised = getattr(own, each.kind)[column] * each.ratio
        limits[each.kind][column] = max(limits[each.kind][column], raised)
    return Limits(limits["velocity"], limits["acceleration"], limits["jerk"], machine.joints)


def _at_corners(
    moves: Commanded, machine: Machine, figures: ControlFigures, profile: MotionProfile, ways: AxisWays
) -> list[ExceededLimit]:
    if figures.model == "fanuc":
        spread = figures.fanuc.after_interpolation or figures.fanuc.cycle
        jumps = np.ones(len(moves), dtype=bool)
    elif figures.model == "sinumerik":
        spread, jumps = figures.sinumerik.cycle, tolerances(moves, figures) == 0.0
    else:
        return []
    limits = machine.limits
    changes = Transitions.of(ways, rests(moves), ways.length)
    speed = np.where(jumps & ~rests(moves), profile.corner, 0.0)[:, None]
    change, across = speed * changes.kink, speed**2 * changes.bend
    jerk = np.maximum(4.0 * change / spread**2, across / spread)
    return [
        *_exceeded("acceleration", "corner", change / spread / limits.acceleration, machine, moves),
        *_exceeded("jerk", "corner", jerk / limits.jerk, machine, moves),
    ]


def _in_ramps(
    moves: Commanded, machine: Machine, figures: ControlFigures, profile: MotionProfile, ways: AxisWays
) -> list[ExceededLimit]:
    own, ways = machine.limits, profile.ways or ways
    with np.errstate(divide="ignore", invalid="ignore"):
        least = ways.length / np.where(moves.length > 0.0, moves.speed, moves.turn)
    # a block that a feed by time, or reading it, keeps steady has no ramp; LinuxCNC's times are counted in cycles
    counted, read = (figures.linuxcnc.cycle, 0.0) if figures.model == "linuxcnc" else (0.0, figures.block_time)
    least = np.maximum(np.maximum(least, moves.time), np.where(moves.rapid, 0.0, read))
    slower = profile.times > least * (1.0 + SLACK) + counted
    ramps = (slower & (ways.length > 0.0) & ~_is_steady(profile, ways.length))[:, None] * ways.most
    acceleration = np.minimum(profile.acceleration, MOST_ACCELERATION)[:, None] * ramps
    cycle = {"sinumerik": figures.sinumerik.cycle, "linuxcnc": figures.linuxcnc.cycle}.get(figures.model, CYCLE)
    with np.errstate(invalid="ignore"):
        kept = np.where(ramps > 0.0, profile.jerk[:, None] * ramps, 0.0)
    jerk = np.minimum(kept, acceleration / cycle)
    return [
        *_exceeded("acceleration", "ramp", acceleration / own.acceleration, machine, moves),
        *_exceeded("jerk", "ramp", jerk / own.jerk, machine, moves),
    ]


def _is_steady(profile: MotionProfile, length: Floats) -> Bools:
    """(n,) whether a block keeps one speed from its beginning to its end; no block of a model without speeds does."""
    steady, rows = np.zeros(len(length), dtype=bool), np.flatnonzero(length > 0.0)
    end, mean = profile.corner[rows], length[rows] / np.maximum(profile.times[rows], np.finfo(float).tiny)
    begin = np.append(0.0, end[:-1])
    steady[rows] = np.maximum(np.abs(end - mean), np.abs(begin - mean)) <= SLACK * mean
    return steady


def _in_blocks(
    moves: Commanded, machine: Machine, figures: ControlFigures, profile: MotionProfile
) -> list[ExceededLimit]:
    by_words = figures.model == "linuxcnc" or figures.limits == "words"
    rows: Bools = moves.tip_mode & (profile.times > 0.0)
    if not by_words or not rows.any():
        return []
    own, ways = machine.limits, axis_ways(moves, machine, joints=True)
    mean = np.where(rows, ways.length / np.where(rows, profile.times, 1.0), 0.0)[:, None]
    return [
        *_exceeded("velocity", "block", mean * ways.most / own.velocity, machine, moves),
        *_exceeded("acceleration", "block", mean**2 * ways.bend / own.acceleration, machine, moves),
    ]


def _exceeded(kind: str, where: str, ratio: Floats, machine: Machine, moves: Commanded) -> list[ExceededLimit]:
    """One for each axis with a ratio (n, axes) above 1, the worst first."""
    found = []
    for axis, column in zip(machine.joints, ratio.T):
        worst, count = int(column.argmax()), int((column > 1.0 + SLACK).sum())
        if count:
            found.append(ExceededLimit(kind, axis, float(column[worst]), where, count, int(moves.line[worst])))
    return sorted(found, key=lambda each: -each.ratio)

"""Limits of axes that a control exceeds at corners, by the rules of its maker.

A Fanuc lets the velocities of axes jump by 1783, a Sinumerik by its overload factor where corners are not rounded. The
jump takes the time T of the control's cycle, or of what is behind its interpolation. A change of velocity D within T
takes an acceleration of at least D / T and a jerk of at least 4 D / T^2; one of acceleration takes its T-th part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.controls.timing.axis_motion import Transitions, axis_ways
from toolpace.controls.timing.blocks import MotionProfile, rests
from toolpace.controls.timing.figures import ControlFigures, limits_of
from toolpace.controls.timing.sinumerik import tolerances
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

SLACK = 1e-6
"""Share of a limit by which it may seem exceeded."""


@dataclass(frozen=True)
class ExceededLimit:
    """A limit of an axis that is exceeded at corners."""

    kind: str
    """acceleration, jerk"""
    axis: str
    ratio: float
    """Of the largest over the limit."""
    corners: int
    """In how many corners it is exceeded."""
    line: int
    """Line of the program with the worst one, at its end."""

    def __str__(self) -> str:
        corners = "1 corner" if self.corners == 1 else f"{self.corners} corners"
        times = f"{self.ratio:.3g} times its limit"
        return f"{self.kind} of {self.axis} up to {times} in {corners}, worst at line {self.line}"


def exceeded_limits(
    moves: Commanded, machine: Machine, figures: ControlFigures, profile: MotionProfile
) -> tuple[ExceededLimit, ...]:
    """What the models of a Fanuc and a Sinumerik exceed; the others keep the limits, or do not tell."""
    if figures.model == "fanuc":
        spread = figures.fanuc.after_interpolation or figures.fanuc.cycle
        jumps = np.ones(len(moves), dtype=bool)
    elif figures.model == "sinumerik":
        spread, jumps = figures.sinumerik.cycle, tolerances(moves, figures) == 0.0
    else:
        return ()
    limits, ways = limits_of(machine, figures), axis_ways(moves, machine, joints=figures.limits == "joints")
    changes = Transitions.of(ways, rests(moves), ways.length)
    speed = np.where(jumps & ~rests(moves), profile.corner, 0.0)[:, None]
    change, across = speed * changes.kink, speed**2 * changes.bend
    jerk = np.maximum(4.0 * change / spread**2, across / spread)
    return (
        *_exceeded("acceleration", change / spread / limits.acceleration, machine, moves),
        *_exceeded("jerk", jerk / limits.jerk, machine, moves),
    )


def _exceeded(kind: str, ratio: Floats, machine: Machine, moves: Commanded) -> list[ExceededLimit]:
    """One for each axis with a ratio (n, axes) above 1, the worst first."""
    found = []
    for axis, column in zip(machine.joints, ratio.T):
        worst, corners = int(column.argmax()), int((column > 1.0 + SLACK).sum())
        if corners:
            found.append(ExceededLimit(kind, axis, float(column[worst]), corners, int(moves.line[worst])))
    return sorted(found, key=lambda each: -each.ratio)

"""The limits that a control keeps, axis by axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.timing.figures import ControlFigures

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine


def limits_of(machine: Machine, figures: ControlFigures) -> Limits:
    """The machine's limits, with the shares or the figures of the control in their place. Raises UsageError."""
    from toolpace.machine.limits import Limits

    own = machine.limits
    acceleration = _scaled(machine, own.acceleration, figures.acceleration, "acceleration")
    jerk = _scaled(machine, own.jerk, figures.jerk, "jerk")
    return Limits(own.velocity, acceleration, jerk, machine.joints)


def _scaled(machine: Machine, own: Floats, asked: float | dict[str, float], kind: str) -> Floats:
    if isinstance(asked, int | float):
        return own * asked
    limits = own.copy()
    for axis, figure in asked.items():
        if axis not in machine.joints:
            raise UsageError(
                f"[time] {kind}: machine '{machine.name}' has no axis {axis}, it has {', '.join(machine.joints)}"
            )
        column = machine.joints.index(axis)
        limits[column] = figure * (DEGREE if machine.is_rotary[column] else MILLIMETRE)
    return limits


def off_the_path(machine: Machine, figures: ControlFigures) -> Floats:
    """(axes,) what a unit of each axis counts for beside the tolerance of the tip [m]."""
    return np.where(machine.is_rotary, figures.turned_metre, 1.0)

"""The rotary positions that bring the tool to a direction on the part."""

from __future__ import annotations

import math

import numpy as np

from toolpace.reading.coordinates.kinematics import Poses

TURN = 2.0 * math.pi
FREE = 1e-6
"""Angle to the pole within which the first rotary joint stays where it is [rad]."""


class Orientation:
    """Tool axes to rotary positions, the nearest to where the joints are."""

    def __init__(self, poses: Poses) -> None:
        self.poses = poses

    def rotary(self, axis: list[float], present: list[float], sign: int = 0) -> tuple[list[float], str]:
        """Rotary positions [rad] for a tool axis (3,) on the part, and what is wrong, or "".

        Of both solutions, and all turns within travel, the one with the least sum of turns. `sign`: only those with
        the second rotary joint below (-1) or above (1) zero.
        """
        machine = self.poses.machine
        if machine is None:
            return [], "a tool vector needs the machine: give --machine NAME (machine= in Python)"
        length = math.hypot(*axis)
        if not 1e-6 < length < 1e6:
            return [], "the tool vector is zero: give the direction from the tip to the spindle"
        unit = np.array([axis]) / length
        solutions, pole = machine.rotary_solutions(unit)
        travel = np.asarray(machine.travel)[list(self.poses.rotary)]
        choices = []
        for solution in np.asarray(solutions)[0]:
            if np.isnan(solution).any():
                continue
            wanted = [float(value) for value in solution]
            if bool(pole[0]):
                wanted[0] = present[0]
            if sign and wanted[1] * sign < -FREE:
                continue
            turned = [near(value, here, low, high) for value, here, (low, high) in zip(wanted, present, travel)]
            if all(value is not None for value in turned):
                choices.append([value for value in turned if value is not None])
        if not choices:
            shown = ", ".join(f"{value:.4g}" for value in unit[0])
            return [], (
                f"machine '{machine.name}' cannot bring its tool to the direction {shown} within the travel of "
                f"{' and '.join(self.poses.rotary_names)}: choose a machine that can, or clamp the part otherwise"
            )
        return min(choices, key=lambda choice: math.dist(choice, present)), ""


def near(angle: float, present: float, low: float, high: float) -> float | None:
    """The angle plus whole turns nearest to where the joint is, within travel; None where there is none."""
    best = angle + TURN * round((present - angle) / TURN)
    if low - 1e-9 <= best <= high + 1e-9:
        return best
    fitting = [angle + TURN * k for k in range(-200, 201) if low - 1e-9 <= angle + TURN * k <= high + 1e-9]
    return min(fitting, key=lambda value: abs(value - present), default=None)

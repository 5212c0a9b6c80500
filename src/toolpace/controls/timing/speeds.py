"""The speeds that a control reaches along a program, by its model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.blocks import rests
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.program_time import MODELS, moves_of_points
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine


@dataclass(frozen=True)
class ControlSpeeds:
    """What a control makes of the ways to the points of a program, by its model."""

    times: Floats
    """(n,) of each way [s]."""
    mean: Floats
    """(n,) speed of the tip on it [m/s]; 0 where it stands."""
    highest: Floats
    """(n,) likewise, at the fastest place of the way, where the speed rises and falls at constant acceleration."""

    @classmethod
    def of(cls, toolpath: ToolPath, machine: Machine, figures: ControlFigures) -> ControlSpeeds:
        """Raises ReachError where the machine cannot follow the tool axes."""
        moves = moves_of_points(toolpath, machine)
        if len(moves) < 2:
            return cls(*np.zeros((3, len(moves))))
        times, _, acceleration, jerk, _ = MODELS[figures.model](moves, machine, figures)
        mean: Floats = np.divide(toolpath.way_length, times, out=np.zeros(len(times)), where=times > 0.0)
        most = np.where(np.isfinite(toolpath.most_speed), toolpath.most_speed, mean)
        mean = np.minimum(mean, most)
        return cls(times, mean, highest_speeds(mean, times, most, rests(moves), acceleration, jerk))


def highest_speeds(
    mean: Floats, times: Floats, most: Floats, rests: Bools, acceleration: Floats, jerk: Floats
) -> Floats:
    """(n,) the highest speed of ways that follow each other [m/s], from their mean speed, time and most speed.

    At both ends a way is no faster than the mean of the slower one of the two ways that meet there, and stands where
    it `rests` (n,). In between the speed rises and falls evenly, in the time that a rise to the most speed takes within
    the acceleration [m/s2] and the jerk [m/s3].
    """
    low = np.where(rests[:-1], 0.0, np.minimum(mean[:-1], mean[1:]))
    begin, end = np.append(0.0, low), np.append(low, 0.0)
    rise = np.maximum(most - np.minimum(begin, end), 1e-12)
    with np.errstate(invalid="ignore", divide="ignore"):
        ramps = rise * jerk > acceleration**2, rise / acceleration + acceleration / jerk, 2.0 * np.sqrt(rise / jerk)
        even = rise / np.where(*ramps)
        half = 0.5 * (even * times + begin + end)
        rest = half**2 - 0.5 * (begin**2 + end**2) - even * mean * times
        found = half - np.sqrt(np.maximum(rest, 0.0))
    return np.clip(np.where(np.isfinite(found), found, mean), mean, most)

"""The model `fir`: velocity pulses smoothed by two moving averages.

After Ward, Sencer, Jones and Ozturk, "Accurate prediction of machining feedrate and cycle times considering
interpolator dynamics", Int. J. Adv. Manuf. Technol. 116 (2021), arXiv 2102.02062: filters in place of ramps, corners
blended by overlap, the feed at a corner as high as the tolerance and the axes allow. Corners close to each other
are taken together here, as far as the filters see.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.controls.timing.axis_limits import limits_of, off_the_path
from toolpace.controls.timing.axis_motion import axis_ways, linear_columns
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.lookahead import cruise_speeds, lookahead_times, rests, room_of
from toolpace.programs.commanded import Commanded

SHORTEST = 1e-6
"""Of a moving average [s]."""

if TYPE_CHECKING:
    from toolpace.machine.limits import Limits
    from toolpace.machine.machine import Machine


def filtered_times(moves: Commanded, machine: Machine, figures: ControlFigures) -> Floats:
    """Time of each move (n,) [s], dwells left out. Rapids ramp by their axes' limits, as of the model `lookahead`."""
    from toolpace.kernels import controls

    limits = limits_of(machine, figures)
    ways = axis_ways(moves, machine, joints=figures.limits == "joints")
    cruise = cruise_speeds(moves, ways, limits.velocity, limits.acceleration, figures.block_time)
    ramp, smoothing = filter_lengths(moves, machine, limits, figures)
    stop = rests(moves)
    speeds = controls.blended_speeds(
        cruise, ways.length, ways.first, ways.last, stop, room_of(moves, figures), limits.acceleration, limits.jerk,
        off_the_path(machine, figures), ramp, smoothing,
    )  # fmt: skip
    times = controls.pulse_times(cruise, ways.length, speeds, ramp + smoothing)
    return np.where(moves.rapid, lookahead_times(moves, machine, figures), times)


def filter_lengths(moves: Commanded, machine: Machine, limits: Limits, figures: ControlFigures) -> tuple[float, float]:
    """Lengths of the two moving averages [s], the longer first.

    What is not told follows from the slowest linear axis: the first average lets it reach the program's highest feed
    at its most acceleration, the second lets that build up at its most jerk.
    """
    linear = linear_columns(machine)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(moves.time > 0.0, moves.length / moves.time, moves.speed)
    cutting = speed[np.isfinite(speed) & ~moves.rapid & (moves.length > 0.0)]
    feed = min(float(cutting.max(initial=0.0)), float(limits.velocity[linear].max()))
    slowest = float(limits.acceleration[linear].min())
    ramp = figures.ramp_time or (feed / slowest if np.isfinite(feed) else 0.0)
    smoothing = figures.smoothing_time or (slowest / float(limits.jerk[linear].min()) if np.isfinite(slowest) else 0.0)
    return max(ramp, smoothing, SHORTEST), max(min(ramp, smoothing), SHORTEST)

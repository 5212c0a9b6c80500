"""Preset speeds and accelerations at reference points that give every interval a quintic law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.kernels.planners import genetic
from toolpace.kernels.planners.quintic_interval import Interval
from toolpace.planning.endstate import EndState
from toolpace.planning.genetic.problem import Intervals
from toolpace.planning.mesh.initial_guess import guess

REPAIRS = 2000
RESOLUTION = 600
"""Points of the ramps from which the speeds are taken."""


@dataclass(frozen=True)
class Preset:
    """Speeds and accelerations of s at the reference points (n + 1,), and periods (n,) that keep to the limits."""

    speed: Floats
    acceleration: Floats
    periods: Floats


def preset(parts: Intervals, start: EndState, end: EndState, reserve: float) -> Preset:
    """Speeds at the reference points: those of jerk-limited ramps, lowered until each interval has a law, then raised.

    The paper sets them "in advance" and does not say how. The accelerations follow from the speeds.
    """
    run, points = parts.run, parts.points
    rough = guess(run, parts.limits, (start.speed**2, end.speed**2), RESOLUTION)
    z = np.interp(points, rough.s, rough.z)
    speed = np.sqrt(reserve * z)
    acceleration = np.zeros(len(points))
    speed[0], acceleration[0], speed[-1], acceleration[-1] = (
        start.speed, start.acceleration, end.speed, end.acceleration
    )  # fmt: skip
    fixed = np.zeros(len(points), dtype=np.int64)
    fixed[[0, -1]] = 1
    intervals = Interval(parts.x, parts.share, parts.pace)
    periods, bad, value, which = genetic.preset(intervals, speed, acceleration, fixed, reserve, REPAIRS)
    if bad >= 0:
        raise InfeasibleError(
            f"genetic: no preset speeds for {parts.interval_name(bad)}: its best law takes {value:.4g} of"
            f" {parts.limit_name(which)}; give more intervals, or start slower"
        )
    genetic.raise_speeds(intervals, speed, acceleration, fixed, reserve, periods)
    return Preset(speed, acceleration, periods)

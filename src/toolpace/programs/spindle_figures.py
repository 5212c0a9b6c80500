"""Figures over the speed of a spindle: what its motor gives, and how deep a tool cuts there without chatter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.errors import UsageError

MOST_POINTS = 100_000


@dataclass(frozen=True)
class SpeedCurve:
    """A quantity over spindle speed, straight between its points. Raises UsageError for points that do not ascend."""

    speed: tuple[float, ...]
    """(k,) turns per second [1/s], ascending."""
    value: tuple[float, ...]
    """(k,) above zero, in SI."""

    def __post_init__(self) -> None:
        if not self.speed or len(self.speed) != len(self.value) or len(self.speed) > MOST_POINTS:
            raise UsageError(f"a curve over spindle speed has 1 to {MOST_POINTS} points, each a speed and a value")
        if not all(math.isfinite(each) and each > 0.0 for each in (*self.speed, *self.value)):
            raise UsageError("a curve over spindle speed: speeds and values must be above zero")
        if any(after <= before for before, after in zip(self.speed, self.speed[1:])):
            raise UsageError("a curve over spindle speed: its speeds must ascend, each once")

    def at(self, speed: float) -> float:
        """At a speed [1/s]; beyond the ends that of the nearest end."""
        return float(np.interp(speed, self.speed, self.value))

    def least(self, low: float, high: float) -> float:
        """The least between two speeds [1/s]; nan where the curve does not reach over both."""
        if low < self.speed[0] or high > self.speed[-1]:
            return math.nan
        inside = [value for speed, value in zip(self.speed, self.value) if low < speed < high]
        return min(self.at(low), self.at(high), *inside)


@dataclass(frozen=True)
class SpindleFigures:
    """What the spindle of a machine gives over its speed; None: not known."""

    power: SpeedCurve | None = None
    """[W]"""
    torque: SpeedCurve | None = None
    """[N m]"""

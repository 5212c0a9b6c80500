"""The stages of motion before and after the deflection on one clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.trajectory import Trajectory
from toolpace.study.simulation import Study


@dataclass(frozen=True)
class Stage:
    """A part of a trajectory, from one of its times to another, and what to add to them for the clock of the whole."""

    trajectory: Trajectory
    begin: float
    end: float
    shift: float

    def times(self, count: int, shown: tuple[float, float] | None = None) -> Floats:
        """(n,) times of the trajectory, evenly spread over the part of the stage that is shown on the whole's clock."""
        low, high = shown or (-np.inf, np.inf)
        begin, end = max(self.begin, low - self.shift), min(self.end, high - self.shift)
        return np.linspace(begin, end, count) if end > begin else np.empty(0)


def undisturbed(study: Study) -> dict[str, list[Stage]]:
    """The plans without deflection, from their start."""
    return {name: [Stage(before, 0.0, before.duration, 0.0)] for name, (before, _) in study.pairs().items()}


def disturbed(study: Study) -> dict[str, list[Stage]]:
    """The ways back, each with what was driven before it; the clock begins at the deflection.

    Behind the way back to the letter the known motion goes on, from the next reference point.
    """
    pairs = study.pairs()
    known = pairs["genetic"][0]
    way = study.literal["acceleration"].trajectory
    before = {name: Stage(pairs[name][0], 0.0, instant, -instant) for name, instant in study.instant.items()}
    onwards = Stage(known, study.next_point, known.duration, way.duration - study.next_point)
    out = {"literal": [before["genetic"], Stage(way, 0.0, way.duration, 0.0), onwards]}
    return out | {name: [before[name], Stage(after, 0.0, after.duration, 0.0)] for name, (_, after) in pairs.items()}

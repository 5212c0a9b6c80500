"""What changes between a move and the next: velocity and acceleration of each axis, a unit of speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.controls.timing.axis_motion import AxisWays


@dataclass(frozen=True)
class Transitions:
    """The transitions at the ends of moves that the control does not rest at; the rows of others are zero."""

    kink: Floats
    """(n, axes) change of the rates: at a speed v the velocity of axis j changes by v kink_j."""
    bend: Floats
    """(n, axes) change of the curvature: its acceleration changes by v^2 bend_j."""
    longer: Floats
    """(n,) length of the longer one of both moves; inf where there is no transition."""
    mean: Floats
    """(n,) mean length of both; inf where there is no transition."""
    straight: Bools
    """(n,) whether both are straight."""

    @classmethod
    def of(cls, ways: AxisWays, stop: Bools, line: Floats) -> Transitions:
        """Those between moves with these ways; moves of length zero are passed over.

        line: (n,) length of the straight way that each move is part of.
        """
        count, axes = ways.first.shape
        kink, bend = np.zeros((count, axes)), np.zeros((count, axes))
        longer, mean = np.full(count, np.inf), np.full(count, np.inf)
        curved = (np.abs(ways.bend_first) + np.abs(ways.bend_last)).max(axis=1, initial=0.0) > 0.0
        straight = np.ones(count, dtype=bool)
        rows = np.flatnonzero(ways.length > 0.0)
        here, there = rows[:-1], rows[1:]
        resting = np.logical_or.reduceat(stop, rows)[:-1] if len(rows) else np.zeros(0, dtype=bool)
        here, there = here[~resting], there[~resting]
        kink[here] = np.abs(ways.first[there] - ways.last[here])
        bend[here] = np.abs(ways.bend_first[there] - ways.bend_last[here])
        longer[here] = np.maximum(line[here], line[there])
        mean[here] = 0.5 * (line[here] + line[there])
        straight[here] = ~curved[here] & ~curved[there]
        return cls(kink, bend, longer, mean, straight)


def least_ratio(limit: Floats, change: Floats) -> Floats:
    """(n,) the least limit over change of the axes (n, axes); inf where nothing changes."""
    with np.errstate(divide="ignore"):
        ratio = np.where(change > 0.0, limit / np.where(change > 0.0, change, 1.0), np.inf)
    return np.asarray(ratio.min(axis=1, initial=np.inf))

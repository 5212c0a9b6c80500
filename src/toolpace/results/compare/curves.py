"""Tip speed and time over path length, for the curves of a comparison."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.set_point_files import read_set_points, set_points_file
from toolpace.results.report.series import tip_speed

MOST = 6000
"""Points of a curve over the way."""
ALIKE = 0.01
"""Share by which ways may differ in length to be one way, of which it can be told who is where when."""


@dataclass(frozen=True)
class MotionAlong:
    """A motion along the way of its tip."""

    way: Floats
    """(n,) [m], never falling."""
    speed: Floats
    """(n,) [m/s]."""
    t: Floats
    """(n,) [s]."""


def along(folder: Path) -> MotionAlong | None:
    """The motion of a plan; None where it was written without set-points, or has no tool. Raises UsageError."""
    if not set_points_file(folder):
        return None
    setpoints = read_set_points(folder)
    if not setpoints.has_tool or len(setpoints) < 2:
        return None
    return MotionAlong(np.concatenate(([0.0], np.cumsum(setpoints.tip_steps))), tip_speed(setpoints), setpoints.t)


def thinned(motion: MotionAlong) -> tuple[Floats, Floats]:
    """Way [m] and speed [m/s] of at most `MOST` points: of each stretch the slowest and the fastest."""
    n = len(motion.way)
    if n <= MOST:
        return motion.way, motion.speed
    edges = np.linspace(0, n, MOST // 2 + 1).astype(np.int64)
    picked = []
    for first, last in itertools.pairwise(edges):
        stretch = motion.speed[first:last]
        picked += sorted((int(first + stretch.argmin()), int(first + stretch.argmax())))
    at = np.array(picked)
    return motion.way[at], motion.speed[at]


def later(motion: MotionAlong, first: MotionAlong) -> tuple[Floats, Floats] | None:
    """Along the way of the first [m], how much later than it another motion is at each place [s].

    None where the ways differ: they are then not of one path. Places are matched by the share of the way.
    """
    length, other = first.way[-1], motion.way[-1]
    if not length > 0.0 or abs(other / length - 1.0) > ALIKE:
        return None
    share = np.linspace(0.0, 1.0, MOST // 4)
    return share * length, _when(motion, share) - _when(first, share)


def _when(motion: MotionAlong, share: Floats) -> Floats:
    """(n,) when the tip leaves the places at these shares of its way [s]."""
    at = np.searchsorted(motion.way, share * motion.way[-1], side="right")
    before, after = np.clip(at - 1, 0, None), np.clip(at, None, len(motion.way) - 1)
    step = motion.way[after] - motion.way[before]
    part = np.where(step > 0.0, (share * motion.way[-1] - motion.way[before]) / np.where(step > 0.0, step, 1.0), 0.0)
    found: Floats = motion.t[before] + part * (motion.t[after] - motion.t[before])
    return found

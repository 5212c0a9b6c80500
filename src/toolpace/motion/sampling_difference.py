"""How far set-points are from a sampling of a trajectory."""

from __future__ import annotations

import math

import numpy as np

from toolpace.motion.set_point_grid import grids
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory


def largest_difference(trajectory: Trajectory, points: SetPoints) -> tuple[float, int]:
    """By how many grids of their rounding positions differ at most, and the set-point where they do so the most.

    Infinite where there are more or fewer of them, or where one names a block that is not run at it or beside it.
    """
    dt = float(points.t[1] - points.t[0])
    sampled = trajectory.sample(dt, on_grid=True)
    if len(sampled) != len(points):
        return math.inf, min(len(sampled), len(points)) - 1
    off = np.zeros(len(points))
    for joint, grid in enumerate(grids(trajectory.limits, dt)[0]):
        np.maximum(off, np.abs(sampled.q[:, joint] - points.q[:, joint]) / grid, out=off)
    beside = np.concatenate([sampled.block[:1], sampled.block, sampled.block[-1:]])
    named = (points.block == beside[:-2]) | (points.block == beside[1:-1]) | (points.block == beside[2:])
    off[~named] = math.inf
    worst = int(np.argmax(off))
    return float(off[worst]), worst

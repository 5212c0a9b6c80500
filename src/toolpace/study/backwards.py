"""How far a way back goes backwards: the tip along the arc, and each joint against the motion that it comes from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.motion.trajectory import Trajectory

SAMPLES = 4001
"""Times that are looked at: of a way back of half a second one every eighth of a millisecond, in which the tip moves by
0.004 mm; near a place of return by its square."""


@dataclass(frozen=True)
class Backwards:
    """What is gone backwards between the deflection and the rejoining."""

    tip: float
    """Of the nearest point of the arc [m]."""
    joints: Floats
    """(m,) of each joint [m or rad]."""


def along_arc(tip: Floats, radius: float) -> Floats:
    """(n,) length of the paper's arc up to its nearest point to each tip (n, 3), in closed form [m]."""
    length: Floats = radius * np.arctan2((tip[:, 0] + tip[:, 1]) / np.sqrt(2.0), tip[:, 2])
    return length


def most_gone_back(values: Floats) -> Floats:
    """(m,) most by which values (n, m) fall behind what they had reached."""
    behind: Floats = (np.maximum.accumulate(values, axis=0) - values).max(axis=0)
    return behind


def gone_back(way: Trajectory, duration: float, radius: float) -> Backwards:
    """That of the first `duration` [s] of a trajectory; a joint's direction is the one it starts with."""
    t = np.linspace(0.0, duration, SAMPLES)
    motion = way.at(t)
    forward = np.sign(motion.qd[0])
    tip = along_arc(way.tip(t)[0], radius)
    return Backwards(float(most_gone_back(tip[:, None])[0]), most_gone_back(motion.q * forward))

"""Smooth random paths of any number of joints, by seed, and limits like those of a machine for them."""

from __future__ import annotations

import numpy as np

from testbed import jets
from toolpace.machine.limits import Limits

JOINTS = 5


def harmonics(seed: int, joints: int = JOINTS, modes: int = 4) -> jets.Remembered:
    """A smooth random path f(s, order) over [0, 1], each joint a sum of harmonics."""
    return jets.Remembered(jets.harmonics(np.random.default_rng(seed), joints, modes))


def random_limits(seed: int, joints: int = JOINTS, tight: bool = False) -> Limits:
    """Limits of a path of about a metre; `tight` with a fifth of the jerk."""
    rng = np.random.default_rng(seed + 77)
    jerk = rng.uniform(10.0, 40.0, joints) * (0.2 if tight else 1.0)
    return Limits(rng.uniform(0.5, 2.0, joints), rng.uniform(1.5, 6.0, joints), jerk)

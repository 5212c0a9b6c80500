"""How much of its limits a motion uses, at very many times and by nothing but its own joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.verdict import usage_at
from toolpace.machine.limits import KINDS
from toolpace.motion.trajectory import Trajectory


def dense_usage(trajectory: Trajectory, samples: int = 20_000, seed: int = 0, kinds: Sequence[str] = KINDS) -> float:
    """Largest value over limit at random times of a path of one run, feed cap included."""
    t = np.random.default_rng(seed).uniform(0.0, trajectory.duration, samples)
    return usage_at(trajectory, np.sort(t), kinds)

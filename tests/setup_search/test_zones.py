"""Forbidden zones, against looking at many positions on each way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.setup_search.choices import Zone

JOINTS = ("X", "Y", "A")


@pytest.mark.parametrize("seed", range(20))
def test_ways_that_enter_are_found(seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (40, 3))
    q[5] = q[4]
    q[9, :2] = q[8, :2]
    low, high = np.sort(rng.uniform(-1.0, 1.0, (2, 2)), axis=0)
    zone = Zone("changer", {"X": (low[0], high[0]), "A": (low[1], math.inf)})
    u = np.linspace(0.0, 1.0, 4001)[:, None]
    entered = zone.entered(JOINTS, q)
    for i in range(len(q) - 1):
        between = q[i] + u * (q[i + 1] - q[i])
        inside = (between[:, 0] >= low[0]) & (between[:, 0] <= high[0]) & (between[:, 2] >= low[1])
        if inside.any():
            assert entered[i]
        elif entered[i]:
            # only a corner that the looks miss
            near = np.maximum(np.maximum(low[0] - between[:, 0], between[:, 0] - high[0]), low[1] - between[:, 2])
            assert near.min() < 1e-3

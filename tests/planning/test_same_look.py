"""The genetic planner is held to the same look as the others: no limit is passed between its nodes either."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from tests.support.usage import dense_usage
from toolpace.kernels.planners import quintic_interval
from toolpace.kernels.planners.quintic_interval import Interval
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import plan


@pytest.mark.parametrize("seed", range(10))
def test_splines_with_knots_close_together(seed):
    """Detail between a few knots a hundred times closer than the others, where a grid even in time sees nothing."""
    random = np.random.default_rng(seed)
    joints, count = int(random.integers(1, 4)), int(random.integers(20, 60))
    steps = 10.0 ** random.uniform(-2.0, 0.0, count)
    s = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    way = np.sin(3.0 * s[:, None] + random.uniform(0, 6, joints))
    way += 1e-4 * random.normal(size=way.shape) * np.gradient(s)[:, None]
    path = AxisPath.from_spline(make_interp_spline(s, way, k=5))
    limits = Limits(*(random.uniform(0.3, 3, joints) * 10**k for k in range(3)))
    trajectory = plan(path, limits, planner="genetic")
    assert trajectory.usage().worst <= PROMISED
    assert dense_usage(trajectory, 300_000) <= PROMISED


def test_a_search_that_ends_early_says_the_same():
    random = np.random.default_rng(1)
    for _ in range(2000):
        nodes, joints = int(random.integers(5, 40)), int(random.integers(1, 6))
        x = np.linspace(0.0, 0.1, nodes)
        interval = Interval(x, random.normal(size=(nodes, 6, joints)) ** 3, np.ones(nodes))
        ends = np.array([1.0, random.normal(), random.uniform(0.7, 1.4), random.normal()])
        period = 0.1 * random.uniform(0.7, 1.4)
        value, kind, node = quintic_interval.usage(interval, ends, period, np.inf, -1)
        first = int(random.integers(-1, nodes))
        above, _, _ = quintic_interval.usage(interval, ends, period, value * 1.001, first)
        assert above == value
        below, _, at = quintic_interval.usage(interval, ends, period, value * 0.5, first)
        assert value * 0.5 <= below <= value * (1.0 + 1e-9)
        assert kind == -1 or (0 <= node < nodes and 0 <= at < nodes)

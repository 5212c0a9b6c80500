"""Units are a matter of taste: joints, parameter and time scaled by 1e-6 to 1e6 change no result by more than 1e-9."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import harmonics
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound.continuous import continuous_bound
from toolpace.planning.genetic import Genetic
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.planner import Planner, plan
from toolpace.planning.second_order import SecondOrder

ALIKE, USED = 1e-9, 1e-6
"""Of durations, bounds and mesh; and of usage: a jerk that is not at its limit is as exact as the solver's end."""


def results(seed: int, planner: Planner, q: float = 1.0, s: float = 1.0, t: float = 1.0) -> np.ndarray:
    """Duration, bounds and usage in units of the path that is not scaled, and the mesh."""
    random = np.random.default_rng(seed)
    joints = int(random.integers(1, 6))
    jets = harmonics(random, joints, 6)
    bounds = [random.uniform(low, high, joints) for low, high in ((0.5, 2.0), (1.5, 6.0), (10.0, 40.0))]
    limits = Limits(*(bound * q / t**k for k, bound in enumerate(bounds, start=1)))
    speed = random.uniform(0.3, 3.0)
    path = AxisPath.from_callable(
        lambda x, order: jets(x / s)[order] * q / s**order, 0.0, s, speed_cap=speed * s / t, breaks=[0.37 * s]
    )
    found = plan(path, limits, planner=planner)
    usage = found.usage()
    peaks = [usage.feed, *usage.velocity.values(), *usage.acceleration.values(), *usage.jerk.values()]
    bound = 0.0
    if isinstance(planner, Optimal) and planner.mesh is None:
        bound = continuous_bound(path.runs[0], limits, found.laws[0])
    peaks = [min(peak, 10.0) for peak in peaks]
    return np.array([found.duration / t, found.lower_bound / t, bound / t, found.mesh_points, *peaks])


@pytest.mark.parametrize(
    "planner",
    [
        Optimal(mesh=200), Optimal(mesh=200, guard=False), pytest.param(Optimal(), marks=pytest.mark.sweep),
        SecondOrder(mesh=200), Genetic(),
    ],
    ids=str,
)  # fmt: skip
@pytest.mark.sweep
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.thorough)])
def test_scaled_units_change_nothing(planner, seed):
    random = np.random.default_rng([seed, 5])
    plain = results(seed, planner)
    for what in ("q", "s", "t"):
        for by in (1e-6, 1e6, float(10.0 ** random.uniform(-6.0, 6.0))):
            scaled = results(seed, planner, **{what: by})
            told = f"{what} by {by:g}"
            np.testing.assert_allclose(scaled[:4], plain[:4], rtol=ALIKE, atol=ALIKE, err_msg=told)
            np.testing.assert_allclose(scaled[4:], plain[4:], rtol=USED, atol=USED, err_msg=told)

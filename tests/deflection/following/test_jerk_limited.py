"""State to rest in least time: within the limits at every step, whatever target comes when."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from toolpace.common.arrays import Floats
from toolpace.kernels.follow.correction import SMALL, approach

PERIOD, MOST = 1e-3, 3e-4


def driven(targets: Floats, limits: Floats) -> Floats:
    """(n, 4) states after each period of going for a target (n,)."""
    state, out = np.zeros(4), np.empty((len(targets), 4))
    for k, target in enumerate(targets):
        approach(state, float(target), limits, PERIOD)
        out[k] = state
    return out


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
@example(110)
@example(3969)
def test_no_target_breaks_a_limit_or_leaves_the_range_of_targets(seed: int):
    rng = np.random.default_rng(seed)
    limits = np.array([10.0 ** rng.uniform(-4, 0), 10.0 ** rng.uniform(-3, 1), 10.0 ** rng.uniform(-1, 3)])
    every = int(rng.integers(1, 120))
    targets = np.repeat(rng.uniform(-MOST, MOST, 600 // every + 1), every)[:600]
    if rng.random() < 0.3:
        targets = MOST * np.sign(targets)
    states = driven(targets, limits)
    x = np.concatenate([np.zeros(3), states[:, 0]])
    for order, limit in enumerate(limits, 1):
        rounding = 2.0**order * 1e-19 / PERIOD**order
        assert np.abs(np.diff(x, order)).max() / PERIOD**order <= limit * (1.0 + 1e-9) + rounding
    # a way below this counts as none: of 6000 seeds two pass the range, by a fifth and by three quarters of it
    assert np.abs(states[:, 0]).max() <= MOST + SMALL * limits[1] * PERIOD**2


def test_rest_to_rest_takes_the_time_of_four_jerks():
    """(32 x / j)^(1/3) where neither velocity nor acceleration is reached."""
    states = driven(np.full(200, 1e-4), np.array([1.0, 10.0, 4.0]))
    time = (32.0 * 1e-4 / 4.0) ** (1.0 / 3.0)
    there = np.flatnonzero(np.abs(states[:, 0] - 1e-4) < 1e-12)[0] + 1
    assert there * PERIOD == pytest.approx(time, abs=1.5 * PERIOD)
    assert states[-1, :3] == pytest.approx([1e-4, 0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("seed", range(40))
def test_least_time_is_that_of_ruckig(seed: int):
    ruckig = pytest.importorskip("ruckig")
    rng = np.random.default_rng(seed)
    limits = np.array([10.0 ** rng.uniform(-3, 0), 10.0 ** rng.uniform(-2, 1), 10.0 ** rng.uniform(0, 3)])
    states = driven(rng.uniform(-MOST, MOST, 30).repeat(7), limits)
    state, target = states[-1].copy(), float(rng.uniform(-MOST, MOST))
    asked = ruckig.InputParameter(1)
    asked.current_position, asked.current_velocity, asked.current_acceleration = ([float(v)] for v in state[:3])
    asked.target_position = [target]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = ([float(v)] for v in limits)
    answer = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(asked, answer)
    steps = 0
    while max(abs(state[0] - target) / MOST, abs(state[1]) / limits[0], abs(state[2]) / limits[1]) > 1e-9:
        approach(state, target, limits, PERIOD)
        steps += 1
        assert steps < 10_000
    assert steps * PERIOD <= answer.duration * (1.0 + 1e-6) + 2.0 * PERIOD


def test_a_lowered_limit_of_velocity_is_reached_as_fast_as_the_others_allow():
    limits = np.array([2e-3, 0.4, 4.0])
    state = np.zeros(4)
    while state[1] < 2e-3 - 1e-9:
        approach(state, 1.0, limits, PERIOD)
    lower = np.array([5e-4, 0.4, 4.0])
    steps = 0
    while state[1] > 5e-4 + 1e-12:
        approach(state, 1.0, lower, PERIOD)
        steps += 1
    assert steps * PERIOD <= 2.0 * np.sqrt(1.5e-3 / 4.0) + 2.0 * PERIOD

"""Prices of limits: against plans with each limit raised, against the scaling of time, and where there are none."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.common.errors import UsageError
from toolpace.machine.limits import KINDS, Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning import prices as module
from toolpace.planning.bound import relaxation
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan

POWER = {"feed": 1.0, "velocity": 1.0, "acceleration": 2.0, "jerk": 3.0}


def assert_as_planned_again(prices, path, limits, names, **options):
    """Prices against plans with one percent more of a limit; where another limit takes over within that one percent, as
    at 0.2 percent in one of 246, also with one percent less."""

    def duration(name, factor):
        kind, _, joint = name.partition(" ")
        factors = np.where(np.array(limits.joints) == joint, factor, 1.0)
        return plan(path, limits.scaled(**{kind: factors}), bound=False, **options).duration

    whole = plan(path, limits, bound=False, **options).duration
    for name in names:
        gain = whole - duration(name, 1.01)
        within = max(0.1 * abs(gain), 1e-4 * whole)
        if prices[name] > gain + within:
            gain = duration(name, 0.99) - whole
        assert abs(prices[name] - gain) <= within, name


def scaled_sum(prices):
    return sum(POWER[name.split()[0]] * price for name, price in prices.items())


@pytest.mark.parametrize("seed", [0, 8, 11])
def test_prices_are_what_plans_with_raised_limits_gain(seed):
    joints = 1 + seed % 6
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, seed % 2 == 1)
    prices = plan(path, limits).prices()
    assert list(prices.values()) == sorted(prices.values(), reverse=True)
    assert_as_planned_again(prices, path, limits, list(prices)[:3])


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(100, 106))
def test_prices_are_what_plans_gain_on_many(seed):
    joints = 1 + seed % 7
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, seed % 2 == 1)
    prices = plan(path, limits).prices()
    names = [f"{kind} {joint}" for kind in KINDS for joint in limits.joints]
    assert_as_planned_again(prices, path, limits, names)


def test_prices_of_a_motion_between_moving_ends_are_what_plans_gain():
    f, limits = harmonics(2), random_limits(2)
    whole = plan(AxisPath.from_callable(f), limits, mesh=200, bound=False)
    (s0, v0, a0), (s1, v1, a1) = (whole.state(share * whole.duration) for share in (0.3, 0.8))
    path = AxisPath.from_callable(f, s0, s1)
    ends = {"start": EndState(0.8 * v0, 0.64 * a0), "end": EndState(0.8 * v1, 0.64 * a1)}
    prices = plan(path, limits, **ends).prices()
    assert_as_planned_again(prices, path, limits, list(prices)[:2], **ends)


@pytest.mark.parametrize("mesh", [None, 100])
def test_prices_sum_as_time_scales(mesh):
    """k times the velocity, k^2 the acceleration, k^3 the jerk: 1 / k of the time, dwells left out."""
    f = harmonics(5)
    halves = [AxisPath.from_callable(f, *ends, speed_cap=0.2).runs[0] for ends in ((0.0, 0.4), (0.4, 1.0))]
    halves[0].dwell = 0.7
    trajectory = plan(AxisPath(tuple(halves), tuple("abcde")), Limits(*limit_arrays(5), tuple("abcde")), mesh=mesh)
    prices = trajectory.prices()
    assert prices["feed"] > 0.0
    assert scaled_sum(prices) == pytest.approx(0.01 * (trajectory.duration - 0.7), rel=1e-4 if mesh is None else 2e-3)


def limit_arrays(seed):
    limits = random_limits(seed)
    return limits.velocity, limits.acceleration, limits.jerk


def test_one_limit_that_holds_all_has_the_price_of_its_power():
    """A straight way held by jerk alone takes a time with the power -1/3 of it."""
    path = AxisPath.from_callable(lambda s, order: np.stack([[s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s][order]], axis=1))
    trajectory = plan(path, Limits(1e3, 1e3, 10.0))
    assert trajectory.prices()["jerk q1"] == pytest.approx(0.01 * trajectory.duration / 3.0, rel=1e-3)


def test_prices_of_parts_are_those_of_the_whole(monkeypatch):
    path, limits = AxisPath.from_callable(harmonics(4)), random_limits(4)
    trajectory = plan(path, limits, mesh=2000, bound=False)
    whole = trajectory.prices()
    monkeypatch.setattr(relaxation, "WHOLE", 1000)
    monkeypatch.setattr(relaxation, "PIECE", 600)
    monkeypatch.setattr(module, "OVERLAP_RAMPS", 3.0)
    assert len(module.parts_of(path.runs[0], limits, trajectory.laws[0])) > 1
    for name, price in trajectory.prices().items():
        assert price == pytest.approx(whole[name], rel=0.02, abs=1e-6 * trajectory.duration), name


def test_infinite_limits_have_no_price_and_other_motions_none():
    path, limits = AxisPath.from_callable(harmonics(1)), random_limits(1)
    unlimited = Limits(limits.velocity, np.full(5, np.inf), limits.jerk)
    assert not any(name.startswith("acceleration") for name in plan(path, unlimited, bound=False).prices())
    with pytest.raises(UsageError, match="planner='optimal'"):
        plan(path, limits, planner="second-order").prices()

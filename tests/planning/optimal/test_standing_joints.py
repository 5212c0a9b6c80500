"""Places where all joints stand at one parameter: reversals of a single joint, cusps, s^2 and s^3."""

import numpy as np
import pytest

from testbed.jets import path_of
from tests.support.usage import dense_usage
from toolpace import Limits, Optimal, plan
from toolpace.planning.limit_tolerances import PROMISED

MESHES = (60, 300, 1000)
WORSE = 5e-3
"""How much slower the default plan may be than the best on any of those meshes."""


def power(s, place, exponent):
    """(4, n) (s - place)^exponent and its derivatives."""
    return np.stack([(s - place) ** exponent] + [falling(s - place, exponent, order) for order in (1, 2, 3)])


def falling(x, exponent, order):
    factor = float(np.prod(np.arange(exponent, exponent - order, -1)))
    return factor * x ** max(exponent - order, 0) if order <= exponent else np.zeros_like(x)


def standing(kind, seed):
    """A path whose joints all stand at one inner parameter, and limits over an order of magnitude."""
    random = np.random.default_rng([66, seed])
    place, scale = random.uniform(0.2, 0.8), 10.0 ** random.uniform(-1.0, 1.0)
    exponents = {"cusp": (2, 3), "reversal": (2,), "slow passage": (3,), "slow passage of two": (3, 3)}[kind]

    def jets(s):
        return np.stack([scale**k * power(s, place, exponent) for k, exponent in enumerate(exponents)], axis=2)

    count = len(exponents)
    limits = [base * 10.0 ** random.uniform(-0.5, 0.5, count) for base in (1.0, 4.0, 40.0)]
    return path_of(jets), Limits(*limits)


@pytest.mark.parametrize("kind", ["cusp", "reversal", "slow passage", "slow passage of two"])
@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.sweep) for seed in range(2, 6))])
def test_the_default_plan_is_as_good_as_the_best_of_all_meshes(kind, seed):
    path, limits = standing(kind, seed)
    best = min(plan(path, limits, planner=Optimal(mesh=mesh, bound=False)).duration for mesh in MESHES)
    default = plan(path, limits, planner=Optimal(bound=False))
    assert default.duration <= (1.0 + WORSE) * best
    assert dense_usage(default) <= PROMISED


def sine(frequency, phase):
    def jets(s):
        turned = [frequency**order * np.sin(frequency * s + phase + order * np.pi / 2.0) for order in range(4)]
        return np.stack(turned)[:, :, None]

    return jets


@pytest.mark.parametrize("seed", range(6))
def test_a_joint_that_turns_back_needs_no_more_time_than_one_that_stops_there(seed):
    random = np.random.default_rng([67, seed])
    frequency, phase = random.uniform(3.3, 9.0), random.uniform(0.0, 2.0 * np.pi)
    limits = Limits(*([base * 10.0 ** random.uniform(-0.4, 0.4)] for base in (1.0, 4.0, 40.0)))
    jets = sine(frequency, phase)
    turns = (np.pi * np.arange(-3, 12) + np.pi / 2.0 - phase) / frequency
    places = np.concatenate([[0.0], turns[(turns > 0.0) & (turns < 1.0)], [1.0]])
    positions = np.sin(frequency * places + phase)
    stopping = sum(straight(abs(way), limits) for way in np.diff(positions))
    assert plan(path_of(jets), limits, planner=Optimal(bound=False)).duration <= stopping * (1.0 + 1e-4)


def straight(way, limits):
    """The time of a joint from rest to rest over so much way, in closed form (seven phases of constant jerk) [s]."""
    v, a, j = (float(limit[0]) for limit in (limits.velocity, limits.acceleration, limits.jerk))
    a = min(a, np.sqrt(v * j))
    if way >= v * (v / a + a / j):
        return way / v + v / a + a / j
    if way >= 2.0 * a**3 / j**2:
        return a / j + np.sqrt(a**2 / j**2 + 4.0 * way / a)
    return 4.0 * (way / (2.0 * j)) ** (1.0 / 3.0)

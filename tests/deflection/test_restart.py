"""A pace that rises from rest: within the limits from any place of any motion that keeps to them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import toolpace as tp
from testbed import replans
from toolpace.cli.demo_programs import impeller_program
from toolpace.deflection.rejoin.superposed import (
    PaceRise,
    RestartFromRest,
    Shape,
    SuperposedRejoin,
    steepest,
)
from toolpace.deflection.rejoin_motion import CommandedMotion
from toolpace.motion.trajectory import Trajectory

STRAIGHT = Shape(0.5, 0.0)


@cache
def demo() -> Trajectory:
    machine = tp.Machine.load("xyzac-trunnion")
    path = tp.Path.fit(tp.read_text(impeller_program(machine), machine), machine=machine)
    return tp.plan(path, machine, bound=False)


def restarted(old: Trajectory, clock: float) -> RestartFromRest:
    """From rest on the path, at a time of the first law's clock."""
    motion = CommandedMotion.of(old, 0)
    here = motion.motion(np.array([clock]))[:3, 0]
    here[1:] = 0.0
    aside = SuperposedRejoin(motion, clock, here, clock, (0.0, 0.0, 0.0), STRAIGHT)
    return RestartFromRest(aside, PaceRise(steepest(motion, clock, old.limits)))


@pytest.mark.parametrize("k", [0.3, 40.0])
def test_the_clock_and_its_rates_are_one_motion_from_rest_to_the_full_pace(k):
    rise = PaceRise(k)
    t = np.linspace(0.0, 1.1 * rise.duration, 200_001)
    come, *rates = rise.clock(t)
    for value, rate in zip((come, *rates[:2]), rates):
        # what is integrated by trapezia is the value, but for a jump of the second derivative at each of three ends
        far = np.append(0.0, np.cumsum((rate[1:] + rate[:-1]) / 2.0 * t[1]))
        np.testing.assert_allclose(value, far, rtol=0.0, atol=1e-4 * max(float(np.abs(value).max()), 1e-9))
    assert rates[0][0] == rates[1][0] == 0.0
    assert (rates[0][t >= rise.duration] == 1.0).all() and (np.diff(rates[0]) >= -1e-15).all()
    assert rise.when(0.7 * come[-1]) == pytest.approx(np.interp(0.7 * come[-1], come, t), abs=1e-6 / k)


@pytest.mark.parametrize("place", ["demo", "arc", "spline", "five 2"])
def test_from_any_place_no_limit_is_passed_by_positions_alone(place):
    old = demo() if place == "demo" else replans.planned(place, 20000.0)
    whole = old.laws[0].duration
    for clock in np.random.default_rng(8).uniform(0.0, 0.99 * whole, 20):
        way = restarted(old, float(clock))
        t = np.linspace(STRAIGHT.duration, way.duration, 4001)
        q, step = way.motion(t)[0], t[1] - t[0]
        for order, limit in enumerate((old.limits.velocity, old.limits.acceleration, old.limits.jerk), start=1):
            change = np.abs(np.diff(q, order, axis=0)) - 2.0**order * 1e-15
            assert (change / step**order <= limit * 1.0001).all()
        # it ends on the clock and with the rates of the motion that it rejoins
        there, end = old.at(way.rejoin), way.motion(t[-1:])[:3, 0]
        sizes = (1.0, old.limits.velocity, old.limits.acceleration)
        for value, wanted, size in zip(end, (there.q, there.qd, there.qdd), sizes, strict=True):
            assert value == pytest.approx(wanted, abs=1e-9 * float(np.max(size)))


def test_where_the_run_ends_before_the_full_pace_it_ends_at_rest():
    old = replans.planned("arc", 20000.0)
    way = restarted(old, 0.9 * old.duration)
    assert way.rise.duration > way.duration - STRAIGHT.duration
    assert way.rejoin == old.laws[0].duration
    q, *rates = way.motion(np.array([way.duration]))[:, 0]
    assert q == pytest.approx(old.at(old.duration).q, abs=1e-12)
    assert (np.abs(rates[:2]) <= 1e-9).all()


def test_a_way_back_is_found_where_the_motion_is_at_its_limits_everywhere():
    """No way beside the path leaves room there: the joints are off by 2 mm and 1.4 degrees, and 2 percent too fast."""
    old = demo()
    time = 17.186003653715048
    given = [-0.02551895, -0.01207031, 0.00059076]
    axis = [-0.28111885, -0.60394248, 0.74580539]
    new = tp.replan(old, time, given, axis=axis, planner="direct")
    assert new.usage().worst <= 1.0001
    assert new.duration - (old.duration - time) < 1.2

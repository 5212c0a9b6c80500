"""A stop of all joints: from any state within the limits to rest, within them, and no later than a search finds."""

from __future__ import annotations

import numpy as np
import pytest

from testbed import replans
from toolpace.deflection.rejoin.stop import StopAlone, StopTogether, dying, stop_of_joint
from toolpace.machine.limits import Limits

LIMITS = Limits([2.0, 0.5, 10.0], [8.0, 1.0, 50.0], [80.0, 40.0, 300.0])


def states(count):
    """States (3, m) from which the limits leave a way to rest: a velocity that an acceleration does not carry on."""
    random = np.random.default_rng(4)
    while count:
        v, a = random.uniform(-1.0, 1.0, (2, 3)) * [LIMITS.velocity, LIMITS.acceleration]
        if (np.abs(v + a * np.abs(a) / (2.0 * LIMITS.jerk)) <= LIMITS.velocity).all():
            count -= 1
            yield np.stack([random.normal(size=3), v, a])


def test_it_ends_at_rest_within_the_limits_by_positions_alone():
    for start in states(200):
        stop = StopAlone(start, LIMITS, 0.0)
        t = np.linspace(0.0, stop.duration, 2001)
        q, *rates = stop.motion(t)
        assert q[0] == pytest.approx(start[0], abs=1e-12)
        assert [rate[0] for rate in rates[:2]] == [pytest.approx(start[k], rel=1e-9, abs=1e-12) for k in (1, 2)]
        step = t[1]
        for order, limit in enumerate((LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk), start=1):
            change = np.abs(np.diff(q, order, axis=0)) - 2.0**order * 1e-15
            assert (change / step**order <= limit * (1.0 + 1e-9)).all()
        # one step before the end nothing is left but what the jerk takes in it
        assert (np.abs(np.diff(q, axis=0)[-1]) <= LIMITS.jerk * step**3).all()
        assert (stop.state()[1:] == 0.0).all() and stop.state()[0] == pytest.approx(q[-1], abs=1e-12)


def test_joints_in_proportion_end_at_rest_on_their_line_within_the_limits():
    random = np.random.default_rng(9)
    for _ in range(100):
        way = random.uniform(-1.0, 1.0, 3) * LIMITS.velocity / 2.0
        rate = random.uniform(-1.0, 1.0) * 0.9 * (LIMITS.acceleration / np.abs(way)).min()
        start = np.stack([random.normal(size=3), way, rate * way])
        stop = StopTogether(start, LIMITS, 0.0)
        t = np.linspace(0.0, stop.duration, 2001)
        q = stop.motion(t)[0]
        off = (q - start[0]) - ((q - start[0]) @ way / (way @ way))[:, None] * way
        assert np.abs(off).max() < 1e-9
        step = t[1]
        for order, limit in enumerate((LIMITS.acceleration, LIMITS.jerk), start=2):
            change = np.abs(np.diff(q, order, axis=0)) - 2.0**order * 1e-15
            assert (change / step**order <= limit * (1.0 + 1e-6)).all()
        assert (np.abs(np.diff(q, axis=0)[-1]) <= LIMITS.jerk * step**3).all()
        assert (stop.state()[1:] == 0.0).all()


def test_what_is_beside_the_line_dies_away_with_all_of_its_share_of_the_jerk():
    """A fortieth for the velocities, and for the accelerations: less would take longer. By third differences."""
    random, by_rate = np.random.default_rng(3), 0
    for _ in range(100):
        way = random.uniform(-1.0, 1.0, 3) * LIMITS.velocity / 2.0
        start = np.stack([np.zeros(3), way, 10.0 ** random.uniform(-4.0, -1.0) * random.normal(size=3)])
        rate, bend, time = StopTogether(start, LIMITS, 0.0).beside
        t = np.linspace(0.0, time * (1.0 - 1e-12), 3001)
        shares = [
            (np.abs(np.diff(dying(*each, time, t)[0], 3, axis=0)).max(axis=0) / t[1] ** 3 / LIMITS.jerk).max()
            for each in ((rate, 0.0 * bend), (0.0 * rate, bend))
        ]
        assert max(shares) == pytest.approx(0.025, rel=1e-2)
        by_rate += shares[0] > shares[1]
    assert 20 < by_rate < 80


def test_what_dies_away_is_one_motion():
    """Each row is the derivative of the one before, by central differences; from the rates at first to none."""
    rate, bend, time, h = np.array([0.3, -1.0]), np.array([2.0, 0.7]), 0.8, 1e-6
    t = np.linspace(0.05, 0.75, 15)
    rows, later, sooner = dying(rate, bend, time, t), dying(rate, bend, time, t + h), dying(rate, bend, time, t - h)
    for order in (1, 2, 3):
        assert (later[order - 1] - sooner[order - 1]) / (2.0 * h) == pytest.approx(rows[order], rel=1e-7, abs=1e-7)
    first, last = dying(rate, bend, time, np.array([0.0, time]))[:3].swapaxes(0, 1)
    assert first == pytest.approx(np.stack([0.0 * rate, rate, bend]))
    assert last[1:] == pytest.approx(0.0, abs=1e-12)


def test_no_jerk_of_one_sign_and_back_stops_a_joint_sooner():
    """All stops of two ramps and an even part, by a grid of their peaks: the quickest that ends at rest."""
    for start in states(60):
        for v, a, *limits in zip(*start[1:], LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk):
            most_a, jerk = limits[1:]
            found = sum(length for length, _ in stop_of_joint(v, a, *limits))
            peaks = np.linspace(-most_a, most_a, 4001)
            ramps = np.abs(peaks - a) / jerk, np.abs(peaks) / jerk
            left = v + ramps[0] * (a + peaks) / 2.0 + ramps[1] * peaks / 2.0
            with np.errstate(divide="ignore", invalid="ignore"):
                held = -left / peaks
            rests = (held >= 0.0) & (peaks != 0.0)
            assert found <= (ramps[0] + held + ramps[1])[rests].min() * (1.0 + 1e-9)


def test_joints_at_rest_need_none():
    assert StopAlone(np.zeros((3, 3)), LIMITS, 0.0).duration == 0.0
    assert StopTogether(np.zeros((3, 3)), LIMITS, 0.0).duration == 0.0


def test_without_a_jerk_limit_a_joint_brakes_at_its_acceleration():
    steps = stop_of_joint(2.0, 0.0, 3.0, 4.0, np.inf)
    assert sum(length for length, _ in steps) == pytest.approx(0.5, rel=1e-2)


@pytest.mark.parametrize(
    ("kind", "feed", "planner", "size", "share", "way"),
    [
        # in the ramp at the start, at the limits of jerk; beside the arc the tip is too fast to go on as it was
        ("arc", 600.0, "optimal", 6.252595721631843e-3, 1e-3, [-0.47377186, 0.48299368, 0.73638124]),
        # the joints alone would be faster at the tip while they brake than together
        ("arc", 60.0, "optimal", 5.99364031497937e-3, 1e-4, [-0.28162242, 0.16988797, 0.94436588]),
        # in the ramp at the end: the way at the commanded pace takes ten minutes
        ("five 2", 600.0, "genetic", 6.24e-3, 0.99, [-0.06184887, -0.58396604, -0.80941855]),
    ],
)
def test_in_a_ramp_at_the_limits_a_way_back_is_found(kind, feed, planner, size, share, way):
    time = share * replans.planned(kind, feed).duration
    case = replans.tried(replans.Case(kind, feed, "displaced", planner, size, time), np.array(way))
    assert not case.faults, case.told()
    assert case.lost < 2.0 + 60e3 * size / feed

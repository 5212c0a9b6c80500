"""Utilisation over time and path, and the stretches in which one limit binds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.motion.active_limits import ActiveLimits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.planner import plan


@pytest.fixture(scope="module")
def trajectory():
    f = harmonics(3, 3)
    runs = [AxisPath.from_callable(f, *ends).runs[0] for ends in ((0.0, 0.4), (0.4, 1.0))]
    runs[0].dwell = 0.5
    return plan(AxisPath(tuple(runs), ("q1", "q2", "q3")), random_limits(3, 3), bound=False)


@pytest.fixture(scope="module")
def active(trajectory):
    return trajectory.active()


def test_used_is_what_the_motion_shows_at_these_times(trajectory, active):
    """From the joints' velocities and accelerations at the times, which knows nothing of probes."""
    limits, some = trajectory.limits, slice(50, None, 397)
    times = trajectory.starts[active.run[some]] + np.array(
        [trajectory.laws[k].passing_time(s) for k, s in zip(active.run[some], active.s[some])]
    )
    motion = trajectory.at(times)
    for kind, figure in (("velocity", motion.qd), ("acceleration", motion.qdd)):
        columns = [active.names.index(f"{kind} {joint}") for joint in limits.joints]
        assert np.allclose(active.used[some][:, columns], np.abs(figure) / getattr(limits, kind), atol=2e-4)
    assert np.allclose(active.t[some], times, atol=1e-9)


def test_shares_are_those_of_limited_by(trajectory, active):
    assert active.share.sum() == pytest.approx(trajectory.duration - 0.5)
    shares = trajectory.limited_by()
    for k, name in enumerate(active.names):
        binds = (active.most == k) & active.binds[:, k]
        assert active.share[binds].sum() / trajectory.duration == pytest.approx(shares.get(name, 0.0), abs=1e-9)


def test_stretches_follow_each_other_and_name_what_binds(active):
    stretches = active.stretches()
    for one, two in itertools.pairwise(stretches):
        wait = 0.5 if two.run > one.run else 0.0
        assert two.start == pytest.approx(one.end + wait, abs=1e-5)
        assert (one.run, one.limit) != (two.run, two.limit)
    assert stretches[0].limit.startswith("jerk") and stretches[0].start < 1e-9
    assert all((one.limit == "nothing") == (one.used < 0.995) for one in stretches)
    assert len(stretches) < 60
    lines = active.table().splitlines()
    assert len(lines) == 1 + len(stretches) and lines[0].split()[0] == "limit"


def test_a_limit_that_is_nearly_held_goes_on_and_one_that_is_left_ends():
    used = np.array([[1.0, 0.0], [0.99, 0.0], [1.0, 0.0], [0.9, 0.0], [1.0, 0.0], [0.99, 0.5], [0.3, 1.0]])
    n = len(used)
    ones = np.ones(n)
    active = ActiveLimits(
        ("a", "b"), np.arange(n) + 0.5, ones, np.zeros(n, dtype=int), ones, np.zeros(n, dtype=int), used
    )
    found = [(one.limit, one.start, one.end) for one in active.stretches()]
    assert found == [("a", 0.5, 3.0), ("nothing", 3.0, 4.0), ("a", 4.0, 5.0), ("nothing", 5.0, 6.0), ("b", 6.0, 6.5)]


def test_jerks_without_bound_are_nan():
    active = plan(AxisPath.from_callable(harmonics(3, 2)), random_limits(3, 2), planner="second-order").active()
    assert np.isnan(active.used[:, -2:]).all() and not np.isnan(active.used[:, :-2]).any()
    assert {one.limit.split()[0] for one in active.stretches()} <= {"velocity", "acceleration", "nothing"}

"""A plan of joints with limits and no machine is followed at any pace, within these limits."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Follower, Measurement, Status

WAYPOINTS = {
    1: [[0.0], [0.3], [0.1]],
    3: [[0.0, 0.0, 0.1], [0.2, 0.1, 0.0], [0.3, -0.1, 0.2], [0.0, 0.1, 0.1]],
    5: [[0.0, 0.0, 0.1, 0.0, 0.5], [0.2, 0.1, 0.0, -1.0, 0.1], [0.3, -0.1, 0.2, 0.5, 0.3]],
}


def planned(count: int, share: float = 1.0):
    limits = tp.Limits(np.linspace(0.3, 0.5, count), np.linspace(2.0, 3.0, count), np.linspace(40.0, 60.0, count))
    path = tp.AxisPath.from_waypoints(WAYPOINTS[count])
    return tp.plan(path, limits.scaled(share, share, share), bound=False), limits


@pytest.mark.parametrize("count", WAYPOINTS)
@pytest.mark.parametrize("share", [1.0, 0.9])
def test_it_goes_to_the_end_within_the_limits_with_holds_and_changes_of_pace(count: int, share: float):
    trajectory, limits = planned(count, share)
    follower = Follower(trajectory, limits, reserve=0.1)
    start, q = trajectory.at(0.0).q, [trajectory.at(0.0).q] * 3
    held = 0
    for k in range(20_000):
        point = follower.step(feed=0.0 if k < 50 or 400 < k < 1500 else 1.1 if k < 2000 else 0.8)
        assert point.q.shape == point.qddd.shape == (count,) and point.correction.shape == (4, count)
        if k < 50:
            assert np.array_equal(point.q, start)
        held += k > 400 and bool(point.status & Status.HELD)
        q.append(point.q)
        if point.status & Status.ENDED:
            break
    assert point.status & Status.ENDED and held > 100
    assert point.q == pytest.approx(trajectory.at(trajectory.duration).q, abs=1e-9)
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        used = np.abs(np.diff(np.array(q), order, axis=0)).max(axis=0) / 1e-3**order / limit
        assert used.max() <= 1.0 + 1e-4


def test_a_law_of_limits_is_the_same_from_its_file(tmp_path):
    trajectory, limits = planned(3)
    follower = Follower(trajectory, limits)
    follower.save(tmp_path / "three.law")
    again = Follower.load(tmp_path / "three.law")
    for _ in range(100):
        assert np.array_equal(again.step(feed=0.5).q, follower.step(feed=0.5).q)
    # how far the path leaves the plan is known of a plan only; of either the line says how long it is
    assert 0.0 < follower.off_the_plan < 1e-6 and np.isnan(again.off_the_plan)
    assert repr(again) == f"<Follower {follower.duration:.6g} s, a set-point every 0.001 s>"


def test_names_of_limits_are_those_of_the_joints_or_none():
    path = tp.AxisPath.from_waypoints(WAYPOINTS[3], joints=("X", "Y", "Z"))
    named = tp.Limits(0.3, 2.0, 40.0, ("X", "Y", "Z"))
    trajectory = tp.plan(path, named, bound=False)
    assert Follower(trajectory, named).duration == Follower(trajectory, tp.Limits([0.3] * 3, 2.0, 40.0)).duration
    with pytest.raises(UsageError, match="moves X, Y, Z, limits has X, Y, B; give limits of the same joints"):
        Follower(trajectory, tp.Limits(0.3, 2.0, 40.0, ("X", "Y", "B")))


def test_what_limits_alone_cannot_do_is_told():
    trajectory, limits = planned(3)
    with pytest.raises(UsageError, match="of limits alone knows no tool; give a Machine"):
        Follower(trajectory, limits).step(Measurement(0.0, deflection=np.zeros(3)))
    with pytest.raises(UsageError, match="a compliance is of a tool on a machine"):
        Follower(trajectory, limits, compliance=1e-7 * np.eye(3))
    with pytest.raises(UsageError, match="q2 has no limit of jerk; give limits one"):
        Follower(trajectory, tp.Limits(0.3, 2.0, [40.0, np.inf, 40.0]))
    six = tp.AxisPath.from_waypoints(np.vstack([np.zeros(6), np.ones(6)]))
    limits = tp.Limits([0.3] * 6, 2.0, 40.0)
    with pytest.raises(UsageError, match="moves 6 joints; at most 5 can be followed"):
        Follower(tp.plan(six, limits, bound=False), limits)
    with pytest.raises(UsageError, match="float in place of a machine; give a Machine, or Limits"):
        Follower(trajectory, 1.0)

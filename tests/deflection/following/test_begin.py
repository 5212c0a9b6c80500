"""A follower begins at rest at the pace that it is given: held from its first step no joint moves."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.followed.campaign import campaign
from testbed.followed.cases import case
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Follower, Measurement, Status
from toolpace.kernels.follow import layout

CASES = ("arc on paper-ab", "fan")


def differences(q, order: int, period: float):
    """(joints,) largest of a derivative by differences of set-points (n, joints), from rest at the first."""
    whole = np.vstack([np.tile(q[0], (order, 1)), q])
    return np.abs(np.diff(whole, order, axis=0)).max(axis=0) / period**order


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("feed", [0.0, -1.0, np.nan])
def test_held_from_the_first_step_it_does_not_move_at_all(name: str, feed: float):
    followed = case(name, 0.1)
    follower, start = Follower(followed.trajectory, followed.machine), followed.trajectory.at(0.0).q
    for k in range(300):
        point = follower.step(feed=feed)
        assert np.array_equal(point.q, start) and point.status & Status.HELD
        assert not (point.qd.any() or point.qdd.any() or point.qddd.any())
        assert point.pace == 0.0 and point.path_time == 0.0 and point.s == 0.0
        assert point.t == pytest.approx((k + 1) * 1e-3)
    # let go, it is the plan from there on, without a ramp
    played = Follower(followed.trajectory, followed.machine)
    for _ in range(300):
        assert np.array_equal(follower.step().q, played.step().q)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("feed", [0.1, 0.37, 1.0, 1.2])
def test_it_starts_at_the_pace_that_it_is_given(name: str, feed: float):
    followed = case(name, 0.1)
    trajectory, machine = followed.trajectory, followed.machine
    follower, pace = Follower(trajectory, machine), min(feed, 1.0)
    q = [trajectory.at(0.0).q] * 3
    for k in range(1, 400):
        point = follower.step(feed=feed)
        if feed <= 1.0:
            assert point.pace == pace
            at = trajectory.at(pace * k * 1e-3 * follower.pace)
            assert point.q == pytest.approx(at.q, abs=follower.off_the_plan + 1e-12)
        assert point.pace >= pace
        q.append(point.q)
    limits = machine.limits
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        assert (differences(np.array(q), order, 1e-3) <= limit * (1.0 + 1e-4)).all()


def test_reset_begins_anew():
    followed = case(CASES[0], 0.1)
    follower = Follower(followed.trajectory, followed.machine)
    first = [follower.step(feed=0.5).q for _ in range(50)]
    follower.reset()
    assert not follower.state.any()
    assert np.array_equal(first, [follower.step(feed=0.5).q for _ in range(50)])


def test_from_the_zeros_of_control_code_the_first_override_is_the_pace():
    from toolpace.kernels.follow.step import step

    followed = case(CASES[0], 0.1)
    follower = Follower(followed.trajectory, followed.machine)
    for override, pace, cut in ((0.0, 0.0, False), (0.6, 0.6, False), (np.nan, 0.0, True), (np.inf, 0.0, True)):
        state, given = np.zeros(layout.STATE), np.full(layout.INPUTS, np.nan)
        given[layout.OVERRIDE], out = override, np.empty(layout.OUTPUTS)
        step(follower.piece, state, given, out)
        assert out[layout.OUT_PACE] == pace
        assert bool(int(out[layout.STATUS]) & layout.OVERRIDE_CUT) is cut


@pytest.mark.parametrize(
    "feed, taken", [(2.0, 1.2), (1.2 + 1e-9, 1.2), (-1e-9, 0.0), (np.inf, 0.0), (-np.inf, 0.0), (np.nan, 0.0)]
)
def test_an_override_that_is_cut_is_told(feed: float, taken: float):
    followed = case(CASES[0], 0.1)
    one, other = (Follower(followed.trajectory, followed.machine) for _ in range(2))
    for _ in range(200):
        cut, asked = one.step(feed=feed), other.step(feed=taken)
        assert cut.status == asked.status | Status.OVERRIDE_CUT
        assert not asked.status & Status.OVERRIDE_CUT
        assert np.array_equal(cut.q, asked.q)


@pytest.mark.parametrize("feed", [None, "0", "1.0", b"1", True, False, np.True_, [None], (0.0,), object()])
def test_what_is_no_number_is_no_override(feed):
    followed = case(CASES[0], 0.1)
    follower = Follower(followed.trajectory, followed.machine)
    with pytest.raises(UsageError, match=r"step: feed is .*; give a share from 0 to 1.2"):
        follower.step(feed=feed)
    assert not follower.state.any()


@pytest.mark.parametrize(
    "measurement", [Measurement("0"), Measurement(0.0, tip=("1", "2", "3")), Measurement(0.0, tip=(None, 0.0, 0.0)),
                    Measurement(True, tip=np.zeros(3)), Measurement(0.0, force=(True, False, True))]
)  # fmt: skip
def test_text_and_truth_are_no_measurement(measurement: Measurement):
    followed = case(CASES[0], 0.1)
    with pytest.raises(UsageError, match="measurement: "):
        Follower(followed.trajectory, followed.machine).step(measurement)


@pytest.mark.thorough
def test_whatever_is_measured_and_asked_limits_hold():
    worst = np.zeros(3)
    for name, group, number, _, verdict in campaign(600, 11):
        assert verdict.fine, f"{name}, figures {group}, run {number}: {verdict}"
        worst = np.maximum(worst, verdict.limits)
    print(f"most of velocity, acceleration and jerk over their limits: {worst}")


def test_a_correction_goes_on_while_the_path_is_held():
    """What is held is the path: a bent tool is corrected there, and the path stands where it began."""
    machine = tp.Machine.load("paper-ab")
    followed = case(CASES[0], 0.1)
    follower = Follower(followed.trajectory, machine)
    for k in range(400):
        point = follower.step(Measurement(k * 1e-3, deflection=(5e-5, 0.0, 0.0)), feed=0.0)
        assert np.array_equal(point.q, followed.trajectory.at(0.0).q + point.correction[0])
    assert np.linalg.norm(point.correction[0]) == pytest.approx(5e-5, rel=1e-3)

"""A deflection that is measured itself does what the tip does that is as far from where it was commanded."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Follower, Measurement, Status
from toolpace.deflection.following.settings import CAUSES

DELAY = 6e-3
PROGRAM = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z11 F900\nX13 Y-3 A2 C3 F500\nM2\n"


@pytest.fixture(scope="module")
def planned():
    """A short trajectory and the machine to follow it on."""
    machine = tp.Machine.load("linuxcnc-xyzac-trt")
    toolpath = tp.read_text(PROGRAM, machine, name="short.ngc")
    on = machine.reserved(0.1)
    return tp.plan(tp.Path.fit(toolpath, machine=on), on), machine


def bent(t: float) -> np.ndarray:
    """(3,) deflection at a time [m]."""
    return 1e-4 * np.array([np.sin(9.0 * t), np.cos(7.0 * t), 0.5 - np.sin(4.0 * t) ** 2])


@pytest.mark.parametrize("cause", CAUSES)
def test_it_is_the_tip_less_where_that_was_commanded(planned, cause):
    trajectory, machine = planned
    by_tip, by_itself = (
        Follower(trajectory, machine, cause=cause, delay=DELAY, gain=0.1, rho=0.2, deadband=2e-5) for _ in range(2)
    )
    given = [trajectory.at(np.zeros(1)).q[0]]
    jumped = False
    for k in range(400):
        t = k * 1e-3
        off = bent(t)
        commanded = machine.forward(given[max(k - 6, 0)][None])[0][0]
        one = by_tip.step(Measurement(t, tip=commanded + off))
        other = by_itself.step(Measurement(t, deflection=off))
        assert one.q == pytest.approx(other.q, abs=1e-11)
        assert one.status == other.status
        jumped |= bool(one.status & Status.JUMPED)
        given.append(one.q)
    assert jumped == (cause == "displaced")
    assert np.abs(one.correction[0]).max() > 2e-5


def test_what_is_no_figure_is_told(planned):
    follower = Follower(*planned)
    assert follower.step(Measurement(0.0, deflection=(np.nan, 0.0, 0.0))).status == Status.NOT_A_NUMBER
    assert follower.step(Measurement(1e-3, deflection=(1.0, 0.0, 0.0))).status == Status.ABSURD


def test_a_force_counts_only_where_its_bending_is_known(planned):
    """Without a compliance it is no word that nothing bends: where the tip drops out the correction is held."""
    force = np.array([30.0, 0.0, 0.0])
    bent_by_tip = np.array([1e-4, 0.0, 0.0])
    for compliance, counts in ((np.zeros((3, 3)), False), (1e-6 * np.eye(3), True)):
        follower = Follower(*planned, gain=1.0, hold=1.0, compliance=compliance)
        for k in range(500):
            follower.step(Measurement(k * 1e-3, deflection=bent_by_tip, force=force))
        for k in range(500, 1000):
            point = follower.step(Measurement(k * 1e-3, deflection=np.full(3, np.nan), force=force))
        assert bool(point.status & Status.NOT_A_NUMBER) is not counts
        assert np.linalg.norm(point.correction[0]) == pytest.approx(3e-5 if counts else 1e-4, rel=0.02)


def test_an_axis_that_is_measured_seldom_is_not_taken_for_right_in_between(planned):
    """Rotary joints hold their correction while only the tip is measured, and let it fade after a while."""
    trajectory, machine = planned
    off = np.array([0.0, 2e-3, 0.0])

    def turned(every: int, steps: int, begun: int = 10**9) -> tuple[float, Status]:
        follower = Follower(trajectory, machine, gain=0.5, max_turn=0.01, hold=0.05, fade=0.02)
        q, said = trajectory.at(np.zeros(1)).q[0], Status(0)
        for k in range(steps):
            tip, axis = (each[0] for each in machine.forward(q[None]))
            axis = axis + off if k % every == 0 and k < begun else None
            point = follower.step(Measurement(k * 1e-3, tip=tip, axis=axis), feed=0.0)
            q, said = point.q, point.status
        return float(np.abs(point.correction[0][machine.rotary]).max()), said

    always, said = turned(1, 1500)
    assert always > 1e-3 and not said & Status.STALE
    seldom, said = turned(10, 1500)
    assert seldom == pytest.approx(always, rel=0.05) and not said & Status.FADING
    faded, said = turned(10, 3000, begun=1000)
    assert faded < 0.01 * always and said & Status.STALE and said & Status.FADING


@pytest.mark.parametrize(
    "measurement, words",
    [
        (Measurement(0.0, tip="abc"), "tip is 'abc'; give three figures"),
        (Measurement(0.0, tip=(1.0, (2.0,), 3.0)), "give three figures"),
        (Measurement(0.0, axis=(1j, 0.0, 0.0)), "axis is .*give three figures"),
        (Measurement(0.0, force=(1.0, 2.0)), r"force has shape \(2,\); give three figures"),
        (Measurement("now", tip=(0.0, 0.0, 0.0)), "t is 'now'; give a time in seconds"),
        (Measurement(10**400, tip=(0.0, 0.0, 0.0)), "give a time in seconds"),
        ((0.0, (0.0, 0.0, 0.0)), "tuple in place of a measurement"),
        (0.0, "float in place of a measurement"),
    ],
)
def test_what_is_no_measurement_is_one_line_and_no_step(planned, measurement, words: str):
    follower = Follower(*planned)
    before = follower.state.copy()
    with pytest.raises(UsageError, match=words):
        follower.step(measurement)
    assert np.array_equal(follower.state, before)


@pytest.mark.parametrize("feed", ["fast", [1.0], 1j, {}])
def test_what_is_no_feed_is_one_line(planned, feed):
    with pytest.raises(UsageError, match=r"feed is .*; give a share"):
        Follower(*planned).step(feed=feed)


@pytest.mark.parametrize(
    "figures, words",
    [
        ({"cause": None}, "unknown cause 'None'; known: bending, displaced"),
        ({"compliance": "soft"}, "compliance of str; give"),
        ({"compliance": [[1.0, 2.0], [3.0]]}, "compliance of list; give"),
        ({"compliance": 1j * np.eye(3)}, "compliance of ndarray; give"),
        ({"compliance": tp.Bending(1e-6 * np.eye(3))}, r"compliance of Bending; give .*Bending\(...\).compliance"),
        ({"believable": 0.0}, "believable is 0.0; give a length above 0"),
        ({"wait": 0.0}, "wait is 0.0; give a length above 0"),
        ({"gain": True}, "gain is True; give a share"),
        ({"period": "1e-3"}, "period is '1e-3'; give a time"),
    ],
)
def test_figures_that_make_no_sense_are_one_line(planned, figures, words: str):
    with pytest.raises(UsageError, match=words):
        Follower(*planned, **figures)


def test_figures_may_be_numbers_of_any_kind(planned):
    assert Follower(*planned, reserve=np.float32(0.1), fade=np.int64(1)).period == 1e-3
    soft = [[1e-6, 0, 0], [0, 2e-6, 0], [0, 0, 0]]
    by_list, by_array = (Follower(*planned, compliance=each).piece for each in (soft, np.array(soft)))
    assert np.array_equal(by_list, by_array) and (by_list == 2e-6).any()
    with pytest.raises(UsageError, match="NoneType in place of a trajectory"):
        Follower(None, planned[1])

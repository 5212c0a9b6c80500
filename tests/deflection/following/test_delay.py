"""What is late is told once: the drives by `delay`, the sensor by the time of a measurement or by `dead_time`."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from tests.support.tool_paths import toolpath_through
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Follower, Measurement, Status
from toolpace.deflection.following.settings import Figures

DRIVES, SENSOR = 6, 4
"""Set-points by which the machine is behind, and by which a measurement comes late."""
FEED, PERIOD = 0.05, 1e-3


@pytest.fixture(scope="module")
def line():
    """A line of 60 mm along X at 50 mm/s, and the machine."""
    machine = tp.Machine.load("xyzbc-head")
    toolpath = toolpath_through([[-0.03, 0.0, 0.0], [0.03, 0.0, 0.0]], 2 * [[0, 0, 1]], feed=FEED)
    on = machine.reserved(0.1)
    return tp.plan(tp.Path.fit(toolpath, machine=on), on, bound=False), machine


def corrected(line, stamped: bool, **figures) -> float:
    """Largest correction [m] of a stiff tool: there is nothing to correct. The X joint tells where it was measured."""
    trajectory, machine = line
    follower = Follower(trajectory, machine, gain=0.2, **figures)
    x, start = machine.joints.index("X"), trajectory.at(0.0).q
    origin = machine.forward(start[None])[0][0]
    given, most = [start] * (DRIVES + SENSOR + 1), 0.0
    for k in range(1000):
        # what comes now was measured SENSOR periods ago, when the machine was where the set-point of DRIVES before is
        tip = origin + (given[k][x] - start[x]) * np.array([1.0, 0.0, 0.0])
        point = follower.step(Measurement((k - SENSOR) * PERIOD if stamped else None, tip=tip))
        given.append(point.q)
        most = max(most, float(np.linalg.norm(point.correction[0])))
        assert not point.status & (Status.LATE | Status.ABSURD | Status.NOT_A_NUMBER)
    return most


def test_either_way_of_telling_when_it_was_measured_leaves_nothing_to_correct(line):
    assert corrected(line, stamped=True, delay=DRIVES * PERIOD) <= 1e-8
    assert corrected(line, stamped=False, delay=DRIVES * PERIOD, dead_time=SENSOR * PERIOD) <= 1e-8


def test_a_dead_time_that_is_told_twice_would_be_seen_as_bending(line):
    """By the feed times the dead time: 200 micrometres."""
    twice = corrected(line, stamped=True, delay=(DRIVES + SENSOR) * PERIOD)
    assert twice == pytest.approx(FEED * SENSOR * PERIOD, rel=0.05)


def test_so_a_time_beside_a_dead_time_is_refused(line):
    follower = Follower(*line, dead_time=SENSOR * PERIOD)
    with pytest.raises(UsageError, match=r"t is 0.002 s, and the follower has a dead_time of 0.004 s: .* late twice"):
        follower.step(Measurement(0.002, tip=np.zeros(3)))
    assert not follower.state.any()
    follower.step()
    assert follower.step(Measurement(None, deflection=np.zeros(3))).status == Status(0)


@pytest.mark.parametrize("age", [0, 4, 20])
def test_what_is_given_at_every_step_is_not_stale_however_old_it_is(line, age: int):
    """Nor does its correction fade, as it does where nothing more is given."""
    follower, said = Follower(*line, gain=0.5, hold=0.01, fade=0.02), Status(0)
    for k in range(300):
        point = follower.step(Measurement((k - age) * PERIOD, deflection=(0.0, 3e-5, 0.0)), feed=0.0)
        said |= point.status
    assert not said & (Status.STALE | Status.FADING)
    assert np.linalg.norm(point.correction[0]) == pytest.approx(3e-5, rel=1e-3)
    for _ in range(300):
        point = follower.step(feed=0.0)
    assert point.status & Status.STALE and point.status & Status.FADING
    assert np.linalg.norm(point.correction[0]) < 1e-8


def test_the_dead_time_is_in_the_law(line, tmp_path):
    one = Follower(*line, dead_time=SENSOR * PERIOD)
    one.save(tmp_path / "line.law")
    other = Follower.load(tmp_path / "line.law")
    for _ in range(20):
        measured = Measurement(None, deflection=(2e-5, 0.0, 0.0))
        assert np.array_equal(one.step(measured).q, other.step(measured).q)
    with pytest.raises(UsageError, match="late twice"):
        other.step(Measurement(0.01, deflection=np.zeros(3)))


@pytest.mark.parametrize("dead_time", [-1e-3, 0.3, np.nan, None, "4 ms", True])
def test_what_is_no_dead_time_is_told(dead_time):
    with pytest.raises(UsageError, match=r"dead_time is .*; give a time from 0 to 0.2 s"):
        Figures(dead_time=dead_time)


def test_both_together_are_no_more_than_is_remembered():
    with pytest.raises(UsageError, match=r"delay and dead_time together of 0.3 s .* period of 0.000598 s"):
        Figures(delay=0.2, dead_time=0.1, period=5e-4)

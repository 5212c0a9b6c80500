"""The search for a way back by splines: it ends where it shall, and a tool that is ahead need not wait for its time."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed import replans
from toolpace.deflection.rejoin.joint_splines import Problem, detour_of
from toolpace.deflection.rejoin.search import joints_alone
from toolpace.deflection.rejoin_motion import CommandedMotion


@pytest.mark.parametrize("ahead", [0.02, 0.3, 1.1])
@pytest.mark.parametrize("period", [0.1, 0.8])
def test_the_joints_alone_come_to_the_place_that_is_given(ahead: float, period: float):
    old = replans.planned("line", 600.0)
    motion, left = CommandedMotion.of(old, 0), 0.4 * old.duration
    start = motion.motion(np.array([left]))[:3, 0]
    start[0] += [2e-4, -3e-4, 1e-4, 1e-3, -2e-3]
    problem = Problem(motion, left, start, old.limits, replans.machine_of("line"))
    found = detour_of(joints_alone(problem, period, left + ahead, 0.0, 0.0))
    assert found.duration == period
    assert found.motion(np.array([period]))[0, 0] == pytest.approx(old.at(left + ahead).q, abs=1e-9)


def test_a_tool_found_ahead_goes_on_and_wins_the_time():
    """By 1 mm at 100 mm/s, 10 ms: to wait for them would take the joints four times as long."""
    old = replans.planned("line", 6000.0)
    time, ahead = 0.4 * old.duration, np.array([1e-3, 0.0, 0.0])
    case = replans.tried(replans.Case("line", 6000.0, "displaced", "direct", 1e-3, time), ahead / 1e-3)
    assert not case.faults, case.told()
    assert -0.01 <= case.lost < -0.009
    new = tp.replan(old, time, old.tip(time)[0] + ahead, planner="direct")
    detour = new.axis_path.runs[0].detour
    assert detour.duration < 0.05
    assert new.at(detour.duration).q == pytest.approx(old.at(time + detour.duration - case.lost).q, abs=1e-9)


@pytest.mark.parametrize("later", [0.05, 0.15])
def test_a_place_to_rejoin_is_come_to_at_speed(later: float):
    """By joint splines or beside the path, on a line at 100 mm/s; the positions there are those of the plan."""
    old = replans.planned("line", 6000.0)
    time = 0.3 * old.duration
    place = float(old.parameter(time + later))
    new = tp.replan(old, time, old.tip(time)[0] + [0.0, 1e-3, 0.0], planner="direct", rejoin=place)
    run = new.axis_path.runs[0]
    assert run.join == pytest.approx(place, abs=1e-9)
    assert new.at(run.detour.duration).q == pytest.approx(old.at(time + later).q, abs=1e-9)
    assert run.detour.duration < 0.35
    assert new.usage().worst <= 1.0001


@pytest.mark.parametrize(("kind", "feed"), [("arc", 6000.0), ("five 1", 1800.0), ("spline", 6000.0)])
def test_a_place_that_is_come_to_in_time_is_rejoined_without_time_lost(kind: str, feed: float):
    old, chain = replans.planned(kind, feed), replans.chain_of(kind)
    time, later = 0.3 * old.duration, 0.15
    tip = chain.forward(old.at([time]).q, chain.own_length)[0][0] + np.array([0.0, 2e-4, 0.0])
    place = float(old.parameter(time + later))
    new = tp.replan(old, time, tip, replans.machine_of(kind), rejoin=place)
    assert new.duration == pytest.approx(old.duration - time, abs=1e-9)
    np.testing.assert_allclose(new.at([later]).q, old.at([time + later]).q, atol=1e-9)

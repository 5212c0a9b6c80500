"""The bound of any motion for whole plans: where it is cheap, and what it sums."""

from __future__ import annotations

from dataclasses import replace

import pytest

from testbed.cases import random_case
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound import continuous
from toolpace.planning.bound.continuous import continuous_bound, is_cheap, with_continuous_bound
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan


def two_runs():
    """There and back along a straight line, with a stop between and a wait before."""
    way = AxisPath.from_waypoints([[0.0, 0.0], [0.3, 0.1], [0.0, 0.0]], stop=True)
    return replace(way, first_dwell=0.25), Limits([0.5, 0.4], [2.0, 3.0], [30.0, 20.0])


def test_the_bound_of_a_plan_is_that_of_its_runs_with_the_dwells():
    path, limits = two_runs()
    trajectory = plan(path, limits)
    proved = with_continuous_bound(trajectory)
    runs = [continuous_bound(run, limits, law) for run, law in zip(path.runs, trajectory.laws)]
    assert len(runs) == 2 and min(runs) > 0.0
    assert proved.continuous_bound == pytest.approx(sum(runs) + 0.25, rel=1e-12)
    assert 0.999 * proved.duration < proved.continuous_bound <= proved.duration
    assert proved.lower_bound == trajectory.lower_bound


def test_a_run_in_motion_has_none_and_so_has_the_whole():
    path, limits = two_runs()
    assert with_continuous_bound(plan(path, limits, start=EndState(0.01))).continuous_bound == 0.0


def test_what_is_long_or_of_another_planner_is_not_cheap(monkeypatch):
    case = random_case(0)
    trajectory = plan(case.axis_path, case.limits)
    assert is_cheap(trajectory)
    assert not is_cheap(plan(case.axis_path, case.limits, planner="second-order"))
    monkeypatch.setattr(continuous, "CHEAP", continuous.cells(trajectory) - 1)
    assert not is_cheap(trajectory)

"""Paths of quintic intervals, Eq. (7a, 7b): as tip and rotary joints, and as any joints."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.common.errors import PathError
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_quintic import quintic_axis_path, quintic_path, quintic_through
from toolpace.path.path import Path
from toolpace.planning.planner import plan

MACHINE = Machine.load("paper-ab")


def test_study_path_is_that_of_its_intervals() -> None:
    """31 quintic intervals keep to the arc within a thousandth of a micrometre, points and derivatives exactly."""
    exact = Path.paper_arc()
    path = quintic_through(exact, MACHINE)
    run, given = path.runs[0], exact.runs[0]
    assert len(run.breaks) == 32
    s = np.linspace(run.s0, run.s1, 2001)
    assert np.abs(run.evaluate(s).tip[0] - given.evaluate(s).tip[0]).max() < 1e-9
    np.testing.assert_allclose(run.evaluate(run.breaks).tip[:3], given.evaluate(run.breaks).tip[:3], atol=1e-9)
    joints, wanted = (AxisPath.follow(p, MACHINE).runs[0].evaluate(s)[0] for p in (path, exact))
    np.testing.assert_allclose(joints, wanted, atol=2e-8)


def test_study_path_error_falls_with_the_sixth_power() -> None:
    exact = Path.paper_arc()
    s = np.linspace(0.0, exact.runs[0].s1, 3001)
    wanted = exact.runs[0].evaluate(s).tip[0]
    errors = [np.abs(quintic_through(exact, MACHINE, n).runs[0].evaluate(s).tip[0] - wanted).max() for n in (4, 8, 16)]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([6, 6], abs=0.3)


def test_third_derivative_jumps_and_is_judged_on_both_sides() -> None:
    run = AxisPath.follow(quintic_through(Path.paper_arc(), MACHINE, 8), MACHINE).runs[0]
    assert len(run.breaks) == 7
    right, left = run.evaluate(run.breaks), run.evaluate(np.nextafter(run.breaks, 0.0))
    scale = np.abs(right).max(axis=(1, 2))
    assert (np.abs(right[:3] - left[:3]).max(axis=(1, 2)) < 1e-9 * scale[:3]).all()
    assert np.abs(right[3] - left[3]).max() > 1e-3 * scale[3]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_joint_derivatives_are_those_of_finite_differences(order: int) -> None:
    run = AxisPath.follow(quintic_through(Path.paper_arc(), MACHINE), MACHINE).runs[0]
    s = (np.linspace(run.s0, run.s1, 32)[:-1] + 0.4 * run.s1 / 31)[::3]
    step = 1e-5
    low, high = (run.evaluate(s + d)[order - 1] for d in (-step, step))
    exact = run.evaluate(s)[order]
    np.testing.assert_allclose((high - low) / (2 * step), exact, atol=2e-5 * np.abs(exact).max())


@pytest.mark.parametrize("planner", ["optimal", "genetic"])
def test_any_joints_are_planned(planner: str) -> None:
    s = np.linspace(0.0, 2.0, 5)
    jets = np.stack([[np.sin(s + k * np.pi / 2), 2.0**k * np.cos(2 * s + k * np.pi / 2)] for k in range(3)])
    path = quintic_axis_path(s, jets.transpose(0, 2, 1), ["one", "two"], speed_cap=0.8)
    np.testing.assert_allclose(path.runs[0].evaluate(s)[:3], jets.transpose(0, 2, 1), atol=1e-12)
    trajectory = plan(path, Limits([1, 1], [3, 3], [30, 30], joints=("one", "two")), planner=planner)
    assert trajectory.usage().worst <= 1.0001
    np.testing.assert_allclose(trajectory.at(trajectory.duration).q, jets[0, :, -1], atol=1e-9)


def test_paper_path_of_points() -> None:
    points = np.array([[0, 0, 0], [0.01, 0, 0], [0.02, 0.005, 0]])
    tip = np.stack([points, np.gradient(points, axis=0), np.zeros((3, 3))])
    path = quintic_path([0, 1, 2], tip, np.zeros((3, 3, 2)), feed=0.02)
    assert list(path.runs[0].block) == [1, 2]
    trajectory = plan(path, MACHINE)
    assert trajectory.usage().worst <= 1.0001
    np.testing.assert_allclose(trajectory.tip([trajectory.duration])[0][0], points[-1], atol=1e-12)


def test_points_that_do_not_fit_together() -> None:
    with pytest.raises(PathError, match="must increase"):
        quintic_axis_path([0, 0], np.zeros((3, 2, 1)))
    with pytest.raises(PathError, match="2 points, but"):
        quintic_axis_path([0, 1], np.zeros((3, 3, 1)))
    with pytest.raises(PathError, match="point 2 is not finite"):
        quintic_axis_path([0, 1], [[[0.0], [np.nan]]] * 3)

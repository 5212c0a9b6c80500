"""The bound of the continuous problem: closed forms, random paths, and that it holds whatever the plan."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import BSpline

import toolpace as tp
from testbed.cases import all_cases
from tests.support.random_paths import harmonics, random_limits
from tests.support.straight_line import line, s_curve
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound import continuous
from toolpace.planning.bound.continuous import continuous_bound, gauss, spline, widest_at_breaks
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planned_run import EndState


@pytest.mark.parametrize(
    "limits",
    [(1e3, 1e3, 2.0), (1e3, 1.0, 10.0), (0.4, 1.0, 10.0), (0.3, 1e3, 10.0), (0.2, 0.5, 100.0)],
    ids=["jerk", "jerk, acceleration", "all", "jerk, velocity", "nearly second order"],
)
def test_straight_line_in_closed_form(limits):
    velocity, acceleration, jerk = limits
    best = s_curve(1.0, *limits)
    run = line().runs[0]
    bounds = Limits([velocity], [acceleration], [jerk])
    law, _ = fastest_law(run, bounds)
    assert law.duration == pytest.approx(best, rel=2e-4)
    found = continuous_bound(run, bounds, law)
    assert found <= best * (1.0 + 1e-9)
    assert found == pytest.approx(best, rel=1e-3)


@pytest.mark.sweep
def test_holds_whatever_the_plan():
    """Any law gives multipliers: a bound by a slow or crude one is lower, never above the optimum."""
    run = line().runs[0]
    limits = Limits([1.0], [1.0], [10.0])
    best = s_curve(1.0, 1.0, 1.0, 10.0)
    for cells in (8, 12, 20, 60):
        law, _ = fastest_law(run, limits, cells=cells)
        for by in (1.0, 1.3, 3.0):
            assert continuous_bound(run, limits, law.slowed(by)) <= best * (1.0 + 1e-9)


def check(seed, worst):
    run = AxisPath.from_callable(harmonics(seed, 4, 4)).runs[0]
    limits = random_limits(seed, 4, tight=bool(seed % 2))
    law, _ = fastest_law(run, limits)
    found = continuous_bound(run, limits, law)
    assert 0.0 <= found <= law.duration
    assert law.duration / found - 1.0 < worst
    # coarser plans hold limits between their nodes too, so none of them may be faster
    for cells in (40, 150):
        other, _ = fastest_law(run, limits, cells=cells)
        assert found <= other.duration * (1.0 + 1e-4)
    return law.duration / found - 1.0


@pytest.mark.parametrize("seed", range(6))
def test_random_paths(seed):
    check(seed, 0.1)


@pytest.mark.parametrize(
    "count", [pytest.param(12, marks=pytest.mark.sweep), pytest.param(100, marks=pytest.mark.thorough)]
)
def test_many_random_paths(count):
    gaps = [check(seed, 0.2) for seed in range(100, 100 + count)]
    assert np.median(gaps) < 1e-3


@pytest.mark.sweep
def test_plans_of_the_published_paths_are_near_the_best_motion_there_is():
    gaps = {}
    for case in all_cases(4):
        law, _ = fastest_law(case.run, case.limits)
        gaps[case.name] = law.duration / continuous_bound(case.run, case.limits, law) - 1.0
    flank = gaps.pop("flank")
    assert 0.0 < flank < 0.03 and max(gaps.values()) < 1e-3 and min(gaps.values()) > 0.0


def test_a_proved_trajectory_has_it():
    case = all_cases(1)[-1]
    trajectory = tp.plan(case.axis_path, case.limits)
    assert trajectory.continuous_bound == 0.0
    proved = tp.prove(trajectory)
    assert 0.999 * proved.duration < proved.continuous_bound <= proved.duration


def test_none_where_the_integral_is_no_number(monkeypatch):
    """Whatever went wrong with the multipliers: no bound is said, least of all one that could be too high."""
    run, limits = line().runs[0], Limits([1.0], [1.0], [10.0])
    law, _ = fastest_law(run, limits)
    for bad in (np.nan, np.inf, -np.inf):
        monkeypatch.setattr(continuous, "dual_integral", lambda *_, bad=bad: bad)
        assert continuous_bound(run, limits, law) == 0.0


def test_none_for_ends_in_motion():
    run = line().runs[0]
    limits = Limits([1.0], [1.0], [10.0])
    law, _ = fastest_law(run, limits, start=EndState(0.3))
    assert continuous_bound(run, limits, law) == 0.0


@pytest.mark.parametrize("points", [2, 6, 12])
def test_gauss_integrates_polynomials_up_to_each_place(points):
    place, rule, up_to = gauss(points)
    for power in range(points):
        assert rule @ place**power == pytest.approx(1.0 / (power + 1), rel=1e-12)
        assert up_to @ place**power == pytest.approx(place ** (power + 1) / (power + 1), rel=1e-10)


@pytest.mark.parametrize("order", range(3))
def test_the_spline_in_its_cells_is_that_over_even_knots(order):
    step, coefficients, place = 2e-3, np.random.default_rng(1).normal(size=(9, 2)), gauss(6)[0]
    edges = step * np.array([0.0, *(np.arange(10) + 0.5), 10.0])
    t = (edges[:-1, None] + np.diff(edges)[:, None] * place).ravel()
    # beyond its ends the coefficients go on in a line
    extended = coefficients[[0, 0, *range(9), -1, -1]]
    extended[:2] += np.array([[2.0], [1.0]]) * (coefficients[0] - coefficients[1])
    extended[-2:] += np.array([[1.0], [2.0]]) * (coefficients[-1] - coefficients[-2])
    expected = BSpline(step * (np.arange(16) - 2.5), extended, 2).derivative(order)(t)
    found = spline(coefficients, step, place)(order)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 / step**order)


@pytest.mark.parametrize("cell", [0, 1, 4, 8, 9])
def test_beside_a_break_no_cap_is_below_that_of_either_side(cell):
    """Rounding may put a break into the cell before or behind its own: nothing near it may be taken for too slow."""
    edges = np.linspace(0.0, 1.0, 11)
    law = SimpleNamespace(nodes=np.array([0.0, 2.0]), times=np.array([0.0, 1.0]))
    run = SimpleNamespace(breaks=np.array([2.0 * (edges[cell] + edges[cell + 1]) / 2.0]))
    cap = np.random.default_rng(cell).uniform(1.0, 2.0, (10, 3))
    found = widest_at_breaks(run, law, edges, cap.copy())
    near = slice(max(cell - 1, 0), cell + 2)
    assert (found[near] == cap[near].max()).all()
    others = np.ones(10, dtype=bool)
    others[near] = False
    assert (found[others] == cap[others]).all()

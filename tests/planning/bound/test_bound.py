"""The lower bound: weak duality for any multipliers, against a conic solver and IPOPT, and never above the best."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.conic import conic_optimum
from tests.support.mesh_problems import law_of, mesh_time, moving, small, solved, some_case
from toolpace.kernels.optimal import newton
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound.problem import Knots, start_within
from toolpace.planning.bound.relaxation import bound_run, coefficients, lower_bound
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.solve import Stalled


def check_below_the_best(seed):
    problem, c = solved(seed)
    found = lower_bound(problem, law_of(problem, c))
    assert 0.0 < found.mesh_bound <= found.mesh_duration
    assert found.gap < 0.25 and found.seconds <= found.duration
    return found.gap


@pytest.mark.parametrize("seed", range(60))
def test_never_above_the_best_found(seed):
    check_below_the_best(seed)


@pytest.mark.sweep
@pytest.mark.parametrize("block", range(20))
def test_never_above_the_best_found_on_a_thousand(block):
    gaps = []
    for seed in range(1000 + 50 * block, 1050 + 50 * block):
        with suppress(Stalled):  # a coarse mesh may leave the planner stuck; there is no plan to compare with then
            gaps.append(check_below_the_best(seed))
    assert len(gaps) >= 48 and np.median(gaps) < 1e-4


@pytest.mark.parametrize("seed", range(8))
def test_never_above_ipopts_optimum_on_the_same_mesh(seed):
    pytest.importorskip("casadi")
    from testbed import ipopt

    problem, c = solved(seed)
    best, note = ipopt.minimise(problem, c * np.where(problem.end[0] == newton.REST, 0.5, 1.0))
    assert note == "Solve_Succeeded"
    knots = Knots(problem)
    assert lower_bound(problem, law_of(problem, c)).mesh_bound <= mesh_time(knots, best) * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 9])
def test_relaxation_is_that_of_a_conic_solver(seed):
    problem, c = solved(seed, cells=40, joints=3)
    best = conic_optimum(Knots(problem), c)
    found = lower_bound(problem, law_of(problem, c)).mesh_bound
    assert best * (1.0 - 3e-5) <= found <= best * (1.0 + 1e-6)


def multipliers(knots, seed, share):
    """Random ones, most of them zero; those of jerk together `share` of the time's weight at most knots."""
    rng = np.random.default_rng(seed)
    points, count = knots.rows.shape[:2]
    weight = np.repeat(knots.weight, np.diff(knots.first))[:, None, None]
    dual = weight * rng.exponential(size=(points, count, 2)) * (rng.uniform(size=(points, count, 2)) < 0.3)
    dual *= share / (0.3 * 2 * count)
    return dual


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.integers(0, 11), st.integers(0, 10**6), st.sampled_from([0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 30.0, 1e6]))
def test_any_multipliers_give_a_bound(seed, number, share):
    problem, c = some_case(seed)
    knots = Knots(problem)
    value = knots.value(multipliers(knots, number, share))
    assert not np.isnan(value) and value <= mesh_time(knots, c)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.integers(0, 11), st.integers(0, 10**6), st.sampled_from([1e-6, 1e-2, 1.0, 30.0]), st.floats(1e-3, 0.99))
def test_any_multipliers_bound_the_times_with_z_in_a_range(seed, number, share, width):
    """Where z is held above zero, jerk multipliers may outweigh the time: the bound is that of this range only."""
    problem, c = some_case(seed)
    knots = Knots(problem)
    z = knots.state(c)[:, 0]
    held = np.random.default_rng(number).uniform(size=len(z)) < 0.3
    low = np.where(held, (1.0 - width) * z, 0.0)
    high = np.where(held, np.minimum((1.0 + width) * z, knots.cap), knots.cap)
    dual = multipliers(knots, number, share)
    value = knots.value(dual, low, high)
    assert value <= mesh_time(knots, c)


def lagrangian(knots, dual, c):
    u = np.repeat(knots.state(c), np.diff(knots.first), axis=0)
    value = np.einsum("pri,pi->pr", knots.rows, u)
    half = knots.rows.shape[1] // 2
    limit = np.ones_like(value)
    limit[:, half:] = u[:, :1] ** -0.5
    broken = np.stack([value - limit, -value - limit], axis=-1)
    return mesh_time(knots, c) + float((dual * broken).sum())


def of_values(knots, z):
    """Coefficients of the spline with z (n,) at the knots and the ends of the problem."""
    n = len(z)
    matrix, right = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
    for k in range(n):
        matrix[k + 1, k : k + 3] = knots.basis[k, 0]
    right[1:-1] = z
    for k, (one, two) in enumerate(((0, 1), (n + 1, n))):
        if knots.end[k] == newton.REST:
            matrix[one, two], matrix[one, one] = 1.0, -knots.ratio[k]
        else:
            matrix[two] = 0.0
            matrix[one, one] = matrix[two, two] = 1.0
            right[one], right[two] = knots.fixed[0 if k == 0 else 3], knots.fixed[1 if k == 0 else 2]
    return np.linalg.solve(matrix, right)


@pytest.mark.parametrize("number", range(12))
def test_dual_value_is_the_least_lagrangian(number):
    """The map from z at the knots to coefficients is one to one, so the Lagrangian's minimum splits by knots."""
    knots = Knots(some_case(number)[0])
    dual = multipliers(knots, number, 0.4)
    value, kappa, theta = knots.dual(dual)
    half = knots.rows.shape[1] // 2
    by_knot = np.add.reduceat(dual[:, half:].sum(axis=(1, 2)), knots.first[:-1])
    dual[:, half:] *= np.repeat(np.minimum(1.0, knots.weight / np.maximum(by_knot, 1e-300)), np.diff(knots.first))[
        :, None, None
    ]
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(theta > 0.0, (np.maximum(kappa, 0.0) / (2.0 * theta)) ** (2.0 / 3.0), np.inf)
    z = np.clip(z, 1e-6 * knots.cap, knots.cap)
    for k, place in ((0, 0), (1, -1)):
        if knots.end[k] == newton.MOVING:
            z[place] = knots.fixed[3 * k]
    least = lagrangian(knots, dual, of_values(knots, z))
    scale = abs(lagrangian(knots, np.abs(dual), of_values(knots, z))) + float(dual.sum())
    assert value == pytest.approx(least, abs=1e-2 * scale) and value <= least + 1e-9 * scale
    rng = np.random.default_rng(number)
    for _ in range(50):
        other = np.where(rng.uniform(size=len(z)) < 0.5, z, knots.cap * rng.uniform(1e-9, 1.0, len(z)))
        if knots.end[0] == newton.MOVING:
            other[0] = z[0]
        if knots.end[1] == newton.MOVING:
            other[-1] = z[-1]
        assert value <= lagrangian(knots, dual, of_values(knots, other)) + 1e-9 * scale


@pytest.mark.parametrize("seed", range(12))
def test_ends_in_motion(seed):
    problem, c = moving(seed)
    found = lower_bound(problem, law_of(problem, c))
    assert 0.0 < found.mesh_bound <= found.mesh_duration and found.gap < 0.1


@pytest.mark.parametrize("cells", [8, 9, 10, 13])
@pytest.mark.parametrize("joints", [1, 3])
def test_tiny_problems(cells, joints):
    problem, c = solved(7, cells=cells, joints=joints, breaks=False)
    found = lower_bound(problem, law_of(problem, c))
    assert 0.0 < found.mesh_bound <= found.mesh_duration


def test_straight_line_has_no_gap():
    run = AxisPath.from_callable(lambda s, order: np.stack([s if order == 0 else (order == 1) + 0.0 * s], 1)).runs[0]
    limits = Limits([1.0], [3.0], [20.0])
    law, _ = fastest_law(run, limits, cells=400, guard=False)
    found = bound_run(run, limits, law)
    assert found.gap < 2e-5 and len(found.places) == 0


def test_of_a_guarded_plan_is_by_the_limits_as_they_are():
    """Tightening slows the plan, not the bound."""
    run, limits, _, _ = small(5, joints=4, breaks=False)
    free, _ = fastest_law(run, limits, cells=80, guard=False)
    held, _ = fastest_law(run, limits, cells=80, guard=True)
    a, b = bound_run(run, limits, free), bound_run(run, limits, held)
    assert np.array_equal(free.nodes, held.nodes)
    assert b.mesh_bound == pytest.approx(a.mesh_bound, rel=3e-5)
    assert b.seconds <= held.duration and b.gap >= a.gap - 3e-5


def test_coefficients_of_a_law():
    problem, c = solved(11, joints=3)
    assert coefficients(law_of(problem, c)) == pytest.approx(c, rel=1e-9, abs=1e-12 * c.max())


@pytest.mark.parametrize("k", [1e-4, 1e4])
def test_slower_limits_scale_the_bound(k):
    run, limits, _, _ = small(12, joints=4)
    gaps = []
    for given_ in (limits, limits.scaled(1.0 / k, 1.0 / k**2, 1.0 / k**3)):
        law, _ = fastest_law(run, given_, cells=120, guard=False)
        gaps.append(bound_run(run, given_, law).gap)
    assert gaps[1] == pytest.approx(gaps[0], abs=3e-5)


def test_a_place_where_the_relaxation_stands_still_is_named():
    """A bend too sharp for its speed: the relaxation passes it faster than jerk allows, and waits on it."""

    def bent(s, order):
        x = (s - 0.5) / 0.01
        soft = [np.tanh(x), 1.0 / np.cosh(x) ** 2]
        soft += [-2.0 * soft[0] * soft[1], 4.0 * soft[0] ** 2 * soft[1] - 2.0 * soft[1] ** 2]
        return np.stack([s if order == 0 else (order == 1) + 0.0 * s, 0.02 * soft[order] / 0.01**order], axis=1)

    run = AxisPath.from_callable(bent).runs[0]
    limits = Limits([1.0, 1.0], [4.0, 4.0], [20.0, 20.0])
    law, _ = fastest_law(run, limits, cells=300, guard=False)
    found = bound_run(run, limits, law)
    assert found.gap > 1e-3 and len(found.places) > 0 and np.all(np.abs(found.places[:, :2] - 0.5) < 0.1)
    assert (found.places[:, 2] > 0.0).all() and (found.places[:, 1] >= found.places[:, 0]).all()


def test_starts_well_inside():
    problem, c = solved(3)
    knots = Knots(problem)
    start, relief = start_within(knots, c)
    assert (knots.state(start)[:, 0] > 0.0).all() and (relief == 0.0).all()

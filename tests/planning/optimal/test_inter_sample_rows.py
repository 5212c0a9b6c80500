"""Limits between the nodes: rows inside cells, their optimum against IPOPT's, and what the look knows of a path."""

import numpy as np
import pytest

from testbed import ipopt
from testbed.jets import harmonics, path_of
from testbed.mesh_problem import mesh_problem
from tests.support.usage import dense_usage
from toolpace import Limits, Optimal, plan
from toolpace.kernels.motion import between_nodes, cubic_spline
from toolpace.kernels.optimal.limit_rows import EIGHTHS, LOWERED, MOST_LOWERED, QUARTERS, SAME_PLACE
from toolpace.kernels.optimal.multipliers import TILE
from toolpace.kernels.optimal.solver_rows import wanted
from toolpace.motion.laws import SplineLaw
from toolpace.planning.limit_tolerances import ALLOWED, PROMISED
from toolpace.planning.optimal.inter_sample_limits import IDLE, WARM_SPREAD
from toolpace.planning.optimal.meshed_run import RowsBetween
from toolpace.planning.optimal.problem import with_rows_between
from toolpace.planning.optimal.solve import slower, solve, start_from
from toolpace.planning.peaks import LimitCheck, Peaks

LIMITS = Limits([1.0] * 5, [4.0] * 5, [40.0] * 5)
LOST = 2e-4
"""What the guard may cost beside an optimum with rows at twenty points of every cell."""


def ten_harmonics(seed):
    """A path of five joints, each a sum of ten harmonics."""
    return path_of(harmonics(np.random.default_rng([6, seed]), joints=5, modes=10))


def everywhere(path, n, rows=20):
    """The problem on the planner's mesh of n cells with so many rows in each, and where the planner starts."""
    problem, s, z = mesh_problem(path, LIMITS, n)
    share = np.arange(1, rows) / rows
    places = (problem.nodes[:-1, None] + np.diff(problem.nodes)[:, None] * share).ravel()
    return with_rows_between(problem, path.runs[0], LIMITS, places), start_from(problem, s, z, 0.4)


def duration(problem, c):
    return SplineLaw(problem.nodes, c, problem.rest).duration


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("mesh", [250, 1000])
def test_the_guard_costs_next_to_nothing(seed, mesh):
    path = ten_harmonics(seed)
    problem, start = everywhere(path, mesh)
    best = duration(problem, solve(problem, start, 1.0))
    held_between_nodes = plan(path, LIMITS, planner=Optimal(mesh=mesh, bound=False))
    assert held_between_nodes.mesh_points == mesh + 1, "on the same spline"
    assert held_between_nodes.duration <= (1.0 + LOST) * best
    assert dense_usage(held_between_nodes) <= PROMISED


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4, 40))
def test_the_guard_costs_next_to_nothing_on_more_paths(seed):
    test_the_guard_costs_next_to_nothing(seed, 1000)


def test_rows_that_are_idle_about_a_place_may_be_left_out():
    """Of a start that is slower than the optimum by three percent: the same motion, with a fraction of the rows."""
    problem, start = everywhere(ten_harmonics(2), 1000, rows=3)
    best = solve(problem, start, 1.0)
    begin = slower(problem, best, 0.03)
    idle = IDLE * 0.97**1.5
    again = solve(problem, begin, WARM_SPREAD, idle=idle)
    assert duration(problem, again) == pytest.approx(duration(problem, best), rel=2e-6)
    points = problem.as_points()
    kept = wanted(points, begin, idle)
    assert wanted(points, begin, 0.0).all() and kept.mean() < 0.5
    # all that any point of 64 uses is kept, whichever point it is
    z, z1, z2 = (states_of(problem, begin, order) for order in range(3))
    value = np.abs(np.einsum("pid,dp->pi", points.rows, np.stack([z, z1, z2])))
    value[:, value.shape[1] // 2 :] *= np.sqrt(z)[:, None]
    most = np.maximum.reduceat(value, np.arange(0, len(value), TILE))
    np.testing.assert_array_equal(kept, most >= idle)


def test_the_optimum_with_rows_between_nodes_is_that_of_ipopt():
    problem, start = everywhere(ten_harmonics(0), 60, rows=3)
    found = solve(problem, start, 1.0)
    reference, note = ipopt.minimise(problem, start)
    assert note == ipopt.SUCCEEDED
    time, best = ((problem.weight / np.sqrt(of_z(problem, c))).sum() for c in (found, reference))
    assert time == pytest.approx(best, rel=1e-6)


def of_z(problem, c):
    return states_of(problem, c, 0)


def states_of(problem, c, order):
    """(points,) a derivative of z by the rows."""
    return np.einsum("pj,pj->p", problem.basis[:, order], c[problem.first[:, None] + np.arange(4)])


def test_a_place_between_nodes_sees_the_spline():
    random = np.random.default_rng(3)
    nodes = np.cumsum(random.uniform(0.5, 2.0, 12))
    law = SplineLaw(nodes, random.uniform(1.0, 2.0, 14), (0.0, 0.0))
    cell = random.integers(0, 11, 50)
    x = random.uniform(0.0, 1.0, 50) * np.diff(nodes)[cell]
    a = law.cells[cell].T
    z = a[0] + x * (a[1] + x * (a[2] + x * a[3]))
    z1, z2 = a[1] + x * (2.0 * a[2] + 3.0 * x * a[3]), 2.0 * a[2] + 6.0 * x * a[3]
    basis = cubic_spline.basis_between(nodes, cell, nodes[cell] + x)
    told = np.einsum("pdj,pj->pd", basis, law.c[cell[:, None] + np.arange(4)])
    np.testing.assert_allclose(told, np.stack([z, z1, z2], axis=1), rtol=1e-9, atol=1e-9)


def test_a_row_is_put_where_a_limit_is_passed_and_lowered_where_it_is_passed_again():
    nodes = np.arange(6.0)
    used, place = np.zeros((5, 3)), np.full((5, 3), 0.5)
    used[2] = [0.5, 0.9, ALLOWED + 1e-4]
    place[2, 2] = 0.4
    wrong, fresh = used.max(axis=1) > ALLOWED, np.zeros(5, dtype=bool)
    once = RowsBetween().held(nodes, Peaks(used, place), wrong, fresh, 1.0)
    assert once.place == pytest.approx([2.4])
    assert once.lowered[0, :2] == pytest.approx(1.0) and 1.0 < once.lowered[0, 2] <= 1.0 + MOST_LOWERED
    place[2, 2] += 0.5 * SAME_PLACE
    twice = once.held(nodes, Peaks(used, place), wrong, fresh, 1.0)
    assert len(twice.place) == 1 and twice.lowered[0, 2] > once.lowered[0, 2]
    place[2, 2] += 2.0 * SAME_PLACE
    assert len(twice.held(nodes, Peaks(used, place), wrong, fresh, 1.0).place) == 2


@pytest.mark.parametrize("used, shares", [(1.005, QUARTERS), (1.5, EIGHTHS)])
def test_neighbours_of_a_place_that_passes_by_far_get_rows_too(used, shares):
    nodes = np.arange(21.0)
    peaks = Peaks(np.zeros((20, 3)), np.full((20, 3), 0.5))
    peaks.used[10, 2] = used
    rows = RowsBetween().held(nodes, peaks, peaks.used.max(axis=1) > 1.0, np.zeros(20, dtype=bool), 1.0)
    beside = [7.5, 8.5, *9.0 + QUARTERS], [*11.0 + QUARTERS, 12.5, 13.5]
    assert rows.place == pytest.approx(np.concatenate([beside[0], 10.0 + shares, beside[1]]))
    assert rows.lowered[1] == pytest.approx(1.0) and rows.lowered[2] == pytest.approx(LOWERED)


def test_derivatives_at_the_nodes_tell_a_smooth_path_to_the_sixth_order():
    path = ten_harmonics(1).runs[0]
    inside, errors = np.linspace(0.0, 1.0, 11), []
    for count in (40, 80):
        nodes = np.linspace(0.2, 0.8, count + 1)
        q = path.evaluate(nodes)
        out = np.empty((count, 3, 5, 11))
        ends = np.ascontiguousarray(q[:, :-1]), np.ascontiguousarray(q[:, 1:])
        between_nodes.path_between(*ends, np.diff(nodes), inside, out)
        s = (nodes[:-1, None] + np.diff(nodes)[:, None] * inside).ravel()
        told = out[:, 0].transpose(0, 2, 1).reshape(-1, 5)
        errors.append(np.abs(told - path.evaluate(s)[1]).max())
    assert errors[1] < errors[0] / 2.0**5.5


@pytest.mark.parametrize("size", [1e-9, 1e-7, 1e-5])
def test_what_the_nodes_do_not_tell_is_asked_for(size):
    """A shift of the path inside a single cell, which its nodes and its middle hardly show."""
    nodes = np.linspace(0.0, 1.0, 101)
    place, width = 0.50712, 4e-4

    def jets(s):
        y = np.tanh((s - place) / width)
        g = 1.0 - y * y
        bump = np.stack([y, g / width, -2.0 * y * g / width**2, (-2.0 * g * g + 4.0 * y * y * g) / width**3])
        out = np.zeros((4, len(s), 1))
        out[0, :, 0], out[1, :, 0] = s, 1.0
        return out + size * bump[:, :, None]

    asked = []
    path = path_of(lambda s: (asked.append(s), jets(s))[1])
    limits = Limits([1.0], [4.0], [4.0])
    law = SplineLaw(nodes[1:-1], np.full(101, 0.5), (nodes[1], nodes[1]))
    look = LimitCheck(path.runs[0], limits, law.nodes)
    peaks = look.peaks(law)
    cell = int(np.searchsorted(law.nodes, place)) - 1
    closely = np.concatenate(asked)
    assert np.count_nonzero((closely > law.nodes[cell]) & (closely < law.nodes[cell + 1])) > 5
    s = np.linspace(law.nodes[cell], law.nodes[cell + 1], 4001)[1:-1]
    true = np.abs(jets(s)[3, :, 0]).max() * 0.5**1.5 / 4.0
    assert peaks.used[cell, 2] >= 0.5 * true

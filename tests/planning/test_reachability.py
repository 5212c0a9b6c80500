"""The passes of the second-order planner against linear programs by HiGHS."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.kernels.planners import reachability
from toolpace.path.axis_path import AxisPath
from toolpace.planning.second_order import BOTH_ENDS, FIVE, Cells, second_order_law


def rows_of(cells):
    """All rows A z <= b of a problem, dense, written down independently of the kernel's passes."""
    n = len(cells.at)
    a, b = [], []
    for k in range(n):
        h = cells.nodes[k + 1] - cells.nodes[k]
        for f, point in zip(cells.place, cells.at[k]):
            for j in range(cells.q1.shape[1]):
                row = np.zeros(n + 1)
                row[k] += cells.q2[point, j] * (1 - f) - cells.q1[point, j] / (2 * h)
                row[k + 1] += cells.q2[point, j] * f + cells.q1[point, j] / (2 * h)
                a += [row, -row]
                b += [1.0, 1.0]
            row = np.zeros(n + 1)
            row[k], row[k + 1] = 1 - f, f
            if not ((f == 0 and k == 0) or (f == 1 and k == n - 1)):
                a.append(row)
                b.append(cells.cap[point])
    return np.array(a), np.array(b)


def linear_program(cells, ends, cost, given_start):
    from scipy.optimize import linprog

    a, b = rows_of(cells)
    finite = np.isfinite(b)
    bounds = [(0.0, None)] * len(cells.nodes)
    bounds[-1] = (ends[1], ends[1])
    bounds[0] = (ends[0], ends[0]) if given_start else (0.0, ends[0])
    found = linprog(-cost, A_ub=a[finite], b_ub=b[finite], bounds=bounds, method="highs-ds")
    return found.x if found.status == 0 else None


def passes(cells, ends):
    return reachability.backward(cells.arrays(cells.top(*ends)), ends[1])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("place", [BOTH_ENDS, FIVE], ids=["two", "five"])
def test_intervals_are_those_of_linear_programs(seed, place):
    """Most and least z of a node from which the end is reached: two programs over all cells that follow."""
    rng = np.random.default_rng(seed)
    n, joints = int(rng.integers(6, 16)), int(rng.integers(1, 6))
    path = AxisPath.from_callable(harmonics(seed, joints))
    run, limits = path.runs[0], random_limits(seed, joints)
    end = 0.0 if seed % 2 else 0.5 * second_order_law(run, limits, cells=200, guard=False).speed[150]
    nodes = np.linspace(0.0, 1.0 if end == 0.0 else 0.75, n + 1)
    cells = Cells(run, limits, nodes, place)
    ends = (1e9, end**2)
    low, high, stuck = passes(cells, ends)
    if stuck >= 0:
        rest = Cells(run, limits, nodes[stuck:], place)
        assert linear_program(rest, ends, np.zeros(len(rest.nodes)), False) is None
        return
    for k in range(n):
        rest = Cells(run, limits, nodes[k:], place)
        first = np.eye(len(rest.nodes))[0]
        start = cells.top(*ends)[k], ends[1]
        most, least = (linear_program(rest, start, sign * first, False) for sign in (1.0, -1.0))
        assert high[k] == pytest.approx(most[0], rel=1e-6, abs=1e-9)
        assert low[k] == pytest.approx(least[0], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_speed_is_that_of_a_linear_program(seed):
    """Where every row lets a faster node be followed by a faster one, one z is the highest of all at every node."""
    run, limits = AxisPath.from_callable(harmonics(seed, 1 + seed % 5)).runs[0], random_limits(seed, 1 + seed % 5)
    cells = Cells(run, limits, np.linspace(0.0, 1.0, 61))
    z, status, _ = cells.solve(0.0, 0.0)
    best = linear_program(cells, (0.0, 0.0), np.ones(61), True)
    assert status == reachability.FEASIBLE
    a, b = rows_of(cells)
    assert (a @ z <= b + 1e-7 * (1 + np.abs(a).max(axis=1) * z.max())).all()
    following = [(row[row != 0.0] > 0.0).sum() == 1 or abs(row @ best - bound) > 1e-9 for row, bound in zip(a, b)]
    if all(following):
        np.testing.assert_allclose(z, best, rtol=1e-6, atol=1e-9)
    # next to zero inertia going faster here may cost speed there, and the passes take it here
    assert 0.997 < z.sum() / best.sum() < 1.0 + 1e-9

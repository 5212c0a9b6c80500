"""Plans without jerk limits, or with very high ones: the second-order optimum; no plan loses by a looser limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import coo_array, vstack

import toolpace as tp
from tests.support.random_paths import harmonics, random_limits
from tests.support.tool_paths import toolpath_through
from tests.support.usage import dense_usage
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan

CELLS = 1000
"""Of the linear program: it is wrong by what an acceleration may miss in a cell."""
NOISE = 1e-4
"""Of the durations of two plans, relative: the guarantee allows as much of each."""


def fastest_second_order(f, limits, cells):
    """Duration of the fastest motion from rest to rest within velocities and accelerations, by a linear program.

    z = (ds/dt)^2 is linear in each cell; the highest z everywhere, which is the fastest, is that of the greatest sum.
    """
    s = np.linspace(0.0, 1.0, cells + 1)
    h = 1.0 / cells
    q1, q2 = f(s, 1), f(s, 2)
    most = np.min((limits.velocity / np.maximum(np.abs(q1), 1e-12)) ** 2, axis=1)
    most[[0, -1]] = 0.0
    row, column, value = [], [], []
    count = 0
    for at in (0, 1):
        for joint in range(q1.shape[1]):
            here = slice(at, cells + at)
            slope = q1[here, joint] / (2.0 * h * limits.acceleration[joint])
            bend = q2[here, joint] / limits.acceleration[joint]
            rows = count + np.arange(cells)
            for node, of_node in ((0, -slope + bend * (at == 0)), (1, slope + bend * (at == 1))):
                row.append(rows)
                column.append(np.arange(cells) + node)
                value.append(of_node)
            count += cells
    a = coo_array((np.concatenate(value), (np.concatenate(row), np.concatenate(column))), (count, cells + 1)).tocsr()
    unit = float(np.median(most))
    found = linprog(
        -np.ones(cells + 1), A_ub=vstack([a, -a]) * unit, b_ub=np.ones(2 * count),
        bounds=np.stack([np.zeros(cells + 1), most / unit], axis=1), method="highs",
    )  # fmt: skip
    assert found.status == 0
    speed = np.sqrt(np.maximum(found.x * unit, 0.0))
    return float((2.0 * h / (speed[1:] + speed[:-1])).sum())


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("jerk", [np.inf, 1e9])
def test_without_jerk_limits_the_second_order_optimum_is_found(seed, jerk):
    """It was 1 percent slower, 3 at worst: the mesh could not tell where accelerations switch."""
    f, limits = harmonics(seed, 3), random_limits(seed, 3)
    free = Limits(limits.velocity, limits.acceleration, jerk)
    trajectory = plan(AxisPath.from_callable(f), free)
    coarse, fine = (fastest_second_order(f, free, cells) for cells in (CELLS // 2, CELLS))
    assert trajectory.duration <= fine * (1.0 + NOISE)
    assert trajectory.duration == pytest.approx(2.0 * fine - coarse, abs=NOISE * fine + abs(fine - coarse))
    assert abs(fine - coarse) < 2e-3 * fine
    assert dense_usage(trajectory) <= PROMISED
    assert 0.999 * trajectory.duration <= trajectory.lower_bound <= trajectory.duration


@pytest.mark.parametrize("v, a, length", [(np.inf, 1.0, 1.0), (np.inf, 7.0, 0.03), (0.4, 1.5, 1.0), (1.0, 50.0, 20.0)])
def test_a_line_without_jerk_is_a_trapezoid(v, a, length):
    path = AxisPath.from_callable(lambda s, order: (s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s)[order][:, None], 0.0, length)
    reached = min(v, np.sqrt(a * length))
    trajectory = plan(path, Limits(v, a, np.inf))
    assert trajectory.duration == pytest.approx(length / reached + reached / a, rel=5e-5)
    assert trajectory.gap < 1e-3 and trajectory.usage().worst <= PROMISED


def test_a_line_between_moving_ends_without_jerk():
    v0, v1, a = 0.5, 0.8, 1.0
    peak = np.sqrt(a + (v0**2 + v1**2) / 2.0)
    path = AxisPath.from_callable(lambda s, order: (s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s)[order][:, None])
    trajectory = plan(path, Limits(np.inf, a, np.inf), start=EndState(v0, 0.0), end=EndState(v1, 0.0))
    assert trajectory.duration == pytest.approx((2.0 * peak - v0 - v1) / a, rel=1e-4)
    assert trajectory.state(0.0)[1] == pytest.approx(v0)


@pytest.mark.sweep
@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    jerk=st.floats(0.0, 6.0),
    kind=st.integers(0, 2),
    joint=st.integers(0, 3),
    factor=st.sampled_from([1.01, 2.0, 100.0, np.inf]),
)
def test_no_plan_loses_by_a_limit_that_is_raised(seed, jerk, kind, joint, factor):
    """Of one joint or of all (joint 3), whatever the jerk."""
    base = random_limits(seed, 3).scaled(jerk=10.0**jerk)
    kinds = [base.velocity.copy(), base.acceleration.copy(), base.jerk.copy()]
    kinds[kind][joint if joint < 3 else slice(None)] *= min(factor, 2.0) if kind < 2 else factor
    path = AxisPath.from_callable(harmonics(seed, 3))
    durations = [plan(path, limits, bound=False).duration for limits in (base, Limits(*kinds))]
    assert durations[1] <= durations[0] * (1.0 + NOISE)


@pytest.mark.parametrize("seed", [5, 6])
def test_jerk_limits_taken_away_one_after_the_other_make_plans_no_slower(seed):
    path, limits = AxisPath.from_callable(harmonics(seed, 3)), random_limits(seed, 3)
    jerk, durations = limits.jerk.copy(), [plan(path, limits, bound=False).duration]
    for joint in range(3):
        jerk[joint] = np.inf
        durations.append(plan(path, Limits(limits.velocity, limits.acceleration, jerk), bound=False).duration)
    assert (np.diff(durations) <= NOISE * durations[0]).all() and durations[-1] < 0.99 * durations[0]


def test_ordinary_jerk_limits_keep_the_mesh_that_they_had(monkeypatch):
    monkeypatch.setattr("toolpace.planning.optimal.planner.sharpened", None)
    fastest_law(AxisPath.from_callable(harmonics(9, 3)).runs[0], random_limits(9, 3))


@pytest.mark.sweep
def test_a_program_on_a_machine_without_jerk_limits_is_verified():
    """The judge differentiates the set-points: velocities and accelerations are held between nodes and set-points."""
    machine = tp.Machine.load("xyzac-trunnion")
    limits = machine.limits
    free = machine.with_limits(Limits(limits.velocity, limits.acceleration, np.inf, limits.joints))
    k = np.arange(8.0)
    tip = np.stack([4e-3 * k, 4e-3 * (k % 2), np.zeros(8)], axis=1)
    toolpath = toolpath_through(tip, np.tile([0.0, 0.0, 1.0], (8, 1)), feed=0.1)
    path = tp.Path.fit(toolpath, machine=free)
    slow, fast = tp.plan(path, machine), tp.plan(path, free)
    assert fast.duration < slow.duration and fast.usage().worst <= PROMISED
    tp.verify(fast, free, toolpath).raise_if_failed()

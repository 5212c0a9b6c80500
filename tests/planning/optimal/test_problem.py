"""The planner's problem: that each of its rows and caps is a limit of the machine or a feed, and none is left out."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import harmonics, path_of
from tests.support.random_paths import random_limits
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.motion.laws import SplineLaw
from toolpace.planning.optimal.problem import OnMesh, discretise, rest_cap, weights, with_rows_between
from toolpace.planning.optimal.solve import pinned
from toolpace.planning.planned_run import AT_REST, EndState

LOOSE = Limits([1e3] * 3, [1e7] * 3, [1e11] * 3)
"""Limits of joints that no motion within the feeds below comes near."""
NODES = np.concatenate([[0.0, 1e-3], np.linspace(0.02, 0.98, 49), [0.999, 1.0]])


def fed(breaks=(), jump=0.0):
    """A path of three joints with a feed that changes along it, and jumps at the breaks."""

    def speed_cap(s):
        return 0.1 + 0.05 * np.sin(9.0 * s) + jump * np.searchsorted(breaks, s, side="right")

    path = path_of(harmonics(np.random.default_rng(5), 3), speed_cap=speed_cap, breaks=np.array(breaks))
    return path.runs[0], speed_cap


@pytest.mark.parametrize("ends", [(AT_REST, AT_REST), (EndState(0.05), EndState(0.05))])
def test_the_feed_caps_every_point_at_the_nodes_and_between_them(ends):
    breaks = (NODES[10], NODES[30])
    run, speed_cap = fed(breaks, 0.2)
    problem = discretise(run, LOOSE, NODES, *ends)
    middles = problem.nodes[:-1] + 0.4 * np.diff(problem.nodes)
    problem = with_rows_between(problem, run, LOOSE, middles)
    assert np.count_nonzero(problem.inside) == len(middles)
    at_end = (problem.node == 0) & ~problem.inside | (problem.node == len(problem.nodes) - 1)
    expected = speed_cap(problem.place) ** 2
    # of a break its left side has the feed before it
    for place in breaks:
        left, right = np.flatnonzero(problem.place == place)
        expected[left] = speed_cap(np.nextafter(place, 0.0)) ** 2
        assert expected[left] < expected[right]
        # and none of what lies behind the break: its acceleration is not held further on
        half = problem.rows.shape[1] // 2
        assert (problem.rows[left, :half, 2] == 0.0).all() and (problem.rows[right, :half, 2] != 0.0).all()
    np.testing.assert_allclose(problem.cap[~at_end], expected[~at_end], rtol=1e-9)
    if ends[0].at_rest:
        assert (problem.cap[at_end] <= expected[at_end] * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("kind", ["velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_at_the_edge_of_its_rows_is_at_a_limit(seed, kind):
    """At any z, z', z'' the rows tell what the joints use of acceleration and jerk, and the cap what of velocity."""
    random = np.random.default_rng(seed)
    run, limits = path_of(harmonics(random, 3)).runs[0], random_limits(seed, 3)
    problem = discretise(run, limits, NODES, EndState(1e-3), EndState(1e-3))
    places = problem.nodes[3:-3] + 0.3 * np.diff(problem.nodes)[3:-2]
    problem = with_rows_between(problem, run, limits, places)
    mine = problem.inside
    s, n = problem.place[mine], len(places)
    z, z1, z2 = random.uniform(0.2, 2.0, n), random.normal(size=n), random.normal(size=n) * 10.0
    # ds/dt = sqrt(z), its derivatives z' / 2 and z'' sqrt(z) / 2
    state = np.stack([s, np.sqrt(z), z1 / 2.0, z2 * np.sqrt(z) / 2.0])
    ratios = np.abs(limit_ratios(run, limits, state, np.ones(n)))
    told = np.abs(np.einsum("prd,pd->pr", problem.rows[mine], np.stack([z, z1, z2], axis=1)))
    if kind == "velocity":
        fast = problem.cap[mine] < problem.most
        assert fast.any()
        np.testing.assert_allclose(np.sqrt(z / problem.cap[mine])[fast], ratios[fast, 1:4].max(axis=1), rtol=1e-9)
    elif kind == "acceleration":
        np.testing.assert_allclose(told[:, :3], ratios[:, 4:7], rtol=1e-9, atol=1e-12)
    else:
        np.testing.assert_allclose(told[:, 3:] * np.sqrt(z)[:, None], ratios[:, 7:], rtol=1e-9, atol=1e-12)


def test_lowered_limits_are_lowered_by_as_much_as_is_said():
    run, _ = fed()
    problem = discretise(run, LOOSE, NODES, AT_REST, AT_REST)
    problem = with_rows_between(problem, run, LOOSE, problem.nodes[[3, 8]] + 1e-3)
    random = np.random.default_rng(0)
    by, between = 1.0 + random.random((len(problem.nodes), 3)), 1.0 + random.random((2, 3))
    lower = problem.lowered(by, between)
    factor = by[problem.node]
    factor[problem.inside] = between
    np.testing.assert_allclose(lower.cap * factor[:, 0] ** 2, problem.cap)
    np.testing.assert_allclose(lower.rows[:, :3], problem.rows[:, :3] * factor[:, 1, None, None])
    np.testing.assert_allclose(lower.rows[:, 3:], problem.rows[:, 3:] * factor[:, 2, None, None])


@pytest.mark.parametrize("forth", [True, False])
@pytest.mark.parametrize("length", [1e-4, 3e-3, 0.05])
@pytest.mark.parametrize("broken", [None, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(2))
def test_out_of_rest_no_limit_is_passed_and_one_is_reached(seed, broken, length, forth):
    """At the most z that is allowed at the inner end of the outermost cell, looked at at ten times as many states.

    The feed may jump within the cell, or at its inner end.
    """
    random = np.random.default_rng(seed)
    breaks = np.empty(0) if broken is None else np.array([broken * length, 1.0 - broken * length])

    def speed_cap(s):
        inner = (s >= breaks[0]) & (s < breaks[1]) if broken else s < 2.0
        return np.where(inner, 0.3, 0.02)

    path = path_of(harmonics(random, 3), speed_cap=speed_cap, breaks=breaks)
    run, limits = path.runs[0], random_limits(seed, 3)
    node = length if forth else 1.0 - length
    most = rest_cap(run, limits, node, length, forth)
    # ds/dt has a constant third derivative: s - s0 = k t^3 / 6, and sqrt(z) = k t^2 / 2 at the node
    sign = 1.0 if forth else -1.0
    third = 2.0 * most**1.5 / (9.0 * length**2)
    t = np.cbrt(6.0 * length / third) * np.linspace(1e-4, 1.0 - 1e-9, 4001)
    s = node - sign * (length - third * t**3 / 6.0)
    state = np.stack([s, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    assert state[1, -1] == pytest.approx(np.sqrt(most), rel=1e-6)
    used = np.abs(limit_ratios(run, limits, state, np.ones(len(t)))).max()
    assert 0.99 < used <= 1.0 + 2e-4


@pytest.mark.parametrize("forth", [True, False])
@pytest.mark.parametrize("width", [1e-6, 1e-5, 1e-4])
def test_a_bend_in_the_cell_next_to_rest_is_not_passed_too_fast(width, forth):
    """However narrow: it changes the slope of the path between two of the places at which it is looked at."""
    length, place = 0.1, 0.0613 if forth else 1.0 - 0.0613
    node = length if forth else 1.0 - length

    def jets(s):
        y = np.tanh((s - place) / width)
        g = 1.0 - y * y
        bend = np.stack([0.0 * s, y, g / width, -2.0 * y * g / width**2]) * 0.3
        bend[0] = 0.3 * (np.abs(s - place) + width * np.log1p(np.exp(-2.0 * np.abs(s - place) / width)))
        return (np.stack([s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s]) + bend)[:, :, None]

    limits = Limits([1.0], [4.0], [40.0])
    run = path_of(jets).runs[0]
    most = rest_cap(run, limits, node, length, forth)
    sign = 1.0 if forth else -1.0
    third = 2.0 * most**1.5 / (9.0 * length**2)
    s = place + np.linspace(-6.0, 6.0, 4001) * width
    t = np.cbrt(6.0 * (s - node + sign * length) * sign / third)
    state = np.stack([s, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    assert limit_ratios(run, limits, state, np.ones(len(t))).max() <= 1.0 + 1e-4


def test_points_of_one_place_share_its_weight():
    """At a pace of 1 the time is the length, with breaks and rows between too; a rest cell counts three times."""
    run, _ = fed((NODES[10], NODES[30]), 0.2)
    problem = discretise(run, LOOSE, NODES, AT_REST, AT_REST)
    between = with_rows_between(problem, run, LOOSE, problem.nodes[[3, 8]] + 1e-3)
    length = problem.nodes[-1] - problem.nodes[0] + 3.0 * sum(problem.rest)
    for each in (problem, between):
        assert each.weight.sum() == pytest.approx(length, rel=1e-12)


def test_weights_sum_the_time_of_a_motion_by_trapezoids():
    places, rest = np.cumsum(np.random.default_rng(2).uniform(0.1, 1.0, 30)), (0.2, 0.05)
    z = np.random.default_rng(3).uniform(0.5, 2.0, 30)
    pace = 1.0 / np.sqrt(z)
    # a rest cell of length h takes 3 h / sqrt(z)
    time = np.trapezoid(pace, places) + 3.0 * rest[0] * pace[0] + 3.0 * rest[1] * pace[-1]
    assert weights(places, rest) @ pace == pytest.approx(time, rel=1e-12)


@pytest.mark.parametrize("rest", [(0.03, 0.2), (0.2, 0.03), (0.1, 0.1)])
def test_accelerations_do_not_jump_at_the_inner_ends_of_rest_cells(rest):
    """The outermost coefficients are tied so that z' there is what a constant third derivative of s gives."""
    nodes = np.cumsum(np.random.default_rng(4).uniform(0.05, 0.3, 12))
    c = pinned(OnMesh(nodes, rest, (AT_REST, AT_REST)), np.random.default_rng(5).uniform(0.5, 2.0, 14))
    law = SplineLaw(nodes, c, rest)
    for inner, outer in ((0.0, law.times[0]), (law.times[-1], law.duration)):
        step = 1e-7 * (outer - inner)
        at = law.times[0] if inner == 0.0 else law.times[-1]
        before, after = law.at(np.array([at - step, at + step])).T
        assert before[2] == pytest.approx(after[2], rel=1e-4, abs=1e-6)
        assert abs(after[2]) > 0.01


@pytest.mark.parametrize("ends", [(0.4, 0.3), (-0.2, -0.5)])
def test_ends_in_motion_have_the_speed_and_the_acceleration_that_are_given(ends):
    nodes = np.cumsum(np.random.default_rng(4).uniform(0.05, 0.3, 12))
    start, end = EndState(1.1, ends[0]), EndState(0.9, ends[1])
    c = pinned(OnMesh(nodes, (0.0, 0.0), (start, end)), np.random.default_rng(5).uniform(0.8, 1.2, 14))
    law = SplineLaw(nodes, c, (0.0, 0.0))
    at = law.at(np.array([0.0, law.duration]))
    np.testing.assert_allclose(at[1], [1.1, 0.9], rtol=1e-9)
    np.testing.assert_allclose(at[2], ends, rtol=1e-6)

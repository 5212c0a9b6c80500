"""The optimal planner against CasADi and IPOPT on the same discretisation, and against what any optimum must obey."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.random_paths import harmonics, random_limits
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan


def compare(path, limits, cells, start=None, end=None):
    """Duration of ours over IPOPT's on exactly the same nodes, rows and caps."""
    pytest.importorskip("casadi")
    from testbed import ipopt

    states = {"start": start or EndState(), "end": end or EndState()}
    law, _ = fastest_law(path.runs[0], limits, cells=cells, guard=False, **states)
    best = ipopt.optimum(path, limits, cells, **states)
    assert best.note == ipopt.SUCCEEDED
    return law.duration / best.law.duration


@pytest.mark.parametrize("seed", range(6))
def test_rest_to_rest_is_ipopts_optimum(seed):
    ratio = compare(AxisPath.from_callable(harmonics(seed)), random_limits(seed, tight=seed % 2 == 1), 60 + 20 * seed)
    assert abs(ratio - 1.0) < 1e-4


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(100, 140))
def test_rest_to_rest_is_ipopts_optimum_on_many(seed):
    joints = 1 + seed % 7
    path = AxisPath.from_callable(harmonics(seed, joints))
    assert abs(compare(path, random_limits(seed, joints, seed % 2 == 1), 150) - 1.0) < 1e-4


@pytest.mark.parametrize("seed", range(3))
def test_moving_ends_are_ipopts_optimum(seed):
    """From and to states taken from a slowed-down motion along a longer piece of the same path."""
    f, limits = harmonics(seed), random_limits(seed)
    whole = plan(AxisPath.from_callable(f), limits, mesh=200)
    (s0, v0, a0), (s1, v1, a1) = (whole.state(share * whole.duration) for share in (0.3, 0.8))
    piece = AxisPath.from_callable(f, s0, s1)
    start, end = EndState(0.8 * v0, 0.64 * a0), EndState(0.8 * v1, 0.64 * a1)
    assert abs(compare(piece, limits, 100, start, end) - 1.0) < 1e-4


def test_feed_caps_that_jump_are_ipopts_optimum():
    breaks = np.array([0.3, 0.55])
    path = AxisPath.from_callable(
        harmonics(3), speed_cap=lambda s: np.where((s >= 0.3) & (s < 0.55), 0.05, 0.3), breaks=breaks
    )
    assert abs(compare(path, random_limits(3), 150) - 1.0) < 1e-4


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["velocity", "acceleration", "jerk"])
def test_looser_limits_are_never_slower(seed, kind):
    path, limits = AxisPath.from_callable(harmonics(seed)), random_limits(seed)
    tight = plan(path, limits, mesh=300).duration
    loose = plan(path, limits.scaled(**{kind: 1.3}), mesh=300).duration
    assert loose <= tight * (1.0 + 1e-3)


@pytest.mark.parametrize("k", [1e-3, 0.5, 7.0, 1e4])
def test_time_scales_with_the_limits(k):
    """Limits v / k, a / k^2, j / k^3 stretch time by exactly k."""
    path, limits = AxisPath.from_callable(harmonics(11)), random_limits(11)
    slow = limits.scaled(1.0 / k, 1.0 / k**2, 1.0 / k**3)
    a, b = (plan(path, given, mesh=200, guard=False).duration for given in (limits, slow))
    assert b / a == pytest.approx(k, rel=1e-5)


@pytest.mark.parametrize("k", [1e-6, 1e3])
def test_units_of_joints_and_of_the_parameter_do_not_matter(k):
    f, limits = harmonics(12), random_limits(12)
    base = plan(AxisPath.from_callable(f), limits, mesh=200, guard=False).duration
    joints = AxisPath.from_callable(lambda s, order: k * f(s, order))
    assert plan(joints, limits.scaled(k, k, k), mesh=200, guard=False).duration == pytest.approx(base, rel=1e-5)
    parameter = AxisPath.from_callable(lambda s, order: f(s / k, order) / k**order, 0.0, k)
    assert plan(parameter, limits, mesh=200, guard=False).duration == pytest.approx(base, rel=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_backwards_takes_as_long(seed):
    f, limits = harmonics(seed), random_limits(seed, tight=True)
    forth = plan(AxisPath.from_callable(f), limits, mesh=500).duration
    back = plan(AxisPath.from_callable(lambda s, order: (-1.0) ** order * f(1.0 - s, order)), limits, mesh=500)
    assert back.duration == pytest.approx(forth, rel=1e-3)


def test_stops_add_up_and_never_help():
    f, limits = harmonics(8), random_limits(8)
    halves = [AxisPath.from_callable(f, *ends) for ends in ((0.0, 0.4), (0.4, 1.0))]
    both = AxisPath(halves[0].runs + halves[1].runs, halves[0].joints)
    parts = [plan(half, limits).duration for half in halves]
    assert plan(both, limits).duration == pytest.approx(sum(parts), rel=1e-9)
    assert plan(AxisPath.from_callable(f), limits).duration < sum(parts)


def test_more_joints_are_never_faster():
    f, limits = harmonics(9), random_limits(9)
    few = AxisPath.from_callable(lambda s, order: f(s, order)[:, :3])
    of_few = Limits(limits.velocity[:3], limits.acceleration[:3], limits.jerk[:3])
    all_five = plan(AxisPath.from_callable(f), limits, mesh=300).duration
    assert plan(few, of_few, mesh=300).duration <= all_five * (1.0 + 1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_some_limit_binds_nearly_always(seed):
    """A time-optimal motion is at a limit at every instant but for the switches that a mesh smears."""
    shares = plan(AxisPath.from_callable(harmonics(seed)), random_limits(seed), mesh=1500).limited_by()
    assert shares["nothing"] < 0.1

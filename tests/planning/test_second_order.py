"""The second-order planner: closed forms, what any optimum must obey, and words where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from testbed import nasty_paths
from tests.support.random_paths import harmonics, random_limits
from tests.support.usage import dense_usage
from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.deflection import replan
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan
from toolpace.planning.second_order import second_order_law

FREE = Limits([np.inf, np.inf], 1.0, np.inf)


def line(length=1.0):
    """One joint, straight on."""
    return AxisPath.from_callable(lambda s, order: (s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s)[order][:, None], 0.0, length)


def circle(s, order):
    return np.stack([np.cos(s + order * np.pi / 2), np.sin(s + order * np.pi / 2)], axis=1)


def second(path, limits, **options):
    return plan(path, limits, planner="second-order", **options)


# Closed forms


@pytest.mark.parametrize("length, a", [(1.0, 1.0), (0.03, 7.0), (40.0, 0.2)])
def test_line_is_bang_bang(length, a):
    trajectory = second(line(length), Limits(np.inf, a, 1.0))
    assert trajectory.duration == pytest.approx(2.0 * np.sqrt(length / a), rel=1e-6)
    middle = second_order_law(line(length).runs[0], Limits(np.inf, a, 1.0), nodes=np.linspace(0.0, length, 11))
    assert middle.duration == pytest.approx(2.0 * np.sqrt(length / a), rel=1e-14)


def test_line_with_a_velocity_is_a_trapezoid():
    v, a, length = 0.4, 1.5, 1.0
    trajectory = second(line(length), Limits(v, a, np.inf))
    assert trajectory.duration == pytest.approx(length / v + v / a, rel=1e-6)
    shares = trajectory.limited_by()
    assert shares["velocity q1"] == pytest.approx((length / v - v / a) / trajectory.duration, abs=2e-3)
    assert shares["acceleration q1"] == pytest.approx(2.0 * v / a / trajectory.duration, abs=2e-3)


def test_line_between_moving_ends():
    v0, v1, a, length = 0.5, 0.8, 1.0, 1.0
    peak = np.sqrt(a * length + (v0**2 + v1**2) / 2.0)
    trajectory = second(line(length), Limits(np.inf, a, np.inf), start=EndState(v0), end=EndState(v1))
    assert trajectory.duration == pytest.approx((2.0 * peak - v0 - v1) / a, rel=1e-6)
    assert trajectory.state(0.0)[1] == v0
    assert trajectory.state(trajectory.duration)[1] == pytest.approx(v1)


def test_quarter_circle():
    """z sin^2 grows by at most 2 sin: z = 2 / (1 + cos) up to 45 degrees, which takes 4 sin(pi / 8) for all of it.

    At both ends one joint stands still: its acceleration is centripetal, whatever the motion (zero inertia).
    """
    path = AxisPath.from_callable(circle, 0.0, np.pi / 2)
    best = 4.0 * np.sin(np.pi / 8)
    losses = []
    for n in (250, 500, 1000, 2000):
        law = second_order_law(path.runs[0], FREE, cells=n, start=EndState(1.0), end=EndState(1.0))
        losses.append(law.duration / best - 1.0)
    assert losses[-1] < 1e-3
    # the acceleration of a cell is what its worse end allows: first order in the mesh
    assert np.all(np.array(losses[:-1]) / losses[1:] > 1.7) and losses[-1] > -1e-4


def test_circle_at_steady_speed_between_full_turns():
    path = AxisPath.from_callable(circle, 0.0, 4 * np.pi, speed_cap=0.7)
    trajectory = second(path, FREE)
    ramp = second(AxisPath.from_callable(circle, 0.0, 0.5, speed_cap=0.7), FREE, end=EndState(0.7))
    assert trajectory.duration == pytest.approx(2 * ramp.duration + (4 * np.pi - 1.0) / 0.7, rel=1e-3)


# What any optimum must obey


def check_within(trajectory):
    usage = trajectory.usage()
    assert max(usage.feed, *usage.velocity.values(), *usage.acceleration.values()) <= PROMISED
    assert dense_usage(trajectory, kinds=("velocity", "acceleration")) <= PROMISED


@pytest.mark.parametrize("block", [0, *(pytest.param(block, marks=pytest.mark.sweep) for block in range(1, 4))])
def test_random_paths_on_fixed_meshes(block):
    for seed in range(30 * block, 30 * block + 30):
        rng = np.random.default_rng(seed)
        joints, mesh = int(rng.integers(1, 8)), int(rng.integers(8, 400))
        path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints)
        check_within(second(path, limits, mesh=mesh))


@pytest.mark.parametrize("seed", range(8))
def test_random_paths_on_the_default_mesh(seed):
    path, limits = AxisPath.from_callable(harmonics(seed)), random_limits(seed)
    trajectory = second(path, limits)
    check_within(trajectory)
    # some limit binds at every instant: the optimum is bang-bang
    assert trajectory.limited_by().get("nothing", 0.0) < 0.1


@pytest.mark.parametrize("seed", range(100, 125))
def test_never_slower_than_with_jerk_limits(seed):
    joints = 1 + seed % 6
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, seed % 2 == 1)
    assert second(path, limits).duration < plan(path, limits, mesh=300, bound=False).duration


@pytest.mark.parametrize("seed", range(4))
def test_loose_jerk_limits_come_close(seed):
    path, limits = AxisPath.from_callable(harmonics(seed)), random_limits(seed).scaled(jerk=1e4)
    with_jerk = plan(path, limits, mesh=2000, bound=False).duration
    assert second(path, limits).duration == pytest.approx(with_jerk, rel=4e-3)


@pytest.mark.parametrize("seed", range(6))
def test_loss_of_the_mesh_is_of_first_order(seed):
    run, limits = AxisPath.from_callable(harmonics(seed)).runs[0], random_limits(seed)
    coarse, middle, fine = (second_order_law(run, limits, cells=n).duration for n in (500, 2000, 8000))
    assert 2.5 < (coarse - middle) / (middle - fine) < 8.0
    assert fine < middle < coarse < fine * 1.005


def test_paper_arc_is_bounded_by_its_feed():
    """A quarter of 100 mm at 30 mm/s, and the ramps."""
    machine = Machine.load("paper-ab")
    trajectory = second(AxisPath.follow(Path.paper_arc(), machine), machine.limits)
    check_within(trajectory)
    assert trajectory.usage().feed == pytest.approx(1.0, abs=1e-4)
    assert 5.2359 < trajectory.duration < 5.26


@pytest.mark.parametrize("seed", range(10))
def test_moving_ends(seed):
    """A piece of a motion, between the speeds that the whole has there, takes as long as it does in the whole."""
    f, limits = harmonics(seed), random_limits(seed)
    whole = second_order_law(AxisPath.from_callable(f).runs[0], limits, cells=4000)
    i, j = 1200, 3100
    piece = AxisPath.from_callable(f, whole.nodes[i], whole.nodes[j])
    states = [EndState(0.999 * whole.speed[k]) for k in (i, j)]
    trajectory = second(piece, limits, start=states[0], end=states[1])
    check_within(trajectory)
    assert trajectory.duration == pytest.approx(whole.times[j] - whole.times[i], rel=2e-3)
    assert trajectory.state(0.0)[1] == pytest.approx(states[0].speed)
    assert trajectory.state(trajectory.duration)[1] == pytest.approx(states[1].speed)


@pytest.mark.parametrize("k", [1e-3, 7.0, 1e4])
def test_time_scales_with_the_limits(k):
    path, limits = AxisPath.from_callable(harmonics(11)), random_limits(11)
    slow = limits.scaled(1.0 / k, 1.0 / k**2)
    assert second(path, slow).duration / second(path, limits).duration == pytest.approx(k, rel=1e-9)


def test_backwards_takes_as_long():
    f, limits = harmonics(5), random_limits(5)
    back = AxisPath.from_callable(lambda s, order: (-1.0) ** order * f(1.0 - s, order))
    assert second(back, limits).duration == pytest.approx(second(AxisPath.from_callable(f), limits).duration, rel=1e-4)


def test_feed_that_jumps_at_breaks():
    def cap(s):
        return np.where((s >= 0.3) & (s < 0.55), 0.05, 0.3)

    path = AxisPath.from_callable(harmonics(3), speed_cap=cap, breaks=[0.3, 0.55])
    trajectory = second(path, random_limits(3))
    check_within(trajectory)
    law = trajectory.laws[0]
    assert {0.3, 0.55} <= set(law.nodes)
    # speed rises at once behind the slow stretch, as far as acceleration allows
    assert law.speed[np.searchsorted(law.nodes, 0.55)] == pytest.approx(0.05, rel=1e-6)


def test_curvature_that_jumps_at_a_break():
    """A straight line into an arc: the centripetal acceleration holds from the break on, not before."""

    def f(s, order):
        line = [s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s][order], [0.0 * s] * 4
        bent = np.sin(s - 1.0 + order * np.pi / 2), -np.cos(s - 1.0 + order * np.pi / 2)
        x = np.where(s < 1.0, line[0], bent[0] + (1.0 if order == 0 else 0.0))
        y = np.where(s < 1.0, 0.0, bent[1] + (1.0 if order == 0 else 0.0))
        return np.stack([x, y], axis=1)

    trajectory = second(AxisPath.from_callable(f, 0.0, 2.5, breaks=[1.0]), FREE)
    check_within(trajectory)
    law = trajectory.laws[0]
    assert law.speed[np.searchsorted(law.nodes, 1.0)] == pytest.approx(1.0, rel=1e-3)


# without limits of velocity and acceleration nothing may be left that holds this planner's motion
NASTY = [family for family in nasty_paths.FAMILIES if family != "infinite_limits"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("family", NASTY)
def test_nasty_paths(family):
    """From rest to rest there is always a motion, also where a cell with zero inertia would leave no speed."""
    for seed in range(6):
        case = nasty_paths.case(family, seed)
        options = {name: case.options[name] for name in ("start", "end", "mesh") if name in case.options}
        try:
            trajectory = second(case.path, case.limits, **options)
        except (InfeasibleError, UsageError):
            assert case.expected != nasty_paths.ANSWER, seed
            continue
        usage = trajectory.usage()
        assert max(usage.feed, *usage.velocity.values(), *usage.acceleration.values()) <= PROMISED, seed
        assert np.isfinite(trajectory.duration) and (np.diff(trajectory.laws[0].times) > 0.0).all(), seed


# The trajectory


def test_law_is_its_own_derivative_and_ends_where_the_run_ends():
    law = second(AxisPath.from_callable(harmonics(2)), random_limits(2), mesh=50).laws[0]
    t = np.linspace(0.0, law.duration, 500)[1:-1]
    t = t[np.abs(t[:, None] - law.times).min(axis=1) > 1e-5]
    for order in range(3):
        low, high = (law.at(t + d)[order] for d in (-1e-6, 1e-6))
        np.testing.assert_allclose((high - low) / 2e-6, law.at(t)[order + 1], atol=1e-7)
    assert law.at(np.array([0.0, law.duration]))[0] == pytest.approx([0.0, 1.0], abs=1e-15)
    np.testing.assert_allclose(law.at(law.times)[0], law.nodes, atol=1e-14)
    np.testing.assert_allclose(sum(probe.share.sum() for probe in law.probes()), law.duration, rtol=1e-12)


def test_stops_and_dwells():
    f, limits = harmonics(8), random_limits(8)
    halves = [AxisPath.from_callable(f, *ends) for ends in ((0.0, 0.4), (0.4, 1.0))]
    # without the guard: with it the durations once differed by 2.8e-6 of themselves on a busy machine, cause not found
    free = {"mesh": 200, "guard": False}
    parts = [second(half, limits, **free).duration for half in halves]
    halves[0].runs[0].dwell = 0.25
    told = []
    both = second(AxisPath(halves[0].runs + halves[1].runs, halves[0].joints), limits, progress=told.append, **free)
    assert both.duration == pytest.approx(sum(parts) + 0.25)
    assert told[-1] == pytest.approx(1.0) and told == sorted(told)
    assert both.limited_by()["dwell"] == pytest.approx(0.25 / both.duration)


def test_jerk_is_shown_as_unbounded_and_never_as_what_binds():
    path, limits = AxisPath.from_callable(harmonics(1)), random_limits(1)
    trajectory = second(path, limits)
    assert trajectory.planner == "second-order"
    assert trajectory.lower_bound == 0.0 and trajectory.gap == np.inf
    assert set(trajectory.usage().jerk.values()) == {np.inf} and trajectory.usage().worst == np.inf
    assert not any(name.startswith("jerk") for name in trajectory.limited_by())
    free = second(path, limits.scaled(jerk=np.inf))
    assert free.usage().worst <= PROMISED and free.duration == trajectory.duration


def test_steady_motion_has_no_jump():
    steady = EndState(0.5)
    path = AxisPath.from_callable(lambda s, order: (s, 1 + 0 * s, 0 * s, 0 * s)[order][:, None], speed_cap=0.5)
    trajectory = second(path, Limits(1.0, 1.0, 1.0), start=steady, end=steady)
    assert trajectory.usage().jerk == {"q1": 0.0} and trajectory.duration == pytest.approx(2.0)


def test_joint_that_stands_still_has_no_jerk():
    path = AxisPath.from_callable(lambda s, order: np.stack([(s, 1 + 0 * s, 0 * s, 0 * s)[order], 0 * s], axis=1))
    assert second(path, Limits([1.0, 1.0], 1.0, 1.0)).usage().jerk == {"q1": np.inf, "q2": 0.0}


def test_replanning_from_it_is_refused():
    machine = Machine.load("paper-ab")
    trajectory = second(AxisPath.follow(Path.paper_arc(), machine), machine.limits)
    with pytest.raises(UsageError, match="accelerations jump in a plan of planner second-order"):
        replan(trajectory, 2.5, [0.059, 0.0568, 0.0589])


# What cannot be


@pytest.mark.parametrize(
    "options, words",
    [
        ({"start": EndState(1.5)}, r"end state at s = 0: takes 1.5 of the velocity limit of q1"),
        ({"end": EndState(1.5)}, r"end state at s = 1: takes 1.5 of the velocity limit of q1"),
        ({"start": EndState(-0.5)}, "must be positive"),
        ({"start": EndState(np.nan)}, "must be positive"),
        ({"start": EndState(1.0)}, r"takes .* of the acceleration limit of q1 near s = .*cannot slow down in time"),
        ({"end": EndState(1.0)}, r"of the acceleration limit of q1 near s = .*more speed than can be gathered"),
        ({"mesh": 3}, "at least 8"),
    ],
)  # fmt: skip
def test_impossible_ends(options, words):
    with pytest.raises((InfeasibleError, UsageError), match=words):
        second(line(), Limits(1.0, 0.4, 1.0), **options)


def test_slow_feed_behind_a_fast_start_names_the_acceleration():
    path = AxisPath.from_callable(circle, 0.0, 1.0, speed_cap=lambda s: np.where(s < 0.1, 1.0, 0.1), breaks=[0.1])
    with pytest.raises(InfeasibleError, match=r"acceleration limit of q[12] near s = 0\.\d+: starting in motion"):
        second(path, FREE, start=EndState(0.9))


def test_centripetal_acceleration_of_a_start_names_the_joint():
    with pytest.raises(InfeasibleError, match=r"acceleration limit of q1 near s = 0: starting in motion"):
        second(AxisPath.from_callable(circle), FREE, start=EndState(1.1))


def test_no_limit_at_all():
    with pytest.raises(InfeasibleError, match="no limit holds the motion"):
        second(line(), Limits(np.inf, np.inf, 1.0))


def test_feed_of_zero():
    path = AxisPath.from_callable(circle, speed_cap=lambda s: np.where(s < 0.5, 1.0, 0.0), breaks=[0.5])
    with pytest.raises(InfeasibleError, match="leave no motion at s = "):
        second(path, FREE)


def test_velocity_alone_is_enough():
    assert second(line(), Limits(0.5, np.inf, np.inf), mesh=1000).duration == pytest.approx(2.0, rel=2e-3)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "seed", [*range(1000, 1060), *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(1060, 1300))]
)
def test_many_random_paths_with_random_ends(seed):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(1, 8))
    path, limits = AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints)
    whole = second_order_law(path.runs[0], limits, cells=500)
    i, j = sorted(rng.choice(np.arange(20, 480), 2, replace=False))
    piece = AxisPath.from_callable(harmonics(seed, joints), whole.nodes[i], whole.nodes[j])
    share = rng.uniform(0.2, 0.95)
    start, end = EndState(share * whole.speed[i]), EndState(share * whole.speed[j])
    check_within(second(piece, limits, start=start, end=end))

"""The optimal planner: closed forms, the guarantee between nodes, convergence, ends in motion, nasty paths."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.random_paths import harmonics, random_limits
from tests.support.straight_line import line, polynomials, s_curve
from tests.support.usage import dense_usage
from toolpace.common.errors import InfeasibleError, ToolpaceError
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planned_run import EndState
from toolpace.planning.planner import plan

# velocity, acceleration, jerk: seven phases; no constant acceleration; no cruise; neither
SHAPES = [(1.0, 3.0, 20.0), (0.3, 10.0, 20.0), (10.0, 2.0, 20.0), (10.0, 10.0, 5.0)]


@pytest.mark.parametrize("limit", SHAPES)
def test_straight_line_is_the_s_curve(limit):
    exact = s_curve(1.0, *limit)
    found = plan(line(), Limits(*([x] for x in limit)), mesh=8000).duration
    assert found == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("limit", SHAPES)
def test_straight_line_on_a_coarser_mesh(limit):
    found = plan(line(), Limits(*([x] for x in limit)), mesh=2000).duration
    assert found == pytest.approx(s_curve(1.0, *limit), rel=3e-4)


@pytest.mark.parametrize("limit", SHAPES)
def test_straight_line_by_default_mesh(limit):
    exact = s_curve(1.0, *limit)
    assert plan(line(), Limits(*([x] for x in limit))).duration == pytest.approx(exact, rel=2e-4)


@pytest.mark.parametrize("length", [1e-9, 1e-4, 0.1, 1e3])
def test_lengths_from_nanometres_to_kilometres(length):
    trajectory = plan(line(length), Limits([1.0], [3.0], [20.0]), mesh=1000)
    assert trajectory.duration == pytest.approx(s_curve(length, 1.0, 3.0, 20.0), rel=5e-3)
    assert trajectory.usage().worst <= PROMISED


def test_paper_arc_is_its_closed_form():
    """Wu et al. 2009, section III, as errata.md works it out: L / F + 2 sqrt(F / 21.2) = 5.3112 s."""
    trajectory = plan(Path.paper_arc(), Machine.load("paper-ab"))
    assert trajectory.duration == pytest.approx(5.3112, rel=5e-4)
    assert trajectory.usage().worst <= PROMISED
    binding = trajectory.limited_by()
    assert max(binding, key=binding.get) == "feed"
    assert binding["jerk B"] > 0.01


def test_cap_on_the_speed_equals_a_velocity_limit():
    wide = Limits([1e6], [3.0], [20.0])
    by_cap = plan(line(speed_cap=0.4), wide, mesh=500).duration
    assert by_cap == pytest.approx(plan(line(), Limits([0.4], [3.0], [20.0]), mesh=500).duration, rel=1e-4)


def test_at_the_cap_from_end_to_end():
    """Started and ended at the speed cap, the motion takes length / speed."""
    at_cap = EndState(0.5, 0.0)
    trajectory = plan(line(speed_cap=0.5), Limits([1.0], [3.0], [20.0]), start=at_cap, end=at_cap, mesh=200)
    assert trajectory.duration == pytest.approx(2.0, rel=1e-4)


def test_error_falls_with_the_mesh():
    """The price of a mesh against a fine one falls at least like N^-1 with the guarantee, N^-1.5 is usual."""
    f, limits = harmonics(21), random_limits(21)
    meshes = np.array([100, 200, 400, 800])
    fine = plan(AxisPath.from_callable(f), limits, mesh=6400).duration
    price = np.array([plan(AxisPath.from_callable(f), limits, mesh=int(n)).duration for n in meshes]) / fine - 1.0
    assert (price > -1e-4).all()
    assert price[-1] < 2e-3
    rate = -np.polyfit(np.log(meshes), np.log(np.maximum(price, 1e-6)), 1)[0]
    assert rate > 0.8


@pytest.mark.parametrize(
    ("seed", "cells"),
    [
        *((30, n) for n in (50, 100, 300, 1000, 2000)),
        (31, 50),
        *((31, n) for n in (100, 300, 1000, 2000)),
    ],
)
def test_limits_hold_between_the_nodes(seed, cells):
    trajectory = plan(AxisPath.from_callable(harmonics(seed)), random_limits(seed, tight=seed % 2 == 1), mesh=cells)
    assert dense_usage(trajectory) <= PROMISED
    assert trajectory.usage().worst == pytest.approx(dense_usage(trajectory), abs=2e-3)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(200, 300))
def test_limits_hold_between_the_nodes_on_many(seed):
    cells = [50, 80, 150, 300, 700, None][seed % 6]
    joints = 1 + seed % 7
    path = AxisPath.from_callable(harmonics(seed, joints))
    assert dense_usage(plan(path, random_limits(seed, joints, seed % 2 == 1), mesh=cells)) <= PROMISED


@pytest.mark.parametrize("seed", range(2))
def test_velocity_acceleration_and_jerk_are_derivatives_of_the_position(seed):
    """Differences of positions, knowing nothing of the chain rule; away from jumps of the jerk on the average."""
    trajectory = plan(AxisPath.from_callable(harmonics(seed)), random_limits(seed), mesh=400)
    h = 1e-4 * trajectory.duration
    t = np.random.default_rng(seed).uniform(5.0 * h, trajectory.duration - 5.0 * h, 300)
    t.sort()
    step = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    q = np.stack([trajectory.at(t + k * h).q for k in step])
    motion = trajectory.at(t)
    first = (q[0] - 8.0 * q[1] + 8.0 * q[3] - q[4]) / (12.0 * h)
    second = (q[1] - 2.0 * q[2] + q[3]) / h**2
    third = (q[4] - 2.0 * q[3] + 2.0 * q[1] - q[0]) / (2.0 * h**3)
    limits = trajectory.limits
    assert np.abs((first - motion.qd) / limits.velocity).max() < 1e-4
    assert np.abs((second - motion.qdd) / limits.acceleration).max() < 1e-2
    assert np.median(np.abs((third - motion.qddd) / limits.jerk)) < 1e-2


def test_motion_starts_and_ends_at_rest():
    trajectory = plan(AxisPath.from_callable(harmonics(4)), random_limits(4))
    motion = trajectory.at([0.0, trajectory.duration])
    limits = trajectory.limits
    assert (np.abs(motion.qd) < 1e-9 * limits.velocity).all()
    assert (np.abs(motion.qdd) < 1e-6 * limits.acceleration).all()


def piece_in_motion(shares, guard=True):
    """A piece of a path, from and to states a little slower than those of the whole motion; and the longest time."""
    f, limits = harmonics(5), random_limits(5)
    whole = plan(AxisPath.from_callable(f), limits)
    (s0, v0, a0), (s1, v1, a1) = (whole.state(share * whole.duration) for share in shares)
    start, end = EndState(0.9 * v0, 0.81 * a0), EndState(0.9 * v1, 0.81 * a1)
    piece = plan(AxisPath.from_callable(f, s0, s1), limits, start=start, end=end, mesh=300, guard=guard)
    return piece, (s0, start), (s1, end), (shares[1] - shares[0]) * whole.duration / 0.9


PIECES = [(0.2, 0.7), (0.45, 0.55), (0.1, 0.95)]


@pytest.mark.parametrize("guard", [False, True])
@pytest.mark.parametrize("shares", PIECES)
def test_moving_ends_are_met(shares, guard):
    piece, (s0, start), (s1, end), _ = piece_in_motion(shares, guard)
    assert piece.state(0.0) == pytest.approx((s0, start.speed, start.acceleration), rel=1e-6, abs=1e-9)
    assert piece.state(piece.duration) == pytest.approx((s1, end.speed, end.acceleration), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("shares", PIECES)
def test_moving_ends_keep_the_limits(shares):
    piece, _, _, longest = piece_in_motion(shares)
    assert dense_usage(piece) <= PROMISED
    assert piece.duration <= longest * (1.0 + 1e-3)


@pytest.mark.parametrize(
    ("start", "end", "limit"),
    [
        (EndState(2.0, 0.0), EndState(), "velocity limit of q1"),
        (EndState(), EndState(0.5, 5.0), "acceleration limit of q1"),
        (EndState(0.5, -4.0), EndState(), "acceleration limit of q1"),
    ],
)
def test_end_that_breaks_a_limit_is_named(start, end, limit):
    with pytest.raises(InfeasibleError, match=limit) as caught:
        plan(line(), Limits([1.0], [3.0], [20.0]), start=start, end=end, mesh=100)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("speed", [float("nan"), -0.1, float("inf")])
def test_end_that_makes_no_sense_is_refused(speed):
    with pytest.raises(InfeasibleError):
        plan(line(), Limits([1.0], [3.0], [20.0]), start=EndState(speed, 0.0), mesh=100)


def test_too_fast_to_stop_is_infeasible():
    """From 0.9 m/s, 10 cm are not enough to stop within 3 m/s^2 and 20 m/s^3."""
    with pytest.raises(InfeasibleError):
        plan(line(0.1), Limits([1.0], [3.0], [20.0]), start=EndState(9.0, 0.0), mesh=100)


NASTY = {
    "line, no third derivative": (polynomials([0, 1]), Limits([1.0], [3.0], [20.0])),
    "a joint that stands": (polynomials([0, 1, 0.5], [3]), Limits([1.0, 1.0], 3.0, 20.0)),
    "limits six orders apart": (
        harmonics(40), Limits([1, 1e-3, 1e3, 1e-3, 1e3], [3, 3e-3, 3e3, 3, 3], [20, 20e-3, 20e3, 20, 20]),
    ),
    "no jerk limit on some": (harmonics(41), Limits([1.0] * 5, [3.0] * 5, [20.0, np.inf, 20.0, np.inf, 20.0])),
    "no velocity limits": (harmonics(42), Limits(np.inf, [3.0] * 5, [20.0] * 5)),
    "parameter at rest at the start": (polynomials([0, 0, 1]), Limits([1.0], [3.0], [20.0])),
    "a joint that turns": (
        lambda s, order: (np.cos(np.pi * s + order * np.pi / 2) * np.pi**order)[:, None], Limits([1.0], [3.0], [20.0]),
    ),
    "joints of nanometres": (lambda s, order: 1e-9 * harmonics(43)(s, order), random_limits(43)),
    "joints of kilometres": (lambda s, order: 1e3 * harmonics(43)(s, order), random_limits(43).scaled(1e3, 1e3, 1e3)),
}  # fmt: skip


COARSE = list(NASTY)


@pytest.mark.parametrize("name", COARSE)
def test_nasty_paths_keep_their_limits_on_fifty_cells(name):
    f, limits = NASTY[name]
    assert dense_usage(plan(AxisPath.from_callable(f), limits, mesh=50)) <= PROMISED


@pytest.mark.parametrize("name", NASTY)
@pytest.mark.parametrize("cells", [400])
def test_nasty_paths_keep_their_limits(name, cells):
    f, limits = NASTY[name]
    trajectory = plan(AxisPath.from_callable(f), limits, mesh=cells)
    assert dense_usage(trajectory) <= PROMISED


@pytest.mark.parametrize("cells", [100, 500, None])
def test_feed_caps_that_jump(cells):
    path = AxisPath.from_callable(
        harmonics(44), speed_cap=lambda s: np.where((s >= 0.3) & (s < 0.6), 0.01, 10.0), breaks=[0.3, 0.6]
    )
    trajectory = plan(path, random_limits(44), mesh=cells)
    assert dense_usage(trajectory) <= PROMISED
    assert trajectory.duration > 0.3 / 0.01


def test_a_cusp_rounded_to_a_micrometre():
    def f(s, order):
        x, e = s - 0.5, 1e-12
        r = np.sqrt(x * x + e)
        one = [s, 1.0 + 0.0 * s, 0.0 * s, 0.0 * s][order]
        return np.stack([one, [r, x / r, e / r**3, -3.0 * e * x / r**5][order]], axis=1)

    trajectory = plan(AxisPath.from_callable(f), Limits([1.0, 1.0], 3.0, 20.0))
    assert dense_usage(trajectory) <= PROMISED
    assert trajectory.duration > 2.0 * s_curve(0.5, 1.0, 3.0, 20.0) * 0.9


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    joints=st.integers(1, 7),
    cells=st.integers(50, 300),
    velocity=st.floats(-3, 3),
    acceleration=st.floats(-3, 3),
    jerk=st.floats(-3, 3),
)
def test_any_path_is_planned_within_its_limits(seed, joints, cells, velocity, acceleration, jerk):
    limits = random_limits(seed, joints).scaled(10.0**velocity, 10.0**acceleration, 10.0**jerk)
    trajectory = plan(AxisPath.from_callable(harmonics(seed, joints)), limits, mesh=cells)
    assert dense_usage(trajectory, 4000, seed) <= PROMISED
    assert np.isfinite(trajectory.duration)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000), share=st.floats(0.05, 0.95), slower=st.floats(0.3, 0.99))
def test_replanning_from_any_state_of_a_motion_works(seed, share, slower):
    f, limits = harmonics(seed), random_limits(seed)
    whole = plan(AxisPath.from_callable(f), limits, mesh=150)
    s, v, a = whole.state(share * whole.duration)
    rest = plan(AxisPath.from_callable(f, s, 1.0), limits, start=EndState(slower * v, slower**2 * a), mesh=150)
    assert dense_usage(rest, 4000, seed) <= PROMISED
    assert rest.duration <= (1.0 - share) * whole.duration / slower * 1.02


@pytest.mark.parametrize("cells", [0, 7, -3])
def test_too_coarse_a_mesh_is_refused(cells):
    with pytest.raises(ToolpaceError, match="mesh"):
        plan(line(), Limits([1.0], [3.0], [20.0]), mesh=cells)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000), joints=st.integers(3, 7), tight=st.booleans())
def test_smooth_paths_of_several_joints_keep_their_limits(seed, joints, tight):
    trajectory = plan(AxisPath.from_callable(harmonics(seed, joints)), random_limits(seed, joints, tight), mesh=200)
    assert dense_usage(trajectory, 4000, seed) <= PROMISED


def test_a_long_straight_line_has_few_nodes():
    """Guarded by a limit on memory: a path of hours must not ask for nodes by the microsecond."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, before[1]))
    try:
        trajectory = plan(line(1e9), Limits([1.0], [3.0], [20.0]))
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
    assert trajectory.mesh_points < 100_000


@pytest.mark.parametrize("cells", [300, 1000, None])
def test_feed_caps_that_jump_ten_times(cells):
    path = AxisPath.from_callable(
        harmonics(44),
        speed_cap=lambda s: np.where(np.floor(s * 20.0) % 2 == 0, 0.01, 1.0),
        breaks=np.arange(1, 20) / 20.0,
    )
    assert dense_usage(plan(path, random_limits(44), mesh=cells)) <= PROMISED


@pytest.mark.parametrize("cells", [1000, None])
def test_a_joint_that_goes_to_and_fro(cells):
    path = AxisPath.from_callable(
        lambda s, order: (0.01 * 200.0**order * np.sin(200.0 * s + order * np.pi / 2))[:, None]
    )
    assert dense_usage(plan(path, Limits([1.0], [3.0], [20.0]), mesh=cells)) <= PROMISED

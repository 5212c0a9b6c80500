"""Axis paths through waypoints and along splines: exact, smooth, planned within the limits, or refused in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.interpolate import (
    Akima1DInterpolator,
    BPoly,
    BSpline,
    CubicSpline,
    PchipInterpolator,
    PPoly,
    make_interp_spline,
    make_smoothing_spline,
)

import toolpace as tp
from toolpace.common.errors import PathError, UsageError
from toolpace.path.axis_spline import chord_lengths
from toolpace.planning.planner import plan

RNG = np.random.default_rng(7)
POINTS = RNG.uniform(-1.0, 1.0, (9, 3)) + np.array([0.0, 2.0, -5.0])
LIMITS = tp.Limits([1.0, 2.0, 3.0], [3.0, 4.0, 9.0], [30.0, 40.0, 90.0])
S = np.linspace(2.0, 5.0, 9)


def times_at(trajectory: tp.Trajectory, s: np.ndarray) -> np.ndarray:
    """When a motion passes s, by bisection."""
    low, high = np.zeros(len(s)), np.full(len(s), trajectory.duration)
    for _ in range(60):
        middle = (low + high) / 2.0
        below = trajectory.parameter(middle) < s
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return (low + high) / 2.0


def off_by_differences(run: tp.AxisRun) -> float:
    """Largest relative difference of each derivative from the central difference of the one below, inside pieces."""
    knots = run.hints
    s = np.concatenate([knots[:-1] + share * np.diff(knots) for share in (0.2, 0.5, 0.77)])
    h = 1e-4 * np.diff(knots).min()
    here, after, before = run.evaluate(s), run.evaluate(s + h), run.evaluate(s - h)
    slope = (after - before)[:3] / (2.0 * h)
    return float((np.abs(slope - here[1:]).max(axis=(1, 2)) / (np.abs(here[1:]).max(axis=(1, 2)) + 1.0)).max())


# -- waypoints --


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 50, 2000])
def test_a_path_passes_through_its_waypoints_and_its_derivatives_are_right(count: int) -> None:
    q = np.cumsum(np.random.default_rng(count).normal(size=(count, 4)), axis=0)
    run = tp.AxisPath.from_waypoints(q).runs[0]
    s = chord_lengths(q)
    np.testing.assert_allclose(run.evaluate(s)[0], q, atol=1e-12 * np.abs(q).max(), rtol=0)
    assert off_by_differences(run) < 1e-5
    assert len(run.breaks) == 0 and run.hints.tolist() == s.tolist()


def test_the_curve_is_four_times_continuous_with_natural_ends() -> None:
    run = tp.AxisPath.from_waypoints(POINTS, s=S).runs[0]
    h = 1e-5
    for knot in S[1:-1]:
        before, at, after = (run.evaluate(np.array([knot + d]))[3, 0] for d in (-h, 0.0, h))
        scale = np.abs(at).max() / np.diff(S).min()
        assert np.abs((after - at) / h - (at - before) / h).max() < 1e-2 * scale
    ends = run.evaluate(S[[0, -1]])[3]
    assert np.abs(ends).max() < 1e-9 * np.abs(run.evaluate(S)[3]).max()
    fourth = (run.evaluate(S[[0]] + h)[3] - ends[0]) / h
    assert np.abs(fourth).max() < 1e-2 * np.abs(run.evaluate(S)[3]).max() / np.diff(S).min()


def test_no_other_curve_through_the_points_has_less_of_the_third_derivative() -> None:
    t = np.linspace(S[0], S[-1], 4001)
    least = np.trapezoid(tp.AxisPath.from_waypoints(POINTS, s=S).runs[0].evaluate(t)[3] ** 2, t, axis=0)
    others = (make_interp_spline(S, POINTS, k=5), make_interp_spline(S, POINTS, k=7), CubicSpline(S, POINTS))
    for other in others:
        assert (least < np.trapezoid(other.derivative(3)(t) ** 2, t, axis=0)).all()


def test_two_waypoints_are_a_straight_line_and_three_a_parabola() -> None:
    line = (
        tp.AxisPath.from_waypoints([[0.0, 1.0], [2.0, 0.0]], s=[0.0, 4.0]).runs[0].evaluate(np.array([0.0, 1.0, 4.0]))
    )
    np.testing.assert_allclose(line[0], [[0.0, 1.0], [0.5, 0.75], [2.0, 0.0]], atol=1e-15)
    assert not line[2:].any()
    parabola = tp.AxisPath.from_waypoints([[0.0], [1.0], [4.0]], s=[0.0, 1.0, 2.0]).runs[0].evaluate(np.array([1.5]))
    np.testing.assert_allclose(parabola[:, 0, 0], [2.25, 3.0, 2.0, 0.0], atol=1e-12)


def test_chord_lengths_do_not_depend_on_units_and_leave_out_joints_that_stand() -> None:
    scaled = POINTS * [1e3, 180.0 / np.pi, 1e-3]
    np.testing.assert_allclose(chord_lengths(scaled), chord_lengths(POINTS), rtol=1e-12)
    standing = np.column_stack([POINTS, np.full(len(POINTS), 3.0)])
    np.testing.assert_array_equal(chord_lengths(standing), chord_lengths(POINTS))
    path = tp.AxisPath.from_waypoints(standing, joints=["a", "b", "c", "d"])
    assert path.joints == ("a", "b", "c", "d")
    assert np.ptp(path.runs[0].evaluate(np.linspace(0.0, 1.0, 20))[0][:, 3]) < 1e-14


def test_the_default_plan_through_waypoints_is_as_fast_as_that_of_a_fine_mesh() -> None:
    path = tp.AxisPath.from_waypoints(POINTS)
    trajectory = plan(path, LIMITS)
    assert trajectory.usage().worst <= 1.0001
    assert trajectory.gap < 1e-3
    assert trajectory.duration < plan(path, LIMITS, mesh=2000, bound=False).duration * (1.0 + 5e-4)
    np.testing.assert_allclose(trajectory.at(trajectory.duration).q, POINTS[-1], atol=1e-9)


def test_with_stops_each_way_is_a_straight_line_of_least_time() -> None:
    q = np.array([[0.0, 0.0], [2.0, 1.0], [2.0, 1.2]])
    path = tp.AxisPath.from_waypoints(q, stop=True, joints=["a", "b"])
    assert len(path.runs) == 2
    trajectory = plan(path, tp.Limits(1.0, 2.0, 8.0, ["a", "b"]))
    # rest to rest over d by jerk, then acceleration, then speed; the closed forms of the seven-segment profile
    v, a, j = 1.0, 2.0, 8.0
    far = 2.0 / v + v / a + a / j
    short = 4.0 * (0.2 / (2.0 * j)) ** (1.0 / 3.0)
    assert trajectory.duration == pytest.approx(far + short, rel=1e-3)
    assert trajectory.duration >= (far + short) * (1.0 - 1e-4)
    middle = trajectory.at(trajectory.starts[1])
    np.testing.assert_allclose(middle.q, q[1], atol=1e-12)
    assert np.abs(middle.qd).max() < 1e-6


def test_a_cap_of_speed_holds_along_waypoints() -> None:
    for cap in (0.05, lambda s: np.full(len(s), 0.05)):
        trajectory = plan(tp.AxisPath.from_waypoints(POINTS, s=S, speed_cap=cap), LIMITS, mesh=200, bound=False)
        assert trajectory.duration >= 3.0 / 0.05
    for wrong in (0.0, -1.0, np.nan, "fast", None):
        with pytest.raises(UsageError, match="speed_cap"):
            tp.AxisPath.from_waypoints(POINTS, speed_cap=wrong)


NAN = POINTS.copy()
NAN[4, 1] = np.nan


@pytest.mark.parametrize(
    ("q", "s", "message"),
    [
        (POINTS[[0, 1, 2, 2, 3]], None, r"q\[3\] repeats q\[2\]; leave it out"),
        (NAN, None, r"q\[4, 1\] is nan"),
        (POINTS[:1], None, "give at least two"),
        (POINTS[:0], None, "give at least two"),
        (POINTS[0], None, "one row a waypoint"),
        (POINTS[:, :0], None, "one row a waypoint"),
        ([[0.0, 1.0], [2.0]], None, "different lengths"),
        ([["a"], ["b"]], None, "of <U1; give real numbers"),
        (POINTS * 1j, None, "of complex128; give real numbers"),
        (POINTS, S[::-1], r"s\[1\] = 4.625 does not lie above s\[0\] = 5"),
        (POINTS, np.zeros(9), r"s\[1\] = 0 does not lie above"),
        (POINTS, S[:5], "each of 9 waypoints"),
        (POINTS, np.where(S > 4.9, np.inf, S), r"s\[8\] is inf"),
        (POINTS, ["a"] * 9, "of <U1; give real numbers"),
    ],
)
def test_what_makes_no_path_is_refused_in_one_line(q: Any, s: Any, message: str) -> None:
    for stop in (False, True):
        with pytest.raises(UsageError, match=message) as caught:
            tp.AxisPath.from_waypoints(q, s=s, stop=stop)
        assert "\n" not in str(caught.value)


def test_joint_names_must_be_as_many_as_the_joints() -> None:
    with pytest.raises(UsageError, match="2 joint names for 3 joints"):
        tp.AxisPath.from_waypoints(POINTS, joints=["a", "b"])


def test_waypoints_too_close_for_a_spline_are_named() -> None:
    s = np.cumsum([0.0, *[1.0, 1e-6] * 20])
    with pytest.raises(UsageError, match=r"q\[\d+\] lies too close to q\[\d+\]"):
        tp.AxisPath.from_waypoints(np.sin(s)[:, None], s=s)


@pytest.mark.sweep
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(2, 20),
    joints=st.integers(1, 7),
    spread=st.floats(0.0, 3.0),
    offset=st.floats(-100.0, 100.0),
    own=st.booleans(),
)
def test_random_waypoints_are_planned_within_the_limits_and_passed(
    seed: int, count: int, joints: int, spread: float, offset: float, own: bool
) -> None:
    random = np.random.default_rng(seed)
    q = offset + random.uniform(-1.0, 1.0, (count, joints)) * 10.0 ** random.uniform(-spread, 0.0, (count, 1))
    s = np.cumsum(10.0 ** random.uniform(-1.0, 0.0, count)) if own else None
    limits = tp.Limits(*(10.0 ** random.uniform(0.0, 1.0, joints) * scale for scale in (1.0, 4.0, 40.0)))
    trajectory = plan(tp.AxisPath.from_waypoints(q, s=s), limits, bound=False)
    assert trajectory.usage().worst <= 1.0001
    passed = trajectory.at(times_at(trajectory, chord_lengths(q) if s is None else s)).q
    np.testing.assert_allclose(passed, q, atol=1e-9, rtol=0)
    assert not trajectory.at([0.0, trajectory.duration]).qd[:, :].round(9).any()


# -- splines --

WAVE = CubicSpline(S, POINTS)
TAKEN: dict[str, Callable[[], Any]] = {
    "cubic": lambda: WAVE,
    "natural cubic": lambda: CubicSpline(S, POINTS, bc_type="natural"),
    "periodic cubic": lambda: CubicSpline(S, np.vstack([POINTS[:-1], POINTS[:1]]), bc_type="periodic"),
    "B-spline of degree 3": lambda: make_interp_spline(S, POINTS, k=3),
    "B-spline of degree 5": lambda: make_interp_spline(S, POINTS, k=5),
    "B-spline of degree 7": lambda: make_interp_spline(S, POINTS, k=7),
    "periodic B-spline": lambda: make_interp_spline(S, np.vstack([POINTS[:-1], POINTS[:1]]), k=5, bc_type="periodic"),
    "unclamped B-spline": lambda: BSpline(np.arange(15.0), RNG.normal(size=(9, 3)), 5),
    "smoothing B-spline": lambda: make_smoothing_spline(S, POINTS[:, 0]),
    "columns along the first axis": lambda: make_interp_spline(S, POINTS.T, k=5, axis=1),
    "parabola": lambda: PPoly(np.array([[[1.0, 2.0]], [[0.0, 1.0]], [[3.0, 4.0]]]), [0.0, 2.0]),
    "line": lambda: BSpline([0.0, 0.0, 1.0, 1.0], np.array([[0.0, 1.0], [2.0, 0.0]]), 1),
    "whole numbers": lambda: PPoly(np.array([[[1, 2]], [[0, 1]]]), [0, 2]),
}


@pytest.mark.parametrize("kind", TAKEN)
def test_a_spline_is_taken_as_it_is(kind: str) -> None:
    spline = TAKEN[kind]()
    run = tp.AxisPath.from_spline(spline).runs[0]
    inside = np.linspace(run.s0, run.s1, 1001)[1:-1]
    for order in range(4):
        wanted = np.asarray(spline(inside, order))
        wanted = wanted.T if kind.startswith("columns") else wanted.reshape(len(inside), -1)
        np.testing.assert_allclose(run.evaluate(inside)[order], wanted, atol=1e-9 * (1.0 + np.abs(wanted).max()))
    assert off_by_differences(run) < 1e-5
    assert run.evaluate(np.array([run.s0, run.s1])).shape == (4, 2, run.evaluate(inside[:1]).shape[2])


@pytest.mark.parametrize("kind", TAKEN)
def test_breaks_are_the_knots_where_the_third_derivative_jumps(kind: str) -> None:
    run = tp.AxisPath.from_spline(TAKEN[kind]()).runs[0]
    inner = run.hints[1:-1]
    before, after = (run.evaluate(s)[3] for s in (np.nextafter(inner, -np.inf), inner))
    jump = np.abs(after - before).max(axis=1, initial=0.0)
    size = np.abs(run.evaluate(run.hints)[3]).max()
    np.testing.assert_array_equal(run.breaks, inner[jump > 1e-6 * (size + 1.0)])
    if "cubic" in kind and "periodic" not in kind:
        # not-a-knot ends of the cubic spline are no knots
        assert len(run.breaks) == len(S) - (2 if kind.startswith("natural") else 4)
    if "degree 5" in kind:
        assert len(run.breaks) == 0


def test_the_end_of_a_periodic_spline_is_its_end() -> None:
    spline = TAKEN["periodic cubic"]()
    run = tp.AxisPath.from_spline(spline).runs[0]
    left = run.evaluate(np.array([S[-1]]))[3, 0]
    np.testing.assert_allclose(left, spline(S[-1] - 1e-9, 3), rtol=1e-6)


@pytest.mark.parametrize("kind", ["cubic", "periodic cubic", "B-spline of degree 5", "line", "parabola"])
def test_splines_are_planned_within_the_limits(kind: str) -> None:
    path = tp.AxisPath.from_spline(TAKEN[kind]())
    limits = tp.Limits(1.0, 4.0, 40.0, path.joints)
    trajectory = plan(path, limits)
    assert trajectory.usage().worst <= 1.0001
    assert trajectory.gap < 5e-3
    t = np.linspace(0.0, trajectory.duration, 20001)
    jerk = np.diff(trajectory.at(t).qdd, axis=0) / np.diff(t)[:, None]
    assert np.abs(jerk).max() <= 40.0 * 1.0002


def test_a_scalar_spline_is_a_path_of_one_joint() -> None:
    path = tp.AxisPath.from_spline(CubicSpline(S, POINTS[:, 0]), joints=["arm"])
    assert path.joints == ("arm",)
    np.testing.assert_allclose(path.runs[0].evaluate(S)[0], POINTS[:, :1], atol=1e-14)


CORNER = make_interp_spline(S, POINTS, k=1)


@pytest.mark.parametrize(
    ("spline", "what"),
    [
        (CORNER, "slope"),
        (BSpline(S, POINTS[:8], 0), "position"),
        (PPoly(np.array([[[0.0], [0.0]], [[1.0], [1.0]], [[0.0], [2.0]]]), [0.0, 1.0, 2.0]), "position"),
        (PchipInterpolator(S, POINTS), "curvature"),
        (Akima1DInterpolator(S, POINTS), "curvature"),
        (make_interp_spline(S, POINTS, k=2), "curvature"),
        (BSpline([0, 0, 0, 0, 0.5, 0.5, 1, 1, 1, 1], RNG.normal(size=(6, 2)), 3), "curvature"),
        (BSpline([0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1], RNG.normal(size=(7, 2)), 3), "slope"),
    ],
)
def test_a_spline_that_is_not_smooth_enough_is_refused_with_the_place(spline: Any, what: str) -> None:
    with pytest.raises(PathError, match=rf"the {what} of joint 1 jumps from .* at s = .*from_waypoints, or split it"):
        tp.AxisPath.from_spline(spline)


def test_a_corner_between_short_pieces_and_far_from_zero_is_seen_and_rounding_is_not() -> None:
    knots = np.array([0.0, 1.0, 1.001, 2.0])
    q = 1e4 + np.sin(3.0 * knots)[:, None]
    smooth = CubicSpline(knots, q)
    assert len(tp.AxisPath.from_spline(smooth).runs) == 1
    bent = PPoly(smooth.c.copy(), smooth.x)
    bent.c[2, 2] += 1e-5
    with pytest.raises(PathError, match=r"s = 1\.001"):
        tp.AxisPath.from_spline(bent)


@pytest.mark.parametrize(
    ("spline", "message"),
    [
        (
            BPoly.from_derivatives([0.0, 1.0], [[0.0, 1.0], [1.0, 0.0]]),
            "BPoly is no spline that is taken; give a BSpline",
        ),
        ((S, POINTS, 3), "tuple is no spline"),
        (np.sin, "from_callable"),
        (None, "NoneType is no spline"),
        (PPoly(np.ones((4, 1, 2)) * 1j, [0.0, 1.0]), "real numbers"),
        (BSpline([0.0, 0.0, 1.0, 1.0], np.array([[1j], [0.0]]), 1), "real numbers"),
        (CubicSpline(S, np.zeros((9, 2, 2))), r"shape \(2, 2\); give \(joints,\)"),
        (PPoly(np.ones((2, 2, 1)), [2.0, 1.0, 0.0]), "must ascend"),
        (PPoly(np.full((2, 1, 1), np.nan), [0.0, 1.0]), "not finite"),
    ],
)
def test_what_is_no_spline_of_joints_is_refused_in_one_line(spline: Any, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        tp.AxisPath.from_spline(spline)
    assert "\n" not in str(caught.value)


def test_waypoints_and_their_spline_are_the_same_path() -> None:
    still = np.zeros(3)
    spline = make_interp_spline(S, POINTS, k=5, bc_type=([(3, still), (4, still)],) * 2)
    one, other = tp.AxisPath.from_waypoints(POINTS, s=S), tp.AxisPath.from_spline(spline)
    t = np.linspace(S[0], S[-1], 301)
    jets, expected = one.runs[0].evaluate(t), other.runs[0].evaluate(t)
    # of each derivative's own size: where it passes zero, its last digit is that of what is around
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(jets / size, expected / size, rtol=0.0, atol=1e-12)
    assert repr(one) == repr(other) == "<AxisPath 1 run, 3 joints q1 q2 q3>"

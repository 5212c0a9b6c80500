"""Changes of path and pace: what a coordinate feels, and where knots of a change lie."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.tool_paths import toolpath_through
from toolpace.kernels.fit.quintic_spline import third_rows
from toolpace.motion.laws import LinearLaw
from toolpace.path.fit import tolerance_tube
from toolpace.path.fit.polyline import PlaceTolerances, polylines
from toolpace.path.fit.speed_weights import ACCELERATION, SpeedWeights, basis_derivatives
from toolpace.path.fit.spline import knots_of
from toolpace.planning.path_and_pace import local_refit
from toolpace.planning.path_and_pace.candidate_evaluation import CheapEvaluation
from toolpace.planning.path_and_pace.local_refit import where_it_matters
from toolpace.planning.path_and_pace.segment import QUICK, THOROUGH

TIP, AXIS = 10e-6, math.radians(0.05)


@pytest.mark.parametrize(("points", "swing"), [(300, 0.0), (3, 1e-3), (3, 0.2), (300, 0.2)])
def test_a_long_straight_way_is_fitted_again_without_a_million_samples(points, swing, monkeypatch):
    """Along a straight way the measure would put the points elsewhere on it, and few samples let the curve stray by 23
    tolerances between them: from there the tube's solver found back over a million samples, or not at all."""
    machine = tp.Machine.load("xyzbc-nutating")
    u = np.linspace(0.0, 1.0, points)[:, None]
    tip = np.hstack([1.2 * u - 0.6, 0.0 * u, swing * np.sin(3.0 * u)])
    way = toolpath_through(tip, np.hstack([np.sin(swing * u), 0.0 * u, np.cos(swing * u)]), feed=np.inf)
    first = tp.Path.fit(way, TIP, AXIS, machine)
    motion = tp.plan(first, machine, guard=False, bound=False)
    speed_weights = [law.speed_weights(0.03, 0.1, 6.0) for law in motion.laws]
    samples, look = [], tolerance_tube.deviations
    monkeypatch.setattr(tolerance_tube, "deviations", lambda *given: samples.append(len(given[2].s)) or look(*given))
    again = tp.Path.fit(way, TIP, AXIS, machine, speed_weights=speed_weights)
    assert max(samples) <= tolerance_tube.MORE_SAMPLES * samples[0] and len(samples) <= 8
    assert again.tip_deviation <= TIP and again.axis_deviation <= AXIS
    if swing == 0.0:
        assert all(np.array_equal(a.coefficients, b.coefficients) for a, b in zip(first.runs, again.runs))


def test_rows_are_what_a_coordinate_feels_in_time():
    """Against differences over time of a spline with any coefficients, passed at a pace that changes."""
    r = np.random.default_rng(4)
    breaks = np.concatenate([[0.0], np.cumsum(r.uniform(0.5, 2.0, 12))])
    x = r.standard_normal(len(breaks) + 4)
    inside = 0.5 * np.diff(breaks)[:, None] * np.array([1.0])
    b = basis_derivatives(breaks, inside)
    from scipy.interpolate import BSpline

    curve = BSpline(knots_of(breaks), x, 5)
    at = (breaks[:-1, None] + inside).ravel()
    for order, value in enumerate(b, 1):
        felt = [value[i, 0] @ x[i : i + 6] for i in range(len(at))]
        assert np.allclose(felt, curve.derivative(order)(at), rtol=1e-9, atol=1e-9)
    # at an even pace jerk is the third derivative, and power 6 counts places as they are long
    even = SpeedWeights(np.array([0.0, breaks[-1]]), np.array([[2.0, 2.0], [0.0, 0.0], [0.0, 0.0]]), 0.1, 6.0)
    rows, weight = even.rows(breaks, 1.0)
    assert np.allclose(weight, 1.0)
    third = third_rows(knots_of(breaks))
    cubic = np.array([np.mean(knots_of(breaks)[i + 1 : i + 6]) for i in range(len(x))])
    assert np.allclose(np.einsum("ika,ia->ik", third, windows(cubic)), 0.0, atol=1e-9)
    jerk = np.einsum("ika,ia->ik", rows[:, [0, 2]], windows(x))
    places = breaks[:-1, None] + 0.5 * np.diff(breaks)[:, None] * (1.0 + np.array([-1.0, 1.0]) / math.sqrt(3.0))
    right = curve.derivative(3)(places) * np.sqrt(0.5 * np.diff(breaks))[:, None]
    assert np.allclose(jerk, right, rtol=1e-8, atol=1e-8)
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    scale = ACCELERATION / (2.0 * 0.1) * np.sqrt(np.diff(breaks))
    acceleration = np.einsum("ia,ia->i", rows[:, 1], windows(x))
    assert np.allclose(acceleration, curve.derivative(2)(middle) * scale, rtol=1e-8, atol=1e-8)


def windows(x):
    """(cells, 6) the coefficients that matter in each cell."""
    return np.lib.stride_tricks.sliding_window_view(x, 6)


def test_the_pace_is_a_mean_over_time():
    """Of a constant acceleration it is the pace itself, and the acceleration, away from the ends."""
    law = LinearLaw(np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 4.0]))
    speed_weight = law.speed_weights(0.1, 0.1, 6.0)
    inner = (speed_weight.s > 0.1) & (speed_weight.s < 1.8)
    assert np.allclose(speed_weight.pace[0, inner], np.sqrt(2.0 * speed_weight.s[inner]))
    assert np.allclose(speed_weight.pace[1, inner], 1.0) and np.allclose(speed_weight.pace[2, inner], 0.0)
    assert speed_weight.pace[0].min() >= 0.02 * speed_weight.pace[0].max()
    twice = speed_weight.mean_with(SpeedWeights(speed_weight.s, 3.0 * speed_weight.pace, 0.1, 6.0))
    assert np.allclose(twice.pace, 2.0 * speed_weight.pace)


def test_knots_of_a_change_lie_where_the_motion_is_slower_than_its_feed():
    times, slower = np.linspace(0.0, 100.0, 10_001), np.zeros(10_001, dtype=bool)
    slower[4_000:4_100] = True
    needed = where_it_matters(times, slower)
    assert needed[3_980:4_120].all() and needed[0] and np.count_nonzero(needed) < 600
    gaps = np.diff(times[needed])
    near = np.maximum(np.abs(times[needed][:-1] - 40.5), 0.5)
    assert (gaps < 0.02 + 0.1 * near).all()
    assert np.count_nonzero(where_it_matters(times, np.zeros_like(slower))) < 50
    assert where_it_matters(times, ~np.zeros_like(slower)).all()


@pytest.fixture(scope="module")
def slow_then_corners():
    """A run of which the first part is passed at its feed, and the rest goes round corners, with knots of a change."""
    machine = tp.Machine.load("xyzac-trunnion")
    straight = "".join(f"G1 X{i}\n" for i in range(1, 9))
    corners = "".join(f"G1 X{8 + 2 * ((i + 1) // 2)} Y{2 * (i // 2 % 2)}\n" for i in range(1, 12))
    program = tp.read_text(f"G21 G94 F1500\nG1 X0 Y0 Z0 A5 C5\n{straight}{corners}", machine)
    path = tp.Path.fit(program, TIP, AXIS, machine)
    motion = tp.plan(path, machine, planner=CheapEvaluation())
    tolerances = PlaceTolerances.of(program, TIP, AXIS)
    line = polylines(program, tolerances, machine)[-1]
    scale, rapid = np.repeat([tolerances.tip, tolerances.axis], [3, 2]), program.rapid[line.entry]
    return local_refit.fitted_run(
        path.runs[-1], motion.axis_path.runs[-1], motion.laws[-1], line, rapid, scale, 0.1, QUICK
    )  # fmt: skip


def test_the_fewest_windows_that_hold_nine_tenths_of_the_lost_time_are_changed(slow_then_corners, monkeypatch):
    monkeypatch.setattr(local_refit, "WINDOW", 20)
    fitted = slow_then_corners
    stage = local_refit.windows(len(fitted.breaks) + 4, False)[0]
    chosen = local_refit.where_time_is_lost(fitted, stage)

    def lost(window):
        between = fitted.times[[max(window[0] - 5, 0), min(window[1], len(fitted.times) - 1)]]
        t = np.linspace(*between, 4001)
        s, speed = fitted.law.at(t)[:2]
        return np.trapezoid(1.0 - speed / fitted.joints.speed_cap(s), t)

    shares = {window: lost(window) for window in stage}
    held = sum(shares[window] for window in chosen) / sum(shares.values())
    assert 0.89 < held < 1.0 and len(chosen) < len(stage)
    assert held - min(shares[window] for window in chosen) / sum(shares.values()) < 0.91
    assert min(shares[window] for window in chosen) > 0.9 * max(shares[w] for w in stage if w not in chosen)
    assert local_refit.where_time_is_lost(fitted, []) == []
    assert local_refit.where_time_is_lost(replace(fitted, care=THOROUGH), stage) == stage


def test_cells_that_no_change_moves_keep_the_knots_of_the_run(slow_then_corners):
    from scipy.interpolate import BSpline

    fitted = slow_then_corners
    x = np.zeros((len(fitted.breaks) + 4, 6))
    x[40:60] = np.random.default_rng(3).standard_normal((20, 6))
    run = local_refit.with_change(fitted, x)
    changed = fitted.breaks[(fitted.breaks >= fitted.breaks[35]) & (fitted.breaks <= fitted.breaks[60])]
    assert np.array_equal(run.breaks, np.union1d(fitted.run.breaks, changed)) and len(run.breaks) < len(fitted.breaks)
    s = np.linspace(fitted.breaks[0], fitted.breaks[-1], 5001)
    before, after = fitted.run.evaluate(s), run.evaluate(s)
    moved = BSpline(knots_of(fitted.breaks), x[:, :5] * fitted.scale, 5)
    for order in range(4):
        there = moved.derivative(order)(s) if order else moved(s)
        size = 1e-9 * np.abs(there).max()
        assert np.allclose(after.tip[order] - before.tip[order], there[:, :3], rtol=1e-7, atol=size)
        assert np.allclose(after.rotary[order] - before.rotary[order], there[:, 3:], rtol=1e-7, atol=size)


def test_a_run_that_its_feeds_make_long_is_not_cut_into_a_billion_pieces(machine, monkeypatch):
    """One millimetre a minute beside twenty metres: knots of a change are counted by time."""
    slow = "G21 G94\nG0 X0 Y0 Z0\n" + "".join(f"G1 X{5 * i} Y{i % 2} F{20000 if i % 2 else 1}\n" for i in range(1, 6))
    program = tp.read_text(slow, machine)
    path = tp.Path.fit(program, TIP, AXIS, machine)
    motion = tp.plan(path, machine, planner=CheapEvaluation())
    assert motion.duration < 2.0 * program.least_duration
    monkeypatch.setattr(local_refit, "fitted_run", None)
    monkeypatch.setattr(local_refit, "MOST", 10_000)
    tolerances = PlaceTolerances.of(program, TIP, AXIS)
    assert local_refit.refitted(program, machine, path, motion, tolerances, 0.1, QUICK).runs == path.runs

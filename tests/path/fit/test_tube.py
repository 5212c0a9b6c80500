"""The fit stays in its tube, whatever the program, and keeps stops, blocks and feeds."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.support.tool_paths import random_toolpath, spiral, tilted, toolpath_through
from toolpace.common import workers
from toolpace.common.errors import PathError
from toolpace.machine.machine import Machine
from toolpace.path.fit import spline as sampling
from toolpace.path.fit import tolerance_tube as fitting
from toolpace.path.fit.polyline import PlaceTolerances, great_circle, polylines
from toolpace.path.fit.smoothest_spline import first_breaks
from toolpace.path.fit.speed_weights import SpeedWeights
from toolpace.path.path import Path

TIP, AXIS = 10e-6, 1e-3
MACHINE = Machine.load("xyzac-trunnion")


def curve(path, per_cell=24):
    """Dense points (n, 3) and tool axes (n, 3) of each run."""
    for run in path.runs:
        u = np.arange(per_cell) / per_cell
        s = np.append((run.breaks[:-1, None] + np.diff(run.breaks)[:, None] * u).ravel(), run.s1)
        jet = run.evaluate(s)
        yield jet.tip[0], MACHINE.axis_at(jet.rotary[0]) if jet.axis is None else jet.axis[0]


GROUP = 16
"""Points next to each other whose distances are worked out together."""


def to_segments(points, ends):
    """Distance (n,) of points (n, 3) to a polyline (k, 3).

    A group of points within r of its middle is compared with all segments that are nearly as near to the middle as the
    nearest one, by 2 r: no other can be nearest to one of its points.
    """
    ways = np.diff(ends, axis=0)
    moves = ways.any(axis=1)
    moves[0] = True
    starts, ways = ends[:-1][moves].T[:, None], ways[moves].T[:, None]
    square = np.maximum(np.sum(ways * ways, axis=0), 1e-300)

    def squares(points, near):
        """(n, k) squared distances; each of x, y and z is an array of its own, which is many times as fast."""
        off, way = points.T[:, :, None] - starts[:, :, near], ways[:, :, near]
        off -= np.clip(np.sum(off * way, axis=0) / square[:, near], 0.0, 1.0) * way
        return np.sum(off * off, axis=0)

    best = []
    for group in np.array_split(points, len(points) // GROUP + 1):
        middle = group.mean(axis=0)
        around = np.sqrt(squares(middle[None], slice(None))[0])
        near = around <= around.min() + 2.0001 * np.linalg.norm(group - middle, axis=1).max()
        best.append(squares(group, near).min(axis=1))
    return np.sqrt(np.concatenate(best))


def assert_in_tube(path, toolpath, axis_slack=1.02):
    """Hausdorff distances of tip and axis both ways, by brute force and without the fit's own parameter."""
    stops = np.flatnonzero(toolpath.stop)
    pieces = [
        (a, b)
        for a, b in pairwise(stops)
        if np.any(toolpath.tip[a : b + 1] != toolpath.tip[a])
        or np.any(np.abs(toolpath.axis[a : b + 1] - toolpath.axis[a]) > 1e-12)
    ]
    assert len(pieces) == len(path.runs)
    for (a, b), (tip, axis) in zip(pieces, curve(path)):
        assert np.max(to_segments(tip, toolpath.tip[a : b + 1])) <= TIP
        assert np.max(to_segments(toolpath.tip[a : b + 1], tip)) <= TIP
        assert np.max(to_segments(toolpath.axis[a : b + 1], axis)) <= AXIS * axis_slack
        assert tip[0] == pytest.approx(toolpath.tip[a], abs=1e-12)
        assert tip[-1] == pytest.approx(toolpath.tip[b], abs=1e-12)
        assert axis[-1] == pytest.approx(toolpath.axis[b], abs=1e-9)
    assert path.tip_deviation <= TIP
    assert path.axis_deviation <= AXIS


@pytest.mark.parametrize("block", [0, *(pytest.param(k, marks=pytest.mark.sweep) for k in range(1, 10))])
def test_a_hundred_nasty_programs(block):
    for seed in range(1000 + 10 * block, 1010 + 10 * block):
        toolpath, _ = random_toolpath(seed)
        assert_in_tube(Path.fit(toolpath, TIP, AXIS), toolpath)


@pytest.mark.parametrize("block", [0, *(pytest.param(k, marks=pytest.mark.sweep) for k in range(1, 4))])
def test_nasty_programs_in_joints(block):
    for seed in range(10 * block, 10 * block + 10):
        toolpath, rotary = random_toolpath(seed)
        joints = np.stack([rotary[:, 1], -rotary[:, 0]], axis=1)
        given = replace(toolpath, rotary=joints, rotary_joints=("C", "A"), axis=MACHINE.axis_at(joints))
        for program in (toolpath, given):
            path = Path.fit(program, TIP, AXIS, machine=MACHINE)
            assert_in_tube(path, program)
            assert path.runs[0].evaluate(path.runs[0].breaks[:1]).rotary is not None


def up(n):
    return np.tile([0.0, 0.0, 1.0], (n, 1))


def apex_distance(path, corner):
    return min(np.min(np.linalg.norm(tip - corner, axis=1)) for tip, _ in curve(path, 50))


def test_a_right_angle_between_long_blocks_is_rounded_within_tolerance():
    toolpath = toolpath_through([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0]], up(3))
    path = Path.fit(toolpath, TIP, AXIS)
    assert_in_tube(path, toolpath)
    assert 0.5 * TIP < apex_distance(path, [0.1, 0, 0]) <= TIP
    assert len(path.runs) == 1 and len(path.runs[0].breaks) < 120


@pytest.mark.parametrize("n", [60, 200, pytest.param(600, marks=pytest.mark.sweep)])
@pytest.mark.parametrize("chords", [0.95, 1.0, 1.05])
def test_a_polygon_whose_chords_leave_the_circle_by_the_tolerance(n, chords):
    """Each vertex is nearly bad for the first spline; halving a cell must not creep from one to the next."""
    radius = 35 * TIP
    turn = 4.0 * np.sqrt(chords * TIP / 2.0 / radius) * np.arange(n)
    tip = (radius + 2e-8 * np.arange(n))[:, None] * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    toolpath = toolpath_through(np.concatenate([[[0, 0, 5e-3]], np.round(tip, 6)]), up(n + 1))
    assert_in_tube(Path.fit(toolpath, TIP, AXIS), toolpath)


def test_a_reversal():
    toolpath = toolpath_through([[0, 0, 0], [0.05, 0, 0], [0.01, 0, 0]], up(3))
    path = Path.fit(toolpath, TIP, AXIS)
    assert_in_tube(path, toolpath)
    assert apex_distance(path, [0.05, 0, 0]) > 0.5 * TIP


def test_rotation_in_place_has_length():
    a = np.linspace(0.1, 0.8, 30)
    toolpath = toolpath_through(np.zeros((30, 3)), tilted(a, 0.3))
    for machine in (None, MACHINE):
        path = Path.fit(toolpath, TIP, AXIS, machine=machine)
        assert_in_tube(path, toolpath)
        assert path.runs[0].s1 == pytest.approx(0.7 * TIP / AXIS, rel=0.01)


def test_turn_of_the_table_at_the_pole():
    joints = np.stack([np.linspace(0, 2, 9), np.zeros(9)], axis=1)
    toolpath = toolpath_through(np.tile([0.01, 0.0, 0.0], (9, 1)), up(9), rotary=joints, joints=("C", "A"))
    run = Path.fit(toolpath, TIP, AXIS, machine=MACHINE).runs[0]
    assert run.evaluate(np.array([run.s1])).rotary[0][0] == pytest.approx([2.0, 0.0])
    assert run.s1 > 0


def test_fits_within_the_same_tolerances_share_what_no_weight_changes():
    """A corner, and a straight way after a stop: fits for two motions are those that were made alone, and the straight
    run is fitted once."""
    corner = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.02, 0.02, 0.0]])
    way = np.concatenate([corner, [[0.02, 0.02, 0.03]]])
    stop = np.array([True, False, True, True])
    toolpath = replace(toolpath_through(way, up(4)), stop=stop)
    fit = fitting.TubeFit(toolpath, TIP, AXIS, None)
    s = np.linspace(0.0, 0.04, 50)
    still = np.zeros(50)
    for speed in (0.01 + s, 0.06 - s):
        weights = [SpeedWeights(s, np.stack([speed, still, still]), 0.05, 6.0)] * 2
        runs = fit.runs(None, weights)[0]
        alone = Path.fit(toolpath, TIP, AXIS, speed_weights=weights)
        for one, other in zip(runs, alone.runs):
            assert np.array_equal(one.breaks, other.breaks)
            assert np.array_equal(one.coefficients, other.coefficients)
        assert runs[1] is fit.runs(None)[0][1]
        assert not np.array_equal(runs[0].coefficients, fit.runs(None)[0][0].coefficients)


def test_a_straight_line_stays_straight():
    rng = np.random.default_rng(0)
    x = np.sort(np.concatenate([[0, 0.05], rng.uniform(0, 0.05, 300)]))
    toolpath = toolpath_through(np.stack([x, 2 * x, -x], axis=1), up(302))
    run = Path.fit(toolpath, TIP, AXIS).runs[0]
    jet = run.evaluate(np.linspace(run.s0, run.s1, 500))
    assert np.max(np.abs(jet.tip[3])) < 1.0
    assert np.max(np.abs(jet.tip[2])) < 0.01


def test_one_block():
    toolpath = toolpath_through([[0, 0, 0], [1e-6, 0, 0]], up(2))
    assert_in_tube(Path.fit(toolpath, TIP, AXIS), toolpath)


def test_stops_dwells_blocks_and_repeated_points():
    tip = np.array([[0, 0, 0], [0, 0, 0], [0.01, 0, 0], [0.01, 0, 0], [0.02, 0.01, 0], [0.03, 0.01, 0]])
    toolpath = toolpath_through(tip, up(6), stops=(2, 3), dwells={2: 1.0, 3: 0.5})
    path = Path.fit(toolpath)
    assert [run.dwell for run in path.runs] == [1.5, 0.0]
    assert [list(run.block) for run in path.runs] == [[3], [5, 6]]
    assert [run.s0 for run in path.runs] == [0.0, 0.0]
    for run in path.runs:
        assert run.block_start[0] == run.s0 and run.block_start[-1] == pytest.approx(run.s1)
        assert len(run.feed) == len(run.least_time) == len(run.block) == len(run.block_start) - 1
        assert np.all(np.diff(run.breaks) > 0)


def test_dwells_before_anything_moves_are_kept():
    tip = np.array([[0, 0, 0], [0, 0, 0], [0.01, 0, 0], [0.02, 0, 0]])
    path = Path.fit(toolpath_through(tip, up(4), stops=(1, 2), dwells={0: 0.25, 1: 0.5, 3: 2.0}))
    assert path.first_dwell == 0.75
    assert [run.dwell for run in path.runs] == [0.0, 2.0]


def test_nothing_moves():
    with pytest.raises(PathError, match="nothing moves"):
        Path.fit(toolpath_through(np.zeros((3, 3)), up(3)))


def test_an_axis_that_turns_half_round_is_named():
    toolpath = toolpath_through([[0, 0, 0], [0.01, 0, 0]], [[0, 0, 1], [0, 0, -1]])
    with pytest.raises(PathError, match="tool path:2"):
        Path.fit(toolpath)
    steps = np.arange(4)[:, None] * [[0.01, 0.0, 0.0]]
    with pytest.raises(PathError, match="tool path:3: the tool axis turns by half a turn in one block"):
        Path.fit(toolpath_through(steps, [[0, 0, 1], [0, 0.1, 1], [0, -0.1, -1], [0, 0, -1]]))


@pytest.mark.parametrize("angle", [1e-9, 1e-7, 9e-7, 1.1e-6, 1e-3, 1.0, 3.0])
def test_a_share_of_the_way_from_axis_to_axis_is_that_share_of_the_turn(angle):
    """However small the turn is."""
    share = np.array([[0.0], [0.25], [0.5], [1.0]])
    low, high = np.tile([0.0, 0.0, 1.0], (4, 1)), np.tile([np.sin(angle), 0.0, np.cos(angle)], (4, 1))
    between = great_circle(low, high, share)
    assert np.arctan2(between[:, 0], between[:, 2]) == pytest.approx(share[:, 0] * angle, rel=1e-9, abs=1e-15)
    assert np.linalg.norm(between, axis=1) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("seed", [2, 5, 7])
def test_progress_never_falls_and_ends_at_one(seed, monkeypatch):
    """Nor where the curve has to be smoothed once more."""
    # however fast the machine is, it shall be heard of what happens before the end
    monkeypatch.setattr(workers, "BREATH", 1e-4)
    seen: list[float] = []
    Path.fit(random_toolpath(seed)[0], progress=seen.append)
    assert len(seen) > 1 and seen[-1] == 1.0
    assert seen == sorted(seen)


def test_the_same_bits_on_one_core_and_on_many(monkeypatch):
    toolpath = spiral(6000)
    curves = []
    for cores in (1, 2, 7):
        monkeypatch.setattr(os, "cpu_count", lambda cores=cores: cores)
        curves.append(Path.fit(toolpath, TIP, AXIS).runs[0])
    for other in curves[1:]:
        assert np.array_equal(curves[0].breaks, other.breaks)
        assert np.array_equal(curves[0].coefficients, other.coefficients)


def test_what_is_known_of_a_sample_is_not_worked_out_again(monkeypatch):
    """Only the samples that are new are, and what comes of it is the same."""
    toolpath = spiral(60)
    (line,) = polylines(toolpath, PlaceTolerances.of(toolpath, TIP, AXIS), None)
    breaks = first_breaks(line)
    previous, finer = sampling.sample(line, breaks, AXIS, None), np.union1d(breaks, breaks[:-1] + 0.3 * np.diff(breaks))
    fresh = sampling.sample(line, finer, AXIS, None)
    true, asked = sampling.turn_metric, []

    def turn_metric(turn, *others):
        asked.append(len(turn))
        return true(turn, *others)

    monkeypatch.setattr(sampling, "turn_metric", turn_metric)
    again = sampling.sample(line, finer, AXIS, None, previous=previous)
    assert asked == [len(np.setdiff1d(again.s, previous.s))] and 0 < asked[0] < len(again.s)
    assert np.array_equal(again.s, fresh.s) and np.array_equal(again.metric, fresh.metric)


def test_a_curve_of_nan_is_never_taken(monkeypatch):
    """Whatever smoothing does, the checks see it, and the first spline remains."""

    def poison(spline, *others):
        spline.tip[5] = np.nan

    monkeypatch.setattr(fitting, "tighten", poison)
    toolpath = spiral(300)
    path = Path.fit(toolpath, TIP, AXIS)
    assert np.all(np.isfinite(path.runs[0].coefficients))
    assert_in_tube(path, toolpath)


def test_a_curve_that_came_to_no_end_outside_the_tube_is_not_taken(monkeypatch):
    """It strays at one place of a window alone; the curve before it stays as it was, and is checked as ever."""
    from toolpace.kernels.fit import smoothest as kernel

    true, kept = fitting.tighten, []

    def endless(rough, samples, tube, moved, free, floor, accuracy, steps):
        moved[len(moved) // 2] += 100.0
        return steps, 0.0, 0.0

    def tighten(spline, *others):
        before = spline.tip.copy(), spline.turn.copy()
        true(spline, *others)
        kept.append(np.array_equal(before[0], spline.tip) and np.array_equal(before[1], spline.turn))

    monkeypatch.setattr(kernel, "smoothest", endless)
    monkeypatch.setattr(fitting, "tighten", tighten)
    toolpath = spiral(300)
    assert_in_tube(Path.fit(toolpath, TIP, AXIS), toolpath)
    assert kept and all(kept)


def test_rotary_words_are_passed_over_without_a_machine():
    """Points are put in where the axis turns; joints of a machine that is not there have none."""
    toolpath = toolpath_through(np.linspace((0.0, 0.0, 0.0), (0.02, 0.0, 0.0), 2), tilted(np.array([0.0, 0.7]), 0.3))
    turning = replace(toolpath, rotary=np.array([[0.0, 0.3], [0.7, 0.3]]), rotary_joints=("A", "C"))
    path, same = (Path.fit(each, TIP, AXIS) for each in (turning, toolpath))
    assert path.axis_deviation == same.axis_deviation <= AXIS


def test_smoothing_gives_up_on_nan():
    from toolpace.kernels.fit import smoothing_spline as kernel
    from toolpace.kernels.fit.quintic_spline import basis_rows, third_rows
    from toolpace.kernels.fit.smoothest import smoothest

    knots = np.concatenate([np.zeros(5), np.linspace(0.0, 400.0, 21), np.full(5, 400.0)])
    s = np.linspace(0.0, 400.0, 81)
    target = np.stack([s, np.sin(s / 50.0), np.zeros(81)], axis=1)
    target[40, 1] = np.nan
    metric = np.tile(np.eye(3), (81, 1, 1))
    x = np.zeros((25, 3))
    steps, _, _ = smoothest(
        kernel.Roughness(third_rows(knots), np.ones(3)), kernel.Samples(*basis_rows(knots, s), target, metric),
        kernel.Tube(np.ones(81), np.full(81, 1e-9)), x, kernel.Free(1, 24), np.full(20, 1e-9), 0.02, 80,
    )  # fmt: skip
    assert steps < 0

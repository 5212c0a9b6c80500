"""The model `lookahead`: against motions worked out by hand, and what no figure may do."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.timed_programs import MACHINE, A, J, machine, timed
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.kernels import controls
from toolpace.programs.reading import Source, read_commanded


def test_a_line_from_rest_to_rest():
    feed, way = 0.1, 0.2
    time = timed("G1 X200 F6000\n")
    assert time.total == pytest.approx(way / feed + feed / A + A / J)


def test_a_line_too_short_for_its_feed():
    time = timed("G1 X1 F6000\n")
    # acceleration is not reached: a ramp to v takes 2 sqrt(v / j) in place of v / a
    v = math.sqrt(1e-3 * A)
    assert v < A**2 / J
    assert time.total == pytest.approx(2.0 * math.sqrt(1e-3 / A) + 2.0 * math.sqrt(v / J) - v / A)


def test_more_acceleration_is_never_slower():
    totals = [timed("G1 X10 F600\nG4 P1\nG1 X0\n", on=machine(a)).total for a in (0.1, 1.0, 10.0, 1e4, 1e8)]
    assert all(b <= a * (1.0 + 1e-9) for a, b in pairwise(totals))


def test_a_right_corner_is_passed_at_the_speed_that_its_tolerance_allows():
    """Both axes change by v: sqrt(2) v^2 / (8 a) off the corner at constant acceleration."""
    free = figures_of({"tolerance": 0.05, "jerk": 1e6}, "", "lookahead")
    feed, way, room = 0.1, 0.05, 50e-6
    v = math.sqrt(8.0 * room * A / math.sqrt(2.0))
    slowing = (feed - v) ** 2 / (2.0 * A * feed)  # what a ramp from feed to v loses
    expected = 2.0 * way / feed + feed / A + 2.0 * slowing
    assert timed("G1 X50 F6000\nG1 Y50\n", free).total == pytest.approx(expected, abs=1e-5)
    # the tolerance of the program goes before that of the control
    assert timed("G64 P0.05\nG1 X50 F6000\nG1 Y50\n", figures_of({"tolerance": 9.0, "jerk": 1e6}, "")).total == (
        pytest.approx(expected, abs=1e-5)
    )


def test_exact_stops_cost_a_stop_each():
    straight = timed("G1 X50 F6000\nG1 X100\n").total
    assert straight == pytest.approx(timed("G1 X100 F6000\n").total)
    assert timed("G61\nG1 X50 F6000\nG1 X100\n").total == pytest.approx(straight + 0.1 / A + A / J)


def test_an_arc_is_as_fast_as_its_radius_allows():
    radius = 2e-3
    time = timed("G1 X2 F30000\nG3 X2 Y0 I-2 J0\n")
    assert time.times[2] >= 2.0 * math.pi * radius / math.sqrt(A * radius)
    # chords of it are as fast: the corners between them hold the same
    turn = np.linspace(0.0, 2.0 * math.pi, 721)[1:]
    chords = "".join(f"G1 X{2 * math.cos(a):.7f} Y{2 * math.sin(a):.7f}\n" for a in turn)
    assert timed(f"G1 X2 F30000\n{chords}").total == pytest.approx(time.total, rel=0.05)


def test_in_tip_mode_the_joints_hold_and_not_the_words():
    """A turns the table: the tip stands in the part, and Y and Z must follow it."""
    body = "G43.4 H1\nG0 X0 Y100 Z50 A0\nG1 A60 F10000\n"
    on = machine()
    text = f"G21 G90 G94\nG0 X0 Y0 Z100 A0 C0\n{body}M30\n"
    moves = read_commanded(Source.from_text(text, "part.nc"), on)
    joints, words = (
        time_of_moves(moves, on, figures_of({"limits": each}, "")).times[-1] for each in ("joints", "words")
    )
    assert joints > 1.05 * words


def test_dwells_rapids_and_tools_are_told_apart():
    text = "G21 G90 G94\nG0 X0 Y0 Z10\nT1 M6\nG1 X10 F600\nG4 P2\nT2 M6\nG0 X20\nG1 X30\nM2\n"
    moves = read_commanded(Source.from_text(text, "part.ngc"), MACHINE)
    time = time_of_moves(moves, MACHINE, figures_of({}, ""), tool_change=8.0)
    assert [part.tool for part in time.parts if part.time] == ["1", "2"]
    assert time.sum("dwell") == pytest.approx(2.0)
    assert time.sum("tool_change") == pytest.approx(16.0)
    assert time.total == pytest.approx(sum(time.sum(kind) for kind in ("cutting", "rapid", "dwell", "tool_change")))
    assert time.times.sum() + 16.0 == pytest.approx(time.total)


def test_slower_reading_and_less_look_ahead_are_never_faster():
    turn = np.linspace(0.0, 1.0, 200)[1:]
    blocks = "".join(f"G1 X{100 * u:.4f} Y{3 * math.sin(9 * u):.4f}\n" for u in turn)
    body = f"F20000\n{blocks}"
    total = [timed(body, figures_of({"look_ahead": n}, "")).total for n in (0, 400, 100, 20, 5, 1)]
    assert total[0] == pytest.approx(total[1])
    assert all(a <= b * (1.0 + 1e-12) for a, b in pairwise(total))
    assert total[-1] > 1.2 * total[0]
    slow = timed(body, figures_of({"block_time": 0.02}, "")).total
    assert slow >= len(turn) * 0.02


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6))
def test_speeds_of_random_moves_can_be_driven(seed: int):
    rng = np.random.default_rng(seed)
    n, axes = int(rng.integers(3, 40)), 3
    cruise, length = rng.uniform(0.01, 1.0, n), rng.uniform(1e-5, 0.05, n)
    direction = rng.normal(size=(n, axes))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    stop, along = rng.random(n) < 0.1, rng.uniform(0.5, 5.0, n)
    room, limit, jerk = rng.uniform(1e-6, 1e-3, n), rng.uniform(1.0, 5.0, axes), rng.uniform(10.0, 500.0, axes)
    begin, end = controls.corner_speeds(
        cruise, length, direction, direction.copy(), stop, room, limit, jerk, np.ones(axes)
    )
    asked = begin.copy(), end.copy()
    controls.ramps(cruise, length, along, begin, end, int(rng.choice([0, 1, 5, 50])))
    assert (begin <= asked[0] + 1e-15).all() and (end <= asked[1] + 1e-15).all()
    assert (begin >= 0.0).all() and (end[stop] == 0.0).all()
    np.testing.assert_allclose(end[1:-1], begin[2:], atol=1e-12)  # one path, one speed at each corner
    assert (np.abs(end**2 - begin**2)[1:] <= (2.0 * along * length * (1.0 + 1e-9) + 1e-15)[1:]).all()
    times = controls.times_of(cruise, length, along, begin, end)
    assert (times[1:] >= length[1:] / cruise[1:] * (1.0 - 1e-12)).all()
    # the change at a corner, taken as fast as the axes can, stays within its room
    for i in range(1, n - 1):
        change = np.abs(direction[i + 1] - direction[i]) * asked[1][i]
        by_jerk = 2.0 * math.sqrt((change / jerk).max())
        assert np.linalg.norm(change) * (change / limit).max() / 8.0 <= room[i] * (1.0 + 1e-9)
        assert np.linalg.norm(change) * by_jerk / 12.0 <= room[i] * (1.0 + 1e-9)
        assert (change / limit).max() * asked[1][i] <= min(length[i], length[i + 1]) * (1.0 + 1e-9)

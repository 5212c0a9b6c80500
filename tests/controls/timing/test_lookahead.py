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
from toolpace.kernels.controls.rounding import deviation, rounded_speeds
from toolpace.programs.reading import Source, read_commanded


def test_a_line_from_rest_to_rest():
    feed, way = 0.1, 0.2
    time = timed("G1 X200 F6000\n")
    assert time.total == pytest.approx(way / feed + feed / A + A / J)


def test_a_line_too_short_for_its_feed():
    time = timed("G1 X1 F6000\n")
    # four phases of jerk: the acceleration is not reached
    assert time.total == pytest.approx(4.0 * (1e-3 / (2.0 * J)) ** (1.0 / 3.0))


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


def test_a_corner_takes_three_phases_within_its_tolerance():
    """Against the way by the trapezoidal rule, where the acceleration is reached and where it is not."""
    limit, sharpest = np.array([A, 0.5 * A]), np.array([J, 3.0 * J])
    for speed, turned in ((0.01, math.radians(30)), (0.1, math.radians(90)), (1.0, math.radians(150))):
        change = np.abs([math.cos(turned) - 1.0, math.sin(turned)])
        jump = speed * change
        period = max((jump / limit).max(), math.sqrt((jump / sharpest).max()))
        phase = (jump / sharpest).max() / period
        t = np.linspace(0.0, period + phase, 20001)
        share = np.minimum(np.minimum(t, t[-1] - t) / phase, 1.0) / period
        # of each axis: its acceleration and jerk stay within its limits, and one of these is reached
        peaks = np.concatenate([jump / period / limit, jump / (period * phase) / sharpest])
        assert peaks.max() == pytest.approx(1.0)
        velocity = np.concatenate([[0.0], np.cumsum(0.5 * (share[1:] + share[:-1]) * np.diff(t))])
        assert velocity[-1] == pytest.approx(1.0, rel=1e-6)
        middle = len(t) // 2
        late = np.trapezoid(velocity[: middle + 1], t[: middle + 1])
        found = deviation(speed, change, float(np.linalg.norm(change)), limit, sharpest)
        assert found == pytest.approx(np.linalg.norm(jump) * late, rel=1e-5)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6))
def test_roundings_of_random_moves_stay_within_their_tolerance(seed: int):
    rng = np.random.default_rng(seed)
    n, axes = int(rng.integers(3, 40)), 3
    cruise, length = rng.uniform(0.01, 1.0, n), rng.uniform(1e-5, 0.05, n)
    direction = rng.normal(size=(n, axes))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    stop = rng.random(n) < 0.1
    room, limit, jerk = rng.uniform(1e-6, 1e-3, n), rng.uniform(1.0, 5.0, axes), rng.uniform(10.0, 500.0, axes)
    speeds = rounded_speeds(cruise, length, direction, direction.copy(), stop, room, limit, jerk, np.ones(axes))
    assert (speeds[stop] == 0.0).all()
    for i in range(1, n - 1):
        change = np.abs(direction[i + 1] - direction[i]) * speeds[i]
        if speeds[i] > 0.0:
            assert (np.linalg.norm(change) / 12.0) * max(
                (change / limit).max(), 2.0 * math.sqrt((change / jerk).max())
            ) <= room[i] * (1.0 + 1e-9)
        assert (change / limit).max() * speeds[i] <= min(length[i], length[i + 1]) * (1.0 + 1e-9)
        assert stop[i] or speeds[i] > 0.0

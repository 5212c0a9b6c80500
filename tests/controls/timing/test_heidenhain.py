"""The model `heidenhain`: each rule of its manual against a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.timed_programs import A, J, machine, timed
from toolpace.controls.timing.figures import ControlFigures, figures_of
from toolpace.controls.timing.heidenhain import half_filters
from toolpace.controls.timing.program_time import MODELS, time_of_moves
from toolpace.kernels.jerk_ramp import ramp_distance, ramp_time
from toolpace.programs.reading import Source, read_commanded

FEED = 0.1
"""Of the programs, F6000 [m/s]."""
LENGTH = 0.02
"""Of the filter, where a test sets it [s]."""


def figures(tolerance: float = 0.01, **own: float) -> ControlFigures:
    return figures_of({"tolerance": tolerance, "heidenhain": {"filter_time": LENGTH} | own}, "", "heidenhain")


def line_to(speed: float, way: float = 0.05) -> float:
    """A line along one axis from rest to a speed, by way of F."""
    slow, fast = ramp_distance(speed, FEED, A, J), ramp_distance(0.0, FEED, A, J)
    return ramp_time(FEED, A, J) + ramp_time(FEED - speed, A, J) + (way - slow - fast) / FEED


def filtered(signal: np.ndarray, count: int) -> np.ndarray:
    """A signal through two moving averages of `count` samples: a triangle of 2 `count`."""
    box = np.ones(count) / count
    return np.convolve(np.convolve(signal, box, mode="valid"), box, mode="valid")


def test_a_line_ends_later_by_the_length_of_the_filter():
    line = 0.2 / FEED + FEED / A + A / J
    assert timed("G1 X200 F6000\n", figures()).total == pytest.approx(line + LENGTH)
    assert timed("G61.1\nG1 X100 F6000\nX200\n", figures()).total == pytest.approx(line + FEED / A + A / J + 2 * LENGTH)


def test_jerk_of_the_path_and_of_rapids():
    slow = timed("G1 X200 F6000\n", figures(path_jerk=10.0)).total
    assert slow == pytest.approx(0.2 / FEED + 2.0 * math.sqrt(FEED / 10.0) + LENGTH)
    rapid = [timed("G0 X400\n", figures(path_jerk_rapid=jerk, axis_jerk_rapid=5.0)).total for jerk in (J, 5.0 * J, 1e6)]
    assert rapid[0] - rapid[1] == pytest.approx(0.8 * A / J)
    assert rapid[2] == pytest.approx(rapid[1])


@pytest.mark.parametrize("degrees", [30, 90, 150])
def test_a_corner_is_so_slow_that_the_filter_stays_within_the_tolerance(degrees: float):
    """The deviation of a corner behind the filter, sampled, is the tolerance; axis limits are far."""
    turn, room, half = math.radians(degrees), 0.001, 0.5 * LENGTH
    change = np.array([math.cos(turn) - 1.0, math.sin(turn)])
    speed = 6.0 * room * 1e-3 / (np.linalg.norm(change) * half)
    assert speed * np.abs(change).max() < min(A * half, J * half**2)
    x, y = 50.0 + 50.0 * math.cos(turn), 50.0 * math.sin(turn)
    found = timed(f"G1 X50 F6000\nX{x:.9f} Y{y:.9f}\n", figures(room, least_corner_feed=0.0))
    assert found.times[1] == pytest.approx(line_to(speed), rel=1e-6)
    count = 1000
    t = (np.arange(8 * count + 1) - 4 * count) * half / count
    late = [filtered(axis * speed * np.maximum(t, 0.0), count) for axis in change]
    middle = (len(late[0]) - 1) // 2
    assert math.hypot(late[0][middle], late[1][middle]) == pytest.approx(room * 1e-3, rel=2e-3)


def test_behind_the_filter_no_axis_exceeds_its_jerk():
    """With a wide tolerance the corner is limited by j h^2: the filter's kernel changes by 1 / h^2."""
    speed = J * (0.5 * LENGTH) ** 2
    assert speed < A * 0.5 * LENGTH
    assert timed("G1 X50 F6000\nY50\n", figures(1.0)).times[1] == pytest.approx(line_to(speed), rel=1e-6)


def test_corners_are_not_slower_than_the_least_corner_feed():
    expected = line_to(600.0 / 6e4)
    assert timed("G1 X50 F6000\nX0 Y0.001\n", figures(1e-4, least_corner_feed=600.0)).times[1] == pytest.approx(
        expected, rel=1e-6
    )


def test_a_circle_is_so_slow_that_the_filter_stays_within_the_tolerance():
    """By v^2 h^2 / (12 r), and not slower than the least feed of the path."""
    radius, room, half = 2e-3, 1e-6, 0.5 * LENGTH
    arcs = "G1 X2 F60000\n" + 5 * "G3 X2 Y0 I-2 J0\n"
    speed = math.sqrt(12.0 * radius * room) / half
    assert speed**2 / radius < A
    around = 2.0 * math.pi * radius
    assert timed(arcs, figures(1e3 * room)).times[4] == pytest.approx(around / speed)
    count = 2000
    t = (np.arange(6 * count + 1) - 3 * count) * half / count
    inside = filtered(radius * np.cos(speed / radius * t), count)
    assert radius - inside[(len(inside) - 1) // 2] == pytest.approx(room, rel=0.01)
    least = 60.0 * speed * 1e3 * 1.1
    assert timed(arcs, figures(1e3 * room, least_path_feed=least)).times[4] == pytest.approx(around / (1.1 * speed))


def test_where_a_line_meets_an_arc_the_jerk_behind_the_filter_is_that_of_the_axes():
    radius = 0.002
    speed = math.sqrt(J * 0.5 * LENGTH * radius)
    assert speed < FEED
    body = "G1 X50 F6000\nG3 X52 Y2 I0 J2\n"
    assert timed(body, figures(1.0)).times[1] == pytest.approx(line_to(speed), rel=1e-6)


def test_corners_close_to_each_other_are_one_curve():
    radius, room, half = 2e-3, 1e-6, 0.5 * LENGTH
    turn = np.linspace(0.0, 2.0 * math.pi, 1441)[1:]
    chords = "".join(f"X{2 * math.cos(a):.9f} Y{2 * math.sin(a):.9f}\n" for a in turn)
    found = timed(f"G1 X2 F60000\n{chords}", figures(1e3 * room)).times[362:1082].sum()
    assert found == pytest.approx(math.pi * radius / (math.sqrt(12.0 * radius * room) / half), rel=0.05)


def test_the_usual_filter_is_the_one_with_the_fastest_corner():
    on = machine()
    usual = figures_of({"tolerance": 0.01}, "", "heidenhain")
    half = half_filters(on, on.limits, np.array([1e-5]), usual)[0]
    assert half == pytest.approx((6.0 * 1e-5 / J) ** (1.0 / 3.0))
    best = timed("G1 X50 F6000\nY50\n", usual).times[1]
    for share in (0.7, 1.4):
        other = figures(0.01, filter_time=float(share * 2.0 * half))
        assert timed("G1 X50 F6000\nY50\n", other).times[1] > best


def test_cycle_32_sets_the_tolerance():
    text = (
        "BEGIN PGM A MM\nCYCL DEF 32.0 TOLERANZ\nCYCL DEF 32.1 T{}\n"
        "L X+0 Y+0 Z+0 R0 FMAX\nL X+50 F6000\nL Y+50\nEND PGM A MM\n"
    )
    on = machine()
    totals = []
    for room in ("0.002", "0.02"):
        moves = read_commanded(Source.from_text(text.format(room), "part.h"), on)
        assert moves.tolerance[-1] == pytest.approx(float(room) * 1e-3)
        totals.append(time_of_moves(moves, on, figures()).total)
    assert totals[1] < totals[0]


def test_a_five_axis_turn_holds_the_limits_of_the_joints():
    on = machine()
    column = on.joints.index("A")
    most, acceleration, jerk = (each[column] for each in (on.limits.velocity, on.limits.acceleration, on.limits.jerk))
    expected = math.pi / 2.0 / most + ramp_time(most, acceleration, jerk) + LENGTH
    assert timed("G1 A90 F60000\n", figures()).total == pytest.approx(expected, rel=1e-6)


def test_cycle_32_sets_the_tolerance_of_rotary_axes():
    """Two turns in place: the filter leaves the corner by |D| v h / 6, at most TA."""
    text = (
        "BEGIN PGM A MM\nCYCL DEF 32.0 TOLERANZ\nCYCL DEF 32.1 T0.01\nCYCL DEF 32.2 HSC-MODE:1 TA{}\n"
        "L A+0 C+0 R0 FMAX\nL A+20 F2000\nL C+20\nEND PGM A MM\n"
    )

    def corner(allowed: float) -> float:
        moves = read_commanded(Source.from_text(text.format(allowed), "part.h"), machine())
        return float(MODELS["heidenhain"](moves, machine(), figures()).corner[-2])

    for allowed in (0.004, 0.002):
        assert corner(allowed) == pytest.approx(6.0 * math.radians(allowed) / (math.sqrt(2.0) * LENGTH / 2.0), rel=1e-6)

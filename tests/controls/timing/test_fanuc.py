"""The model `fanuc`: each rule of its specifications against a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.timed_programs import A, J, machine, timed
from toolpace.controls.timing.figures import ControlFigures, figures_of
from toolpace.kernels.jerk_ramp import ramp_distance, ramp_time, reachable_speed

FEED = 0.1
"""Of the programs, F6000 [m/s]."""


def figures(look_ahead: int = 0, **own: float) -> ControlFigures:
    return figures_of({"look_ahead": look_ahead, "fanuc": own}, "", "fanuc")


def two_lines(speed: float, way: float = 0.05) -> float:
    """Two lines along one axis each, with a speed between them, from rest to rest."""
    slow, fast = ramp_distance(speed, FEED, A, J), ramp_distance(0.0, FEED, A, J)
    return 2.0 * (ramp_time(FEED, A, J) + ramp_time(FEED - speed, A, J) + (way - slow - fast) / FEED)


def test_a_line_from_rest_to_rest_and_what_comes_after_interpolation():
    line = 0.2 / FEED + FEED / A + A / J
    assert timed("G1 X200 F6000\n", figures()).total == pytest.approx(line)
    assert timed("G1 X200 F6000\n", figures(after_interpolation=0.03)).total == pytest.approx(line + 0.03)
    # the bell takes its own time
    assert timed("G1 X200 F6000\n", figures(bell_time=0.02)).total == pytest.approx(0.2 / FEED + FEED / A + 0.02)


@pytest.mark.parametrize("degrees", [30, 90, 150])
def test_a_corner_is_passed_at_f_over_the_greatest_ratio(degrees: float):
    turn = math.radians(degrees)
    difference = 1200.0
    ratio = 6000.0 / difference * max(abs(math.cos(turn) - 1.0), abs(math.sin(turn)))
    x, y = 50.0 + 50.0 * math.cos(turn), 50.0 * math.sin(turn)
    body = f"G1 X50 F6000\nX{x:.9f} Y{y:.9f}\n"
    found = timed(body, figures(corner_difference=difference))
    # the first line is along X: up to F, and down to F / R
    speed = FEED / max(ratio, 1.0)
    slow, fast = ramp_distance(speed, FEED, A, J), ramp_distance(0.0, FEED, A, J)
    expected = ramp_time(FEED, A, J) + ramp_time(FEED - speed, A, J) + (0.05 - slow - fast) / FEED
    assert found.times[1] == pytest.approx(expected, rel=1e-6)


def test_the_manuals_example_of_a_right_corner():
    """A-63512EN, 2.4: at 1000 mm/min with a difference of 500 the corner is passed at 500."""
    slow = timed("G1 X50 F1000\nY50\n", figures(corner_difference=500.0)).total
    speed, feed = 500.0 / 6e4, 1000.0 / 6e4
    down = ramp_time(feed - speed, A, J) - ramp_distance(speed, feed, A, J) / feed
    rest = ramp_time(feed, A, J) - ramp_distance(0.0, feed, A, J) / feed
    assert slow == pytest.approx(2.0 * (0.05 / feed + down + rest))


def test_arcs_keep_their_acceleration_and_their_least_feed():
    radius = 2e-3
    arcs = "G1 X2 F60000\n" + 5 * "G3 X2 Y0 I-2 J0\n"
    around = 2.0 * math.pi * radius
    free = {"corner_difference": 0.0}
    assert timed(arcs, figures(**free)).times[4] == pytest.approx(around / math.sqrt(A * radius))
    assert timed(arcs, figures(arc_acceleration=0.25, **free)).times[4] == pytest.approx(
        around / math.sqrt(0.25 * A * radius)
    )
    feed = 4800.0
    assert feed / 6e4 > math.sqrt(A * radius)
    assert timed(arcs, figures(arc_least_feed=feed, **free)).times[4] == pytest.approx(around / (feed / 6e4))


def test_chords_of_a_circle_keep_the_acceleration_of_their_axes():
    """A-78962EN, 2.7: the difference of feed over the time of a block."""
    radius, turn = 2e-3, np.linspace(0.0, 2.0 * math.pi, 721)[1:]
    chords = "".join(f"X{2 * math.cos(a):.9f} Y{2 * math.sin(a):.9f}\n" for a in turn)
    found = timed(f"G1 X2 F60000\n{chords}", figures(corner_difference=0.0))
    # no axis alone has all of it but for a moment: between a and 2^(1/2) a
    half = math.pi * radius
    assert half / math.sqrt(math.sqrt(2.0) * A * radius) <= found.times[182:542].sum() <= half / math.sqrt(A * radius)
    weaker = timed(f"G1 X2 F60000\n{chords}", figures(corner_difference=0.0, curve_acceleration=0.25))
    assert weaker.times[182:542].sum() == pytest.approx(2.0 * found.times[182:542].sum(), rel=0.02)


def test_jerk_control_slows_where_a_line_meets_an_arc():
    """1788: v^2 / r within the permissible change of acceleration."""
    radius, change = 0.01, 250.0
    body = "G1 X50 F6000\nG3 X60 Y10 I0 J10\n"
    speed = math.sqrt(change * 1e-3 * radius)
    slow, fast = ramp_distance(speed, FEED, A, J), ramp_distance(0.0, FEED, A, J)
    line = ramp_time(FEED, A, J) + ramp_time(FEED - speed, A, J) + (0.05 - slow - fast) / FEED
    assert timed(body, figures(acceleration_change=change)).times[1] == pytest.approx(line, rel=1e-6)
    # 1789 is for lines alone
    corner = "G1 X50 F6000\nX100 Y0.05\n"
    assert timed(corner, figures(acceleration_change=0.1)).total > timed(corner, figures()).total * 1.0001
    wide = timed(corner, figures(acceleration_change=0.1, acceleration_change_lines=1e6)).total
    assert wide == pytest.approx(timed(corner, figures()).total)


def test_a_control_can_stop_at_the_end_of_the_blocks_that_it_has_read():
    body = "F6000\n" + "".join(f"G1 X{0.01 * k:.3f}\n" for k in range(1, 5001))
    least = min(FEED, reachable_speed(0.0, 40 * 1e-5, A, J))
    found = timed(body, figures(look_ahead=40))
    assert least < FEED
    np.testing.assert_allclose(found.times[1000:4000], 1e-5 / least, rtol=0.01)
    assert timed(body, figures()).total < 0.7 * found.total
    assert timed(body, figures_of({}, "", "fanuc")).total == pytest.approx(found.total)


def test_stops():
    straight = timed("G1 X100 F6000\n", figures()).total
    stops = timed("G61\nG1 X50 F6000\nX100\n", figures(after_interpolation=0.03)).total
    assert stops == pytest.approx(straight + FEED / A + A / J + 0.06)


def test_a_five_axis_turn_holds_the_limits_of_the_joints():
    on = machine()
    column = on.joints.index("A")
    most, acceleration, jerk = (each[column] for each in (on.limits.velocity, on.limits.acceleration, on.limits.jerk))
    expected = math.pi / 2.0 / most + ramp_time(most, acceleration, jerk)
    assert timed("G1 A90 F60000\n", figures()).total == pytest.approx(expected, rel=1e-6)

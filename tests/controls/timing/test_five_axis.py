"""Moves that turn, in tool-centre-point mode: which limits hold in each model, and which speed F is."""

from __future__ import annotations

import math

import pytest

from tests.support.timed_programs import A, J, machine
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import MODELS
from toolpace.kernels.jerk_ramp import ramp_time
from toolpace.programs.reading import Source, read_commanded

JOINTS = ("sinumerik", "heidenhain", "fanuc", "lookahead")
"""Models that keep the limits of the joints."""
FILTER = 0.01
"""Of a Heidenhain [s]."""


def last_time(body: str, model: str) -> float:
    """Time of the last move, from rest to rest, without the delay of a filter [s]."""
    text = f"G21 G90 G94\nG0 X0 Y0 Z100 A0 C0\nG43.4 H1\n{body}M30\n"
    moves = read_commanded(Source.from_text(text, "part.nc"), machine())
    figures = figures_of({"heidenhain": {"filter_time": FILTER}}, "", model)
    return float(MODELS[model](moves, machine(), figures).times[-1]) - FILTER * (model == "heidenhain")


def turned(angle: float, top: float, acceleration: float, jerk: float) -> float:
    """Seven phases over an angle from rest to rest; fewer where the acceleration is not reached."""
    build_up = acceleration / jerk
    peak = 0.5 * acceleration * (math.sqrt(build_up**2 + 4.0 * angle / acceleration) - build_up)
    if peak < acceleration * build_up:
        peak = (0.25 * angle * angle * jerk) ** (1.0 / 3.0)
    speed = min(peak, top)
    return angle / speed + ramp_time(speed, acceleration, jerk)


@pytest.mark.parametrize("model", JOINTS)
@pytest.mark.parametrize("radius", [0.1, 0.02])
def test_a_turn_about_the_table_is_as_fast_as_the_joints_that_follow_it(radius: float, model: str):
    """The tip stands in the part, off the axis of C: X and Y go round by the radius, at first along Y alone."""
    own = machine().limits
    column = machine().joints.index("C")
    acceleration = min(own.acceleration[column], A / radius)
    jerk = min(own.jerk[column], J / radius)
    # across the way Y needs the radius times the speed squared
    top = min(own.velocity[column], math.sqrt(A / radius))
    expected = turned(math.radians(10.0), top, acceleration, jerk)
    assert last_time(f"G0 X{1e3 * radius} Y0 Z0\nG1 C10 F60000\n", model) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("model", JOINTS)
def test_near_the_pole_c_turns_as_fast_as_it_can_while_the_tip_hardly_moves(model: str):
    own = machine().limits
    column = machine().joints.index("C")
    limits = own.velocity[column], own.acceleration[column], own.jerk[column]
    expected = turned(math.pi, *limits)
    # over 0.01 mm of the tip at the pole; F would take a thousandth of the time
    assert last_time("G0 X0 Y0 Z0 A0.001\nG1 X0.01 C180 F60000\n", model) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("model", [*JOINTS, "linuxcnc"])
def test_f_is_the_speed_of_the_tip_in_the_part(model: str):
    """C turns by 90 degrees over 100 mm along its axis, far from every limit."""
    expected = 0.1 / 0.01
    assert last_time("G0 X0 Y0 Z0\nG1 Z-100 C90 F600\n", model) == pytest.approx(expected, rel=1e-2)

"""The model `sinumerik`: each rule of its manuals against a closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.timed_programs import A, J, machine
from toolpace.controls.timing.axis_motion import axis_ways
from toolpace.controls.timing.blocks import rests
from toolpace.controls.timing.figures import figures_of, limits_of, off_the_path
from toolpace.controls.timing.program_time import ProgramTime, time_of_moves
from toolpace.controls.timing.sinumerik import brisk_moves, corner_speeds
from toolpace.kernels.jerk_ramp import ramp_distance, ramp_time
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import Source, read_commanded

HEAD = "G21 G90 G94 G17\nG0 X0 Y0 Z0 A0 C0\n".replace("G21", "G71")
FEED = 0.1
"""Of the programs, F6000 [m/s]."""


def moves_of(body: str) -> Commanded:
    return read_commanded(Source.from_text(f"{HEAD}{body}M30\n", "part.mpf"), machine())


def timed(body: str, **own: float) -> ProgramTime:
    return time_of_moves(moves_of(body), machine(), figures_of({"sinumerik": own}, "", "sinumerik"))


def corner_of(body: str, index: int = 1, **table: object) -> float:
    """Speed at the end of a move [m/s], by the rules of corners alone."""
    moves, on = moves_of(body), machine()
    figures = figures_of(table, "", "sinumerik")
    ways, stop = axis_ways(moves, on, joints=True), rests(moves)
    feed = np.full(len(moves), FEED)
    arguments = moves, ways, feed, ways.length, stop, limits_of(on, figures), figures, off_the_path(moves, on, figures)
    return float(corner_speeds(*arguments, brisk_moves(moves, figures))[index])


def test_soft_takes_seven_phases_and_brisk_three():
    line = 0.2 / FEED + FEED / A
    assert timed("SOFT\nG1 X200 F6000\n").total == pytest.approx(line + A / J)
    assert timed("BRISK\nG1 X200 F6000\n").total == pytest.approx(line, rel=1e-6)
    assert timed("DRIVE\nG1 X200 F6000\n").total == pytest.approx(line, rel=1e-6)
    assert timed("G1 X200 F6000\n", brisk=1.0).total == pytest.approx(line, rel=1e-6)
    # CYCLE832 switches SOFT on; half the acceleration by MD32433
    assert timed("BRISK\nCYCLE832(0.02, 1)\nG1 X200 F6000\n").total == pytest.approx(line + A / J)
    assert FEED * J >= (0.5 * A) ** 2
    soft = 0.2 / FEED + FEED / (0.5 * A) + 0.5 * A / J
    assert timed("SOFT\nG1 X200 F6000\n", soft_acceleration=0.5).total == pytest.approx(soft)


def test_limits_by_the_mode_of_finishing_count():
    finishing = timed("DYNFINISH\nG1 X200 F6000\n", jerk_finish=0.25).total
    assert finishing == pytest.approx(0.2 / FEED + 2.0 * math.sqrt(FEED / (0.25 * J)))
    assert timed("DYNFINISH\nDYNNORM\nG1 X200 F6000\n", jerk_finish=0.25).total < finishing
    assert timed("CYCLE832(0.02, 1)\nG1 X200 F6000\n", jerk_finish=0.25).total == pytest.approx(finishing)
    assert timed("DYNPREC\nG1 X200 F6000\n", jerk_precise=0.25).total == pytest.approx(finishing)
    assert timed("DYNPOS\nG1 X200 F6000\n", jerk_position=0.25).total == pytest.approx(finishing)
    assert timed("CYCLE832(0.02, 3)\nG1 X200 F6000\n", jerk_finish=0.25).total < finishing


@pytest.mark.parametrize("degrees", [30, 90, 150])
@pytest.mark.parametrize("tolerance", [0.005, 0.02])
def test_a_corner_is_rounded_within_the_tolerance_of_the_program(degrees: float, tolerance: float):
    """The change of velocity D v takes 2 (D v / j)^(1/2) in jerk alone, and leaves the corner by |D| v t / 12."""
    turn = math.radians(degrees)
    change = np.abs([math.cos(turn) - 1.0, math.sin(turn)])
    body = f"CYCLE832({tolerance}, 1)\nG1 X50 F6000\nX={50 + 50 * math.cos(turn)} Y={50 * math.sin(turn)}\n"
    speed = corner_of(body)
    period = 2.0 * math.sqrt(change.max() * speed / J)
    assert 0.5 * period * J < A  # the acceleration is not reached
    assert np.linalg.norm(change) * speed * period / 12.0 == pytest.approx(tolerance * 1e-3, rel=1e-6)
    # and the whole time: two lines, each with a ramp between the corner and F, and one from rest
    slow, fast = ramp_distance(speed, FEED, A, J), ramp_distance(0.0, FEED, A, J)
    expected = 2.0 * (ramp_time(FEED, A, J) + ramp_time(FEED - speed, A, J) + (0.05 - slow - fast) / FEED)
    along = machine().limits.acceleration[0] / max(abs(math.cos(turn)), abs(math.sin(turn)))
    if along == pytest.approx(A):
        assert timed(body).total == pytest.approx(expected, rel=1e-6)


def test_a_corner_without_rounding_jumps_by_the_overload_factor():
    """B1: jump = acceleration (overload - 1) cycle; of X and of Y at a right corner."""
    body = "G64\nG1 X50 F6000\nY50\n"
    assert corner_of(body) == pytest.approx(A * 0.2 * 0.004)
    assert corner_of(body, sinumerik={"overload": 2.0, "cycle": 0.002}) == pytest.approx(A * 1.0 * 0.002)
    assert corner_of(body.replace("G64", "G642")) > 2.5 * A * 0.2 * 0.004


def test_where_a_line_meets_an_arc_the_acceleration_across_is_spread_within_the_tolerance():
    radius, room = 0.01, 20e-6
    body = "CYCLE832(0.02, 1)\nG1 X50 F6000\nG3 X60 Y10 I0 J10\n"
    speed = corner_of(body)
    step = speed**2 / radius
    # spread over the time step / j it is off by step t^2 / 24
    assert step * (step / J) ** 2 / 24.0 == pytest.approx(room)
    assert corner_of(body, sinumerik={"transition_jerk": 8.0}) == pytest.approx(2.0 * speed)
    assert corner_of("BRISK\nG642\nG1 X50 F6000\nG3 X60 Y10 I0 J10\n") >= FEED


def test_chords_of_a_circle_are_driven_as_its_radius_allows_and_share_the_acceleration():
    radius, feed = 2e-3, 1.0
    turn = np.linspace(0.0, 2.0 * math.pi, 721)[1:]
    chords = "".join(f"X={2 * math.cos(a):.9f} Y={2 * math.sin(a):.9f}\n" for a in turn)
    body = f"G642\nG1 X2 F{feed * 6e4:.0f}\n{chords}"
    around = 2.0 * math.pi * radius / math.sqrt(A * radius)
    # away from the ramps at its ends
    assert timed(body).times[182:542].sum() == pytest.approx(0.5 * around, rel=0.04)
    # a quarter across: half the speed
    arcs = f"G642\nG1 X2 F{feed * 6e4:.0f}\n" + 5 * "G3 X2 Y0 I-2 J0\n"
    whole, shared = (timed(arcs, curve_share=share).times[4] for share in (0.0, 0.25))
    assert whole == pytest.approx(around) and shared == pytest.approx(2.0 * around)


def test_stops_and_rapids():
    straight = timed("G1 X100 F6000\n").total
    assert timed("G60\nG1 X50 F6000\nX100\n").total == pytest.approx(straight + FEED / A + A / J)
    slow, fast = (timed("G0 X400\n", rapid_jerk=share).total for share in (1.0, 4.0))
    assert slow - fast == pytest.approx(A / J * 0.75, rel=1e-6)


def test_a_five_axis_turn_holds_the_limits_of_the_joints():
    """In place, on the axis of A: the turn of A alone, with its jerk."""
    body = "G1 A=90 F=60000\n"
    own = machine().limits
    column = machine().joints.index("A")
    velocity, acceleration, jerk = own.velocity[column], own.acceleration[column], own.jerk[column]
    turn, most = math.pi / 2.0, min(velocity, 60000.0 / 60.0 * math.pi / 180.0)
    expected = turn / most + ramp_time(most, acceleration, jerk)
    assert timed(body).total == pytest.approx(expected, rel=1e-6)

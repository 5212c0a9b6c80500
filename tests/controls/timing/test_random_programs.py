"""Programs that move one axis at a time, and straight lines: no control that keeps jerk beats the fastest motion.

With exact stops the fastest motion has a closed form; with roundings it is planned within the same tolerance.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import toolpace as tp
from tests.support.timed_programs import machine
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.programs.reading import Source, read_commanded, read_source
from toolpace.programs.reading.languages import with_controller
from toolpace.programs.reading.options import ReadOptions

ROOM = 0.02
"""Tolerance of roundings [mm]."""
KEEP_JERK = ("sinumerik", "heidenhain", "fanuc", "lookahead")
"""At rests; of these a Fanuc lets velocities jump where it does not rest."""
Move = tuple[str, float, float, float]
"""Axis, place at its end, way and feed [mm, mm/min; deg, deg/min]."""
PLANNED = 1e-3
"""Share by which a plan may be slower than the fastest motion: the gap to its bound."""


def one_axis_at_a_time(seed: int, axes: str, signs: tuple[float, ...] = (-1.0, 1.0)) -> list[Move]:
    rng, place, moves = np.random.default_rng(seed), dict.fromkeys(axes, 0.0), []
    for _ in range(int(rng.integers(2, 7))):
        axis = str(rng.choice(list(axes)))
        before = place[axis]
        place[axis] = round(before + float(rng.choice(signs)) * 10.0 ** rng.uniform(-1.0, 1.5), 4)
        moves.append((axis, place[axis], abs(place[axis] - before), round(10.0 ** rng.uniform(2.7, 4.0))))
    return moves


def source_of(moves: list[Move], mode: str) -> Source:
    body = "\n".join(f"G1 {axis}{place:.4f} F{feed:.0f}" for axis, place, _, feed in moves)
    return Source.from_text(f"G21 G90 G17 G94\nG0 X0 Y0 Z0 A0 C0\n{mode}\n{body}\nM2\n", "part.ngc")


def seven_phases(way: float, top: float, acceleration: float, jerk: float) -> float:
    """Time from rest to rest [s]."""
    if way <= 0.0:
        return 0.0
    build_up = acceleration / jerk
    # from way = v (v / a + a / j), and way = 2 v (v / j)^(1/2) below the acceleration
    peak = 0.5 * acceleration * (math.sqrt(build_up**2 + 4.0 * way / acceleration) - build_up)
    if peak < acceleration * build_up:
        peak = (0.25 * way * way * jerk) ** (1.0 / 3.0)
    speed = min(peak, top)
    ramp = speed / acceleration + build_up if speed >= acceleration * build_up else 2.0 * math.sqrt(speed / jerk)
    return way / speed + ramp


def with_stops(moves: list[Move]) -> list[float]:
    """Time of each move from rest to rest [s]."""
    on, times = machine(), []
    for axis, _, way, feed in moves:
        column = on.joints.index(axis)
        unit = math.radians(1.0) if on.is_rotary[column] else 1e-3
        own = on.limits
        top = min(feed * unit / 60.0, own.velocity[column])
        times.append(seven_phases(way * unit, top, own.acceleration[column], own.jerk[column]))
    return times


def check_exact_stops(seed: int) -> None:
    moves = one_axis_at_a_time(seed, "XYZAC")
    times = with_stops(moves)
    commanded = read_commanded(source_of(moves, "G61.1"), machine())
    for model in KEEP_JERK:
        # a Heidenhain adds the delay of its filter to each rest
        delay = 0.02 if model == "heidenhain" else 0.0
        figures = figures_of({"heidenhain": {"filter_time": 0.02}}, "", model)
        found = time_of_moves(commanded, machine(), figures).times[-len(times) :]
        np.testing.assert_allclose(found, np.add(times, delay), rtol=1e-6, err_msg=f"{model}, seed {seed}")


def check_roundings(seed: int) -> None:
    """A third of the programs are straight lines whose feed changes from block to block."""
    moves = one_axis_at_a_time(seed, "X", (1.0,)) if seed % 3 == 2 else one_axis_at_a_time(seed, "XYZ")
    source, on = source_of(moves, f"G64 P{ROOM}"), machine()
    commanded = read_commanded(source, on)
    options, _ = with_controller(source, None, ReadOptions.of(on))
    least = tp.plan_program(read_source(source, on, None, options), on, ROOM * 1e-3).trajectory.duration
    most = sum(with_stops(moves))
    for model in ("sinumerik", "heidenhain", "lookahead"):
        table = {"compress": 0.0, "heidenhain": {"filter_time": 0.01}}
        found = time_of_moves(commanded, on, figures_of(table, "", model)).total
        delay = 0.01 if model == "heidenhain" else 0.0
        assert (1.0 - PLANNED) * least <= found <= most * (1.0 + 1e-9) + delay, f"{model}, seed {seed}"


@pytest.mark.parametrize("seed", range(20))
def test_with_exact_stops_every_control_takes_seven_phases_for_each_move(seed: int):
    check_exact_stops(seed)


@pytest.mark.parametrize("seed", range(3))
def test_with_roundings_no_control_that_keeps_jerk_is_faster_than_the_optimum_or_slower_than_with_stops(seed: int):
    check_roundings(seed)


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(1000, 1090), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(1090, 1270), marks=pytest.mark.thorough, id="many"),
    ],
)
def test_many_programs_with_stops_and_a_tenth_as_many_with_roundings(seeds):
    for seed in seeds:
        check_exact_stops(seed)
    for seed in seeds[:: 9]:
        check_roundings(1000 + seed)

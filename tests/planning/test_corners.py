"""A square with its corners rounded within a tolerance, beside what a control without limits of jerk makes of it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import toolpace as tp
from toolpace.controls.timing.linuxcnc import linuxcnc_times
from toolpace.planning.optimal.planner import Optimal
from toolpace.planning.program_plan import plan_program
from toolpace.planning.second_order import SecondOrder
from toolpace.programs.reading import Source, read_commanded, read_text
from toolpace.programs.reading.options import ReadOptions

AXIS = math.radians(0.05)
PLACES = ["X10 Y0", "X10 Y10", "X-10 Y10", "X-10 Y-10", "X10 Y-10", "X10 Y0"]


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("linuxcnc-xyzac-trt")


def square(tolerance):
    ways = [f"{'G1' if k else 'G0'} {place} Z0 A0 C0{' F1200' * (k == 1)}" for k, place in enumerate(PLACES)]
    return "\n".join(["G21 G90 G17 G94 G40 G49", f"G64 P{1e3 * tolerance:g}", *ways, "M2", ""])


def test_corners_beside_linuxcnc_and_stop_and_go(machine):
    """Without limits of jerk it is faster than LinuxCNC, which has none, at the same tolerance; with them it never
    stops in a corner, and a wider tolerance saves time."""
    stopping, with_jerk = 4.0 + 4.0 * 0.2, []
    for tolerance in (10e-6, 200e-6):
        text = square(tolerance)
        path = read_text(text, machine, "gcode", controller="linuxcnc")
        told = path.tip_tolerance
        assert np.all(told == pytest.approx(tolerance))
        moves = read_commanded(Source.from_text(text), machine, options=ReadOptions.of(machine, "linuxcnc"))
        theirs = linuxcnc_times(moves, machine)[~moves.rapid].sum()
        assert plan_program(path, machine, tolerance, AXIS, planner=SecondOrder()).trajectory.duration < theirs
        found = plan_program(path, machine, tp.Tolerances(1e-6, program=True), AXIS, planner=Optimal(bound=False))
        tp.verify(found.trajectory, machine, path, tolerance, AXIS).raise_if_failed()
        with_jerk.append(found.trajectory.duration)
    assert with_jerk[0] < stopping and all(wide < narrow for narrow, wide in pairwise(with_jerk))

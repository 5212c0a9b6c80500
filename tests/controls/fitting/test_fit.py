"""Figures of a control from a log of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.timed_programs import machine
from tests.support.trapezoids import REAL, log_of, program
from toolpace import Limits, Machine
from toolpace.common.errors import UsageError
from toolpace.controls.fitting.fit import fit_log
from toolpace.controls.fitting.motion_log import MotionLog, load_log, sustained_accelerations, trimmed
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.programs.reading import Source, read_commanded

ON = Machine.load("xyzac-trunnion")
MACHINE = machine()


def test_accelerations_that_are_kept_up_are_found():
    found, _ = sustained_accelerations(log_of())
    assert found[:3] == pytest.approx([REAL[axis] for axis in "XYZ"], rel=1e-3)
    assert np.isnan(found[3:]).all()  # axes that stand tell nothing


def test_noise_of_an_encoder_is_not_taken_for_acceleration():
    found, _ = sustained_accelerations(log_of(noise=0.1e-6))
    assert found[:3] == pytest.approx([REAL[axis] for axis in "XYZ"], rel=0.1)


def test_the_model_then_takes_the_time_of_the_log_and_of_another_program():
    moves = read_commanded(Source.from_text(program(), "part.ngc"), MACHINE)
    wrong = machine(acceleration=3.0, jerk=1e6)
    found = fit_log(moves, wrong, log_of(), figures_of({}, "", "lookahead"))
    assert found.modelled == pytest.approx(found.measured, rel=0.004)
    assert found.misfit < 4e-3
    acceleration = found.figures.acceleration
    assert isinstance(acceleration, dict)
    assert acceleration == pytest.approx({axis: a * 1e3 for axis, a in REAL.items()}, rel=1e-3)
    other = "G21 G90 G94 G61.1\nG0 X0 Y0 Z0 A0 C0\nG1 X9 F4800\nG1 Y20\nG1 Z30\nG1 X0\nM2\n"
    hand = sum(
        way / v + v / REAL[axis]
        for axis, way in (("X", 9e-3), ("Y", 0.02), ("Z", 0.03), ("X", 9e-3))
        for v in [min(0.08, math.sqrt(REAL[axis] * way))]
    )
    time = time_of_moves(read_commanded(Source.from_text(other, "other.ngc"), wrong), wrong, found.figures)
    assert time.total == pytest.approx(hand, rel=0.005)


def test_a_log_is_read_by_the_names_of_its_columns(tmp_path: Path):
    rows = ["time , Y, other, X", *(f"{0.002 * k},{max(k - 10, 0) * 0.5},x,{min(k, 40)}" for k in range(60))]
    (tmp_path / "log.csv").write_text("\n".join(rows), encoding="utf-8")
    log = load_log(tmp_path / "log.csv", ON)
    assert log.dt == pytest.approx(0.002)
    assert log.q[:, 0].max() == pytest.approx(0.04)
    assert log.q[-1, 1] == pytest.approx(0.0245)
    assert np.isnan(log.q[:, 2:]).all()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a,b\n1,2\n", "must name the columns"),
        ("t,X\n0,0\n0.1,1\n", "has 2 rows"),
        ("t,X\n" + "".join(f"{k},{k}\n" for k in range(30)) + "31,oops\n", "log.csv:32: a figure is missing"),
        ("t,X\n" + "".join(f"{k},{k}\n" for k in range(30)) + "99,3\n", "log.csv:32: times must rise in equal steps"),
        ("t,X\n" + "".join(f"{-k},{k}\n" for k in range(30)), "times must rise"),
        ("t,X\n" + "".join(f"{k},5\n" for k in range(30)), "no axis moves"),
        ("t,X\n" + "".join(f"{k},nan\n" for k in range(30)), "log.csv:2: a figure is missing"),
    ],
)
def test_logs_that_cannot_be_used_are_refused_with_their_line(tmp_path: Path, text: str, told: str):
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=told):
        load_log(tmp_path / "log.csv", ON)


def test_a_log_that_is_not_there_or_no_text(tmp_path: Path):
    with pytest.raises(UsageError, match="cannot be read"):
        load_log(tmp_path / "none.csv", ON)
    (tmp_path / "log.csv").write_bytes(b"\xff\xfe\x00\x81t,X\n")
    with pytest.raises(UsageError, match="no table of text"):
        load_log(tmp_path / "log.csv", ON)


@pytest.mark.linuxcnc
@pytest.mark.sweep
def test_a_log_of_linuxcnc_tells_its_acceleration_and_tolerance():
    """Run with limits and a tolerance that the model is not told; another program is then known to 2 percent."""
    from testbed.linuxcnc.configuration import Configuration
    from testbed.linuxcnc.run import run_program
    from testbed.linuxcnc.timed import corners, pocket

    told = Machine.load("linuxcnc-xyzac-trt")
    own = told.limits
    acceleration = np.where(told.is_rotary, own.acceleration, [0.7, 0.5, 0.4, 0.0, 0.0])
    real = told.with_limits(Limits(own.velocity, acceleration, own.jerk, told.joints))
    logged, asked = corners(40).replace("G64\n", "G64 P0.03\n"), pocket(2).replace("G64 P0.05", "G64 P0.03")
    runs = [run_program(text, Configuration.joints(real)) for text in (logged, asked)]
    unsaid = [
        read_commanded(Source.from_text(text.replace("G64 P0.03", "G64"), "part.ngc"), told) for text in (logged, asked)
    ]
    found = fit_log(unsaid[0], told, trimmed(1e-3, runs[0].joints), figures_of({}, "", "linuxcnc"))
    assert found.figures.tolerance == pytest.approx(0.03, rel=0.02)
    assert isinstance(found.figures.acceleration, dict)
    assert [found.figures.acceleration[axis] for axis in "XYZ"] == pytest.approx([700.0, 500.0, 400.0], rel=0.02)
    assert time_of_moves(unsaid[1], told, found.figures).total == pytest.approx(runs[1].duration, rel=0.02)


def test_the_log_of_another_program_is_refused():
    q = np.zeros((400, 5))
    q[:, 2] = np.linspace(0.0, 40.0, 400)
    moves = read_commanded(Source.from_text(program(), "part.ngc"), MACHINE)
    with pytest.raises(UsageError, match="not measured of this program"):
        fit_log(moves, MACHINE, MotionLog(1e-3, q), figures_of({}, "", "lookahead"))

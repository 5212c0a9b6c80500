"""Figures of a control from a log of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.s_curves import duration, log_of_lines
from tests.support.timed_programs import A, J, machine
from tests.support.trapezoids import REAL, log_of, program
from toolpace import Limits, Machine
from toolpace.common.errors import UsageError
from toolpace.controls.fitting.fit import fit_log, fit_measured, fit_times
from toolpace.controls.fitting.motion_log import MotionLog, load_log, progress, sustained_accelerations, trimmed
from toolpace.controls.fitting.written_times import WrittenTime
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.program_time import time_of_moves, with_range
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import Source, read_commanded

ON = Machine.load("xyzac-trunnion")
MACHINE = machine()


def test_accelerations_that_are_kept_up_are_found():
    found, *_ = sustained_accelerations(log_of())
    assert found[:3] == pytest.approx([REAL[axis] for axis in "XYZ"], rel=1e-3)
    assert np.isnan(found[3:]).all()  # axes that stand tell nothing


def test_noise_of_an_encoder_is_not_taken_for_acceleration():
    found, *_ = sustained_accelerations(log_of(noise=0.1e-6))
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
        ("t,X\n" + "".join(f"{k},{k}e200\n" for k in range(30)), "log.csv:3: a figure .* beyond 1e.09"),
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
    (own_tolerance,) = (each for each in found.fitted if each.name == "tolerance")
    assert own_tolerance.least <= 0.03 <= own_tolerance.most < 1.05 * own_tolerance.least
    assert isinstance(found.figures.acceleration, dict)
    assert [found.figures.acceleration[axis] for axis in "XYZ"] == pytest.approx([700.0, 500.0, 400.0], rel=0.02)
    assert time_of_moves(unsaid[1], told, found.figures).total == pytest.approx(runs[1].duration, rel=0.02)


def test_the_log_of_another_program_is_refused():
    q = np.zeros((400, 5))
    q[:, 2] = np.linspace(0.0, 40.0, 400)
    moves = read_commanded(Source.from_text(program(), "part.ngc"), MACHINE)
    with pytest.raises(UsageError, match=r"its axes go \d+ times as far as the program; log the whole program"):
        fit_log(moves, MACHINE, MotionLog(1e-3, q), figures_of({}, "", "lookahead"))


WRONG_LOGS = {
    "half of it": (lambda log: MotionLog(log.dt, log.q[: len(log.q) // 2]), "X ends 16 mm from where it ends in the"),
    "columns exchanged": (lambda log: MotionLog(log.dt, log.q[:, [2, 0, 1, 3, 4]]), "X ends 24 mm from where"),
    "inches": (lambda log: MotionLog(log.dt, log.q / 25.4), "its axes go 0.0394 times as far as the program"),
    "milliseconds": (lambda log: MotionLog(1e3 * log.dt, log.q), "that is not measured of this program"),
}


@pytest.mark.parametrize(("wrong", "told"), WRONG_LOGS.values(), ids=WRONG_LOGS)
def test_what_is_no_log_of_the_whole_program_in_its_units_is_refused(
    wrong: Callable[[MotionLog], MotionLog], told: str
):
    moves = read_commanded(Source.from_text(program(), "part.ngc"), MACHINE)
    with pytest.raises(UsageError, match=told):
        fit_log(moves, MACHINE, wrong(log_of()), figures_of({}, "", "lookahead"))


@pytest.mark.parametrize("noise", [0.0, 1e-6])
@pytest.mark.parametrize("share", [0.01, 0.05])
@pytest.mark.parametrize("end", ["begins", "ends"])
def test_a_log_that_is_cut_says_so(end: str, share: float, noise: float):
    moves = read_commanded(Source.from_text(program(), "part.ngc"), MACHINE)
    whole = log_of(noise=noise)
    assert progress(moves, MACHINE, trimmed(whole.dt, whole.q))[2] == ()
    cut = int(share * len(whole.q))
    log = trimmed(whole.dt, whole.q[:-cut] if end == "ends" else whole.q[cut:])
    doubts = fit_log(moves, MACHINE, log, figures_of({}, "", "lookahead")).doubts
    told = [float(each.split()[2]) for each in doubts if each.startswith("X ends") and "is the log cut" in each]
    missing = abs((log.q[-1, 0] - log.q[0, 0]) - 0.034)
    assert told == [pytest.approx(1e3 * missing, abs=0.01)]
    assert noise or doubts[0] == f"the axes are in motion where the log {end}: rows are missing there"


def test_a_log_that_comes_back_to_its_end_lacks_way():
    """The last corner is missing, with rest before and after it."""
    text = "G21 G90 G94 G61.1\nG0 X0 Y0 Z0 A0 C0\nG1 X40 F4800\nX0\nX40\nX38\nM2\n"
    moves = read_commanded(Source.from_text(text, "part.ngc"), MACHINE)
    log = log_of_lines([(0, 0.04), (0, -0.04), (0, 0.038)], 0.08, [A] * 5, [J] * 5, 1e-3)
    doubts = progress(moves, MACHINE, log)[2]
    (doubt,) = doubts
    assert doubt == "the axes go 0.967 times as far in the log as in the program: wide roundings, or are rows missing?"


@pytest.mark.parametrize(("seed", "dt", "noise"), [(1, 2e-3, 1e-7), (7, 2e-3, 1e-7), (1, 1e-3, 1e-6), (7, 1e-3, 1e-8)])
def test_a_log_with_limited_jerk_tells_figures_within_their_stated_ends(seed: int, dt: float, noise: float):
    """The motion is of closed forms; with the noise of an encoder."""
    rng = np.random.default_rng(seed)
    jerk = J * float(rng.uniform(0.6, 1.6))
    real = {"X": 1.3 * A, "Y": 0.8 * A, "Z": A}
    ways = [(k % 3, float(rng.uniform(0.01, 0.06)) * (-1) ** k) for k in range(9)]
    log = log_of_lines(ways, 0.25, [*real.values(), 50.0, 50.0], [jerk] * 5, dt, noise, seed)
    found = fit_log(lines(ways), MACHINE, log, figures_of({}, "", "lookahead"))
    told = {each.name: each for each in found.fitted}
    assert told["jerk"].least * J <= jerk <= told["jerk"].most * J
    assert told["jerk"].most < 1.3 * told["jerk"].least
    for axis, figure in real.items():
        own = told[f"acceleration of {axis}"]
        assert own.least <= 1e3 * figure <= own.most and own.most < 1.3 * own.least


def lines(ways: list[tuple[int, float]], feed: int = 15000) -> Commanded:
    """A program that stops after each way; every third begins with another tool."""
    place, text = np.zeros(3), ["G21 G90 G94 G61.1", "G0 X0 Y0 Z0 A0 C0"]
    for k, (axis, way) in enumerate(ways):
        place[axis] += way
        text += [f"T{k // 3 + 1} M6"] * (k % 3 == 0)
        text.append(f"G1 {'XYZ'[axis]}{1e3 * place[axis]:.7f} F{feed}")
    return read_commanded(Source.from_text("\n".join([*text, "M2", ""]), "part.ngc"), MACHINE)


def test_times_of_operations_tell_jerk_and_acceleration():
    """Written to a hundredth of a second, from closed forms; long ways tell the acceleration, short ones the jerk."""
    rng = np.random.default_rng(3)
    long = [(k % 3, 0.3 * (-1) ** (k // 3)) for k in range(12)]
    short = [(k % 3, float(rng.uniform(0.001, 0.002)) * (-1) ** (k // 3)) for k in range(24)]
    ways, a, j = long + short, 1.15 * A, 0.7 * J
    spent = [sum(duration(abs(way), 0.5, a, j)[1] for _, way in ways[k : k + 3]) for k in range(0, 36, 3)]
    written = [WrittenTime(f"T{k + 1}", round(time, 2), 0.01) for k, time in enumerate(spent)]
    found = fit_times(lines(ways, 30000), MACHINE, written, figures_of({}, "", "lookahead"))
    told = {each.name: each for each in found.fitted}
    assert told["jerk"].least <= 0.7 <= told["jerk"].most < 1.1 * told["jerk"].least
    assert told["acceleration"].least <= 1.15 <= told["acceleration"].most < 1.2 * told["acceleration"].least
    assert found.modelled == pytest.approx(sum(spent), rel=2e-3)
    # a file with these figures has a range as narrow as the times leave it
    time = time_of_moves(lines(ways, 30000), MACHINE, found.figures)
    narrow = with_range(time, lines(ways, 30000), MACHINE, found.figures).range
    assert narrow is not None and narrow.least <= sum(spent) <= narrow.most < 1.1 * narrow.least


def test_one_time_tells_one_figure_as_well_as_the_others_are_known():
    """Short ways, on which the acceleration is never reached: the time is that of the jerk alone."""
    ways = [(k % 3, 0.0015 * (-1) ** (k // 3)) for k in range(12)]
    total = sum(duration(abs(way), 0.25, A, 0.6 * J)[1] for _, way in ways)
    found = fit_measured(f"{total:.2f} s", lines(ways), MACHINE, figures_of({}, "", "lookahead"))
    (told,) = found.fitted
    assert told.name == "jerk" and told.least <= 0.6 <= told.most
    # the jerk goes with the cube of the time
    rounding = 0.01 / math.sqrt(12.0) / total
    assert told.most / told.least == pytest.approx(math.exp(2.0 * 1.96 * 3.0 * rounding), rel=0.01)
    assert found.modelled == pytest.approx(total, abs=0.006)


def test_of_several_figures_that_fit_the_nearest_is_found():
    """LinuxCNC with limited jerk takes as long with 3.8 times the jerk, too."""
    ways = np.random.default_rng(5).uniform(-20.0, 20.0, (25, 3))
    body = "".join(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} F3000\n" for x, y, z in ways)
    text = f"G21 G90 G17 G94 G64 P0.02\nG0 X0 Y0 Z0 A0 C0\n{body}M2\n"
    moves = read_commanded(Source.from_text(text, "part.ngc"), MACHINE)
    figures = figures_of({"linuxcnc": {"planner": 1}}, "", "linuxcnc")
    total = time_of_moves(moves, MACHINE, figures).total
    (told,) = fit_times(moves, MACHINE, [WrittenTime("", total, 0.1)], figures).fitted
    assert told.name == "jerk" and told.least < 1.0 < told.most < 1.2 * told.least


@pytest.mark.parametrize("slower", [0.97, 1.003])
def test_a_figure_stays_within_what_may_be_of_it(slower: float):
    """The overload factor of a Sinumerik without roundings: below 1 there is none, which fits came to."""
    ways = [(k % 3, 0.01 * (-1) ** (k // 3)) for k in range(12)]
    text, place = ["G71 G90 G94 G64", "G0 X0 Y0 Z0 A0 C0"], np.zeros(3)
    for axis, way in ways:
        place[axis] += way
        text.append("G1 " + " ".join(f"{name}{1e3 * at:.4f}" for name, at in zip("XYZ", place)) + " F3000")
    moves = read_commanded(Source.from_text("\n".join([*text, "M30", ""]), "part.mpf"), MACHINE)
    exact = {"acceleration": 1.0, "jerk": 1.0, "sinumerik": {"cycle": 1.0}}
    figures = figures_of({"uncertainty": exact}, "", "sinumerik")
    total = slower * time_of_moves(moves, MACHINE, figures).total
    found = fit_times(moves, MACHINE, [WrittenTime("", total, 1e-3)], figures)
    (told,) = found.fitted
    assert told.name == "overload" and 1.0 <= told.least < told.value < told.most
    assert found.modelled == pytest.approx(total, abs=1e-3)
    # the written file can be read and has a range
    assert with_range(time_of_moves(moves, MACHINE, found.figures), moves, MACHINE, found.figures).range is not None


@pytest.mark.sweep
def test_stated_ends_hold_95_of_100_controls():
    """Acceleration and jerk drawn as uncertain as they are by default; the whole time is written to a tenth of it."""
    held = 0
    ways = [(k % 3, 0.002 * (k % 7 + 1) * (-1) ** (k // 3)) for k in range(21)]
    moves = lines(ways)
    for seed in range(100):
        a, j = np.random.default_rng(seed).normal(size=2) * np.log([1.2, 2.0]) / 1.96
        total = sum(duration(abs(way), 0.25, A * math.exp(a), J * math.exp(j))[1] for _, way in ways)
        (jerk,) = fit_measured(f"{total:.1f} s", moves, MACHINE, figures_of({}, "", "lookahead")).fitted
        assert jerk.name == "jerk"
        held += jerk.least <= math.exp(j) <= jerk.most
    assert held >= 95


def test_a_total_below_its_operations_counts_once():
    moves = lines([(k % 3, 0.0015 * (-1) ** k) for k in range(6)])
    figures = figures_of({}, "", "lookahead")
    times = [part.time for part in time_of_moves(moves, MACHINE, figures).parts]
    written = [WrittenTime(f"T{k + 1}", 1.1 * time, 0.01) for k, time in enumerate(times)]
    alone = fit_times(moves, MACHINE, written, figures)
    assert fit_times(moves, MACHINE, [*written, WrittenTime("", 1.1 * sum(times), 0.01)], figures) == alone
    with pytest.raises(UsageError, match=r"the total is 5\.00 s, and the operations take .* together; leave out"):
        fit_times(moves, MACHINE, [*written, WrittenTime("", 5.0, 0.01)], figures)


def test_an_operation_is_written_as_often_as_it_is_there():
    text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\n(operation: Face)\nG1 X40 F1000\nM2\n"
    moves = read_commanded(Source.from_text(text, "part.ngc"), MACHINE)
    (name,) = {each.name for each in moves.operations if each.name}
    with pytest.raises(UsageError, match="is written 2 times, and the program has 1 of it; remove a line"):
        fit_times(moves, MACHINE, [WrittenTime(name, 3.0, 1.0)] * 2, figures_of({}, "", "lookahead"))


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ([WrittenTime("Pocket", 3.0, 1.0)], "no operation 'Pocket'; .*T1"),
        ([WrittenTime("T1", 1.0, 1.0)] * 2, "'T1' is written twice"),
        ([WrittenTime("", 900.0, 1.0)], "no jerk makes the model take 15 min"),
        ([WrittenTime("T1", 90.0, 1.0), WrittenTime("T2", 800.0, 1.0)], "not measured of this program"),
    ],
)
def test_times_that_cannot_be_of_the_program_are_refused(written: list[WrittenTime], told: str):
    with pytest.raises(UsageError, match=told):
        fit_times(lines([(k % 3, 0.0015) for k in range(6)]), MACHINE, written, figures_of({}, "", "lookahead"))

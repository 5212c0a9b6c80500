"""Machine data of a Sinumerik as files have it: ways of writing, axes, limits, units, and figures of the control."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sinumerik_archive import Archive, changed
from toolpace.cli import main
from toolpace.common.errors import UnitWarning
from toolpace.controls.timing.figures import figures_of
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller

TRUNNION = Archive(Machine.load("xyzac-trunnion"))
LINES = [*TRUNNION.axes(), *TRUNNION.transformation(1, 1, 40)]


def _read(folder, lines, answers=None, name="mill.arc"):
    (folder / name).write_text("\n".join(lines))
    return read_control([folder / name], answers)


def _joint(draft, letter):
    return draft.machine.file.joints[letter]


def _asked(draft):
    return [question.what for question in draft.stand_ins]


@pytest.mark.parametrize(
    "line",
    [
        "$MA_MAX_AX_VELO[AX4]=12000",
        "N32000 $MA_MAX_AX_VELO[AX4]=12000 ;mm/min",
        "N32000 $MA_MAX_AX_VELO[MX4]=1.2EX4 '3a1f",
        "  n32000  $ma_max_ax_velo[ 0 , ax4 ] = 'H2EE0'",
        "N32000 $MA_MAX_AX_VELO[X]=12000.000",
        "$MA_MAX_AX_VELO[AX4,0]=1.2e4$MN_OTHER=1",
        "$MA_MAX_AX_VELO[AX4]=12000 mm/min",
        "$MA_MAX_AX_VELO[AX4]=12000 'ff N32010 $MA_OTHER[AX4]=1",
        "$MA_MAX_AX_VELO[AX4]=12000 (rapid)",
    ],
)
def test_a_datum_is_read_however_it_is_written(line, tmp_path):
    lines = [each for each in LINES if "VELO[AX4]" not in each]
    assert _joint(_read(tmp_path, [*lines, line]), "X").velocity == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize(
    "line", ["N32000 $MA_MAX_AX_VELO AX4=12000", "$MA_MAX_AX_VELO(AX4)=12000", "$MA_MAX_AX_VELO[AX4=1"]
)
def test_a_line_that_assigns_nothing_is_told(line, tmp_path):
    draft = _read(tmp_path, [*(each for each in LINES if "VELO[AX4]" not in each), line])
    assert _asked(draft) == ["velocity of X [mm/s]"]
    (told,) = (each for each in draft.record.remarks if "assign nothing" in each)
    assert told.startswith("Lines that name machine data and assign nothing: 1, ") and line in told


@pytest.mark.parametrize("value", ["12 m/min", "200 mm/s", "12 000", "12000 12000"])
def test_a_figure_with_something_behind_it_is_refused(value, tmp_path):
    lines = [*(each for each in LINES if "VELO[AX4]" not in each), f"$MA_MAX_AX_VELO[AX4]={value}"]
    with pytest.raises(ControlFileError, match=r"= \d+ has '.*' behind it; give the number alone"):
        _read(tmp_path, lines)


@pytest.mark.parametrize("off", ["#", "//", ";"])
def test_lines_that_are_switched_off_do_not_count(off, tmp_path):
    draft = _read(tmp_path, [each.replace("N32000", f"{off} N32000") for each in LINES])
    assert "velocity of X [mm/s]" in _asked(draft) and not draft.record.remarks


def _with_knee(folder, **data):
    """A machine of which X moves at 12 m/min with 5 m/s2, with data of a knee."""
    lines = changed(LINES, {"$MA_MAX_AX_VELO[AX4]": "12000", "$MA_MAX_AX_ACCEL[0,AX4]": "5"})
    return _read(folder, [*lines, *(f"$MA_ACCEL_REDUCTION_{name}[AX4]={value}" for name, value in data.items())])


def test_acceleration_falls_beyond_a_knee_as_the_control_has_it(tmp_path):
    limits = _with_knee(tmp_path, SPEED_POINT=0.25, FACTOR=0.6, TYPE=2).machine.limits
    (curve,) = limits.curves
    assert curve.joint == "X" and limits.acceleration[limits.joints.index("X")] == pytest.approx(2.0)
    assert np.allclose(np.stack([curve.curves[0].speed, curve.curves[0].limit]), [[0.0, 0.05, 0.2], [5.0, 5.0, 2.0]])
    # without a type the control has a hyperbola from the knee to the velocity limit
    draft = _with_knee(tmp_path, SPEED_POINT=0.25, FACTOR=0.75)
    curve = draft.machine.limits.curves[0].curves[0]
    v = np.linspace(0.05, 0.2, 200)
    power = 5.0 * 0.05 / v
    assert (curve.at(v) <= power * (1.0 + 1e-9)).all() and (curve.at(v) >= 0.99 * power).all()
    assert any("keeps that with DRIVE" in each for each in draft.record.remarks)
    assert Machine.from_toml(draft.text) == draft.machine
    jump = _with_knee(tmp_path, SPEED_POINT=0.5, FACTOR=0.75, TYPE=0).machine.limits.curves[0].curves[0]
    assert jump.at(np.array([0.094, 0.1, 0.2])) == pytest.approx([5.0, 1.25, 1.25])


def test_a_knee_of_a_turning_axis_is_in_turns(tmp_path):
    figures = {"$MA_MAX_AX_VELO[AX1]": "25", "$MA_MAX_AX_ACCEL[0,AX1]": "2"}
    lines = changed(LINES, figures)
    lines += ["$MA_ACCEL_REDUCTION_SPEED_POINT[AX1]=0.5", "$MA_ACCEL_REDUCTION_FACTOR[AX1]=0.5"]
    lines += ["$MA_ACCEL_REDUCTION_TYPE[AX1]=2"]
    (curve,) = _read(tmp_path, lines).machine.limits.curves
    turn = 2.0 * math.pi
    assert np.allclose(curve.curves[0].speed, np.array([0.0, 0.5, 1.0]) * 25.0 / 60.0 * turn)
    assert np.allclose(curve.curves[0].limit, np.array([2.0, 2.0, 1.0]) * turn)


@pytest.mark.parametrize("data", [
    {"SPEED_POINT": 1, "FACTOR": 0.5}, {"SPEED_POINT": 0.5, "FACTOR": 0}, {"SPEED_POINT": 0.5}, {"FACTOR": 0.5},
])  # fmt: skip
def test_a_knee_that_takes_nothing_is_none(data, tmp_path):
    assert not _with_knee(tmp_path, **data).machine.limits.curves


@pytest.mark.parametrize(("data", "message"), [
    ({"SPEED_POINT": -0.1, "FACTOR": 0.5}, "SPEED_POINT.* = -0.1; give a share of the velocity"),
    ({"SPEED_POINT": 0.5, "FACTOR": 1}, "FACTOR.* = 1; give a share of the acceleration"),
    ({"SPEED_POINT": 0.5, "FACTOR": 0.5, "TYPE": 3}, "TYPE.* = 3; give 0"),
])  # fmt: skip
def test_a_knee_that_cannot_be_is_refused(data, message, tmp_path):
    with pytest.raises(ControlFileError, match=message):
        _with_knee(tmp_path, **data)


def test_each_figure_says_its_file_and_line(tmp_path):
    text = _read(tmp_path, LINES).text
    line = next(number for number, line in enumerate(LINES, 1) if "MINUS[AX4]" in line)
    ends = f"mill.arc:{line} N36100 $MA_POS_LIMIT_MINUS[AX4] and mill.arc:{line + 1} N36110 $MA_POS_LIMIT_PLUS[AX4]"
    assert f"# mm; {ends}" in text
    figures = [line for line in text.splitlines() if " = " in line and not line.startswith(("#", "name", "note"))]
    of_words = ("the display shows", "tools have their lengths", "Sinumerik counts turns", "axis ", "the nose is at")
    assert figures and all("mill.arc:" in line or any(word in line for word in of_words) for line in figures)


def test_several_files_and_channels(tmp_path):
    general = [line for line in LINES if "$MN_" in line]
    axis = [line for line in LINES if "$MA_" in line]
    channel = [line for line in LINES if "$MC_" in line]
    loader = ["CHANDATA(2)", '$MC_AXCONF_CHANAX_NAME_TAB[0]="X"', "$MC_AXCONF_MACHAX_USED[0]=9"]
    (tmp_path / "nc.tea").write_text("\n".join(general))
    (tmp_path / "axes.tea").write_text("\n".join(axis))
    (tmp_path / "channels.tea").write_text("\n".join(["%_N_CH1_TEA_INI", *channel, *loader]))
    files = [tmp_path / name for name in ("channels.tea", "nc.tea", "axes.tea")]
    draft = read_control(files)
    assert not draft.stand_ins and draft.machine.kind == "table-table"
    assert "Channel 1 is read; channels 2 are not." in draft.record.remarks
    for idle in (0, 256):  # no transformation, TRANSMIT
        lathe = ["CHANDATA(1)", f"$MC_TRAFO_TYPE_1={idle}", '$MC_AXCONF_CHANAX_NAME_TAB[0]="Q"']
        (tmp_path / "channels.tea").write_text("\n".join([*lathe, "CHANDATA(2)", *channel]))
        draft = read_control(files)
        assert draft.machine.kind == "table-table" and "Channel 2 is read; channels 1 are not." in draft.record.remarks
    own = [line.replace("]=", ",CH1]=", 1) if "$MC_" in line and "]" in line else line for line in LINES]
    assert not _read(tmp_path, [line for line in own if "CHANDATA" not in line]).stand_ins


def test_limits_are_in_the_units_of_the_control(tmp_path):
    values = {
        "$MA_MAX_AX_VELO[AX4]": "36000", "$MA_MAX_AX_ACCEL[0,AX4]": "5", "$MA_MAX_AX_JERK[0,AX4]": "80",
        "$MA_SOFT_ACCEL_FACTOR[0,AX4]": "0.8", "$MA_MAX_AX_VELO[AX1]": "25", "$MA_MAX_AX_ACCEL[0,AX1]": "2",
        "$MA_MAX_AX_JERK[0,AX1]": "30", "$MN_SCALING_SYSTEM_IS_METRIC": "1",
    }  # fmt: skip
    draft = _read(tmp_path, changed(LINES, values))
    x, a = _joint(draft, "X"), _joint(draft, "A")
    assert (x.velocity, x.acceleration, x.jerk) == pytest.approx((0.6, 0.8 * 5.0, 80.0))
    assert (a.velocity, a.acceleration, a.jerk) == pytest.approx((25 * math.tau / 60, 2 * math.tau, 30 * math.tau))
    assert "$MA_MAX_AX_ACCEL[0,AX4] and mill.arc:" in draft.text
    values |= {"$MN_SCALING_SYSTEM_IS_METRIC": "FALSE", "$MA_MAX_AX_VELO[AX4]": "1400"}
    values |= {"$MA_MAX_AX_ACCEL[0,AX4]": "200", "$MA_MAX_AX_JERK[0,AX4]": "3000"}
    inch = _joint(_read(tmp_path, changed(LINES, values)), "X")
    assert (inch.velocity, inch.acceleration) == pytest.approx((1400 * 0.0254 / 60, 0.8 * 200 * 0.0254))
    assert inch.travel == pytest.approx((-500 * 0.0254, 500 * 0.0254))


@pytest.mark.filterwarnings("always::toolpace.common.errors.UnitWarning")
def test_degrees_per_minute_in_place_of_turns_are_asked_about(tmp_path):
    with pytest.warns(UnitWarning, match=r"joint A: velocity = 54000 deg/s is more than rotary joints .* have"):
        _read(tmp_path, changed(LINES, {"$MA_MAX_AX_VELO[AX1]": "9000"}))


def test_what_is_missing_is_asked_for_or_stood_in_for(tmp_path):
    gone = {
        "$MA_MAX_AX_JERK[0,AX4]": None, "$MA_POS_LIMIT_PLUS[AX4]": None, "$MN_SCALING_SYSTEM_IS_METRIC": None,
        "$MC_TRAFO5_AXIS2_1[0]": None, "$MC_TRAFO5_AXIS2_1[1]": None, "$MC_TRAFO5_AXIS2_1[2]": None,
    } | {f"$MC_TRAFO5_JOINT_OFFSET_1[{k}]": None for k in range(3)}  # fmt: skip
    draft = _read(tmp_path, changed(LINES, gone))
    assert _asked(draft) == [
        "basic unit of lengths (mm, in)", "$MC_TRAFO5_JOINT_OFFSET_1, a vector [mm]",
        "$MC_TRAFO5_AXIS2_1, the direction of C", "jerk of X [m/s^3]", "travel of X [mm]",
    ]  # fmt: skip
    assert draft.machine.file.joints["C"].direction == (0.0, 0.0, -1.0)
    assert "# NOT in these files: $MC_TRAFO5_AXIS2_1, the direction of C; 0, 0, -1 is a stand-in" in draft.text
    answered = _read(tmp_path, changed(LINES, gone), Answers(lambda question: question.stand_in))
    assert not answered.stand_ins and answered.machine.file.joints == draft.machine.file.joints


def test_limits_of_travel_that_the_control_does_not_watch_are_none(tmp_path):
    lines = changed(LINES, {"$MA_POS_LIMIT_MINUS[AX4]": "-1.0EX8", "$MA_POS_LIMIT_PLUS[AX4]": "1e8"})
    assert _asked(_read(tmp_path, lines)) == ["travel of X [mm]"]
    endless = changed(LINES, {"$MA_POS_LIMIT_MINUS[AX1]": "-1e8", "$MA_POS_LIMIT_PLUS[AX1]": "1e8"})
    assert _joint(_read(tmp_path, endless), "A").wrap
    modulo = changed(LINES, {"$MA_POS_LIMIT_MINUS[AX3]": "-10", "$MA_POS_LIMIT_PLUS[AX3]": "370"})
    assert _joint(_read(tmp_path, modulo), "C").wrap


def test_axes_that_no_file_names_are_asked_for(tmp_path):
    lines = [line for line in LINES if "$MN_AX" not in line and "$MC_AX" not in line]
    in_order = {"AX4": "X", "AX2": "Y", "AX6": "Z", "AX1": "A", "AX3": "C"}
    draft = _read(tmp_path, lines)
    assert _asked(draft) == [f"names of the axes {', '.join(in_order)} with commas between"]
    assert _asked(_read(tmp_path, ["$MA_SPIND_ASSIGN_TO_MACHAX[AX5]=1", *lines])) == _asked(draft)
    assert _joint(draft, "A").travel == pytest.approx(TRUNNION.machine.file.joints["A"].travel)
    for word, letter in in_order.items():
        lines = [line.replace(f"{word}]", f"{letter}1]") for line in lines]
    draft = _read(tmp_path, lines)
    assert not draft.stand_ins and _joint(draft, "X").jerk == TRUNNION.machine.file.joints["X"].jerk


def test_the_first_axes_of_a_channel_have_their_default_names_and_machine_axes(tmp_path):
    lines = ["$MN_SCALING_SYSTEM_IS_METRIC=1", "$MC_TRAFO_TYPE_1=21", "$MC_TRAFO5_BASE_TOOL_1[2]=260"]
    for place, (name, number) in enumerate((("C", 5), ("B", 6), ("SP", 4)), 3):
        lines += [f'$MC_AXCONF_CHANAX_NAME_TAB[{place}]="{name}"', f"$MC_AXCONF_MACHAX_USED[{place}]={number}"]
    lines += [f"$MA_MAX_AX_VELO[AX{k}]={6000 * k}" for k in (1, 2, 3)]
    machine = _read(tmp_path, lines).machine
    assert machine.limits.velocity[:3] == pytest.approx([0.1, 0.2, 0.3])
    assert machine.joints == ("X", "Y", "Z", "C", "B") and machine.kind == "head-head"
    with pytest.raises(ControlFileError, match="for Y, and the channel has no such axis"):
        _read(tmp_path, [*lines, "$MC_AXCONF_MACHAX_USED[0]=2"])


def test_axes_without_a_transformation_are_asked_for_as_of_other_controls(tmp_path):
    draft = _read(tmp_path, TRUNNION.axes())
    assert _asked(draft)[0].startswith("axes A, C: those from the bed to the workpiece")
    three = [line for line in LINES if not any(word in line for word in ("TRAFO", "AX1]", "AX3]", "[3]=", "[4]="))]
    draft = _read(tmp_path, three)
    assert draft.record.held == ["A", "C"] and not draft.stand_ins


def test_an_axis_with_another_name_is_a_joint_by_its_letter_and_spindles_are_none(tmp_path):
    lines = changed(LINES, {"$MC_AXCONF_CHANAX_NAME_TAB[4]": '"C1"', "$MC_AXCONF_CHANAX_NAME_TAB[3]": '"TILT"'})
    lines += ["$MC_AXCONF_MACHAX_USED[5]=5", '$MC_AXCONF_CHANAX_NAME_TAB[5]="SP"']
    draft = _read(tmp_path, lines)
    assert draft.machine.joints == ("X", "Y", "Z", "A", "C")
    remarks = "\n".join(draft.record.remarks)
    assert "C is the axis C1 of the control" in remarks and "A is the axis TILT" in remarks
    assert "No joints of this machine: SP." in remarks


def test_figures_of_the_control_make_a_controller_file(tmp_path):
    lines = [*LINES, *(f"$MA_COMPRESS_POS_TOL[AX{k}]={value}" for k, value in ((4, 0.012), (2, 0.01), (1, 0.05)))]
    lines += ["$MA_G00_ACCEL_FACTOR[AX4]=1.5", "$MA_G00_JERK_FACTOR[AX4]=2", "$MA_MAX_ACCEL_OVL_FACTOR[0,AX4]=1.3"]
    lines += ["$MA_MAX_AX_JERK[4,AX4]=25", "$MA_PATH_TRANS_JERK_LIM[0,AX4]=100", "$MC_CURV_EFFECT_ON_PATH_ACCEL[0]=0.5"]
    lines += ["$MN_IPO_CYCLE_TIME=0.003", "$MC_GCODE_RESET_VALUES[20]=1", "$MC_MAX_PATH_JERK[0]=1000"]
    (tmp_path / "mill.arc").write_text("\n".join(lines))
    place = tmp_path / "control.toml"
    assert main(["machines", "--from", str(tmp_path / "mill.arc"), "--write-controller", str(place)]) == 0
    controller = Controller.load(place)
    figures = figures_of(controller.time, controller.name)
    assert controller.like == "sinumerik" and figures.model == "sinumerik"
    assert (figures.tolerance, figures.axis_tolerance) == (0.01, 0.05)
    own = figures.sinumerik
    assert (own.rapid_acceleration, own.rapid_jerk, own.overload, own.curve_share) == (1.5, 2.0, 1.3, 0.5)
    assert (own.jerk_finish, own.transition_jerk, own.cycle, own.brisk) == (0.5, 2.0, 0.003, 1.0)
    # defaults of a control that nobody has tuned: no limit at all, and factors that are off
    untuned = changed(lines, {"$MA_PATH_TRANS_JERK_LIM[0,AX4]": "1e6", "$MA_G00_ACCEL_FACTOR[AX4]": "0"})
    text = _read(tmp_path, untuned, name="untuned.arc").controller
    assert "transition_jerk = 100 " in text and "20000 is beyond what the model takes" in text
    assert "rapid_acceleration" not in text and figures_of(Controller.from_toml(text).time, "") is not None
    record = read_control([tmp_path / "mill.arc"]).record
    assert record.control_figures["jerk of the path [m/s^3]"].number == 1000.0
    assert any("$MA_MAX_AX_JERK of X differs by dynamic mode (50, 25)" in remark for remark in record.remarks)

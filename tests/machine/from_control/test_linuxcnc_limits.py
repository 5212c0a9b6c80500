"""Limits, travel and their origins, as LinuxCNC's files tell them; contradictions are refused with both lines."""

from __future__ import annotations

import re

import pytest

from tests.support.linuxcnc_files import ini_text, written
from toolpace.common.errors import MachineError
from toolpace.common.units import DEGREE, INCH
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError

TABLE = ("xyzac-trt-kins", "XYZAC")
GANTRY = ("trivkins coordinates=XYYZ", "XYYZ")


def _line(text: str, entry: str, section: str) -> int:
    """At which line of a text an entry stands, below a heading."""
    lines = text.splitlines()
    at = lines.index(f"[{section}]")
    return next(k for k in range(at, len(lines)) if lines[k].startswith(entry)) + 1


def test_the_lowest_of_axis_and_joints_holds(tmp_path):
    sections = {
        "AXIS_X": {"MAX_VELOCITY": 150.0, "MAX_ACCELERATION": 2000.0, "MIN_LIMIT": -1.0},
        "JOINT_0": {"MAX_VELOCITY": 170.0, "MAX_ACCELERATION": 1200.0, "MAX_LIMIT": 5.0},
        "AXIS_Y": {"MAX_VELOCITY": 110.0},
        "JOINT_2": {"MAX_VELOCITY": 90.0, "MIN_LIMIT": -7.0},
    }
    text = ini_text(*GANTRY, sections=sections)
    draft = read_control([written(tmp_path, mill_ini=text)])
    x, y = (draft.machine.file.joints[name] for name in "XY")
    assert (x.velocity, x.acceleration) == (pytest.approx(0.15), pytest.approx(1.2))
    assert x.travel == pytest.approx((-0.001, 0.005))
    assert y.velocity == pytest.approx(0.09) and y.travel == pytest.approx((-0.007, 0.25))
    at = _line(text, "MAX_VELOCITY", "JOINT_2")
    assert re.search(rf"velocity = 90 +# mm/s; mill\.ini:{at} \[JOINT_2\] MAX_VELOCITY", draft.text)
    assert "Y is moved by joints 1, 2 together." in draft.text


def test_every_figure_stands_at_the_line_that_the_file_names(tmp_path):
    pins = {"x-rot-point": 3.25, "y-rot-point": -7.5, "z-rot-point": 11.75, "y-offset": 20.125, "z-offset": 10.5}
    hal = "".join(f"setp xyzac-trt-kins.{name} {value}\n" for name, value in pins.items())
    sections = {f"JOINT_{k}": {"MAX_VELOCITY": 100 + k, "MAX_JERK": 7000 + k} for k in range(5)}
    text = ini_text(*TABLE, sections=sections, lines=["HALFILE = pins.hal"])
    draft = read_control([written(tmp_path, mill_ini=text, pins_hal=hal)])
    files = {"mill.ini": text.splitlines(), "pins.hal": hal.splitlines()}
    checked = 0
    for line in draft.text.splitlines():
        key, _, rest = line.partition(" = ")
        if key in ("travel", "velocity", "acceleration", "jerk"):
            figures = {float(each) for each in re.findall(r"-?\d+(?:\.\d+)?", rest.partition("#")[0])}
            origins = re.findall(r"(mill\.ini|pins\.hal):(\d+)", rest)
            told = {float(files[name][int(number) - 1].split()[-1]) for name, number in origins}
            assert figures == told, line
            checked += 1
    assert checked == 20
    point = next(line for line in draft.text.splitlines() if line.startswith("point = [3.25, 12.625, 22.25]"))
    assert [int(number) for number in re.findall(r"pins\.hal:(\d+)", point)] == [1, 2, 3, 4, 5]


def test_the_text_of_a_draft_is_its_machine(tmp_path):
    from toolpace.machine.machine import Machine

    draft = read_control([written(tmp_path, mill_ini=ini_text(*TABLE))])
    assert Machine.from_toml(draft.text) == draft.machine
    rows = [line for line in draft.text.splitlines() if " = " in line and not line.startswith(("name", "note", "#"))]
    assert all("  # " in line for line in rows)


def test_jerk_is_that_of_the_joint_or_else_of_the_path_and_else_stood_in_for(tmp_path):
    sections = {"JOINT_0": {"MAX_JERK": 5000.0}, "AXIS_X": {"MAX_JERK": 0.0}, "TRAJ": {"MAX_LINEAR_JERK": 9000.0}}
    sections |= {"AXIS_Z": {"MAX_JERK": 7000.0}, "JOINT_2": {"MAX_JERK": 6000.0}}
    draft = read_control([written(tmp_path, mill_ini=ini_text(*TABLE, sections=sections))])
    joints = draft.machine.file.joints
    assert joints["X"].jerk == pytest.approx(5.0) and joints["Y"].jerk == pytest.approx(9.0)
    assert joints["Z"].jerk == pytest.approx(6.0) and joints["A"].jerk == pytest.approx(9000 * DEGREE)
    assert [question.what for question in draft.stand_ins] == ["jerk of A [deg/s^3]", "jerk of C [deg/s^3]"]
    assert draft.text.count("stand-in: ten times the acceleration, per second") == 2
    assert "# NOT in these files: jerk of A [deg/s^3]; 9000 is a stand-in" in draft.text


def test_a_jerk_of_the_path_that_limits_nothing_is_none(tmp_path):
    for jerk in (0.5, 1e9):
        path = written(tmp_path, mill_ini=ini_text(*TABLE, sections={"TRAJ": {"MAX_LINEAR_JERK": jerk}}))
        assert "jerk of X [mm/s^3]" in [question.what for question in read_control([path]).stand_ins]


def test_inches_and_turns_without_end(tmp_path):
    endless = dict.fromkeys(("MIN_LIMIT", "MAX_LIMIT"))
    sections = {"AXIS_C": endless, "JOINT_4": endless, "AXIS_A": {"WRAPPED_ROTARY": 1}}
    limits = {"MAX_VELOCITY": 4.0, "MAX_ACCELERATION": 20.0, "MIN_LIMIT": -10.0, "MAX_LIMIT": 12.0}
    sections |= {f"AXIS_{letter}": limits for letter in "XYZ"}
    machine = read_control([written(tmp_path, mill_ini=ini_text(*TABLE, units="inch", sections=sections))]).machine
    joints = machine.file.joints
    assert joints["X"].velocity == pytest.approx(4 * INCH)
    assert joints["X"].travel == pytest.approx((-10 * INCH, 12 * INCH))
    assert joints["A"].wrap and joints["C"].wrap
    assert joints["A"].velocity == pytest.approx(200 * DEGREE)


def test_units_may_be_numbers_of_them_in_a_millimetre_and_a_degree(tmp_path):
    sections = {"TRAJ": {"ANGULAR_UNITS": 0.0174533}}
    text = ini_text(*TABLE, units="0.03937007874", sections=sections)
    machine = read_control([written(tmp_path, mill_ini=text)]).machine
    assert machine.file.joints["X"].velocity == pytest.approx(200 * INCH)
    assert machine.file.joints["A"].velocity == pytest.approx(200.0)


def test_a_linear_axis_without_limits_gets_a_travel_that_is_told(tmp_path):
    endless = dict.fromkeys(("MIN_LIMIT", "MAX_LIMIT"))
    text = ini_text(*TABLE, sections={"AXIS_Y": endless, "JOINT_1": {"MIN_LIMIT": -1e99, "MAX_LIMIT": 1e99}})
    draft = read_control([written(tmp_path, mill_ini=text)])
    assert draft.machine.file.joints["Y"].travel == (-1.0, 1.0)
    assert "travel of Y [mm]" in [question.what for question in draft.stand_ins]


def test_limits_that_no_section_tells_are_the_controls_own_and_told(tmp_path):
    gone = dict.fromkeys(("MAX_VELOCITY", "MAX_ACCELERATION"))
    draft = read_control([written(tmp_path, mill_ini=ini_text(*TABLE, sections={"AXIS_Z": gone, "JOINT_2": gone}))])
    joint = draft.machine.file.joints["Z"]
    assert (joint.velocity, joint.acceleration, joint.jerk) == pytest.approx((1e-3, 1e-3, 1e-2))
    assert [each.reason.split(",")[0] for each in draft.stand_ins[:2]] == ["LinuxCNC's own default"] * 2


def test_digits_are_kept_and_rounding_of_sums_is_not(tmp_path):
    lines = ["HALCMD = setp xyzac-trt-kins.z-rot-point 0.1", "HALCMD = setp xyzac-trt-kins.z-offset 0.2"]
    text = ini_text(*TABLE, sections={"JOINT_0": {"MAX_VELOCITY": 123.4567891}}, lines=lines)
    shown = read_control([written(tmp_path, mill_ini=text)]).text
    assert "velocity = 123.4567891 " in shown and "point = [0, 0, 0.3] " in shown


def test_includes_and_files_given_beside_the_ini_are_read(tmp_path):
    text = ini_text(*TABLE, lines=["HALFILE = where/else/pins.hal"])
    body = text[text.index("[TRAJ]") :].replace("MAX_VELOCITY = 200.0", "MAX_VELOCITY = 120.0 # tested")
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "axes.inc").write_text(body)
    (tmp_path / "pins.hal").write_text("setp xyzac-trt-kins.z-offset \\\n 31\n# setp xyzac-trt-kins.z-offset 1\n")
    (tmp_path / "mill.ini").write_text(text[: text.index("[TRAJ]")] + "#INCLUDE inner/axes.inc\n")
    draft = read_control([tmp_path / "mill.ini", tmp_path / "pins.hal"])
    assert draft.machine.file.joints["X"].velocity == pytest.approx(0.12)
    assert draft.machine.file.joints["A"].point[2] == pytest.approx(0.031)
    assert f"axes.inc:{_line(body, 'MAX_VELOCITY', 'AXIS_X')} [AXIS_X] MAX_VELOCITY" in draft.text


def test_what_the_control_keeps_beside_the_joints_is_told(tmp_path):
    sections = {"TRAJ": {"MAX_LINEAR_VELOCITY": 80.0, "PLANNER_TYPE": 1}, "JOINT_2": {"HOME": 12.5}}
    text = ini_text("5axiskins", "XYZBCW", sections=sections, lines=["HALFILE = lost.hal"])
    shown = read_control([written(tmp_path, mill_ini=text)]).text
    at = _line(text, "MAX_LINEAR", "TRAJ")
    assert f"velocity of the path [mm/s] = 80 (mill.ini:{at} [TRAJ] MAX_LINEAR_VELOCITY)" in shown
    assert "planner = 1" in shown and "home of Z [mm] = 12.5" in shown
    assert "The axis W rests at zero" in shown and "tip_mode_at_start = true" in shown
    assert "lost.hal is not there" in shown


AXIS = {"MIN_LIMIT": 5.0, "MAX_LIMIT": 2.0}
REFUSED = {
    "travel the wrong way": (*TABLE, {"AXIS_Y": AXIS}, r"mill.ini:\d+: .* MIN_LIMIT = 5 is not below .*:\d+ .AXIS_Y"),
    "no travel": (*TABLE, {"AXIS_Y": dict.fromkeys(AXIS, 0.0)}, r"mill.ini:\d+: .* MIN_LIMIT = 0 is not below .*:\d+ "),
    "an axis that is nowhere": ("trivkins", "XY", {"TRAJ": {"COORDINATES": "XYZ"}}, "nor .JOINT_2. is there: the file"),
    "a robot": ("pumakins", "XYZABC", {}, r"mill.ini:\d+: .*KINEMATICS = pumakins: these kinematics cannot"),
    "three turning axes": ("xyzacb_trsrn", "XYZABC", {}, "it has three turning axes"),
    "three of trivkins": ("trivkins", "XYZABC", {}, "has the turning axes A, B, C; a machine here has two"),
    "a lathe": ("trivkins coordinates=xz", "XZ", {}, "has no axis Y"),
    "an axis without a joint": ("trivkins coordinates=XYZA", "XYZB", {}, r"names B, which no joint of .*:\d+ \[KINS\]"),
    "too few joints": (
        "trivkins coordinates=XYZAC", "XYZAC", {"KINS": {"JOINTS": 4}}, r"= 4 is less than the 5 axes of .*:\d+",
    ),
    "no such axis": ("trivkins coordinates=XYQ", "XYZ", {}, "names the axis 'Q'"),
    "a table without C": ("xyzac-trt-kins coordinates=XYZA", "XYZA", {}, "without C, which xyzac-trt-kins needs"),
    "a linear A": (*TABLE, {"JOINT_3": {"TYPE": "LINEAR"}}, "TYPE = LINEAR, and the joint moves the axis A"),
    "a limit below zero": (*TABLE, {"JOINT_1": {"MAX_VELOCITY": -3}}, "MAX_VELOCITY = -3; give a number above zero"),
    "no number": (*TABLE, {"AXIS_Z": {"MAX_VELOCITY": "fast"}}, "'fast' is not a number"),
    "no unit": (*TABLE, {"TRAJ": {"LINEAR_UNITS": None}}, "LINEAR_UNITS is missing"),
    "another unit": (*TABLE, {"TRAJ": {"ANGULAR_UNITS": "grad"}}, "= 'grad'; give one of deg, degree"),
    "no kinematics": (*TABLE, {"KINS": {"KINEMATICS": None}}, "KINEMATICS is missing"),
    "a section of 2.7": (*TABLE, {"AXIS_0": {"TYPE": "LINEAR"}}, "of LinuxCNC 2.7"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_meant_is_refused_at_its_line(case, tmp_path):
    kinematics, letters, sections, message = REFUSED[case]
    path = written(tmp_path, mill_ini=ini_text(kinematics, letters, sections=sections))
    with pytest.raises(ControlFileError, match=message) as error:
        read_control([path])
    assert "\n" not in str(error.value)


def test_a_key_with_two_values_is_refused_with_both_lines(tmp_path):
    text = ini_text(*TABLE) + "[TRAJ]\nLINEAR_UNITS = inch\n[AXIS_X]\nMAX_VELOCITY = 200.0\n"
    first, second = _line(text, "LINEAR_UNITS", "TRAJ"), len(text.splitlines()) - 2
    with pytest.raises(ControlFileError, match=rf"mill.ini:{second}: .*'inch' contradicts .*mill.ini:{first} .*'mm'"):
        read_control([written(tmp_path, mill_ini=text)])


def test_a_hal_file_that_loads_other_kinematics_is_refused(tmp_path):
    text = ini_text(*TABLE, lines=["HALFILE = mill.hal"])
    path = written(tmp_path, mill_ini=text, mill_hal="loadrt xyzbc-trt-kins\n")
    with pytest.raises(ControlFileError, match=r"mill.hal:1: .*loads xyzbc-trt-kins, and .*:\d+ .*xyzac-trt-kins"):
        read_control([path])


def test_files_that_are_none_or_of_two_machines_are_refused(tmp_path):
    mill = written(tmp_path, mill_ini=ini_text(*TABLE), other_ini=ini_text(*TABLE), part_ngc="G0 X1\nM2\n")
    with pytest.raises(ControlFileError, match="second INI"):
        read_control([mill, tmp_path / "other.ini"])
    with pytest.raises(ControlFileError, match=r"part.ngc: is neither a HAL file nor a part of"):
        read_control([mill, tmp_path / "part.ngc"])
    with pytest.raises(ControlFileError, match="no file of a control that is known"):
        read_control([tmp_path / "part.ngc"])


def test_a_control_file_error_is_a_machine_error_with_its_place(tmp_path):
    path = written(tmp_path, mill_ini=ini_text(*TABLE, sections={"AXIS_Z": {"MAX_VELOCITY": "fast"}}))
    with pytest.raises(MachineError) as error:
        read_control([path])
    assert isinstance(error.value, ControlFileError) and error.value.line > 0
    assert error.value.file == str(path)

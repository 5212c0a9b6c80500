"""Built-in machines, written as a Heidenhain control keeps them, are read back; what contradicts itself is refused."""

from __future__ import annotations

import math
import random
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.support.heidenhain_files import objects_text, parameters_text, table_text, vectors_text
from tests.support.read_back import assert_comes_back
from toolpace.common.errors import ToolpaceError, UnitWarning
from toolpace.machine.from_control import MachineDraft, read_control
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller

MIXED = Machine.load("xyzbc-millturn")
TABLE, PARAMETERS, OBJECTS = table_text(MIXED), parameters_text(MIXED), objects_text(MIXED)


def _read(tmp_path: Path, *texts: str, answers: Answers | None = None) -> MachineDraft:
    places = [tmp_path / f"{number}.txt" for number, _ in enumerate(texts)]
    for place, text in zip(places, texts):
        place.write_text(text)
    return read_control(places, answers)


@pytest.mark.parametrize("form", ["iTNC 530", "TNC 640", "vectors"])
@pytest.mark.parametrize("name", Machine.names())
def test_a_built_in_machine_comes_back(name, form, tmp_path):
    machine = Machine.load(name)
    texts = {
        "iTNC 530": (parameters_text(machine), table_text(machine)),
        "TNC 640": (objects_text(machine),),
        "vectors": (vectors_text(machine),),
    }
    draft = _read(tmp_path, *texts[form])
    assert not draft.stand_ins
    assert_comes_back(draft.machine, machine, machine.file.chain.spindle_nose)


def test_each_figure_names_its_line_and_a_controller_file_has_those_of_the_model(tmp_path):
    draft = _read(tmp_path, PARAMETERS, TABLE)
    assert 'acceleration = "5 m/s2"             # 0.txt:4 MP1060.0' in draft.text
    assert "point = [0, 0, 220]                 # 1.txt:4 Trans Z and 1.txt:5 MachAxis B" in draft.text
    place = tmp_path / "my-tnc.toml"
    place.write_text(draft.controller)
    assert Controller.load(place).time["heidenhain"] == {"path_jerk": 60, "path_jerk_rapid": 90}
    own = OBJECTS.replace(" axPathJerk:=50.0", " axPathJerkHi:=400.0, axPathJerk:=50.0")
    assert own.count("Hi:=400.0") == 2, "of X and Z"
    draft = _read(tmp_path, own.replace(" axPathJerk:=40.0", " axPathJerkHi:=200.0, axPathJerk:=40.0"))
    assert 'jerk = "50 m/s3"                    # 0.txt:8 CfgFeedLimits PX1 axPathJerk' in draft.text
    place.write_text(draft.controller)
    figures = Controller.load(place).time["heidenhain"]
    assert figures == {"path_jerk": 70, "path_jerk_rapid": 100, "least_corner_feed": 25, "least_path_feed": 60,
                       "axis_jerk_rapid": 5}  # fmt: skip


def test_the_example_of_the_manual_is_its_machine(tmp_path):
    """Technical Manual iTNC 530 HSCI, page 670: B, Y and X carry the tool, Z and C the workpiece.

    With the axes at zero the tool's reference point is 250.051 below and 0.016 beside the axis of B. Turned by B = 90
    degrees it is beside it on the other side: (0.016 - 250.051, 250.051 + 0.016) from where it was, in X and Z.
    """
    table = "BEGIN K.TAB MM\nNR KEY AXIS COORD\n0 Trans X 0.016\n1 Trans Z 250.051\n2 MachAxis B\n3 MachAxis Y\n"
    table += "4 MachAxis X\n5 MachBase\n6 MachAxis Z\n7 Trans X -298.923\n8 Trans Y 200.172\n9 MachAxis C\n[END]\n"
    machine = _read(tmp_path, parameters_text(MIXED), table).machine
    assert machine.file.chain.tool == ("X", "Y", "B") and machine.file.chain.workpiece == ("Z", "C")
    place = {name: k for k, name in enumerate(machine.joints)}
    q = np.zeros((3, 5))
    q[1, place["B"]] = q[2, place["C"]] = math.pi / 2.0
    tip, axis = machine.forward(q)
    assert tip[1] - tip[0] == pytest.approx(np.array([0.016 - 250.051, 0.0, 250.051 + 0.016]) * 1e-3, abs=1e-12)
    assert axis[1] == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    # positive C turns the tool, as the workpiece sees it, right-handed about (0.016 - 298.923, 200.172)
    centre = np.array([0.016 - 298.923, 200.172]) * 1e-3
    assert tip[2][:2] == pytest.approx((centre[0] + centre[1], centre[1] - centre[0]), abs=1e-12)


def test_without_a_base_the_linear_axes_move_the_tool(tmp_path):
    """MachBase is for the picture of the machine alone: tip and axis are the same."""
    axes = "".join(f"{number} MachAxis {axis}\n" for number, axis in enumerate("ZYXBC"))
    draft = _read(tmp_path, PARAMETERS, "NR KEY AXIS COORD\n" + axes)
    assert draft.machine.file.chain.workpiece == ("B", "C")
    assert any("1.txt does not end with [END]" in remark for remark in draft.record.remarks)
    whole = _read(tmp_path, PARAMETERS, TABLE).machine
    machine = _read(tmp_path, PARAMETERS, TABLE.replace("MachBase", "CMO")).machine
    assert machine.file.chain.tool == ("X", "Y", "Z", "B") and machine.file.chain.workpiece == ("C",)
    q = np.random.default_rng(5).uniform(-0.4, 0.4, (3, 5))
    assert machine.forward(q)[0] == pytest.approx(whole.forward(q)[0], abs=1e-12)


def test_a_turn_behind_the_table_turns_the_workpiece(tmp_path):
    table = TABLE.replace("[END]", "9    Trans      C    90\n[END]")
    chain = _read(tmp_path, PARAMETERS, table).machine.file.chain
    assert chain.workpiece_x == pytest.approx((0.0, 1.0, 0.0)) and chain.workpiece_z == (0.0, 0.0, 1.0)


def test_an_object_may_count_against_its_direction(tmp_path):
    """Once for a shift, of which the value has the other sign, once for an axis that turns the other way."""
    text = OBJECTS.replace("dir:=Z, val:=220.0", "dir:=-Z, val:=-220.0")
    assert text != OBJECTS
    assert _read(tmp_path, text).machine.file.joints["B"].point == pytest.approx((0.0, 0.0, 0.22))
    machine = _read(tmp_path, OBJECTS.replace("dir:=C", "dir:=-C")).machine
    assert machine.file.joints["C"].direction == (0.0, 0.0, 1.0)


def test_a_table_in_inches_is_read_and_told(tmp_path):
    draft = _read(tmp_path, PARAMETERS, TABLE.replace("TAB MM", "TAB INCH").replace("220.0", repr(220.0 / 25.4)))
    assert draft.machine.file.joints["B"].point == pytest.approx((0.0, 0.0, 0.22))
    assert any("inches" in remark for remark in draft.record.remarks)


def test_a_machine_without_kinematics_is_asked_about(tmp_path):
    points = {"a point on the axis of B": "0, 0, 220", "a point on the axis of C": "0, 0, -130"}
    answers = points | {"axes B, C": "C/B", "positive": "yes"}

    def ask(question):
        return next((answer for start, answer in answers.items() if question.what.startswith(start)), "")

    draft = _read(tmp_path, parameters_text(MIXED, {"MP7510.0": "%000001"}), answers=Answers(ask))
    expected = _read(tmp_path, PARAMETERS, TABLE).machine
    q = np.random.default_rng(3).uniform(-0.4, 0.4, (5, 5))
    columns = [expected.joints.index(name) for name in draft.machine.joints]
    assert draft.machine.forward(q[:, columns])[0] == pytest.approx(expected.forward(q)[0], abs=1e-12)
    assert any("MP7510.0 and following" in remark for remark in draft.record.remarks)


def test_the_coordinate_systems_of_the_manuals_example_are_its_axes(tmp_path):
    """Technical Manual MANUALplus 620, page 752: Z carries X, X carries Y, and C turns the workpiece."""
    systems = {
        "CZ": ("0, 0, 1", "1, 0, 0"), "CX": ("1, 0, 0", "0, 1, 0"), "CY": ("1, 0, 0", "0, 1, 0"),
        "CTOOL": ("1, 0, 0", "0, 1, 0"), "CC": ("0, 0, 1", "1, 0, 0"), "CMT": ("0, 1, 0", "0, 0, 1"),
    }  # fmt: skip
    text = "".join(
        f'CfgTrafoByDir( key:="{key}", location:=[0, 0, 0], zDir:=[{z}], xDir:=[{x}] )\n'
        for key, (z, x) in systems.items()
    )
    text += 'CfgKinModel( key:="K1", axesToolSide:=["Z","X","Y"], trafoToolSide:=["CZ","CX","CY"], '
    text += 'toolCoordSys:="CTOOL", axesWpSide:=["C"], trafoWpSide:=["CC"], machineTableSys:="CMT" )\n'
    axes = "".join(f'CfgFeedLimits( key:="P{name}1", rapidFeed:=9000 )\n' for name in "XYZC")
    record = _read(tmp_path, axes + text).record
    assert {name: record.joints[name]["direction"].value for name in "XYZC"} == {
        "X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0), "C": (0.0, 0.0, -1.0),
    }  # fmt: skip
    assert record.chain["tool"].value[:3] == ("Z", "X", "Y") and record.chain["tool_axis"].value == (0.0, 0.0, 1.0)


VECTORS = vectors_text(MIXED)
WRONG_VECTORS = {
    "a system that is not there": (('["T_Wp_C"]', '["T_Wp_Q"]'), "names T_Wp_Q, which is not there"),
    "fewer systems than axes": (('["T_Tool_X", ', "["), "axesToolSide names . axes, and trafoToolSide has . systems"),
    "no direction": (("zDir:=[", "zDir:=[0.0, 0.0, 0.0], oldDir:=["), "zDir = .* is no direction"),
    "two numbers": (("location:=[", "location:=[1.0, 2.0], place:=["), "location = .* has 2 numbers; it has 3"),
    "directions along each other": (("xDir:=[", "xDir:=[1.0, 1e-9, 0.0], oldDir:=["), "is not across"),
    "one direction": (("xDir:=[", "oldDir:=["), "needs both zDir and xDir"),
    "angles": (("zDir:=[", "angle1:=30.0, zDir:=["), "turns by angles, whose order is not known"),
}


@pytest.mark.parametrize(("change", "message"), WRONG_VECTORS.values(), ids=WRONG_VECTORS)
def test_a_model_of_vectors_that_cannot_be_meant_is_refused(change, message, tmp_path):
    text = VECTORS.replace(*change, 1)
    assert text != VECTORS
    with pytest.raises(ControlFileError, match=message):
        _read(tmp_path, text)


def test_jerk_is_the_axis_own_or_the_paths_or_the_guide_value(tmp_path):
    """MP1085, else MP1090.0; without both acceleration^2 * 60000 / rapid traverse, as the manual proposes."""
    joint = _read(tmp_path, parameters_text(MIXED, {"MP1085.0": "0"}), TABLE).machine.file.joints["X"]
    assert joint.jerk == pytest.approx(60.0)
    draft = _read(tmp_path, parameters_text(MIXED, {"MP1085.0": "0", "MP1090.0": None}), TABLE)
    assert draft.machine.file.joints["X"].jerk == pytest.approx(5.0**2 * 60_000.0 / 39_600.0, rel=1e-5)
    assert [each.what for each in draft.stand_ins] == ["jerk of X [m/s^3]"]


@pytest.mark.parametrize(("watched", "ends"), [(None, False), ("%00000", False), ("%10000", True)])
def test_a_rotary_axis_that_counts_modulo_has_ends_where_they_are_watched(watched, ends, tmp_path):
    """MP810 counts C within 360 degrees; MP812 has a bit for each axis, the last one for axis 1."""
    changes = {"MP910.4": "200", "MP920.4": "-100", "MP810.4": "360", "MP812": watched}
    joint = _read(tmp_path, parameters_text(MIXED, changes), TABLE).machine.file.joints["C"]
    assert joint.wrap != ends and (joint.travel is not None) == ends


def test_a_machine_of_three_axes_has_two_held_at_rest(tmp_path):
    mill = Machine.load("xyzac-trunnion")
    table = "NR KEY AXIS COORD\n0 MachAxis Z\n1 MachBase\n2 MachAxis X\n3 MachAxis Y\n[END]\n"
    draft = _read(tmp_path, parameters_text(mill, {"MP100": "--ZYX"}), table)
    assert draft.record.held == ["A", "C"] and draft.machine.file.chain.workpiece == ("X", "Y", "A", "C")
    assert draft.machine.file.joints["X"].direction == (-1.0, 0.0, 0.0)


def test_an_axis_that_turns_the_spindle_has_a_tilting_one_in_front_held_at_rest(tmp_path):
    mill = Machine.load("xyzac-trunnion")
    table = "NR KEY AXIS COORD\n0 MachAxis C\n1 MachAxis Z\n2 MachBase\n3 MachAxis X\n4 MachAxis Y\n[END]\n"
    draft = _read(tmp_path, parameters_text(mill), table)
    assert draft.record.held == ["A"] and draft.machine.file.chain.tool == ("Z", "C", "A")


REFUSED = {
    "an axis twice in the table": ((PARAMETERS, TABLE.replace("MachAxis   C", "MachAxis   B")),
        r"1.txt:\d+: MachAxis B is there twice, as .*1.txt:\d+ MachAxis B"),
    "a letter twice": ((parameters_text(MIXED, {"MP100": "CCZYX"}), TABLE), "MP100 = CCZYX has the letter C twice"),
    "an axis that is not there": ((parameters_text(MIXED, {"MP100": "C-ZYX"}), TABLE), "MachAxis B moves B, .* none"),
    "no Z": ((PARAMETERS, TABLE.replace("MachAxis   Z", "MachAxis   W")), "the kinematics have no axis Z"),
    "two values": ((PARAMETERS + "MP1010.0 : 5\n", TABLE), "MP1010.0 = 5 contradicts .*0.txt:3 MP1010.0 = 39600"),
    "a travel that is none": ((parameters_text(MIXED, {"MP910.0": "-900"}), TABLE), "MP920.0 = -450 is not .*MP910.0"),
    "an unknown key": ((PARAMETERS, TABLE.replace("MachBase", "MachBass")), "MachBass is no key that is read"),
    "a partial table": ((PARAMETERS, TABLE.replace("MachBase", "SUBFILE1")), "SUBFILE1 stands for a partial"),
    "a shift without length": ((PARAMETERS, TABLE.replace("220.0", "")), "Trans Z has no COORD"),
    "two tables": ((PARAMETERS, TABLE, TABLE), "2.txt: is a second kinematics table beside .*1.txt"),
    "a table and a model": ((OBJECTS, TABLE), "CfgKinComposModel M1 is a kinematic model beside the table"),
    "an object twice": ((OBJECTS + 'CfgAxis( key:="C" )\n',), "CfgAxis C is there twice, as .*CfgAxis C"),
    "two sets of an axis": ((OBJECTS + 'CfgFeedLimits( key:="PX2", rapidFeed:=9 )\n',),
        "CfgFeedLimits PX2 rapidFeed = 9 contradicts .* CfgFeedLimits PX1 rapidFeed = 39600.* of the same axis"),
    "an object that is not whole": ((OBJECTS[:-20],), "CfgKinComposModel has .* is the file whole"),
    "an object that is missing": ((OBJECTS.replace('key:="Mach_BASE"', 'key:="M"'),), "names Mach_BASE, which is not"),
    "no number": ((parameters_text(MIXED, {"MP1060.1": "fast"}), TABLE), "MP1060.1 = 'fast' is not a number"),
    "a comment that does not end": ((OBJECTS[:-20] + "(* " * 300_000,), "CfgKinComposModel has .* is the file whole"),
    "an object of blanks": ((OBJECTS + "CfgAxis(" + " " * 500_000 + ":=",), "CfgAxis has ':=' where an attribute"),
    "more objects than a control has": ((OBJECTS + "".join(f'CfgA( key:="{k}" )\n' for k in range(20_001)),),
        "CfgA .* is one of more than 20000 objects"),
    "nothing of axes": (('CfgLaPath( key:="", maxPathJerk:=40 )\n',), "0.txt: tells nothing of axes"),
    "another file": ((PARAMETERS, "hello\n"), "1.txt: has neither machine parameters, nor configuration objects"),
    "a table alone is not enough without letters": ((TABLE.replace("MachAxis   X", "MachAxis   U"),), "no axis X"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_contradicts_itself_is_refused_at_its_line(case, tmp_path):
    texts, message = REFUSED[case]
    with pytest.raises(ControlFileError, match=message) as error:
        _read(tmp_path, *texts)
    assert "\n" not in str(error.value)


def test_a_kinematic_model_of_several_is_asked_for(tmp_path):
    other = 'CfgKinComposModel( key:="M2", subKinList:=["K_TABLE"] )\n'
    draft = _read(tmp_path, OBJECTS + other)
    assert [each.what for each in draft.stand_ins] == ["kinematic model (M1, M2)"]


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.sweep)])
def test_changed_files_are_read_or_refused_in_one_line(seed, tmp_path):
    chance = random.Random(seed)
    words = [b"(", b")", b"[", b":=", b'"', b"MP", b"Trans", b"\xff", b"--", b"(*", b"9" * 30, b"-", b".", b"\r"]
    outcomes = {"read": 0, "refused": 0}
    places = [tmp_path / "a.txt", tmp_path / "b.txt"]
    for turn in range(100):
        forms = ((OBJECTS,), (PARAMETERS, TABLE), (VECTORS,))
        texts = [bytearray(text.encode()) for text in forms[turn % 3]]
        for _ in range(chance.randrange(1, 4)):
            text = chance.choice(texts)
            start = chance.randrange(len(text) + 1)
            end = min(len(text), start + chance.choice((0, 1, 3, 20, 800)))
            text[start:end] = chance.choice([*words, b""])
        for place, text in zip(places, texts):
            place.write_bytes(text)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UnitWarning)
                read_control(places[: len(texts)])
            outcomes["read"] += 1
        except ToolpaceError as error:
            assert "\n" not in str(error) and len(str(error)) < 500
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 10


@pytest.mark.parametrize("value", ["39.6 m/min", "39 600 ; rapid", "39,600 39,600"])
def test_a_figure_with_something_behind_it_is_refused(value, tmp_path):
    with pytest.raises(ControlFileError, match=r"MP1010.0 = 39\S* has '.*' behind it; give the number alone"):
        _read(tmp_path, parameters_text(MIXED, {"MP1010.0": value}), TABLE)


@pytest.mark.parametrize("comment", ["; mm/min", "(rapid)", "# rapid", "// rapid", "-- rapid", ""])
def test_a_comment_may_stand_behind_a_figure(comment, tmp_path):
    text = parameters_text(MIXED).replace("; comment", comment)
    assert _read(tmp_path, text, TABLE).machine.file.joints == _read(tmp_path, PARAMETERS, TABLE).machine.file.joints


@pytest.mark.parametrize("line", ["MP101O.0 : 39600", "MP1010.0 :", "MP1010.0 39600"])
def test_a_parameter_without_a_value_is_told(line, tmp_path):
    draft = _read(tmp_path, parameters_text(MIXED, {"MP1010.0": None}) + line + "\n", TABLE)
    assert [each.what for each in draft.stand_ins] == ["velocity of X [mm/s]"]
    (told,) = (each for each in draft.record.remarks if "have no value" in each)
    assert told.endswith(f"'{line}'.")


def test_attributes_may_be_in_small_letters(tmp_path):
    small = OBJECTS.replace("rapidFeed", "rapidfeed")
    assert _read(tmp_path, small).machine.file.joints == _read(tmp_path, OBJECTS).machine.file.joints


def test_a_row_of_kinematics_without_its_number_is_refused(tmp_path):
    row = next(line for line in TABLE.splitlines() if "Trans" in line)
    for odd in ("1b Trans A 45", row.lstrip("0123456789 ")):
        with pytest.raises(ControlFileError, match=r"1.txt:\d+: .* is no row with NR, KEY, AXIS and COORD"):
            _read(tmp_path, PARAMETERS, TABLE.replace(row, f"{odd}\n{row}", 1))

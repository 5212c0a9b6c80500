"""Kinematics of the machine that LinuxCNC's files tell, against the formulas of its documents."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.linuxcnc_files import ini_text, written
from toolpace.common.units import DEGREE, INCH, MILLIMETRE
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.from_control.stand_ins import Answers

TOOL = 83.0
"""Length of the tool [machine units]."""


def _turn(axis: str, degrees: float) -> np.ndarray:
    """(3, 3) the right-handed turn about a coordinate axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turns = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(turns[axis])


def _tilting_table(letters: str, offset: np.ndarray, sense: float):
    """Position of the nose, two angles -> tip: the part is turned by a tilting axis, and by C on it.

    offset: from the centre of C to the tilting axis at the side, and up.
    """
    about = "x" if letters[0] == "A" else "y"

    def tip(nose: np.ndarray, tilt: float, turn: float) -> np.ndarray:
        seen = _turn(about, -sense * tilt) @ (nose - [0, 0, TOOL] - CENTRE - offset) + offset
        return _turn("z", -sense * turn) @ seen + CENTRE

    return tip


CENTRE = np.array([3.0, -7.0, 11.0])
PINS = {"x-rot-point": 3.0, "y-rot-point": -7.0, "z-rot-point": 11.0}


def _two_tables(nose: np.ndarray, a: float, b: float) -> np.ndarray:
    """xyzab_tdr_kins: B below, A 10 mm under B's axis on it; both turn the part against the right-hand rule."""
    up = np.array([0.0, 0.0, -10.0])
    return _turn("x", a) @ (_turn("y", b) @ (nose - [0, 0, TOOL] - CENTRE) - up) + up + CENTRE


def _fork_head(nose: np.ndarray, b: float, c: float) -> np.ndarray:
    """5axiskins: B tilts towards -X, C turns B, both 212 above the nose."""
    length, b, c = 212.0 + TOOL, np.radians(b), np.radians(c)
    spherical = np.array([np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), -np.cos(b)])
    return nose + [0, 0, 212.0] + length * spherical


def _max(sense: float):
    """maxkins by its inverse: joints = position turned back by C, less the tilt of B (no tool)."""

    def tip(nose: np.ndarray, b: float, c: float) -> np.ndarray:
        tilt = 130.0 * np.array([sense * np.sin(np.radians(b)), 0.0, 1.0 - np.cos(np.radians(b))])
        return _turn("z", c) @ (nose + tilt)

    return tip


CASES = {
    "AC table": (
        "xyzac-trt-kins", "XYZAC", "tool-offset", PINS | {"y-offset": 20.0, "z-offset": 10.0},
        _tilting_table("AC", np.array([0.0, 20.0, 10.0]), 1.0),
    ),
    "AC table, conventional": (
        "xyzac-trt-kins", "XYZAC", "tool-offset",
        PINS | {"y-offset": 20.0, "z-offset": 10.0, "conventional-directions": "TRUE"},
        _tilting_table("AC", np.array([0.0, 20.0, 10.0]), -1.0),
    ),
    "BC table": (
        "xyzbc-trt-kins", "XYZBC", "tool-offset", PINS | {"x-offset": -20.0, "z-offset": -15.0},
        _tilting_table("BC", np.array([-20.0, 0.0, -15.0]), 1.0),
    ),
    "AB tables": (
        "xyzab_tdr_kins", "XYZAB", "tool-offset-z", PINS | {"x-offset": -20.0, "z-offset": -10.0}, _two_tables,
    ),
    "BC head": ("5axiskins", "XYZBCW", "", {}, _fork_head),
    "B head, C table": ("maxkins", "XYZABCUVW", "", {"pivot-length": 130.0}, _max(1.0)),
    "B head, conventional": (
        "maxkins", "XYZABCUVW", "", {"pivot-length": 130.0, "conventional-directions": 1}, _max(-1.0),
    ),
}  # fmt: skip
PIVOT = (
    "loadrt sum2 names=pivot\nsetp pivot.in0 [GEOMETRY]PIVOT\nnet tool motion.tooloffset.z => pivot.in1\n"
    "net pivot pivot.out => 5axiskins.pivot-length\n"
)


@pytest.mark.parametrize("units", ["mm", "inch"])
@pytest.mark.parametrize("case", CASES)
def test_tips_are_those_of_the_documents_formulas(case, units, tmp_path):
    module, letters, tool_pin, pins, formula = CASES[case]
    lines = [f"HALCMD = setp {module}.{name} {value}" for name, value in pins.items()]
    lines += [f"HALCMD = net tool motion.tooloffset.z => {module}.{tool_pin}"] if tool_pin else ["HALFILE = pivot.hal"]
    coordinates = "XYZBC" if module == "maxkins" else letters
    sections = {"GEOMETRY": {"PIVOT": 212.0}}
    path = written(
        tmp_path,
        mill_ini=ini_text(module, letters, coordinates=coordinates, units=units, sections=sections, lines=lines),
        pivot_hal=PIVOT if module == "5axiskins" else "setp motmod.nothing 0\n",
    )
    machine = read_control([path]).machine
    unit = MILLIMETRE if units == "mm" else INCH
    turning = sorted(set(letters) & set("ABC" if module != "maxkins" else "BC"))
    random = np.random.default_rng(5)
    for _ in range(20):
        nose, angles = random.uniform(-80.0, 80.0, 3), random.uniform(-100.0, 100.0, 2)
        q = np.zeros(5)
        for letter, value in zip("XYZ", nose):
            q[machine.joints.index(letter)] = value * unit
        for letter, value in zip(turning, angles):
            q[machine.joints.index(letter)] = value * DEGREE
        tip, _ = machine.forward(q, 0.0 if module == "maxkins" else TOOL * unit)
        assert tip == pytest.approx(formula(nose, *angles) * unit, abs=1e-12)


def test_a_pivot_that_a_program_sets_is_asked_for(tmp_path):
    hal = "net :pivot gui.pivot_len => 5axiskins.pivot-length\n"
    path = written(tmp_path, mill_ini=ini_text("5axiskins", "XYZBCW", lines=["HALFILE = mill.hal"]), mill_hal=hal)
    draft = read_control([path])
    question = draft.stand_ins[0]
    assert question.stand_in == "250" and "gui.pivot_len" in question.reason
    assert draft.machine.file.joints["B"].point == pytest.approx((0.0, 0.0, 0.25))
    answered = read_control([path], Answers(lambda each: "180" if "pivot" in each.what else ""))
    assert answered.machine.file.joints["B"].point == pytest.approx((0.0, 0.0, 0.18))
    assert "answered" in answered.text and len(answered.stand_ins) == len(draft.stand_ins) - 1


@pytest.mark.parametrize(
    ("letters", "arrangement", "kind"),
    [
        ("XYZAC", "AC/", "table-table"),
        ("XYZAC", "C/A", "head-table"),
        ("XYZBC", "/CB", "head-head"),
        ("XYZAB", "BA/", "table-table"),
        ("XYZB", "/B", "head-table"),
        ("XYZC", "C/", "table-table"),
        ("XYZA", "A/", "table-table"),
    ],
)
def test_axes_that_trivkins_does_not_place_are_placed_by_answers(letters, arrangement, kind, tmp_path):
    path = written(tmp_path, mill_ini=ini_text(f"trivkins coordinates={letters}", letters))
    on_table, _, on_tool = arrangement.partition("/")

    def answer(question):
        if "slash" in question.what:
            return arrangement
        return "1, 2, 3" if "point" in question.what else "yes" if "right-hand" in question.what else ""

    machine = read_control([path], Answers(answer)).machine
    assert machine.kind == kind
    turning = sorted(set(letters) & set("ABC"))
    held = [name for name in "ABC" if name in machine.joints and name not in turning]
    assert [each for each in machine.file.chain.workpiece if each not in held] == list(on_table)
    assert [each for each in machine.file.chain.tool[3:] if each not in held] == list(on_tool)
    for letter in turning:
        # a positive turn of each axis, alone, turns the tool about its letter by the right-hand rule
        q = np.zeros((2, 5))
        q[1, machine.joints.index(letter)] = 25 * DEGREE
        tip, axis = machine.forward(q)
        turn = _turn("xyz"["ABC".index(letter)], 25.0)
        assert axis[1] == pytest.approx(turn @ [0, 0, 1], abs=1e-12)
        point = np.array([1, 2, 3]) * MILLIMETRE
        assert tip[1] == pytest.approx(turn @ (tip[0] - point) + point)
    for letter in held:
        assert np.abs(machine.travel[machine.joints.index(letter)]).max() == pytest.approx(0.001 * DEGREE)


def test_a_wrong_answer_is_refused(tmp_path):
    path = written(tmp_path, mill_ini=ini_text("trivkins coordinates=XYZAC", "XYZAC"))
    with pytest.raises(ControlFileError, match="'AB/'; known: AC/, A/C, /AC, CA/, C/A, /CA"):
        read_control([path], Answers(lambda question: "AB/"))
    with pytest.raises(ControlFileError, match=r"a point on the axis of A.*'1, 2'; give 3 numbers, commas between"):
        read_control([path], Answers(lambda question: "1, 2" if "point" in question.what else ""))


def test_a_machine_of_three_axes_holds_the_others_at_zero(tmp_path):
    draft = read_control([written(tmp_path, mill_ini=ini_text("trivkins coordinates=XYZ", "XYZ"))])
    machine = draft.machine
    q = np.zeros(5)
    q[[machine.joints.index(letter) for letter in "XYZ"]] = 0.01, 0.02, 0.03
    tip, axis = machine.forward(q)
    assert tip == pytest.approx([0.01, 0.02, 0.03]) and axis == pytest.approx([0, 0, 1])
    assert "leans" not in draft.text and draft.text.count("the machine has no such axis: it is held at zero") == 16
    assert {name: machine.travel[k].tolist() for k, name in enumerate(machine.joints) if name in "AC"} == {
        name: pytest.approx([-0.001 * DEGREE, 0.001 * DEGREE]) for name in "AC"
    }

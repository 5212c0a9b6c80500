"""Set-up sheets: what is read, what is written, and one error a slip, with file, key, value and cure."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.virtual_control import control, go, joints, place
from toolpace.common.errors import MachineError, UsageError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text
from toolpace.programs.reading.control.machine_moves import reference, straight_in_machine
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.findings import Used
from toolpace.programs.reading.setup_file import load_setup, setup_in, setup_of_text, setup_sheet, setup_text

SHEET = """
[offsets.G54]
X = -120.5
A = 30
[offsets."g54.1p12"]
Z = 1
[references.2]
Z = -5
[machine_zero]
X = 500
[tools.05]
length = 120
[tools."MILL D10"]
length = 0.5
radius = 5
[part]
origin = [0, 0, 70]
z = [0, 0, 2]
[start]
X = 10
[variables]
"#500" = 3
"""


def test_figures_are_in_mm_and_degrees_unless_the_sheet_says_otherwise():
    setup = setup_of_text(SHEET)
    assert setup.offsets == {"G54": {"X": -0.1205, "A": math.radians(30)}, "G54.1 P12": {"Z": 0.001}}
    assert setup.references == {2: {"Z": -0.005}} and setup.machine_zero == {"X": 0.5} and setup.start == {"X": 0.01}
    assert setup.tools == {"5": Tool(0.12), "MILL D10": Tool(0.0005, 0.005)}
    assert setup.part == {"origin": (0.0, 0.0, 0.07), "z": (0.0, 0.0, 2.0)} and setup.variables == {"#500": 3.0}
    inches = setup_of_text('[units]\nlength = "in"\nangle = "rad"\n' + SHEET)
    assert inches.tools["5"].length == 120 * 0.0254 and inches.offsets["G54"]["A"] == 30.0


def test_a_sheet_is_written_so_that_it_reads_as_the_same_to_the_last_digit():
    r = np.random.default_rng(5)
    for _ in range(200):
        a, b, c = map(float, r.normal(size=3))
        setup = SetUp(
            source="set-up sheet",
            offsets={"G54": {"X": a, "C": b}, "G505": {}},
            references={1: {"Z": c}},
            machine_zero={"Y": a * b},
            tools={"1": Tool(abs(a), abs(b)), 'D "10"\t': Tool(abs(c))},
            part={"x": (a, b, c)},
            start={"A": b},
            variables={"#<depth>": a},
        )
        again = setup_of_text(setup_text(setup))
        assert again.tools == {"1": setup.tools["1"], 'D "10"': setup.tools['D "10"\t']}
        for key in ("offsets", "references", "machine_zero", "part", "start", "variables"):
            assert getattr(again, key) == getattr(setup, key)


@pytest.mark.parametrize(
    "text, words",
    [
        ("x = 1", ["unknown key 'x'", "offsets"]),
        ("ofsets = 1", ["unknown key 'ofsets'", "did you mean 'offsets'"]),
        ("offsets = 3", ["offsets = 3", "[offsets]"]),
        ("[offsets]\nG54 = 3", ["G54 = 3", "write it under [offsets.G54]"]),
        ('[offsets.G54]\nX = "a"', ["[offsets.G54]", "X = 'a'", "not a number", "mm"]),
        ("[offsets.G54]\nX = true", ["X = True", "not a number"]),
        ("[offsets.G54]\nx = 1", ["'x'", "X = 12.5"]),
        ("[offsets.G54]\nX = inf", ["X = inf", "not finite"]),
        (f"[offsets.G54]\nX = 1{'0' * 400}", ["X = 1000", "not finite"]),
        ("[offsets.G54]\nX = 2e6", ["X = 2000000.0", "more than 1e+06 mm", "check its unit"]),
        ('[offsets."G54.1 P1"]\nX = 1\n[offsets."G54.1P1"]\nX = 2', ["stands twice", "keep one"]),
        ("[tools.1]\nlength = -1", ["[tools.1]", "length = -1", "below zero"]),
        ("[tools.1]", ["[tools.1]", "says nothing", "mm"]),
        ("[tools.1]\nlength = 1\nlenght = 2", ["'lenght'", "did you mean 'length'"]),
        ("[references.9]\nX = 1", ["[references.9]", "1 to 4"]),
        ('[units]\nlength = "cm"', ["length = 'cm'", "'mm', 'm', 'in'"]),
        ("[part]\nz = [0, 0, 0]", ["[part] z has no length"]),
        ("[part]\norigin = 1", ["origin = 1", "[0, 0, 1]"]),
        ("[[tools]]\nlength = 1", ["tools", "not a table"]),
        ("[offsets.G54\nX = 1", ["not a TOML file", "line 1"]),
        ("a = " + "[" * 5000, ["sheet.toml"]),
    ],
)
def test_one_error_names_file_key_value_and_cure(text, words):
    with pytest.raises(UsageError) as caught:
        setup_of_text(text, "sheet.toml")
    message = str(caught.value)
    assert message.startswith("sheet.toml") and "\n" not in message and len(message) < 600
    for word in words:
        assert word in message


def test_files_that_cannot_be_read_are_said(tmp_path):
    with pytest.raises(UsageError, match="no such file"):
        load_setup(tmp_path / "gone.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="not a text file"):
        load_setup(tmp_path / "binary.toml")


def test_a_machine_file_may_hold_the_sheet_in_its_own_units():
    plain = Machine.load("xyzac-trunnion")
    text = plain.to_toml() + "\n[setup.offsets.G54]\nX = 1.5\n[setup.tools.3]\nlength = 100\n"
    machine = Machine.from_toml(text, "mill.toml")
    setup = setup_in(machine)
    assert setup.offsets == {"G54": {"X": 0.0015}} and setup.tools == {"3": Tool(0.1)}
    assert setup_in(Machine.from_toml(machine.to_toml())).tools == setup.tools
    assert Machine.from_toml(machine.to_toml()) == machine and machine != plain
    assert np.array_equal(machine.forward(np.ones((1, 5)))[0], plain.forward(np.ones((1, 5)))[0])
    with pytest.raises(MachineError, match="setup must be a table"):
        Machine.from_toml(plain.to_toml().replace('name = "xyzac', 'setup = 3\nname = "xyzac', 1))
    with pytest.raises(UsageError, match=r"mill.toml: \[setup\]: \[tools.3\] says nothing"):
        setup_in(Machine.from_toml(text.replace("length = 100", ""), "mill.toml"))


PROGRAM = "G43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F600\nM30\n"


def test_a_sheet_for_another_machine_is_refused():
    machine = Machine.load("xyzac-trunnion")
    with pytest.raises(UsageError, match=r"\[offsets.G54\] B: machine 'xyzac-trunnion' has no axis B"):
        read_text(PROGRAM, machine, setup=SetUp(offsets={"G54": {"B": 0.1}}))
    part = {"origin": (0.0, 0.0, 0.01)}
    with pytest.raises(UsageError, match=r"machine.mounted\(\*\*setup.part\)"):
        read_text(PROGRAM, machine, setup=SetUp(part=part))
    read_text(PROGRAM, machine.mounted(**part), setup=SetUp(part=part))


@pytest.mark.parametrize("name", ["xyzac-trunnion", "xyzbc-head", "xyzbc-nutating", "xyzab-trunnion-inch"])
def test_a_sheet_to_fill_in_says_what_was_taken_without_it(name):
    """Reading with the sheet as it is written gives the motion that there was without one, tool lengths reckoned."""
    machine = Machine.load(name)
    used = Used({"G54": None, "G55": None}, {1: None, 2: None}, {"4": None, "D8": None}, True)
    sheet = setup_of_text(setup_sheet("part.nc", used, machine, SetUp()), "sheet.toml")
    assert list(sheet.offsets) == ["G54", "G55"] and list(sheet.references) == [1, 2]
    found = []
    for setup in (SetUp(), sheet):
        made = control(machine, setup)
        made.set_offset("G54")
        made.set_length("4")
        go(made, place(0, 0, 0, 0, 0), place(1, 2, 3, 0, 0))
        made.set_tip_mode(True)
        go(made, place(5, 2, 3, 0, 0), place(5, 6, 7, 10, 20))
        straight_in_machine(made, {"Z": 0.0})
        reference(made, 1, ["X", "Z"])
        found.append(joints(made, machine))
    assert found[0] == pytest.approx(found[1], abs=1e-9)


def test_a_sheet_to_fill_in_keeps_what_is_known():
    given = SetUp(offsets={"G54": {"X": 0.1}}, tools={"4": Tool(0.07, 0.002)}, machine_zero={"X": 0.25})
    machine = Machine.load("xyzac-trunnion")
    text = setup_sheet("part.nc", Used({"G54": None}, {}, {"04": None}, False), machine, given)
    again = setup_of_text(text)
    assert again.offsets["G54"]["X"] == pytest.approx(0.1) and again.machine_zero["X"] == 0.25
    assert again.tools["4"] == Tool(0.07, 0.002)
    assert all(line.startswith(("#", "[")) or " = " in line for line in text.splitlines() if line)


LONG = "9" * 4400


@pytest.mark.parametrize(
    "sheet, told",
    [
        (
            f'[variables]\n"#{LONG}" = 1\n',
            r"^set-up sheet: \[variables\] has the name '#9{39}\.\.\.', of 4401 characters",
        ),
        (f'[offsets."{"(" * 1100}"]\nX = 1\n', r"^set-up sheet: \[offsets\] has the name '\({40}\.\.\.', of 1100"),
        (f"[tools.T{LONG}]\nlength = 1\n", r"^set-up sheet: \[tools\] has the name"),
    ],
)
def test_a_name_without_end_is_told_in_short(sheet, told):
    """Found by fuzzing: digits beyond what Python turns into a number, names that fill a page."""
    with pytest.raises(UsageError, match=told) as caught:
        setup_of_text(sheet)
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize("controller", ["fanuc", "linuxcnc", "sinumerik", "heidenhain"])
def test_digits_of_other_kinds_are_no_numbers(controller):
    """A superscript is a digit to Python, and no number."""
    given = setup_of_text('[variables]\n"#\u00b2" = 1\n"R\u00b2" = 2\n"Q\u00b2" = 3\n"#\u0663" = 4\n')
    text = "L X+1 R0 F100\nL X+2\nM30\n" if controller == "heidenhain" else "G1 X1 F100\nX2\nM30\n"
    path = read_text(text, None, "gcode", controller=controller, setup=given)
    assert path.tip[-1, 0] == pytest.approx(0.002)


def test_the_corner_radius_of_a_tool_is_read_and_written():
    setup = setup_of_text("[tools.7]\nlength = 100\nradius = 6\ncorner_radius = 2\n[tools.8]\nlength = 90\n")
    assert setup.tools == {"7": Tool(0.1, 0.006, 0.002), "8": Tool(0.09)}
    assert setup_of_text(setup_text(setup)) == setup
    written = setup_sheet("part.nc", Used({}, {}, {"7": None}, False), None, setup)
    assert setup_of_text(written).tools == setup.tools
    with pytest.raises(UsageError, match="corner_radius"):
        setup_of_text("[tools.7]\nlength = 100\ncorner_radius = -1\n")

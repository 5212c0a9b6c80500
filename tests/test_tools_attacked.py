"""Tools of several lengths where programs are careless: lengths named late, taken back, or of the tool before."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.true_tip.cases import BUILTIN
from testbed.true_tip.chain import Chain
from toolpace.programs.reading.setup_file import setup_of_text

MACHINES = ("xyzac-trunnion", "xyzbc-head", "xyzbc-nutating")
OFFSET, ZERO = np.array([0.02, -0.03, -0.15]), np.array([0.05, 0.02, 0.1])
SHEET = """\
[tools.1]
length = 110
[tools.2]
length = 170
[machine_zero]
X = 50
Y = 20
Z = 100
[offsets.G54]
X = 20
Y = -30
Z = -150
"""
WORDS = {"X": 0.02, "Y": 0.01, "Z": 0.2}
TURNED = 10.0, 20.0
"""Both rotary joints where a program ends [deg]."""


class Read:
    """The end of a program whose last block goes to `WORDS` and `TURNED`, and the joints there [m, rad]."""

    def __init__(self, name, controller, begin, suffix=".nc", equals="", close=(), sheet=SHEET):
        self.chain = Chain((BUILTIN / f"{name}.toml").read_text())
        self.machine = tp.Machine.load(name)
        turned = " ".join(f"{joint}{equals}{value}" for joint, value in zip(self.chain.rotary, TURNED))
        upright = " ".join(f"{joint}{equals}0" for joint in self.chain.rotary)
        lines = [line.replace("UPRIGHT", upright) for line in begin] + [f"G1 X20 Y10 Z200 {turned} F500", *close]
        self.sheet = sheet
        self.line = len(lines) - len(close)
        end = ["M30"] if controller in ("fanuc", "haas", "linuxcnc") else []
        setup, text = setup_of_text(self.sheet), "\n".join([*lines, *end]) + "\n"
        self.path = tp.read_text(text, self.machine, setup=setup, controller=controller, name="x" + suffix)

    @property
    def length(self):
        """Of the tool in the spindle, as the path tells it at the end [m]."""
        return float(self.path.tool_length[np.flatnonzero(self.path.block == self.line)[-1]])

    @property
    def joints(self):
        """(m,) at the end, by kinematics of the test's own [m, rad]."""
        at = np.flatnonzero(self.path.block == self.line)[-1]
        rotary = dict(zip(self.path.rotary_joints, self.path.rotary[at : at + 1].T))
        return self.chain.joints(self.path.tip[at : at + 1], rotary, self.length)[0]

    def expected_of_joints(self, length):
        """Where words are joints, and a length [m] counts in them."""
        q = np.zeros(len(self.chain.names))
        for letter, value, zero, offset in zip("XYZ", WORDS.values(), ZERO, OFFSET):
            q[self.chain.names.index(letter)] = value + zero + offset + length * (letter == "Z")
        for joint, value in zip(self.chain.rotary, TURNED):
            q[self.chain.names.index(joint)] = np.radians(value)
        return q

    def expected_of_tip(self, length):
        """Where words are the tip, on the part, of a tool of this length [m]."""
        nose = np.zeros((1, len(self.chain.names)))
        for letter, zero, offset in zip("XYZ", ZERO, OFFSET):
            nose[0, self.chain.names.index(letter)] = zero + offset
        tip = self.chain.forward(nose, 0.0)[0] + np.array(list(WORDS.values()))
        rotary = {joint: np.radians([value]) for joint, value in zip(self.chain.rotary, TURNED)}
        return self.chain.joints(tip, rotary, length)[0]


FIRST = ["G21 G90 G94 G17", "G54", "T1 M6", "G43 H1", "G0 X0 Y0 Z50 UPRIGHT", "G1 X10 F500"]
LINUXCNC = ["G21 G90 G94 G17", "G54", "T1 M6", "G43 H1", "M428", "G0 X0 Y0 Z50 UPRIGHT", "G1 X10 F500"]


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("controller", ["fanuc", "haas", "linuxcnc"])
def test_a_length_that_is_taken_back_after_a_change_was_of_the_tool_before(name, controller):
    """T2 M6, then G49 on a line of its own: tool 2 is in the spindle, however long tool 1 was."""
    found = Read(name, controller, [*FIRST, "T2 M6", "G49"])
    assert found.length == 0.17
    assert found.joints == pytest.approx(found.expected_of_joints(0.0), abs=1e-12)
    assert found.path.operations[-1].told_lengths == ()


@pytest.mark.parametrize("name", MACHINES)
def test_a_length_that_stays_in_force_is_that_of_its_number(name):
    found = Read(name, "linuxcnc", [*LINUXCNC, "T2 M6"])
    assert found.length == 0.11
    assert found.joints == pytest.approx(found.expected_of_tip(0.11), abs=1e-12)


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(
    "between",
    [["G49"], ["M429", "G49", "M428"], ["M429", "G49", "T2 M6", "M428"], ["M429", "T2 M6", "G49", "M428"]],
)
def test_tip_mode_without_a_length_means_the_nose(name, between):
    """M428 after G49: LinuxCNC's kinematics have a tool of no length then, whatever number was named before."""
    found = Read(name, "linuxcnc", [*LINUXCNC, *between])
    assert found.length == 0.0
    assert found.joints == pytest.approx(found.expected_of_tip(0.0), abs=1e-12)


@pytest.mark.parametrize("name", MACHINES)
def test_a_length_named_again_counts_again(name):
    found = Read(name, "linuxcnc", [*LINUXCNC, "G49", "T2 M6", "G43 H2"])
    assert found.length == 0.17
    assert found.joints == pytest.approx(found.expected_of_tip(0.17), abs=1e-12)


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(("words", "length"), [(["D0"], 0.0), (["D0", "D1"], 0.11), (["TRAFOOF", "D0", "TRAORI"], 0.0)])
def test_no_edge_means_no_length_under_traori(name, words, length):
    start = ["G71 G90 G94 G17 G40", "T1 D1", "M6", "G54", "TRAORI", "G0 X0 Y0 Z50 UPRIGHT"]
    found = Read(name, "sinumerik", [*start, *words], ".mpf", "=", ["M30"])
    assert found.length == length
    assert found.joints == pytest.approx(found.expected_of_tip(length), abs=1e-12)


@pytest.mark.parametrize("name", MACHINES)
def test_and_the_machines_own_tool_where_no_sheet_tells_of_offsets(name):
    """The stand-in of words that are joints, G49 or not; so without a sheet nothing moves at G49."""
    found = Read(name, "linuxcnc", [*LINUXCNC, "G49"], sheet=SHEET.partition("[machine_zero]")[0])
    assert found.length == found.machine.tool_length
    bare = Read(name, "linuxcnc", [*LINUXCNC, "G49"], sheet="")
    assert np.isnan(bare.path.tool_length).all()
    assert bare.path.tip[-1] == pytest.approx(list(WORDS.values()), abs=1e-12)


def test_a_g49_in_the_first_line_takes_no_length_from_a_tool():
    """Nothing was reckoned with before it; M428 without G43 means the tool in the spindle, as ever."""
    start = ["G21 G90 G94 G17 G40 G49", "G54", "T2 M6", "M428", "G0 X0 Y0 Z50 UPRIGHT"]
    assert Read("xyzbc-head", "linuxcnc", start).length == 0.17


def test_the_judge_knows_a_nose_that_the_program_tells():
    found = Read("xyzbc-head", "linuxcnc", [*LINUXCNC, "G49", "G1 Z200"])
    plan = tp.plan_program(found.path, found.machine, tip_tolerance=10e-6, axis_tolerance=1e-3, effort="low")
    points = plan.trajectory.sample(2e-3)
    assert set(points.tool_length) == {0.11, 0.0}
    for length in (0.11, 0.0):
        rows = points.tool_length == length
        real = found.chain.forward(points.q[rows], length)[0]
        assert np.abs(points.tip[rows] - real).max() < 1e-12
    verdict = tp.verify(points, found.machine, found.path, 10e-6, 1e-3, sheet=found.sheet)
    verdict.raise_if_failed()

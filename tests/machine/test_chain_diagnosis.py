"""Errors of a chain name the slip that most likely made it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.machines import CLASSES, oracle, random_machine
from toolpace.common.errors import MachineError, ReachError
from toolpace.machine.geometry import leaning, shown, tool_axis
from toolpace.machine.machine import FOLDER, Machine
from toolpace.programs.reading import read_text


def changed(name: str, *changes: tuple[str, str]) -> str:
    text = (FOLDER / f"{name}.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


REVERSED = {
    "workpiece": (
        changed("xyzac-trunnion", ('["A", "C"]', '["C", "A"]')),
        r'workpiece goes from the bed to the workpiece, and is \["C", "A"\]; should it be \["A", "C"\]\? '
        r"As it stands A \+30 deg leans the tool axis to \(0, -0.5, 0.866\), and C \+30 deg leaves",
    ),
    "workpiece with a linear joint": (
        changed("xyzbc-table", ('["X", "B", "C"]', '["C", "B", "X"]')),
        r'and is \["C", "B", "X"\]; should it be \["X", "B", "C"\]\?',
    ),
    "two of the tool": (
        changed("xyzac-head", ('"C", "A"]', '"A", "C"]')),
        r'tool goes from the bed to the tool, .* \["X", "Y", "Z", "A", "C"\]; should it be \["X", "Y", "Z", "C", "A"\]',
    ),
    "the whole tool": (
        changed("xyzac-head", ('["X", "Y", "Z", "C", "A"]', '["A", "C", "Z", "Y", "X"]')),
        r'should it be \["X", "Y", "Z", "C", "A"\]',
    ),
    "sides": (
        changed("xyzbc-millturn", ('workpiece = ["C"]', 'workpiece = ["B"]'), ('"Z", "B"]', '"Z", "C"]')),
        r"C turns about the tool axis and cannot tilt it: should C be in \[chain\] workpiece, and B in tool\?",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REVERSED)
def test_order_of_the_chain(case: str) -> None:
    text, says = REVERSED[case]
    with pytest.raises(MachineError, match=says) as caught:
        Machine.from_toml(text, "m.toml")
    assert str(caught.value).startswith("m.toml: ") and str(caught.value).isprintable()


def test_what_is_proposed_is_a_machine() -> None:
    """Every built-in chain with its rotary joints exchanged: what the error proposes loads, and is the machine."""
    import re

    refused = 0
    for name in Machine.names():
        machine = Machine.load(name)
        first, second = machine.geometry.rotary_joints
        chain = machine.file.chain
        for side, order in (("workpiece", chain.workpiece), ("tool", chain.tool)):
            if first not in order or second not in order:
                continue
            given = [{first: second, second: first}.get(joint, joint) for joint in order]
            text = re.sub(rf"^{side} = .*$", f"{side} = {given}".replace("'", '"'), machine.to_toml(), flags=re.M)
            try:
                Machine.from_toml(text)
            except MachineError as error:
                meant = re.search(r"should it be (\[.*?\])\?", str(error))
                assert meant and meant[1] == str(list(order)).replace("'", '"')
                refused += 1
    assert refused == 8


def test_directions_are_named() -> None:
    with pytest.raises(MachineError, match=r"C and A are parallel; .* directions \[0, 0, -1\] and \[0, 0, 1\]"):
        Machine.from_toml(changed("xyzac-trunnion", ("[-1, 0, 0]", "[0, 0, 1]")))
    with pytest.raises(
        MachineError, match=r"X and Z move along one line, directions \[1, 0, 0\] and \[-1, 0, 0\]: correct one"
    ):
        Machine.from_toml(changed("xyzac-trunnion", ("direction = [0, 0, 1]", "direction = [-1, 0, 0]")))


def test_a_point_of_a_rotary_axis_must_be_given_and_a_linear_joint_needs_none() -> None:
    with pytest.raises(MachineError, match=r"m.toml: joint C: point is missing; a rotary joint needs a point"):
        Machine.from_toml(changed("xyzac-trunnion", ("0, -1]\npoint = [0, 0, 0]", "0, -1]")), "m.toml")


@pytest.mark.parametrize("kind", CLASSES)
def test_leaning_is_what_the_oracle_finds(kind: str) -> None:
    rng = np.random.default_rng(12)
    for _ in range(50):
        machine = random_machine(rng, kind)
        t1, t2 = rng.uniform(-3.0, 3.0, 2)
        q = np.zeros(5)
        q[machine.rotary] = t1, t2
        np.testing.assert_allclose(tool_axis(machine.geometry.frame, t1, t2), oracle(machine, q)[1], atol=1e-13)
        for k, says in enumerate(machine.geometry.leanings):
            q = np.zeros(5)
            q[machine.rotary[k]] = np.radians(30.0)
            assert says == f"R{k + 1} +30 deg leans the tool axis to {shown(oracle(machine, q)[1])}"


def test_a_joint_that_never_tilts_the_tool_says_so() -> None:
    upright = np.array([[0.0, 0, 1], [0, 0, 1], [0, 0, 1]])
    assert leaning(("C", "D"), upright, 0) == "C +30 deg leaves the tool axis where it is"


def test_wrong_sign_of_a_direction_is_pointed_at() -> None:
    """A cradle that tilts to one side, and a program that needs the other one."""
    one_sided = ("[-130, 130]", "[-130, 0]")
    machine = Machine.from_toml(changed("xyzac-trunnion", one_sided, ("wrap = true", "travel = [-5, 5]")))
    cl = "FEDRAT/100\nGOTO/0,0,0,0,0,1\nGOTO/0,0,0,0,-0.5,0.866\n"
    with pytest.raises(
        ReachError,
        match=r"outside the travel .*; is the sign of \[joints.A\] direction right\? With the other one A would reach "
        r"it; as it is A \+30 deg leans the tool axis to \(0, -0.5, 0.866\); mount the part",
    ):
        machine.choose_rotary(read_text(cl, machine, "apt"))
    other = Machine.from_toml(
        changed("xyzac-trunnion", one_sided, ("wrap = true", "travel = [-5, 5]"), ("[-1, 0, 0]", "[1, 0, 0]"))
    )
    assert other.choose_rotary(read_text(cl, other, "apt"))[-1, 1] == pytest.approx(-np.radians(30), abs=1e-4)

    words = "G43.4\nG0 X0 Y0 Z0 A0 C0\nG1 X1 A20 F100\n"
    with pytest.raises(ReachError, match=r"joint A would have to go to 20.000 deg, above .* \[joints.A\] direction"):
        machine.choose_rotary(read_text(words, machine, "gcode"))


def test_no_sign_is_blamed_where_the_other_one_would_not_help() -> None:
    machine = Machine.load("xyzac-trunnion")
    beyond = read_text("FEDRAT/100\nGOTO/0,0,0,0,0,1\nGOTO/0,0,0,0,-0.5,-0.866\n", machine, "apt")
    with pytest.raises(ReachError) as caught:
        machine.choose_rotary(beyond)
    assert "sign" not in str(caught.value)
    words = read_text("G43.4\nG0 X0 Y0 Z0 A-131 C0\nG1 X1 A20 F100\n", machine, "gcode")
    with pytest.raises(ReachError) as caught:
        machine.choose_rotary(words)
    assert "sign" not in str(caught.value)
    linear = read_text("G43.4\nG0 X0 Y0 Z0 A0 C0\nG1 X900 F100\n", machine, "gcode")
    with pytest.raises(ReachError, match="joint X would have to go to 900") as caught:
        machine.choose_rotary(linear)
    assert "sign" not in str(caught.value)

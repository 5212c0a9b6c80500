"""Kinematic chains of a Sinumerik ($NK_, $NT_) against a walk along their elements, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.sinumerik_archive import changed
from toolpace.machine.from_control import MachineDraft, read_control
from toolpace.machine.from_control.control_file import ControlFileError

AXES = [
    "N10240 $MN_SCALING_SYSTEM_IS_METRIC=1",
    *(f'N10000 $MN_AXCONF_MACHAX_NAME_TAB[{k}]="{name}1"' for k, name in enumerate("XYZBCS")),
    "$MA_SPIND_ASSIGN_TO_MACHAX[S1]=1",
]
Element = tuple[str, str, list[float], float]
"""Kind, axis, vector, and what is added to the position [mm, deg]."""


def _lines(tool: list[Element], table: list[Element], shared: list[Element]) -> list[str]:
    """A chain whose sides part behind the shared elements; the table's begins beside the tool's."""
    lines, number = list(AXES), 0
    for letter, elements in (("R", shared), ("T", tool), ("P", table)):
        for k, (kind, axis, vector, position) in enumerate(elements):
            follows = f"{letter}{k + 1}" if k + 1 < len(elements) else "T0" if letter == "R" else ""
            lines += [f'$NK_NAME[{number}]="{letter}{k}"', f'$NK_TYPE[{number}]="{kind}"']
            lines += [f"$NK_OFF_DIR[{number},{i}]={vector[i]!r}" for i in range(3)]
            lines += [f'$NK_NEXT[{number}]="{follows}"', f'$NK_AXIS[{number}]="{axis}"']
            lines += [f"$NK_A_OFF[{number}]={position!r}"]
            if (letter, k) == ("T", 0):
                lines.append(f'$NK_PARALLEL[{number}]="P0"')
            number += 1
    ends = f'$NT_T_CHAIN_LAST_ELEM[1]="T{len(tool) - 1}"', f'$NT_P_CHAIN_LAST_ELEM[1]="P{len(table) - 1}"'
    return [*lines, '$NT_TRAFO_TYPE[1]="TRAORI_DYN"', *ends]


def _end(elements: list[Element], positions: dict[str, float]) -> tuple[np.ndarray, Rotation]:
    """Place [mm] and turn of the end, element by element; positions in mm and rad."""
    at, turn = np.zeros(3), Rotation.identity()
    for kind, axis, vector, position in elements:
        along = np.array(vector)
        if kind == "OFFSET":
            at = at + turn.apply(along)
        elif kind == "AXIS_LIN":
            at = at + turn.apply(along / np.linalg.norm(along)) * (positions[axis] + position)
        elif axis != "S1":
            turn = turn * Rotation.from_rotvec(along / np.linalg.norm(along) * (positions[axis] + np.radians(position)))
    return at, turn


def _sides(kind: str, chance: np.random.Generator) -> tuple[list[Element], list[Element]]:
    def offset() -> Element:
        return "OFFSET", "", chance.uniform(-300.0, 300.0, 3).round(3).tolist(), 0.0

    def turning(axis: str, about: tuple[float, float, float]) -> Element:
        direction = np.array(about) + 0.1 * chance.normal(size=3)
        return "AXIS_ROT", axis, direction.round(4).tolist(), round(float(chance.uniform(-40.0, 40.0)), 3)

    b, c = turning("B1", (0.0, 1.0, 0.0)), turning("C1", (0.0, 0.0, -1.0))
    y, z = ("AXIS_LIN", "Y1", [0.0, 3.0, 0.0], 5.0), ("AXIS_LIN", "Z1", [0.0, 0.0, 1.0], 0.0)
    x = ("AXIS_LIN", "X1", [-2.0, 0.0, 0.0], -7.0)
    head = {"T": [c, offset(), b, offset()], "P": [], "M": [b, offset()]}[kind]
    table = {"T": [], "P": [b, offset(), c, offset()], "M": [c, offset()]}[kind]
    spindle: Element = ("AXIS_ROT", "S1", [0.0, 0.0, 1.0], 0.0)
    return [offset(), y, offset(), z, offset(), *head, spindle], [offset(), x, offset(), *table]


def _read(folder: Path, lines: list[str]) -> MachineDraft:
    (folder / "mill.arc").write_text("\n".join(lines))
    return read_control([folder / "mill.arc"])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["T", "P", "M"])
def test_tip_and_axis_are_those_of_a_walk_along_the_elements(kind: str, seed: int, tmp_path: Path):
    chance = np.random.default_rng(seed)
    tool, table = _sides(kind, chance)
    shared: list[Element] = [("OFFSET", "", [1.0, 2.0, 3.0], 0.0), ("OFFSET", "", [-4.0, 5.0, 60.0], 0.0)]
    length = 87.3
    machine = _read(tmp_path, _lines(tool, table, shared)).machine.with_tool(length * 1e-3)
    names = ("X", "Y", "Z", "B", "C")
    q = np.hstack([chance.uniform(-500.0, 500.0, (20, 3)), chance.uniform(-3.0, 3.0, (20, 2))])
    joints = np.empty((20, 5))
    joints[:, [machine.joints.index(name) for name in names]] = q * [1e-3, 1e-3, 1e-3, 1.0, 1.0]
    tip, axis = machine.forward(joints)
    for k in range(20):
        positions = {f"{name}1": float(value) for name, value in zip(names, q[k])}
        (at, turn), (zero, frame) = _end(tool, positions), _end(table, positions)
        point = at + turn.apply([0.0, 0.0, -length])
        assert tip[k] * 1e3 == pytest.approx(frame.inv().apply(point - zero), abs=1e-8)
        assert axis[k] == pytest.approx(frame.inv().apply(turn.apply([0.0, 0.0, 1.0])), abs=1e-9)


def test_a_chain_is_closed_as_swivel_data_are(tmp_path: Path):
    tool, table = _sides("M", np.random.default_rng(5))
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    by_bits = _read(tmp_path, [*lines, f"$NT_CNTRL[1]={2**7 + 2**8}"])
    by_names = _read(tmp_path, [*lines, '$NT_CLOSE_CHAIN_T[1]="T0"', f'$NT_CLOSE_CHAIN_P[1]="P{len(table) - 1}"'])
    zero = np.zeros((1, 5))
    zero[0, by_bits.machine.joints.index("B")], zero[0, by_bits.machine.joints.index("C")] = (
        -np.radians(next(position for _, axis, _, position in side if axis == name))
        for side, name in ((tool, "B1"), (table, "C1"))
    )
    for draft in (by_bits, by_names):
        # where the turning axes are as they were measured, nose and table are both at machine zero
        assert draft.machine.forward(zero)[0] == pytest.approx(np.zeros((1, 3)), abs=1e-12)
        assert sum("closes the chain" in remark for remark in draft.record.remarks) == 2


def test_the_spindle_tells_the_direction_of_the_tool(tmp_path: Path):
    tool, table = _sides("P", np.random.default_rng(6))
    tool[-1] = ("AXIS_ROT", "S1", [0.0, 1.0, 0.0], 0.0)
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    draft = _read(tmp_path, [*lines, f"$NT_CNTRL[1]='H{2**19 + 2**20:X}'"])
    assert draft.record.chain["tool_axis"].value == (0.0, -1.0, 0.0)


REFUSED = {
    "a table that goes the wrong way": (
        {"$NK_OFF_DIR[10,0]": "2"},
        r"\$NK_OFF_DIR\[10,0\] to \[10,2\] is 2, 0, 0, and X carries the workpiece to the negative side of X",
    ),
    "a name that is no element's": ({"$NK_NEXT[9]": '"P9"'}, r"NK_NEXT\[9\] = \"P9\" is the name of no element"),
    "a circle": ({"$NK_PARALLEL[1]": None, "$NK_NEXT[4]": '"T2"'}, r"NK_NEXT\[4\] = \"T2\" is also "),
    "two of one name": ({"$NK_NAME[10]": '"P0"'}, r"NK_NAME\[10\] = \"P0\" is also .*; correct one"),
    "no type": ({"$NK_TYPE[10]": None}, r"NK_NAME\[10\] = \"P1\" has no \$NK_TYPE\[10\]"),
    "a switch": ({"$NK_TYPE[9]": '"SWITCH"'}, "chains that are switched over are not read"),
    "a constant turn": ({"$NK_TYPE[9]": '"ROT_CONST"', "$NK_A_OFF[9]": "30"}, "a constant turn is not read"),
    "a type of another age": ({"$NK_TYPE[9]": '"BODY"'}, r"= BODY; elements are AXIS_LIN"),
    "no such axis": ({"$NK_AXIS[10]": '"U1"'}, r"NK_AXIS\[10\] = U1, and the channel has no such axis"),
    "no axis": ({"$NK_AXIS[10]": '""'}, r"NK_TYPE\[10\] = AXIS_LIN has no \$NK_AXIS"),
    "no direction": ({"$NK_OFF_DIR[12,2]": "0"}, r"NK_OFF_DIR\[12,0\] to \[12,2\] is no direction of B\b"),
    "a slide on the table": ({"$NK_AXIS[10]": '"B1"', "$NK_TYPE[10]": '"AXIS_ROT"', "$NK_AXIS[12]": '"X1"',
        "$NK_TYPE[12]": '"AXIS_LIN"'}, "moves X behind the turning axis B; a machine here turns no slides"),
    "no end": ({"$NT_T_CHAIN_LAST_ELEM[1]": '""', "$NT_P_CHAIN_LAST_ELEM[1]": None}, "has no .NT_T_CHAIN_LAST_ELEM"),
    "an end that is no element": ({"$NT_P_CHAIN_LAST_ELEM[1]": '"P77"'}, "is the name of no element"),
    "closed between the axes": ({"$NT_CLOSE_CHAIN_P[1]": '"P4"'}, "not closed behind the last turning axis"),
    "one axis twice": ({"$NK_AXIS[14]": '"B1"'}, "is of the axis B, as is"),
}  # fmt: skip


@pytest.mark.parametrize(("values", "message"), REFUSED.values(), ids=REFUSED)
def test_chains_that_cannot_be_meant_are_refused(values: dict[str, str | None], message: str, tmp_path: Path):
    tool = [("OFFSET", "", [0.0, 0.0, float(k + 1)], 0.0) for k in range(4)]
    tool += [("AXIS_LIN", "Y1", [0.0, 1.0, 0.0], 0.0), ("OFFSET", "", [1.0, 0.0, 0.0], 0.0)]
    tool += [("AXIS_LIN", "Z1", [0.0, 0.0, 1.0], 0.0), ("OFFSET", "", [0.0, 0.0, 4.0], 0.0)]
    table = [
        ("OFFSET", "", [0.0, 1.0, 0.0], 0.0), ("AXIS_LIN", "X1", [-1.0, 0.0, 0.0], 0.0),
        ("OFFSET", "", [1.0, 0.0, 0.0], 0.0), ("AXIS_ROT", "B1", [0.0, 0.0, -1.0], 0.0),
        ("OFFSET", "", [1.0, 0.0, 0.0], 0.0), ("AXIS_ROT", "C1", [0.0, 0.0, -1.0], 0.0),
    ]  # fmt: skip
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    with pytest.raises(ControlFileError, match=message):
        _read(tmp_path, changed(lines, values))


def test_of_two_axes_along_one_direction_the_other_rests(tmp_path: Path):
    """A quill in the head: its display is zero, and its place in the chain an offset like others."""
    tool, table = _sides("P", np.random.default_rng(9))
    plain = _read(tmp_path, _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)]))
    quill: Element = ("AXIS_LIN", "W1", [0.0, 0.0, 1.0], 0.0)
    for place in (0, len(tool) - 1):
        own = [*tool[:place], quill, *tool[place:]]
        lines = _lines(own, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
        draft = _read(tmp_path, [*lines, '$MN_AXCONF_MACHAX_NAME_TAB[6]="W1"'])
        assert draft.machine.file.joints == plain.machine.file.joints
        (told,) = (each for each in draft.record.remarks if "rests at zero" in each)
        assert told.startswith("W (") and told.endswith("it moves as Z does.")


def test_a_chain_without_a_transformation_is_told(tmp_path: Path):
    tool, table = _sides("P", np.random.default_rng(7))
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    draft = _read(tmp_path, changed(lines, {"$NT_TRAFO_TYPE[1]": '"TRANSMIT_K"'}))
    assert any("no $NT_TRAFO_TYPE = TRAORI_DYN says where" in remark for remark in draft.record.remarks)


def test_of_several_transformations_that_of_five_axis_programs_is_taken(tmp_path: Path):
    tool, table = _sides("P", np.random.default_rng(7))
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    other = ['$NT_TRAFO_TYPE[0]="TRAORI_STAT"', '$NT_T_CHAIN_LAST_ELEM[0]="R0"']
    draft = _read(tmp_path, [*lines, *other])
    assert draft.machine.file.joints == _read(tmp_path, lines).machine.file.joints
    assert any("$NT_TRAFO_TYPE[0] = TRAORI_STAT is not read" in remark for remark in draft.record.remarks)


def test_swivel_data_of_the_same_axes_must_agree(tmp_path: Path):
    tool, table = _sides("P", np.random.default_rng(8))
    lines = _lines(tool, table, [("OFFSET", "", [0.0, 0.0, 1.0], 0.0)])
    carrier = ["$TC_CARR8[1]=1", "$TC_CARR12[1]=-1", "$TC_CARR21[1]=B1", "$TC_CARR22[1]=C1", '$TC_CARR23[1]="P"']
    assert any("of the swivel data is" in remark for remark in _read(tmp_path, [*lines, *carrier]).record.remarks)
    with pytest.raises(ControlFileError, match=r"TC_CARR10.* turns C in the other sense than"):
        _read(tmp_path, [*lines, *changed(carrier, {"$TC_CARR12[1]": "1"}), "$TC_CARR10[1]=0", "$TC_CARR11[1]=0"])

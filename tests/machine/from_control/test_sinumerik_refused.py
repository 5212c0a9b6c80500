"""What contradicts itself in a Sinumerik's files is refused with both lines; whatever a file holds, in one line."""

from __future__ import annotations

import random
import time
import warnings

import numpy as np
import pytest

from tests.support.sinumerik_archive import Archive, changed
from toolpace.common.errors import ToolpaceError, UnitWarning
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError
from toolpace.machine.machine import Machine

TABLE, HEAD, MIXED = (Archive(Machine.load(name)) for name in ("xyzac-trunnion", "xyzbc-head", "xyzbc-millturn"))
ARCHIVES = {
    "table": [*TABLE.axes(), *TABLE.transformation(1, 1, 40)],
    "letters": [*TABLE.axes(), *TABLE.transformation(1, 1, 33)],
    "swivel table": [*TABLE.axes(), *TABLE.carrier(1)],
    "both": [*TABLE.axes(), *TABLE.transformation(1, 1, 40), *TABLE.carrier(1)],
    "head": [*HEAD.axes(), *HEAD.transformation(1, 1, 24)],
    "swivel head": [*HEAD.axes(), *HEAD.carrier(1)],
    "mixed": [*MIXED.axes(), *MIXED.carrier(1)],
    "elements": [*MIXED.axes(), *MIXED.elements(np.zeros(3))],
}
CONTRADICTIONS = {
    "a table with a head's vector": ("table", {"$MC_TRAFO5_JOINT_OFFSET_PART_1[1]": "2"}, "TYPE_1", "in the table"),
    "a head with a table's vector": ("head", {"$MC_TRAFO5_JOINT_OFFSET_PART_1[1]": "20"}, "TYPE_1", "in the head"),
    "swivel data of a table with I1": ("swivel table", {"$TC_CARR3[1]": "5"}, "$TC_CARR23", "I1 is of the other side"),
    "a closing vector with a wrong sign": ("table", {"$MC_TRAFO5_PART_OFFSET_1[2]": "-220"}, "BASE_TOOL", "sign of"),
    "a swivel table's with a wrong sign": ("swivel table", {"$TC_CARR20[1]": "-220"}, "$TC_CARR4", "sign of"),
    "a channel axis' name twice": ("table", {"$MC_AXCONF_CHANAX_NAME_TAB[4]": '"A"'}, "NAME_TAB[3]", "is also"),
    "a machine axis' name twice": ("table", {"$MN_AXCONF_MACHAX_NAME_TAB[2]": '"MX4"'}, "NAME_TAB", "is also"),
    "a machine axis twice": ("table", {"$MC_AXCONF_MACHAX_USED[4]": "1"}, "MACHAX_USED[3]", "= 1 is also"),
    "an axis twice in a transformation": ("table", {"$MC_TRAFO_AXES_IN_1[4]": "4"}, "AXES_IN_1[3]", "= 4 is also"),
    "a swivel axis twice": ("swivel table", {"$TC_CARR22[1]": "(A)"}, "$TC_CARR7", "is of the axis A, as is"),
    "letters other than the type's": ("letters", {"$MC_TRAFO_TYPE_1": "35"}, "$MC_TRAFO_TYPE_1 = 35", "about B's"),
    "X and Y changed": (
        "table", {"$MC_TRAFO_AXES_IN_1[0]": "2", "$MC_TRAFO_AXES_IN_1[1]": "1"}, "GEOAX_ASSIGN_TAB[0] = 1", "which",
    ),
    "Y and Z changed": (
        "swivel table", {"$MC_AXCONF_GEOAX_ASSIGN_TAB[1]": "3", "$MC_AXCONF_GEOAX_ASSIGN_TAB[2]": "2"}, "NAME_TAB[2]",
        "= 3 for Y is the axis Z",
    ),
    "a turning axis that is linear": ("table", {"$MA_IS_ROT_AX[AX1]": "0"}, "CHANAX_NAME_TAB[3]", "which turns"),
    "a linear axis that turns": ("table", {"$MA_IS_ROT_AX[AX4]": "1"}, "CHANAX_NAME_TAB[0]", "which is linear"),
    "travel without room": ("table", {"$MA_POS_LIMIT_MINUS[AX4]": "600"}, "POS_LIMIT_PLUS", "is not below"),
    "a head and a table": ("both", {"$TC_CARR23[1]": '"T"', "$TC_CARR18[1]": "0", "$TC_CARR19[1]": "0",
                                    "$TC_CARR20[1]": "0"}, "TRAFO_TYPE_1", "which is kind P"),
    "axes that turn in two senses": ("both", {"$TC_CARR12[1]": "1"}, "AXIS2_1", "in the other sense"),
    "swivel data with other axes": ("both", {"$TC_CARR21[1]": "C", "$TC_CARR22[1]": "A"}, "AXIS1_1", "where"),
}  # fmt: skip


def _read(folder, lines):
    (folder / "mill.arc").write_text("\n".join(lines))
    return read_control([folder / "mill.arc"])


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_a_contradiction_is_refused_with_both_lines(case, tmp_path):
    archive, values, other, message = CONTRADICTIONS[case]
    with pytest.raises(ControlFileError, match=r"mill\.arc:[0-9]+: .*mill\.arc:[0-9]+ ") as error:
        _read(tmp_path, changed(ARCHIVES[archive], values))
    assert other in str(error.value) and message in str(error.value) and "\n" not in str(error.value)


def test_values_of_two_files_that_differ_are_refused_and_equal_ones_are_not(tmp_path):
    (tmp_path / "old.arc").write_text("$MA_MAX_AX_VELO[AX4]=123\n$MC_OTHER=1\n")
    (tmp_path / "mill.arc").write_text("\n".join(ARCHIVES["table"]))
    files = [tmp_path / "mill.arc", tmp_path / "old.arc"]
    with pytest.raises(ControlFileError, match=r"old.arc:1: .* = 123 contradicts .*mill.arc:\d+ N32000"):
        read_control(files)
    (tmp_path / "twice.arc").write_text("\n".join([*ARCHIVES["table"], "$MA_MAX_AX_VELO[AX4]=123"]))
    with pytest.raises(ControlFileError, match=r"= 123 contradicts .*; remove one of both lines"):
        read_control([tmp_path / "twice.arc"])
    (tmp_path / "other.arc").write_text("$MA_MAX_AX_VELO[Q1]=123\n$MA_MAX_AX_VELO[AX31]=10000\n")
    remarks = read_control([tmp_path / "mill.arc", tmp_path / "other.arc"]).record.remarks
    assert "$MA data of Q1 are not read: the channel has no such axis." in remarks
    same = 60e3 * TABLE.machine.file.joints["X"].velocity
    (tmp_path / "old.arc").write_text(f"$MA_MAX_AX_VELO[0,MX4]={same:.3f}\n")
    assert read_control(files).machine.joints == ("X", "Y", "Z", "A", "C")


REFUSED = {
    "another transformation": ("table", {"$MC_TRAFO_TYPE_1": "148"}, r"TYPE_1 = 148 is not read; types are 16"),
    "a type 72 without swivel data": ("table", {"$MC_TRAFO_TYPE_1": "72"}, "takes swivel data set 1, which no file"),
    "no such kind": ("swivel table", {"$TC_CARR23[1]": '"Q"'}, "= 'Q'; give one of T, P, M"),
    "no such axis": ("swivel table", {"$TC_CARR21[1]": "(U)"}, "= U, and the channel has no such axis"),
    "a linear swivel axis": ("swivel table", {"$TC_CARR21[1]": "(X)"}, "= X, which is linear; give the axis that"),
    "no such number": ("table", {"$MC_TRAFO_AXES_IN_1[3]": "9"}, "= 9, and the channel has no such axis"),
    "a lathe": ("swivel table", {"$MC_AXCONF_GEOAX_ASSIGN_TAB[1]": "0"}, "= 0 for Y, and the channel has no such axis"),
    "another order": ("table", {"$MC_AXCONF_GEOAX_NAME_TAB[1]": '"Z"'}, 'NAME_TAB.1. = "Z"; geometry axes are read'),
    "units of the builder": ("table", {"$MN_SCALING_USER_DEF_MASK": "'H4'"}, "gives data units of their own"),
    "no velocity": ("table", {"$MA_MAX_AX_VELO[AX4]": "0"}, "= 0; give a number above zero"),
    "no number": ("table", {"$MA_MAX_AX_VELO[AX4]": "fast"}, "= 'fast' is not a number"),
    "nothing": ("table", {"$MA_MAX_AX_VELO[AX4]": ""}, "= '' is not a number"),
    "too much": ("table", {"$MA_MAX_AX_VELO[AX4]": "1e999"}, "is too large"),
    "no direction": ("table", {"$MC_TRAFO5_AXIS1_1[0]": "1e-300"}, "is no direction"),
    "a length beyond all": ("table", {"$MC_TRAFO5_BASE_TOOL_1[0]": "1e308"}, "is too large"),
    "no acceleration with SOFT": ("table", {"$MA_SOFT_ACCEL_FACTOR[AX4]": "0"}, "give a number above zero"),
    "parallel axes": ("swivel table", {"$TC_CARR10[1]": "-1", "$TC_CARR12[1]": "0"}, "C and A are parallel"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused_at_its_line(case, tmp_path):
    archive, values, message = REFUSED[case]
    with pytest.raises(ToolpaceError, match=message) as error:
        _read(tmp_path, changed(ARCHIVES[archive], values))
    assert "\n" not in str(error.value) and len(str(error.value)) < 500


def test_files_without_data_and_of_two_controls_are_refused(tmp_path):
    for name, text in {"a.arc": "\n".join(ARCHIVES["table"]), "b.txt": "R1=2\n", "c.ini": "[KINS]\n[TRAJ]\n"}.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(ControlFileError, match=r"b.txt: has no machine data"):
        read_control([tmp_path / "a.arc", tmp_path / "b.txt"])
    with pytest.raises(ControlFileError, match=r"is of Sinumerik, and .*c.ini of LinuxCNC"):
        read_control([tmp_path / "a.arc", tmp_path / "c.ini"])


def test_open_chains_and_other_figures_of_two_sources_are_told(tmp_path):
    open_table = changed(ARCHIVES["table"], {"$MC_TRAFO5_PART_OFFSET_1[2]": "150"})
    remarks = _read(tmp_path, open_table).record.remarks
    assert any(each.startswith("I4 is (0, 0, 150) [mm] (") and "(0, 0, 220) would" in each for each in remarks)
    for archive, values, closing in (
        ("swivel table", {"$TC_CARR20[1]": "219.9"}, "(0, 0, 220)"),
        ("swivel head", {"$TC_CARR3[1]": "-249"}, "(0, 0, -250)"),
        ("mixed", {"$TC_CARR20[1]": "129.9"}, "(0, 0, 130)"),
    ):
        remarks = _read(tmp_path, changed(ARCHIVES[archive], values)).record.remarks
        assert any(f"{closing} would close the chain" in each for each in remarks)
    apart = changed(ARCHIVES["both"], {"$TC_CARR5[1]": "0.02", "$TC_CARR19[1]": "-0.02"})
    assert any("I2 of the swivel data is (0, 0.02, -220)" in each for each in _read(tmp_path, apart).record.remarks)
    two = [*ARCHIVES["swivel table"], *TABLE.carrier(2)]
    assert [each.what for each in _read(tmp_path, two).stand_ins] == ["number of the swivel data set (1, 2)"]


def test_a_file_of_any_size_and_code_page_ends_soon(tmp_path):
    text = "\n".join(ARCHIVES["both"])
    (tmp_path / "mill.arc").write_bytes(("; Fräsmaschine\n" + text).encode("latin-1"))
    assert read_control([tmp_path / "mill.arc"]).machine.kind == "table-table"
    (tmp_path / "mill.arc").write_bytes(text.encode() + b"\0\x01binary")
    with pytest.raises(ControlFileError, match="is not text; save it as text on the control"):
        read_control([tmp_path / "mill.arc"])
    began = time.monotonic()
    lines = ["$MA_" + "X" * 1900, "$MC_A[" + "1," * 900, '$TC_CARR1[7]="' + " " * 1900, "N1" * 900 + "$MA_A=("]
    (tmp_path / "mill.arc").write_text("\n".join([text, *lines * 500]))
    assert read_control([tmp_path / "mill.arc"]).machine.kind == "table-table"
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize("seed", [1, 2, pytest.param(3, marks=pytest.mark.sweep)])
def test_changed_files_are_read_or_refused_in_one_line(seed, tmp_path):
    """Bytes, words and lines are changed at random; nothing but an error of ours may come of it."""
    chance = random.Random(seed)
    words = [b"1e308", b"-0", b"nan", b"[", b"]", b"=", b"$", b'"', b"'HFF'", b"\xff", b"CHANDATA(2)", b"72"]
    outcomes = {"read": 0, "refused": 0}
    for _ in range(70):
        text = bytearray("\n".join(chance.choice(list(ARCHIVES.values()))).encode())
        for _ in range(chance.randrange(1, 6)):
            start = chance.randrange(len(text) + 1)
            end = min(len(text), start + chance.choice((0, 1, 5, 40, 2000)))
            text[start:end] = chance.choice([*words, bytes(chance.randrange(1, 256) for _ in range(4)), b""])
        if chance.random() < 0.2:
            del text[chance.randrange(len(text)) :]
        (tmp_path / "mill.arc").write_bytes(bytes(text))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UnitWarning)
                read_control([tmp_path / "mill.arc"])
            outcomes["read"] += 1
        except ToolpaceError as error:
            assert "\n" not in str(error)
            outcomes["refused"] += 1
    assert min(outcomes.values()) > 10

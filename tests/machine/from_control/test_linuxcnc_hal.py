"""Values of kinematics pins, as HAL files and commands set and connect them."""

from __future__ import annotations

import pytest

from tests.support.linuxcnc_files import ini_text, written
from toolpace.common.units import MILLIMETRE
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.control_file import ControlFileError

PIN = "xyzac-trt-kins"


def _draft(tmp_path, hal: str, lines=("HALFILE = mill.hal",), kinematics=PIN, **sections):
    text = ini_text(kinematics, "XYZAC", sections=sections, lines=lines)
    return read_control([written(tmp_path, mill_ini=text, mill_hal=hal)])


def _height(draft) -> float:
    """Of the axis A [mm]: the sum of z-rot-point, z-offset and a fixed length of tool."""
    return draft.machine.file.joints["A"].point[2] / MILLIMETRE


WAYS = {
    "set": f"setp {PIN}.z-offset 12.5",
    "set twice: the last counts": f"setp {PIN}.z-offset 1\nsetp {PIN}.z-offset 12.5",
    "from the INI": f"setp {PIN}.z-offset [GEOMETRY]UP",
    "from the INI, in brackets": f"setp {PIN}.z-offset [GEOMETRY](UP)",
    "from the INI, in Tcl": f"setp {PIN}.z-offset $::GEOMETRY(UP)",
    "by a signal": f"net up => {PIN}.z-offset\nsets up 12.5",
    "by a signal with its comment": f"net up other.pin => {PIN}.z-offset  # up\nsets up 12.5 # mm",
    "by a sum with gains": "\n".join(
        ["loadrt sum2 names=s", "setp s.in0 5", "setp s.gain0 2", "setp s.in1 -3", "setp s.gain1 -1",
         "setp s.offset -0.5", f"net up s.out => {PIN}.z-offset"]
    ),
    "by a fixed length of tool": f"setp {PIN}.tool-offset 12.5",
    "on two lines": f"setp {PIN}.z-offset \\\n   12.5",
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_a_pin_is_set_in_any_way(way, tmp_path):
    assert _height(_draft(tmp_path, WAYS[way], GEOMETRY={"UP": 12.5})) == pytest.approx(12.5)


def test_files_are_executed_in_the_order_of_linuxcnc(tmp_path):
    """HALFILE, then HALCMD, then POSTGUI_HALFILE; a sourced file where it is sourced."""
    lines = ["POSTGUI_HALFILE = last.hal", f"HALCMD = setp {PIN}.z-offset 2", "HALFILE = mill.hal"]
    (tmp_path / "more.hal").write_text(f"setp {PIN}.z-rot-point 30\n")
    (tmp_path / "last.hal").write_text(f"setp {PIN}.tool-offset 400\n")
    hal = f"setp {PIN}.z-offset 1\nsetp {PIN}.z-rot-point 10\nsource more.hal\nsetp {PIN}.tool-offset 100\n"
    assert _height(_draft(tmp_path, hal, lines)) == pytest.approx(432.0)


def test_a_tool_length_that_is_not_connected_is_told(tmp_path):
    note = "does not hold the tip of a tool with a length"
    connected = _draft(tmp_path, f"net tool motion.tooloffset.z => {PIN}.tool-offset\n")
    assert note.replace("a length", "length") not in connected.text and note not in connected.text
    assert _height(connected) == 0.0
    assert note.split(" with ")[0] in _draft(tmp_path, "").text


def test_a_pivot_with_the_tool_in_it_needs_no_note(tmp_path):
    text = ini_text("5axiskins", "XYZBCW", lines=["HALFILE = mill.hal"])
    hal = "net tool motion.tooloffset.z => s.in1\nsetp s.in0 200\nnet length s.out => 5axiskins.pivot-length\n"
    draft = read_control([written(tmp_path, mill_ini=text, mill_hal=hal)])
    assert draft.machine.file.joints["B"].point == pytest.approx((0.0, 0.0, 0.2))
    assert "does not have the tool's length" not in draft.text
    without = read_control([written(tmp_path, mill_ini=text, mill_hal="setp 5axiskins.pivot-length 200\n")])
    assert without.machine == draft.machine and "does not have the tool's length" in without.text


def test_a_fixed_tool_lifts_both_tables(tmp_path):
    lines = [f"HALCMD = setp xyzab_tdr_kins.{pin}" for pin in ("tool-offset-z 50", "z-rot-point 7", "z-offset -10")]
    path = written(tmp_path, mill_ini=ini_text("xyzab_tdr_kins", "XYZAB", lines=lines))
    joints = read_control([path]).machine.file.joints
    assert (joints["B"].point[2], joints["A"].point[2]) == pytest.approx((0.057, 0.047))


def test_a_hal_file_that_the_ini_does_not_name_counts_if_it_is_given(tmp_path):
    path = written(tmp_path, mill_ini=ini_text(PIN, "XYZAC"), extra_hal=f"setp {PIN}.z-offset 6\n")
    assert _height(read_control([path])) == 0.0
    assert _height(read_control([path, tmp_path / "extra.hal"])) == pytest.approx(6.0)


def test_kinematics_that_hold_the_tip_from_the_start_are_told(tmp_path):
    assert "tip_mode_at_start = true" in _draft(tmp_path, "").text
    assert "tip_mode_at_start" not in _draft(tmp_path, "", kinematics=f"{PIN} sparm=identityfirst").text


def test_the_module_may_be_named_by_hal_alone(tmp_path):
    draft = _draft(tmp_path, f"loadrt {PIN}\n", KINS={"KINEMATICS": None})
    assert draft.machine.kind == "table-table"
    assert 'workpiece = ["A", "C"]' in draft.text and "mill.hal:1 loadrt xyzac-trt-kins" in draft.text


def test_a_pin_set_to_a_word_is_refused_at_its_line(tmp_path):
    with pytest.raises(ControlFileError, match=r"mill.hal:2: setp xyzac-trt-kins.z-offset is set to 'high'"):
        _draft(tmp_path, f"\nsetp {PIN}.z-offset high\n")

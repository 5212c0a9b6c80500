"""Rotary axes and M functions: TNC 640 Klartext manual, "Miscellaneous functions", "Multiple-axis machining"."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.heidenhain import MACHINE, SetUp, findings, last, read
from toolpace.common.errors import ProgramError
from toolpace.common.units import DEGREE
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import Tool


def degrees(path):
    return np.round(path.rotary / DEGREE, 6) + 0.0


# Rotary axes


def test_rotary_words_are_joints():
    path = read("L X+0 Y+0 Z+0 A+10 C-20 FMAX\nL A+30 IC+5 FMAX", MACHINE)
    assert degrees(path)[-1].tolist() == [30, -15]


def test_feed_of_a_block_that_turns_without_m128_is_said():
    """Millimetres and degrees as one length: 3 mm and 4 deg at F 300 take a second."""
    path = read("L X+3 A+4 F300", MACHINE)
    assert path.least_time.sum() == pytest.approx(1.0)
    assert any("millimetres and degrees as one length" in said for said in path.assumed)


def test_where_m128_fixes_the_part_is_said_where_it_matters():
    assert "M128" not in " ".join(read("L M128\nL X+3 F300", MACHINE).assumed)
    assert "where the tables are at zero" in " ".join(read("L C+90 FMAX\nL M128\nL X+3 F300", MACHINE).assumed)


def test_rotary_words_need_a_machine_that_has_them():
    with pytest.raises(ProgramError, match="rotary word B needs the machine"):
        read("L B+3 FMAX")
    with pytest.raises(ProgramError, match="has no axis B"):
        read("L B+3 FMAX", MACHINE)


def test_m126_takes_the_shorter_way_and_m127_ends_it():
    """The manual's table: 350 to 10 is +20 with M126, and -340 without."""
    path = read("L C+350 FMAX\nL C+10 FMAX M126\nL C+350 FMAX\nL C+340 FMAX M127\nL C+10 FMAX", MACHINE)
    ends = degrees(path)[np.append(np.diff(path.block) > 0, True)][:, 1]
    assert ends.tolist() == [0, 350, 370, 350, 340, 10]


def test_m94_takes_whole_turns_off_the_display():
    """The manual's example: from 538 to 180 is -358; with M94 it is +2."""
    assert degrees(read("L C+538 FMAX\nL C+180 FMAX M94", MACHINE))[-1, 1] == 540
    assert degrees(read("L C+538 FMAX\nL C+180 FMAX", MACHINE))[-1, 1] == 180


@pytest.mark.parametrize("on", ["L M128", "M128", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS"])
@pytest.mark.parametrize("off", ["L M129", "FUNCTION RESET TCPM"])
def test_under_m128_the_words_are_the_tip_on_the_part(on, off):
    """ "Maintaining the position of the tool tip": the table turns, the tip stays on the part."""
    path = read(f"{on}\nL X+10 Y+20 Z+30 F600\nL A+30 C+40\n{off}\nL A+0 C+0 FMAX", MACHINE)
    turned = path.block == path.block[path.rotary.any(axis=1)][0]
    assert np.allclose(path.tip[turned], (0.01, 0.02, 0.03), atol=1e-12)
    # M129 ends it: the joints stay, and the tip moves on the part while the tables turn back
    joints = MACHINE.rotation(*(np.array([angle * DEGREE]) for angle in (30.0, 40.0)))[0].T @ (0.01, 0.02, 0.03)
    assert np.allclose(path.tip[-1], joints, atol=1e-12)


def test_the_feed_behind_m128_is_that_of_the_compensation():
    """ "M128 F": the most feed of the compensating movements; it is not the feed of the contour."""
    path = read("L X+1 F600 M128 F1000\nL X+2", MACHINE)
    assert path.feed[1:] == pytest.approx([0.01, 0.01])


def test_ln_turns_the_tool_to_its_vector():
    """LN with TX TY TZ under TCPM; the vector need not be a unit vector."""
    path = read("L M128\nLN X+1 Y+2 Z+3 NX+0 NY+0 NZ+1 TX+0 TY-0,6 TZ+0,8 F100\nLN X+2 TX+3 TY+0 TZ+4", MACHINE)
    ends = path.axis[np.append(np.diff(path.block) > 0, True)]
    assert np.allclose(ends[1:], [(0, -0.6, 0.8), (0.6, 0, 0.8)], atol=1e-12)
    assert np.allclose(path.tip[-1], (0.002, 0.002, 0.003))


def test_ln_without_the_tools_direction_stands_upright_on_the_part():
    """iTNC 530 Conversational, "Face milling: 3-D compensation with and without tool orientation": under M128 "the TNC
    maintains the tool perpendicular to the workpiece contour if no tool orientation is programmed"."""
    path = read("L M128\nLN X+1 Y+2 Z+3 NX+0 NY-0.6 NZ+0.8 F100\nLN X+2 NX+0.6 NY+0 NZ+0.8", MACHINE)
    ends = path.axis[np.append(np.diff(path.block) > 0, True)]
    assert np.allclose(ends[1:], [(0, -0.6, 0.8), (0.6, 0, 0.8)], atol=1e-12)
    assert np.allclose(path.tip[-1], (0.002, 0.002, 0.003))


def test_ln_without_m128_ignores_the_tools_direction():
    """The same section: "if you have not activated M128, the TNC ignores the direction vector T"."""
    path = read("LN X+1 Y+2 NX+0.6 NY+0 NZ+0.8 TX+0.6 TY+0 TZ+0.8 F100\nLN X+2 NX+0 NY+0 NZ+1", MACHINE)
    assert np.allclose(path.axis, (0, 0, 1)) and np.allclose(path.tip[-1], (0.002, 0.002, 0))
    assert any("without M128" in said for said in path.assumed)


@pytest.mark.parametrize("delta", ["DL+0.5", "DR-0.1", "DR2+0.2"])
def test_ln_with_an_oversize_of_the_tool_is_refused(delta):
    """The same section: the tool is displaced along the normals "by the sum of the delta values"."""
    text = f"TOOL CALL 1 Z {delta}\nL X+0 F100\nLN X+1 NX+0 NY+0.6 NZ+0.8\nTOOL CALL 1 Z\nLN X+2 NX+0 NY+0.6 NZ+0.8"
    (refused,) = findings(text, MACHINE).refusals
    assert refused.word == "NX NY NZ with an oversize of TOOL CALL" and refused.count == 1


def test_a_direction_without_length_is_a_mistake():
    with pytest.raises(ProgramError, match="NX NY NZ is no direction"):
        read("L X+1 F100 M128\nLN X+2 NX+0 NY+0 NZ+0", MACHINE)


def test_tcpm_with_spatial_angles():
    """AXIS SPAT: A, B, C of L are angles in space, fixed axes; A 30 tilts the tool in the YZ plane."""
    path = read("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+1 A+30 C+0 F100", MACHINE)
    assert np.allclose(path.axis[-1], (0, -0.5, math.sqrt(0.75)), atol=1e-12)


def test_words_that_are_the_centre_of_the_tools_corner():
    """REFPNT CENTER-CENTER: X, Y, Z are the centre of the corner radius R2, which is above the tip along the tool."""
    machine, corner = Machine.load("xyzbc-trunnion"), 0.004
    setup = SetUp(tools={"5": Tool(0.1, 0.006, corner)})
    begin = "TOOL CALL 5 Z S1000\nL X+0 Y+0 Z+50 R0 FMAX\n"
    on = "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT {}\n"
    text = on + "L X+{} Y+{} Z+{} B+30 C+40 F500\nFUNCTION RESET TCPM\nL Z+60"
    axis = direct_axis(30.0, 40.0)
    at = np.array([10.0, 5.0, 20.0])
    columns = [machine.joints.index(letter) for letter in "XYZ"]
    found = []
    for word, place in (("CENTER-CENTER", at), ("TIP-TIP", at - corner * 1e3 * axis)):
        path = read(text.format(word, *np.round(place, 9)), machine, begin=begin, setup=setup)
        joints = machine.joints_at(path.tip, path.rotary, path.tool_length)[:, columns]
        found.append([joints[path.block == line][-1] for line in (5, 7)])
    assert np.allclose(found[0], found[1], atol=1e-9)


@pytest.mark.parametrize(
    "switch", ["TOOL CALL DL-4\nM128", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER"]
)
def test_the_path_starts_with_the_tip_that_the_first_motion_has(switch):
    """Between the first position and the first motion another length comes in force: no way leads from one tip to the
    other."""
    setup = SetUp(tools={"5": Tool(0.15, 0.006, 0.004)})
    begin = "TOOL CALL 5 Z S1000\nL X+0 Y+0 Z+50 R0 FMAX\n"
    path = read(f"{switch}\nL X+5 F500\nL X+6", Machine.load("xyzbc-trunnion"), begin=begin, setup=setup)
    assert np.allclose(path.tool_length, 0.146) and np.allclose(path.tip[:, 2], 0.054)
    assert path.tip[0, 0] == 0.0 and len(path) == 3


def test_another_tool_under_center_center_is_refused():
    setup = SetUp(tools={"5": Tool(0.1, 0.006, 0.004), "6": Tool(0.1)})
    text = "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER\nL X+1 F100\nTOOL CALL 6 Z\nL X+2"
    begin = "TOOL CALL {} Z S1000\nL X+0 Y+0 Z+50 R0 FMAX\n"
    for tool, word in ((5, "TOOL CALL of a tool under M128"), (6, "FUNCTION TCPM REFPNT CENTER-CENTER")):
        refusals = findings(text, MACHINE, begin=begin.format(tool), setup=setup).refusals
        assert refusals[0].word == word


def direct_axis(b, c):
    """The tool's axis (3,) at B and C [deg] of ISO 841: turned about Y, then about Z."""
    b, c = np.radians(b), np.radians(c)
    return np.array([np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), np.cos(b)])


# M functions


def test_machine_coordinates():
    """M91: this block in machine coordinates; from the set-up sheet here, without it from the ends of travel."""
    setup = SetUp(machine_zero={"X": 0.1, "Y": 0.0, "Z": 0.5})
    assert last("L X+1 F100\nL Z-20 X-10 R0 FMAX M91\nL Y+5", MACHINE, setup=setup) == (90, 5, 480)


@pytest.mark.parametrize(
    ("block", "word"),
    [("L Z+0 FMAX M91", "M91 and M92 under M128"), ("TOOL CALL 2 Z S100", "TOOL CALL of a tool under M128")],
)
def test_what_m128_must_be_reset_before(block, word):
    """ "Before positioning with M91 or M92 and before a TOOL CALL block, reset M128" (TNC 620, "M128")."""
    assert [each.word for each in findings(f"L X+1 F100 M128\n{block}\nL X+2", MACHINE).refusals] == [word]
    assert not findings(f"L X+1 F100 M128\nL M129\n{block}\nL X+2", MACHINE).refusals
    assert not findings("L X+1 F100 M128\nTOOL CALL S2000 F300\nL X+2", MACHINE).refusals


def test_incremental_machine_coordinates_are_refused():
    assert findings("L IX+1 FMAX M91\nL X+1 F100", MACHINE).refusals[0].word == "incremental words with M91"


def test_m140_goes_back_along_the_tool():
    """M140 MB 50: back by 50 mm along the tool axis, at the feed behind it or at rapid."""
    path = read("L X+1 F100\nL A+90 FMAX\nM140 MB 50 F600\nL M140 MB+5", MACHINE)
    way = np.diff(path.tip[np.append(np.diff(path.block) > 0, True)], axis=0)[-2:]
    axis = path.axis[-1]
    assert np.allclose(way, [0.05 * axis, 0.005 * axis], atol=1e-12)
    assert path.feed[-2] == pytest.approx(0.01) and path.rapid[-1]


def linear_joints(machine, tip, rotary):
    """X, Y, Z joints [m] of a tip (3,) at rotary positions in the order of the machine's joints."""
    probes = np.zeros((4, 5))
    probes[1:, :3] = np.eye(3)
    probes[:, 3:] = rotary
    at, _ = machine.forward(probes)
    return np.linalg.solve((at[1:] - at[0]).T, tip - at[0])


def test_m140_mb_max_goes_to_the_end_of_travel():
    """M140 MB MAX: to the limit of the range of traverse along the tool axis, short of it by the parameter moveBack
    (TNC 640, "Retraction from the contour in the tool-axis direction: M140"); no other joint moves."""
    machine = Machine.load("xyzbc-trunnion")
    path = read("L X+10 Y+20 Z+0 B+0 C+0 F100\nM140 MB MAX\nL M128\nL Z+30 B+90 FMAX\nM140 MB MAX", machine)
    top = float(machine.travel[2, 1]) - 1e-3
    up = path.tip[path.block == 5][-1]
    assert linear_joints(machine, up, (0.0, 0.0)) == pytest.approx((0.01, 0.02, top), abs=1e-9)
    before, after = (path.tip[path.block == line][-1] for line in (7, 8))
    first, second = (linear_joints(machine, tip, (np.pi / 2, 0.0)) for tip in (before, after))
    assert second == pytest.approx((first[0], first[1], top), abs=1e-9)


def test_functions_without_motion_are_counted_and_the_builders_are_said():
    found = findings("L X+1 F100 M3 M8\nM57\nM120 LA5\nL X+2 M118 Z1\nM138")
    assert {"M3", "M8", "M57", "M120", "M118", "M138"} <= set(found.skipped)
    assert any("M57" in said for said in found.assumptions) and not found.refusals


@pytest.mark.parametrize(("axes", "refused"), [("C", True), ("A C", False), ("", False)])
def test_m138_with_some_of_the_axes_is_refused(axes, refused):
    """"Selecting tilting axes: M138": planes and M128 count with the axes that it names only."""
    found = findings(f"L Z+100 FMAX M138 {axes}\nL A+10 C+20 F100 M128", MACHINE).refusals
    assert [each.word for each in found] == ["M138 with some of the rotary axes"] * refused


@pytest.mark.parametrize("words", ["AXIS SPACE", "F TCP AXIS POS REFPNT TIP", "PATHCTRL", "F TCP X"])
def test_words_that_tcpm_does_not_have(words):
    with pytest.raises(ProgramError, match="has a word that FUNCTION TCPM does not have"):
        read(f"FUNCTION TCPM {words}\nL X+1 F100", MACHINE)


def test_a_path_that_is_the_contour_is_refused_where_normals_are_told():
    """"Interpretation of the programmed path": the tool is led beside it by the whole radius, along the normal."""
    line = "LN X+10 Y+0 Z+5 NX+0 NY+0.6 NZ+0.8 F100"
    found = findings(f"FUNCTION PROG PATH IS CONTOUR\n{line}\nFUNCTION PROG PATH IS OFF\n{line}").refusals
    assert [(each.word, each.line) for each in found] == [("NX NY NZ under FUNCTION PROG PATH IS CONTOUR", 5)]


def test_functions_that_may_move_are_refused():
    found = findings("L X+1 F100 M109\nM114\nM95\nM103 F20")
    assert [refusal.word for refusal in found.refusals] == ["M109", "M114", "M95", "M103"]


def test_dwells():
    path = read("L X+1 F100\nCYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 1.5\nL X+2\nFUNCTION DWELL TIME2\nL X+3")
    assert path.dwell.tolist() == [0, 1.5, 2, 0]


def test_oversize_of_the_tool_lifts_it():
    """TOOL CALL, DL: "delta value for the length": a tool that is called longer stands higher, until the next one."""
    machine = Machine.load("xyzac-trunnion")
    path = read("TOOL CALL 2 Z DL+0.5\nL X+1 Z+3 F100\nTOOL CALL DL-0.25\nL X+2 Z+3\nTOOL CALL 3\nL X+3 Z+3", machine)
    z = machine.joints_at(path.tip, path.rotary, path.tool_length)[:, machine.joints.index("Z")]
    ends = np.array([[path.tip[path.block == line][-1][2], z[path.block == line][-1]] for line in (5, 7, 9)]) * 1e3
    assert ends[:, 0] == pytest.approx([3.0, 3.0, 3.0])
    assert ends[:, 1] - ends[2, 1] == pytest.approx([0.5, -0.25, 0.0])


def test_a_tool_axis_that_the_machine_does_not_have_is_said():
    machine = Machine.load("xyzac-trunnion")
    for axis, said in (("Z", False), ("X", True)):
        assumed = " ".join(read(f"TOOL CALL 2 {axis}\nL X+1 F100", machine).assumed)
        assert (f"TOOL CALL with tool axis {axis} sets the plane" in assumed) == said


def test_q108_is_the_radius_of_the_tool():
    """Preassigned Q parameters: Q108 is the radius of the tool table, plus DR of TOOL CALL."""
    sheet = SetUp(tools={"2": Tool(0.1, 0.004)})
    path = read("TOOL CALL 2 Z DR+0.5\nL X+Q108 F100\nTOOL CALL 2 Z\nL X+Q108", setup=sheet)
    assert (path.tip[1:, 0] * 1e3).round(9).tolist() == [4.5, 4]
    with pytest.raises(ProgramError, match="Q108 is not read: it is the radius of the tool: give the tool"):
        read("TOOL CALL 2 Z\nL X+Q108 F100\nL X+1")

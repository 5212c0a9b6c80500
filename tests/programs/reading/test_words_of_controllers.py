"""What G and M words mean to each controller: expectations by hand, with the manual cited."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.controllers import read_for, tips, with_options
from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError, UsageError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.options import PROGRAM

START = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0\n"
WORDS = [name for name in Controller.names() if Controller.load(name).language == "word-address"]


def ends(path) -> np.ndarray:
    """Tips at the ends of blocks [mm]."""
    return path.tip[np.flatnonzero(np.diff(path.block, append=-1))] * 1e3


# --- files ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WORDS)
def test_every_word_of_a_built_in_controller_is_carried_out_or_refused_in_one_line(name):
    """Each word alone behind a position: a path, or one error, and each meaning has somebody who carries it out."""
    controller = Controller.load(name)
    for word in [*controller.meanings, *controller.ignored, *controller.refused]:
        try:
            read_for(controller, f"G90 G94 F600\nG0 X0 Y0 Z0\n{word}\nG1 X1 Y1 F600\nM30", MACHINE)
        except ProgramError as error:
            assert "\n" not in str(error) and "part.nc" in str(error), word


@pytest.mark.parametrize("name", WORDS)
def test_a_word_has_one_place_in_a_controllers_file(name):
    controller = Controller.load(name)
    places = [*controller.meanings, *controller.ignored, *controller.refused]
    assert sorted(places) == sorted(set(places))


def test_a_meaning_that_there_is_not_is_an_error_of_the_file():
    controller = Controller.from_toml('name = "x"\nlanguage = "word-address"\n[meanings]\nG0 = "fly"\n', "x.toml")
    with pytest.raises(UsageError, match=r"x\.toml: G0 = 'fly' is no meaning"):
        read_for(controller, START)


def test_all_unknown_words_are_refused_in_one_run():
    with pytest.raises(ProgramError, match=r"3 kinds of words are not read: G123 \(first line 3, 2 times\)") as caught:
        read_for("fanuc", START + "G123\nG5.7 X1\nG123 X2\nG66 P1\nG1 X1\nM30")
    assert "G5.7 (first line 4)" in str(caught.value) and "G66" in str(caught.value)
    path = read_for("fanuc", START + "G123\nG5.7 X1\nG1 X3\nM30", skip_unknown=True)
    assert ends(path)[:, 0].tolist() == [0, 3] and any("skipped G123" in sentence for sentence in path.assumed)


def test_forms_of_known_words_that_are_not_read_are_refused_with_the_others():
    body = START + "G10 L10 P1 R5.\nG68 X0 Y0 I0 J1. K0 R30.\nG68.2 P4 X0\nG1 X#150\nG1 X1.\nM30"
    with pytest.raises(ProgramError, match="4 kinds of words are not read: G10 L10") as caught:
        read_for("fanuc", body, MACHINE)
    assert all(word in str(caught.value) for word in ("G68 about a vector", "G68.2 P4", "#150"))


def test_letters_of_a_word_that_moves_nothing_go_with_it():
    """Haas G187 P1 E.01 smooths, Fanuc G05.1 Q1 and G08 P1 look ahead: none of them moves."""
    assert tips("haas", START + "G187 P1 E.01\nG187 P2 G1 X1.\nM30")[-1] == [1, 0, 0]
    assert tips("fanuc", START + "G05.1 Q1\nG08 P1\nG1 X1.\nM30")[-1] == [1, 0, 0]


def test_an_unknown_m_word_is_a_stop_where_the_machines_builder_may_have_made_it():
    """Fanuc: M words are the machine builder's. LinuxCNC: M100 to M199 run programs, so they are refused."""
    assert read_for("fanuc", START + "G1 X1.\nM46\nX2.\nM30").stop.tolist() == [True, True, True]
    with pytest.raises(ProgramError, match="M123 is not read"):
        read_for("linuxcnc", START + "G1 X1\nM123\nX2\nM2")


# --- text -------------------------------------------------------------------------------------------------------


def test_headers_nested_comments_and_listings():
    """Posts for Haas: text for the program's number, comments within comments, a blank line."""
    body = "%\nO ENTER OP AND LAST 3 DIGITS\n \n(#508= (MILL_.25 ))\nG90 G21 F600\nN1T008M06\nG0X0Y0Z0\nG1X1.\nM30\n%"
    assert tips("haas", body) == [[0, 0, 0], [1, 0, 0]]
    with pytest.raises(ProgramError, match="do not nest"):
        read_for("linuxcnc", START + "(a (b))\nM2")


@pytest.mark.parametrize("line", ["(ROUGHING", "G1 X1. (ROUGHING", "(A) (B"])
def test_a_comment_that_is_not_closed_may_hide_blocks(line):
    """By the manuals' words it ends with ), on whatever line that stands."""
    for name in ("fanuc", "mazak"):
        with pytest.raises(ProgramError, match="open at the end of its line"):
            read_for(name, START + line + "\nG1 X2.\n(DONE)\nM30")
    assert tips("fanuc", START + "(PART; 27/05)\nG1 X1. (A (B)\nM30")[-1] == [1, 0, 0]


def test_a_semicolon_ends_a_block_of_fanuc_and_hides_none():
    """Fanuc manuals print ; for the end of a block; on LinuxCNC a comment begins with it."""
    assert tips("fanuc", START + "G1 X1.;\nX2. ; so far\nM30;")[-1] == [2, 0, 0]
    with pytest.raises(ProgramError, match="; is not read: a block stands behind it"):
        read_for("fanuc", START + "G1 X1.; Y1.\nX2.\nM30")
    assert tips("linuxcnc", START + "G1 X1 ; Y1\nM2")[-1] == [1, 0, 0]


def test_text_before_the_first_percent_is_no_program():
    """Fanuc 0i, 12.2: what stands before the tape start is skipped."""
    assert tips("fanuc", "PART 7, ASK JOE\n%\nO1\n" + START + "G1 X1.\nM30\n%") == [[0, 0, 0], [1, 0, 0]]


def test_a_comment_names_an_operation():
    path = read_for("fanuc", START + "(Operation Name: ROUGH)\nT1 M6\nG1 X1.\n(Operation Name: FINISH)\nX2.\nM30")
    assert [(o.name, o.tool) for o in path.operations][1:] == [("ROUGH", "1"), ("FINISH", "1")]


def test_numbers_without_a_point_are_as_written_or_least_increments():
    """Fanuc, parameter 3401#0: X10 is 10 mm or 0.010 mm; with a point always 10 mm; angles count 0.001 degrees."""
    body = START + "G1 X10 Y2.\nM30"
    path = read_for("fanuc", body)
    assert ends(path)[-1].tolist() == [10, 2, 0] and any("decimal point" in said for said in path.assumed)
    assert tips(with_options("fanuc", whole_numbers="least increment"), body)[-1] == [0.01, 2, 0]
    assert not any("decimal point" in said for said in read_for("linuxcnc", body).assumed)


@pytest.mark.parametrize(
    ("block", "says"),
    [
        ("M3 M5", "M3 and M5 exclude"), ("M8 M9", "M8 and M9 exclude"), ("M0 M30", "M0 and M30 exclude"),
        ("G0 G1 X1.", "G0 and G1 exclude"), ("G54 G55", "G54 and G55 exclude"),
    ],
)  # fmt: skip
def test_two_words_of_one_group_are_refused(block, says):
    """LinuxCNC, "Modal Groups": one word of a group in a block."""
    with pytest.raises(ProgramError, match=says):
        read_for("linuxcnc", START + block)


# --- feeds and times --------------------------------------------------------------------------------------------


def test_f_beside_units_is_of_the_units_before_on_linuxcnc():
    """LinuxCNC, "G Code Order of Execution": F is 3rd, G20 and G21 are 12th. Elsewhere units come first."""
    body = "G20 G90 G94\nG0 X0 Y0 Z0\nG21 F600\nG20 G1 X1 F60\nM2"
    assert read_for("linuxcnc", body).feed[-1] * 6e4 == pytest.approx(60)
    assert read_for("iso", body).feed[-1] * 6e4 == pytest.approx(60 * 25.4)


def test_inverse_time_of_an_arc_is_by_its_radius_on_fanuc():
    """Fanuc 16/18 operator's manual, 5.4 "Inverse time feed": for arcs F is feed over radius, not over length."""
    body = "G90 G21 G17\nG0 X10. Y0. Z0.\nG93 G3 X-10. Y0. I-10. J0. F2.\nM30"
    assert read_for("iso", body).least_time.sum() == pytest.approx(30.0)
    assert read_for("fanuc", body).least_time.sum() == pytest.approx(30.0 * math.pi)


def test_dwells_have_the_unit_of_their_controller():
    """Fanuc: P milliseconds, X seconds. Haas: P without a point milliseconds, with one seconds. LinuxCNC: seconds."""
    for controller, word in (
        ("fanuc", "P2000"), ("fanuc", "X2."), ("haas", "P2000"), ("haas", "P2."), ("linuxcnc", "P2"),
        ("millplus", "X2."),
    ):  # fmt: skip
        start = START if controller != "millplus" else "G71 G90 G94 F600\nG0 X0 Y0 Z0\n"
        path = read_for(controller, start + f"G1 X1.\nG4 {word}\nX2.\nM30")
        assert path.dwell.sum() == pytest.approx(2.0), (controller, word)


def test_f_outside_tip_mode_is_over_millimetres_and_degrees_on_fanuc():
    """Fanuc: F of linear and rotary axes together is their vector's; LinuxCNC: of X, Y, Z alone."""
    body = "G90 G21 G94 G17\nG0 X0 Y0 Z0 A0 C0\nG1 X30. C40. F600.\nM30"
    assert read_for("fanuc", body, MACHINE).least_time.sum() == pytest.approx(5.0)
    assert read_for("linuxcnc", body, MACHINE).least_time.sum() == pytest.approx(3.0)


def test_a_feed_per_revolution_needs_the_spindle():
    """G95 F0.2 at S600 is 120 mm/min."""
    assert read_for("fanuc", START + "S600 M3\nG95 G1 X1. F.2\nM30").feed[-1] * 6e4 == pytest.approx(120)


def test_the_p_of_g64_beside_an_arc_counts_its_turns():
    """LinuxCNC: one P of a block is both the tolerance of G64 and the turns of G2 and G3, so it has to be whole."""
    body = "G90 G21 F600\nG0 X10 Y0 Z0\nG3 I-10 P1\n"
    with pytest.raises(ProgramError, match="counts its turns"):
        read_for("linuxcnc", body + "G64 P0.02 G3 I-10\nM2")
    path = read_for("linuxcnc", body + "G64 P2 Q0.1 G3 I-10\nM2")
    angle = np.unwrap(np.arctan2(path.tip[:, 1], path.tip[:, 0]))
    assert angle[-1] == pytest.approx(6 * math.pi)


def test_w_moves_along_the_tool():
    """LinuxCNC's five-axis demonstration: W is the way along the tool, from where X, Y, Z are."""
    path = read_for("linuxcnc", "G90 G21 F600\nM428\nG0 X10 Y0 Z0 A-30 C0 W0\nG1 W-5\nX12\nG0 W0\nM2", MACHINE)
    axis = path.axis[-1]
    wanted = [[10, 0, 0], [10, 0, 0] - 5 * axis, [12, 0, 0] - 5 * axis, [12, 0, 0]]
    assert ends(path) == pytest.approx(np.array(wanted), abs=1e-9)


def test_rotary_words_are_as_written_or_the_shorter_way():
    """Fanuc, parameter 1008: with roll-over a position is gone to the shorter way."""
    body = "G90 G21 F600\nG0 X0 Y0 Z0 A0 C350.\nG1 C10. F600\nX1.\nM30"
    path = read_for("fanuc", body, MACHINE)
    assert np.degrees(path.rotary[-1, 1]) == pytest.approx(10) and any("180 degrees" in said for said in path.assumed)
    path = read_for(with_options("fanuc", rotary="shortest"), body, MACHINE)
    assert np.degrees(np.ptp(path.rotary[:, 1])) == pytest.approx(20)


@pytest.mark.parametrize("controller", ["fanuc", "haas", "mazak"])
def test_p_of_an_arc_is_refused_where_it_counts_no_turns(controller):
    """It does to LinuxCNC ("P", G2 and G3); to these it is no word of an arc."""
    with pytest.raises(ProgramError, match="P2 of an arc is not read"):
        read_for(controller, START + "G2 X10. I5. P2\nM30")


@pytest.mark.parametrize("words", ["X10.", "Y30."])
def test_polar_words_begin_with_radius_and_angle(words):
    """B-63944EN gives no example without either: zero, or that of where the tool is."""
    with pytest.raises(ProgramError, match="G16 without a radius or an angle"):
        read_for("fanuc", START + f"G0 X5. Y5.\nG16 {words}\nM30")


# --- tools ------------------------------------------------------------------------------------------------------


def test_a_tool_change_is_an_operation_and_t_before_it_the_tool():
    """Fanuc: T preselects, M6 changes; a T behind it is of the next change."""
    path = read_for("fanuc", START + "T8\nM6\nT9\nG1 X1.\nM6\nG1 X2.\nM30")
    assert [path.operations[k].tool for k in path.operation[1:]] == ["8", "9"] and path.stop[1]


@pytest.mark.parametrize(("controller", "home", "said"), [
    ("haas", "", True), ("fanuc", "", True), ("haas", "G53 Z0\n", False), ("haas", "G91 G28 Z0\nG90\n", False),
    ("linuxcnc", "", False),
])  # fmt: skip
def test_a_change_of_the_tool_that_may_go_elsewhere_is_said(controller, home, said):
    """Haas, M06: Z goes to its zero first; LinuxCNC's axes stay."""
    path = read_for(controller, START + f"{home}T2 M6\nG1 X1. Y0 Z0\nM30", MACHINE)
    assert any("M6 leaves the axes where they are" in sentence for sentence in path.assumed) is said


def test_compensation_with_a_radius_of_zero_is_the_programmed_contour():
    """Fanuc 16i, 14.4: the offset of D; D0 is none."""
    body = START + "G41 D{} G1 X1. Y1.\nX2.\nG40 X3.\nM30"
    assert tips("fanuc", body.format(0))[-1] == [3, 1, 0]
    with pytest.raises(ProgramError, match="G41 is not read: cutter compensation needs the tool's radius"):
        read_for("fanuc", body.format(1))
    assert tips("fanuc", body.format(1), compensation=PROGRAM)[-1] == [3, 1, 0]


def test_arcs_of_millplus_take_the_centre_that_fits():
    """Posts for MillPlus write centres as positions, or from the start to the centre, or the other way."""
    start = "G71 G90 G94 F600\nG0 X30. Y20. Z0.\n"
    for words in ("I20. J20.", "I-10. J0.", "I10. J0."):
        path = read_for("millplus", f"{start}G3 X20. Y30. {words}\nM30")
        radii = np.linalg.norm(path.tip[:, :2] * 1e3 - [20, 20], axis=1)
        assert np.abs(radii - 10).max() < 1e-6
    with pytest.raises(ProgramError, match="equally far from both ends"):
        read_for("millplus", f"{start}G3 X20. Y31.5 I-10. J0.\nM30")


def test_tool_vectors_are_in_the_coordinates_that_the_tip_is_in():
    """A-79348E: the frame is fixed to the table where it stands when G43.5 is read; I, J, K are in it."""
    program = "G90 G21 G94 F600\nG0 X0. Y0. Z50. A0. C90.\nG43.5 H1\nG1 X10. I0.6 J0. K0.8\nM30"
    trunnion = Machine.load("xyzac-trunnion")  # whose table turns about -Z for a positive C
    assert read_for("fanuc", program, trunnion).axis[-1].tolist() == pytest.approx([0.0, 0.6, 0.8])


def test_roundings_do_not_choose_the_centre_of_a_full_circle():
    """MillPlus: all that I and J may mean makes both radii equal; the position is meant, as Autodesk's post writes."""
    start = "X-1.154330708661 Y-0.561417322835"
    program = f"G90 G70 G94\nG0 {start} Z1.\nG2 {start} I-0.10157480315 J-0.463779527559 F142.\nM30"
    path = read_for("millplus", program)
    away = np.hypot(*(path.tip[:, :2] / 0.0254 - [-0.10157480315, -0.463779527559]).T)
    assert away == pytest.approx(away[0])


def test_a_turn_of_the_joints_to_a_plane_begins_where_the_joints_are():
    """The slides stand, with a tool that is not the machine's own and joints that are turned."""
    trunnion = Machine.load("xyzac-trunnion")
    setup = SetUp(tools={"1": Tool(0.2)})
    begin = "G90 G21 G94\nT1 M6\nG54\nG43 H1\nG0 X10. Y20. Z50. A5. C10."
    path = read_for("fanuc", f"{begin}\nG68.2 X0. Y0. Z0. I10. J30. K0.\nG53.1\nM30", trunnion, setup=setup)
    columns = [trunnion.joints.index(letter) for letter in "XYZ"]
    joints = trunnion.joints_at(path.tip, path.rotary, path.tool_length)[:, columns]
    assert len(path) > 5 and np.ptp(joints, axis=0) == pytest.approx(0.0, abs=1e-12)


def test_a_program_without_a_unit_says_how_it_is_taken():
    """Which unit is in force before G20 or G21 is a setting of the control (Haas: Setting 9)."""
    text = "G90 G94 F100\nG0 X0 Y0 Z0\nG1 X1\nM30"
    unsaid = read_for("haas", text)
    assert unsaid.tip[-1, 0] == 0.001 and any("are millimetres" in said for said in unsaid.assumed)
    inches = read_for(with_options("haas", units="inch"), text)
    assert inches.tip[-1, 0] == 0.0254 and any("are inches" in said for said in inches.assumed)
    assert not any("unit of lengths" in said for said in read_for("haas", "G21\n" + text).assumed)


def test_words_behind_the_number_of_a_program_are_a_block_of_it():
    """As in the examples of Fanuc's manual ("O2200 G68 X0 Y0 G91 R45.0"); a name that is no words moves nothing."""
    assert tips("fanuc", "O1000 G90 G21 G0 X1. Y0 Z0\nG1 F600. X2.\nM30") == [[1, 0, 0], [2, 0, 0]]
    body = START + "M98 P200\nX5.\nM30\nO200 G1 X#1 Y3.\nM99"
    assert tips("fanuc", body)[1:] == [[0, 3, 0], [5, 3, 0]]
    assert tips("haas", "O1000 M12 NUT\n" + START + "G1 X1.\nM30")[-1] == [1, 0, 0]

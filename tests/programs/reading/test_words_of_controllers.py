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


# --- frames -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("G52 X10. Y5.\nG1 X1. Y1.\nG52 X0. Y0.\nX1.", [[0, 0, 0], [11, 6, 0], [1, 6, 0]]),
        ("G92 X5.\nG1 X6.\nG92.1\nX6.", [[0, 0, 0], [1, 0, 0], [6, 0, 0]]),
        ("G68 X0. Y0. R90.\nG1 X2. Y0.\nG69\nX5.", [[0, 0, 0], [0, 2, 0], [5, 2, 0]]),
        ("G68 X1. Y1. R180.\nG1 X0. Y0.\nG69", [[0, 0, 0], [2, 2, 0]]),
        ("G16\nG1 X10. Y90.\nY180.\nG15\nX1. Y0.", [[0, 0, 0], [0, 10, 0], [-10, 0, 0], [1, 0, 0]]),
        ("G16\nG1 X10. Y30.\nG91 Y60.\nY90.\nG90\nG15\nX1. Y0.",
         [[0, 0, 0], [8.660254, 5, 0], [0, 10, 0], [-10, 0, 0], [1, 0, 0]]),
        ("G51 X0. Y0. Z0. P2000\nG1 X3. Y1.\nG50\nX3.", [[0, 0, 0], [6, 2, 0], [3, 2, 0]]),
        ("G51 X0. Y0. Z0. I-1000 J1000 K1000\nG1 X3. Y1.\nG50", [[0, 0, 0], [-3, 1, 0]]),
        ("G51.1 X2.\nG1 X3. Y1.\nG50.1 X0.\nX3.", [[0, 0, 0], [1, 1, 0], [3, 1, 0]]),
        ("G10 L2 P1 X100.\nG10 L2 P2 X130.\nG54\nG1 X1.\nG55\nX1.", [[0, 0, 0], [1, 0, 0], [31, 0, 0]]),
        # L20 tells G54.1
        ("G54\nG10 L20 P1 X5.\nG1 X6.", [[0, 0, 0], [6, 0, 0]]),
        ("G54.1 P1\nG10 L20 P1 X100.\nG10 L20 P2 X130.\nG1 X1.\nG54.1 P2\nX1.", [[0, 0, 0], [1, 0, 0], [31, 0, 0]]),
    ],
)  # fmt: skip
def test_frames_of_fanuc(body, wanted):
    """Fanuc 16i operator's manual: G52 7.2.4, G92 7.2.1, G68 14.5, G16 13.3, G51 14.7 (1000 is life size), G51.1,
    G10 L2 and L20 7.2.3. Without a set-up sheet the first offset that is set is where the part's origin is."""
    assert tips("fanuc", START + body + "\nM30") == wanted


@pytest.mark.parametrize("name", ["fanuc", "haas", "mazak", "linuxcnc", "iso"])
def test_a_block_without_a_centre_behind_an_arc_is_no_straight_way_unless_the_machine_says_so(name):
    """Alarm 022 of Fanuc's list. A parameter of the machine may let it go straight, at the feed that is in force."""
    body = f"{START}G2 X10 Y0 I5 J0\nG43 Z4 H1\nG1 X20\nM30"
    sheet = SetUp(tools={"1": Tool(MACHINE.tool_length)})
    with pytest.raises(ProgramError, match=r"lacks its centre: .* for a straight way G0 or G1, since G2"):
        read_for(name, body, MACHINE, setup=sheet)
    path = read_for(with_options(name, arc_without_centre="straight"), body, MACHINE, setup=sheet)
    np.testing.assert_allclose(ends(path)[-2:], [[10.0, 0.0, 4.0], [20.0, 0.0, 4.0]], atol=1e-9)
    np.testing.assert_allclose(path.feed[-2:], 0.01, rtol=1e-12)
    assert not path.rapid[-2:].any()


@pytest.mark.parametrize(("plane", "words", "wanted"), [
    ("G17", "X2. Y0 Z0", [0, 2, 0]), ("G17", "X0 Y2. Z0", [-2, 0, 0]), ("G17", "X0 Y0 Z2.", [0, 0, 2]),
    ("G18", "X0 Y0 Z2.", [2, 0, 0]), ("G18", "X2. Y0 Z0", [0, 0, -2]), ("G18", "X0 Y2. Z0", [0, 2, 0]),
    ("G19", "X0 Y2. Z0", [0, 0, 2]), ("G19", "X0 Y0 Z2.", [0, -2, 0]), ("G19", "X2. Y0 Z0", [2, 0, 0]),
])  # fmt: skip
def test_g68_turns_the_plane_that_is_in_force(plane, words, wanted):
    """Fanuc 16i operator's manual, 14.5: counterclockwise in the plane, of which the first axis is X of G17, Z of G18,
    Y of G19; a quarter turn brings the first axis onto the second, and leaves the third."""
    body = f"G90 G21 G94 {plane} F600\nG0 X0 Y0 Z0\nG68 R90.\nG1 {words}\nM30"
    assert tips("fanuc", body)[-1] == wanted


def test_g10_l20_of_the_generic_control_calls_the_place_in_the_kind_of_offset_in_force():
    """LinuxCNC, G Codes, "G10 L20": the value is such that the present place becomes the value given; while G54.1 is in
    force P is one of these."""
    body = "G54.1 P2\nG0 X1.\nG10 L20 P3 X5.\nG54.1 P3\nG1 X6.\nG54\nX6."
    assert tips("iso", START + body)[1:] == [[1, 0, 0], [2, 0, 0], [6, 0, 0]]


def test_g10_l20_of_haas_tells_g154_and_needs_its_number():
    """Haas mill operator's manual, G10: L20 is of the auxiliary offsets, G154 P1 to P99."""
    body = START + "G154 P1\nG10 L20 P1 X100.\nG10 L20 P2 X130.\nG1 X1.\nG154 P2\nX1.\nG54\nX3."
    assert tips("haas", body)[1:] == [[1, 0, 0], [31, 0, 0], [3, 0, 0]]
    with pytest.raises(ProgramError, match="needs the number of an offset G154 as P"):
        tips("haas", START + "G154 P1\nG10 L20 X1.\nG1 X1.")


def test_an_arc_in_mirrored_coordinates_turns_the_other_way():
    path = read_for("fanuc", "G90 G21 G17 F600\nG0 X10. Y0. Z0.\nG51.1 X0.\nG1 X10.\nG3 X0. Y10. I-10. J0.\nM30")
    angle = np.unwrap(np.arctan2(path.tip[1:, 1], path.tip[1:, 0]))
    assert angle[-1] - angle[0] == pytest.approx(-math.pi / 2)


def test_work_offsets_are_those_of_the_set_up_sheet():
    """Offsets are machine coordinates of the part's origin; axis words are joints without tip mode."""
    sheet = SetUp(offsets={"G54": {"X": 0.1, "Y": 0.0, "Z": 0.0}, "G54.1 P2": {"X": 0.13, "Y": 0.01, "Z": 0.0}},
                  machine_zero={"X": 0.0, "Y": 0.0, "Z": 0.0})  # fmt: skip
    path = read_for("fanuc", "G90 G21 F600\nG54 G0 X0. Y0. Z0.\nG1 X1.\nG54.1 P2 X1. Y1.\nM30", MACHINE, setup=sheet)
    assert np.diff(ends(path), axis=0) == pytest.approx(np.array([[1, 0, 0], [30, 11, 0]]))


def test_g43_h_shifts_by_the_length_of_the_table_and_two_tools_are_two_lengths():
    """Fanuc 16i, 14.1 "Tool length offset": the tip stands where Z says, the joint is higher by the length."""
    sheet = SetUp(tools={"1": Tool(0.1), "2": Tool(0.15)}, machine_zero={"Z": 0.0})
    body = "G90 G21 F600\nT1 M6\nG43 H1 G0 X0. Y0. Z10.\nG1 X1.\nT2 M6\nG43 H2 Z10.\nG1 X2.\nM30"
    machine = Machine.load("xyzac-trunnion")
    path = read_for("fanuc", body, machine, setup=sheet)
    assert ends(path)[:, 2].tolist() == pytest.approx([10, 10, 10, 10])
    z = machine.joints_at(path.tip, path.rotary, path.tool_length)[:, machine.joints.index("Z")] * 1e3
    assert np.diff(z).tolist() == pytest.approx([0, 50, 0])
    # when the tool is changed the joints stay, and the tip of the longer one is 50 mm lower
    assert path.stop.tolist() == [True, True, False, True] and path.way[2].tolist() == pytest.approx([0, 0, 0.05])
    plain = read_for("fanuc", body.replace("G43 H1", "").replace("G43 H2", ""), machine)
    assert np.ptp(plain.tip[:, 2]) == pytest.approx(0)


# --- places of the machine --------------------------------------------------------------------------------------

SHEET = SetUp(machine_zero={"X": 0.5, "Y": 0.4, "Z": 0.3}, references={1: {"X": 0, "Y": 0, "Z": 0}, 2: {"Z": -0.1}})


def test_g28_goes_over_the_place_named_to_the_reference_point_with_the_axes_named():
    """Fanuc 16i, 6.1 "Reference position return": over the intermediate point, only the axes commanded."""
    path = read_for("fanuc", START + "G1 X10.\nG91 G28 Z5.\nG28 X0. Y0.\nM30", MACHINE, setup=SHEET)
    joints = path.tip * 1e3
    assert joints.tolist()[1:] == pytest.approx(np.array([[10, 0, 0], [10, 0, 5], [10, 0, 300], [500, 400, 300]]))
    assert path.rapid[2:].all() and path.stop[[3, 4]].all()


def test_g30_g53_and_g29():
    """Fanuc 16i, 6: G30 to the second reference point (P2); G29 back over the intermediate point. 7.1: G53."""
    path = read_for("fanuc", START + "G91 G30 P2 Z0.\nG90 G53 G0 X-100. Y0.\nG1 X0. Y0. Z0.\nM30", MACHINE, setup=SHEET)
    assert ends(path)[1:].tolist() == pytest.approx(np.array([[0, 0, 200], [400, 400, 200], [0, 0, 0]]))
    path = read_for("fanuc", START + "G28 Z20.\nG29 X5. Z1.\nM30", MACHINE, setup=SHEET)
    assert (path.tip * 1e3).tolist()[1:] == pytest.approx(np.array([[0, 0, 20], [0, 0, 300], [0, 0, 20], [5, 0, 1]]))


def test_a_bare_g53_is_nothing_and_g28_without_axes_goes_home_where_it_does():
    """Posts for Fanuc write G53 alone; G28 without axes moves all of them on LinuxCNC and Haas, none on Fanuc."""
    assert ends(read_for("fanuc", START + "G1 X1.\nG53\nG28\nX2.\nM30", MACHINE, setup=SHEET))[-1].tolist() == [2, 0, 0]
    path = read_for("linuxcnc", START + "G1 X1\nG28\nM2", MACHINE, setup=SHEET)
    assert ends(path)[-1] == pytest.approx([500, 400, 300])


# --- five axes --------------------------------------------------------------------------------------------------


def test_g43_4_fixes_its_frame_where_the_table_stands_on_fanuc():
    """Fanuc A-79348E: the frame of tool centre point control is fixed to the table where G43.4 is read."""
    body = "G90 G21 F600\nG0 A0. C90.\nG43.4 H1 X10. Y0. Z0.\nG1 X20.\nM30"
    a, b = ends(read_for("fanuc", body, MACHINE))[-2:], ends(read_for("haas", body, MACHINE))[-2:]
    assert any("where the table stands turned" in told for told in read_for("fanuc", body, MACHINE).assumed)
    at_zero = read_for("fanuc", body.replace("C90.", "C0."), MACHINE)
    assert not any("where the table stands turned" in told for told in at_zero.assumed)
    assert np.abs(b - [[10, 0, 0], [20, 0, 0]]).max() < 1e-9
    assert np.abs(np.linalg.norm(a, axis=1) - [10, 20]).max() < 1e-9 and np.abs(a[:, 0]).max() < 1e-9


def test_g43_5_takes_the_tool_axis():
    """Fanuc A-79348E: I J K are the tool axis at the end of the block, in the frame of the table."""
    path = read_for("fanuc", "G90 G21 F600\nG43.5 H1\nG0 X0. Y0. Z0. I0 J0 K1.\nG1 X10. I0 J1. K2.\nX20.\nM30", MACHINE)
    assert path.axis[-1] == pytest.approx(np.array([0, 1, 2]) / math.sqrt(5))
    with pytest.raises(ProgramError, match="tool axis I, J, K is zero"):
        read_for("fanuc", "G90 G43.5 H1\nG0 X0. Y0. Z0. I0 J0 K0\nM30", MACHINE)


def test_g68_2_lays_the_coordinates_into_a_plane_and_g53_1_turns_the_tool_to_it():
    """Fanuc 30i, "Tilted working plane": R = Rz(I) Rx(J) Rz(K) about X Y Z; Z is then along the tool."""
    body = "G90 G21 F600\nG0 X0. Y0. Z50.\nG68.2 X10. Y0. Z5. I0. J30. K0.\nG53.1\n"
    body += "G0 X0. Y0. Z20.\nG1 Z0.\nG1 Y7.\nG69\nM30"
    path = read_for("fanuc", body, Machine.load("xyzac-trunnion"))
    normal = np.array([0, -math.sin(math.radians(30)), math.cos(math.radians(30))])
    assert path.axis[-1] == pytest.approx(normal)
    along = np.array([0, math.cos(math.radians(30)), math.sin(math.radians(30))])
    at = np.array([10, 0, 5])
    assert ends(path)[-3:] == pytest.approx(np.array([at + 20 * normal, at, at + 7 * along]), abs=1e-9)


def test_g254_keeps_axes_parallel_to_the_machine_and_carries_the_origin():
    """Haas, G254 "Dynamic work offset": the part's origin goes with the table, X Y Z stay the machine's."""
    machine = Machine.load("xyzac-trunnion")
    body = "G90 G21 F600\nG0 X0. Y0. Z100.\nG0 A-90. C0.\nG254\nG0 X0. Y0. Z30.\nG1 Z10.\nX5.\nG255\nM30"
    path = read_for("haas", body, machine)
    axis = path.axis[-1]
    assert ends(path)[-2] == pytest.approx(10 * axis, abs=1e-9)
    assert ends(path)[-1] == pytest.approx(10 * axis + [5, 0, 0], abs=1e-9)


def test_g7_of_millplus_tilts_turns_the_axes_and_tells_them():
    """Autodesk's post-processor for MillPlus: A5 B5 C5 about fixed axes, B7 and C7 take the angles, L1=1 turns."""
    machine = Machine.load("xyzbc-trunnion")
    body = "G71 G90 G94 F600\nG0 X0. Y0. Z50.\nG93 X10. Y0. Z0.\nG7 B5=30. B7=254 C7=255\n"
    body += "G0 B=E254 C=E255\nX0. Y0. Z20.\nG1 Z0.\nM30"
    path = read_for("millplus", body, machine)
    normal = np.array([math.sin(math.radians(30)), 0, math.cos(math.radians(30))])
    assert path.axis[-1] == pytest.approx(normal)
    assert ends(path)[-2:] == pytest.approx(np.array([[10, 0, 0] + 20 * normal, [10, 0, 0]]), abs=1e-9)


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

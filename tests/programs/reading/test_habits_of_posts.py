"""What posts for mills commonly write: heads, tool calls, data. Each test says where the habit stands."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for, tips
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.recognise import recognise
from toolpace.programs.reading.languages import dialect_of, is_conversational
from toolpace.programs.reading.source import Source

START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z10.\n"


@pytest.mark.parametrize("controller", ["fanuc", "haas", "mazak", "iso", "linuxcnc"])
def test_one_block_ends_cycles_and_begins_a_motion(controller):
    """Fanuc B-63944EN, list of G codes: G80 is of group 09, G0 of group 01. Heads of most posts rely on it."""
    body = START + "G99 G81 X1. Z-3. R2.\nG0 G17 G40 G49 G80 G90\nX5.\nM30"
    assert tips(controller, body)[-1] == [5, 0, 2]


def test_the_second_t_of_a_block_is_the_tool_made_ready():
    """Autodesk's post for Mazak, tool calls: T12 T13 M6 changes to 12."""
    path = read_for("mazak", START + "T12 T13 M6\nG1 X1.\nM30")
    assert path.operations[-1].tool == "12"


def test_parameters_that_a_program_sets_are_no_motion():
    """Fanuc B-63944EN, chapter 16.2: G10 L52, lines N (parameter) P (axis) R (value), ended by G11."""
    path = read_for("fanuc", START + "G10 L52\nN1401 R1\nN1020 P1 R88\nG11\nN10 G1 X1.\nM30")
    assert (path.tip[-1] * 1e3).tolist() == [1, 0, 10]
    assert any("G10 L52" in said for said in path.assumed)


def test_an_m_word_of_the_builder_is_said():
    assert any("M250" in said for said in read_for("fanuc", START + "M250\nG1 X1.\nM30").assumed)


def test_rigid_tapping_of_the_format_of_the_15():
    """Fanuc 0i operator's manual, 13.2: G84.2 is rigid tapping in the tape format of the series 15."""
    body = START + "G99 G84.2 X1. Z-3. R2. F100\nG80\nM30"
    assert tips("fanuc", body) == tips("fanuc", body.replace("G84.2", "G84"))


def test_a_comment_ends_with_its_line_where_no_controller_is_told():
    """Fadal user manual, "Comments": an opening bracket alone makes the rest of the line a comment."""
    assert tips("iso", "N1 O1 (PART\n" + START + "G1 X1\nM30")[-1] == [1, 0, 10]


def test_klartext_without_block_numbers_is_klartext():
    """TNC 640 Klartext Programming, 3.4: BEGIN PGM opens a program; files of posts may lack the numbers."""
    assert is_conversational(Source.from_text("BEGIN PGM A MM\nL X+1 Y+1 FMAX\nEND PGM A MM\n", "a.txt"))
    assert is_conversational(Source.from_text("N1 TOOL CALL 1 Z S9\n", "a.txt"))
    assert is_conversational(Source.from_text("L X1.5 Y2 FMAX\nL Z-0.2 F100\n", "a.txt"))
    assert not is_conversational(Source.from_text("%\n(BEGIN PGM A)\nG0 X1\nM30\n", "a.txt"))


def test_ending_contour_control_is_no_sign_of_mazak():
    """Fanuc B-63944EN, 20.4: G05 P10000 begins contour control, G05 P0 ends it; G05 P2 is Mazak's."""
    text = "%\nO1000\nG5 P10000\nG1 X1.\nG5 P0\nG91 G28 Z0.\nM30\n%\n"
    assert recognise(Source.from_text(text, "a.nc"))[0].name == "fanuc"
    assert recognise(Source.from_text(text.replace("P10000", "P2"), "a.nc"))[0].name == "mazak"


MODAL = "G66 P9200 Z-5. R2.\nX10. Y10.\nM8\nX20. Y10.\nG67\nX30.\nM30\nO9200\n#3=#5003\nG0 Z#18\nG1 Z#26\nG0 Z#3\nM99"


def test_a_modal_macro_is_called_behind_each_motion():
    """Fanuc B-63944EN, chapter "Modal call (G66)": behind blocks that move, with the arguments of G66, until G67."""
    got = tips("fanuc", START + MODAL)
    hole = [2, -5, 10]
    first, second = ([[x, 10, z] for z in hole] for x in (10, 20))
    assert got == [[0, 0, 10], [10, 10, 10], *first, [20, 10, 10], *second, [30, 10, 10]]


def test_local_variables_of_a_modal_macro_stay_from_call_to_call_and_are_its_own():
    """Fanuc B-63944EN, "Modal call": local variables are set in the block of G66 only."""
    body = "G66 P9200 A1.\nX10.\nX20.\nG67\nM30\nO9200\nG1 Z#1\n#1=#1+1.\nM99"
    assert [row[2] for row in tips("fanuc", START + body)] == [10, 10, 1, 1, 2]
    body = "#1=7\nG66 P9200 A1. L0\nX10.\nG67\nX#1\nM30\nO9200\nG1 Z#1\nM99"
    assert tips("fanuc", START + body)[1:] == [[10, 0, 10], [7, 0, 10]]


PROBING = "G65 P9832\nG65 P9810 X5. Z2. F3000.\nG65 P9811 Z0. S1.\nG65 P9833\nG1 X7.\nM30"


def test_probing_moves_between_its_measurements_and_those_are_refused_in_one_run():
    """Renishaw Inspection Plus: O9810 moves straight at F, O9832 and O9833 switch; O9811 measures."""
    path = read_for("fanuc", START + PROBING, skip_unknown=True)
    assert (path.tip * 1e3).tolist() == [[0, 0, 10], [5, 0, 2], [7, 0, 2]]
    assert (path.feed[1:] * 60e3).round(9).tolist() == [3000, 100]
    with pytest.raises(ProgramError, match=r"G65 P9811 is not read: .*--skip-unknown"):
        read_for("fanuc", START + PROBING)


def test_repeats_of_the_older_format_are_read_too():
    """Fanuc B-63944EN, appendix on the tape format of the series 15: L for K."""
    body = START + "G91 G99 G81 X4. Z-5. R-8. {}3\nG80\nM30"
    assert tips("fanuc", body.format("L")) == tips("fanuc", body.format("K"))


@pytest.mark.parametrize("word", ["G54.2", "G54.4"])
def test_p0_ends_what_is_not_read(word):
    """Fanuc B-63944EN, "Rotary table dynamic fixture offset": P0 cancels it, as heads of programs do."""
    assert tips("fanuc", START + f"{word} P0\nG1 X1.\nM30")[-1] == [1, 0, 10]
    with pytest.raises(ProgramError, match=f"{word} P1 is not read"):
        read_for("fanuc", START + f"{word} P1\nG1 X1.\nM30")


def test_a_slash_within_a_block_leaves_its_last_words_to_the_operator():
    """Fanuc B-63944EN, "Optional block skip": what follows / up to the end of the block is skipped, if so switched."""
    body = START + "G1 X1. /M8\nX2.5 /2 Y1.\nM30"
    assert tips("fanuc", body)[-1] == [2.5, 0, 10]
    assert tips("fanuc", body, block_delete=False)[-1] == [2.5, 1, 10]
    assert tips("fanuc", START + "#1=[4/2]\nG1 X[#1/2]\nM30")[-1] == [1, 0, 10]


def test_holes_on_a_circle_and_on_an_arc():
    """Haas mill operator's manual 96-8000, G70 (I radius, J first angle, L holes) and G71 (K from hole to hole)."""
    body = START + "G99 G81 Z-1. R2. F100. L0\n{}\nG80\nM30"
    holes = [row for row in tips("haas", body.format("G70 X10. Y0 I5. J90. L4")) if row[2] == -1]
    assert holes == [[10, 5, -1], [5, 0, -1], [10, -5, -1], [15, 0, -1]]
    holes = [row for row in tips("haas", body.format("G71 X0 Y0 I5. J0. K90. L2")) if row[2] == -1]
    assert holes == [[5, 0, -1], [0, 5, -1]]
    with pytest.raises(ProgramError, match="G70 drills with the cycle in force"):
        read_for("haas", START + "G70 I5. J0 L4\nM30")


def test_the_tilted_frame_of_haas_turns_about_fixed_axes_in_the_order_of_q():
    """haascnc.com, G268 "Feature coordinate system" and G253; Q123 as Autodesk's post writes it (EULER_ZYX)."""
    body = "G90 G21 G17 F600.\nG0 X0 Y0 Z50. B0 C0\nG268 X10. Y0 Z0 I0 J30. K45. Q123\nG253\nG0 X0 Y0 Z20.\nG1 Z0\nM30"
    path = read_for("haas", body, Machine.load("xyzbc-trunnion"))
    normal = np.array([np.sin(np.pi / 6) * np.cos(np.pi / 4), np.sin(np.pi / 6) * np.sin(np.pi / 4), np.cos(np.pi / 6)])
    assert np.allclose(path.axis[-1], normal) and np.allclose(path.tip[-1] * 1e3, [10, 0, 0])
    assert np.allclose((path.tip[-2] - path.tip[-1]) * 1e3, 20 * normal)
    for words, message in (("J30. K45.", "G268 without Q"), ("I1. J30. K45. Q313", "G268 Q313")):
        with pytest.raises(ProgramError, match=message):
            read_for("haas", body.replace("I0 J30. K45. Q123", words), Machine.load("xyzbc-trunnion"))


def test_a_slash_behind_the_sequence_number():
    """Fanuc B-63944EN, "Optional block skip": / stands at the head of the block, in programs also behind N."""
    body = START + "N10 /G1 X1.\nN20/2 X2.\nG1 X3.\nM30"
    assert tips("fanuc", body)[1:] == [[3, 0, 10]]
    assert tips("fanuc", body, block_delete=False)[1:] == [[1, 0, 10], [2, 0, 10], [3, 0, 10]]


def test_of_words_that_set_one_mode_the_last_rules():
    """Fanuc B-63944EN, "Preparatory function (G function)": of several of one group the last is effective."""
    assert tips("fanuc", START + "G91 G90 G0 G1 X1.\nX1.\nM30") == [[0, 0, 10], [1, 0, 10]]
    with pytest.raises(ProgramError, match="exclude each other"):
        read_for("linuxcnc", START + "G91 G90 G1 X1\nM2")


def test_corners_of_forbidden_zones_are_no_motion():
    """Fanuc B-63944EN, "Stroke check": G22 X Y Z I J K."""
    assert tips("fanuc", START + "G1 X1.\nG22 X9. Y9. Z9. I0 J0 K0\nX2.\nM30")[1:] == [[1, 0, 10], [2, 0, 10]]


def test_names_of_programs_and_radii_of_tools():
    """Fanuc 30i-B, "Program name": <NAME>; B-63944EN, "Tool compensation values": G10 L12 and L13 are of the radius."""
    body = START + "G10 L12 P1 R5.\nG10 L13 P1 R0\nG1 X1.\nM30\n%"
    assert tips("fanuc", "%\n<BRACKET_OP-1>(TEXT)\n" + body)[-1] == [1, 0, 10]


def test_roll_pitch_and_yaw_of_a_tilted_plane_where_one_turns():
    """Fanuc B-63944EN, "Tilted working plane": P1 Q123 turns about X, Y and Z by I, J and K."""
    body = "G90 G21 G17 F600.\nG54\nG0 X0 Y0 Z50. B0 C0\nG68.2 {} X10. Y0 Z0 I0 J{} K0\nG53.1\nG1 X0 Y0 Z20.\nM30"
    machine = Machine.load("xyzbc-trunnion")
    path = read_for("fanuc", body.format("P1 Q123", "30."), machine)
    assert np.allclose(path.axis[-1], [0.5, 0, np.sqrt(0.75)])
    assert np.allclose(path.tip[-1] * 1e3, [20, 0, 20 * np.sqrt(0.75)])
    with pytest.raises(ProgramError, match=r"G68\.2 P1 with several angles"):
        read_for("fanuc", body.format("P1 Q123 ", "30.").replace("K0", "K5."), machine)


def test_notes_behind_a_slash_are_no_words():
    """Some posts put notes of theirs behind `/`: a block that is left out may say anything."""
    body = START + "//DATE=09-07-10 TIME 11:53\n/(a note without end\nN5 /see drawing 3\nG1 X5.\nM30"
    assert tips("fanuc", body)[-1] == [5, 0, 10]
    with pytest.raises(ProgramError, match="'DATE' is no letter with a number"):
        tips("fanuc", body, block_delete=False)


def test_m98_hands_no_values_over():
    with pytest.raises(ProgramError, match="M98 with V is not read: it hands no values over: write G65 in its place"):
        tips("fanuc", START + "M98 P9998 I10. D2. Z-1. V.1 R1.5 X1.\nM30\nO9998\nM99")


def test_units_of_other_controls_have_their_cure():
    """NX's default words for units are G70 and G71, whatever the control."""
    with pytest.raises(ProgramError, match="G71 is not read: other controls say millimetres by it: write G21"):
        tips("fanuc", START + "G71\nG1 X5.\nM30")


def test_a_value_of_another_control_is_no_header_of_a_table():
    """Okuma's `X[VC1*2]` was taken for a column; its header tells it."""
    text = "O1001\nG15 H1\nVC1=10.5\nX[VC1*2]\nM02\n"
    assert dialect_of(Source.from_text(text)).dialect == "gcode"
    for header in ("x [mm],y [mm]", "X(mm);Y(mm)", "x,y,z", '"x [mm]","y [mm]"', "x\ty"):
        assert dialect_of(Source.from_text(header + "\n1,2,3\n")).dialect == "csv"
    with pytest.raises(ProgramError, match="this header is of Okuma's OSP"):
        dialect_of(Source.from_text("$O1001.MIN%\n" + text, "part.min"))


def test_a_macro_takes_m_as_an_argument():
    """Fanuc B-63944EN, "Argument specification I": M is #13, as D is #7; G65 stands before all of them."""
    body = "G65 P2000 X4. M48 D3\nM30\nO2000\nG1 X#24 Y#13 Z#7\nM99"
    assert tips("fanuc", START + body)[-1] == [4, 48, 3]
    assert tips("fanuc", START + body.replace("M48", "M[40+8]"))[-1] == [4, 48, 3]


def test_an_alarm_that_a_program_raises_is_refused_and_ends_it():
    """Fanuc B-63944EN, "Macro alarms": #3000=1 stops the control with alarm 3001."""
    body = START + "G1 X1.\nIF [#5041 LT 5] GOTO 7\nN7 #3000=12 (TOO SHORT)\nG123 X2.\nM30"
    with pytest.raises(ProgramError, match=r"#3000=12 is not read: the program stops itself with this alarm") as caught:
        read_for("fanuc", body)
    assert "G123" not in str(caught.value)


def test_holes_round_a_pole_by_increments_of_the_angle():
    """Fanuc B-63944EN, "Polar coordinate command (G15, G16)": the bolt hole circle, by G90 and by G91."""
    body = "G16\nG81 X100. Y30. Z-20. R-5. F200.\n{}\nG15 G80\nM30"
    wanted = tips("fanuc", START + body.format("Y150.\nY270."))
    assert tips("fanuc", START + body.format("G91 Y120.\nY120.")) == wanted
    assert tips("fanuc", START + body.format("G91 Y120. K2")) == wanted


def test_what_the_operator_may_interrupt_moves_nothing():
    """Fanuc B-63944EN, "Automatic operation control": #3003 and #3004; #3001 and #3002 are clocks."""
    path = read_for("fanuc", START + "#3001=0\n#3003=1\n#3004=2\nG1 X1.\n#3003=0\nM30")
    assert path.tip[-1, 0] == 0.001 and path.skipped["#3003"] == 2

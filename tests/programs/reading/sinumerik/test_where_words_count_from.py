"""What distances, polar words, CT and $ variables count from, behind everything that may stand between.

Poles: NC Programming 12/2019, 2.9.3. Distances behind a frame: SD42440 = 1. Units of $ variables: Function Manual
Basic Functions, G2, "G functions G700/G710". INT: Job Planning, "Possible type conversions".
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.sinumerik import ends, last, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

STILL = ('MSG("A")', "FGROUP(X,Y)", "CYCLE832(0.01,1)", "M8", "STOPRE", "G18", "T1 M6")


@pytest.mark.parametrize("between", STILL)
def test_a_distance_moves_by_the_change_of_the_frame_too_whatever_stands_between(between):
    assert last(f"G1 X5\nTRANS X10\n{between}\nG91 X1") == pytest.approx([16, 0, 0])


@pytest.mark.parametrize("between", ["G1 Y3", "CYCLE81(5,0,1,-2)", "SUPA G0 Y3", "TRAORI", "CYCLE800()"])
def test_a_distance_is_refused_where_something_moved_behind_the_frame(between):
    """The axis was not named: whether its shift is still to come is not told."""
    text = f"G1 X5\nTRANS X10\n{between}\nG17 G91 G1 X1"
    with pytest.raises(ProgramError, match=r"write X=AC\(\) once before"):
        last(text, "xyzac-trunnion")
    assert last(text.replace("G17", "G17 G90 X6\n"), "xyzac-trunnion")[0] == pytest.approx(17)


@pytest.mark.parametrize(
    "between",
    [
        "G0 X20 Y9\nCYCLE81(0,-5,1,-9)", "S100 M3\nG331 Z-5 K1\nG332 Z0 K1", "SUPA G0 Z0\nG1", "AROT Z30", "G58 X3",
        "BSPLINE X11 Y1\nX12 Y5\nX13 Y8", "G55",
    ],
)  # fmt: skip
def test_ct_goes_on_from_a_motion_of_its_own_coordinates(between):
    before = "$P_UIFR[1]=CTRANS(X,0)\n$P_UIFR[2]=CROT(Z,90)\nG54\nG1 X10"
    with pytest.raises(ProgramError, match="CT needs a motion before it, whose direction"):
        last(f"{before}\n{between}\nCT X40 Y10", "xyzac-trunnion")


def test_ct_goes_on_behind_a_subprogram_that_saves():
    """G1 Y10 was the last motion: CT to X20 Y10 is half a circle about X15 Y10, whose top is at Y15."""
    path = read('G1 X10\nSUB1\nMSG("A")\nCT X20 Y10\nM30\nPROC SUB1 SAVE\nG1 Y10\nM17')
    assert path.tip[:, 1].max() * 1e3 == pytest.approx(15, abs=2e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G111 X5 Y0\nG1 RP=5 AP=180\nG1 X30 Y0\nAP=90", "AP without RP: RP was 5, and the tool is 25 from"),
        ("G111 X5 Y0\nG1 RP=5 AP=180\nG111 X30 Y0\nG1 RP=5", "AP is missing"),
        ("G1 RP=5 AP=90\nG18\nG1 RP=5", "AP is missing"), ("G1 AP=30", "RP is missing"), ("G1 RP=9", "AP is missing"),
        ("G111 X5 Y0\nG1 RP=5 AP=90\nG18\nG1 RP=5 AP=0", "write G111 anew"),
        ("G111 X5 Y0\nG18\nG112 X1 Z0\nG1 RP=5 AP=0", "write G111 anew"),
        ("G111 X0 Y0\nTRANS X100\nG1 RP=5 AP=90", "write G111 anew"),
        ("G111 X0 Y0\nG1 RP=5 AP=90\nRP=IC(2)", r"RP=IC\(\) has no meaning"),
        ("G111 X0 Y0\nG1 RP=5 AP=DC(90)", r"AP=DC\(\) has no meaning"),
        ("G111 X0 Y0\nG1 RP=5 AP=IC(9)", r"AP=IC\(\) counts from an AP"),
        ("G2 X10 Y10 CR=IC(10)", r"CR=IC\(\) has no meaning"),
    ],
)  # fmt: skip
def test_polar_words_that_count_from_nothing_are_refused(text, message):
    with pytest.raises(ProgramError, match=message):
        last(text)


def test_polar_words_that_last():
    assert last("G111 X5 Y0\nG1 RP=5 AP=180\nAP=AC(90)") == pytest.approx([5, 5, 0])
    assert last("G1 RP=5 AP=90\nG18\nG1 RP=5 AP=0") == pytest.approx([0, 5, 5])


def test_variables_of_the_control_are_in_its_unit_under_g70_and_in_the_programs_under_g700():
    """The control is metric, since F stands under G71: X is at 25.4 mm, and G1 Y=25.4 inch is 645.16 mm."""
    read_x = "G71 F100 G1 X25.4\n{} R1=0\nR1=$P_EP[X]\nG1 Y=R1"
    assert last(read_x.format("G700")) == pytest.approx([25.4, 25.4, 0])
    assert last(read_x.format("G70")) == pytest.approx([25.4, 645.16, 0])
    offsets = "F100\n$P_UIFR[1,X,TR]=1\n{}\nG71\nG55\nG1 X0 Y1"
    assert last(offsets.format("G70\n$P_UIFR[2,X,TR]=2")) == pytest.approx([1, 1, 0])
    assert last(offsets.format("G700\n$P_UIFR[2,X,TR]=2")) == pytest.approx([49.8, 1, 0])
    with pytest.raises(ProgramError, match="in another unit than the control's"):
        last(offsets.format("G70\n$P_UIFR[2]=CTRANS(X,2)"))


def test_an_offset_that_is_written_again_goes_elsewhere():
    """Two parts 100 mm apart with one program: the first is where the tool moved first."""
    one, two = "$P_UIFR[1,X,TR]=5\n$P_UIFR[1,Y,TR]=7\nG54\nG1 X1 Y1", "$P_UIFR[1,X,TR]=105\nG54\nX1 Y1"
    assert ends(f"{one}\n{two}\nZ1")[-2:] == pytest.approx(np.array([[101, 1, 0], [101, 1, 1]]))
    assert last(f"{one}\n$P_UIFR[2]=CTRANS(X,25,Y,7)\n{two}\nG55\nX1") == pytest.approx([21, 1, 0])


def test_the_last_end_behind_a_change_of_frames_is_refused():
    with pytest.raises(ProgramError, match="behind a change of frames is not read"):
        last("G1 X5\nTRANS X5\nG1 Y=$P_EP[X]")
    assert last("G1 X5\nTRANS X5\nG1 Y=$AA_IW[X]+3") == pytest.approx([5, 3, 0])
    assert last("G1 X5\nTRANS X5\nX2\nG1 Y=$P_EP[X]") == pytest.approx([7, 2, 0])


@pytest.mark.parametrize("block", ["R1=2 G1 X=R1", "G1 X=R1 R1=2"])
def test_a_word_that_reads_what_its_block_assigns_is_refused(block):
    with pytest.raises(ProgramError, match="X reads what its own block assigns"):
        last(f"R1=5\n{block}")
    assert last("R1=5\nG1 X=R1 R2=2\nY=R2") == pytest.approx([5, 2, 0])


def test_an_int_is_rounded_as_round_does():
    values = {"0.5": 1, "2.5": 3, "-2.5": -3, "2.4": 2, "-0.6": -1}
    for written, wanted in values.items():
        assert last(f"DEF INT N\nN={written}\nG1 X=N Y=ROUND({written}) Z1")[:2] == [wanted, wanted], written


def test_an_end_label_beside_other_words_is_refused():
    with pytest.raises(ProgramError, match="ENDLABEL: beside other words"):
        last("G91\nAA: G1 X1\nENDLABEL: Y1\nREPEAT AA P=2")


SHEET = SetUp(tools={"1": Tool(length=0.1), "2": Tool(length=0.15)})


def test_d0_beside_a_change_of_the_tool_stays():
    """D that stands in the block of M6 counts; without it D1 does (MD20270 = 1)."""
    at_ten = {
        change: read(f"{change}\nG0 X0 Y0 Z0\nG1 Z10 F900", "xyzac-trunnion", start="", setup=SHEET).tip[-1, 2]
        for change in ("T1 M6", "T1 M6\nD0", "T1 D0 M6", "T1 M6 D0", "T1 D0\nM6")
    }
    assert at_ten["T1 M6"] == at_ten["T1 D0\nM6"] != at_ten["T1 M6\nD0"]
    assert at_ten["T1 D0 M6"] == at_ten["T1 M6 D0"] == at_ten["T1 M6\nD0"]


@pytest.mark.parametrize("words", ["T1=2", "M1=6", "M2=30", "M1=0"])
def test_words_of_a_numbered_spindle_that_do_more_than_turn_it_are_refused(words):
    with pytest.raises(ProgramError, match=f"{words.split('=')[0]}= is not read"):
        last(f"G1 X5\n{words}\nX9")
    assert last("G1 X5\nM2=3 S2=500 H4\nX9") == pytest.approx([9, 0, 0])


@pytest.mark.parametrize(
    ("words", "turns"),
    [
        ("S1=6000 M1=3", 100.0),
        ("S1=6000 M3", 100.0),
        ("S6000\nM1=4", -100.0),
        ("S1=6000 M1=3\nS2=500 M2=4", 100.0),
        ("SETMS(2)\nS1=6000 M1=3 S2=1200 M2=4", -20.0),
        ("S1=6000 M1=3\nSETMS(2)\nSETMS\nS1=3000 S2=60", 50.0),
        ("S1=6000 M1=3\nM1=5", 0.0),
    ],
)
def test_speed_and_sense_of_the_master_spindle_may_have_its_number(words, turns):
    assert read(f"G0 X0\n{words}\nG1 X5 F500").spindle[-1] == pytest.approx(turns)


@pytest.mark.parametrize("word", ["A3=IC(1)", "A2=DC(5)"])
def test_tool_vectors_are_no_distances(word):
    with pytest.raises(ProgramError, match="has no meaning"):
        last(f"TRAORI\nG1 X5 {word}", "xyzac-trunnion")


def test_two_groups_that_ask_for_other_ways_between_vectors_are_said():
    for words, said in (("ORIWKS\nORIAXES", True), ("ORIMKS\nORIVECT", True), ("ORIMKS\nORIAXES", False)):
        path = read(f"TRAORI\n{words}\nG1 X5 A3=1 C3=1", "xyzac-trunnion")
        assert any("MD21104" in sentence for sentence in path.assumed) == said, words


def test_where_the_length_of_a_tool_acts_under_g18_is_said():
    assert any("SD42940" in sentence for sentence in read("G18 G1 X5").assumed)
    assert not any("SD42940" in sentence for sentence in read("G1 X5").assumed)

"""Words of one control each, by worked examples of manuals and by numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from testbed.linuxcnc.job import Cartesian
from tests.support.compensated import HEADS, SHEET, read
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool


def places(text: str, control: str, sheet: SetUp = SHEET) -> list[list[float]]:
    """X, Y [mm] of the ends of straight motions."""
    found = read(text, control, sheet)
    assert (found.bow == 0.0).all(), "there are arcs in it"
    return (found.tip[:, :2] * 1e3).round(4).tolist()


# --- Sinumerik ---------------------------------------------------------------------------------------------------


def test_cutconon_shifts_blocks_by_the_vector_at_the_end_of_the_contour():
    """The example of the Programming Guide Advanced, 8.4, with a tool of 10 mm; corners met (G451), by hand."""
    text = (
        "G451 G0 X0 Y0 Z0\nG1 X20 G42 NORM F100\nX30\nY20\nX10 CUTCONON\nY30\nX-10 CUTCONOF\nY20 NORM\nX0 Y0 G40\nM30\n"
    )
    wanted = [
        [0, 0], [20, -10], [40, -10], [40, 20], [20, 20], [20, 30], [10, 40], [-20, 40], [-20, 20], [0, 0],
    ]  # fmt: skip
    assert places(text, "sinumerik", SetUp(tools={"1": Tool(0.1, 0.01)})) == wanted


def test_arcs_are_shifted_under_cutconon():
    text = "G0 X-20 Y-20 Z0\nG41 G1 X0 Y0 F500\nY50\nCUTCONON X50\nG3 X60 Y60 CR=10\nCUTCONOF G1 Y90\nG40 X0\nM30\n"
    tip = read(text, "sinumerik").tip[:, :2] * 1e3
    on_arc = np.isclose(np.hypot(tip[:, 0] - 46, tip[:, 1] - 60), 10.0, atol=1e-3)
    assert on_arc.sum() > 10  # from (46, 50) to (56, 60) about (46, 60): 4 mm left of what is written
    assert tip[-3:].round(4).tolist() == [[56, 60], [56, 90], [0, 90]]


OUTLINE = "G0 X-20 Y-20 Z0\n{} G41 G1 X0 Y0 F500\nY50\nX50\nG40 X80\nM30\n"


def test_offn_adds_to_the_radius():
    assert places(OUTLINE.format("G451 OFFN=2.5"), "sinumerik")[1:4] == [[-6.5, 0], [-6.5, 56.5], [50, 56.5]]
    assert places(OUTLINE.format("G451 OFFN=-1"), "sinumerik")[1] == [-3, 0]


@pytest.mark.parametrize("word", ["G461", "G462", "DISC=50"])
def test_words_that_change_nothing_here(word):
    """G461 and G462 differ from G460 where ways do not meet; DISC belongs to G450 (NC Programming 12/2019, 2.10.3)."""
    assert places(OUTLINE.format(f"G451 {word}"), "sinumerik") == places(OUTLINE.format("G451"), "sinumerik")


@pytest.mark.parametrize("block", ["KONT G40", "G40 KONT", "G40\nKONT"])
def test_the_word_in_the_last_block_tells_how_it_leads_away(block):
    """From behind the contour's end, by KONT round it."""
    text = "G451 G0 X-20 Y-20 Z0\nG41 G1 X0 Y0 F500\nY50\n{} X20 Y60\nM30\n"
    assert places(text.format("NORM G40"), "sinumerik")[2:] == [[-4, 50], [20, 60]]
    # the line from (-4, 53) to (20, 60) passes (0, 50) at (24 * 3 + 7 * 4) / 25 = 4 mm
    assert places(text.format(block), "sinumerik")[2:] == [[-4, 53], [20, 60]]


def test_g40_comes_before_d_and_a_change_of_its_block():
    text = "G0 X-20 Y-20 Z0\nG41 G1 X0 Y0 F500\nY50\nG40 X-30 D0\nM30\n"
    assert places(text, "sinumerik")[2:] == [[-4, 50], [-30, 50]]


def test_a_plane_that_a_table_has_turned_to_the_tool_is_that_of_the_axes():
    """CUT2D and CUT2DF are one there, and differ where a head has turned the tool."""
    swivel = 'CYCLE800(0,"",0,57,0,0,0,30,0,0,0,0,0,-1)\n'
    text = HEADS["sinumerik"] + swivel + "{}\n" + OUTLINE.format("G451")
    table = Machine.load("xyzac-trunnion")
    flat = read_text(text.format("CUT2D"), table, controller="sinumerik", setup=SHEET)
    in_frame = read_text(text.format("CUT2DF"), table, controller="sinumerik", setup=SHEET)
    assert np.array_equal(flat.tip, in_frame.tip)
    cos, sin = math.cos(math.radians(30)), math.sin(math.radians(30))
    assert np.allclose(flat.tip[-3] * 1e3, [-4, 54 * cos, 54 * sin], atol=1e-6)
    with pytest.raises(ProgramError, match="write CUT2DF"):
        read_text(text.format("CUT2D"), Machine.load("xyzbc-head"), controller="sinumerik", setup=SHEET)


# --- Fanuc -------------------------------------------------------------------------------------------------------


def by_type(tmp_path, kind: str, contour: str) -> list[list[float]]:
    file = tmp_path / "mine.toml"
    file.write_text(f'name = "mine"\nlike = "fanuc"\nlanguage = "word-address"\n[options]\ncompensation = "{kind}"\n')
    text = HEADS["fanuc"] + f"G0 X0. Y0. Z0.\nF500\n{contour}M30\n"
    found = read_text(text, None, controller=file, setup=SHEET, name="part.nc")
    return (found.tip[:, :2] * 1e3).round(4).tolist()


@pytest.mark.parametrize("kind", ["type C", "type C as B"])
def test_type_c_shifts_the_tool_across_where_a_block_moves_nothing(tmp_path, kind):
    path = by_type(tmp_path, kind, "G41 D1\nG1 Y50.\nX50.\nG40\nX60.\n")
    assert path == [[0, 0], [-4, 0], [-4, 54], [50, 54], [50, 50], [60, 50]]


def test_type_c_begins_and_ends_beside_motions_as_types_a_and_b_do(tmp_path):
    contour = "G42 D1 G1 X20.\nY40.\nX60.\nG40 X70. Y90.\n"
    assert by_type(tmp_path, "type C", contour) == by_type(tmp_path, "type A", contour)
    assert by_type(tmp_path, "type C as B", contour) == by_type(tmp_path, "type B", contour)


@pytest.mark.parametrize(
    "contour", ["G41 D1 Z-5.\nG1 Y50.\nG40 X9.\n", "G41 D1\nZ-5.\nG1 Y50.\nG40 X9.\n", "G41 D1\nG1 Y50.\nG40 Z5.\n"]
)
def test_type_c_with_a_motion_across_the_plane_is_refused(tmp_path, contour):
    with pytest.raises(ProgramError, match="across the plane"):
        by_type(tmp_path, "type C", contour)


def test_type_c_does_not_begin_on_an_arc(tmp_path):
    with pytest.raises(ProgramError, match="begins with a straight motion"):
        by_type(tmp_path, "type C", "G41 D1\nG2 X10. Y10. R10.\nG40 X30.\n")


def test_d_of_the_same_radius_may_stand_within_a_contour():
    sheet = SetUp(tools={"1": Tool(0.1, 4e-3), "21": Tool(0.1, 4e-3)})
    text = "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\n{}X50\nG40 X80\nM30\n"
    assert places(text.format("D21 "), "fanuc", sheet) == places(text.format(""), "fanuc", sheet)


# --- Klartext ----------------------------------------------------------------------------------------------------


def test_ways_of_one_axis_are_longer_by_r_plus_and_shorter_by_r_minus():
    """A pocket from its middle, and past its edge (TNC 407, "Shortening or lengthening single-axis movements")."""
    text = (
        "L X+0 Y+0 Z+0 R0 FMAX\nX+50 R- F500\nY+30 R-\nX-50 R-\nX+0 R+\nX+20 R0\nIX+5 R0\nM30\nEND PGM A MM\n"
    )
    wanted = [[0, 0], [46, 0], [46, 26], [-46, 26], [4, 26], [20, 26], [25, 26]]
    assert places(text, "heidenhain") == wanted


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("IX+50 R-", "absolute coordinate"), ("X+50 Y+20 R-", "one axis"), ("Z+50 R-", "working plane"),
        ("X+3 R-", "not longer than"), ("X+50 R-\nIX+5 R0", "no sure beginning"), ("C X+50 Y+0 DR+ R-", "one axis"),
        ("CYCL DEF 11.0 M\nCYCL DEF 11.1 SCL 2\nX+50 R-", "scaled"), ("L X+50 RL\nL Y+50\nX+9 R-", "write R0 before"),
    ],
)  # fmt: skip
def test_what_of_r_plus_and_r_minus_is_refused(block, said):
    text = f"L X+0 Y+0 Z+0 R0 FMAX\nCC X+25 Y+0\nL Z-1 F500\n{block}\nM30\nEND PGM A MM\n"
    with pytest.raises(ProgramError, match=said):
        read(text, "heidenhain")


@pytest.mark.parametrize("machine", [None, Cartesian()])
def test_r0_beside_m91_ends_the_compensation(machine):
    """The way up at the end of nearly every program: with a machine, and without one, where it is passed over."""
    contour = "L X-20 Y-20 Z+0 R0 FMAX\nL X+0 Y+0 RL F500\nL Y+50\nL Z-1 R0 FMAX M91\nL X+60 FMAX\nM30\nEND PGM A MM\n"
    found = read_text(HEADS["heidenhain"] + contour, machine, controller="heidenhain", setup=SHEET)
    assert (found.tip[-1, :2] * 1e3).round(4).tolist() == [60, 50]
    assert (found.tip[-2, :2] * 1e3).round(4).tolist() == [-4, 50]

"""Words of LinuxCNC that its own interpreter reads so: what was once read otherwise, one test each.

Its interpreter judges random programs in `test_against_rs274.py`; figures here are of the documents' rules.
"""

from __future__ import annotations

import pytest

from tests.support.controllers import read_for, tips
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

MM = 1e-3
START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z0\n"
SHEET = SetUp(
    offsets={"G54": {"X": 100 * MM}, "G55": {"X": 200 * MM, "Y": 10 * MM}},
    tools={"1": Tool(50 * MM), "2": Tool(80 * MM)},
)


def ends(body: str, **options) -> list[float]:
    """The last place of a program [mm]."""
    return tips("linuxcnc", START + body + "\nM2", **options)[-1]


# --- offsets --------------------------------------------------------------------------------------------------------


def test_g54_is_in_force_from_the_beginning():
    assert ends("G1 X1", setup=SHEET) == [101, 0, 0]


def test_g10_sets_offsets_absolutely_under_g91_too():
    """ "G10 L2": offsets are set, whatever the distance mode."""
    assert ends("G91\nG10 L2 P1 X5\nG10 L2 P1 X7\nG90 G1 X1", setup=SHEET) == [8, 0, 0]


def test_g10_l2_turns_an_offset_about_its_own_origin():
    """ "G10 L2 R": rotation around the Z axis, of the axes of the coordinate system."""
    assert ends("G10 L2 P1 X5 R90\nG1 X1 Y0", setup=SHEET) == [5, 1, 0]


def test_g92_shifts_along_the_turned_axes():
    assert ends("G10 L2 P1 X0 Y0 R90\nG0 X0 Y0\nG92 X-2\nG1 X1 Y0", setup=SHEET) == [0, 3, 0]


def test_g10_l20_calls_the_place_in_an_offset_that_is_not_in_force():
    assert ends("G10 L20 P2 X3\nG55 G1 X4 Y0", setup=SHEET) == [101, 10, 0]


def test_g10_l20_moves_a_turned_offset_along_its_own_axes():
    assert ends("G10 L2 P1 X0 Y0 R90\nG0 X0 Y0\nG10 L20 P1 X-2\nG1 X1 Y0", setup=SHEET) == [0, 3, 0]


def test_g52_and_g92_are_one_shift():
    """ "G52": it shares its offset with G92, parameters 5211 to 5219."""
    assert ends("G52 X5\nG0 X0\nG92 X1\nG52 X7\nG1 X1", setup=SHEET) == [108, 0, 0]
    assert ends("G52 X5\nG92.1\nG1 X1", setup=SHEET) == [101, 0, 0]


def test_g92_3_restores_what_was_set_last():
    assert ends("G92 X1\nG92.2\nG92 X3\nG92.2\nG92.3\nG1 X4", setup=SHEET) == [101, 0, 0]


@pytest.mark.parametrize("block", ["G92", "G52", "G10 L20 P1 X1 R0", "G10 L2 P1.5 X1"])
def test_offsets_that_cannot_be_set(block):
    with pytest.raises(ProgramError, match=r"part\.nc:3"):
        read_for("linuxcnc", START + block + "\nG1 X1\nM2")


# --- tools ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("G43 H1", [101, 0, 51]), ("T2 M6\nG43", [101, 0, 81]), ("G43", [101, 0, 1]), ("G43 H2\nG43 H0", [101, 0, 1]),
        ("M61 Q2\nG43", [101, 0, 81]), ("G43.1 Z7", [101, 0, 8]), ("G43 H1\nG43.1 X2 Y3", [103, 3, 51]),
        ("G43 H1\nG43.2 H2", [101, 0, 131]), ("G43.1 Z7\nG43.2 H1\nG43.2 Z.5", [101, 0, 58.5]),
        ("G43.1 Z7\nG49", [101, 0, 1]), ("G43.1 Z7\nG43 H1", [101, 0, 51]), ("G20\nG43.1 Z1\nG21", [101, 0, 26.4]),
    ],
)  # fmt: skip
def test_tool_offsets(words, wanted):
    """ "G43", "G43.1", "G43.2", "G49", "M61"; without a machine places are those of the spindle nose."""
    assert ends(f"{words}\nG1 X1 Y0 Z1", setup=SHEET) == pytest.approx(wanted)


@pytest.mark.parametrize("block", ["G43.1 Z1", "G43.2 H1"])
def test_tool_offsets_in_numbers_need_the_tools_of_a_sheet(block):
    with pytest.raises(ProgramError, match="list the tools on the set-up sheet"):
        ends(f"{block}\nG1 X1")


@pytest.mark.parametrize(
    "block",
    [
        "M61",
        "M61 Q1.5",
        "G43.2",
        "G43.2 H9",
        "G91 G53 G0 X1",
        "G2 G53 X1 I3",
        "S-5",
        "T-1",
        "T1.5",
        "D3",
        "H1",
        "G10 L2 X1",
        "G4 X1",
        "o5 cal [1]",
        "o5 endsub",
        "o5 return",
        "o5 else",
        "o5 endif",
        "(abort, enough)",
    ],
)
def test_blocks_that_its_interpreter_refuses(block):
    with pytest.raises(ProgramError, match=r"part\.nc:3"):
        ends(f"{block}\nG1 X1", setup=SHEET)


# --- cycles ---------------------------------------------------------------------------------------------------------


def cycle(body: str) -> list[list[float]]:
    """X and Z of the places behind the first [mm]."""
    return [[x, z] for x, _, z in tips("linuxcnc", "G90 G21 G94 G17 F100\nG0 X0 Y0 Z10\n" + body + "\nM2")[1:]]


def test_cycles_go_back_to_r_until_g98_is_written():
    assert cycle("G81 X1 Z-3 R2") == [[1, 10], [1, 2], [1, -3], [1, 2]]


def test_under_g98_the_tool_arrives_over_the_next_hole_at_the_initial_level():
    assert cycle("G99 G81 X1 Z-3 R2\nG98 X2")[4:] == [[2, 10], [2, 2], [2, -3], [2, 10]]


def test_a_cycle_that_began_below_r_goes_to_r_first():
    assert cycle("G0 Z1\nG98 G81 X1 Z-3 R2\nX2 R3")[1:] == [
        [0, 2], [1, 2], [1, -3], [1, 2], [1, 3], [2, 3], [2, -3], [2, 3],
    ]  # fmt: skip


@pytest.mark.parametrize(("turn", "word"), [("M3", "G84"), ("M4", "G74"), ("M5", "G89")])
def test_taps_and_g89_feed_out_to_the_initial_level(turn, word):
    assert cycle(f"{turn}\nG98 {word} X1 Z-3 R2 P1") == [[1, 10], [1, 2], [1, -3], [1, 10]]


@pytest.mark.parametrize(
    "block",
    ["G81 X1 Z-3", "G81 X1 R2", "G82 X1 Z-3 R2", "G83 X1 Z-3 R2", "G81 X1 Z-3 R2\nG85 X2 Z-3", "G81 X1 Z-3 R2 L0",
     "G81 X1 Z-3 R2\nG81", "G81 X1 Z-3 R2 P1\nG82 X2 Z-3 R2"],
)  # fmt: skip
def test_each_cycle_names_all_its_words_and_an_axis(block):
    """ "All axes missing with motion code", "R clearance plane unspecified in cycle" and their like."""
    with pytest.raises(ProgramError, match=r"part\.nc:[34]"):
        ends(block)


# --- variables ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "name", "wanted"),
    [
        ("G18", "_plane", 180), ("G55", "_coord_system", 550), ("G59.3", "_coord_system", 593), ("", "_feed", 100),
        ("G20", "_feed", 100), ("S500 M3", "_rpm", 500), ("T7", "_selected_tool", 7), ("", "_motion_mode", 0),
        ("G80", "_motion_mode", 800), ("G95", "_units_per_rev", 1), ("G43 H1", "_tool_offset", 1), ("", "_line", 5),
        ("G90.1", "_ijk_absolute_mode", 1), ("", "_retract_r_plane", 1),
    ],
)  # fmt: skip
def test_named_variables_of_the_controller(words, name, wanted):
    """ "Predefined Named Parameters"."""
    assert ends(f"{words}\n\n#1=#<{name}>\nG21 G94 F100\nG1 X[#1] Y1")[0] == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("3 MOD -2", 1),
        ("-7 MOD 4", 1),
        ("1 EQ 1.00001", 1),
        ("1 NE 1.00001", 0),
        ("1 NE 1.0002", 1),
        ("1 GE 1.00001", 0),
    ],
)
def test_expressions_as_its_interpreter_reckons(text, wanted):
    """ "Binary Operators": numbers are equal that differ by less than 0.0001; MOD is never negative."""
    assert ends(f"G1 X[{text}] Y1")[0] == wanted


def test_a_subprogram_without_a_value_returns_zero():
    """ "#<_value>": zero where the last subprogram returned none."""
    body = "o1 sub\no1 endsub [5]\no2 sub\no2 endsub\no1 call\n#1=#<_value>\no2 call\nG1 X#1 Y[#<_value>]"
    assert ends(body) == [5, 0, 0]


def test_values_of_a_block_are_those_before_it_sets_variables():
    """ "Parameters": a setting does not take effect until after all parameter values of the line have been found."""
    assert ends("#1=3 #2=4\nG1 X#1 #1=[#2+1] Y#2 #2=#1\nG1 Z[#1*10+#2]") == [3, 4, 53]


def test_blanks_change_nothing():
    """ "Format of a Line": g0x +0. 12 34y 7 is g0 x+0.1234 y7."""
    assert ends("g0x +0. 12 34y 7") == [0.1234, 7, 0]


# --- saved modes ----------------------------------------------------------------------------------------------------


def test_m70_saves_modes_and_m72_restores_them():
    path = read_for("linuxcnc", START + "M70\nG91 G20 F5\nG55\nM72\nG1 X1\nX2\nM2", setup=SHEET)
    assert path.tip[-1].tolist() == pytest.approx([102 * MM, 0, 0])
    assert path.feed[-1] == pytest.approx(0.1 / 60)


def test_m73_restores_modes_on_return():
    body = "o1 sub\nM73\nG91 G20 G18\nG1 X1\no1 endsub\no1 call\nG1 X1\nG2 X3 I1"
    assert ends(body)[0] == 3
    with pytest.raises(ProgramError, match="off its circle"):
        ends(body.replace("M73\n", ""))


def test_m72_needs_modes_that_were_saved_at_its_level():
    for body in ("M72", "M70\nM71\nM72", "M70\no1 sub\nM72\no1 endsub\no1 call"):
        with pytest.raises(ProgramError, match="write M70 before it"):
            ends(body + "\nG1 X1")


def test_local_variables_begin_at_zero_in_the_main_program_too():
    """ "Subroutine Parameters"; others that nothing has set may be in the controller's file."""
    assert ends("G1 X#1 Y1") == [0, 1, 0]
    with pytest.raises(ProgramError, match="#31"):
        ends("G1 X#31 Y1")


def test_each_word_of_a_feed_mode_forgets_f():
    with pytest.raises(ProgramError, match="feed missing"):
        ends("G94\nG1 X1")
    assert ends("G94 F200\nG1 X1") == [1, 0, 0]


def test_g4_waits_before_the_motion_of_its_block():
    path = read_for("linuxcnc", START + "G1 X1\nG4 P2 X3\nM2")
    assert path.tip[:, 0].tolist() == pytest.approx([0, MM, 3 * MM]) and path.dwell.tolist() == [0, 2, 0]


def test_g87_bores_from_below():
    """ "G87": through the hole beside its axis, up to K at feed and down again, out beside the axis."""
    assert cycle("M3\nG99 G87 X5 Z-4 R2 I1 J0 K-1") == [
        [5, 10], [5, 2], [6, 2], [6, -4], [5, -4], [5, -1], [5, -4], [6, -4], [6, 2], [5, 2],
    ]  # fmt: skip

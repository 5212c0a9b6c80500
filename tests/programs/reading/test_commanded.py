"""What a control sees of a program: its moves, how they meet, where it waits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace import Machine
from toolpace.common.errors import ProgramError, UsageError
from toolpace.programs.commanded import BLENDED, EXACT_PATH, EXACT_STOP, Commanded
from toolpace.programs.reading import Controller, ReadOptions, SetUp, Source, read_commanded, read_source

MACHINE = Machine.load("xyzac-trunnion")
HEAD = "G21 G90 G17 G94 M428\nG0 X0 Y0 Z10 A0 C0\n"


def commanded(body: str, head: str = HEAD) -> Commanded:
    return read_commanded(Source.from_text(f"{head}{body}M2\n", "part.ngc"), MACHINE)


def test_lines_have_their_length_and_direction() -> None:
    moves = commanded("G1 X3 Y4 F600\nG1 A30\nG1 X3 Y4 Z10\nG0 X0 Y0\n")
    assert moves.length == pytest.approx([0.0, 5e-3, 0.0, 5e-3])  # the repeated position is no move
    np.testing.assert_allclose(moves.begin[1], [0.6, 0.8, 0.0])
    np.testing.assert_allclose(moves.begin[2], 0.0)
    assert moves.way[2, 3 + moves.rotary_joints.index("A")] == pytest.approx(math.radians(30.0))
    assert moves.rapid.tolist() == [True, False, False, True]
    assert moves.speed[1:3] == pytest.approx([0.01, 0.01])
    assert moves.turn[2] == pytest.approx(math.radians(600.0) / 60.0)


def test_a_helix_tells_its_tangents_centre_and_length() -> None:
    moves = commanded("G1 X10 F600\nG3 X0 Y10 Z13 I-10 J0\nG2 X0 Y10 I0 J-10\n")
    length = math.hypot(0.01 * math.pi / 2, 0.003)
    assert moves.length[2] == pytest.approx(length)
    np.testing.assert_allclose(moves.begin[2], np.array([0.0, 0.01 * math.pi / 2, 0.003]) / length, atol=1e-12)
    np.testing.assert_allclose(moves.end[2], np.array([-0.01 * math.pi / 2, 0.0, 0.003]) / length, atol=1e-12)
    np.testing.assert_allclose(moves.centre[2], [0.0, 0.0, 0.01], atol=1e-12)
    np.testing.assert_allclose(moves.normal[2], [0.0, 0.0, 1.0])
    # a full circle ends where it begins, and is a move
    assert moves.sweep[2:] == pytest.approx([math.pi / 2, 2 * math.pi])
    np.testing.assert_allclose(moves.normal[3], [0.0, 0.0, -1.0])
    assert moves.radius[1:].tolist() == [math.inf, pytest.approx(0.01), pytest.approx(0.01)]


def test_how_moves_meet_is_what_is_in_force_where_they_stand() -> None:
    moves = commanded(
        "G64 P0.05 Q0.01\nG1 X1 F600\nG61\nG1 X2\nG61.1\nG1 X3\nG64\nG1 X4\nM70\nG64 P0.2\nG1 X5\nM72\nG1 X6\n"
    )
    assert moves.joining[1:].tolist() == [BLENDED, EXACT_PATH, EXACT_STOP, BLENDED, BLENDED, BLENDED]
    assert moves.tolerance[1:] == pytest.approx([5e-5, math.inf, math.inf, math.inf, 2e-4, math.inf])
    assert moves.cam_tolerance[1] == pytest.approx(1e-5)
    assert np.isnan(moves.cam_tolerance[2:]).all()
    # before the first word the control's own tolerance is in force, which is not that of G64
    assert commanded("G1 X1 F600\nG64\nG1 X2\n").tolerance[1:] == pytest.approx([math.nan, math.inf], nan_ok=True)
    # in the mode of exact stops the control rests by that mode, not by a word
    assert not moves.stop[1:-1].any()


def test_the_control_waits_where_it_switches_something() -> None:
    moves = commanded("G1 X1 F600\nM8\nG1 X2\nS900 G1 X3\nG4 P0.5\nG1 X4\nG1 X5 M3\nT2 M6\nG43 H2\nG1 X6\n")
    assert moves.stop[1:-1].tolist() == [True, True, True, True, True]
    assert moves.dwell[3] == pytest.approx(0.5)
    assert [moves.operations[k].tool for k in moves.operation] == ["", "", "", "", "", "", "2"]
    path = read_source(Source.from_text(f"{HEAD}G1 X1 F600\nS900\nG1 X2\nM2\n", "part.ngc"), MACHINE)
    assert path.stop.tolist() == [True, False, True]  # the motion itself needs no rest for a speed of the spindle


def test_splines_are_straight_pieces_and_share_the_time_of_their_block() -> None:
    moves = commanded("G93\nG5 X10 Y0 I3 J10 P-3 Q10 F2\n")
    assert len(moves) > 20
    assert moves.time.sum() == pytest.approx(30.0)
    assert moves.length.sum() == pytest.approx(np.linalg.norm(np.diff(moves.words[:, :3], axis=0), axis=1).sum())
    assert set(moves.line[1:].tolist()) == {4}


def test_outside_tip_mode_words_are_joints_and_a_change_of_mode_waits() -> None:
    moves = commanded("G1 X10 F600\nG1 A10\nM429\nG1 X20\n")
    assert moves.tip_mode.tolist() == [True, True, True, False]
    assert moves.stop[2]


def test_a_program_without_motion_is_refused() -> None:
    with pytest.raises(ProgramError, match="there is no motion in the program"):
        commanded("")


def test_cutter_location_data_are_for_no_control() -> None:
    with pytest.raises(UsageError, match="for no control"):
        read_commanded(Source.from_text("FEDRAT/100\nGOTO/0,0,0\nGOTO/1,0,0\nFINI\n", "part.cls"), MACHINE)


def test_where_the_machine_stands_is_on_the_sheet_and_the_first_percent_opens_the_program() -> None:
    """The place where it stands is a row before the first block: it is not what the program moved."""
    options = ReadOptions(setup=SetUp(start=dict.fromkeys("XYZAC", 0.0), machine_zero=dict.fromkeys("XYZAC", 0.0)))
    source = Source.from_text("%\nG21 G90 G94\nG1 X10 F600\nG1 X20\nM30\n%\nG1 X99\n", "part.ngc")
    moves = read_commanded(source, MACHINE, None, options)
    assert moves.words[:, 0] == pytest.approx([0.0, 0.01, 0.02])


@pytest.mark.parametrize(("controller", "within"), [("linuxcnc", EXACT_PATH), ("fanuc", BLENDED)])
def test_how_the_moves_of_a_cycle_meet(controller: str, within: int) -> None:
    """LinuxCNC's interpreter has canned cycles on the exact path, whatever is in force; others go on as they did."""
    text = "G21 G90 G94 G17 F100\nG64\nG0 X0 Y0 Z5\nG99 G81 X1 Z-1 R2\nX2\nG80\nG0 X9\nG1 X10\nM2\n"
    told = ReadOptions(controller=Controller.load(controller))
    moves = read_commanded(Source.from_text(text, "part.ngc"), options=told)
    of_cycle = (moves.line == 4) | (moves.line == 5)
    assert of_cycle.any() and set(moves.joining[of_cycle].tolist()) == {within}
    assert moves.joining[-1] == BLENDED

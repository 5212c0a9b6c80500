"""G-code as a controller executes it: each test is one rule."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.toolpath import ToolPath

MM_MIN = 1e-3 / 60


def path(body: str, machine=MACHINE, **options) -> ToolPath:
    """Of pieces of programs, which have no end of their own."""
    return read_text(body + "\n", machine, "gcode", lenient=True, **options)


def tips(body: str, **options) -> list[list[float]]:
    """Tips in mm, rounded to a nanometre."""
    return np.round(path(body, None, **options).tip * 1e3, 6).tolist()


def test_starts_where_the_program_first_positions_every_axis():
    assert tips("G0 Z50\nG0 X1 Y2\nG1 Z0 F100") == [[1, 2, 50], [1, 2, 0]]


def test_keeps_every_motion_at_feed_after_the_first_position():
    assert tips("G0 X1\nG1 X2 F100\nG0 Z5") == [[1, 0, 0], [2, 0, 0], [2, 0, 5]]


def test_modal_words_without_spaces_in_any_case():
    assert tips("g0x0y0z0\nG1X1.Y-.5F100\nx+2.") == [[0, 0, 0], [1, -0.5, 0], [2, -0.5, 0]]


def test_numbers_comments_program_names_and_tape_marks():
    body = "%\nO1001 (PART; 7)\n(first) N10 G0 X0 Y0 Z0 ; to (the start\nN20 G1 X1 F100 (half) Y2\n%\nG1 X9"
    assert tips(body) == [[0, 0, 0], [1, 2, 0]]


def test_block_delete_is_an_option():
    body = "G0 X0 Y0 Z0\n/G1 X5 F100\n/2 N3 G1 X6 F100\nG1 X1 F100"
    assert tips(body) == [[0, 0, 0], [1, 0, 0]]
    assert tips(body, block_delete=False) == [[0, 0, 0], [5, 0, 0], [6, 0, 0], [1, 0, 0]]
    assert path(body).skipped["/"] == 2


def test_inch_and_incremental():
    assert tips("G20 G0 X1 Y0 Z0\nG91 G1 X1 F10\nG90 G21 X10") == [[25.4, 0, 0], [50.8, 0, 0], [10, 0, 0]]


def test_incremental_from_the_outset_starts_at_zero():
    assert tips("G91 G1 X1 F100\nX1") == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]


def test_feeds_per_minute_and_rapids():
    p = path("G0 X0 Y0 Z0\nG1 X1 F600\nX2\nG0 X3\nG1 X4\nG20 F10 X1")
    assert p.feed / MM_MIN == pytest.approx([np.inf, 600, 600, np.inf, 600, 254])
    assert not p.least_time.any()


def test_inverse_time_is_a_least_time():
    p = path("G93 G0 X0 Y0 Z0\nG1 X1 F2\nG1 X2 F120\nG0 X0\nG94 G1 X1 F60")
    assert p.least_time.tolist() == [0, 30, 0.5, 0, 0]
    assert np.isinf(p.feed[:-1]).all() and p.feed[-1] == pytest.approx(60 * MM_MIN)


def test_rotation_in_place_takes_degrees_per_minute():
    p = path("G43.4\nG0 X0 Y0 Z0\nG1 A30 F600")
    assert p.least_time.sum() == pytest.approx(3.0)
    assert np.isinf(p.feed).all()


def test_tip_mode_caps_the_tip_alone():
    p = path("G43.4\nG0 X0 Y0 Z0\nG1 X10 A30 F600")
    assert p.feed[1:] / MM_MIN == pytest.approx(600.0)
    assert not p.least_time.any()


def test_joint_mode_with_rotation_gives_a_time():
    p = path("G0 X0 Y0 Z0\nG1 X10 A30 F600\nX20")
    assert p.least_time.sum() == pytest.approx(1.0)
    assert np.isinf(p.feed[:-1]).all() and p.feed[-1] / MM_MIN == pytest.approx(600)


def test_g4_dwells_in_seconds_and_stops():
    p = path("G0 X0 Y0 Z0\nG1 X1 F100\nG4 P0.5\nG4 P1\nX2\nX3")
    assert p.dwell.tolist() == [0, 1.5, 0, 0]
    assert p.stop.tolist() == [True, True, False, True]


@pytest.mark.parametrize("words", ["M3 S100", "M5", "M8", "T1 M6", "M0", "M1", "M19", "M60", "G4 P0"])
def test_machine_functions_stop_the_motion(words):
    p = path(f"G0 X0 Y0 Z0\nG1 X1 F100\n{words}\nX2\nX3")
    assert p.stop.tolist() == [True, True, False, True]


def test_spindle_acts_before_the_motion_of_its_block_and_program_stop_after():
    assert path("G0 X0 Y0 Z0\nG1 X1 F9\nX2 M5\nX3").stop.tolist() == [True, True, False, True]
    assert path("G0 X0 Y0 Z0\nG1 X1 F9\nX2 M0\nX3").stop.tolist() == [True, False, True, True]


def test_exact_stop_modes():
    assert path("G0 X0 Y0 Z0\nG61 G1 X1 F9\nX2\nG64 P0.01 X3\nX4").stop.tolist() == [
        True,
        True,
        True,
        False,
        True,
    ]
    assert path("G0 X0 Y0 Z0\nG9 G1 X1 F9\nX2\nX3").stop.tolist() == [True, True, False, True]
    assert path("G0 X0 Y0 Z0\nG61.1 G1 X1 F9\nX2\nX3").stop.all()


@pytest.mark.parametrize("end", ["M2", "M30", "G1 X1 M30"])
def test_the_program_ends(end):
    assert path(f"G0 X0 Y0 Z0\nG1 X1 F9\n{end}\nX2\nG28 nonsense").tip[-1, 0] == pytest.approx(1e-3)


def test_counts_blocks_and_what_it_passes_over():
    p = path("G21 G54 G40\nT7\nS100 M62 P1\nG0 X0 Y0 Z0\n\n(c)\nG43 H3\nG1 X1 F9".replace(" P1", ""))
    assert p.blocks == 6
    assert p.skipped == {"G40": 1, "T": 1, "S": 1, "M62": 1, "G43": 1}
    assert p.block.tolist() == [4, 8]


def test_repeated_points_are_dropped_and_their_stop_stays():
    p = path("G0 X0 Y0 Z0\nG1 X1 F9\nG9 X1\nX2\nX3")
    assert len(p) == 4 and p.stop.tolist() == [True, True, False, True]


# --- arcs -------------------------------------------------------------------------------------------------------


def assert_arc(p: ToolPath, centre, radius, sweep, normal=(0, 0, 1)):
    """Points on the circle, all the way round in the right sense, chords within half a micrometre."""
    spoke = p.tip * 1e3 - np.array(centre)
    spoke -= np.outer(spoke @ normal, normal)
    assert np.linalg.norm(spoke, axis=1) == pytest.approx(radius, abs=1e-9)
    turn = np.arctan2(np.cross(spoke[:-1], spoke[1:]) @ normal, (spoke[:-1] * spoke[1:]).sum(axis=1))
    assert turn.sum() == pytest.approx(sweep, abs=1e-9)
    assert (radius * (1 - np.cos(turn / 2))).max() <= 0.5e-3


@pytest.mark.parametrize(
    ("body", "centre", "radius", "sweep", "normal"),
    [
        ("G0 X10 Y0 Z0\nG3 X0 Y10 I-10 J0 F100", (0, 0, 0), 10, math.pi / 2, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG2 X0 Y10 I-10 F100", (0, 0, 0), 10, -1.5 * math.pi, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG3 I-10 F100", (0, 0, 0), 10, 2 * math.pi, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG2 I-10 P3 F100", (0, 0, 0), 10, -6 * math.pi, (0, 0, 1)),
        ("G90.1 G0 X10 Y5 Z0\nG3 X-10 Y5 I0 J5 F100", (0, 5, 0), 10, math.pi, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG3 X0 Y10 R10 F100", (0, 0, 0), 10, math.pi / 2, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG3 X0 Y10 R-10 F100", (10, 10, 0), 10, 1.5 * math.pi, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG2 X0 Y10 R10 F100", (10, 10, 0), 10, -math.pi / 2, (0, 0, 1)),
        ("G0 X10 Y0 Z0\nG2 X0 Y10 R-10 F100", (0, 0, 0), 10, -1.5 * math.pi, (0, 0, 1)),
        ("G18 G0 X0 Y0 Z10\nG3 X10 Z0 K-10 F100", (0, 0, 0), 10, math.pi / 2, (0, 1, 0)),
        ("G18 G0 X0 Y0 Z10\nG2 X10 Z0 R10 F100", (10, 0, 10), 10, -math.pi / 2, (0, 1, 0)),
        ("G19 G0 X0 Y10 Z0\nG3 Y0 Z10 J-10 F100", (0, 0, 0), 10, math.pi / 2, (1, 0, 0)),
        ("G0 X10 Y0 Z0\nG3 X0 Y10 Z7 I-10 F100", (0, 0, 0), 10, math.pi / 2, (0, 0, 1)),
    ],
)
def test_arcs_in_every_plane_and_form(body, centre, radius, sweep, normal):
    assert_arc(path(body), centre, radius, sweep, np.array(normal, dtype=float))


def test_helix_rises_evenly():
    p = path("G0 X10 Y0 Z0\nG3 X0 Y10 Z7 I-10 P2 F100")
    angle = np.unwrap(np.arctan2(p.tip[:, 1], p.tip[:, 0]))
    assert angle[-1] == pytest.approx(2.5 * math.pi)
    assert p.tip[:, 2] == pytest.approx(7e-3 * angle / angle[-1], abs=1e-15)
    assert set(p.block[1:]) == {2} and not p.stop[1:-1].any()


def test_inverse_time_of_an_arc_is_shared_out():
    assert path("G93 G0 X10 Y0 Z0\nG3 I-10 F6").least_time.sum() == pytest.approx(10.0)


# --- five axes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("on", "off"), [("M428", "M429"), ("G43.4 H1", "G49"), ("G43.4 H1", "G43 H1")])
def test_tip_mode_reads_tips_and_joint_mode_joints(on, off):
    p = path(f"{on}\nG0 X1 Y2 Z3 A30 C40\nG1 X5 F100\n{off}\nG1 X0 Y0 Z10 F100")
    assert p.tip[0] * 1e3 == pytest.approx([1, 2, 3])
    a, c = np.radians([30, 40])
    assert p.axis[0] == pytest.approx([np.sin(c) * np.sin(a), np.cos(c) * np.sin(a), np.cos(a)])
    assert p.tip[-1] * 1e3 == pytest.approx(10 * p.axis[0])
    assert np.degrees(p.rotary) == pytest.approx(np.tile([30, 40], (len(p), 1)))
    assert p.rotary_joints == ("A", "C")


def test_switching_modes_moves_nothing():
    p = path("G0 X1 Y2 Z3 A30 C40\nG43.4\nG1 C41 F100\nG49\nG1 A31 F100")
    start, _ = MACHINE.forward(np.array([[1e-3, 2e-3, 3e-3, *np.radians([30, 40])]]))
    turned = p.block == 3
    assert p.tip[0] == pytest.approx(start[0], abs=1e-12)
    assert p.tip[turned] == pytest.approx(np.tile(start, (turned.sum(), 1)), abs=1e-12)
    assert np.linalg.norm(p.tip[-1]) == pytest.approx(np.linalg.norm(start))


def test_rotary_joints_unwind_and_are_zero_without_words():
    p = path("M428\nG0 X0 Y0 Z0 C350\nG1 X1 C370 F100\nX2 C-400")
    assert np.degrees(p.rotary[[0, -1], 1]) == pytest.approx([350, -400])
    assert np.abs(np.diff(p.rotary[:, 1])).max() < 0.1
    assert not path("G0 X0 Y0 Z0\nG1 X1 F100").rotary.any()


def test_without_a_machine_the_axis_is_z():
    p = path("G0 X0 Y0 Z0\nG1 X1 F100", None)
    assert p.axis.tolist() == [[0, 0, 1]] * 2 and p.rotary is None


@pytest.mark.parametrize("mode", ["M428", "M429"])
@pytest.mark.parametrize(
    "words", ["X40 A-40 C90", "X0 A-80 C400", "C720", "A-90", "X40 Y5 Z9 A-1 C3", "A40", "X20 A40.001"]
)
def test_points_are_so_close_that_chords_and_great_circles_stay_true(mode, words):
    """Judged at a hundred places a piece, by the machine's own kinematics."""
    p = path(f"{mode}\nG0 X10 Y20 Z50 A-40 C0\nG1 {words} F500")
    t = np.linspace(0, 1, 100)[:, None, None]
    rotary = p.rotary[:-1] + t * np.diff(p.rotary, axis=0)
    chord = p.tip[:-1] + t * np.diff(p.tip, axis=0)
    assert np.abs(np.diff(p.rotary, 2, axis=0)).max(initial=0) < 1e-9
    rotation = MACHINE.rotation(rotary[..., 0].ravel(), rotary[..., 1].ravel())
    angle = np.arccos(np.clip((p.axis[:-1] * p.axis[1:]).sum(axis=1), -1, 1))[:, None]
    sine = np.where(angle > 1e-9, np.sin(angle), 1.0)
    first = np.where(angle > 1e-9, np.sin((1 - t) * angle) / sine, 1 - t)
    second = np.where(angle > 1e-9, np.sin(t * angle) / sine, t)
    circle = first * p.axis[:-1] + second * p.axis[1:]
    assert np.linalg.norm(rotation[:, :, 2].reshape(circle.shape) - circle, axis=-1).max() <= 1e-4
    if mode == "M429":
        ends = {letter: float(word) for letter, word in ((w[0], w[1:]) for w in words.split())}
        start = np.array([10.0, 20, 50])
        end = np.array([ends.get(x, s) for x, s in zip("XYZ", start)])
        u = (np.arange(len(p) - 1) + t[..., 0]) / (len(p) - 1)
        joints = (start + u[..., None] * (end - start)).reshape(-1, 3) * 1e-3
        tip = np.einsum("nij,nj->ni", rotation, joints).reshape(chord.shape)
        assert np.linalg.norm(tip - chord, axis=-1).max() <= 0.5e-6


# --- what is refused ----------------------------------------------------------------------------------------------

START = "G0 X0 Y0 Z0\n"


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("G1 Xnan F100", "'XNAN' is no letter with a number"),
        ("G1 X F100", "letter X has no number"),
        ("G1 X1e5 F100", "without exponent"),
        ("G1 X1 F0", "no F above zero"),
        ("G1 X1 F-5", "feed F-5 must be above zero"),
        ("G1 X1", "feed missing"),
        ("G93 G1 X1", "under G93 every G1"),
        ("G1 X1 X2 F1", "word X stands twice"),
        ("G1 G2 X1 F1", "exclude each other"),
        ("G1 X2000000 F1", "is beyond 1e+06"),
        ("G1 X1 B5 F1", "no axis B, its joints are X, Y, Z, A, C"),
        ("G1 X1 L5 F1", "L has no use in this block"),
        ("G1 X1 I5 F1", "I has no use in this block"),
        ("G80\nX1", "axis words without a motion"),
        ("G41 D1", "cutter compensation"),
        ("G5 X1", "write P and Q"),
        ("G33 Z1 K1", "spindle-synchronised"),
        ("G68 R30", "rotated coordinates"),
        ("G70", "write G20"),
        ("G123", "might move something"),
        ("G1.05 X1", "might move something"),
        ("G9999999999 X1", "might move something"),
        ("M123", "might move something"),
        ("M3.5", "M has no whole number"),
        ("G1 X#100 F100", "#100 is not read: set it before"),
        ("o100 sub", "lacks its beginning or its end"),
        ("o<name> call", "is not in this file, nor in a file beside it"),
        ("G1 X1 @ F1", "'@' has no meaning"),
        ("G1 1.5", "has no letter"),
        ("G1 X1 (open", "bracket has no partner"),
        ("G1 X1) F1", "bracket has no partner"),
        ("G4", "P in seconds"),
        ("G4 K1", "P in seconds"),
        ("G4 P-1", "not between 0 and a day"),
        ("P5", "P has no use"),
        ("G2 X1 F100", "lacks its centre: write I and J"),
        ("G90.1 G2 X1 I1 F100", "lacks J"),
        ("G2 X10 I1 F100", "mm off its circle"),
        ("G2 X10 R1 F100", "is too small"),
        ("G2 R1 F100", "full circle cannot be written with R"),
        ("G2 X1 R1 I1 F100", "not both"),
        ("G2 X1 I0.5 K1 F100", "in the plane of G17"),
        ("G2 X1 I0.5 P1.5 F100", "counts its turns"),
        ("G2 X0 I0 J0 F100", "no radius"),
    ],
)
def test_refuses_with_line_text_and_cure(line, says):
    with pytest.raises(ProgramError) as caught:
        read_text(START + line + "\nG1 X3 Y3 F100\n", MACHINE, "gcode", name="part.ngc", lenient=True)
    message = str(caught.value)
    number = 3 if "\n" in line else 2
    assert says in message and "\n" not in message
    assert message.startswith(f"part.ngc:{number}: ") and line.split("\n")[-1][:20] in message


def test_a_block_that_asks_for_points_without_end_is_refused(monkeypatch):
    monkeypatch.setattr("toolpace.programs.reading.control.unroll.MOST_PIECES_OF_BLOCK", 100_000)
    with pytest.raises(ProgramError, match=r":2: .*check its numbers"):
        path(START + "G1 C900000 F100")


def test_first_motion_an_arc_is_refused():
    with pytest.raises(ProgramError, match="start is not known"):
        path("G2 X1 I0.5 F100")


def test_rotary_words_need_a_machine():
    with pytest.raises(ProgramError, match=r":2: rotary word A needs the machine: give --machine"):
        path("G0 X0 Y0 Z0\nG1 X1 A5 F100", None)


@pytest.mark.parametrize("body", ["G21\n", "G0 X1 Y1 Z1\n", "M30\n", "G0 X1\nG1 X1 F5\n"])
def test_no_motion_is_an_error(body):
    with pytest.raises(ProgramError, match="no motion in the program"):
        path(body)


@pytest.mark.parametrize(
    "text",
    ["%\nG0 X0 Y0 Z0\nG1 X1 F100\n", "G0 X0 Y0 Z0\nG1 X1 F100\nG1 X", "G0 X0 Y0 Z0\nG1 X1 F100\nG1 X2."],
)
def test_cut_off_programs(text):
    with pytest.raises(ProgramError, match="cut off"):
        read_text(text, MACHINE, "gcode")


def test_a_program_that_ends_properly_needs_no_last_line_end():
    assert len(read_text("G0 X0 Y0 Z0\nG1 X1 F100\nM30", MACHINE, "gcode")) == 2

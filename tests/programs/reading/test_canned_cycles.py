"""Canned cycles, written out by hand: each test cites where the motion stands."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for, tips, with_options
from toolpace.common.errors import ProgramError

START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z10\n"
CONTROLLERS = ("linuxcnc", "fanuc", "haas", "iso")


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_g81_goes_over_the_hole_to_r_to_z_and_out(controller):
    """LinuxCNC, G Codes, "G81 Drilling Cycle": over the hole, to R at rapid, to Z at feed, out at rapid."""
    path = read_for(controller, START + "G98 G81 X5 Y6 Z-3 R2\nX7\nG80\nM30")
    assert (np.round(path.tip * 1e3, 9) + 0.0).tolist() == [
        [0, 0, 10], [5, 6, 10], [5, 6, 2], [5, 6, -3], [5, 6, 10], [7, 6, 10], [7, 6, 2], [7, 6, -3], [7, 6, 10],
    ]  # fmt: skip
    assert path.rapid.tolist()[1:] == [True, True, False, True] * 2


@pytest.mark.parametrize("controller", ["fanuc", "haas", "iso"])  # LinuxCNC's interpreter: test_linuxcnc.py
def test_g99_goes_back_to_r_and_g98_to_the_level_where_the_cycle_began(controller):
    """Fanuc 0i operator's manual, 13.1 "Return to point R level". The initial level stays, also behind G99."""
    got = tips(controller, START + "G99 G81 X1 Y0 Z-3 R2\nX2\nG98 X3\nG80\nM30")
    assert got == [
        [0, 0, 10], [1, 0, 10], [1, 0, 2], [1, 0, -3], [1, 0, 2], [2, 0, 2], [2, 0, -3], [2, 0, 2],
        [3, 0, 2], [3, 0, -3], [3, 0, 10],
    ]  # fmt: skip


@pytest.mark.parametrize(("controller", "letter"), [("linuxcnc", "L"), ("fanuc", "K"), ("haas", "L")])
def test_repeats_under_g91_go_on_by_the_distance(controller, letter):
    """LinuxCNC, G81 example 2: under G91 R counts from the level before, Z from R, and L holes go on by X."""
    got = tips(controller, START + f"G91 G99 G81 X4 Z-5 R-8 {letter}2\nG80\nM30")
    assert got == [
        [0, 0, 10], [4, 0, 10], [4, 0, 2], [4, 0, -3], [4, 0, 2], [8, 0, 2], [8, 0, -3], [8, 0, 2],
    ]  # fmt: skip


@pytest.mark.parametrize(("controller", "letter"), [("fanuc", "K"), ("haas", "L"), ("iso", "L")])
def test_g91_behind_a_cycle_places_holes_and_leaves_their_depths(controller, letter):
    """Haas mill operator's manual, "Looping canned cycles": G81 Z-1.5 R.1, then G91 X1. L9 drills nine more holes as
    deep; Fanuc 0i, 13.1: drilling data are kept as they were specified."""
    got = tips(controller, START + f"G99 G81 Z-3 R2\nG91 X4 {letter}2\nG90 G80\nM30")
    assert got == [
        [0, 0, 10], [0, 0, 2], [0, 0, -3], [0, 0, 2], [4, 0, 2], [4, 0, -3], [4, 0, 2],
        [8, 0, 2], [8, 0, -3], [8, 0, 2],
    ]  # fmt: skip


@pytest.mark.parametrize("controller", ["fanuc", "haas", "iso"])
def test_r_alone_drills_no_hole_and_holds_for_the_next(controller):
    """Haas mill operator's manual, "Canned cycles": each X or Y drills; R stays until it is replaced. It is said."""
    body = START + "G98 G81 X1 Y0 Z-3 R2\nR4\nX2\nG80\nM30"
    assert tips(controller, body) == [
        [0, 0, 10], [1, 0, 10], [1, 0, 2], [1, 0, -3], [1, 0, 10], [2, 0, 10], [2, 0, 4], [2, 0, -3], [2, 0, 10],
    ]  # fmt: skip
    assert any("R in a block without an axis" in said for said in read_for(controller, body).assumed)


@pytest.mark.parametrize("word", ["R3", "Q1"])
def test_linuxcnc_refuses_words_of_a_cycle_without_an_axis(word):
    """Its interpreter: "R word with no g code that uses it"; see test_against_rs274."""
    with pytest.raises(ProgramError, match=f"{word[0]} has no use in this block"):
        read_for("linuxcnc", START + f"G98 G83 X1 Y0 Z-3 R2 Q2\n{word}\nX2\nG80\nM2")


def test_a_cycle_of_haas_without_r_feeds_from_where_it_began():
    """The manual marks R of G81 to G89 as optional."""
    path = read_for("haas", START + "G82 X1 Z-3 P500\nX2\nG80\nM30")
    assert tips("haas", START + "G81 X1 Z-3\nG80\nM30") == [[0, 0, 10], [1, 0, 10], [1, 0, -3], [1, 0, 10]]
    assert any("without R" in sentence for sentence in path.assumed)


def test_no_repeat_keeps_the_words_for_the_next_block():
    """Fanuc 0i, 13.1: K0 stores the drilling data and drills nothing."""
    got = tips("fanuc", START + "G99 G81 X4 Z-5. R2. K0\nX6\nG80\nM30")
    assert got == [[0, 0, 10], [6, 0, 10], [6, 0, 2], [6, 0, -5], [6, 0, 2]]


def test_g82_dwells_by_the_unit_of_the_controller():
    """Fanuc: P in milliseconds; Haas: with a point seconds; LinuxCNC: seconds."""
    for controller, word in (("fanuc", "P500"), ("haas", "P.5"), ("haas", "P500"), ("linuxcnc", "P.5")):
        path = read_for(controller, START + f"G82 X1 Z-3 R2 {word}\nG80\nM30")
        assert path.dwell.sum() == pytest.approx(0.5), (controller, word)
        assert path.tip[np.argmax(path.dwell), 2] == pytest.approx(-3e-3)


def test_g83_goes_out_after_each_peck_and_back_to_a_little_above():
    """LinuxCNC, "G83 Peck Drilling Cycle": back down to 0.254 mm above the last depth."""
    z = [row[2] for row in tips("linuxcnc", START + "G99 G83 X0 Z-3 R1 Q2\nG80\nM2")]
    assert z == [10, 1, -1, 1, -0.746, -3, 1]


def test_g73_breaks_the_chip_and_stays_in_the_hole():
    """Fanuc 0i, 13.1.1 "High-speed peck drilling cycle": back by d of parameter 5114."""
    by = with_options("fanuc", chip_break_mm=0.5)
    z = [row[2] for row in tips(by, START + "G99 G73 X0 Z-3. R1. Q2.\nG80\nM30")]
    assert z == [10, 1, -1, -0.5, -3, 1]


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_peck_of_zero_is_no_peck(controller):
    """Posts write `Q0.`: the hole is drilled in one."""
    got = tips(controller, START + "G99 G83 X0 Z-3. R1. Q0.0\nG80\nM30")
    assert [row[2] for row in got] == [10, 1, -3, 1]


@pytest.mark.parametrize(
    ("code", "stops", "out_at_feed"),
    [("G84", True, True), ("G74", True, True), ("G85", False, True), ("G86", True, False), ("G89", False, True),
     ("G76", True, False)],
)  # fmt: skip
def test_taps_and_bores_differ_at_the_bottom_and_on_the_way_out(code, stops, out_at_feed):
    """Fanuc 0i, 13.1.3 to 13.1.12: tapping reverses and goes out at feed, G86 and G76 stop and go out at rapid."""
    path = read_for("fanuc", START + f"G99 {code} X1. Z-3. R2.\nG80\nM30")
    bottom = int(np.argmin(path.tip[:, 2]))
    assert bool(path.stop[bottom]) is stops and bool(path.rapid[bottom + 1]) is not out_at_feed


def test_a_back_bore_goes_below_and_feeds_up():
    """Fanuc 0i, 13.1.10 "Back boring cycle": rapid to R below the part, feed up to Z, out to the initial level."""
    got = tips("fanuc", START + "G98 G87 X5. Z-2. R-8.\nG80\nM30")
    assert got == [[0, 0, 10], [5, 0, 10], [5, 0, -8], [5, 0, -2], [5, 0, 10]]


Q_ALONG = {"first": (0.5, 0), "first negative": (-0.5, 0), "second": (0, 0.5), "second negative": (0, -0.5)}


@pytest.mark.parametrize("direction", Q_ALONG)
def test_a_fine_bore_goes_out_beside_the_axis_of_the_hole(direction):
    """Fanuc 0i, 13.1.4 "Fine boring cycle": stop at the bottom, aside by Q, out, back to the axis; the direction is
    that of parameters 5101#4 and #5, and said."""
    path = read_for(with_options("fanuc", boring_shift=direction), START + "G99 G76 X5. Y6. Z-3. R2. Q0.5\nG80\nM30")
    x, y = Q_ALONG[direction]
    assert (np.round(path.tip * 1e3, 6) + 0.0).tolist() == [
        [0, 0, 10], [5, 6, 10], [5, 6, 2], [5, 6, -3], [5 + x, 6 + y, -3], [5 + x, 6 + y, 2], [5, 6, 2],
    ]  # fmt: skip
    assert path.rapid.tolist() == [True, True, True, False, True, True, True] and path.stop[3]
    assert any("Q shifts a boring tool along" in said for said in path.assumed)


@pytest.mark.parametrize(("controller", "words", "x", "y"), [
    ("fanuc", "G87 Q0.5", 0.5, 0.0), ("haas", "G77 Q0.5", 0.5, 0.0), ("haas", "G77 I-0.3 J0.4", -0.3, 0.4),
])  # fmt: skip
def test_a_back_bore_goes_in_and_out_beside_the_axis_of_the_hole(controller, words, x, y):
    """Fanuc 0i, 13.1.10 "Back boring cycle": aside, down to R, to the axis, up to Z, aside, out, to the axis. Haas NGC,
    G77: Q, or where it is not told I and J."""
    path = read_for(controller, START + f"G98 {words} X5. Y0. Z-2. R-8.\nG80\nM30")
    assert (np.round(path.tip * 1e3, 6) + 0.0).tolist() == [
        [0, 0, 10], [5, 0, 10], [5 + x, y, 10], [5 + x, y, -8], [5, 0, -8], [5, 0, -2], [5 + x, y, -2], [5 + x, y, 10],
        [5, 0, 10],
    ]  # fmt: skip
    assert np.flatnonzero(~path.rapid).tolist() == [5]


def test_the_shift_of_a_bore_in_turned_coordinates_is_refused():
    """The spindle is oriented in the machine, and no manual at hand says whether the shift is turned."""
    with pytest.raises(ProgramError, match="the shift of an oriented tool in turned, scaled or mirrored"):
        tips("fanuc", START + "G68 X0 Y0 R30.\nG76 X5. Y0 Z-3. R2. Q0.5\nG80\nM30")
    with pytest.raises(ProgramError, match="Q is the shift of a boring tool and has no sign"):
        tips("haas", START + "G76 X5. Y0 Z-3. R2. Q-0.5\nG80\nM30")


def test_a_back_bore_of_another_plane_begins_over_its_hole():
    """G18 bores along Y: Z goes to the hole with X."""
    got = tips("fanuc", START + "G0 Y9.\nG18 G87 X5. Z4. Y-2. R-8.\nG80\nM30")
    assert got[2:] == [[5, 9, 4], [5, -8, 4], [5, -2, 4], [5, 9, 4]]


def test_a_tap_with_pecks_breaks_chips_at_feed():
    """Fanuc 0i, "Peck rigid tapping cycle": by Q, and back by parameter 5213 at feed where parameter 5200#5 is 0."""
    path = read_for(with_options("fanuc", chip_break_mm=0.5), START + "G99 G84 X0 Z-5. R1. Q2. F500\nG80\nM30")
    assert [round(z, 6) for z in path.tip[1:, 2] * 1e3] == [1, -1, -0.5, -3, -2.5, -5, 1]
    assert not path.rapid[2:].any() and any("a tap with Q" in said for said in path.assumed)


def test_the_other_letter_of_repeats_is_said_or_refused():
    """Where holes go on by a distance, K and L are other places."""
    assert any("L of a cycle counts holes" in said for said in
               read_for("fanuc", START + "G91 G81 X4. Z-5. R-8. L2\nG80\nM30").assumed)  # fmt: skip
    with pytest.raises(ProgramError, match="K2 of a cycle is not read"):
        tips("mazak", START + "G91 G81 X4. Z-5. R-8. K2\nG80\nM30")


@pytest.mark.parametrize("controller", ["fanuc", "haas", "mazak", "iso"])
def test_a_unit_within_a_cycle_is_refused(controller):
    """Its words would count in another unit than they were written in."""
    with pytest.raises(ProgramError, match="a change of the unit within a cycle"):
        tips(controller, START + "G81 X4. Z-5. R2.\nG20 X1.\nG80\nM30")


@pytest.mark.parametrize("words", ["I-10. J30. K15.", "I10. J30. K-15."])
def test_holes_on_an_arc_go_clockwise_where_radius_or_step_is_below_zero(words):
    """Haas 96-8000, G71: I is the radius, "+CCW/-CW", and J its first angle."""
    got = tips("haas", START + f"G99 G81 Z-1. R2. L0\nG71 {words} L3\nG80\nM30")
    holes = np.array([row[:2] for row in got if row[2] == -1])
    angles = np.radians([30.0, 15.0, 0.0])
    assert holes == pytest.approx(10.0 * np.stack([np.cos(angles), np.sin(angles)], axis=1), abs=1e-6)


def test_the_drill_axis_is_the_normal_of_the_plane():
    """LinuxCNC, "Canned Cycles", in-plane words: under G18 the cycle drills along Y."""
    got = tips("linuxcnc", "G90 G21 G94 F100\nG0 X0 Y10 Z0\nG18 G99 G81 X3 Z4 Y-1 R2\nG80\nM2")
    assert got == [[0, 10, 0], [3, 10, 4], [3, 2, 4], [3, -1, 4], [3, 2, 4]]


def test_a_word_of_motion_ends_a_cycle():
    """Fanuc 0i, 13.1.14: a code of group 01 cancels the canned cycle."""
    got = tips("fanuc", START + "G99 G81 X1. Z-3. R2.\nG0 X5.\nM30")
    assert got[-1] == [5, 0, 2]


def test_behind_g80_fanuc_keeps_its_motion_and_linuxcnc_has_none():
    """Fanuc: cycles are group 09, G0 and G1 are group 01. LinuxCNC, G80: "cancel canned cycle modal motion"."""
    body = START + "G99 G81 X1. Z-3. R2.\nG80\nX5.\nM30"
    assert tips("fanuc", body)[-1] == [5, 0, 2]
    with pytest.raises(ProgramError, match="axis words without a motion"):
        tips("linuxcnc", body)


@pytest.mark.parametrize(
    ("block", "says"),
    [
        ("G81 X1 Z-3", "lacks R"), ("G81 X1 R2", "lacks Z"), ("G81 X1 Z3 R2", "depth Z is above R"),
        ("G83 X1 Z-3 R2 Q-1", "Q is the depth of a peck"), ("G81 X1 Z-3 R2 K1.5", "counts holes"),
        ("G93\nG81 X1 Z-3 R2 F5", "feeds per minute"), ("G83 X1 Z-30 R2 Q.0001", "10000 strokes"),
    ],
)  # fmt: skip
def test_cycles_that_cannot_be_are_refused(block, says):
    with pytest.raises(ProgramError, match=says):
        read_for("fanuc", START + block + "\nM30")


def test_more_strokes_than_memory_holds_are_refused():
    with pytest.raises(ProgramError, match="holes make more than 4000000 motions up to here: check their pecks"):
        read_for("fanuc", START + "G91 G83 X1. Z-9. R-1. Q.001 K400\nM30")


def test_holes_that_are_alike_share_their_strokes_and_keep_what_is_their_own():
    """Line, operation, stop and dwell of each hole, a hole of another depth between, in a turned frame."""
    text = (
        "G68 X0 Y0 R90.\nG98 G82 X1. Z-3. R2. P500 F60.\nX2.\nX3. Z-4. P0\nT2 M6\nX4. Z-3. F120.\nG80\nM0\nG0 X0\nM30"
    )
    path = read_for("fanuc", START + text)
    holes = np.round(path.tip[1:17] * 1e3, 9).reshape(4, 4, 3)
    np.testing.assert_allclose(holes[:, :, 1], [[y] * 4 for y in (1, 2, 3, 4)], atol=1e-12)
    np.testing.assert_allclose(holes[:, :, 2], [[10, 2, z, 10] for z in (-3, -3, -4, -3)], atol=1e-12)
    assert path.dwell[1:17].reshape(4, 4)[:, 2].tolist() == [0.5, 0.5, 0.0, 0.0]
    assert path.block[1:17].reshape(4, 4)[:, 0].tolist() == [4, 5, 6, 8]
    np.testing.assert_allclose(path.feed[1:17].reshape(4, 4)[:, 2], [0.001, 0.001, 0.001, 0.002])
    assert np.isinf(path.feed[1:17].reshape(4, 4)[:, [0, 1, 3]]).all()
    assert path.operation[1:17].reshape(4, 4)[:, 0].tolist() == [0, 0, 0, 1] and path.stop[16]


def test_a_cycle_of_millplus_is_defined_and_then_run_from_a_surface():
    """Autodesk's post-processor for MillPlus: G81 Y clearance Z depth B more to go back; G79 X Y Z of the surface."""
    start = "G71 G90 G94 F100\nG0 X0 Y0 Z20\n"
    got = tips("millplus", start + "G81 Y2. Z-5. B3. F50.\nG79 X4. Y0. Z10.\nG79 X6.\nM30")
    assert got == [
        [0, 0, 20], [4, 0, 20], [4, 0, 12], [4, 0, 5], [4, 0, 15], [6, 0, 15], [6, 0, 12], [6, 0, 5], [6, 0, 15],
    ]  # fmt: skip


def test_i_j_k_of_pecks_are_what_each_control_says():
    """Haas: the first peck, by how much each is shorter, the least. Posts for Mazak: K is a clearance. Fanuc: none."""
    body = START + "G99 G83 X0 Z-9. R1. {}\nG80\nM30"
    haas = [row[2] for row in tips("haas", body.format("I4. J1. K2."))]
    assert haas == [10, 1, -3, 1, -1.73, -6, 1, -4.73, -8, 1, -6.73, -9, 1]
    mazak = read_for("mazak", body.format("Q5. K.5"))
    assert [round(z, 6) for z in mazak.tip[1:, 2] * 1e3] == [1, -4, 1, -3.5, -9, 1]
    assert any("K of pecks" in said for said in mazak.assumed)
    with pytest.raises(ProgramError, match="I, J, K of pecks is not read"):
        tips("fanuc", body.format("Q3. I1. J1."))


def test_haas_scales_by_one_factor():
    with pytest.raises(ProgramError, match="G51 with I, J, K is not read"):
        tips("haas", START + "G51 X0 Y0 I2. J3.\nG1 X1.\nM30")

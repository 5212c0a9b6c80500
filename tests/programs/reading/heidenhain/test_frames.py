"""Frames: TNC 640 manual "Cycle programming", coordinate transformations."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import with_options
from tests.support.heidenhain import MACHINE, SetUp, findings, last, read, tips
from toolpace.common.units import DEGREE

SHIFT = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Y-5\n"


def test_a_datum_shift_is_from_the_preset_and_replaces_the_axes_it_names():
    assert last(SHIFT + "L X+1 Y+1 F100") == (11, -4, 0)
    assert last(SHIFT + "CYCL DEF 7.0\nCYCL DEF 7.1 X+20\nL X+1 Y+1 F100") == (21, -4, 0)
    assert last(SHIFT + "CYCL DEF 7.0\nCYCL DEF 7.1 IX+20\nL X+1 Y+1 F100") == (31, -4, 0)
    assert last(SHIFT + "CYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+1 Y+1 F100") == (1, 1, 0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("TRANS DATUM AXIS X+10 Y-5", (11, -4, 0)),
        ("TRANS DATUM AXIS X+10\nTRANS DATUM RESET", (1, 1, 0)),
        ("TRANS MIRROR AXIS X", (-1, 1, 0)),
        ("TRANS ROTATION ROT+90", (-1, 1, 0)),
        ("TRANS SCALE SCL 2", (2, 2, 0)),
        ("TRANS SCALE SCL 2\nTRANS SCALE RESET", (1, 1, 0)),
    ],
)
def test_trans(text, expected):
    assert last(f"{text}\nL X+1 Y+1 F100") == expected


def test_the_tool_stays_where_it_is_when_the_datum_is_shifted():
    assert last("L X+3 Y+3 F100\n" + SHIFT + "L Y+0") == (3, -5, 0)


def test_rotary_axes_are_shifted_too():
    path = read("CYCL DEF 7.0\nCYCL DEF 7.1 C+15\nL C+30 FMAX", MACHINE)
    assert path.rotary[-1, 1] == pytest.approx(45 * DEGREE)


def test_a_mirror_turns_the_sense_of_arcs():
    arc = tips("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X\nL X+10 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+")
    assert arc[-1] == pytest.approx((0, 10, 0)) and arc[:, 0].max() < 1e-9
    assert np.abs(np.hypot(arc[:, 0], arc[:, 1]) - 10).max() < 1e-6
    assert last("CYCL DEF 8.0\nCYCL DEF 8.1 X Y\nCYCL DEF 8.0\nCYCL DEF 8.1\nL X+1 Y+1 F100") == (1, 1, 0)


def test_a_mirror_of_a_rotary_axis_turns_its_words():
    """Cycle 8: "you can mirror all axes, including rotary axes"; about the active datum, until the next mirror."""
    text = "L C+10 A+5 FMAX\nCYCL DEF 8.0\nCYCL DEF 8.1 X C\nL X+1 C+30 FMAX\nL IC+5 A+7 FMAX\n"
    path = read(text + "L A+8 C+1 FMAX M91\nL C+2 FMAX\nCYCL DEF 8.0\nCYCL DEF 8.1\nL C+2 FMAX", MACHINE)
    last_of_block = np.append(np.diff(path.block) > 0, True)
    angles = np.round(path.rotary[last_of_block] / DEGREE, 9)
    assert angles[1:].tolist() == [[5, 10], [5, -30], [7, -35], [8, 1], [8, -2], [8, 2]]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("CYCL DEF 7.0\nCYCL DEF 7.1 C+5\nCYCL DEF 8.0\nCYCL DEF 8.1 C", "a mirror of a rotary axis in a tilted plane"),
        ("CYCL DEF 8.0\nCYCL DEF 8.1 C\nCYCL DEF 7.0\nCYCL DEF 7.1 C+5", "a shift of a mirrored rotary axis"),
        ("CYCL DEF 8.0\nCYCL DEF 8.1 C\nL C+5 FMAX M94", "M94 of mirrored axes"),
        ("CYCL DEF 8.0\nCYCL DEF 8.1 C\nFUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "AXIS SPAT over a mirror"),
    ],
)
def test_what_a_mirrored_rotary_axis_does_not_go_with(text, word):
    (refusal,) = findings(text + "\nL X+1 F100", MACHINE).refusals
    assert refusal.word.startswith(word)


def test_m128_with_a_preset_that_shifts_the_table_is_refused():
    """The parameter presetToAlignAxis tells what it means; a datum shift of C is a position of C."""
    setup = SetUp(offsets={"1": {"X": 0.0, "Y": 0.0, "Z": 0.0, "C": 0.1}, "2": {"X": 0.0, "Y": 0.0, "Z": 0.0}})
    text = "CYCL DEF 247 PRESET ~\n Q339=+{}\nL X+1 F100 M128\nL X+2"
    word = "M128 with a preset that shifts a rotary axis of the table"
    assert [each.word for each in findings(text.format(1), MACHINE, setup=setup).refusals] == [word]
    assert not findings(text.format(2), MACHINE, setup=setup).refusals
    shifted = "CYCL DEF 7.0\nCYCL DEF 7.1 C+90\nL C+0 FMAX\nM128\nL X+0 Y+1 Z+0 F100"
    path = read(shifted, MACHINE)
    assert np.allclose(path.tip[-1] * 1e3, (0, 1, 0)) and path.rotary[-1, 1] == pytest.approx(90 * DEGREE)


def test_rotation_is_about_the_datum_in_the_plane_of_the_tool():
    assert last(SHIFT + "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+90\nL X+1 Y+2 F100") == (8, -4, 0)
    assert last("CYCL DEF 10.0\nCYCL DEF 10.1 ROT+60\nCYCL DEF 10.1 IROT+30\nL X+1 Y+2 F100") == (-2, 1, 0)
    assert last("TOOL CALL 2 X\nCYCL DEF 10.0\nCYCL DEF 10.1 ROT+90\nL X+1 Y+2 F100") == (1, 0, 2)


def test_transformations_act_in_the_order_of_their_programming():
    turn, mirror = "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+90\n", "CYCL DEF 8.0\nCYCL DEF 8.1 X\n"
    assert last(turn + mirror + "L X+1 Y+2 F100") == (-2, -1, 0)
    assert last(mirror + turn + "L X+1 Y+2 F100") == (2, 1, 0)
    assert any("programmed before" in said for said in read(turn + mirror + "L X+1 F100").assumed)


def test_a_transformation_that_is_programmed_anew_keeps_its_place_and_that_is_said():
    turn = "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+90\n"
    again = "CYCL DEF 7.0\nCYCL DEF 7.1 X+20\n"
    path = read(SHIFT + turn + again + "L X+1 Y+2 F100")
    assert np.allclose(path.tip[-1] * 1e3, (18, -4, 0)) and any("keeps its place" in said for said in path.assumed)
    # a rotation that is changed while it is the last says nothing more
    turned = read(SHIFT + turn + "CYCL DEF 10.1 ROT+45\nL X+1 Y+2 F100")
    assert not any("keeps its place" in said for said in turned.assumed)


def test_scales():
    """Cycle 11, one factor; cycle 26, a factor for each axis about a centre. Arcs become larger with it."""
    assert last("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 0.5\nL X+1 Y+2 Z+4 F100") == (0.5, 1, 2)
    assert last("CYCL DEF 26.0\nCYCL DEF 26.1 X1.4 Y0.6 CCX+15 CCY+20\nL X+25 Y+30 F100") == (29, 26, 0)
    arc = tips("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 20\nL X+10 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+")
    middle = (arc[1:] + arc[:-1]) / 2
    assert np.abs(np.hypot(arc[:, 0], arc[:, 1]) - 200).max() < 1e-6
    assert np.abs(np.hypot(middle[:, 0], middle[:, 1]) - 200).max() < 0.5e-3


def test_the_axes_that_cycle_11_scales_are_a_parameter():
    """ "The scaling factor can be applied in the working plane, or on all three coordinate axes at the same time
    (depending on machine parameter 7410)" (TNC 410, "Scaling factor (cycle 11)")."""
    text = "CYCL DEF 11.0\nCYCL DEF 11.1 SCL 0.5\nL X+1 Y+2 Z+4 F100"
    assert any("X, Y and Z" in said for said in read(text).assumed)
    plane = with_options("heidenhain", cycle_11_axes="plane")
    assert last(text, controller=plane) == (0.5, 1, 4)
    assert last("TOOL CALL 2 X\n" + text, controller=plane) == (1, 1, 2)
    assert not any("CYCL DEF 11" in said for said in read(text.replace("0.5", "1")).assumed)


def test_cycle_26_names_each_axis_that_is_scaled():
    """Reset: "a scaling factor of 1 for the same axis"; what becomes of an axis that is left out is not said."""
    text = "CYCL DEF 26.0\nCYCL DEF 26.1 X2 Y3\nL X+1 Y+1 F100\nCYCL DEF 26.0\nCYCL DEF 26.1 {}\nL X+1 Y+1"
    (refusal,) = findings(text.format("X1")).refusals
    assert refusal.word == "CYCL DEF 26 without an axis that is scaled"
    assert last(text.format("X1 Y1")) == (1, 1, 0) and last(text.format("X1 Y3")) == (1, 3, 0)


def test_a_preset_is_an_offset_of_the_set_up_sheet_and_ends_shifts():
    """Cycle 247: activating a preset resets datum shift, mirror, rotation and scales."""
    setup = SetUp(offsets={"1": {"X": 0.0}, "2": {"X": 0.1, "Y": 0.2}})
    text = "CYCL DEF 247 DATUM SETTING ~\n Q339=+{} ;DATUM NUMBER\nL X+1 Y+1 Z+1 F100"
    near, far = (read(SHIFT + text.format(k), MACHINE, setup=setup).tip[-1] for k in (1, 2))
    machine_zero = read(text.format(1), MACHINE, setup=setup).tip[-1]
    assert np.allclose(far - near, (0.1, 0.2, 0)) and np.allclose(near, machine_zero)
    assert np.allclose(read("PRESET SELECT #2\nL X+1 Y+1 Z+1 F100", MACHINE, setup=setup).tip[-1], far)
    shift = "CYCL DEF 7.0\nCYCL DEF 7.1 X+20\n"
    ends = "PRESET SELECT #2{}\nL X+1 Y+1 Z+1 F100"
    kept = read(shift + ends.format(" KEEP TRANS WP"), MACHINE, setup=setup).tip[-1]
    assert np.allclose(kept, far + np.array([0.02, 0.0, 0.0]))
    assert np.allclose(read(shift + ends.format(" WP"), MACHINE, setup=setup).tip[-1], far)


def test_a_reset_in_a_plane_over_a_shift_before_it_is_refused():
    """Whether TRANS DATUM RESET ends the shift before the plane too, no manual says; it was ended."""
    text = "TRANS DATUM AXIS X+10\nPLANE SPATIAL SPA+0 SPB+0 SPC+90 STAY\n{}TRANS DATUM RESET\nL X+1 Y+0 F100"
    (refusal,) = findings(text.format("")).refusals
    assert refusal.word == "TRANS DATUM RESET in a plane over a shift"
    assert last(text.format("PLANE RESET STAY\n")) == (1, 0, 0)


def test_a_preset_in_a_plane_leaves_it():
    path = read("PLANE SPATIAL SPA+0 SPB+0 SPC+90 STAY\nCYCL DEF 247 Q339=+1\nL X+1 Y+0 F100")
    assert np.allclose(path.tip[-1], (0, 0.001, 0))
    assert any("leaves the plane in force" in said for said in path.assumed)


def test_the_datum_table_is_refused_with_its_cure():
    assert [refusal.word for refusal in findings("CYCL DEF 7.0\nCYCL DEF 7.1 #5\nL X+1 F100").refusals] == [
        "CYCL DEF 7 #"
    ]


def test_tolerance_is_told():
    assert findings("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.02\nL X+1 F100").skipped["CYCL DEF 32"] == 1

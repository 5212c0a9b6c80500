"""Tilted planes: TNC 640 Klartext manual, "The PLANE function"; cycle 19."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import MACHINE, findings, last, read
from toolpace.common.errors import ProgramError
from toolpace.common.units import DEGREE
from toolpace.machine.machine import Machine

SHIFT = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Y-5\n"


def ends(path):
    """Index of the last point of each block."""
    return np.append(np.diff(path.block) > 0, True)


def turned(axis, angle):
    """Rotation (3, 3) about an axis 0, 1, 2 by degrees, as in a textbook."""
    c, s = np.cos(angle * DEGREE), np.sin(angle * DEGREE)
    return np.array(
        [
            [[1, 0, 0], [0, c, -s], [0, s, c]],
            [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        ][axis]
    )


PLANES = [
    ("SPATIAL SPA+27 SPB+0 SPC+45", turned(2, 45) @ turned(0, 27)),
    ("SPATIAL SPA+10 SPB+20 SPC+30", turned(2, 30) @ turned(1, 20) @ turned(0, 10)),
    ("EULER EULPR45 EULNU20 EULROT22", turned(2, 45) @ turned(0, 20) @ turned(2, 22)),
    ("VECTOR BX0.8 BY-0.4 BZ-0.42 NX0.2 NY0.2 NZ0.92", None),
    ("POINTS P1X+0 P1Y+0 P1Z+20 P2X+30 P2Y+31 P2Z+20 P3X+0 P3Y+41 P3Z+32.5", None),
]


@pytest.mark.parametrize(("plane", "rotation"), PLANES)
@pytest.mark.parametrize("way", ["TURN FMAX", "MOVE FMAX", "STAY"])
def test_words_in_a_tilted_plane(plane, rotation, way):
    """SPATIAL: fixed axes, A then B then C; EULER: about z, new x, new z. The tool stands upright on the plane."""
    path = read(f"PLANE {plane} {way}\nL X+1 Y+0 Z+0 F600\nL X+0 Y+1 Z+0\nL X+0 Y+0 Z+1", MACHINE)
    points = path.tip[ends(path)][-3:].T * 1e3
    if rotation is not None:
        assert np.allclose(points, rotation, atol=1e-9)
    assert np.allclose(points.T @ points, np.eye(3), atol=1e-9) and np.linalg.det(points) == pytest.approx(1)
    if way != "STAY":
        assert np.allclose(path.axis[-1], points[:, 2], atol=1e-9)


def test_vector_and_points_have_the_directions_that_they_name():
    path = read(f"PLANE {PLANES[3][0]} STAY\nL X+1 Y+0 Z+0 F600\nL X+0 Z+1", MACHINE)
    normal = np.array((0.2, 0.2, 0.92))
    assert np.allclose(path.tip[-1] * 1e3, normal / np.linalg.norm(normal), atol=1e-12)
    path = read(f"PLANE {PLANES[4][0]} STAY\nL X+1 Y+0 Z+0 F600\nL X+0 Y+1", MACHINE)
    x, y = path.tip[ends(path)][-2:] * 1e3
    assert np.allclose(x, np.array((30, 31, 0)) / np.hypot(30, 31), atol=1e-12)
    assert y @ (0, 41, 12.5) > 0  # the third point is on the side of +Y


def test_the_plane_is_about_the_active_datum_and_a_new_one_replaces_it():
    text = SHIFT + "PLANE SPATIAL SPA+0 SPB+0 SPC+90 STAY\n"
    assert last(text + "L X+1 Y+0 Z+0 F100", MACHINE) == (10, -4, 0)
    assert last(text + "PLANE SPATIAL SPA+90 SPB+0 SPC+0 STAY\nL X+1 Y+2 Z+0 F100", MACHINE) == (11, -5, 2)
    assert last(text + "PLANE RELATIV SPC-90 STAY\nL X+1 Y+0 Z+0 F100", MACHINE) == (11, -5, 0)
    assert last(text + "PLANE RESET STAY\nL X+1 Y+0 Z+0 F100", MACHINE) == (11, -5, 0)


def test_turn_keeps_the_linear_axes_and_move_keeps_the_tip():
    """TURN: only the rotary axes are positioned; MOVE: the tip keeps its place on the part."""
    plane = "L X+5 Y+6 Z+7 F100\nPLANE SPATIAL SPA+30 SPB+0 SPC+0 {} FMAX"
    moved, joints = read(plane.format("MOVE"), MACHINE), read(plane.format("TURN"), MACHINE)
    last_block = moved.block == moved.block[-1]
    assert np.allclose(moved.tip[last_block], (0.005, 0.006, 0.007), atol=1e-12)
    a, c = joints.rotary[-1]
    assert np.allclose(joints.tip[-1], MACHINE.rotation(np.array([a]), np.array([c]))[0] @ (0.005, 0.006, 0.007))
    assert not np.allclose(joints.tip[-1], moved.tip[-1])


@pytest.mark.parametrize("plane", ["SPATIAL SPA+30 SPB+0 SPC+20", "RESET"])
def test_move_keeps_the_point_that_dist_names(plane):
    """MOVE DIST50: the turning point is 50 mm above the tip, and keeps its place on the part."""
    path = read(f"L A+10 C-20 X+5 Y+6 Z+7 F100\nPLANE {plane} MOVE DIST50 F1000", MACHINE)
    turn = slice(int(np.flatnonzero(path.block == path.block[-1])[0]) - 1, None)
    pivot = path.tip[turn] + 0.05 * path.axis[turn]
    assert np.abs(pivot - pivot[0]).max() < 0.45e-6 and np.abs(np.diff(path.rotary[turn], axis=0)).max() > 1e-4
    chord = np.linalg.norm(np.diff(path.tip[turn], axis=0), axis=1)
    assert (chord[-5:] ** 2 / (8 * 0.05)).max() < 0.5e-6


@pytest.mark.parametrize("sign", [-1, 1])
def test_seq_chooses_the_sign_of_the_tilt(sign):
    """SEQ+ and SEQ-: the sign of the master axis, which is the one that tilts."""
    machine = Machine.load("xyzbc-trunnion")
    word = "SEQ+" if sign > 0 else "SEQ-"
    path = read(f"L X+1 B+0 C+0 FMAX\nPLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX {word}", machine)
    tilt = path.rotary[-1, path.rotary_joints.index("B")]
    assert np.sign(tilt) == sign and abs(tilt) == pytest.approx(30 * DEGREE)


def test_stay_gives_the_angles_as_parameters():
    """STAY: the angles are in Q120 to Q122; the program positions by them."""
    text = "PLANE SPATIAL SPA+30 SPB+0 SPC+0 {}\n"
    stay = read(text.format("STAY") + "L A+Q120 C+Q122 FMAX\nL X+1 Y+1 Z+1 F100", MACHINE)
    turn = read(text.format("TURN FMAX") + "L X+1 Y+1 Z+1 F100", MACHINE)
    assert np.allclose(stay.rotary[-1], turn.rotary[-1]) and np.allclose(stay.tip[-1], turn.tip[-1])


def test_rotary_axes_alone_in_a_tilted_plane_leave_the_linear_axes_where_they_are():
    path = read("L X+5 Y+6 Z+7 F100\nPLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\nL A+30 C+0 FMAX", MACHINE)
    a, c = path.rotary[-1]
    assert np.allclose(path.tip[-1], MACHINE.rotation(np.array([a]), np.array([c]))[0] @ (0.005, 0.006, 0.007))


def test_cycle_19_tilts_and_does_not_turn():
    """Cycle 19, spatial angles: the angles are in Q120 to Q122; zeros end it."""
    text = "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+30 B+0 C+0\nL A+Q120 C+Q122 FMAX\nL X+0 Y+1 Z+0 F100\n"
    assert last(text, MACHINE) == pytest.approx((0, np.cos(30 * DEGREE), 0.5), abs=1e-6)
    path = read(
        text + "CYCL DEF 19.0\nCYCL DEF 19.1 A+0 B+0 C+0\nCYCL DEF 19.0\nCYCL DEF 19.1\nL A+0 C+0 FMAX\nL X+3 Y+0 Z+0",
        MACHINE,
    )
    assert np.allclose(path.tip[-1], (0.003, 0, 0), atol=1e-12)


def test_an_angle_that_cycle_19_leaves_out_stays_as_it_was():
    """iTNC 530 Cycle Programming, cycle 19: "nonprogrammed rotary axis values are interpreted as unchanged"."""
    turn, then = "CYCL DEF 19.1 A+30 B+0 C+40\n", "L X+10 Y+0 Z+5 FMAX"
    expected = turned(2, 40) @ turned(0, 10) @ (10, 0, 5)
    assert last(turn + "CYCL DEF 19.1 A+10\n" + then) == pytest.approx(expected, abs=1e-6)
    ended = turn + "CYCL DEF 19.1\nCYCL DEF 19.1 A+10\n"
    assert last(ended + then) == pytest.approx(turned(0, 10) @ (10, 0, 5), abs=1e-6)
    after = "PLANE SPATIAL SPA+0 SPB+0 SPC+20 STAY\nCYCL DEF 19.1 A+10\n"
    with pytest.raises(ProgramError, match=r"behind PLANE leaves an angle out.*write A, B and C"):
        read(after + then)


def test_cycle_19_takes_the_position_near_the_zero_of_the_axes():
    """The same section: "the shorter path from the zero position of the rotary axes"; PLANE counts from where they
    stand."""
    far = "L A+30 C+180 FMAX\n"
    cycle = read(far + "CYCL DEF 19.1 A+30 B+0 C+0\nL A+Q120 C+Q122 FMAX\nL X+1 F100", MACHINE)
    plane = read(far + "PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN FMAX\nL X+1 F100", MACHINE)
    assert np.allclose(cycle.rotary[-1] / DEGREE, (-30, 0)) and np.allclose(plane.rotary[-1] / DEGREE, (30, 180))


@pytest.mark.parametrize("name", ["xyzac-trunnion", "xyzbc-table", "xyzbc-millturn"])
@pytest.mark.parametrize("angle", [30, -120, 180])
def test_table_rot_of_a_plane_that_is_not_tilted_turns_the_table(name, angle):
    """COORD ROT turns the coordinates only, TABLE ROT the table: X of the plane is then the machine's X."""
    machine = Machine.load(name)
    text = f"PLANE SPATIAL SPA+0 SPB+0 SPC{angle:+} TURN FMAX {{}} ROT\nL X+10 Y+0 Z+5 F100\nL X+20"
    table, coordinates = (read(text.format(word), machine) for word in ("TABLE", "COORD"))
    joints = machine.joints_at(table.tip, table.rotary, table.tool_length)
    xyz = [machine.joints.index(letter) for letter in "XYZ"]
    before = np.flatnonzero(table.block == 5)[-1]
    assert np.allclose(joints[-1, xyz] - joints[before, xyz], (0.01, 0, 0), atol=1e-12)
    assert np.allclose(table.tip[-1], coordinates.tip[-1]) and np.allclose(coordinates.rotary, 0.0)
    assert np.allclose(table.tip[-1] * 1e3, turned(2, angle) @ (20, 0, 5))


def test_table_rot_without_a_table_that_turns_about_the_tool_is_refused():
    text = "PLANE SPATIAL SPA+0 SPB+0 SPC+30 TURN FMAX TABLE ROT\nL X+1 F100"
    (found,) = findings(text, Machine.load("xyzab-table")).refusals
    assert found.word == "TABLE ROT of a plane that is not tilted" and "COORD ROT" in found.cure


def test_the_feed_of_a_plane():
    """MOVE and TURN take F, FMAX or FAUTO, the F of TOOL CALL; without one that is said."""
    text = "TOOL CALL 2 Z S1000 F600\nPLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN {}\nL X+1 F100"
    auto, none = (read(text.format(word), MACHINE) for word in ("F AUTO", ""))
    assert auto.least_time[auto.block == 5].sum() == pytest.approx(3.0) and none.rapid[none.block == 5].all()
    assert any("without F turn the axes at rapid" in said for said in none.assumed)


def test_axial_planes_where_tables_tilt():
    """PLANE AXIAL: the angles are those of the axes."""
    path = read("PLANE AXIAL A+30 C+0 TURN FMAX\nL X+0 Y+0 Z+1 F100", MACHINE)
    assert np.allclose(path.rotary[-1], (30 * DEGREE, 0)) and np.allclose(path.tip[-1] * 1e3, path.axis[-1])


def test_axial_planes_build_on_each_other_and_take_no_other_solution():
    """PLANE AXIAL: "modally effective; successive definitions build on each other", and SEQ does nothing. The axes go
    to the angles that are written, also where the other solution is nearer."""
    path = read("L A-30 C+180 FMAX\nPLANE AXIAL A+30 C+0 TURN FMAX SEQ-\nL X+1 F100", MACHINE)
    assert np.allclose(path.rotary[-1] / DEGREE, (30, 0))
    text = "PLANE AXIAL A+30 C+20 TURN FMAX\nPLANE AXIAL IA+10 TURN FMAX\nL X+1 Y+0 Z+0 F100"
    path = read(text, MACHINE)
    assert np.allclose(path.rotary[-1] / DEGREE, (40, 20))
    table = MACHINE.rotation(np.array([40 * DEGREE]), np.array([20 * DEGREE]))[0]
    assert np.allclose(path.tip[-1] * 1e3, table @ (1, 0, 0), atol=1e-9)


def test_an_axis_that_a_first_axial_plane_leaves_out_must_stand_at_zero():
    with pytest.raises(ProgramError, match="leaves C out, which stands at 20"):
        read("L C+20 FMAX\nPLANE AXIAL A+30 TURN FMAX\nL X+1 F100", MACHINE)


def test_axial_plane_of_a_head_that_one_axis_tilts():
    """PLANE AXIAL B-45, the manual's example: X and Z of the plane turn with the axis about Y."""
    machine = Machine.load("xyzbc-head")
    path = read("PLANE AXIAL B-45 C+0 TURN FMAX\nL X+10 Y+0 Z+0 F100\nL X+0 Y+0 Z+10", machine)
    x, z = path.tip[ends(path)][-2:] * 1e3
    assert np.allclose(x, turned(1, -45) @ (10, 0, 0), atol=1e-9) and np.allclose(z, path.axis[-1] * 10, atol=1e-9)
    text = "PLANE AXIAL B-45 C+30 TURN FMAX\nL X+10 F100"
    assert [each.word for each in findings(text, machine).refusals] == ["PLANE AXIAL"]
    assert [each.word for each in findings(text, Machine.load("xyzbc-nutating")).refusals] == ["PLANE AXIAL"]


@pytest.mark.parametrize(
    ("before", "plane", "word"),
    [
        ("CYCL DEF 10.0\nCYCL DEF 10.1 ROT+20", "SPATIAL SPA+10 SPB+0 SPC+0", "PLANE over a rotation or scale of axes"),
        ("CYCL DEF 26.0\nCYCL DEF 26.1 X2 Y1", "SPATIAL SPA+10 SPB+0 SPC+0", "PLANE over a rotation or scale of axes"),
        ("CYCL DEF 8.0\nCYCL DEF 8.1 X", "AXIAL A+10 C+0", "PLANE over a mirror"),
        ("CYCL DEF 8.0\nCYCL DEF 8.1 C", "SPATIAL SPA+10 SPB+0 SPC+0", "PLANE over a mirror"),
        ("PLANE SPATIAL SPA+5 SPB+0 SPC+0 STAY\nCYCL DEF 7.0\nCYCL DEF 7.1 X+5", "RELATIV SPA+5",
         "PLANE over a shift, mirror, rotation or scale in the plane before"),
    ],
)  # fmt: skip
def test_a_plane_over_what_no_manual_places(before, plane, word):
    """TNC 620 Conversational, "Workpiece coordinate system W-CS": shifts and mirrors stand before a plane, rotations
    and scales in it; "any other use may lead to unexpected results"."""
    text = f"{before}\nPLANE {plane} STAY\nL X+1 F100"
    assert [refusal.word for refusal in findings(text, MACHINE).refusals] == [word]


def test_a_mirror_before_a_plane_mirrors_the_plane():
    """The same section: mirrors before a plane change "the orientation of the rotary axes"."""
    text = "CYCL DEF 8.0\nCYCL DEF 8.1 X\nPLANE SPATIAL SPA+20 SPB+30 SPC+0 TURN FMAX\nL X+1 Y+2 Z+3 F100"
    path = read(text, MACHINE)
    mirrored = np.diag([-1, 1, 1]) @ turned(1, 30) @ turned(0, 20)
    assert np.allclose(path.tip[-1] * 1e3, mirrored @ (1, 2, 3), atol=1e-9)
    assert np.allclose(path.axis[-1], mirrored[:, 2], atol=1e-9)


def test_a_block_in_a_plane_that_the_axes_are_not_turned_to_is_said():
    plane = "PLANE SPATIAL SPA+20 SPB+0 SPC+0 {} FMAX\n{}L X+1 F100"
    for how, more, said in (
        ("STAY", "", True), ("TURN", "", False), ("STAY", "M128\n", False), ("TURN", "L A+0\n", True),
    ):  # fmt: skip
        assumed = " ".join(read("L F100\n" + plane.format(how, more), MACHINE).assumed)
        assert ("not turned to" in assumed) == said


def test_m130_positions_in_the_untilted_system():
    """M130: the block's coordinates refer to the untilted system, in a tilted plane."""
    text = "PLANE SPATIAL SPA+90 SPB+0 SPC+0 TURN FMAX\nL X+1 Y+1 Z+1 F100\n"
    path = read(text + "L X+2 Y+3 Z+4 M130", MACHINE)
    a, c = path.rotary[-1]
    assert np.allclose(path.tip[-1], MACHINE.rotation(np.array([a]), np.array([c]))[0] @ (0.002, 0.003, 0.004))
    assert any("M130" in said for said in path.assumed)
    after = last(text + "L X+2 Y+3 Z+4 M130\nL X+1 Y+1 Z+1", MACHINE)
    assert after == (1, -1, 1)


def test_a_shift_in_a_tilted_plane_is_along_its_axes_and_said():
    found = read("PLANE SPATIAL SPA+90 SPB+0 SPC+0 STAY\nCYCL DEF 7.0\nCYCL DEF 7.1 Y+5\nL X+0 Y+1 Z+0 F100", MACHINE)
    assert np.allclose(found.tip[-1], (0, 0, 0.006), atol=1e-12)
    assert any("in a tilted plane" in said for said in found.assumed)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("PLANE PROJECTED PROPR+24 PROMIN+24 ROT+30 STAY", "PLANE PROJECTED"),
        ("PLANE PROJECTED PROPR+24 PROMIN+24 PROROT+30 STAY", "PLANE PROJECTED"),
        ("CYCL DEF 19.1 A+30 F1000 ABST50", "CYCL DEF 19 with a feed"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER", "FUNCTION TCPM REFPNT CENTER-CENTER"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-CENTER", "FUNCTION TCPM REFPNT TIP-CENTER"),
        ("FUNCTION MODE TURN", "FUNCTION MODE TURN"),
        ("TRANS DATUM TABLE TABLINE5", "TRANS DATUM TABLE TABLINE5"),
    ],
)
def test_what_is_refused(text, word):
    assert [refusal.word for refusal in findings(f"{text}\nL X+1 F100", MACHINE).refusals] == [word]


def test_a_plane_out_of_reach_names_machine_and_joints():
    machine = Machine.load("xyzac-trunnion")
    with pytest.raises(ProgramError, match="cannot bring its tool"):
        read("PLANE SPATIAL SPA+180 SPB+0 SPC+0 TURN FMAX\nL X+1 F100", machine)


def test_vectors_that_span_no_plane():
    with pytest.raises(ProgramError, match="span no plane"):
        read("PLANE VECTOR BX0 BY0 BZ1 NX0 NY0 NZ1 STAY\nL X+1 F100", MACHINE)


def test_table_rot_of_no_tilt_turns_the_table_back():
    """TNC 640 manual, "Transformation types": the table turns to the spatial angle, which is zero here."""
    turned = read("L A+30 C+40 FMAX\nPLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN FMAX TABLE ROT\nL X+1 F100", MACHINE)
    assert np.allclose(turned.rotary[-1], 0.0) and np.ptp(turned.rotary[:, 0]) > 0.5

"""Planes, offsets of rotary axes, mirrors, scales and tool-centre-point mode together: where the tip must be."""

from __future__ import annotations

import math

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import ToolpaceError
from toolpace.common.units import DEGREE
from toolpace.programs.reading.setup_file import setup_of_text

MACHINES = ("xyzac-trunnion", "xyzbc-trunnion", "xyzbc-nutating", "xyzbc-head", "xyzab-trunnion-inch", "xyzbc-table")
TURNED = """
[machine_zero]
X = 0
Y = 0
Z = 0
[offsets.G54]
C = 0.5
[offsets.1]
C = 0.5
"""
START = {
    "fanuc": "G21 G90 G94 G17 G40 F500\nT1 M6\n",
    "sinumerik": "G710 G90 G94 G17 F500\n",
    "heidenhain": "BEGIN PGM X MM\n",
}


def read(text, machine="xyzac-trunnion", controller="fanuc", sheet=""):
    setup = setup_of_text(sheet) if sheet else None
    return tp.read_text(START[controller] + text, tp.Machine.load(machine), setup=setup, controller=controller)


def refusals(text, **where):
    try:
        read(text, **where)
    except ToolpaceError as error:
        return str(error)
    return ""


def turn(axis, degrees):
    """Rotation matrix (3, 3) about X (0), Y (1) or Z (2)."""
    c, s = math.cos(degrees * DEGREE), math.sin(degrees * DEGREE)
    made = np.eye(3)
    i, j = [k for k in range(3) if k != axis]
    made[i, i] = made[j, j] = c
    made[i, j], made[j, i] = (s, -s) if axis == 1 else (-s, s)
    return made


@pytest.mark.parametrize("machine", MACHINES)
def test_tip_mode_within_a_plane_does_not_turn_it_again(machine):
    text = "G68.2 X10 Y20 Z-5 I30 J15 K-30\nG53.1\nG43.4 H1 X0 Y0 Z50\nG1 Z0\nX7 Y3\n"
    path = read(text, machine)
    plane = turn(2, 30) @ turn(0, 15) @ turn(2, -30)
    wanted = np.array([10.0, 20.0, -5.0]) + np.array([[0.0, 0.0, 0.0], [7.0, 3.0, 0.0]]) @ plane.T
    assert path.tip[-2:] * 1e3 == pytest.approx(wanted, abs=1e-6)
    assert path.axis[-1] == pytest.approx(plane[:, 2], abs=1e-9)


def test_a_turn_in_a_plane_is_refused_and_a_plane_in_a_turn():
    plane = "G68.2 X0 Y0 Z0 I30 J15 K-30\n"
    assert "G68 in a tilted plane" in refusals(f"{plane}G53.1\nG68 X0 Y0 R10\nG1 X5\nX7\n")
    assert "G69" in refusals(f"G68 X0 Y0 R10\n{plane}G1 X5\nX7\n")
    assert not refusals(f"G0 X0 Y0 Z0\nG68 X0 Y0 R10\nG69\n{plane}G1 X5\nX7\n")


PLANES = {
    "fanuc": "G54\nG0 X0 Y0 Z0\nG68.2 X0 Y0 Z0 I0 J25 K10\nG53.1\nG1 X5\n",
    "sinumerik": 'G54\nG0 X0 Y0 Z0\nCYCLE800(1,"",100000,57,0,0,0,20,0,0,0,0,0,1,,1)\nG1 X5 F100\n',
    "heidenhain": "CYCL DEF 247 DATUM SETTING ~ Q339=+1\nL X+0 Y+0 Z+0 FMAX\n"
                  "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX\nL X+5 F100\n",
}  # fmt: skip


@pytest.mark.parametrize("controller", PLANES)
def test_a_plane_on_a_table_that_its_offset_shifts_is_refused(controller):
    text = PLANES[controller]
    assert "rotary axis of the table is shifted" in refusals(text, controller=controller, sheet=TURNED)
    assert not refusals(text, controller=controller, sheet=TURNED.replace("0.5", "0"))
    # a head carries no part
    assert not refusals(text, machine="xyzbc-head", controller=controller, sheet=TURNED)


@pytest.mark.parametrize(
    ("controller", "block", "said"),
    [
        ("fanuc", "G51.1 X0 C0", "G51.1 with C"), ("fanuc", "G51 X0 Y0 Z0 P2000 C5", "G51 with C"),
        ("fanuc", "G68 X0 Y0 R10 C5", "G68 with C"), ("sinumerik", "MIRROR X0 C0", "MIRROR with C"),
        ("sinumerik", "AMIRROR C0", "AMIRROR with C"), ("sinumerik", "SCALE X2 C2", "SCALE with C"),
        ("sinumerik", "ASCALE C2", "ASCALE with C"), ("sinumerik", "ROT Z10 C2", "ROT with C"),
    ],
)  # fmt: skip
def test_a_rotary_word_of_a_frame_is_no_motion(controller, block, said):
    assert said in refusals(f"G0 X0 Y0 Z0 A0 C20\n{block}\nG1 X5\n", controller=controller)


def test_g50_1_with_a_rotary_axis_moves_nothing():
    path = read("G0 X0 Y0 Z0 A0 C20\nG51.1 X0\nG50.1 X0 C0\nG1 X5\n")
    assert path.rotary[-1] == pytest.approx([20.0 * DEGREE, 0.0])


@pytest.mark.parametrize(
    ("blocks", "wanted"),
    [
        ("G58 C10\nG1 X5 C=20\n", 30), ("G59 C10\nG1 X5 C=20\n", 30), ("TRANS C5\nG59 C10\nG1 X5 C=20\n", 35),
        ("TRANS C5\nG58 C10\nG1 X5 C=20\n", 30), ("TRANS C5\nATRANS C3\nG1 X5 C=20\n", 28),
        ("G58 C10\nTRANS\nG1 X5 C=20\n", 20),
    ],
)  # fmt: skip
def test_axial_shifts_of_rotary_axes(blocks, wanted):
    path = read(f"G0 X0 Y0 Z0 A0 C0\n{blocks}", controller="sinumerik")
    assert path.rotary[-1, 0] / DEGREE == pytest.approx(wanted)


def test_a_direction_in_uneven_scales_is_refused():
    text = "TRAORI\nSCALE X2\nG1 X1 Y0 Z0 A3=0 B3=1 C3=1\nX2\n"
    assert "scaled unevenly" in refusals(text, controller="sinumerik")
    assert not refusals(text.replace("SCALE X2", "SCALE X2 Y2 Z2"), controller="sinumerik")


TCPM = "L X+0 Y+0 Z+0 FMAX\nFUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\n"


@pytest.mark.parametrize(
    ("blocks", "angles"),
    [
        ("L X+1 A+20 F100\nL X+2 B+10\n", (20, 10, 0)), ("L X+1 A+20 B+5 C+30 F100\nL X+2 A+10\n", (10, 5, 30)),
        ("L X+1 A+20 B+0 C+30 F100\nL X+2 IA+5\n", (25, 0, 30)), ("L X+1 B-15 F100\nL X+2 C+40\n", (0, -15, 40)),
    ],
)  # fmt: skip
@pytest.mark.parametrize("machine", ["xyzbc-trunnion", "xyzac-trunnion", "xyzbc-head"])
def test_spatial_angles_stay(machine, blocks, angles):
    path = read(TCPM + blocks, machine, "heidenhain")
    a, b, c = angles
    wanted = (turn(2, c) @ turn(1, b) @ turn(0, a))[:, 2]
    assert path.axis[-1] == pytest.approx(wanted, abs=1e-9)
    assert path.tip[-1] * 1e3 == pytest.approx([2.0, 0.0, 0.0], abs=1e-9)


def test_spatial_angles_that_are_not_known_are_asked_for():
    text = "L X+0 Y+0 Z+0 A+10 C+20 FMAX\nFUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+1 A+20 F100\n"
    assert "tells no B, C" in refusals(text, controller="heidenhain")
    # without TCPM a letter that the machine lacks is no angle
    assert "has no axis B" in refusals("L X+0 Y+0 Z+0 FMAX\nL X+1 B+20 F100\n", controller="heidenhain")

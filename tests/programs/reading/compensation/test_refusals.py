"""What compensation refuses, and what of a machine stands still behind it."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.linuxcnc.job import Cartesian
from tests.support.compensated import HEADS, SHEET, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

KLARTEXT = "L X-20 Y-20 Z+0 R0 FMAX\nL X+0 Y+0 RL F500\nL Y+50\n{}L X-20 R0\nM30\nEND PGM A MM\n"


def refused(text: str, control: str, sheet: SetUp = SHEET) -> str:
    with pytest.raises(ProgramError) as caught:
        read(text, control, sheet)
    return str(caught.value)


@pytest.mark.parametrize(
    ("control", "contour", "said"),
    [
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nX-3\nY0\nG40 X9\n", "PS0041"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nG3 X53 Y3 R3\nG1 Y20\nG40 X9\n", "does not fit into this arc"),
        ("fanuc", "G41 D1 G2 X0 Y0 R30 F500\nY50\nG40 X9\n", "begins with a straight motion"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG40 G2 X30 Y50 R15\n", "straight motion behind G40"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nZ-5\nZ-6\nY50\nG40 X9\n", "2 blocks before this one"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nM8\nM3\nY50\nG40 X9\n", "2 blocks before this one"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nM0\nY50\nG40 X9\n", "M0 or M1 stands"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nZ-5\nX0 Y-20\nG40 X-20\n", "in several lines"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nY20\nG40 X9\n", "goes back on itself"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG42 D1 X50\nG40 X9\n", "write G40 before it"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG18 X50\nG40 X9\n", "change of the plane"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG81 X50 Y0 Z-3 R2\nG40 X9\n", "cycle of holes"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG52 X5\nX50\nG40 X9\n", "change of coordinates"),
        ("fanuc", "G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "without D"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nD3 X50\nY0\nG40 X60\n", "D3 changes the radius from 4 to 3 mm"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nD0 X50\nY0\nG40 X60\n", "D0 changes the radius from 4 to 0 mm"),
        ("fanuc", "G41 D0 G1 X0 Y0 F500\nY50\nD1 X50\nY0\nG40 X60\n", "D1 changes the radius from 0 to 4 mm"),
        ("fanuc", "G41 D2 G1 X0 Y0 F500\nY50\nG40 X9\n", "radius"),
        ("fanuc", "G41 D9 G1 X0 Y0 F500\nY50\nG40 X9\n", "radius"),
        ("fanuc", "G10 L12 P1 R3\nG41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "G10 tells its radius"),
        ("fanuc", "G51 X0 Y0 P2000\nG41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "scaled"),
        ("fanuc", "G93\nG41 D1 G1 X0 Y0 F5\nY50 F5\nG40 X9 F5\n", "G93"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nG40 X9\n", "before it has followed a contour"),
        ("haas", "G18 G41 D1 G1 X0 Z0 F500\nZ50\nG40 X9\n", "alarm 344"),
        ("haas", "G41 D1 G1 X0 Y0 F500\nY50\n", "alarm 349"),
        ("iso", "G41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "how this control compensates is not known"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG40 X9 I5 J0\n", "write that element out"),
        ("millplus", "G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "how this control compensates is not known"),
        ("fanuc", "G41.1 G1 X0 Y0 F500\nY50\nG40.1 X9\n", "follows the contour"),
        ("fanuc", "G42.5 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "compensation in space"),
        ("sinumerik", "G41 KONTC G1 X0 Y0 F500\nY50\nG40 X9\n", "NORM and KONT are read"),
        ("sinumerik", "G0 X1 Y-1\nG41 KONT G1 X0 Y0 F500\nY50\nG40 X9\n", "within the tool's radius"),
        ("sinumerik", "G41 KONT G1 X0 Y0 F500\nY50\nG40\nZ9\nX9\n", "write that way first"),
        ("sinumerik", "DISC=50 G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "arcs are read without it"),
        ("sinumerik", "G461 G41 G1 X0 Y0 F500\nX3\nX0 Y50\nG40 X-9\n", "10750"),
        ("sinumerik", "OFFN=-5 G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "come to -1 mm"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nOFFN=1 Y50\nG40 X9\n", "OFFN while"),
        ("sinumerik", "G70\nOFFN=1 G41 G1 X0 Y0 F500\nY2\nG40 X9\n", "whether it is in inches"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nCUTCONON Y50\nG40 X9\n", "before the first element"),
        ("sinumerik", "CUTCONON\nG41 G1 X0 Y0 F500\nY50\nG40 X9\n", "no radius is compensated"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nCUTCONON Y60\nG40 X9\n", "write CUTCONOF before"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nCUTCONON Y60\nD2 X9\n", "D2 while"),
        ("sinumerik", "KONT G41 G1 X0 Y0 F500\nY50\nCUTCONON X9\nCUTCONOF Y9\nG40 X9\n", "write NORM"),
        ("sinumerik", "G41 CUT3DC G1 X0 Y0 F500\nY50\nG40 X9\n", "compensation in space"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nG42 X50\nG40 X9\n", "changes the side"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nTRANS X5\nX50\nG40 X9\n", "change of coordinates"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nD2 X50\nG40 X9\n", "write G40 before it"),
        ("sinumerik", "AROT X30\nG41 G1 X0 Y0 F500\nY50\nG40 X9\n", "CUT2DF"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nX-3\nY0\nG40 X9\n", "10750"),
    ],
)
def test_what_is_refused(control, contour, said):
    head = HEADS.get(control, HEADS["fanuc"])
    with pytest.raises(ProgramError, match=r"part\.nc") as caught:
        read_text(head + f"G0 X-20 Y-20 Z0\n{contour}M30\n", None, controller=control, setup=SHEET, name="part.nc")
    assert said in str(caught.value)


def test_a_reference_point_is_not_gone_to_from_a_compensated_contour():
    text = HEADS["fanuc"] + "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nG28 Z0\nG40 X9\nM30\n"
    with pytest.raises(ProgramError, match="machine coordinates under cutter compensation"):
        read_text(text, Cartesian(), controller="fanuc", setup=SHEET)


def test_axes_that_are_not_named_stay_beside_the_contour_until_a_motion_leads_away():
    """G40 alone: Z goes up where the centre is, in machine coordinates too, and the next motion starts there."""
    text = HEADS["fanuc"] + "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nG40\nZ5\nG53 Z0\nG0 X30\nM30\n"
    sheet = SetUp(tools=SHEET.tools, machine_zero=dict.fromkeys("XYZ", 0.0))
    found = read_text(text, Cartesian(), controller="fanuc", setup=sheet)
    assert np.allclose(found.tip[2:, :2] * 1e3, [[-4, 50], [-4, 50], [-4, 50], [30, 50]])
    assert any("stays beside the contour" in said for said in found.assumed)


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("L X-3\nL Y+0\n", "does not fit"), ("L X+50 RR\n", "write R0 before it"),
        ("APPR LT X+20 Y+60 LEN5 RL\n", "APPR under RL"), ("L X+50 M97\n", "M97"),
        ("TOOL CALL 2 Z\n", "write R0 before it"), ("L X+50 R+\n", "block of one axis"),
        ("L Z+50 M91\n", "machine coordinates"),
        ("LN X+5 Y+5 Z+5 NX0 NY0 NZ1 TX0 TY0 TZ1\n", "LN"), ("CYCL DEF 7.0\nCYCL DEF 7.1 X+5\n", "coordinates"),
    ],
)  # fmt: skip
def test_what_is_refused_in_klartext(block, said):
    assert said in refused(KLARTEXT.format(block), "heidenhain")


def test_klartext_without_a_radius_names_the_cure():
    assert "[tools.N] radius" in refused(KLARTEXT.format(""), "heidenhain", SetUp(tools={"1": Tool(0.1)}))

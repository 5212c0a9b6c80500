"""Tool vectors and TRAORI (Job Planning 6 and 7; NC Programming 3.9)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sinumerik import read
from toolpace.common.errors import ProgramError

TIP = "TRAORI\nG1 X0 Y0 Z0 A3=0 B3=0 C3=1\n"
MILLS = ("xyzac-trunnion", "xyzbc-nutating", "xyzbc-trunnion")


def off_plane(path, first, last) -> float:
    """Most angle [rad] between the tool axes of a path and the plane of two directions."""
    normal = np.cross(first, last)
    return float(np.abs(np.arcsin(path.axis @ (normal / np.linalg.norm(normal)))).max())


@pytest.mark.parametrize("mill", MILLS)
def test_tool_vectors_of_any_length(mill):
    """Job Planning, 7.2: A3, B3, C3 is a vector from the tip to the holder, of any length; what is missing is zero."""
    path = read(TIP + "X10 A3=3 C3=4", mill)
    assert path.axis[-1] == pytest.approx([0.6, 0, 0.8], abs=1e-9)
    assert path.tip[-1] * 1e3 == pytest.approx([10, 0, 0])


@pytest.mark.parametrize("mill", MILLS)
def test_vectors_turn_on_a_great_circle_or_with_the_axes(mill):
    """NC Programming, 3.9: ORIVECT turns in the plane of both vectors, ORIAXES the rotary axes in proportion."""
    first, second = (0.3, 0.2, 0.93), (-0.2, 0.45, 0.87)
    words = "\nX10 A3={} B3={} C3={}".format
    straight = read(f"{TIP}ORIVECT{words(*first)}\nG4 F1{words(*second).replace('X10', 'X20')}", mill)
    part = slice(int(np.argmax(straight.dwell > 0)), None)
    axes = straight.axis[part]
    normal = np.cross(first, second)
    assert np.abs(axes @ (normal / np.linalg.norm(normal))).max() < 2e-4
    turned = read(f"{TIP}ORIAXES{words(*first)}\nG4 F1{words(*second).replace('X10', 'X20')}", mill)
    rotary = turned.rotary[int(np.argmax(turned.dwell > 0)) :]
    share = np.linalg.norm(turned.tip[int(np.argmax(turned.dwell > 0)) :] - turned.tip[-1], axis=1) / 0.01
    line = rotary[-1] + share[:, None] * (rotary[0] - rotary[-1])
    assert np.abs(rotary - line).max() < 1e-9
    assert turned.axis[-1] == pytest.approx(straight.axis[-1], abs=1e-9)


def test_pieces_of_a_block_share_its_time():
    path = read(TIP + "G93 X10 A3=1 B3=1 C3=1 F4", "xyzac-trunnion")
    assert path.least_time.sum() == pytest.approx(15.0)


def test_frames_turn_vectors():
    """ORIWKS: the vector is one of the workpiece coordinates, which a frame turns."""
    path = read(TIP + "ROT Z90\nX10 A3=0.6 C3=0.8", "xyzac-trunnion")
    assert path.axis[-1] == pytest.approx([0, 0.6, 0.8], abs=1e-9)


def test_orientation_angles():
    """Job Planning, 7.2: ORIEULER turns +Z about Z, X', Z''; ORIRPY about Z, Y', X''."""
    a, b = math.radians(30), math.radians(40)
    euler = read(TIP + "ORIEULER\nX10 A2=30 B2=40 C2=15", "xyzac-trunnion")
    assert euler.axis[-1] == pytest.approx([math.sin(a) * math.sin(b), -math.cos(a) * math.sin(b), math.cos(b)])
    rpy = read(TIP + "ORIRPY\nX10 A2=30 B2=40 C2=0", "xyzac-trunnion")
    assert rpy.axis[-1] == pytest.approx([math.sin(b) * math.cos(a), -math.sin(a), math.cos(b) * math.cos(a)])


def test_traori_keeps_the_tip_and_gives_it_the_words():
    path = read("G0 A20 C30\nTRAORI\nG1 X5 Y6 Z7\nA10 C40\nTRAFOOF\nG0 Z50", "xyzac-trunnion")
    turned = path.tip[np.isin(path.block, [5, 6])]
    assert turned[-1] * 1e3 == pytest.approx([5, 6, 7])
    assert np.abs(turned - turned[-1]).max() < 1e-9 or path.tip[path.block == 6].std(axis=0).max() < 1e-9


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G1 X0 A3=1 C3=1", "need TRAORI"),
        ("TRAORI\nG1 X0 A3=0", "the tool vector is zero"),
        ("TRAORI\nG1 X0 A3=0.1 C3=-1", "cannot bring its tool"),
        ("TRAORI\nG1 X0 LEAD=5", "LEAD= is not read"),
        ("TRAORI(1,0,1,1)", "TRAORI with another direction"),
    ],
)
def test_vectors_that_cannot_be(text, said):
    with pytest.raises(ProgramError, match=said):
        read(text, "xyzbc-head")


def test_the_order_of_rpy_angles_is_said_where_it_matters():
    """Job Planning: ORIRPY by C2, B2, A2 about Z, Y', X''; NC Programming 12/2019 has ORIRPY XYZ, and ORIRPY2 ZYX."""
    several = read(TIP + "ORIRPY\nX10 A2=30 B2=40", "xyzac-trunnion")
    assert any("ORIRPY turns" in said for said in several.assumed)
    for word in ("ORIRPY", "ORIRPY2"):
        alone = read(TIP + f"{word}\nX10 B2=40", "xyzac-trunnion")
        assert alone.axis[-1] == pytest.approx([math.sin(math.radians(40)), 0, math.cos(math.radians(40))])
        assert not any("ORIRPY" in said for said in alone.assumed)
    with pytest.raises(ProgramError, match="ORIRPY2 with several angles"):
        read(TIP + "ORIRPY2\nX10 A2=30 B2=40", "xyzac-trunnion")


@pytest.mark.parametrize("mode", ["ORIVIRT1", "ORIVIRT2"])
def test_angles_about_axes_that_the_machine_tells_are_refused(mode):
    """MD21120, MD21130 say about which axes A2, B2 and C2 turn there."""
    with pytest.raises(ProgramError, match="under ORIVIRT1 or ORIVIRT2"):
        read(f"TRAORI\n{mode}\nG1 X5 A2=30 B2=10", "xyzac-trunnion")
    path = read(f"TRAORI\n{mode}\nG1 X5 A3=1 C3=1", "xyzac-trunnion")
    assert path.axis[-1] == pytest.approx([0.5**0.5, 0, 0.5**0.5])


def test_normals_of_the_surface_turn_nothing_by_themselves():
    text = "TRAORI\nG1 X5 A3=1 C3=1{}\nX9{}"
    with_normals = read(text.format(" A4=0 B4=0 C4=1 A5=0.1 C5=1", " A5=0.3 C5=1"), "xyzac-trunnion")
    without = read(text.format("", ""), "xyzac-trunnion")
    assert np.array_equal(with_normals.tip, without.tip) and np.array_equal(with_normals.axis, without.axis)
    with pytest.raises(ProgramError, match="LEAD= is not read"):
        read(text.format(" A5=0.1 C5=1 LEAD=5", ""), "xyzac-trunnion")

"""TRAORI with arguments, ORIRESET, TOROT, $P_PFRAME (Job Planning, "TRAORI"; Function Manual K2, "TOROT")."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.support.sinumerik import SINUMERIK, read
from toolpace.common.errors import ProgramError

START = "G54 G64 G90 G71 F1000\nG0 X0 Y0 Z50\n"
TILTED = "TRAORI\nG1 X5 Y3 Z1 A3={} B3={} C3={}\n"
DIRECTIONS = [(0.3, 0.2, 0.9), (-0.1, 0.5, 0.8), (0.0, 0.4, 0.9), (0.4, 0.0, 0.9)]


def tip(text, on="xyzac-trunnion", **options):
    return read(text, on, start=START, **options).tip[-1] * 1e3


def frame(text, on="xyzac-trunnion", **options):
    """Origin (3,) [mm] and axes (3, 3) in columns of the frame in which a program ends, by four of its places."""
    origin, *ends = (tip(f"{text}G1 X{x} Y{y} Z{z}", on, **options) for x, y, z in ((0, 0, 0), *np.eye(3, dtype=int)))
    return origin, np.array([end - origin for end in ends]).T


def refused(text, said, on="xyzac-trunnion"):
    with pytest.raises(ProgramError, match=said):
        read(text, on, start=START)


@pytest.mark.parametrize("vector", DIRECTIONS)
@pytest.mark.parametrize("mode", ["2000", "2001", "2002"])
def test_torot_turns_z_to_the_tool_and_keeps_the_origin(vector, mode):
    """SD42980: with 2001 X lies in the old ZX plane, with 2002 Y in the old YZ plane, with 2000 both are as far."""
    controller = msgspec.structs.replace(SINUMERIK, options=SINUMERIK.options | {"toframe_mode": mode})
    origin, axes = frame(TILTED.format(*vector) + "TOROT\n", controller=controller)
    assert origin == pytest.approx([0, 0, 0], abs=1e-7)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-8) and np.linalg.det(axes) > 0
    assert axes[:, 2] == pytest.approx(np.array(vector) / np.linalg.norm(vector), abs=1e-8)
    assert axes[0, 0] > 0 and axes[1, 1] > 0
    out_of_plane = {"2000": axes[1, 0] - axes[0, 1], "2001": axes[1, 0], "2002": axes[0, 1]}
    assert out_of_plane[mode] == pytest.approx(0.0, abs=1e-8)


def test_torot_says_what_it_takes_for_granted_where_it_matters():
    said = "SD42980"
    several = read(TILTED.format(0.3, 0.2, 0.9) + "TOROT\nG1 X0 Y0 Z0", "xyzac-trunnion", start=START)
    alone = read(TILTED.format(0.0, 0.2, 0.9) + "TOROT\nG1 X0 Y0 Z0", "xyzac-trunnion", start=START)
    assert any(said in each for each in several.assumed) and not any(said in each for each in alone.assumed)


@pytest.mark.parametrize("mill", ["xyzac-trunnion", "xyzbc-head", "xyzbc-nutating"])
def test_a_retract_along_the_tool_by_torot(mill):
    """The use of it in the manuals: TOROT, then Z alone moves along the tool, also with a frame in force."""
    vector = np.array([0.3, 0.2, 0.9]) / math.sqrt(0.94)
    text = "TRANS X7 Y-2 Z3\nAROT Z30\n" + TILTED.format(0.3, 0.2, 0.9)
    before = tip(text, mill)
    turned = np.array([[math.cos(math.pi / 6), -0.5, 0], [0.5, math.cos(math.pi / 6), 0], [0, 0, 1]]) @ vector
    assert tip(text + "TOROT\nG91 G1 Z12\nG90", mill) - before == pytest.approx(12 * turned, abs=1e-6)
    assert tip(text + "TOROT\nG91 G1 Z12\nG90\nTOROTOF\nG1 X5 Y3 Z1", mill) == pytest.approx(before, abs=1e-6)


def test_torot_where_the_tool_stands_along_z_changes_nothing():
    """K2: "if no toolholder is active, the Z direction in the new frame is the same as the old one with G17"."""
    assert tip("TOROT\nG1 X1 Y2 Z3") == pytest.approx([1, 2, 3])
    plane = 'CYCLE800(0,"",0,57,0,0,0,30,0,0,0,0,0,-1,0,1)\n'
    assert tip(f"{plane}TOROT\nG1 X1 Y2 Z3") == pytest.approx(tip(f"{plane}G1 X1 Y2 Z3"), abs=1e-9)


def test_frames_of_the_tool_that_are_refused():
    tilted = TILTED.format(0.3, 0.2, 0.9)
    refused(f"TRANS X3\n{tilted}TOROT\nTRANS X4\nG1 X0", "TRANS after TOROT")
    refused(f"SCALE X2 Y2 Z2\n{tilted}TOROT\nG1 X0", "TOROT in a scaled or mirrored frame")
    refused(f"{tilted}G18 TOROT\nG1 X0", "TOROT under G18")
    refused(f"TRANS X3\n{tilted}TOFRAME\nG1 X0", "TOFRAME upon another frame")
    refused(f"{tilted}TOROT\nTOFRAME\nG1 X0", "TOFRAME upon another frame")
    refused(f"{tilted}TOFRAME\nTRANS X4\nG1 X0", "TRANS after TOROT")
    refused(f"{tilted}TOFRAMEX\nG1 X0", "TOFRAMEX is not read")
    refused(f"{tilted}PAROT\nG1 X0", "PAROT is not read")
    plane = 'CYCLE800(0,"",0,57,0,0,0,30,0,0,0,0,0,-1,0,1)\n'
    for word in ("TOROTOF", "PAROTOF"):
        refused(f"{plane}{word}\nG1 X0", f"{word} in a plane of CYCLE800")
        assert tip(f"{word}\nG1 X1 Y2 Z3") == pytest.approx([1, 2, 3])


def test_toframe_upon_no_frame_is_torot():
    """PF 12.8: Z lies along the tool; the example there retracts with G91 Z20, and then goes along the new X."""
    vector = np.array([0.0, 0.4, 0.9]) / math.hypot(0.4, 0.9)
    tilted = TILTED.format(*vector)
    origin, axes = frame(tilted + "TOFRAME\n")
    assert origin == pytest.approx([0, 0, 0], abs=1e-7) and axes[:, 2] == pytest.approx(vector, abs=1e-8)
    assert tip(f"{tilted}TOFRAME\nG91 G1 Z20") == pytest.approx(np.array([5, 3, 1]) + 20 * vector)
    assert tip(f"{tilted}TOFRAME\nG91 G1 Z20\nX50") == pytest.approx(np.array([55, 3, 1]) + 20 * vector)
    assert tip(f"{tilted}TOFRAME\nTOROTOF\nG1 X1 Y2 Z3") == pytest.approx([1, 2, 3])


def test_a_frame_that_is_appended_acts_within_that_of_torot():
    tilted = TILTED.format(0.3, 0.2, 0.9) + "TOROT\n"
    origin, axes = frame(tilted)
    shifted, same = frame(tilted + "ATRANS X4 Y1\n")
    assert shifted - origin == pytest.approx(axes @ [4, 1, 0], abs=1e-6) and same == pytest.approx(axes, abs=1e-8)


@pytest.mark.parametrize("call", ["TRAORI(1)", "TRAORI(1,0,0,1)", "TRAORI(1,0,0,1,0,0)", "TRAORI()", "TRAORI(2)"])
def test_traori_with_what_it_is_anyway(call):
    path = read(f"{call}\nG1 X5 Y3 Z1 A3=0.3 C3=0.9", "xyzac-trunnion", start=START)
    assert path.tip[-1] * 1e3 == pytest.approx([5, 3, 1])
    assert any(call in said for said in path.assumed) == (call == "TRAORI(2)")


def test_traori_with_more_is_refused():
    refused("TRAORI(1,0,1,0)\nG1 X0", "another direction of the tool")
    refused("TRAORI(1,,,,5)\nG1 X0", "offsets of the rotary axes")
    refused("TRAORI(0)\nG1 X0", "numbered from 1")
    refused("TRAORI(1.5)\nG1 X0", "whole number")


@pytest.mark.parametrize(
    ("mill", "call", "wanted"),
    [
        ("xyzbc-head", "ORIRESET(90,45)", {"C": 90, "B": 45}), ("xyzbc-head", "ORIRESET(,30)", {"C": 0, "B": 30}),
        ("xyzac-trunnion", "ORIRESET(30,90)", {"A": 30, "C": 90}), ("xyzac-trunnion", "ORIRESET()", {"A": 0, "C": 0}),
        ("xyzbc-nutating", "ORIRESET", {"B": 0, "C": 0}),
    ],
)  # fmt: skip
def test_orireset_moves_the_rotary_axes_and_keeps_the_tip(mill, call, wanted):
    """Job Planning, "ORIRESET", examples of machine kinematics CA: the axes in their order, zero where none is told."""
    letters = list(wanted)
    tilt = " ".join(f"{letter}=10" for letter in letters)
    path = read(f"TRAORI\nG1 X5 Y3 Z1 {tilt}\n{call}", mill, start=START)
    found = dict(zip(path.rotary_joints, np.degrees(path.rotary[-1])))
    assert found == pytest.approx(wanted)
    turning = path.tip[path.block == path.block.max()] * 1e3
    assert np.abs(turning - [5, 3, 1]).max() < 1e-6


def test_orireset_ignores_frames_of_rotary_axes():
    """ "Any active frames of rotary axes are ignored"."""
    path = read("TRANS C25\nTRAORI\nG1 X5 Y3 Z1 C=10\nORIRESET()", "xyzac-trunnion", start=START)
    assert path.rotary[-1] == pytest.approx([0, 0], abs=1e-12)


def test_orireset_that_is_refused():
    refused("ORIRESET()\nG1 X0", "alarm 14101")
    refused("TRAORI\nORIRESET(10)\nG1 X0", "ORIRESET with positions", "xyzbc-nutating")


def test_the_programmed_frame_is_written_and_read():
    """K2: $P_PFRAME acts at once; the frame that it tells may be changed and assigned again."""
    assert tip("TRANS X5\n$P_PFRAME=CTRANS(X,10):CROT(Z,90)\nG1 X1 Y0 Z0") == pytest.approx([10, 1, 0])
    assert tip("TRANS X5\n$P_PFRAME=$P_PFRAME:CROT(Z,90)\nG1 X1 Y0 Z0") == pytest.approx([5, 1, 0])
    assert tip("TRANS X5\nATRANS X1\n$P_PFRAME[X,TR]=8\nG1 X1 Y0 Z0") == pytest.approx([10, 0, 0])
    kept = "DEF FRAME OLD\nTRANS X5 Y2\nOLD=$P_PFRAME\nTRANS\n$P_PFRAME=OLD\nG1 X1 Y0 Z0"
    assert tip(kept) == pytest.approx([6, 2, 0])
    refused("TRANS C5\n$P_PFRAME=$P_PFRAME:CTRANS(X,1)\nG1 X1", r"\$P_PFRAME is not read")
    refused("$P_PFRAME[X,RT]=5\nG1 X1", "of the parts of a frame TR")


def test_a_subprogram_with_save_gives_frames_back():
    """Job Planning, "SAVE": the frame of the caller is in force again, whatever the subprogram made of it."""
    text = "TRANS X5\nATRANS X1\nSUB1\nG1 X1 Y0 Z0\nM30\nPROC SUB1 SAVE\n{}\nRET"
    inside = ("ROT Z90", "G500\n$P_PFRAME=CTRANS(X,50)", 'CYCLE800(0,"",0,57,9,0,0,30,0,0,0,0,0,0,0,1)')
    for frame in inside:
        assert tip(text.format(frame)) == pytest.approx([7, 0, 0])


def test_trans_behind_atrans_is_asked_about():
    """A table of NC Programming (at G58, G59) has the fine offset unchanged by TRANS, which else deletes old shifts."""
    path = read("TRANS X10\nATRANS X5\nTRANS X20\nG1 X1 Y0 Z0", "xyzac-trunnion", start=START)
    assert path.tip[-1, 0] * 1e3 == pytest.approx(21) and any("ends the shift of ATRANS" in s for s in path.assumed)
    path = read("TRANS X10\nATRANS X5\nTRANS\nTRANS X20\nG1 X1 Y0 Z0", "xyzac-trunnion", start=START)
    assert not any("ends the shift of ATRANS" in said for said in path.assumed)


def test_axial_shifts_beside_an_assigned_frame():
    """NC Programming 12/2019, table at G58, G59: [X,TR] is the part of TRANS and G58, [X,FI] that of ATRANS and G59."""
    assert tip("TRANS X10\n$P_PFRAME[X,FI]=3\nG58 X20\nG1 X0 Y0 Z0") == pytest.approx([23, 0, 0])
    assert tip("TRANS X10\nATRANS X5\n$P_PFRAME[X,TR]=20\nG59 X1\nG1 X0 Y0 Z0") == pytest.approx([21, 0, 0])
    refused("$P_PFRAME=CTRANS(X,10):CFINE(X,3)\nG58 X20\nG1 X0", r"G58 after \$P_PFRAME=")

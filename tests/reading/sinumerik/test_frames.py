"""Frames: TRANS, ROT, SCALE, MIRROR, settable offsets, CYCLE800 (Fundamentals 12; Function Manual K2)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sinumerik import START, last, machine, read
from toolpace.errors import ProgramError
from toolpace.reading.sinumerik.frames import solid


def test_trans_replaces_and_atrans_appends():
    """NC Programming, 2.12: TRANS, ROT, SCALE, MIRROR replace the whole programmed frame; the A forms append."""
    assert last("TRANS X10\nG1 X1") == [11, 0, 0]
    assert last("TRANS X10\nATRANS X5 Y1\nG1 X1 Y0") == pytest.approx([16, 1, 0])
    assert last("TRANS X10\nROT Z90\nG1 X1 Y0") == pytest.approx([0, 1, 0])
    assert last("TRANS X10\nAROT Z90\nG1 X1 Y0") == pytest.approx([10, 1, 0])
    assert last("TRANS X10\nAROT Z90\nATRANS X5\nG1 X1 Y0") == pytest.approx([10, 6, 0])
    assert last("TRANS X10\nROT Z90\nTRANS\nG1 X1 Y2") == [1, 2, 0]


def test_scale_and_mirror():
    assert last("SCALE X2 Y2 Z2\nG1 X3 Y1") == pytest.approx([6, 2, 0])
    assert last("TRANS X10\nAMIRROR X0\nG1 X3") == pytest.approx([7, 0, 0])
    path = read("MIRROR X0\nG2 X-10 Y10 I-10")
    middle = path.tip[len(path.tip) // 2] * 1e3
    assert np.hypot(middle[0] - 10, middle[1]) == pytest.approx(10, abs=1e-6) and middle[0] > 0


def test_one_rot_block_turns_about_z_then_y_then_x():
    """Fundamentals, 12.4: with MD10600 = 1 the order is Z, Y', X'' whatever the order of the words."""
    a, b, c = np.deg2rad([20, 30, 40])
    x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    z = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
    wanted = z @ y @ x @ [1, 2, 3]
    for words in ("ROT X20 Y30 Z40", "ROT Z40 X20 Y30", "ROT Z40\nAROT Y30\nAROT X20"):
        assert last(f"{words}\nG1 X1 Y2 Z3") == pytest.approx(wanted), words


def test_rot_in_the_plane():
    assert last("ROT RPL=90\nG1 X1 Y0") == pytest.approx([0, 1, 0])
    assert last("G18 ROT RPL=90\nG1 Z1 X0") == pytest.approx([1, 0, 0])


def test_solid_angles():
    """K2: with ROTS X Y the new X axis lies in the old ZX plane, and both edges of the plane have their angles."""
    rows = np.array(solid({"X": 20.0, "Y": 30.0}))[:, :3]
    assert rows @ rows.T == pytest.approx(np.eye(3)) and np.linalg.det(rows) == pytest.approx(1)
    assert rows[:, 0] == pytest.approx([math.cos(math.pi / 6), 0, -0.5])
    edge = np.cross([1, 0, 0], rows[:, 2])  # where the plane cuts the old YZ plane
    assert abs(math.degrees(math.atan2(edge[2], edge[1]))) == pytest.approx(160.0)
    for words, pair in (("Y20 Z30", "XY"), ("Z20 X30", "YZ")):
        letter = words[0]
        made = np.array(solid({words[0]: 20.0, words.split()[1][0]: 30.0}))[:, :3]
        slot = "XYZ".index(letter)
        out_of = ({0, 1, 2} - {"XYZ".index(x) for x in pair}).pop()
        assert abs(made[out_of, slot]) < 1e-12, words


def test_axial_shifts():
    """K2: G58 sets the coarse shift of an axis, G59 the fine one that ATRANS adds to; the others stay."""
    assert last("TRANS X10 Y5\nATRANS X1\nG58 X20\nG1 X0 Y0") == pytest.approx([21, 5, 0])
    assert last("TRANS X10\nATRANS X1\nG59 X2\nG1 X0") == pytest.approx([12, 0, 0])


def test_settable_offsets_that_the_program_writes():
    """K2: they work at the next G54; the first that is written is where the part is."""
    text = "$P_UIFR[1]=CTRANS(X,100,Y,50)\n$P_UIFR[2]=CTRANS(X,110,Y,50):CROT(Z,90)\nG54\nG1 X1 Y0\nG55\nX1 Y0"
    assert last(text) == pytest.approx([10, 1, 0])
    assert last("$P_UIFR[1,X,TR]=100\n$P_UIFR[5,X,TR]=103\nG505\nG1 X1") == pytest.approx([4, 0, 0])
    with pytest.raises(ProgramError, match=r"\$P_UIFR\[100\] does not exist"):
        read("$P_UIFR[100]=CTRANS(X,1)")


def test_frames_apply_under_traori():
    """Job Planning, 6.2: with TRAORI X, Y, Z are the tip in the workpiece, and frames apply; rotary words stay."""
    for angles in ("A0 C0", "A30 C50"):
        path = read(f"G0 {angles}\nTRAORI\nTRANS X10\nAROT Z90\nG1 X5 Y0 Z1", "xyzac-trunnion")
        assert path.tip[-1] * 1e3 == pytest.approx([10, 5, 1])


def swivelled(call: str, text: str = "G1 X1 Y2 Z3", on: str = "xyzac-trunnion"):
    return read(f"G0 Z100 A0 C0\n{call}\n{text}", on)


@pytest.mark.parametrize(
    ("mode", "steps"),
    [(57, "XYZ"), (45, "XZY"), (54, "YXZ"), (30, "YZX"), (39, "ZXY"), (27, "ZYX")],
)
def test_cycle800_turns_about_the_axes_of_its_mode(mode, steps):
    """Operating manuals, CYCLE800: _A, _B, _C are the angles of the 1st, 2nd, 3rd turn; shifts before and behind."""
    turn = np.eye(3)
    for axis, angle in zip(steps, (10.0, 20.0, 30.0)):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        i, j = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
        one = np.eye(3)
        one[i, i], one[i, j], one[j, i], one[j, j] = c, -s, s, c
        turn = turn @ one
    wanted = np.array([1, 2, 3]) + turn @ np.array([5, 7, 9])
    path = swivelled(f'CYCLE800(0,"",0,{mode},1,2,3,10,20,30,4,5,6,1,0,1)')
    assert path.tip[-1] * 1e3 == pytest.approx(wanted, abs=1e-6)
    assert path.axis[-1] == pytest.approx(turn[:, 2], abs=1e-9)


def test_cycle800_without_direction_turns_nothing():
    """_DIR 0: the frame alone."""
    path = swivelled('CYCLE800(0,"",0,57,0,0,0,0,0,90,0,0,0,0,0)', "G1 X1 Y0 Z0")
    assert path.tip[-1] * 1e3 == pytest.approx([0, 1, 0]) and np.ptp(path.rotary) == 0.0


def test_cycle800_direction_chooses_the_solution():
    mill = machine("xyzac-trunnion")
    tilts = []
    for direction in (-1, 1):
        path = swivelled(f'CYCLE800(0,"",0,57,0,0,0,20,0,0,0,0,0,{direction},0)')
        tilts.append(path.rotary[-1, path.rotary_joints.index("A")])
        assert path.axis[-1] == pytest.approx([0, -math.sin(math.radians(20)), math.cos(math.radians(20))])
    assert tilts[0] < 0 < tilts[1] and tilts[1] == pytest.approx(-tilts[0])
    assert mill.name == "xyzac-trunnion"


def test_cycle800_alone_and_additive():
    assert swivelled('CYCLE800(0,"",0,57,0,0,0,0,0,90,0,0,0,0,0)\nCYCLE800()').tip[-1] * 1e3 == pytest.approx([1, 2, 3])
    twice = 'CYCLE800(0,"",0,57,10,0,0,0,0,90,0,0,0,0,0)\nCYCLE800(0,"",1,57,5,0,0,0,0,0,0,0,0,0,0)'
    assert swivelled(twice, "G1 X0 Y0 Z0").tip[-1] * 1e3 == pytest.approx([10, 5, 0])


@pytest.mark.parametrize("mode", [128, 192])
def test_cycle800_by_projection_or_axes_is_refused(mode):
    with pytest.raises(ProgramError, match=r"CYCLE800 with .* is not read"):
        swivelled(f'CYCLE800(0,"",0,{mode},0,0,0,10,0,0,0,0,0,0,0)')


def test_cycle800_retracts_along_the_tool():
    path = read('G0 Z0 A0 C0\nCYCLE800(5,"",0,57,0,0,0,0,0,0,0,0,0,1,25,1)\nG1 X1', "xyzac-trunnion", start=START)
    assert path.tip[:, 2].max() * 1e3 == pytest.approx(25.0)

"""Frames: TRANS, ROT, SCALE, MIRROR, settable offsets, CYCLE800 (Fundamentals 12; Function Manual K2)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from testbed.true_tip.cases import BUILTIN as FOLDER
from testbed.true_tip.chain import Chain
from tests.support.sinumerik import START, last, machine, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.sinumerik.syntax.values import solid


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
    return read(f"G0 Z100\n{call}\n{text}", on)


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


def turn(axis, degrees):
    """Rotation matrix (3, 3) about X, Y or Z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    rows = {"X": [[1, 0, 0], [0, c, -s], [0, s, c]], "Y": [[c, 0, s], [0, 1, 0], [-s, 0, c]]}
    return np.array(rows.get(axis, [[c, -s, 0], [s, c, 0], [0, 0, 1]]))


def axes_of(call, on):
    """Axes (3, 3) in columns of the plane of a call, by four places."""
    ends = [swivelled(call, f"G1 X{x} Y{y} Z{z}", on).tip[-1] * 1e3 for x, y, z in ((0, 0, 0), *np.eye(3, dtype=int))]
    return np.array([end - ends[0] for end in ends[1:]]).T


@pytest.mark.parametrize(("direction", "turned"), [(1, ""), (0, "G0 A20 C40\n")])
def test_cycle800_by_axes_on_a_trunnion(direction, turned):
    """Operating manuals, "Swiveling plane", direct: _A and _B are axes 1 and 2; X, Y, Z are the machine's there."""
    call = f'CYCLE800(0,"",0,192,1,2,3,20,40,0,4,5,6,{direction},0,1)\n{turned}'
    wanted = turn("Z", 40) @ turn("X", 20)  # both joints of this table turn the other way round in space
    path = swivelled(call)
    assert path.tip[-1] * 1e3 == pytest.approx([1, 2, 3] + wanted @ [5, 7, 9], abs=1e-6)
    assert dict(zip(path.rotary_joints, np.degrees(path.rotary[-1]))) == pytest.approx({"A": 20, "C": 40})
    assert axes_of(call, "xyzac-trunnion") == pytest.approx(wanted, abs=1e-6)


IN_PLANE = 'CYCLE800(0,"",0,57,0,0,0,30,0,0,0,0,0,{},0,1)\n'


def test_rotary_words_in_a_plane_turn_the_axes_alone():
    """Without TRAORI nothing follows a rotary axis: X, Y and Z of the machine stay."""
    chain = Chain((FOLDER / "xyzac-trunnion.toml").read_text())
    path = swivelled(IN_PLANE.format(0) + "G0 A30 C20", "")
    joints = chain.joints(path.tip, dict(zip(path.rotary_joints, path.rotary.T)), chain.own_length)
    turned = joints[path.block == path.block.max()]
    assert len(turned) > 10 and np.ptp(turned[:, :3], axis=0).max() < 1e-9
    assert np.degrees(turned[-1, 3:]) == pytest.approx([30, 20])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (IN_PLANE.format(0) + "G1 X1", "not turned to"), (IN_PLANE.format(1) + "G0 C5\nG1 X1", "have moved since"),
        (IN_PLANE.format(1) + "G1 X1 C5", "rotary words beside X, Y, Z"),
        (IN_PLANE.format(0) + "CYCLE81(10,0,2,-5)", "not turned to"),
        (IN_PLANE.format(1) + "G0 C5\nHOLES1(0,0,0,5,5,3)", "have moved since"),
    ],
)  # fmt: skip
def test_a_plane_whose_axes_stand_elsewhere_is_refused(text, said):
    with pytest.raises(ProgramError, match=said):
        swivelled(text)
    # TRAORI knows where they are
    if "CYCLE81" not in text:
        swivelled(text.replace("G1 X1", "TRAORI\nG1 X1").replace("HOLES1", "TRAORI\nHOLES1"))


def test_cycle800_by_axes_on_a_head():
    """With a head and a table axis 1 is that of the head; where a head turns X otherwise than TOROT, it is refused."""
    call = 'CYCLE800(0,"",0,192,0,0,0,20,40,0,0,0,0,1,0,1)'
    assert axes_of(call, "xyzbc-millturn") == pytest.approx(turn("Z", 40) @ turn("Y", 20), abs=1e-6)
    for mill in ("xyzbc-head", "xyzbc-nutating"):
        with pytest.raises(ProgramError, match="X and Y there are not told"):
            swivelled(call, on=mill)
    assert axes_of(call.replace("20,40", "0,20"), "xyzbc-head") == pytest.approx(turn("Y", 20), abs=1e-6)


@pytest.mark.parametrize("mode", [185, 128 + 54])
def test_cycle800_by_projection_angles(mode):
    """Operating manuals: with XY and YX the new X axis lies in the old ZX plane; the third turn is about the new Z."""
    first, second = (20, 35) if mode == 185 else (35, 20)
    axes = axes_of(f'CYCLE800(0,"",0,{mode},0,0,0,{first},{second},25,0,0,0,1,0,1)', "xyzac-trunnion")
    x, z = axes @ turn("Z", -25)[:, 0], axes[:, 2]
    assert x == pytest.approx([math.cos(math.radians(35)), 0, -math.sin(math.radians(35))], abs=1e-6)
    in_yz = np.cross(z, [1, 0, 0])  # where the plane cuts the old YZ plane
    assert math.degrees(math.atan2(in_yz[2], in_yz[1])) == pytest.approx(20)


def test_cycle800_takes_the_other_solution_where_the_asked_one_is_out_of_travel():
    """Operating Manual Milling 08/2018: "the alternative position is automatically selected irrespective of" _DIR."""
    call = 'CYCLE800(0,"",0,57,0,0,0,0,70,0,0,0,0,{},0,1)'
    paths = [swivelled(call.format(direction), on="xyzbc-nutating") for direction in (-1, 1)]
    for path in paths:
        assert path.axis[-1] == pytest.approx([math.sin(math.radians(70)), 0, math.cos(math.radians(70))], abs=1e-9)
        assert path.rotary[-1, path.rotary_joints.index("B")] > 0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ('CYCLE800(0,"",0,128,0,0,0,10,0,0,0,0,0,0,0)', "_MODE does not name"),
        ('CYCLE800(0,"",0,192,0,0,0,10,0,5,0,0,0,0,0)', "a third rotary axis"),
        ('CYCLE800(0,"",1,192,0,0,0,10,0,0,0,0,0,0,0)', "upon another plane"),
        ('TRANS C5\nCYCLE800(0,"",0,192,0,0,0,10,0,0,0,0,0,0,0)', "which an offset shifts"),
        ('CYCLE800(0,"",100,57,0,0,0,10,0,0,0,0,0,0,0)', "its hundreds align a tool"),
        ('CYCLE800(0,"",0,57,0,0,0,10,0,0,0,0,0,0,0,2)', "CYCLE800 under G18"),
        ('G18\nCYCLE800(0,"",0,57,0,0,0,10,0,0,0,0,0,0,0)', "CYCLE800 under G18"),
        ('CYCLE800(5,"",0,57,0,0,0,10,0,0,0,0,0,1,-5)', "below zero"),
        ('CYCLE800(0,"",0,57,0,0,0,10,0,0,0,0,0,2)', "_DIR 2"),
        ('CYCLE800(0,"",0,64,0,0,0,10,20,5,0,0,0,1)', "a solid angle and a third one"),
    ],
)
def test_cycle800_that_is_refused(call, said):
    with pytest.raises(ProgramError, match=said):
        swivelled(call)


def test_cycle800_retracts_along_the_tool():
    path = read('G0 Z0 A0 C0\nCYCLE800(5,"",0,57,0,0,0,0,0,0,0,0,0,1,25,1)\nG1 X1', "xyzac-trunnion", start=START)
    assert path.tip[:, 2].max() * 1e3 == pytest.approx(25.0)


SHEET = SetUp(
    offsets={"G54": {"X": -0.4, "Y": -0.3, "Z": -0.5}}, machine_zero={"X": 0.5, "Y": 0.4, "Z": 0.6},
    tools={"1": Tool(0.1)},
)  # fmt: skip


def test_g500_counts_from_the_machine_zero_where_the_sheet_tells_offsets():
    """Fundamentals, "Settable work offset": G500 ends all of them, if it holds no values itself."""
    text = "T1 D1 M6\nG0 X0 Y0 Z0 A0 C0\nX10"
    g54, g500 = (read(text, "xyzac-trunnion", start=f"{g}\n", setup=SHEET) for g in ("G54", "G500"))
    assert g500.tip[-1] - g54.tip[-1] == pytest.approx([0.4, 0.3, 0.5])
    unsaid = read(text, "xyzac-trunnion", start="", setup=SHEET)
    assert any("names no settable offset" in said for said in unsaid.assumed)
    assert not any("names no settable offset" in said for path in (g54, g500) for said in path.assumed)


@pytest.mark.parametrize("text", ["{}TRAORI\nG1 X1 Y2 Z3", "TRAORI\n{}G1 X1 Y2 Z3"])
def test_a_plane_and_traori_together_are_said(text):
    path = read("G0 Z100\n" + text.format(IN_PLANE.format(1)), "xyzac-trunnion")
    assert any("TRAORI and a plane of CYCLE800 together" in said for said in path.assumed)
    assert path.tip[-1] * 1e3 == pytest.approx(turn("X", 30) @ [1, 2, 3], abs=1e-6)


def test_positions_of_a_plane_may_be_repeated_as_posts_round_them():
    """CYCLE800 turns to 45 and 35.2643897 degrees here; a whole turn of the table is the same place."""
    call = 'CYCLE800(0,"",0,64,0,0,0,45,54.7356103,0,0,0,0,1,0,1)\n'
    found = swivelled(call)
    angles = np.degrees(found.rotary[-1])
    words = " ".join(f"{x}={v:.3f}" for x, v in zip(found.rotary_joints, angles))
    assert not np.allclose(angles, np.round(angles, 3), rtol=0, atol=1e-6)
    again = swivelled(f"{call}G0 {words}\n")
    assert again.tip[-1] == pytest.approx(found.tip[-1], abs=1e-12) and any("repeat" in said for said in again.assumed)
    turned = dict(zip(found.rotary_joints, angles))["C"] + 360
    assert swivelled(f"{call}G0 C={turned:.12f}\n").tip[-1] == pytest.approx(found.tip[-1], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("ROT RPL=30 Z10", "ROT beside Z"), ("AROT RPL=30 X10", "AROT beside X"), ("TRANS X5 AP=30", "TRANS beside AP"),
        ("MIRROR X0 A3=1", "MIRROR beside A3"), ("G111 X5 Y5 B2=3", "G111 beside B2"), ("TRANS X=IC(5)", r"X=IC\(\)"),
    ],
)  # fmt: skip
def test_words_that_a_frame_leaves_over_are_no_motion(text, said):
    with pytest.raises(ProgramError, match=said):
        read(f"{text}\nG1 X5")

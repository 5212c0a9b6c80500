"""Motions: words, arcs, polar places, machine coordinates, feeds (Programming Manual Fundamentals; NC Programming)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sinumerik import START, ends, last, machine, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.setup_file import setup_of_text


def test_forms_of_words():
    """NC Programming, 2.9: AC() and IC() beat G90 and G91, in one word each."""
    assert last("G1 X10 Y5\nX=IC(5) Y=AC(1)\nG91 X=AC(3) Y2") == [3, 3, 0]
    assert last("R1=7\nG1X=R1+2Y=-R1Z.5") == pytest.approx([9, -7, 0.5])


def test_incremental_words_move_by_a_new_frame_too():
    """Function Manual K2: with SD42440 = 1, the default, a new offset moves the next distances as well."""
    assert last("G1 X10\nTRANS X100\nG91 X5") == [115, 0, 0]


def test_inch_and_metric_and_what_they_say_of_f():
    """Fundamentals, 3: G70 and G71 leave F alone, which is in the base unit; G700 and G710 take it along."""
    assert last("G70 G1 X1", start=START.replace(" F1000", "") + "F10\n") == pytest.approx([25.4, 0, 0])
    head = "G54 G64\n"
    assert read("G700 G0 X0 Y0 Z0\nG1 X1 F10", start=head).feed[-1] == pytest.approx(10 * 0.0254 / 60)
    assert read("G710 G0 X0 Y0 Z0\nG1 X1 F10", start=head).feed[-1] == pytest.approx(0.010 / 60)
    path = read("G70 G0 X0 Y0 Z0\nG1 X1 F10", start=head)
    assert path.feed[-1] == pytest.approx(10 * 0.0254 / 60)
    assert any("F under G70 is in inches" in sentence for sentence in path.assumed)


def test_ovr_is_the_share_of_f():
    """It lasts, scales an F that stands and one that comes, and leaves rapid motions and what F alone says."""
    path = read("G1 X1 F600\nX2 OVR=50\nX3 F200\nG0 X4\nG1 X5 OVR=100\nG93 X6 F2 OVR=50")
    last = np.flatnonzero(np.append(np.diff(path.block) != 0, True))[1:]
    assert path.feed[last][:5] * 60e3 == pytest.approx([600, 300, 100, np.inf, 200])
    assert path.least_time[last][5] == pytest.approx(60.0)  # half of two blocks a minute
    for share in ("0", "-5", "201"):
        with pytest.raises(ProgramError, match="share of F in percent"):
            read(f"G1 X1 OVR={share}")


@pytest.mark.parametrize(
    ("words", "end", "centre", "radius"),
    [
        ("G2 X10 Y10 I10 J0", (10, 10), (10, 0), 10),
        ("G2 X10 Y10 I=AC(10) J=AC(0)", (10, 10), (10, 0), 10),
        ("G2 X10 Y10 CR=10", (10, 10), (10, 0), 10),
        ("G3 X10 Y10 CR=-10", (10, 10), (10, 0), 10),
        ("G2 X10 Y10 AR=90", (10, 10), (10, 0), 10),
        ("G2 I10 J0 AR=90", (10, 10), (10, 0), 10),
        ("CIP X20 Y0 I1=10 J1=10", (20, 0), (10, 0), 10),
        ("G91 CIP X20 Y0 I1=10 J1=10", (20, 0), (10, 0), 10),
        ("G1 Y1\nCT X10 Y11", (10, 11), (10, 1), 10),
        ("G2 I10", (0, 0), (10, 0), 10),
        ("G111 X10 Y0\nG2 RP=10 AP=90", (10, 10), (10, 0), 10),
        ("G111 X10 Y0\nRP=10 AP=180\nG3 AP=90", (10, 10), (10, 0), 10),
        ("G111 X0 Y0\nG2 RP=10 AP=90 CR=10", (0, 10), (5 * 3**0.5, 5), 10),
    ],
)
def test_arcs(words, end, centre, radius):
    """Fundamentals, circular interpolation: centre and end, radius, opening angle, intermediate point, tangent."""
    path = read("X0 Y0\n" + words)
    assert path.tip[-1, :2] * 1e3 == pytest.approx(end, abs=1e-9)
    arc = path.tip[path.block == path.block[-1]]
    assert len(arc) > 10
    assert np.abs(np.hypot(arc[:, 0] * 1e3 - centre[0], arc[:, 1] * 1e3 - centre[1]) - radius).max() < 1e-6


def test_radii_below_zero_go_the_long_way_and_g3_turns_left():
    """Fundamentals: CR= above 0 is up to 180 degrees, below 0 beyond."""
    short, long_way = read("G2 X10 Y10 CR=10").tip, read("G2 X10 Y10 CR=-10").tip
    assert (short[:, 0] - short[:, 1]).max() <= 1e-12  # left of the chord
    assert np.linalg.norm(np.diff(long_way, axis=0), axis=1).sum() * 1e3 == pytest.approx(1.5 * math.pi * 10, rel=1e-4)


def test_turns_of_a_helix():
    """NC Programming, 2.9.7: TURN whole turns, then on to the end; the height rises evenly over all."""
    path = read("G2 X20 Y0 Z-25 I10 J0 TURN=2")
    turned = np.unwrap(np.arctan2(path.tip[:, 1], path.tip[:, 0] - 0.01))
    assert turned[-1] - turned[0] == pytest.approx(-5 * math.pi, abs=1e-9)
    half = np.argmin(np.abs(turned - turned[0] + 2.5 * math.pi))
    assert path.tip[half, 2] * 1e3 == pytest.approx(-12.5, abs=0.5)
    whole = read("G2 X0 Y0 Z-2 I10 TURN=1")
    assert np.ptp(np.unwrap(np.arctan2(whole.tip[:, 1], whole.tip[:, 0] - 0.01))) == pytest.approx(2 * math.pi)
    assert read("G2 X20 Z-1 I10 TURN=.5").assumed[-1].startswith("TURN=0.5 is the whole turn")
    with pytest.raises(ProgramError, match=r"TURN=0\.7 is not read"):
        read("G2 X20 Z-1 I10 TURN=.7")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("G2 X10 Y10", "the arc lacks its centre"),
        ("G2 X10 CR=3", "radius 3 mm is too small"),
        ("G2 X10 Y10 CR=10 I5", "an arc has CR, or I, J, K, not both"),
        ("G2 X10 Y0 K5 I5", "K has no meaning for an arc in the plane of G17"),
        ("G2 X10 Y10 I10 J1", "off its circle"),
        ("G2 X0 Y0 CR=5", "a full circle cannot be written"),
        ("CIP X10 Y10 I1=15 J1=15", "lie on a line"),
        ("CT X10", "CT needs a motion before it"),
        ("G1 X5 CR=5", "CR= is not read: it belongs to arcs"),
        ("G1 X5 X6", "X stands twice"),
        ("G1 X=DC(5)", r"X=DC\(\) is for rotary axes"),
        ("G1 X1e9", "is not read|beyond"),
        ("X=", "a value is missing before the end of the block"),
        ("(comment)", "comments begin with ;"),
        ("G1 X5 ?", r"'\?' has no meaning here"),
        ('MSG("open', "a text has no end"),
        ("G4", "G4 needs its time"),
        ("F0", "must be above zero"),
        ("SUPA G2 X5 CR=5", "reached with G0 or G1"),
    ],
)
def test_faults_name_their_line(words, said):
    with pytest.raises(ProgramError, match=rf"part\.mpf:3: .*(?:{said})"):
        read(words, "xyzac-trunnion")


def test_polar_places():
    """NC Programming, 4.3: G111 sets the pole in the workpiece, AP from the first axis of the plane, RP stays."""
    assert last("G111 X10 Y10\nG1 AP=90 RP=5") == pytest.approx([10, 15, 0])
    assert last("G111 X0 Y0\nG1 AP=0 RP=5\nAP=IC(90)") == pytest.approx([0, 5, 0])
    assert last("G1 X3\nG110 X1\nG112 Y2\nAP=180 RP=4") == pytest.approx([0, 2, 0])
    assert last("G18 G111 Z10 X0\nG1 AP=90 RP=5") == pytest.approx([5, 0, 10])


def test_rotary_words():
    """Function Manual R2: DC() the shortest way, ACP() and ACN() up and down; a plain value is gone to straight."""
    start = START + "G0 A0 C350\n"
    for words, wanted in (("C10", 10), ("C=DC(10)", 370), ("C=ACP(10)", 370), ("C=ACN(10)", 10), ("C=IC(-20)", 330)):
        path = read(f"G1 X1 {words}", "xyzac-trunnion", start=start)
        assert np.rad2deg(path.rotary[-1, path.rotary_joints.index("C")]) == pytest.approx(wanted), words
    assert np.rad2deg(read("G1 X1 C=ACN(20)", "xyzac-trunnion", start=start).rotary[-1]).max() == pytest.approx(20)


def test_rotary_words_need_their_machine():
    with pytest.raises(ProgramError, match="rotary word B needs the machine"):
        read("G1 B5")
    with pytest.raises(ProgramError, match="has no axis B"):
        read("G1 B5", "xyzac-trunnion")


def test_feeds():
    """Fundamentals, 7.1: G93 1/min, G94 mm/min, G95 mm a turn; between them F is forgotten."""
    assert read("G93 G1 X10 F2").least_time[-1] == pytest.approx(30.0)
    assert read("S1200 G95 G1 X10 F0.1").feed[-1] == pytest.approx(0.002)
    with pytest.raises(ProgramError, match="feed missing"):
        read("G95 G1 X10")
    assert read("G4 F2\nG1 X1\nG4 S10", start=START + "S60\n").dwell.tolist() == [2, 10]


def test_the_feed_of_one_block():
    """NC Programming, 7: FB holds in its own block, in the unit in force; behind it F does again."""
    path = read("G1 X10 F600\nX20 FB=300\nX30\nFB=120 X40\nX50")
    assert path.feed[-5:] * 60e3 == pytest.approx([600, 300, 600, 120, 600])
    with pytest.raises(ProgramError, match="above zero"):
        read("G1 X10 F600\nX20 FB=0")


def test_feed_per_tooth_is_kept_where_the_tool_changes_and_counts_its_teeth():
    """ "F = FZ * $TC_DPNT [...] is retained in modal format" (NC Programming, "Tooth feedrate (G95 FZ)")."""
    setup = setup_of_text("".join(f'[tools.{k}]\nkind = "flat"\ndiameter = 9\nteeth = {k + 2}\n' for k in (1, 2)))
    text = "T1 M6\nS600 M3\nG95 G1 X10 FZ=0.1\nT2 M6\nX20\nG95 X30 FB=0.2\nX40\nX50 F0.2\nG94 X60 F60"
    feeds = read(text, setup=setup).feed[-6:]
    assert feeds == pytest.approx([0.003, 0.004, 0.002, 0.004, 0.002, 0.001])
    for wrong, message in (("G1 X10 FZ=0.1", "needs G95"), ("G95 S9 G1 X10 FZ=0.1 F1", "F beside FZ")):
        with pytest.raises(ProgramError, match=message):
            read(wrong, setup=setup)


def test_stops():
    """Fundamentals, 5.2: G60 stops at every block, G9 at its own, G64 at none; M0 behind its block."""
    text = "G1 X1\nG9 X2\nX3\nM0\nX4\nG60 X5\nX6\nG642 X7\nX8"
    assert (read(text).stop.nonzero()[0]).tolist() == [0, 2, 3, 5, 6, 8]


def test_machine_coordinates():
    """Fundamentals, 3.6: G53, G153 and SUPA name machine coordinates in their block alone."""
    setup = SetUp(machine_zero={"X": 0.0, "Y": 0.0, "Z": 0.0}, offsets={"G54": {"X": 0.1, "Y": 0.2, "Z": 0.0}})
    mill = machine("xyzac-trunnion")
    path = read("G0 X0 Y0 Z0 A0 C0\nSUPA G0 X5 Y6\nG1 X1", "xyzac-trunnion", setup=setup, start="G54 G64 F1000\n")
    q = np.zeros((2, 5))
    q[:, [mill.joints.index(x) for x in "XY"]] = [[0.1, 0.2], [0.005, 0.006]]
    tip, _ = mill.forward(q)
    assert (path.tip[1] - path.tip[0])[:2] * 1e3 == pytest.approx(((tip[1] - tip[0])[:2]) * 1e3, abs=1e-6)
    assert path.rapid[1] and not path.rapid[2]


def test_retracts_without_a_machine_are_passed_over_and_said():
    path = read("G1 X1\nSUPA G0 Z0 D0\nG1 X2")
    assert path.tip[-1].tolist() == [0.002, 0, 0] and any("passed over" in said for said in path.assumed)


def test_references():
    """Fundamentals, G74: the reference point by the names of machine axes, whose values do not count."""
    path = read("G1 X10\nG74 Z1=0", "xyzac-trunnion", start=START + "A0 C0\n")
    assert path.stop[-1] and path.tip[-1, 2] > 0.05
    assert any("upper ends of the travel" in said for said in path.assumed)


def test_tools_and_operations():
    path = read('T="MILL 8"\nM6\nMSG("ROUGH")\nG1 X1\nT2 D1\nX2\nM6\nX3')
    assert [(o.name, o.tool) for o in path.operations] == [("", ""), ("ROUGH", "MILL 8"), ("ROUGH", "2")]
    assert path.operation.tolist() == [0, 1, 1, 2]
    assert [o.tool for o in read("T5\nG1 X1").operations] == ["", "5"]


def test_two_tools_are_two_lengths():
    setup = SetUp(tools={"1": Tool(0.1), "2": Tool(0.15)})
    path = read("T1 M6\nG1 X1 Z5 D1\nT2 M6\nG1 X2 Z5", "xyzac-trunnion", setup=setup, start=START + "A0 C0\n")
    mill = machine("xyzac-trunnion")
    cut = path.block >= 5
    z = mill.joints_at(path.tip, path.rotary, path.tool_length)[cut, mill.joints.index("Z")] * 1e3
    assert path.tip[cut, 2] * 1e3 == pytest.approx(5.0)
    assert np.ptp(z) == pytest.approx(50.0)
    assert path.tool_length[cut].tolist() == [0.1, 0.15]


def test_radius_compensation():
    """G41 with a tool of no radius, or for a CAM system's path of the centre, is the programmed contour."""
    assert read("G41 G1 X5\nG40 X6", compensation="program").assumed
    assert last("T1 M6\nG41 G1 X5\nG40 X6", setup=SetUp(tools={"1": Tool(0.1, 0.0)})) == [6, 0, 0]
    assert last("D0 G41 G1 X5\nG40 X6") == [6, 0, 0]
    with pytest.raises(ProgramError, match="G41 is not read: the tool's radius is not known"):
        read("G41 G1 X5")


def test_variables_of_the_control():
    assert last("G1 X7\nY=$P_EP[X]+1 Z=$AA_IW[X]") == [7, 8, 7]
    assert last("IF $P_SEARCH==FALSE\nG1 X5\nENDIF") == [5, 0, 0]
    with pytest.raises(ProgramError, match=r"\$A_IN is not read"):
        read("G1 X=$A_IN[3]")


def test_ends_lists_the_ends_of_blocks():
    assert ends("G1 X1\nY2").tolist() == [[0, 0, 0], [1, 0, 0], [1, 2, 0]]


@pytest.mark.parametrize(("angle", "turns"), [(20, 1), (40, 2), (70, 3), (50, 5), (10, 1)])
def test_an_axis_that_stands_there_up_to_rounding_does_not_turn(angle, turns):
    """ACP() and ACN() to the angle at which it is, some turns on: no turn, neither up nor down."""
    stands = angle + 360 * turns
    for form in ("ACP", "ACN", "DC"):
        path = read(f"G1 X1 C={form}({angle})", "xyzac-trunnion", start=f"{START}G0 A0 C{stands}\n")
        assert np.rad2deg(path.rotary[-1, path.rotary_joints.index("C")]) == pytest.approx(stands), form


def test_cip_through_a_point_of_the_straight_way_is_straight():
    """Diagnostics Guide, 14920: with the point between start and end, and no TURN, a straight line is generated."""
    assert last("CIP X10 Y10 I1=5 J1=5") == pytest.approx([10, 10, 0])
    with pytest.raises(ProgramError, match="lie on a line"):
        read("CIP X10 Y10 I1=5 J1=5 TURN=1")


@pytest.mark.parametrize("block", ["SUPA G0 Z0 D0", "G53 G0 X0", "G74 Z1=0", "G75 FP=1 Z1=0"])
def test_machine_coordinates_under_traori_are_refused(block):
    """Fundamentals: G53, G153, SUPA suppress frames, no transformation; at G74 and G75 none may be active."""
    with pytest.raises(ProgramError, match="TRAFOOF before"):
        read(f"TRAORI\nG1 X5\n{block}", "xyzac-trunnion")
    assert read(f"TRAORI\nG1 X5\nTRAFOOF\n{block}", "xyzac-trunnion").tip.shape[1] == 3


def test_modal_rounding_in_a_block_of_its_own():
    """NC Programming, "Chamfer, rounding": RNDM is modal, RNDM=0 ends it."""
    modal = read("RNDM=2\nG1 X10\nY10\nRNDM=0\nX0\nY0")
    alone = read("G1 X10 RND=2\nY10 RND=2\nX0\nY0")
    assert modal.tip == pytest.approx(alone.tip)


@pytest.mark.parametrize("block", ["X5 CYCLE81(9,0,2,-5)", "CYCLE81(9,0,2,-5)X5", "TRAORI X5", "HOLES1(0,0,0,5,5,9)Y2"])
def test_axes_beside_a_cycle_are_refused(block):
    """Which of them is first is told nowhere; a cycle and a transformation stand in blocks of their own."""
    with pytest.raises(ProgramError, match="write two blocks"):
        read(f"G1 X1 F100\n{block}", "xyzac-trunnion")
    assert len(read('G1 X1\nMSG("A") X5').tip)

"""What words of coordinates and planes mean to each controller: expectations by hand, with the manual cited."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.controllers import read_for, tips, with_options
from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

START = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0\n"
WORDS = [name for name in Controller.names() if Controller.load(name).language == "word-address"]


def ends(path) -> np.ndarray:
    """Tips at the ends of blocks [mm]."""
    return path.tip[np.flatnonzero(np.diff(path.block, append=-1))] * 1e3


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        ("G52 X10. Y5.\nG1 X1. Y1.\nG52 X0. Y0.\nX1.", [[0, 0, 0], [11, 6, 0], [1, 6, 0]]),
        ("G92 X5.\nG1 X6.\nG92.1\nX6.", [[0, 0, 0], [1, 0, 0], [6, 0, 0]]),
        ("G68 X0. Y0. R90.\nG1 X2. Y0.\nG69\nX5.", [[0, 0, 0], [0, 2, 0], [5, 2, 0]]),
        ("G68 X1. Y1. R180.\nG1 X0. Y0.\nG69", [[0, 0, 0], [2, 2, 0]]),
        ("G16\nG1 X10. Y90.\nY180.\nG15\nX1. Y0.", [[0, 0, 0], [0, 10, 0], [-10, 0, 0], [1, 0, 0]]),
        ("G16\nG1 X10. Y30.\nG91 Y60.\nY90.\nG90\nG15\nX1. Y0.",
         [[0, 0, 0], [8.660254, 5, 0], [0, 10, 0], [-10, 0, 0], [1, 0, 0]]),
        ("G51 X0. Y0. Z0. P2000\nG1 X3. Y1.\nG50\nX3.", [[0, 0, 0], [6, 2, 0], [3, 2, 0]]),
        ("G51 X0. Y0. Z0. I-1000 J1000 K1000\nG1 X3. Y1.\nG50", [[0, 0, 0], [-3, 1, 0]]),
        ("G51.1 X2.\nG1 X3. Y1.\nG50.1 X0.\nX3.", [[0, 0, 0], [1, 1, 0], [3, 1, 0]]),
        ("G10 L2 P1 X100.\nG10 L2 P2 X130.\nG54\nG1 X1.\nG55\nX1.", [[0, 0, 0], [1, 0, 0], [31, 0, 0]]),
        # L20 tells G54.1
        ("G54\nG10 L20 P1 X5.\nG1 X6.", [[0, 0, 0], [6, 0, 0]]),
        ("G54.1 P1\nG10 L20 P1 X100.\nG10 L20 P2 X130.\nG1 X1.\nG54.1 P2\nX1.", [[0, 0, 0], [1, 0, 0], [31, 0, 0]]),
    ],
)  # fmt: skip
def test_frames_of_fanuc(body, wanted):
    """Fanuc 16i operator's manual: G52 7.2.4, G92 7.2.1, G68 14.5, G16 13.3, G51 14.7 (1000 is life size), G51.1,
    G10 L2 and L20 7.2.3. Without a set-up sheet the first offset that is set is where the part's origin is."""
    assert tips("fanuc", START + body + "\nM30") == wanted


@pytest.mark.parametrize("name", ["fanuc", "haas", "mazak", "linuxcnc", "iso"])
def test_a_block_without_a_centre_behind_an_arc_is_no_straight_way_unless_the_machine_says_so(name):
    """Alarm 022 of Fanuc's list. A parameter of the machine may let it go straight, at the feed that is in force."""
    body = f"{START}G2 X10 Y0 I5 J0\nG43 Z4 H1\nG1 X20\nM30"
    sheet = SetUp(tools={"1": Tool(MACHINE.tool_length)})
    with pytest.raises(ProgramError, match=r"lacks its centre: .* for a straight way G0 or G1, since G2"):
        read_for(name, body, MACHINE, setup=sheet)
    path = read_for(with_options(name, arc_without_centre="straight"), body, MACHINE, setup=sheet)
    np.testing.assert_allclose(ends(path)[-2:], [[10.0, 0.0, 4.0], [20.0, 0.0, 4.0]], atol=1e-9)
    np.testing.assert_allclose(path.feed[-2:], 0.01, rtol=1e-12)
    assert not path.rapid[-2:].any()


@pytest.mark.parametrize(("plane", "words", "wanted"), [
    ("G17", "X2. Y0 Z0", [0, 2, 0]), ("G17", "X0 Y2. Z0", [-2, 0, 0]), ("G17", "X0 Y0 Z2.", [0, 0, 2]),
    ("G18", "X0 Y0 Z2.", [2, 0, 0]), ("G18", "X2. Y0 Z0", [0, 0, -2]), ("G18", "X0 Y2. Z0", [0, 2, 0]),
    ("G19", "X0 Y2. Z0", [0, 0, 2]), ("G19", "X0 Y0 Z2.", [0, -2, 0]), ("G19", "X2. Y0 Z0", [2, 0, 0]),
])  # fmt: skip
def test_g68_turns_the_plane_that_is_in_force(plane, words, wanted):
    """Fanuc 16i operator's manual, 14.5: counterclockwise in the plane, of which the first axis is X of G17, Z of G18,
    Y of G19; a quarter turn brings the first axis onto the second, and leaves the third."""
    body = f"G90 G21 G94 {plane} F600\nG0 X0 Y0 Z0\nG68 R90.\nG1 {words}\nM30"
    assert tips("fanuc", body)[-1] == wanted


def test_g10_l20_of_the_generic_control_calls_the_place_in_the_kind_of_offset_in_force():
    """LinuxCNC, G Codes, "G10 L20": the value is such that the present place becomes the value given; while G54.1 is in
    force P is one of these."""
    body = "G54.1 P2\nG0 X1.\nG10 L20 P3 X5.\nG54.1 P3\nG1 X6.\nG54\nX6."
    assert tips("iso", START + body)[1:] == [[1, 0, 0], [2, 0, 0], [6, 0, 0]]


def test_g10_l20_of_haas_tells_g154_and_needs_its_number():
    """Haas mill operator's manual, G10: L20 is of the auxiliary offsets, G154 P1 to P99."""
    body = START + "G154 P1\nG10 L20 P1 X100.\nG10 L20 P2 X130.\nG1 X1.\nG154 P2\nX1.\nG54\nX3."
    assert tips("haas", body)[1:] == [[1, 0, 0], [31, 0, 0], [3, 0, 0]]
    with pytest.raises(ProgramError, match="needs the number of an offset G154 as P"):
        tips("haas", START + "G154 P1\nG10 L20 X1.\nG1 X1.")


def test_an_arc_in_mirrored_coordinates_turns_the_other_way():
    path = read_for("fanuc", "G90 G21 G17 F600\nG0 X10. Y0. Z0.\nG51.1 X0.\nG1 X10.\nG3 X0. Y10. I-10. J0.\nM30")
    angle = np.unwrap(np.arctan2(path.tip[1:, 1], path.tip[1:, 0]))
    assert angle[-1] - angle[0] == pytest.approx(-math.pi / 2)


def test_work_offsets_are_those_of_the_set_up_sheet():
    """Offsets are machine coordinates of the part's origin; axis words are joints without tip mode."""
    sheet = SetUp(offsets={"G54": {"X": 0.1, "Y": 0.0, "Z": 0.0}, "G54.1 P2": {"X": 0.13, "Y": 0.01, "Z": 0.0}},
                  machine_zero={"X": 0.0, "Y": 0.0, "Z": 0.0})  # fmt: skip
    path = read_for("fanuc", "G90 G21 F600\nG54 G0 X0. Y0. Z0.\nG1 X1.\nG54.1 P2 X1. Y1.\nM30", MACHINE, setup=sheet)
    assert np.diff(ends(path), axis=0) == pytest.approx(np.array([[1, 0, 0], [30, 11, 0]]))


def test_g43_h_shifts_by_the_length_of_the_table_and_two_tools_are_two_lengths():
    """Fanuc 16i, 14.1 "Tool length offset": the tip stands where Z says, the joint is higher by the length."""
    sheet = SetUp(tools={"1": Tool(0.1), "2": Tool(0.15)}, machine_zero={"Z": 0.0})
    body = "G90 G21 F600\nT1 M6\nG43 H1 G0 X0. Y0. Z10.\nG1 X1.\nT2 M6\nG43 H2 Z10.\nG1 X2.\nM30"
    machine = Machine.load("xyzac-trunnion")
    path = read_for("fanuc", body, machine, setup=sheet)
    assert ends(path)[:, 2].tolist() == pytest.approx([10, 10, 10, 10])
    z = machine.joints_at(path.tip, path.rotary, path.tool_length)[:, machine.joints.index("Z")] * 1e3
    assert np.diff(z).tolist() == pytest.approx([0, 50, 0])
    # when the tool is changed the joints stay, and the tip of the longer one is 50 mm lower
    assert path.stop.tolist() == [True, True, False, True] and path.way[2].tolist() == pytest.approx([0, 0, 0.05])
    plain = read_for("fanuc", body.replace("G43 H1", "").replace("G43 H2", ""), machine)
    assert np.ptp(plain.tip[:, 2]) == pytest.approx(0)


# --- places of the machine --------------------------------------------------------------------------------------

SHEET = SetUp(machine_zero={"X": 0.5, "Y": 0.4, "Z": 0.3}, references={1: {"X": 0, "Y": 0, "Z": 0}, 2: {"Z": -0.1}})


def test_g28_goes_over_the_place_named_to_the_reference_point_with_the_axes_named():
    """Fanuc 16i, 6.1 "Reference position return": over the intermediate point, only the axes commanded."""
    path = read_for("fanuc", START + "G1 X10.\nG91 G28 Z5.\nG28 X0. Y0.\nM30", MACHINE, setup=SHEET)
    joints = path.tip * 1e3
    assert joints.tolist()[1:] == pytest.approx(np.array([[10, 0, 0], [10, 0, 5], [10, 0, 300], [500, 400, 300]]))
    assert path.rapid[2:].all() and path.stop[[3, 4]].all()


def test_g30_g53_and_g29():
    """Fanuc 16i, 6: G30 to the second reference point (P2); G29 back over the intermediate point. 7.1: G53."""
    path = read_for("fanuc", START + "G91 G30 P2 Z0.\nG90 G53 G0 X-100. Y0.\nG1 X0. Y0. Z0.\nM30", MACHINE, setup=SHEET)
    assert ends(path)[1:].tolist() == pytest.approx(np.array([[0, 0, 200], [400, 400, 200], [0, 0, 0]]))
    path = read_for("fanuc", START + "G28 Z20.\nG29 X5. Z1.\nM30", MACHINE, setup=SHEET)
    assert (path.tip * 1e3).tolist()[1:] == pytest.approx(np.array([[0, 0, 20], [0, 0, 300], [0, 0, 20], [5, 0, 1]]))


def test_a_bare_g53_is_nothing_and_g28_without_axes_goes_home_where_it_does():
    """Posts for Fanuc write G53 alone; G28 without axes moves all of them on LinuxCNC and Haas, none on Fanuc."""
    assert ends(read_for("fanuc", START + "G1 X1.\nG53\nG28\nX2.\nM30", MACHINE, setup=SHEET))[-1].tolist() == [2, 0, 0]
    path = read_for("linuxcnc", START + "G1 X1\nG28\nM2", MACHINE, setup=SHEET)
    assert ends(path)[-1] == pytest.approx([500, 400, 300])


# --- five axes --------------------------------------------------------------------------------------------------


def test_g43_4_fixes_its_frame_where_the_table_stands_on_fanuc():
    """Fanuc A-79348E: the frame of tool centre point control is fixed to the table where G43.4 is read."""
    body = "G90 G21 F600\nG0 A0. C90.\nG43.4 H1 X10. Y0. Z0.\nG1 X20.\nM30"
    a, b = ends(read_for("fanuc", body, MACHINE))[-2:], ends(read_for("haas", body, MACHINE))[-2:]
    assert any("where the table stands turned" in told for told in read_for("fanuc", body, MACHINE).assumed)
    at_zero = read_for("fanuc", body.replace("C90.", "C0."), MACHINE)
    assert not any("where the table stands turned" in told for told in at_zero.assumed)
    assert np.abs(b - [[10, 0, 0], [20, 0, 0]]).max() < 1e-9
    assert np.abs(np.linalg.norm(a, axis=1) - [10, 20]).max() < 1e-9 and np.abs(a[:, 0]).max() < 1e-9


def test_g43_5_takes_the_tool_axis():
    """Fanuc A-79348E: I J K are the tool axis at the end of the block, in the frame of the table."""
    path = read_for("fanuc", "G90 G21 F600\nG43.5 H1\nG0 X0. Y0. Z0. I0 J0 K1.\nG1 X10. I0 J1. K2.\nX20.\nM30", MACHINE)
    assert path.axis[-1] == pytest.approx(np.array([0, 1, 2]) / math.sqrt(5))
    with pytest.raises(ProgramError, match="tool axis I, J, K is zero"):
        read_for("fanuc", "G90 G43.5 H1\nG0 X0. Y0. Z0. I0 J0 K0\nM30", MACHINE)


def test_g68_2_lays_the_coordinates_into_a_plane_and_g53_1_turns_the_tool_to_it():
    """Fanuc 30i, "Tilted working plane": R = Rz(I) Rx(J) Rz(K) about X Y Z; Z is then along the tool."""
    body = "G90 G21 F600\nG0 X0. Y0. Z50.\nG68.2 X10. Y0. Z5. I0. J30. K0.\nG53.1\n"
    body += "G0 X0. Y0. Z20.\nG1 Z0.\nG1 Y7.\nG69\nM30"
    path = read_for("fanuc", body, Machine.load("xyzac-trunnion"))
    normal = np.array([0, -math.sin(math.radians(30)), math.cos(math.radians(30))])
    assert path.axis[-1] == pytest.approx(normal)
    along = np.array([0, math.cos(math.radians(30)), math.sin(math.radians(30))])
    at = np.array([10, 0, 5])
    assert ends(path)[-3:] == pytest.approx(np.array([at + 20 * normal, at, at + 7 * along]), abs=1e-9)


def test_g254_keeps_axes_parallel_to_the_machine_and_carries_the_origin():
    """Haas, G254 "Dynamic work offset": the part's origin goes with the table, X Y Z stay the machine's."""
    machine = Machine.load("xyzac-trunnion")
    body = "G90 G21 F600\nG0 X0. Y0. Z100.\nG0 A-90. C0.\nG254\nG0 X0. Y0. Z30.\nG1 Z10.\nX5.\nG255\nM30"
    path = read_for("haas", body, machine)
    axis = path.axis[-1]
    assert ends(path)[-2] == pytest.approx(10 * axis, abs=1e-9)
    assert ends(path)[-1] == pytest.approx(10 * axis + [5, 0, 0], abs=1e-9)


def test_g7_of_millplus_tilts_turns_the_axes_and_tells_them():
    """Autodesk's post-processor for MillPlus: A5 B5 C5 about fixed axes, B7 and C7 take the angles, L1=1 turns."""
    machine = Machine.load("xyzbc-trunnion")
    body = "G71 G90 G94 F600\nG0 X0. Y0. Z50.\nG93 X10. Y0. Z0.\nG7 B5=30. B7=254 C7=255\n"
    body += "G0 B=E254 C=E255\nX0. Y0. Z20.\nG1 Z0.\nM30"
    path = read_for("millplus", body, machine)
    normal = np.array([math.sin(math.radians(30)), 0, math.cos(math.radians(30))])
    assert path.axis[-1] == pytest.approx(normal)
    assert ends(path)[-2:] == pytest.approx(np.array([[10, 0, 0] + 20 * normal, [10, 0, 0]]), abs=1e-9)

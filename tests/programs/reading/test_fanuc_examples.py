"""Worked examples of Fanuc's and Haas' manuals, position by position.

Programs and what each shows are from the operator's manuals B-63944EN and B-63944EN-2 (30i), which have them as those
of the 16i (B-63534EN) and 16 (B-62764EN) do; the chapter begins each docstring. Positions are worked out here from its
figures.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import toolpace as tp
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.setup_file import setup_of_text

UNITS = '[units]\nlength = "mm"\nangle = "deg"\n'
ZERO = "[machine_zero]\nX = 0\nY = 0\nZ = 0\n"


def read(text, controller="fanuc", sheet="", machine=None, compensation=""):
    setup = setup_of_text(UNITS + sheet) if sheet else None
    body = f"%\nO0001\nG21 G90 G94 G17 G40 F1000.\n{text}\nM30\n%\n"
    return tp.read_text(body, machine, setup=setup, controller=controller, compensation=compensation)


def ends(path):
    """(k, 3) the place at the end of each block that moves [mm], one after the other."""
    last = np.flatnonzero(np.diff(path.block, append=-1))
    return path.tip[last] * 1e3


def turned(degrees, x, y):
    """A point (2,) turned about zero."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([c * x - s * y, s * x + c * y])


def planar(found, wanted):
    """Whether X and Y (k, 2) are those wanted, at the end."""
    wanted = np.asarray(wanted, float)
    assert found[-len(wanted) :, :2] == pytest.approx(wanted, abs=1e-6)


def test_absolute_and_incremental_programming():
    """Absolute and incremental programming (G90, G91): from (100, 30) to (40, 70), both ways."""
    for words in ("G90 X40.0 Y70.0", "G91 X-60.0 Y40.0"):
        planar(ends(read(f"G0 X100. Y30. Z0.\nG1 {words}")), [[40.0, 70.0]])


@pytest.mark.parametrize(
    "blocks",
    [
        "G90 G03 X140.0 Y100.0 R60.0\nG02 X120.0 Y60.0 R50.0",
        "G90 G03 X140.0 Y100.0 I-60.0\nG02 X120.0 Y60.0 I-50.0",
        "G91 G03 X-60.0 Y60.0 R60.0\nG02 X-20.0 Y-40.0 R50.0",
        "G91 G03 X-60.0 Y60.0 I-60.0\nG02 X-20.0 Y-40.0 I-50.0",
    ],
)
def test_circular_interpolation(blocks):
    """Circular interpolation (G02, G03), its example: from (200, 40) about (140, 40), then about (90, 100)."""
    path = read(f"G92 X200.0 Y40.0 Z0\nG1 X200.0 Y40.0 Z0\n{blocks}")
    # G92 tells where the tool is: the first words stand for the machine's zero
    begin = np.array([200.0, 40.0, 0.0])
    tip = path.tip * 1e3 + begin
    planar(ends(path) + begin, [[200.0, 40.0], [140.0, 100.0], [120.0, 60.0]])
    last = path.block.max()
    for block, centre, radius in ((last - 1, (140.0, 40.0), 60.0), (last, (90.0, 100.0), 50.0)):
        rows = path.block == block
        assert rows.sum() > 5
        assert np.hypot(*(tip[rows, :2] - centre).T) == pytest.approx(radius, abs=1e-3)


def test_return_to_and_from_the_reference_point():
    """Automatic return to reference point and return from it (G28, G29): from A over B to R, and over B to C."""
    sheet = f"{ZERO}[offsets.G54]\nX = 0\nY = 0\nZ = 0\n[references.1]\nX = 1500\nY = 700\nZ = 400\n"
    machine = tp.Machine.load("xyzbc-trunnion")
    body = "G54\nG90 G0 X200. Y300. Z100. B0 C0\nG28 X1000.0 Y500.0\nM1\nG29 X1300.0 Y200.0\nM1"
    path = read(body, sheet=sheet, machine=machine)
    q = np.asarray(machine.joints_at(path.tip, path.rotary, path.tool_length))[:, :3] * 1e3
    kept = [q[0], *(b for a, b in pairwise(q) if np.abs(a - b).max() > 1e-6)]
    wanted = [[200, 300], [1000, 500], [1500, 700], [1000, 500], [1300, 200]]
    assert np.array(kept)[:, :2] == pytest.approx(np.array(wanted, float), abs=1e-6)
    assert np.array(kept)[:, 2] == pytest.approx(100.0, abs=1e-6)


def test_setting_a_workpiece_coordinate_system():
    """Setting a workpiece coordinate system (G92): G92 X25.2 Z23.0, and G92 X600.0 Z1200.0."""
    for x, z in ((25.2, 23.0), (600.0, 1200.0)):
        found = ends(read(f"G0 X0 Y0 Z0\nG92 X{x} Z{z}\nG90 G0 X0 Z0"))
        assert found[-1] == pytest.approx([-x, 0.0, -z], abs=1e-9)


def test_changing_a_workpiece_coordinate_system():
    """Changing workpiece coordinate system: at (200, 160) of G54 G92 X100 Y100 shifts both
    G54 and G55 by (100, 60)."""
    sheet = "[offsets.G54]\nX = 0\nY = 0\nZ = 0\n[offsets.G55]\nX = 300\nY = 100\nZ = 0\n"
    found = ends(read("G54\nG0 X200. Y160. Z0.\nG92 X100. Y100.\nG0 X0. Y0.\nG55 X0. Y0.", sheet=sheet))
    planar(found, [[200.0, 160.0], [100.0, 60.0], [400.0, 160.0]])


def test_selecting_a_workpiece_coordinate_system():
    """Selecting a workpiece coordinate system: G90 G55 G00 X40.0 Y100.0."""
    sheet = "[offsets.G54]\nX = 0\nY = 0\nZ = 0\n[offsets.G55]\nX = 300\nY = 50\nZ = 0\n"
    planar(ends(read("G54\nG0 X0 Y0 Z0\nG90 G55 G00 X40.0 Y100.0", sheet=sheet)), [[340.0, 150.0]])


@pytest.mark.parametrize("angles", ["Y150.0\nY270.0", "G91 Y120.0\nY120.0"])
def test_bolt_holes_by_polar_coordinates(angles):
    """Polar coordinate command (G15, G16), its bolt-hole circle: radius 100 at 30, 150 and 270 degrees."""
    path = read(f"G0 X0 Y0 Z10.\nG17 G90 G16\nG81 X100.0 Y30.0 Z-20.0 R-5.0 F200.0\n{angles}\nG15 G80")
    bottoms = path.tip[np.abs(path.tip[:, 2] + 20e-3) < 1e-9] * 1e3
    wanted = [[100 * math.cos(math.radians(a)), 100 * math.sin(math.radians(a))] for a in (30, 150, 270)]
    assert bottoms[:, :2] == pytest.approx(np.array(wanted), abs=1e-6)


@pytest.mark.parametrize("incremental", [False, True])
def test_coordinate_system_rotation(incremental):
    """Coordinate system rotation (G68, G69), its example with an absolute and an incremental command in N3.

    With the incremental one the tool is the centre; else it is (700, 300).
    """
    third = "G91 X0 Y0" if incremental else "G90 G01 X0 Y0"
    blocks = (
        f"N1 G92 X-500.0 Y-500.0 Z0 G69 G17\nN2 G68 X700.0 Y300.0 R60.0\nN3 {third} F200\nN4 G91 G01 X1000.0\n"
        "N5 G02 Y1000.0 R1000.0\nN6 G03 X-1000.0 I-500.0 J-500.0\nN7 G01 Y-1000.0\nN8 G69 G90 X-500.0 Y-500.0"
    )
    found = ends(read(blocks))[:, :2] - 500.0
    centre = np.array([700.0, 300.0])
    begin = np.array([-500.0, -500.0]) if incremental else centre + turned(60.0, *-centre)
    steps = [(1000.0, 0.0), (0.0, 1000.0), (-1000.0, 0.0), (0.0, -1000.0)]
    wanted = begin + np.cumsum([[0.0, 0.0], *(turned(60.0, *step) for step in steps)], axis=0)
    planar(found, wanted[1:] if incremental else [*wanted, [-500.0, -500.0]])


def test_repetitive_commands_for_rotation():
    """Repetitive commands for coordinate system rotation, whose angle is incremental (parameter 5400#0 is 1): the
    contour of O2100 at 0, 45, .. 315 degrees."""
    main = (
        "G92 X0 Y0 Z0 G69 G17\nG01 F200\nM98 P2100\nM98 P072200\nG00 G90 X0 Y0\nM30\n"
        "O2200 G68 X0 Y0 G91 R45.0\nG90 M98 P2100\nM99\n"
        "O2100 G90 G01 G42 X0 Y-10.0\nX4.142\nX7.071 Y-7.071\nG40\nM99"
    )
    by = Controller.from_toml('name = "fanuc-rin"\nlike = "fanuc"\n[options]\nrotation_adds = true\n')
    path = read(main, controller=by, compensation="program")
    wanted = [turned(45.0 * k, *point) for k in range(8) for point in ((0.0, -10.0), (4.142, -10.0), (7.071, -7.071))]
    assert path_points(path)[:24, :2] == pytest.approx(np.array(wanted), abs=2e-3)
    assert any("is added to the turn in force" in each for each in path.assumed)


def test_programmable_mirror_image():
    """Programmable mirror image (G51.1, G50.1), its example: O9000 as it is, about X50, about both, about Y50."""
    main = (
        "G0 X0 Y0 Z0\nN10 G00 G90\nN20 M98 P9000\nN30 G51.1 X50.0\nN40 M98 P9000\nN50 G51.1 Y50.0\n"
        "N60 M98 P9000\nN70 G50.1 X0\nN80 M98 P9000\nN90 G50.1 Y0\nM30\n"
        "O9000\nG00 G90 X60.0 Y60.0\nG01 X100.0 F100\nG01 Y100.0\nG01 X60.0 Y60.0\nM99"
    )
    shape = np.array([[60.0, 60.0], [100.0, 60.0], [100.0, 100.0], [60.0, 60.0]])
    x, y = np.array([-1.0, 1.0]), np.array([1.0, -1.0])
    side = np.array([100.0, 0.0])
    up = np.array([0.0, 100.0])
    wanted = np.concatenate([shape, shape * x + side, shape * x * y + side + up, shape * y + up])
    found = path_points(read(main))
    assert found[1:, :2] == pytest.approx(wanted, abs=1e-6)


def path_points(path):
    """(k, 3) places one after the other [mm]."""
    found = path.tip * 1e3
    return np.array([found[0], *(b for a, b in pairwise(found) if np.abs(a - b).max() > 1e-9)])


def test_scaling_and_rotation():
    """Scaling and coordinate system rotation: the centre (200, 100) of G68 is scaled, the angle is
    not, and "scaling is applied first and then the coordinates are rotated"; so Haas 96-8000."""
    blocks = (
        "G0 X0 Y0 Z0\nG51 X300.0 Y150.0 {}\nG68 X200.0 Y100.0 R45.0\n"
        "G01 X400.0 Y100.0\nX400. Y200.0\nX200.0\nY100.0"
    )
    square = np.array([[200, 0], [200, 100], [0, 100], [0, 0]]) / 2.0
    wanted = [np.array([250.0, 125.0]) + turned(45.0, *corner) for corner in square]
    for controller, factor in (("fanuc", "P500"), ("haas", "P0.5")):
        planar(ends(read(blocks.format(factor), controller=controller)), wanted)


def test_rotation_with_scaling_of_haas():
    """Haas 96-8000, "Rotation with scaling", O0004: G51 P3.0 and G68 R60. about the origin, a window of 1 by 1."""
    main = (
        "G0 G90 X0 Y0 Z0\nG51 P3.0\nG68 R60.\nM98 P1001\nG69\nG50\nG90 G00 X0 Y0\nM30\n"
        "O1001\nG00 X1. Y1.\nG01 X2.\nY2.\nG03 X1. R0.5\nG01 Y1.\nG00 X0 Y0\nM99"
    )
    found = ends(read(main, controller="haas"))[1:6, :2]
    wanted = [3.0 * turned(60.0, *point) for point in ((1, 1), (2, 1), (2, 2), (1, 2), (1, 1))]
    assert found == pytest.approx(np.array(wanted), abs=1e-6)


def test_tool_length_offset():
    """Tool length offset (G43), H1 20.0 and H2 30.0: "G90 G43 Z100.0 H1: Z will move to 120.0", with H2 to 130.0."""
    sheet = "[tools.1]\nlength = 20\n[tools.2]\nlength = 30\n"
    found = ends(read("G0 X0 Y0 Z0\nG90 G43 Z100.0 H1\nG90 G43 Z100.0 H2", sheet=sheet))
    assert found[-2:, 2] == pytest.approx([120.0, 130.0], abs=1e-9)


def test_tool_length_offset_in_incremental_programming():
    """Tool length offset, its example of three holes under G91, where H1 = -4.0 shortens the tool of the program.

    The sheet has lengths from the spindle: the tool of the program is H2 with 100, in force before N1, and for H0.
    """
    blocks = (
        "G0 X0 Y0 Z0\nG90 G43 Z0 H2\nN1 G91 G00 X120.0 Y80.0\nN2 G43 Z-32.0 H1\nN3 G01 Z-21.0 F1000\nN4 G04 P2000\n"
        "N5 G00 Z21.0\nN6 X30.0 Y-50.0\nN7 G01 Z-41.0\nN8 G00 Z41.0\nN9 X50.0 Y30.0\nN10 G01 Z-25.0\nN11 G04 P2000\n"
        "N12 G00 Z57.0 H2\nN13 X-200.0 Y-60.0"
    )
    sheet = "[tools.1]\nlength = 96\n[tools.2]\nlength = 100\n"
    found = ends(read(blocks, sheet=sheet))[-11:] - [0.0, 0.0, 100.0]
    wanted = [
        [120, 80, 0], [120, 80, -36], [120, 80, -57], [120, 80, -36], [150, 30, -36], [150, 30, -77], [150, 30, -36],
        [200, 60, -36], [200, 60, -61], [200, 60, 0], [0, 0, 0],
    ]  # fmt: skip
    assert found == pytest.approx(np.array(wanted, float), abs=1e-6)


def test_canned_cycles_with_tool_length_compensation():
    """Example of canned cycles: offsets No. 11, 15 and 31 are 200, 190 and 150; thirteen holes.

    The origin of the program is where the spindle stands; a depth is that of the tip.
    """
    blocks = (
        "N001 G92 X0 Y0 Z0\nN002 G90 G00 Z250.0 T11 M6\nN003 G43 Z0 H11\nN004 S30 M3\n"
        "N005 G99 G81 X400.0 Y-350.0 Z-153.0 R-97.0 F120\nN006 Y-550.0\nN007 G98 Y-750.0\nN008 G99 X1200.0\n"
        "N009 Y-550.0\nN010 G98 Y-350.0\nN011 G00 X0 Y0 M5\nN012 G49 Z250.0 T15 M6\nN013 G43 Z0 H15\nN014 S20 M3\n"
        "N015 G99 G82 X550.0 Y-450.0 Z-130.0 R-97.0 P300 F70\nN016 G98 Y-650.0\nN017 G99 X1050.0\nN018 G98 Y-450.0\n"
        "N019 G00 X0 Y0 M5\nN020 G49 Z250.0 T31 M6\nN021 G43 Z0 H31\nN022 S10 M3\n"
        "N023 G85 G99 X800.0 Y-350.0 Z-153.0 R47.0 F50\nN024 G91 Y-200.0 K2\nN025 G28 X0 Y0 M5"
    )
    sheet = "[tools.11]\nlength = 200\n[tools.15]\nlength = 190\n[tools.31]\nlength = 150\n"
    path = read(blocks, sheet=sheet)
    found = path.tip * 1e3
    places = [
        (400, -350, 47), (400, -550, 47), (400, -750, 47), (1200, -750, 47), (1200, -550, 47), (1200, -350, 47),
        (550, -450, 60), (550, -650, 60), (1050, -650, 60), (1050, -450, 60),
        (800, -350, -3), (800, -550, -3), (800, -750, -3),
    ]  # fmt: skip
    low = [b for a, b, c in zip(found, found[1:], found[2:]) if b[2] < min(a[2], c[2]) + 1e-9 and b[0] > 1.0]
    assert np.array(low)[: len(places)] == pytest.approx(np.array(places, float), abs=1e-6)


def test_three_dimensional_conversion_about_the_tool():
    """Three-dimensional coordinate conversion (G68 X Y Z I J K R): the centre is added to what is turned about the
    vector; here about Z, which leaves the tool as it is."""
    body = "G0 X0 Y0 Z0\nG68 X10. Y20. Z5. I0 J0 K1. R30.\nG0 X0 Y0 Z0\nG0 X10. Y0 Z0\nG0 X0 Y10. Z2.\nG69"
    found = ends(read(body))
    at = np.array([10.0, 20.0])
    planar(found, [at, at + turned(30.0, 10.0, 0.0), at + turned(30.0, 0.0, 10.0)])
    assert found[-3:, 2] == pytest.approx([5.0, 5.0, 7.0])


def plane_by_euler(first, second, third):
    """(3, 3) turns about Z, the new X, the new Z."""
    def about(axis, degrees):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        made = np.eye(3)
        i, j = ((1, 2), (2, 0), (0, 1))[axis]
        made[i, i] = made[j, j] = c
        made[i, j], made[j, i] = -s, s
        return made

    return about(2, first) @ about(0, second) @ about(2, third)


@pytest.mark.parametrize(
    "machine", ["xyzac-trunnion", "xyzbc-trunnion", "xyzbc-nutating", "xyzbc-head", "xyzab-trunnion-inch"]
)
def test_tilted_working_plane(machine):
    """Tilted working plane command (G68.2, G53.1; B-63942EN, 5.44): origin in the workpiece
    coordinates, Euler's angles, then positions in the feature coordinate system."""
    blocks = (
        "G54\nG0 X0 Y0 Z50.\nG68.2 X100.0 Y100.0 Z50.0 I30.0 J15.0 K20.0\nG53.1\nG43 H1 X0 Y0 Z30.\n"
        "G1 Z0\nX40.\nX40. Y25.\nX0. Y0. Z10.\nG49\nG69"
    )
    path = read(blocks, machine=tp.Machine.load(machine))
    axes = plane_by_euler(30.0, 15.0, 20.0)
    local = np.array([[0, 0, 30], [0, 0, 0], [40, 0, 0], [40, 25, 0], [0, 0, 10]], float)
    assert ends(path)[-5:] == pytest.approx([100.0, 100.0, 50.0] + local @ axes.T, abs=1e-6)
    assert path.axis[-1] == pytest.approx(axes[:, 2], abs=1e-9)


PLANES = {
    "points": "G68.2 P2 Q1 X{a[0]:.9f} Y{a[1]:.9f} Z{a[2]:.9f}\nG68.2 P2 Q2 X{b[0]:.9f} Y{b[1]:.9f} Z{b[2]:.9f}\n"
              "G68.2 P2 Q3 X{c[0]:.9f} Y{c[1]:.9f} Z{c[2]:.9f}",
    "vectors": "G68.2 P3 Q1 X{a[0]:.9f} Y{a[1]:.9f} Z{a[2]:.9f} I{x[0]:.9f} J{x[1]:.9f} K{x[2]:.9f}\n"
               "G68.2 P3 Q2 I{z[0]:.9f} J{z[1]:.9f} K{z[2]:.9f}",
    "plane upon plane": "G68.2 X{a[0]:.9f} Y{a[1]:.9f} Z{a[2]:.9f} I30.\nG68.4 J15.\nG68.4 K20.",
}  # fmt: skip


@pytest.mark.parametrize("how", PLANES)
@pytest.mark.parametrize("word", ["G53.1", "G53.6", "G53.6 R50."])
def test_a_plane_told_otherwise_is_the_same(how, word):
    """G68.2 P2, P3 and G68.4 tell the plane of Euler's angles 30, 15, 20; G53.6 turns about the tip, or above it."""
    axes, at = plane_by_euler(30.0, 15.0, 20.0), np.array([10.0, -20.0, 5.0])
    x, y, z = axes.T
    text = PLANES[how].format(a=at, b=at + 50.0 * x, c=at + 20.0 * x + 30.0 * y, x=x, z=z)
    body = f"G54\nG0 X0 Y0 Z50.\n{text}\n{word}\nG43 H1 X0 Y0 Z30.\nG1 X7. Y3. Z0"
    path = read(body, machine=tp.Machine.load("xyzac-trunnion"))
    local = np.array([[0, 0, 30], [7, 3, 0]], float)
    assert ends(path)[-2:] == pytest.approx(at + local @ axes.T, abs=1e-5)


def test_a_plane_that_the_tool_tells():
    """G68.3 X Y Z R (A-79976E): Z is the tool, X = Z of the machine x Z of the plane, then R about Z."""
    machine = tp.Machine.load("xyzbc-head")
    path = read("G54\nG0 X0 Y0 Z50. B20. C0\nG68.3 X10. Y0 Z5. R30.\nG43 H1 X10. Y0 Z0\nG1 X0 Y10.", machine=machine)
    axis = path.axis[-1]
    x = np.cross([0.0, 0.0, 1.0], axis)
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    wanted = np.array([10.0, 0.0, 5.0]) + 10.0 * np.array([c * x + s * y, c * y - s * x])
    assert ends(path)[-2:] == pytest.approx(wanted, abs=1e-6)

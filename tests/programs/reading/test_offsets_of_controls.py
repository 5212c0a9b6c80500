"""G10 of Fanuc, Haas and Mazak: which offset it sets, in machine coordinates worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.setup_file import setup_of_text

SHEET = """
[units]
length = "mm"
angle = "deg"
[tools.1]
length = 150
[machine_zero]
X = 0
Y = 0
Z = 0
[offsets.G54]
X = 20
Y = -15
Z = -138
"""
HEAD = "G21 G90 G94 G17 G40\nT1 M6\nG43 H1\nG0 A0 C0\n"


def joints(text, controller, sheet=SHEET):
    """Joints X, Y, Z [mm] at the last point, and what was assumed."""
    machine = tp.Machine.load("xyzac-trunnion")
    path = tp.read_text(f"{HEAD}{text}G91 G1 Y1 F500\n", machine, setup=setup_of_text(sheet), controller=controller)
    q = machine.joints_at(path.tip, path.rotary, path.tool_length)
    return np.asarray(q)[-1, :3] * 1e3 - [0.0, 1.0, 0.0], [str(each) for each in path.assumed]


# an offset tells where the nose is without a tool: with one of 150 mm the nose is 150 mm higher
G54 = np.array([20.0, -15.0, -138.0 + 150.0])


def beside(x, y, z):
    """Joints at a place in G54."""
    return G54 + np.array([x, y, z])


@pytest.mark.parametrize("controller", ["fanuc", "mazak", "haas"])
@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("G10 L2 P0 X0 Y0 Z0\nG54\nG0 X20 Y0 Z0\n", beside(20.0, 0.0, 0.0)),
        ("G10 L2 P0 X1 Y2 Z3\nG54\nG0 X20 Y0 Z0\n", beside(21.0, 2.0, 3.0)),
        ("G10 L2 P0 X1\nG91 G10 L2 P0 X1 Y2\nG90 G54\nG0 X20 Y0 Z0\n", beside(22.0, 2.0, 0.0)),
        ("G10 L2 P1 X30 Y-10 Z-130\nG54\nG0 X20 Y0 Z0\n", [50.0, -10.0, 20.0]),
        ("G91 G10 L2 P1 X1\nG90 G54\nG0 X20 Y0 Z0\n", beside(21.0, 0.0, 0.0)),
        # an offset that the sheet does not have counts from the machine's zero
        ("G10 L2 P2 X30 Y-10 Z-130\nG55\nG0 X20 Y0 Z0\n", [50.0, -10.0, 20.0]),
        ("G10 L2 P2 X30 Y-10 Z-130\nG10 L2 P0 X1 Y0 Z0\nG55\nG0 X20 Y0 Z0\n", [51.0, -10.0, 20.0]),
    ],
)
def test_g10_sets_the_offset_that_it_names(controller, text, place):
    found, assumed = joints(text, controller)
    assert found == pytest.approx(np.asarray(place), abs=1e-9)
    assert not any("stands for" in each for each in assumed)


@pytest.mark.parametrize(
    ("controller", "word"), [("fanuc", "G54.1 P5"), ("mazak", "G54.1 P5"), ("haas", "G154 P5"), ("haas", "G114")]
)
def test_g10_l20_sets_a_numbered_offset(controller, word):
    text = f"G54\nG10 L20 P5 X30 Y-10 Z-130\n{word}\nG0 X20 Y0 Z0\n"
    assert joints(text, controller)[0] == pytest.approx([50.0, -10.0, 20.0], abs=1e-9)
    listed = SHEET + f"[offsets.\"{word}\"]\nX = 1\nY = 1\nZ = -140\n"
    assert joints(text, controller, listed)[0] == pytest.approx([50.0, -10.0, 20.0], abs=1e-9)


def test_axes_that_an_unlisted_offset_leaves_out_are_said():
    assumed = joints("G10 L2 P2 X30 Y-10\nG55\nG0 X20 Y0 Z100\n", "fanuc")[1]
    assert any("G55 is not on the set-up sheet: Z" in each for each in assumed)


@pytest.mark.parametrize("controller", ["fanuc", "mazak", "haas"])
def test_g10_l2_without_a_number_is_refused(controller):
    with pytest.raises(ToolpaceError, match="number of an offset"):
        joints("G10 L2 X30\nG0 X0 Y0 Z0\n", controller)


def test_haas_p0_is_the_shift_of_g52():
    found = joints("G52 X5\nG10 L2 P0 X0 Y0 Z0\nG54\nG0 X20 Y0 Z0\n", "haas")[0]
    assert found == pytest.approx(beside(20.0, 0.0, 0.0), abs=1e-9)
    found = joints("G52 X5\nG10 L2 P0 X0 Y0 Z0\nG54\nG0 X20 Y0 Z0\n", "fanuc")[0]
    assert found == pytest.approx(beside(25.0, 0.0, 0.0), abs=1e-9)

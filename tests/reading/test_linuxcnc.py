"""Words of LinuxCNC that its own interpreter reads so: what was once read otherwise, one test each.

Its interpreter judges random programs in `test_against_rs274.py`; figures here are of the documents' rules.
"""

from __future__ import annotations

import pytest

from tests.support.controllers import read_for, tips
from toolpace.errors import ProgramError
from toolpace.reading.coordinates.setup import SetUp, Tool

MM = 1e-3
START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z0\n"
SHEET = SetUp(
    offsets={"G54": {"X": 100 * MM}, "G55": {"X": 200 * MM, "Y": 10 * MM}},
    tools={"1": Tool(50 * MM), "2": Tool(80 * MM)},
)


def ends(body: str, **options) -> list[float]:
    """The last place of a program [mm]."""
    return tips("linuxcnc", START + body + "\nM2", **options)[-1]


# --- offsets --------------------------------------------------------------------------------------------------------


def test_g54_is_in_force_from_the_beginning():
    assert ends("G1 X1", setup=SHEET) == [101, 0, 0]


def test_g10_sets_offsets_absolutely_under_g91_too():
    """ "G10 L2": offsets are set, whatever the distance mode."""
    assert ends("G91\nG10 L2 P1 X5\nG10 L2 P1 X7\nG90 G1 X1", setup=SHEET) == [8, 0, 0]


def test_g10_l2_turns_an_offset_about_its_own_origin():
    """ "G10 L2 R": rotation around the Z axis, of the axes of the coordinate system."""
    assert ends("G10 L2 P1 X5 R90\nG1 X1 Y0", setup=SHEET) == [5, 1, 0]


def test_g92_shifts_along_the_turned_axes():
    assert ends("G10 L2 P1 X0 Y0 R90\nG0 X0 Y0\nG92 X-2\nG1 X1 Y0", setup=SHEET) == [0, 3, 0]


def test_g10_l20_calls_the_place_in_an_offset_that_is_not_in_force():
    assert ends("G10 L20 P2 X3\nG55 G1 X4 Y0", setup=SHEET) == [101, 10, 0]


def test_g10_l20_moves_a_turned_offset_along_its_own_axes():
    assert ends("G10 L2 P1 X0 Y0 R90\nG0 X0 Y0\nG10 L20 P1 X-2\nG1 X1 Y0", setup=SHEET) == [0, 3, 0]


def test_g52_and_g92_are_one_shift():
    """ "G52": it shares its offset with G92, parameters 5211 to 5219."""
    assert ends("G52 X5\nG0 X0\nG92 X1\nG52 X7\nG1 X1", setup=SHEET) == [108, 0, 0]
    assert ends("G52 X5\nG92.1\nG1 X1", setup=SHEET) == [101, 0, 0]


def test_g92_3_restores_what_was_set_last():
    assert ends("G92 X1\nG92.2\nG92 X3\nG92.2\nG92.3\nG1 X4", setup=SHEET) == [101, 0, 0]


@pytest.mark.parametrize("block", ["G92", "G52", "G10 L20 P1 X1 R0", "G10 L2 P1.5 X1"])
def test_offsets_that_cannot_be_set(block):
    with pytest.raises(ProgramError, match="part.nc:3"):
        read_for("linuxcnc", START + block + "\nG1 X1\nM2")

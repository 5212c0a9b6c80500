"""Work offsets that the program sets and moves itself, and what is said of them."""

from __future__ import annotations

import pytest

from tests.support.controllers import read_for, tips
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp

START = "G90 G21 G94 G17 F600\n"
SHEET = SetUp(offsets={"G54": {"X": 0.1}, "G55": {"X": 0.2}})
GANTRY = Machine.load("xyzac-trunnion")


@pytest.mark.parametrize("controller", ["fanuc", "haas", "mazak", "linuxcnc"])
def test_the_first_offset_holds_before_one_is_named(controller):
    """Fanuc 30i operator's manual, workpiece coordinate systems: G54 is selected when power is turned on; it is the
    default of its group in the list of Haas."""
    body = "G0 X1. Y0 Z0\nG1 X2.\nG55\nG1 X2.\nM30"
    assert [tip[0] for tip in tips(controller, START + body, setup=SHEET)] == [101.0, 102.0, 202.0]


def test_in_g91_what_g10_sets_is_added():
    """Fanuc 16i operator's manual 7.2.3: in the incremental mode a value is added to the offset."""
    body = "G54\nG0 X0 Y0 Z0\nG91 G10 L2 P1 X5.\nG10 L2 P1 X-2.\nG90 G1 X1."
    assert tips("fanuc", START + body, setup=SHEET)[-1][0] == 104.0


def test_it_is_said_that_a_sheet_is_missing_where_it_is():
    """One sentence for all offsets without a sheet; none with it."""
    body = START + "G54\nG0 X0 Y0 Z0\nG1 X1.\nG55\nX2."
    said = [s for s in read_for("fanuc", body).assumed if "no set-up sheet tells work offsets" in s]
    assert len(said) == 1
    assert not [s for s in read_for("fanuc", body, setup=SHEET).assumed if "no set-up sheet tells work offsets" in s]


def test_an_offset_of_an_axis_that_is_not_there_is_refused_unless_it_is_zero():
    """B of a machine with A and C: nothing to move, or an error that names it."""
    body = START + "G54\nG0 X0 Y0 Z0 A0 C0\nG10 L2 P1 X1. B{}\nG1 X1."
    without = tips("fanuc", body.replace(" B{}", ""), GANTRY, setup=SHEET)
    assert tips("fanuc", body.format("0"), GANTRY, setup=SHEET) == without
    with pytest.raises(ProgramError, match="B"):
        read_for("fanuc", body.format("5."), GANTRY, setup=SHEET)

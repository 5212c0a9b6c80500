"""SEQ after "TNC 640 Klartext Programming", "PLANE function", "Positioning behavior"."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import read
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine

MASTER = {
    "linuxcnc-xyzac-trt": "A", "paper-ab": "A", "xyzab-table": "A", "xyzab-trunnion-inch": "A", "xyzac-head": "A",
    "xyzac-trunnion": "A", "xyzbc-head": "B", "xyzbc-millturn": "B", "xyzbc-nutating": "B",
    "xyzbc-nutating-large": "B", "xyzbc-table": "B", "xyzbc-trunnion": "B",
}  # fmt: skip
"""The first rotary axis seen from the tool, or the last one seen from the table."""
BEYOND = {("paper-ab", -1), ("xyzab-table", -1), ("xyzbc-nutating", -1)}
"""Where the other solution lies beyond the travel."""


@pytest.mark.parametrize("name", MASTER)
@pytest.mark.parametrize("sign", [1, -1])
def test_seq_is_the_sign_of_the_master_axis(name, sign):
    """SEQ+ and SEQ-: the master axis takes a positive or a negative angle."""
    machine = Machine.load(name)
    text = f"PLANE SPATIAL SPA+10 SPB+15 SPC+0 TURN FMAX SEQ{'+' if sign > 0 else '-'}\nL X+0 Y+0 Z+0 F500"
    try:
        path = read(text, machine)
    except ProgramError as error:
        assert "out of travel" in str(error)
        assert (name, sign) in BEYOND
        return
    names = [joint.upper() for joint in path.rotary_joints]
    angle = path.rotary[-1][names.index(MASTER[name])]
    assert np.sign(angle) == sign and abs(angle) > np.deg2rad(5)


@pytest.mark.parametrize(("name", "plane", "sign", "within"), [
    ("linuxcnc-xyzac-trt", "SPA+70 SPB+0", "+", "with A above zero.*C 0.000 A -70.000 deg is within.*SEQ-"),
    ("xyzbc-nutating", "SPA+0 SPB+60", "-", r"with B below zero.*B 90.000 deg is within.*SEQ\+"),
])  # fmt: skip
def test_seq_out_of_travel_names_the_solution_that_is_within(name, plane, sign, within):
    """A of the trunnion goes from -100 to 50 deg, and B of the nutating table from -30 to 185."""
    with pytest.raises(ProgramError, match=within):
        read(f"PLANE SPATIAL {plane} SPC+0 TURN FMAX SEQ{sign}\nL X+0 Y+0 Z+0 F500", Machine.load(name))

"""How moves become points: in pieces that are small enough, however many of them are looked at at once."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for
from tests.support.table_table import MACHINE
from toolpace.programs.reading.control import unroll

BODY = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0 A0 C0\nG1 X50 A5 C70\nX20 C200\nY30\nA40\nM2"


@pytest.mark.parametrize("chunk", [1, 7, 100])
def test_points_do_not_depend_on_how_many_are_looked_at_at_once(chunk, monkeypatch):
    """Moves of more pieces than fit at once are looked at alone."""
    whole = read_for("linuxcnc", BODY, MACHINE)
    monkeypatch.setattr(unroll, "CHUNK", chunk)
    again = read_for("linuxcnc", BODY, MACHINE)
    assert len(whole) > 100
    assert np.array_equal(whole.tip, again.tip) and np.array_equal(whole.axis, again.axis)

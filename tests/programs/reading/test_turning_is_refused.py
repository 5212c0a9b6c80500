"""Programs of lathes are refused: X is a diameter there and F counts by revolution, so that none of it is true here."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp

MACHINE = tp.Machine.load("xyzac-trunnion")
ROUGHING = "G0 X60. Z5.\nG1 Z-87. F0.127\nX62.\nG0 Z5.\n"
"""As a lathe takes it: a diameter of 60 mm, 0.127 mm a revolution."""


def read(body, controller="fanuc"):
    return tp.read_text(f"%\nO1001\nG21 G90 G54\n{body}M30\n%\n", MACHINE, controller=controller)


@pytest.mark.parametrize("controller", ["fanuc", "haas", "mazak", "iso"])
@pytest.mark.parametrize("word", ["G96 S91 M3", "G50 S5000", "G28 U0.", "G28 W0."])
def test_a_word_of_a_lathe_alone_refuses_the_program(word, controller):
    with pytest.raises(tp.ToolpaceError, match=r":4: .*turning"):
        read(f"{word}\n{ROUGHING}", controller)


@pytest.mark.parametrize("controller", ["fanuc", "haas", "linuxcnc", "iso"])
@pytest.mark.parametrize("home", ["G28", "G30"])
def test_an_axis_that_is_absent_goes_home_alone(home, controller):
    """Not all axes, as for a block that names none."""
    tips = read(f"G0 X1. Y2. Z3.\nG91 {home} B0.\nG90 G1 X11. F100.\n", controller).tip
    np.testing.assert_allclose(tips, [[0.001, 0.002, 0.003], [0.011, 0.002, 0.003]], atol=1e-12)

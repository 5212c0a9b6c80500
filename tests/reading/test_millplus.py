"""MillPlus: what is refused, with its cure."""

from __future__ import annotations

import pytest

from tests.support.controllers import read_for
from toolpace.errors import ProgramError
from toolpace.machine.machine import Machine

START = "%PM1\nN10 G71 G90 G94 F600.\nN20 G0 X0. Y0. Z50. B0. C0.\nN30 G141 L2=0 F2=15000.\n"


@pytest.mark.parametrize("words", ["I1=0.6 J1=0. K1=0.8", "I1=0.1", "K1=1."])
def test_a_tools_direction_under_g141_is_refused(words):
    """Its rotary words turn X and Y with the table (one program of NX's post shows it); what its vectors are in is
    not known, so that both cannot be read together."""
    machine = Machine.load("xyzbc-trunnion")
    with pytest.raises(ProgramError, match=r"[IK]1= of G141.*write the positions of the rotary axes"):
        read_for("millplus", f"{START}N40 G1 X5. {words}\nN50 G40\nN60 M30\n", machine)
    path = read_for("millplus", f"{START}N40 G1 X5. B10. C30.\nN50 G40\nN60 M30\n", machine)
    assert len(path) > 1


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G8 X1.", "G8"), ("G9 X1. Y1.", "G9"), ("G14 N1=10 N2=20", "G14"), ("G22 N=100", "G22"), ("G29 N=10", "G29"),
        ("G51", "G51"), ("G72", "G72"), ("G73 B4=30.", "G73"), ("G77 X0. Y0. R10.", "G77"), ("G87 X10. Y10.", "G87"),
        ("G192 X1.", "G192"), ("G999 X1.", "G999"), ("G41 D1", "G41"),
    ],
)  # fmt: skip
def test_words_that_may_move_something_are_refused(block, said):
    with pytest.raises(ProgramError, match=rf"\b{said}\b"):
        read_for("millplus", f"%PM1\nG71 G90 G94 F600.\nG0 X0. Y0. Z50.\n{block}\nG1 X5.\nM30\n")

"""Numbers without a point where they count least increments: lengths 0.001 mm or 0.0001 inch, angles 0.001 degree.

Each program is written with and without points; both are one.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for, with_options
from tests.support.table_table import MACHINE
from toolpace.common.errors import ProgramError

LEAST = {name: with_options(name, whole_numbers="least increment") for name in ("fanuc", "haas")}
START = "G90 G21 G94 G17 F600\nG0 X0. Y0. Z50. A0 C0\n"


@pytest.mark.parametrize(
    ("controller", "without", "pointed"),
    [
        ("fanuc", "G1 X10 Y10000", "G1 X0.01 Y10."),
        ("fanuc", "G18 G2 X10000 Z60000 I0 K10000", "G18 G2 X10. Z60. I0 K10."),
        ("fanuc", "G19 G3 Y10000 Z60000 J10000 K0", "G19 G3 Y10. Z60. J10. K0"),
        ("fanuc", "G20\nG1 X10000\nG21", "G20\nG1 X1.\nG21"),
        ("fanuc", "G20\nG68 X0 Y0 R90000\nG1 X10000 Y0\nG69 G21", "G20\nG68 X0 Y0 R90.\nG1 X1. Y0\nG69 G21"),
        ("fanuc", "G51 X0 Y0 I2000 J2000 K2000\nG1 X10000 Y0", "G51 X0 Y0 P2000\nG1 X10. Y0"),
        ("fanuc", "G81 X10000 Z-5000 R2000 K2\nG80", "G81 X10. Z-5. R2. K2\nG80"),
        ("fanuc", "G83 X10000 Z-10000 R2000 Q3000\nG80", "G83 X10. Z-10. R2. Q3.\nG80"),
        ("fanuc", "G20\nG16 X10000 Y90000\nG15 G21", "G20\nG16 X1. Y90.\nG15 G21"),
        ("fanuc", "G1 X10000,R2000\nY10000", "G1 X10.,R2.\nY10."),
        ("fanuc", "G20\nG4 X1000\nG21 X1000", "G20\nG4 X1.\nG21 X1."),
        ("fanuc", "G20\nG68.2 X0 Y0 Z0 I0 J25000 K30000\nG53.1\nG21 G0 X1000", "G68.2 I0 J25. K30.\nG53.1\nG0 X1."),
        ("fanuc", "G43.5 H1\nG1 X6000 I0 J-1 K1", "G43.5 H1\nG1 X6. I0 J-1. K1."),
        ("fanuc", "G1 C10000", "G1 C10."),
        ("haas", "G73 X10000 Z-10000 R2000 I4000 J1000 K2000\nG80", "G73 X10. Z-10. R2. I4. J1. K2.\nG80"),
        ("haas", "G20\nG81 Z-100 R2000 L0\nG71 I10000 J90000 K30000 L2\nG80 G21",
         "G20\nG81 Z-.01 R.2 L0\nG71 I1. J90. K30. L2\nG80 G21"),
    ],
)  # fmt: skip
def test_numbers_without_a_point_are_those_with_one(controller, without, pointed):
    """Fanuc: "Decimal point programming", and the increment system IS-B; a dwell X counts 0.001 s."""
    a, b = (read_for(LEAST[controller], f"{START}{body}\nM30", MACHINE) for body in (without, pointed))
    assert a.tip == pytest.approx(b.tip, abs=1e-9) and a.rotary == pytest.approx(b.rotary, abs=1e-9)
    assert a.dwell == pytest.approx(b.dwell) and np.ptp(a.tip, axis=0).max() + np.ptp(a.rotary) > 0.0


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("G65 P1 X10 A5\nM30\nO1\nG1 X#24\nM99", "arguments of a macro without a point"),
        ("G43.5 H1\nG1 X6. I0 J-1 K1.5", "a tool vector of which some numbers have a point"),
    ],
)
def test_what_no_manual_at_hand_counts_is_refused(body, said):
    with pytest.raises(ProgramError, match=said):
        read_for(LEAST["fanuc"], f"{START}{body}\nM30", MACHINE)


def test_numbers_of_tools_and_repeats_are_no_lengths():
    """D, H, M, S and T are whole numbers by their letter, to macros too."""
    path = read_for(LEAST["fanuc"], f"{START}G65 P1 H10 S5 T2\nM30\nO1\nG1 X[#11+#19]\nM99", MACHINE)
    assert path.tip[-1, 0] == pytest.approx(0.015)


@pytest.mark.parametrize(("body", "wanted"), [("P2000", 20.0), ("P-1000", -10.0), ("P[1500]", 15.0)])
def test_a_scale_counts_thousandths(body, wanted):
    """Fanuc 16i, 14.7: P1000 is life size, and it takes no point."""
    path = read_for("fanuc", f"{START}G51 X0 Y0 {body}\nG1 X10.\nM30", MACHINE)
    assert path.tip[-1, 0] == pytest.approx(wanted / 1e3)
    with pytest.raises(ProgramError, match="G51 P with a point"):
        read_for("fanuc", f"{START}G51 X0 Y0 P2.\nG1 X10.\nM30", MACHINE)


def test_a_mirror_of_haas_stands_at_zero():
    """G101 names axes ("G101 X0")."""
    with pytest.raises(ProgramError, match="G101 about another place than zero"):
        read_for("haas", f"{START}G101 X5.\nG1 X10.\nM30", MACHINE)

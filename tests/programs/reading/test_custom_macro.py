"""Arithmetic of Custom Macro B: the worked examples of the manuals of Fanuc and Haas."""

from __future__ import annotations

import pytest

from tests.support.controllers import read_for, tips, with_options
from toolpace.common.errors import ProgramError

START = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0\n"


def last(controller, body, axis=0):
    """Coordinate [mm] at which a program ends."""
    return tips(controller, START + body + "\nM30")[-1][axis]


@pytest.mark.parametrize(
    ("back", "left"), [("X[#1+#2]", -0.001), ("X[ROUND[#1]+ROUND[#2]]", 0.0)], ids=["sum", "sum of rounded"]
)
def test_words_are_rounded_to_their_least_increment_and_so_does_round_in_them(back, left):
    """B-64304EN, "ROUND function": 1.2345 and 2.3456 there, and their sum back, misses the start by 0.001; the sum of
    both rounded does not."""
    body = f"#1=1.2345\n#2=2.3456\nG91 G0 X-#1\nG1 X-#2\nG0 {back}"
    path = [x for x, _, _ in tips("fanuc", START + body + "\nM30")]
    assert path == pytest.approx([0.0, -1.235, -3.581, left], abs=1e-9)


@pytest.mark.parametrize(("value", "inches"), [("#1 + #1", 2.0067), ("ROUND[ #1 ] + ROUND[ #1 ]", 2.0066)])
def test_haas_rounds_words_in_inches_to_four_places(value, inches):
    """Haas 96-8000, "Notes on functions": the table moves to 2.0067, and with ROUND to 2.0066."""
    assert last("haas", f"G20\n#1= 1.00333\nG0 X[ {value} ]") == pytest.approx(inches * 25.4, abs=1e-6)


def test_round_in_arithmetic_gives_whole_numbers():
    """Haas 96-8000: #2=ROUND[1.714] is 2; B-64304EN: of 1.2345 it is 1."""
    assert last("haas", "#1=1.714\n#2=ROUND[#1]\nG0 X#2") == 2.0
    assert last("fanuc", "#1=ROUND[1.2345]\nG0 X#1") == 1.0


def test_the_centre_of_an_arc_is_rounded_as_its_end_is():
    """A quarter of a circle whose figures have a digit more than the control keeps is one of the figures rounded."""
    body = "#1=10.00049\nG2 X#1 Y[-#1] I0 J[-#1]"
    path = tips("fanuc", START + body + "\nM30")
    assert path[-1] == [10.0, -10.0, 0.0]
    assert max(abs((x**2 + (y + 10) ** 2) ** 0.5 - 10.0) for x, y, _ in path) < 1e-5


@pytest.mark.parametrize(
    ("text", "fanuc", "haas"),
    [("ATAN[-1]/[-1]", 225.0, -135.0), ("ASIN[-0.5]", 330.0, -30.0), ("ATAN[1]/[-1]", 135.0, 135.0)]
)  # fmt: skip
def test_the_range_of_angles_is_that_of_the_parameter_and_said(text, fanuc, haas):
    """B-64304EN: parameter 6004#0 = 0: ATAN[-1]/[-1] is 225, ASIN gives 270 to 90; with 1, -135 and -90 to 90."""
    body = f"#1={text}\nG0 X#1"
    for controller, wanted in (("fanuc", fanuc), ("haas", haas), (with_options("fanuc", angles_to_360=False), haas)):
        path = read_for(controller, START + body + "\nM30")
        assert path.tip[-1, 0] * 1e3 == pytest.approx(wanted, abs=1e-9)
        assert any("ASIN and ATAN" in said for said in path.assumed) == (fanuc != haas)


def test_the_remainder_is_of_whole_numbers_with_the_sign_of_the_first():
    """B-64304EN: #j and #k are rounded, and what comes of it has the sign of #j. Haas 96-8000: 27 MOD 20 is 7."""
    assert [last("fanuc", f"#1={text}\nG0 X#1") for text in ("27 MOD 20", "-10 MOD 3", "10.6 MOD 3")] == [7, -1, 2]
    assert last("haas", "#1=27 MOD 20\nG0 X#1") == 7
    with pytest.raises(ProgramError, match="controls differ in the remainder"):
        last("haas", "#1=-10 MOD 3\nG0 X#1")
    with pytest.raises(ProgramError, match="division by zero"):
        last("fanuc", "#1=5 MOD 0.4\nG0 X#1")


def test_round_that_is_handed_to_a_macro_is_refused():
    with pytest.raises(ProgramError, match="ROUND in an argument of a macro"):
        read_for("fanuc", START + "G65 P1 A[ROUND[1.4]]\nM30\nO1\nG1 X#1\nM99")


@pytest.mark.parametrize(
    ("controller", "body", "seconds", "said"),
    [
        ("fanuc", "#1=500\nG4 P#1", 0.5, False),
        ("fanuc", "G4 P1.5", 1.5, True),
        ("haas", "#1=.5\nG4 P#1", 0.5, True),
        ("haas", "G4 P.5", 0.5, False),
    ],
)
def test_dwells_whose_time_is_reckoned(controller, body, seconds, said):
    """P takes no point on Fanuc, and is milliseconds also from a variable; Haas tells its unit by the point."""
    path = read_for(controller, START + body + "\nG1 X1.\nM30")
    assert path.dwell.sum() == pytest.approx(seconds)
    assert any("P of a dwell" in sentence for sentence in path.assumed) is said


@pytest.mark.parametrize(("text", "wanted"), [("POW[2,3]", 8.0), ("ATAN[1,-1]", 135.0), ("ATAN[1]/[-1]", 135.0)])
def test_functions_of_two_values(text, wanted):
    """B-64304EN: POW[#j,#k], and ATAN[#j,#k] for ATAN[#j]/[#k]."""
    assert last("fanuc", f"#1={text}\nG0 X#1") == pytest.approx(wanted)
    with pytest.raises(ProgramError, match="'POW' is no function"):
        last("iso", "#1=POW[2,3]\nG0 X#1")

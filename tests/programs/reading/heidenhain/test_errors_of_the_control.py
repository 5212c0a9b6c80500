"""NC error messages that a program alone raises: what the control stops at is refused here.

Messages after "TNC error messages" of the user's manuals (TNC 407 to TNC 430; later controls say the same in other
words), bounds after "Input format and unit of TNC functions" (TNC 640).
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import MACHINE, findings, read
from toolpace.common.errors import ProgramError

CHAIN = "CALL LBL 1\nSTOP M2\n" + "".join(f"LBL {k}\nL IX+1\nCALL LBL {k + 1}\nLBL 0\n" for k in range(1, 20))
DRILL = "CYCL DEF 200 ~\n Q200=2 Q201=-10 Q206=100 {}Q210=0 Q203=0 Q204=5 Q211=0\nCYCL CALL"
ENDED = {
    "Label number allocated": ("LBL 1\nL X+1\nLBL 0\nLBL 1\nL X+2\nLBL 0", "stands twice"),
    "Label number not found": ("CALL LBL 7", "no LBL 7"),
    "Jump to label 0 not permitted": ("CALL LBL 0", "no LBL 0"),
    "Excessive subprogramming": (CHAIN + "LBL 20\nL IX+1\nLBL 0", "more than 19 deep"),
    "Angle reference missing": ("CC X+5 Y+0\nCP DR+", "CP needs the angle"),
    "Circle centre undefined": ("C X+10 Y+10 DR+", "no CC before"),
    "Pole undefined": ("LP PR+5 PA+10", "no CC before"),
    "Plane wrongly defined, CC": ("CC X+10", "names one coordinate"),
    "Plane wrongly defined, vectors": ("PLANE VECTOR BX1 BY0 BZ0 NX1 NY0 NZ0 STAY", "span no plane"),
    "Plane wrongly defined, points": (
        "PLANE POINTS P1X0 P1Y0 P1Z0 P2X1 P2Y0 P2Z0 P3X2 P3Y0 P3Z0 STAY", "span no plane",
    ),
    "Entered angle not permitted": ("PLANE SPATIAL SPA+400 SPB+0 SPC+0 STAY", "between -360 and 360"),
    "PLANE incomplete, angles": ("PLANE SPATIAL SPA+10 STAY", "lacks SPB"),
    "PLANE incomplete, positioning": ("PLANE SPATIAL SPA+10 SPB+0 SPC+0", "write MOVE, TURN or STAY"),
    "Arithmetical error, quotient": ("Q1 = 1 / 0\nL X+Q1", "division by zero"),
    "Arithmetical error, FN 4": ("FN 4: Q1 = +1 DIV +0\nL X+Q1", "division by zero"),
    "Arithmetical error, root": ("Q1 = SQRT -1\nL X+Q1", "is no number"),
    "Arithmetical error, logarithm": ("Q1 = LN -1\nL X+Q1", "is no number"),
    "Axis double programmed": ("L X+1 X+2", "stands twice in one block"),
    "Chamfer not permitted, length": ("L X+10\nCHF -2\nL Y+10", "size of CHF"),
    "Chamfer too large": ("L X+10\nCHF 20\nL Y+10", "make it smaller"),
    "Rounding radius too large": ("L X+10\nRND R20\nL Y+10", "make it smaller"),
    "Rounding off not defined": ("L X+10\nRND R2\nRND R2\nL Y+10", "RND behind RND"),
    "Circle end position incorrect, C": ("L X+10\nCC X+0 Y+0\nC X+0 Y+12 DR+", "off its circle"),
    "Circle end position incorrect, CR": ("CR X+10 Y+0 R+2 DR+", "too small"),
    "Circle end position incorrect, CT": ("L X+10\nCT X+5 Y+0", "straight behind its start"),
    "No tangent to join": ("L Z+5\nCT X+10 Y+10", "an element before it"),
    "No rotation sense, C": ("L X+10\nCC X+0 Y+0\nC X+0 Y+10", "no sense"),
    "No rotation sense, CR": ("CR X+10 Y+0 R+20", "no sense"),
    "No radius": ("CR X+10 Y+0 DR+", "needs its radius"),
    "Full circle by CR": ("CR X+0 Y+0 R+20 DR+", "full circle"),
    "Helix, angle": ("CC X+5 Y+5\nCP IPA+5500 IZ+5 DR+", "5400"),
    "Helix, sense": ("L X+10\nCC X+0 Y+0\nCP IPA-360 IZ+5 DR+", "different signs"),
    "Cycle not defined, CYCL CALL": ("CYCL CALL", "no cycle is defined"),
    "Cycle not defined, M99": ("L X+1 M99", "no cycle is defined"),
    "Cycle incomplete": (DRILL.format(""), "lacks Q202"),
    "Cycle without its number": ("CYCL DEF", "needs the number"),
    "Feed rate is missing": ("L X+1 F0", "must be above zero"),
    "Spindle must be turning": (
        "TOOL CALL 1 Z S0\nCYCL DEF 207 ~\n Q200=2 Q201=-10 Q239=+1 Q203=0 Q204=5\nCYCL CALL",
        "needs the spindle speed",
    ),
    "Scaling factor not permitted, arc": (
        "CYCL DEF 26.0\nCYCL DEF 26.1 X1.5 Y1\nL X+10\nCC X+0 Y+0\nC X+0 Y+10 DR+", "scales differently",
    ),
    "Scaling factor not permitted, rounding": (
        "CYCL DEF 26.0\nCYCL DEF 26.1 X1.5 Y1\nL X+10\nRND R2\nL Y+10", "scales differently",
    ),
    "Scaling factor not permitted, 0": ("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 0", "a scale of 0"),
    "Scaling factor not permitted, 100": ("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 100", "a scale of 100"),
    "Entry value incorrect, rotation": ("CYCL DEF 10.0\nCYCL DEF 10.1 ROT+400", "between -360 and 360"),
    "Entry value incorrect, dwell": ("CYCL DEF 9.0\nCYCL DEF 9.1 DWELL 4000", "between 0 and 3600"),
    "Entry value incorrect, tool": ("TOOL CALL 40000 Z", "between 0 and 32767.9"),
    "Entry value incorrect, oversize": ("TOOL CALL 1 Z DL+2000", "-999.9999"),
    "Entry value incorrect, REP": ("LBL 1\nL IX+1\nCALL LBL 1 REP 65535", "from 0 to 65534"),
    "Entry value incorrect, Q": ("Q2000 = 1", "numbered from 0 to 1999"),
    "Entry value incorrect, QL": ("QL500 = 1", "numbered from 0 to 499"),
    "Entry value incorrect, FN": ("FN 0: QR500 = +1", "numbered from 0 to 499"),
    "Entry value incorrect, MB": ("L X+1\nM140 MB -5", "MB of M140"),
    "Too many M functions": ("L X+1 M3 M8 M13 M25 M26", "more than 4 M functions"),
    "Second line of a mirror": ("CYCL DEF 8.0\nCYCL DEF 8.1 X\nCYCL DEF 8.2 Y", "one line of figures, 8.1"),
    "Way back below zero": ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 TURN MB-5 FMAX", "MB of PLANE is the length"),
    "Distance below zero": ("PLANE SPATIAL SPA+9 SPB+0 SPC+0 MOVE DIST-5 FMAX", "DIST of PLANE is a distance"),
    "Preset without its number": ("CYCL DEF 247 PRESET ~\n Q340=1", "lacks Q339"),
    "FAUTO without F of TOOL CALL": ("TOOL CALL 1 Z S100\nL X+1 FAUTO", "which has none"),
    "Wrong axis programmed": ("L B+5", "has no axis B"),
    "Wrong axis programmed, CC": ("CC A+5", "takes X, Y and Z only"),
    "Wrong axis programmed, scale": ("CYCL DEF 26.0\nCYCL DEF 26.1 A1.5", "scales X, Y and Z only"),
    "The program's own error": ("FN 14: ERROR = 1000", "FN 14: ERROR = 1000 is not read"),
    "Program selected nowhere": ("CALL SELECTED PGM", "no program is selected"),
}  # fmt: skip


@pytest.mark.parametrize("message", ENDED)
def test_what_ends_the_run_of_the_control_ends_reading(message):
    text, said = ENDED[message]
    with pytest.raises(ProgramError, match=said):
        read(f"L X+0 Y+0 Z+0 F100\n{text}\nL X+3 Y+3", MACHINE)


REFUSED = {
    "Chamfer not permitted, before an arc": ("L X+10\nCHF 2\nCC X+10 Y+5\nC X+10 Y+10 DR+", "CHF"),
    "Chamfer not permitted, behind an arc": ("L X+10\nCC X+10 Y+5\nC X+10 Y+10 DR+\nCHF 2\nL X+0", "CHF"),
    "Rounding off not defined, end of program": ("L X+10\nRND R2\nSTOP M2", "RND"),
    "Rounding off not defined, rapid": ("L X+10\nRND R2\nL Y+10 FMAX", "RND"),
    "Rounding off not defined, tool axis": ("L X+10\nRND R2\nL Z+10", "RND"),
    "Cycle parameter incorrect, sign of the depth": (
        DRILL.format("Q202=5 ").replace("Q201=-10", "Q201=+10"), "CYCL DEF 200 with Q201 above zero",
    ),
    "Q parameter undefined": ("L X+Q5", "Q5"),
    "Program not found": ("CALL PGM NOWHERE", "CALL PGM NOWHERE"),
    "Block marked ERROR": ("ERROR L X+5 Y", "ERROR"),
    "Unknown statement": ("FOO X+5", "FOO"),
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_what_the_control_stops_at_is_refused(message):
    text, word = REFUSED[message]
    found = findings(f"L X+0 Y+0 Z+0 F100\n{text}" + ("" if text.endswith("M2") else "\nL X+3 Y+3"), MACHINE)
    assert [refusal.word for refusal in found.refusals] == [word]


def test_a_corner_before_a_block_without_a_value_is_no_other_error():
    found = findings("L X+0 Y+0 F100\nL X+10\nRND R2\nL Y+Q5\nRND R2\nL X+Q5\nRND R2\nL Y+0", MACHINE)
    assert {refusal.word for refusal in found.refusals} <= {"Q5", "RND"}


def test_what_is_within_the_bounds_is_read():
    """The same words at the bounds that the control still takes."""
    text = (
        "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+360\nCYCL DEF 9.0\nCYCL DEF 9.1 DWELL 3600\nQ1999 = 2\nQL499 = 1\n"
        "CYCL DEF 26.0\nCYCL DEF 26.1 X1 Y1 Z1.5\nL X+10\nCC X+0 Y+0\nC X+0 Y+10 DR+ M3 M8 M13 M25\nL X+Q1999 Z+2"
    )
    path = read(f"L X+0 Y+0 Z+0 F100\n{text}", MACHINE)
    assert np.allclose(path.tip[-1] * 1e3, (2, 10, 3), atol=1e-9) and path.dwell.max() == 3600
    nested = CHAIN.replace("CALL LBL 20\n", "")
    assert np.allclose(read(f"L X+0 Y+0 Z+0 F100\n{nested}").tip[-1] * 1e3, (19, 0, 0), atol=1e-9)

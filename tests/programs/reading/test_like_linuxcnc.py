"""Programs on which our reading once moved elsewhere than LinuxCNC's own interpreter."""

from __future__ import annotations

import shutil

import pytest

from testbed.against_rs274 import BOTH, compared, difference
from testbed.linuxcnc.job import Job

pytestmark = [
    pytest.mark.linuxcnc,
    pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's interpreter rs274 is not installed"),
]
HEAD = "G21 G90 G94 G17 F600\n"
SAME = {
    "a full circle but for a rounding": "G0 X10 Y0 Z5\nG2 X10.005 Y0 I-10 J0\nM2\n",
    "two turns of it": "G0 X10 Y0 Z5\nG2 X10.005 Y0 I-10 J0 P2\nM2\n",
    "left about": "G0 X10 Y0 Z5\nG3 X9.995 Y0 I-10 J0\nM2\n",
    "a helix": "G0 X0 Y10.004\nG2 X0 Y10 J-10 Z-2\nM2\n",
    "H0 is the tool in the spindle": "G0 X0 Y0 Z0\nT2 M6\nG43 H0\nG1 X5 Z1\nG43 H1\nG1 Z2\nM2\n",
    "G28 in turned coordinates": "G10 L2 P1 R45\nG0 X3 Y4 Z0\nG28 X5\nG1 X1 Y1\nM2\n",
    "G30 too": "G10 L2 P1 R30\nG0 X3 Y4 Z0\nG30 Y5 Z2\nG1 X1 Y1\nM2\n",
    "modes with G92 off": "G0 X1 Y1\nM70\nG92 X5\nM72\nG1 X7\nM2\n",
    "modes with G92 on": "G0 X1 Y1\nG92 X5\nM70\nG92.2\nM72\nG1 X7\nM2\n",
    "another G92 stays": "G0 X1 Y1\nG92 X5\nM70\nG92 X9\nM72\nG1 X7\nM2\n",
    "the number of F": "G0 X0 Y0\nF600\nG20\nG1 X[#<_feed>/100]\nF7\nG21\nG1 X[#<_feed>]\nM2\n",
    "numbered variables exist": "G0 X0 Y0\nG1 X[2+EXISTS[#31]] Y[EXISTS[#<foo>]]\nM2\n",
    "short pecks": "G0 X0 Y0 Z5\nG83 X1 Y1 Z-1 R1 Q0.2\nG80\nM2\n",
    "a tap waits as long as the cycle before": "M3 S100\nG0 Z5\nG82 X1 Y1 Z-1 R1 P.5\nG80\nG84 X2 Z-1 R1\nG80\nM2\n",
    "P of a tap too": "M3 S100\nG0 Z5\nG84 X1 Y1 Z-1 R1 P.25\nG81 X2\nG84 X3\nG80\nM2\n",
    "P of no peck": "G0 Z5\nG83 X1 Y1 Z-1 R1 Q1 M62 P1\nG80\nM2\n",
    "P of an arc beside an offset": "G0 X1\nG3 I3 P2 G54\nG1 X3\nM2\n",
    "P of a cycle beside an offset": "G0 Z5\nG82 X1 Y1 Z-1 R1 P1 G55\nX3 P.5 G54\nG80\nM2\n",
    "P of a cycle and a tolerance": "G0 Z5\nG82 X1 Y1 Z-1 R1 P.25\nX4 G64 P.5\nX5\nG80\nM2\n",
    "P of a cycle and a dwell": "G0 Z5\nG82 X1 Y1 Z-1 R1 P.25\nX4 G4 P.5\nX5\nG80\nM2\n",
    "P of an arc and a dwell": "G0 X1\nG2 I3 G91.1\nI3 G4 P2\nG1 X3\nM2\n",
    "P of a dwell alone": "G0 X1\nG2 I3\nG4 P.5\nG1 X3\nM2\n",
    "Q of a cycle and a tolerance": "G0 Z5\nG83 X1 Y1 Z-3 R1 Q2\nX4 G64 P.5 Q1\nG80\nM2\n",
    "G80 beside another cycle": "G0 Z5\nG91 G83 X1 Y1 Z-2 R-1 Q.5\nG81 X3 Z-1 R1 G80\nG90 G80\nG0 X0\nM2\n",
    "G80 beside G53": "G0 Z5\nG81 X1 Y1 Z-1 R1\nG80 G53 G0 X5\nX6\nM2\n",
    "an input beside an arc": "G0 X1\nG2 I3 M66 P2 L0\nG3 X3 I1 M66 E1\nM2\n",
    "an input beside what ends a cycle": "G0 Z5\nG81 X1 Y1 Z-1 R1\nG1 X5 M66 P0 L0\nM2\n",
    "next to nothing of an arc": "G0 X0 Y0\nG2 X0.005 Y-0.0001 I-5 J0\nG1 X9\nM2\n",
    "a told length takes the place of another": "G0 X0 Y0 Z0\nG43 H1\nG43.1 X1 Z3\nG1 X2 Z1\nG43.1 Z4\nG1 Z2\nM2\n",
    "levels go by the mode at the hole": "G0 Z5\nG81 X1 Y1 Z-1 R1\nG91 X3\nG90 X9\nG80\nM2\n",
    "F of saved modes": "G1 X1\nM70\nF100\nM72\nG1 X9\nM2\n",
    "short chips": "G0 X0 Y0 Z5\nG73 X1 Y1 Z-1 R1 Q0.2\nG80\nM2\n",
}
REFUSED = {
    "G92 X0\nG10 L2 P1 R90\nG1 Y5\nM2\n": "while G92 or G52 shifts",
    "G52 X1\nG10 L2 P1 R90\nG1 Y5\nM2\n": "while G92 or G52 shifts",
    "G81 X1 Y1 Z-1 R1\nG20 X0.5\nG80\nM2\n": "G20 within a cycle",
    "G1 X5 G43.1 Z3\nM2\n": "both take the axes",
    "G91 G81 X3 Z-1 R1 M66 P1 L3 Q2\nG80\nM2\n": "may take the same letters",
    "G82 X3 Z-1 R1 P1\nX4 M19 R30 P2\nG80\nM2\n": "may take the same letters",
    "G83 X3 Z-1 R1 Q1\nX4 M61 Q2\nG80\nM2\n": "may take the same letters",
    "G2 X10.005 Y-0.0000001 I-10\nM2\n": "a full circle, or none",
    # its interpreter takes the number of F for inches, and for 7.2 in its next version
    "G20\nM70\nF100\nM72\nG1 X0.1\nM2\n": "feed missing",
    "F7.25\nM70\nM72\nG1 X1\nM2\n": "feed missing",
    "T2 M6\nG41 D0\nG1 X5\nG40 X7\nM2\n": "needs the tool's radius",
}


@pytest.mark.parametrize("name", SAME)
def test_what_is_read_is_what_linuxcnc_does(name):
    assert difference(Job(HEAD + SAME[name], tools={1: 80.0, 2: 100.0})) == ""


def test_a_block_without_a_centre_behind_an_arc_is_refused_by_both():
    verdict = compared(Job(HEAD + "G0 X0 Y0 Z5\nG2 X10 Y0 I5\nG43 Z0 H2\nM2\n", tools={2: 100.0}))
    assert verdict.kind == BOTH


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_not_read_so_is_refused(text):
    found = difference(Job(f"{HEAD}G0 X10 Y0 Z5\n{text}", tools={2: 100.0}))
    assert found.startswith("refused by us only") and REFUSED[text] in found


@pytest.mark.parametrize("text", ["G2 I3 P0", "G2 I3 M66 P0 L0", "G2 I3 P1.5", "G2 I3\nI3 G4 P.5"])
def test_turns_that_are_none_are_refused_by_both(text):
    assert compared(Job(f"{HEAD}G0 X1\n{text}\nM2\n")).kind == BOTH

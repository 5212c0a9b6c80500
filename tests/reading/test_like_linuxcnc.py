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
    "short chips": "G0 X0 Y0 Z5\nG73 X1 Y1 Z-1 R1 Q0.2\nG80\nM2\n",
}
REFUSED = {
    "G92 X0\nG10 L2 P1 R90\nG1 Y5\nM2\n": "while G92 or G52 shifts",
    "G52 X1\nG10 L2 P1 R90\nG1 Y5\nM2\n": "while G92 or G52 shifts",
    "G81 X1 Y1 Z-1 R1\nG20 X0.5\nG80\nM2\n": "G20 within a cycle",
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

"""A plan of 22 s: rests, a turn, a loop, a cycle, an arc; made once."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.support.thinned import first_of
from toolpace.cli import main
from toolpace.controls.export import PlannedMotion

PROGRAM = """\
(rests, a turn, a loop, a cycle)
G21 G90 G17 G94
G0 X0 Y0 Z5 A0 C0
G1 Z0 F600
N10 X30 F300 ; along x
Y20 A4 C8
G4 P0.4
F400
o100 repeat [2]
  G91 G1 X-4 Y-2
  X1
  G90
o100 endrepeat
G1 X0 Y0 A0 C0 F250
G81 Z-1 R2 F200
X5
G80
#1=12
G1 X[#1/2] F[200+#1]
G0 Z5
M2
"""


@pytest.fixture(scope="session")
def plan(tmp_path_factory):
    """Its folder."""
    place = tmp_path_factory.mktemp("exporting")
    program = place / "part.ngc"
    program.write_bytes(PROGRAM.replace("along x\n", "along x\r\n").encode())
    out = place / "part-plan"
    assert main(["plan", str(program), "-m", "linuxcnc-xyzac-trt", "--no-report", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="session")
def motion(plan):
    """It, loaded."""
    found = PlannedMotion.load(plan)
    assert found.duration > 20.0
    return found


@pytest.fixture(scope="session")
def brief(motion):
    """Its first four seconds, for what needs no more."""
    return replace(motion, setpoints=first_of(motion.setpoints, 4001))

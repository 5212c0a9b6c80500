"""A whole program with the habits of posts: it reads untouched, and everything in it is accounted for."""

from __future__ import annotations

import numpy as np

from tests.support.heidenhain import CONTROLLER
from toolpace.machine.machine import Machine
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.reader import HeidenhainReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

PROGRAM = """\
0  BEGIN PGM 1001 MM
1  BLK FORM 0.1 Z  X-50  Y-50  Z-20
2  BLK FORM 0.2  X+50  Y+50  Z+0
3  ;-------------------------------------
4  LBL 500
5  M140 MB MAX F99999
6  PLANE RESET STAY
7  L  Z-0.1 R FMAX M91
8  L  B+0  C+0 FMAX M9
9  LBL 0
10 * - 3+2 POCKET
11 CALL LBL 500
12 TOOL CALL 5 Z S12000 DL+0 DR+0
13 TOOL DEF 6
14 CYCL DEF 32.0 TOLERANCE
15 CYCL DEF 32.1 T0.01
16 CYCL DEF 32.2 HSC-MODE:0 TA0.5
17 CYCL DEF 7.0 DATUM SHIFT
18 CYCL DEF 7.1 X+0
19 M126
20 PLANE SPATIAL SPA+0 SPB+45 SPC+90 TURN MB MAX FMAX SEQ- TABLE ROT
21 L X+10 Y+0 R0 FMAX M8
22 L Z+15 R0 FMAX
23 L Z-2 F400
24 L X+20 Y+5 F1200
25 CC X+25 Y+5
26 C X+30 Y+5 DR-
27 CP IPA+180 DR+
28 LP PR+8 PA+45
29 L Z+50 FMAX
30 PLANE RESET TURN MB MAX FMAX
31 M127
32 * - 5-AXIS
33 TOOL CALL "BALL 6" Z S15000
34 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
35 L X+0 Y+0 Z+50 B+0 C+0 R0 FMAX
36 L X+1.23 Y+2.3 Z+10 B+12.5 C+33.2 F2000
37 L X+1.43 Y+2.6 B+13.5 C+34.2
38 FUNCTION RESET TCPM
39 M140 MB MAX
40 CYCL DEF 200 DRILLING ~
     Q200=2    ;SET-UP CLEARANCE ~
     Q201=-15  ;DEPTH ~
     Q206=FAUTO ;FEED RATE FOR PLNGNG ~
     Q202=15   ;PLUNGING DEPTH ~
     Q203=+.5  ;SURFACE COORDINATE ~
     Q204=50   ;2ND SET-UP CLEARANCE
41 TOOL CALL 7 Z S2000 F150
42 L X+10 Y+10 B0 C0 R0 FMAX M13
43 CYCL CALL
44 L IX+10 FMAX M99
45 CALL LBL 500
46 STOP M2
47 END PGM 1001 MM
"""


def test_a_posted_program():
    machine, findings = Machine.load("xyzbc-trunnion"), Findings()
    path = (
        HeidenhainReader(Source.from_text(PROGRAM), machine, CONTROLLER, ReadOptions(), findings).executed().toolpath()
    )
    assert not findings.refusals
    assert findings.skipped == {"M9": 3, "TOOL DEF": 1, "CYCL DEF 32": 2, "M8": 1, "M13": 1}
    assert [operation.tool for operation in path.operations][-3:] == ["5", "BALL 6", "7"]
    tilted = path.axis[path.block == 25][-1]  # the straight line in the pocket
    assert np.allclose(tilted, (0, np.sqrt(0.5), np.sqrt(0.5)), atol=1e-9)
    bottoms = path.tip[(path.block >= 50) & np.isclose(path.tip[:, 2], -0.0145)]
    assert np.allclose(bottoms[:, :2], [(0.01, 0.01), (0.02, 0.01)])
    assert np.allclose(path.feed[np.isclose(path.tip[:, 2], -0.0145)], 150 / 60e3)

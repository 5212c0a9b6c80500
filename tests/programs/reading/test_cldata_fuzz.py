"""Random statements and truncated lines: a sound ToolPath or a one-line ProgramError, nothing else."""

from __future__ import annotations

import random

import numpy as np
import pytest

from toolpace.common.errors import ProgramError
from toolpace.programs.reading.cldata.reader import ClReader
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

TEXT = """PARTNO X $ Y
$$*CATIA0
$$ A
$$ 1. 0. 0. 0.
$$-> CSYS / 1,0,0,0, $
0,1,0,0,0,0,1,0
$$ centerline data
$$ OPERATION NAME : A
TOOL PATH/A,TOOL,B
END-OF-PATH
LOADTL/3
LOAD/TOOL,2,ADJUST,0
MSYS/0,0,0,1,0,0,0,1,0
UNITS/MM
UNITS/INCHES
FEDRAT/MMPM,250
FEDRAT/0.1,MMPR
FEDRAT/INVERS,30
FEDRAT/INVERS,OFF
FEDRAT/9,FURLONG
SPINDL/2000,RPM
RAPID
FROM/0,0,0
GOTO/0,0,0
GOTO/10,0,0
GOTO/0,10,0
GOTO / -1.5, 2 3 0 0.6 0.8
GOTO/1,2,3,0,0,1,0,0,1
GODLTA/1,2,3
GODLTA/-4
GOHOME/0,0,100
GOHOME
TLAXIS/0,1,0
CIRCLE/0,0,0,0,0,1,10
CIRCLE/0,0,0,0,0,-1,10,0.01,0.5,6,0,TIMES,2
INDIRV/0,1,0
TLON,GOFWD/(CIRCLE/0,0,0,10),ON,2,INTOF,(LINE/0,0,0,0,5,0)
TLON,GOFWD/(CYLNDR/0,2,0,0,1,0,10),ON,(PLANE/PERPTO,(POINT/0,2,10))
NURBS/
FNURBS/
KNOT/0.25,0.5
KNOT/1.0
CNTRL/1,2,3
CNTRL/4,4,4
CNTRL/5,2,1
MOVNRB/ON,4,2
MOVNRB/OFF
CYCLE/DRILL,DEEP,STEP,2,RAPTO,3,FEDTO,-10,RTRCTO,AUTO,MMPM,250
CYCLE/BRKCHP,DEPTH,9,STEP,2,IPM,5,CLEAR,4,RAPTO,1,RETURN,0,DWELL,0.1
CYCLE/TAP,10,250,MMPM,20,5
CYCLE/DRILL, 126, 85, 1, MMPR
CYCLE/ON
CYCLE/OFF
CUTCOM/LEFT
CUTCOM/OFF
TRACUT/1,0,0,0,0,1,0,0,0,0,1,0
ROTATE/TABLE,90
DELAY/2,REV
DELAY/0.5
COOLNT/ON
INSERT/M8
INSERT/G0 X5
PPRINT costs $ 5
REMARK -> CUTTER / 5
PREFUN/5
P1 = POINT/0,0,0
JUMPTO/7
FINI"""
STATEMENTS = TEXT.splitlines()
WHOLE = [
    "GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0",
    "GOTO/10,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,2,INTOF,(LINE/0,0,0,0,5,0)",
    "NURBS/\nKNOT/0.25,0.5\nKNOT/1.0\nCNTRL/1,2,3\nCNTRL/4,4,4\nCNTRL/5,2,1\nCNTRL/5,3,1\nCNTRL/6,3,1",
    "CYCLE/DRILL,DEEP,STEP,2,RAPTO,3,FEDTO,-10,RTRCTO,AUTO,MMPM,250\nGOTO/0,0,0\nCYCLE/OFF",
    "CYCLE/DRILL,DEPTH,9,IPM,5,CLEAR,4,RAPTO,1,RETURN,0\nGOTO/0,0,0\nGOTO/0,5,0,0,1,0\nCYCLE/OFF",
    "FEDRAT/MMPM,250\nGOTO/1,1,1,0,0,1",
    "RAPID\nGOTO/4,4,4",
]
"""Statements that belong together."""
SCRAPS = ["", "0", "-1", "1E-9", "1e12", "9" * 30, "NAN", "INF", "$", "$$", ",", "/", "(", ")", "OFF", "É", "1D3", " "]


def check(text: str, skip_unknown: bool = False) -> bool:
    findings = Findings()
    try:
        p = ClReader(Source.from_text(text), None, ReadOptions(skip_unknown=skip_unknown), findings).run()
    except ProgramError as error:
        assert str(error) and "\n" not in str(error)
        return False
    n = len(p)
    assert n >= 2 and skip_unknown | (not findings.refusals)
    for values in (p.tip, p.axis, p.least_time, p.dwell):
        assert np.isfinite(values).all()
    assert (p.feed > 0).all() and (p.least_time >= 0).all() and (p.dwell >= 0).all()
    assert np.abs(np.linalg.norm(p.axis, axis=1) - 1).max() < 1e-9
    assert (np.diff(p.block) >= 0).all() and p.stop[0] and p.stop[-1]
    assert (np.diff(p.operation) >= 0).all() and p.operation[-1] < len(p.operations)
    assert len(p.rapid) == n and p.assumed == findings.assumptions
    return True


def spoilt(statement: str, chance: random.Random) -> str:
    """The statement with a part cut off, left out, or put in."""
    at = chance.randrange(len(statement) + 1)
    kind = chance.randrange(3)
    if kind == 0:
        return statement[:at]
    if kind == 1:
        return statement[:at] + statement[at + chance.randint(1, 6) :]
    return statement[:at] + chance.choice(SCRAPS) + statement[at:]


@pytest.mark.parametrize("skip_unknown", [False, pytest.param(True, marks=pytest.mark.sweep)])
def test_random_statements(skip_unknown):
    chance = random.Random(11)
    read = 0
    for _ in range(4000):
        lines = ["UNITS/MM", "FEDRAT/9", "GOTO/10,0,0"][: chance.randint(0, 3)]
        for _ in range(chance.randint(1, 14)):
            statement = chance.choice(STATEMENTS if chance.random() < 0.3 else WHOLE)
            lines.append(spoilt(statement, chance) if chance.random() < 0.15 else statement)
        text = "\n".join(lines)
        read += check(text if text.strip() else "GOTO", skip_unknown)
    assert read > (1000 if skip_unknown else 100)


def test_a_program_cut_off_anywhere():
    for end in range(1, len(TEXT)):
        check(TEXT[:end], skip_unknown=True)
    text = "FEDRAT/9\n" + "\n".join(WHOLE)
    assert sum(check(text[:end]) for end in range(1, len(text))) > 30

"""APT and CLSF: statements that are refused, each with its line, its text and the cure."""

from __future__ import annotations

import pytest

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.cldata.reader import ClReader
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

MM_MIN = 1e-3 / 60


def path(body: str, **options) -> ToolPath:
    return read_text(body + "\n", None, "apt", **options)


START = "FEDRAT/100\nGOTO/0,0,0\n"


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("GOTO/1,2", "has 2 numbers: it takes x, y, z"),
        ("GOTO/1,2,3,0,1", "has 5 numbers"),
        ("GOTO/1,,3", "is empty"),
        ("GOTO/1,nan,3", "is not finite"),
        ("GOTO/1,inf,3", "is not finite"),
        ("GOTO/1,1e300,3", "beyond 1e9"),
        ("GOTO/1,2e8,3", "more than a kilometre"),
        ("GOTO/1,2,3,0,0,0", "the tool axis i, j, k is zero"),
        ("GOTO/1,2,3,0,0,0.9", "has length 0.9, not 1"),
        ("GODLTA/1,2", "has 2 numbers"),
        ("FEDRAT/0", "above zero"),
        ("FEDRAT/-5,MMPM", "above zero"),
        ("FEDRAT/MMPM", "has no number"),
        ("FEDRAT/5,LENGTH", "FEDRAT/LENGTH is not read: give one number"),
        ("FEDRAT/0.1,MMPR", "needs the spindle speed"),
        ("SPINDL/9,RPM\nSPINDL/9,SFM\nFEDRAT/0.1,MMPR", "needs the spindle speed"),
        ("DELAY/-1", "not between 0 and a day"),
        ("DELAY/NONE", "takes one number"),
        ("DELAY/5,REV", "needs the spindle speed"),
        ("UNITS/FEET", "use UNITS/MM"),
        ("GOFWD/C1", "GOFWD is not read: its motion depends on the shape of the part"),
        ("TLLFT,GOFWD/C1", "TLLFT,GOFWD is not read: its motion depends on the shape"),
        ("P1 = POINT/0,0,0", "= is not read: its motion depends on the shape"),
        ("BLORK/1,2", "BLORK is not read: it is not known here and might move something"),
        ("CYCLE/DRILL,5", "CYCLE/DRILL is not read: what its numbers mean is set in the post-processor"),
        ("CUTCOM/LEFT", "CUTCOM is not read: the control would shift the tool"),
        ("ROTATE/TABLE,90", "ROTATE is not read: it moves or turns the points"),
        ("ORIGIN/1,0,0", "ORIGIN is not read: it moves or turns the points"),
        ("TRNTYP/WORLD,1,0,0", "TRNTYP is not read: it moves or turns the points"),
        ("INSERT/G0", "INSERT is not read: it holds code of the control"),
        ("FROM/1,0,0", "FROM is not read: it names the start"),
        ("CIRCLE/0,0,0,0,1", "it takes centre, direction and radius"),
        ("GOTO/1,2,3,0,0,1,0,0,1", "GOTO with 9 numbers is not read"),
        ("PPFUN/3", "PPFUN is not read"),
        ("SET/MODE,INCR", "SET/INCR is not read: the points after it would be increments"),
        ("COPY/1,SAME,2", "COPY is not read"),
        ("TRACUT/1,0,0,5,0,1,0,0,0,0,1,0", "TRACUT is not read"),
        ("CLEARP/0,0,1,50", "its motion is the machine's own"),
        ("CNTRL/1,2,3", "no NURBS stands before it"),
        ("?", "no statement of the form"),
    ],
)
def test_refuses_with_line_text_and_cure(statement, says):
    with pytest.raises(ProgramError) as caught:
        read_text(START + statement + "\nGOTO/5,5,5,0,0,1\nFINI\n", None, "apt", name="part.apt")
    message = str(caught.value)
    assert says in message and "\n" not in message
    line = 3 + statement.count("\n") + ("needs the spindle" in says and "FEDRAT" in statement)
    assert message.startswith(f"part.apt:{line}: ")


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("CIRCLE/0,0,0,0,0,1,10\nGOTO/10,0,0", "CIRCLE before any position"),
        ("GODLTA/1,0,0", "GODLTA before any position"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,0,10\nGOTO/0,10,0", "has length 0, not 1"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,9\nGOTO/0,10,0", "says radius 9 mm, but it starts 10 mm"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,11,0", "mm off its circle"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10", "not followed by the GOTO"),
        ("GOTO/10,0,0\nGOTO/0,0,$", "cut off"),
        ("GOTO/10,0,0\nMSYS/0,0,0\nGOTO/1,0,0\nMSYS/1,0,0", "MSYS is not read: it changes the coordinates"),
        ("GOTO/10,0,0", "no motion"),
        ("PAINT/PATH", "no motion"),
    ],
)
def test_refuses_what_does_not_fit_together(body, says):
    with pytest.raises(ProgramError, match=says):
        path("FEDRAT/100\n" + body)


def test_feed_missing_names_the_line_and_the_cure():
    with pytest.raises(ProgramError, match=r":2: feed missing.*--feed 3000mm/min"):
        path("GOTO/0,0,0\nGOTO/1,0,0")
    assert path("GOTO/0,0,0\nGOTO/1,0,0", feed="3000mm/min").feed[1] == pytest.approx(0.05)


def test_a_goto_cut_in_the_middle_says_so():
    with pytest.raises(ProgramError, match="cut off"):
        read_text("FEDRAT/1\nGOTO/0,0,0\nGOTO/1,2", None, "apt")


def test_all_that_is_refused_is_told_in_one_run():
    body = START + "BLORK/1\nGOTO/1,0,0\nCYCLE/THRU,1\nGOTO/2,0,0\nCYCLE/OFF\nBLORK/2\nTRACUT/1,2,3\nGOTO/3,0,0"
    findings = Findings()
    with pytest.raises(ProgramError) as caught:
        ClReader(Source.from_text(body + "\n", "part.apt"), None, ReadOptions(), findings).run()
    assert str(caught.value).startswith("part.apt: 3 kinds of words are not read: BLORK (first line 3, 2 times): ")
    assert [(r.word, r.line, r.count) for r in findings.refusals] == [
        ("BLORK", 3, 2),
        ("CYCLE/THRU", 5, 1),
        ("TRACUT", 9, 1),
    ]
    p = ClReader(Source.from_text(body + "\n"), None, ReadOptions(skip_unknown=True), Findings()).run()
    assert p.tip[:, 0] * 1e3 == pytest.approx([0, 1, 2, 3])
    assert "skipped BLORK (first line 3, 2 times)" in p.assumed
    assert p.rapid.tolist() == [1, 0, 1, 0]

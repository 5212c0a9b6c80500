"""Programs at which controls stop with an alarm (Diagnostics Manual; of cycles, Programming Manual Cycles) are refused.

The numbers are the alarms'. Those that are told from a machine's data or in operation are in docs/design/sinumerik.md,
with those that a program raises and that are read here all the same.
"""

from __future__ import annotations

import msgspec
import pytest

from tests.support.sinumerik import SINUMERIK, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

START = "G54 G710 G64 G90 G94 G17 F500\nG0 X0 Y0 Z50 A0 C0\n"
ALARMS = [
    (10880, "RND=2 G1 X10\nZ1\nG4 F1\nM8\nM9\nM8\nY10"), (10882, "CHF=2\nG1 X10"),
    (10891, "BSPLINE X1 Y1 PL=0\nX2 PL=0\nX3 PL=0\nX4 Y5 PL=0"), (12000, "G1 X10 X20"), (12000, "G1 F100 F200 X1"),
    (12000, "T1 T2"), (12010, "M3 M7 M8 M9 M10 M11 G1 X1"), (12020, "G1 X=AC(10)=IC(5)"), (12040, "R1=AXNAME(5)"),
    (12050, "G1 Q10 X1"), (12050, "G1 E5 X1"), (12060, "G0 G1 X10"), (12060, "G90 G91 X10"), (12060, "G54 G55\nX1"),
    (12060, "G17 G18\nX1"), (12060, "G94 G95 F1\nX1"), (12060, "G70 G71\nG1 X1"), (12060, "G40 G41\nX1"),
    (12120, "G4 TRANS X5 F1\nG1 X1"), (12060, "TRANS X5 ROT Z5\nG1 X1"), (12080, "G1 X10 )"), (12080, "G1 X=5+*3"),
    (12080, "IF R1== GOTOF AAA\nAAA: G1 X1"), (14013, "SUBX P0\nM30\nPROC SUBX\nG1 X1\nM17"), (12110, "X10 Y G1"),
    (12110, "G1 X10 Y"), (12120, "G4 F1 X10"), (12120, "TRANS X5 G1 Y10"), (12120, "G1 X1 G25 Y5"),
    (12150, "DEF STRING[5] SS\nR1=SS+1\nG1 X1"), (12150, 'R1="A"*2\nG1 X1'), (12160, "R1=1.5EX400\nG1 X1"),
    (12160, "DEF INT NN=99999999999\nG1 X1"), (12170, "DEF INT NN\nDEF REAL NN\nG1 X1"),
    (12180, "R1=R2 AND OR R3\nG1 X1"), (12190, "DEF INT NN[2,2,2,2]\nG1 X1"),
    (12260, "DEF INT NN[2]=SET(1,2,3,4)\nG1 X1"), (12290, "R1=R99999\nG1 X1"), (12290, "R99999=1\nG1 X1"),
    (12300, "SUBX(5)\nM30\nPROC SUBX(VAR REAL AA)\nG1 X1\nM17"),
    (12330, 'SUBX("A")\nM30\nPROC SUBX(REAL AA)\nG1 X1\nM17'),
    (12340, "SUBX(1,2)\nM30\nPROC SUBX(REAL AA)\nG1 X1\nM17"), (12400, "DEF REAL NN[3]\nNN[5]=1\nG1 X1"),
    (12410, "DEF REAL NN[3]\nNN[1.5]=1\nG1 X1"), (12420, "DEF REAL N23456789012345678901234567890123\nG1 X1"),
    (12430, "DEF REAL NN[0]\nG1 X1"), (12450, "AAA: G1 X1\nAAA: G1 X2\nGOTOF AAA"), (12470, "G777 X1"),
    (12470, "G16 X1"), (12470, "G1.5 X1"), (12550, "NOSUCH=5\nG1 X1"), (12550, "G1 X=NOSUCH"),
    (12550, "NOSUCH(1)\nG1 X1"), (12550, "G1 X1 NOSUCH"), (12560, "R1=SET(5)\nG1 X1"),
    (12630, "/IF R1==0\nG1 X1\nENDIF"), (12630, "AAA: IF R1==0\nG1 X1\nENDIF"),
    (12640, "IF R1==0\nFOR R1=1 TO 2\nENDIF\nENDFOR\nG1 X1"), (12640, "ENDIF\nG1 X1"), (12640, "IF R1==0\nG1 X1"),
    (12640, "ELSE\nG1 X1"), (14011, "L77\nG1 X1"), (14011, 'CALL "NIX"\nG1 X1'),
    (14012, "SUBX\nM30\nPROC SUBX\nG1 X1\nSUBX\nM17"), (14013, "SUBX P=0\nM30\nPROC SUBX\nG1 X1\nM17"),
    (14013, "SUBX P=-1\nM30\nPROC SUBX\nG1 X1\nM17"), (14020, "SUBX(1,2,3)\nM30\nPROC SUBX(REAL AA)\nG1 X1\nM17"),
    (14040, "G2 X10 Y0 I4 J0"), (14045, "CT X10 Y0"), (14045, "G0 Z1\nCT X5 Y5"), (14048, "G2 X10 Y0 I5 J0 TURN=-1"),
    (14051, "R1=1/0\nG1 X1"), (14051, "R1=SQRT(-1)\nG1 X1"), (14051, "R1=ASIN(2)\nG1 X1"),
    (14051, "R1=LN(0)\nG1 X1"), (14060, "/10 G1 X1"), (14080, "GOTOF NIX\nG1 X1"), (14080, "GOTOB N500\nG1 X1"),
    (14082, "REPEAT NIX P=2\nG1 X1"), (14090, "D-1\nG1 X1"), (14090, "D1.5\nG1 X1"), (14092, "POS[X]=5\nG1 X1"),
    (14095, "G2 X20 Y0 CR=5"), (14095, "G2 X0 Y0 CR=5"), (14095, "G2 X5 Y0 CR=0"),
    (14098, 'R1=NUMBER("ABC")\nG1 X1'), (14101, "G1 X1 A3=0 B3=0 C3=1"), (14101, "G1 X1 A2=5"),
    (14101, "ORIRESET()"), (14110, "TRAORI\nG1 X1 A3=0 B3=0 C3=1 A2=5"), (14111, "TRAORI\nG1 X1 A3=0 B3=0 C3=1 C=5"),
    (14111, "TRAORI\nG1 X1 A2=5 A=5"), (14112, "TRAORI\nG1 X1 A3=0 B3=0 C3=0"), (14113, "TRAORI\nG1 X1 LEAD=95"),
    (14159, "ROTS X10 Y10 Z10\nG1 X1"), (14159, "AROTS X10 Y10 Z10\nG1 X1"), (14200, "G111 X0 Y0\nG1 AP=30 RP=-5"),
    (14210, "G111 X0 Y0\nG1 AP=400 RP=5"), (14250, "G111 AP=30 RP=-5\nG1 AP=30 RP=5"),
    (14260, "G111 AP=400 RP=5\nG1 AP=30 RP=5"), (14270, "G111 X5 AP=30 RP=5\nG1 AP=30 RP=5"),
    (14270, "G111 X5 Z5\nG1 AP=30 RP=5"), (14270, "G17 G111 Z5\nG1 AP=30 RP=5"),
    (14280, "G111 X0 Y0\nG1 AP=30 RP=5 X3"), (14401, "TRAORI(9)"), (14402, "BSPLINE X1 Y1\nTRAORI\nX2\nX3 Y5"),
    (14510, "SUBX(1)\nM30\nSUBX: G1 X1\nM17"), (14750, "H1 H2 H3 H4 H5 H6 G1 X1"), (14760, "M3 M4\nG1 X1"),
    (14760, "M3 M5\nG1 X1"), (14800, "G1 X5 F0"), (14800, "G1 X5 F-100"), (14900, "G2 X10 Y0 I5 J0 AR=180"),
    (14900, "G2 X10 Y0 I5 CR=5"), (14900, "G2 X10 CR=5 AR=180"), (14910, "G2 X10 Y0 AR=360"),
    (14910, "G2 X10 Y0 AR=0"), (14910, "G2 I5 J0 AR=-20"), (14920, "CIP X10 Y0"), (14920, "CIP X10 Y0 I1=0 J1=0"),
    (16500, "G1 X10 CHF=-2\nY10"), (16500, "G1 X10 RND=-2\nY10"), (16720, "G331 Z-5 K0 S100"), (16720, "G33 Z-5 K0"),
    (16760, "G331 Z-5 K1"), (16800, "G1 X=DC(5)"), (16810, "G1 X=ACP(5)"), (16820, "G1 X=ACN(5)"),
    (17020, "R1=$P_UIFR[500]\nG1 X1"), (17050, "TURN=5 G1 X1"), (18310, "ROT A10\nG1 X1"), (16440, "ROT U10\nG1 X1"),
    (61001, "S100 M3\nCYCLE84(10,0,2,-5,,,3,5,2,0,100,100)"), (61002, "CYCLE83(10,0,2,-20,,-5,,2,0,0,1,7)"),
    (61103, "MCALL CYCLE81(10,0,2,-5)\nHOLES1(0,0,0,5,5,0)\nMCALL"),
    (61103, "MCALL CYCLE81(10,0,2,-5)\nHOLES2(0,0,10,0,30,0)\nMCALL"), (61101, "CYCLE81(10,0,2,5)"),
    (61107, "CYCLE83(10,0,2,-20,,5,,2,0,0,1,1)"),
    (61180, 'CYCLE800(7,"",0,57,0,0,0,30,0,0,0,0,0,-1,0,1)'),
    (61184, 'CYCLE800(0,"",0,57,0,0,0,170,0,0,0,0,0,-1,0,1)'), (14920, "CIP X10 Y10 I1=15 J1=15"),
    (12641, "IF R1==0\n" * 20 + "G1 X1\n" + "ENDIF\n" * 20),
    (12120, "G0 G111 X5 Y5\nG1 AP=30 RP=5"), (14400, "G41\nTRAORI"),
]  # fmt: skip


def refusal(text, start=START, **options):
    """What a program is refused with; empty where it is read."""
    try:
        read(text, "xyzac-trunnion", start=start, **options)
    except ProgramError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(("alarm", "text"), ALARMS, ids=lambda value: str(value)[:20].replace("\n", " "))
def test_what_stops_a_control_is_refused(alarm, text):
    said = refusal(f"{text}\nG1 X3 Y3")
    assert said and "there is no motion" not in said
    # a number in the message is the one of the table
    assert "alarm" not in said or str(alarm) in said


def test_alarms_of_a_program_as_a_whole():
    """10860: no feed; 14000: the file ends in mid-program."""
    assert "feed missing" in refusal("G1 X2", start="G54\nG0 X0 Y0 Z50\n")


SAID = {
    "DEF REAL AA": "14500", "G1 C=DC(400)": "16830", "G1 C=ACP(-10)": "16830", "CYCLE85(10,0,2,-5)": "FFR",
    "CYCLE86(10,0,2,-5,,0)": "61102", "CYCLE88(10,0,2,-5,,0,9)": "61102", "S100\nCYCLE84(10,0,2,-5,,,9,,1)": "61102",
    "CYCLE81(10,11,2,-5)": "61101", "CYCLE81(10,10,2,,5)": "61101",
}  # fmt: skip


@pytest.mark.parametrize("text", SAID)
def test_what_stops_a_control_and_has_one_meaning_is_said(text):
    path = read(f"G1 X1\n{text}\nG1 X3", "xyzac-trunnion", start=START)
    assert any(SAID[text] in said for said in path.assumed), path.assumed


@pytest.mark.parametrize("text", [text for text in SAID if text.startswith(("CYCLE", "S"))])
def test_cycles_that_stop_a_control_are_refused_where_that_is_asked_for(text):
    strict = msgspec.structs.replace(SINUMERIK, options=SINUMERIK.options | {"strict_cycles": True})
    assert "not read" in refusal(f"G1 X1\n{text}\nG1 X3", controller=strict)


def test_words_of_a_group_may_stand_twice_and_groups_beside_each_other():
    path = read("G90 G90 G1 G17 G54 G64 G94 G40 X10 M3 M8\nG0 G153 Z60", "xyzac-trunnion", start=START)
    assert path.tip[-2] * 1e3 == pytest.approx([10, 0, 50])


@pytest.mark.parametrize(
    ("alarm", "call"),
    [
        (61000, "D0\nCYCLE90(10,0,2,-20,,20,18,1,500,2,0,0,0)"), (61101, "CYCLE90(10,0,2,1,,20,18,1,500,2,0,0,0)"),
        (61109, "CYCLE90(10,0,2,-20,,20,18,1,500,7,0,0,0)"), (61119, "CYCLE90(10,0,2,-20,,0,0,1,500,2,0,0,0)"),
        (61120, "CYCLE90(10,0,2,-20,,20,18,1,500,2,9,0,0)"), (61007, "CYCLE90(10,0,2,-20,,5,4,1,500,2,0,0,0)"),
    ],
)  # fmt: skip
def test_threads_that_stop_a_control_are_refused(alarm, call):
    sheet = SetUp(tools={"1": Tool(0.1, 0.004)})
    head = "T1 D1 M6\nG0 X0 Y0 Z50\n"
    assert not refusal(f"{head}CYCLE90(10,0,2,-20,,20,18,1,500,2,0,0,0)", start="G54 G710 F500\n", setup=sheet)
    assert refusal(f"{head}{call}", start="G54 G710 F500\n", setup=sheet)
    # the path that G41 follows tells nothing of what a cycle compensates itself
    said = refusal(f"{head}CYCLE90(10,0,2,-20,,20,18,1,500,2,0,0,0)", start="G54 G710 F500\n", compensation="program")
    assert "needs the radius of the tool" in said

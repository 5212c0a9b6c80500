"""Alarms that a program alone raises on Fanuc and Haas: each is refused here. The page on them is
docs/design/fanuc_alarms.md, which says of the others why not."""

from __future__ import annotations

import pytest

import toolpace as tp
from toolpace.common.errors import ToolpaceError

MACHINE = tp.Machine.load("xyzbc-trunnion")
HEAD = "%\nO1000\nG21 G90 G94 G17 G40 G49 G80\nT1 M6\nG54\nG43 H1\nG0 X0. Y0. Z50. B0. C0.\nG1 F500. X1.\n"
CYCLE = "G81 X5. Y5. Z-5. R2. F100.\n"


def said(body, controller="fanuc"):
    """The refusal of a program, or ""."""
    text = body if body.startswith("%") else f"{HEAD}{body}\nM30\n%\n"
    try:
        tp.read_text(text, MACHINE, controller=controller)
    except ToolpaceError as error:
        return str(error)
    return ""


FANUC = [
    ("PS0003", "G1 X1234567890.1", "beyond"),
    ("PS0004", "1.5 X1.", "no letter before it"),
    ("PS0005", "G1 X Y1.", "no number after it"),
    ("PS0006", "G43 H-1", "no number of a tool"),
    ("PS0007", "G1 X1.2.3", "no letter before it"),
    ("PS0009", "G1 X1. ?", "no meaning"),
    ("PS0010", "G1.7 X1.", "G1.7 is not read"),
    ("PS0011", "G1 F0 X5.", "no F above zero"),
    ("PS0011", "%\nO1\nG21 G90\nG0 X0. Y0. Z0.\nG1 X5.\nM30\n%\n", "feed missing"),
    ("PS0011", "G93 G1 X5.", "feed missing"),
    ("PS0015", "G1 X1. Y1. A5.", "no axis A"),
    ("PS0020", "G2 X10. Y0. I3. J0.", "off its circle"),
    ("PS0021", "G2 X5. Y5. K3.", "lacks its centre"),
    ("PS0022", "G2 X10. Y5.", "lacks its centre"),
    ("PS0028", "G17 X1. U5.", "no axis U"),
    ("PS0030", "G43 H1.5", "no number of a tool"),
    ("PS0031", "G10 L2 P7 X1.", "no work offset"),
    ("PS0031", "G10 L20 P0 X1.", "needs the number of an offset"),
    ("PS0031", "G10 L20 P301 X1.", "is no offset"),
    ("PS0046", "G30 P5 Z0.", "no reference point"),
    ("PS0051", "G1 X10. ,R2.\nG4 P100\nM8", ",R is not read"),
    ("PS0051 and a function", "G1 X10. Y0 ,R2.\nM8\nY10.", ",R is not read"),
    ("PS0051 and a dwell", "G1 X10. Y0 ,C2.\nG4 P100\nY10.", ",C is not read"),
    ("PS0052", "G1 X10. ,R2.\nG0 X10. Y10.", ",R is not read"),
    ("PS0053", "G1 X10. ,R2. ,C3.\nY10.", ",C is not known here"),
    ("PS0055", "G1 X10. ,R20.\nX11. Y1.", "takes"),
    ("PS0060", "GOTO 77", "no block N77"),
    ("PS0078", "M98 P4711", "is not in this file"),
    ("PS0076", "M98", "needs what it calls as P"),
    ("PS0076", "G65 A1.", "needs the macro's number as P"),
    ("PS0078", "%\nO1\nG21 G90 F500.\nG0 X0. Y0. Z0.\nM98 P100\nM30\nO100\nX9.\nM99 P77\n%\n", "no block N77"),
    ("PS0111", "#1=EXP[1000]", "no number"),
    ("PS0112", "#1=5/0", "division by zero"),
    ("PS0113", "#1=FOO[3]", "no function"),
    ("PS0114", "#1=[3+4", "is missing"),
    ("PS0115", "#99999999=1", "cannot be set"),
    ("PS0116", "#4001=5", "belongs to the controller"),
    ("PS0119", "#1=SQRT[-4]", "no number"),
    ("PS0119", "#1=ASIN[2]", "no number"),
    ("PS0124", "WHILE [1 EQ 0] DO1\nX5.", "lacks its beginning or its end"),
    ("PS0125", "IF [1 EQ 1] X5.", "GOTO or THEN is missing"),
    ("PS0126", "WHILE [1 EQ 0] DO4\nEND4", "DO and END take"),
    ("PS0127", "X2. #1=5", "beside other words"),
    ("PS0128", "GOTO 100000", "no block N100000"),
    ("PS0142", "G51 X0. Y0. Z0. P0", "by zero"),
    ("PS0144", "G68 X0. Y0. R30.\nX1. Y1.\nG18 G68 X0. Z0. R20.\nX2. Z2.", "another plane"),
    ("PS0144", "G68 X0. Y0. R30.\nX1. Y1.\nG18 G2 X5. Z5. R10.", "another plane"),
    ("PS0175", "G7.1 C10.", "G7.1 is not read"),
    ("PS0176", "G12.1", "G12.1 is not read"),
    ("PS0200", "G84 X5. Z-5. R2. S-100", "below zero"),
    ("PS0206", "G84 X5. Z-5. R2. F100.\nG18\nX10.", "lacks"),
    ("PS0212", "G18\nG1 X10. Y0. ,R2.\nY10.", ",R is not read"),
    ("G29", "G29 X5. Y5. Z5.", "none did"),
    ("M198", "M198 P1", "M198 is not read"),
    ("PS1144", "G10 L99 P1", "L99"),
    ("PS5010", "%\nO1\nG21 G90\nG0 X0. Y0. Z0.\nG1 X5. F100.\n", "cut off"),
    ("PS5044", "G68 X0. Y0. Z0. I1 J0 K0", "needs its angle"),
    ("PS5421", "G43.5 H1\nG1 X5. B10.", "rotary word under G43.5"),
    ("G43.5", "G43.5 H1\nG1 X5. I0 J0 K0", "is zero"),
    ("PS5457", "G68.2 X0. Y0. Z0. I10. J20. K30. R5.", "with Q or R"),
    ("PS5457", "G68.2 P5 X0. Y0. Z0. I10.", "no way to tell a plane"),
    ("PS5457", "G68.2 P2 Q1 X0. Y0. Z0.\nG68.2 P2 Q2 X10. Y0. Z0.\nG68.2 P2 Q3 X20. Y0. Z0.", "on one line"),
    ("PS5457", "G68.2 P3 Q1 X0. Y0. Z0. I1. J0 K0\nG68.2 P3 Q2 I1. J0 K1.", "not square"),
    ("PS5457", "G68.2 P3 Q1 X0. Y0. Z0. I1. J0 K0\nG53.1", "not whole"),
    ("PS5457", "G68.2 P2 Q1 X0. Y0. Z0.\nG68.2 P2 Q1 X1. Y0. Z0.", "each once"),
    ("PS5457", "G68.2 P1 X0. Y0. Z0. I10. Q112", "Q112"),
    ("PS5457", "G68.3 X0. Y0.", "without X, Y and Z"),
    ("PS5458", "G53.1", "without a tilted plane"),
    ("PS5458", "G53.6", "without a tilted plane"),
    ("PS5462", "G68.2 X0. Y0. Z0. I0. J20. K0.\nG53.1\nG55\nX1. Y1.", "G55 in turned"),
    ("PS5462", "G68.2 X0. Y0. Z0. I0. J20. K0.\nG53.1\nX1. Y1. Z50.\nG92 X5.", "G92 in turned"),
    ("PS5462", "G68.4 X0. Y0. Z0. I0. J20. K0.", "without a plane in force"),
    ("PS5462", "G0 C20.\nG43.4 H1\nX1. Y1.\nG68.2 X0. Y0. Z0. J20.\nG53.1\nX1. Y1.", "began with the table turned"),
    ("5010", "%\nO1\nG21 G90 F500.\nG0 X0. Y0. Z0.\nM98 P100\nM30\nO100\nX9.\n%\n", "without M99"),
    # what the control passes over, or does otherwise than it says
    ("G53", "G91 G53 Z0.", "G53 under G91"),
    ("G54.1", "G54.1 P0", "is no offset"),
    ("G54.1", "G54.1", "needs the number of its offset"),
    ("G4", "G4 P-5", "is not between 0 and a day"),
    ("G43.8", "G43.8 H1 D1", "G43.8 is not read"),
    ("G51 and Q", "G51 X0. Y0. Z0. P2000\nG83 X5. Z-5. R2. Q1. F100.", "Q of a cycle in scaled"),
    ("G51 and arcs", "G51 X0. Y0. Z0. I2000 J1000 K1000\nG2 X10. Y0. R8.", "scaled unevenly"),
    ("G68 alone", "G68 X5. Y5. R90.\nG1 X3.", "one axis alone behind G68"),
    ("G51.1 in G68", "G68 X5. Y5. R90.\nG51.1 X0.", "G51.1 in turned coordinates"),
    ("G51 in G68", "G68 X5. Y5. R90.\nG51 X0. Y0. P2000", "G51 in turned coordinates"),
    ("G50 in G68", "G51 X0. Y0. P2000\nG68 X5. Y5. R90.\nX0. Y0.\nG50", "G50 in turned coordinates"),
    ("G51.1 in G51", "G51 X0. Y0. P2000\nG51.1 X0.", "G51.1 in scaled coordinates"),
    ("G52 in G68", "G68 X5. Y5. R90.\nG52 X5.", "G52 in turned"),
    ("G55 in G51.1", "G51.1 X5.\nG55", "G55 in turned"),
    ("G10 in G51", "G51 X0. Y0. P2000\nG10 L2 P1 X5.", "G10 in turned"),
    ("G68 in G51 I-1", "G51 X0. Y0. Z0. I-1000 J1000 K1000\nG68 X0. Y0. R30.\nX5. Y5.", "scales below zero"),
    ("G68 in G68", "G68 X5. Y5. Z0. I0 J0 K1. R30.\nX0. Y0.\nG68 X0. Y0. R10.\nX5. Y5.", "in a three-dimensional turn"),
    ("G91 G51.1", "G91 G51.1 X5.", "G51.1 under G91"),
    ("G43.4 H", "G43.4 H1\nX5. Y5. Z50.\nX6. H2", "H2 alone"),
    ("G68 about X", "G68 X0. Y0. Z0. I1. J0 K0 R30.", "vector that is not the tool's"),
    ("G53.1 P", "G68.2 X0. Y0. Z0. J20.\nG53.1 P1", "G53.1 P1 is not read"),
]
HAAS = [
    ("302", "G2 X10. Y0. R2.", "radius"),
    ("303", "G2 X10. Y0. I3. J0.", "off its circle"),
    ("304", "G2 X10. Y5.", "lacks its centre"),
    ("310", "G1.7 X1.", "G1.7 is not read"),
    ("310", "G68.2 X0. Y0. Z0. I0 J20. K0", "no word of this control"),
    ("310", "G53.1", "no word of this control"),
    ("313", "M98", "needs what it calls as P"),
    ("314", "M98 P4711", "is not in this file"),
    ("315", "M97 P77", "N77 is called"),
    ("320", "%\nO1\nG21 G90\nG0 X0. Y0. Z0.\nG1 X5.\nM30\n%\n", "feed missing"),
    ("322", "%\nO1\nG21 G90 F500.\nG0 X0. Y0. Z0.\nM98 P100\nM30\nO100\nX9.\n%\n", "without M99"),
    ("324", "G4 P-5", "is not between 0 and a day"),
    ("326", "G4", "needs its time"),
    ("308", "G43 H-1", "no number of a tool"),
    ("H", "G43 H1 Z50.\nZ40. H2", "H2 alone"),
    ("331", "G154 P100", "is no offset"),
    ("339", "G0 G1 X5.", "exclude each other"),
    ("339", "G90 G91 X5.", "exclude each other"),
    ("339", "X1. X2.", "stands twice"),
    ("S", "S-100", "below zero"),
]  # fmt: skip


@pytest.mark.parametrize(("alarm", "body", "message"), FANUC, ids=[f"{a}-{k}" for k, (a, _, _) in enumerate(FANUC)])
def test_what_fanuc_stops_with_an_alarm_is_refused(alarm, body, message):
    assert message in said(body)


@pytest.mark.parametrize(("alarm", "body", "message"), HAAS, ids=[f"{a}-{k}" for k, (a, _, _) in enumerate(HAAS)])
def test_what_haas_stops_with_an_alarm_is_refused(alarm, body, message):
    assert message in said(body, "haas")


@pytest.mark.parametrize("controller", ["fanuc", "haas"])
def test_the_program_around_them_is_read(controller):
    assert not said("G1 X2.", controller)
    assert not said(f"{CYCLE}G80\nG91 G28 Z0.\nG90 G53 G0 Z0.", controller)

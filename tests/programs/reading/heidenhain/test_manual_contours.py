"""Worked examples of contours in the manuals, word by word, and where they lead.

"TNC 640 Klartext Programming" and "iTNC 530 Conversational": chapters "Programming contours", "Subprograms and program
section repeats", "Q parameters". The places follow from the drawings' dimensions and plane geometry written here.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.heidenhain import read

ROOT3 = math.sqrt(3.0)
TOOL = "TOOL CALL 1 Z S4000\n"


def unit(x, y):
    return np.array([x, y]) / math.hypot(x, y)


def right_of(way):
    return np.array([way[1], -way[0]])


def polar(centre, radius, degrees):
    angle = math.radians(degrees)
    return centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)


def middle_of_tangent_arc(start, way, end):
    """The place halfway along an arc that leaves a place in a direction: on its bisector, by the angle of the chord."""
    start, chord = np.array(start, float), np.array(end, float) - np.array(start, float)
    way = unit(*way)
    half = math.atan2(way[0] * chord[1] - way[1] * chord[0], way @ chord)
    c, s = math.cos(half / 2.0), math.sin(half / 2.0)
    length = math.hypot(*chord) / (2.0 * math.cos(half / 2.0))
    return tuple(start + length * np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]]))


def touching(start, centre, radius, sense):
    """Where a line from a place touches a circle that it then goes round: sense 1 counter-clockwise, -1 clockwise."""
    start, centre = np.array(start, float), np.array(centre, float)
    to = centre - start
    far, bearing = math.hypot(*to), math.atan2(to[1], to[0])
    along = math.sqrt(far**2 - radius**2)
    angle = bearing - sense * math.asin(radius / far)
    return tuple(start + along * np.array([math.cos(angle), math.sin(angle)]))


def passes(tip, places):
    """Whether a polyline (n, 3) comes by places, in their order, within a micrometre; a place may leave Z out."""
    at, share = 0, 0.0
    for place in places:
        place = np.array([*place, math.nan][:3], float)
        known = np.isfinite(place)
        for k in range(at, len(tip) - 1):
            first, way = tip[k][known], (tip[k + 1] - tip[k])[known]
            length = way @ way
            least = share if k == at else 0.0
            here = min(max((place[known] - first) @ way / length, least), 1.0) if length > 0.0 else least
            if np.linalg.norm(first + here * way - place[known]) < 1e-3:
                at, share = k, here
                break
        else:
            return f"does not come by {place}"
    return ""


def tips(text):
    return read(text, begin="", compensation="program").tip * 1e3


CHAMFER = unit(40, 5), unit(5, -35)
ROUND = unit(30, -15), unit(-30, -20)
TANGENT = 5.0 / math.tan(math.acos(-ROUND[0] @ ROUND[1]) / 2.0)
LOW, HIGH = 20.0 - math.sqrt(175.0), 20.0 + math.sqrt(175.0)
ACROSS = right_of(unit(10, 15))
P = np.array([10.0, 20.0])
SIDE = 15.0 / math.sqrt(2.0)
ELEMENTS = {
    "Straight line L": ("L X+10 Y+40 RL F200 M3\nL IX+20 IY-15\nL X+60 IY-10", [(10, 40), (30, 25), (60, 15)]),
    "Chamfer CHF": (
        "L X+0 Y+30 RL F300 M3\nL X+40 IY+5\nCHF 12 F250\nL IX+5 Y+0",
        [(0, 30), (40, 35) - 12 * CHAMFER[0], (40, 35) + 12 * CHAMFER[1], (45, 0)],
    ),
    "Rounding RND": (
        "L X+10 Y+40 RL F300 M3\nL X+40 Y+25\nRND R5 F100\nL X+10 Y+5",
        [(10, 40), (40, 25) - TANGENT * ROUND[0], (40, 25) + TANGENT * ROUND[1], (10, 5)],
    ),
    "Circle centre CC": ("L X+25 Y+25 F100\nCC\nLP PR+10 PA+90", [(25, 25), (25, 35)]),
    "Circular path C around CC": (
        "CC X+25 Y+25\nL X+45 Y+25 RR F200 M3\nC X+45 Y+25 DR+", [(45, 25), (25, 45), (5, 25), (25, 5), (45, 25)],
    ),
    "Circular path CR, arc 1": ("L X+40 Y+40 RL F200 M3\nCR X+70 Y+40 R+20 DR-", [(40, 40), (55, 40 + LOW), (70, 40)]),
    "Circular path CR, arc 2": ("L X+40 Y+40 RL F200 M3\nCR X+70 Y+40 R+20 DR+", [(40, 40), (55, 40 - LOW), (70, 40)]),
    "Circular path CR, arc 3": ("L X+40 Y+40 RL F200 M3\nCR X+70 Y+40 R-20 DR-", [(40, 40), (55, 40 + HIGH), (70, 40)]),
    "Circular path CR, arc 4": ("L X+40 Y+40 RL F200 M3\nCR X+70 Y+40 R-20 DR+", [(40, 40), (55, 40 - HIGH), (70, 40)]),
    "Circular path CT": (
        "L X+0 Y+25 RL F300 M3\nL X+25 Y+30\nCT X+45 Y+20\nL Y+0",
        [(0, 25), (25, 30), middle_of_tangent_arc((25, 30), (25, 5), (45, 20)), (45, 20), (45, 0)],
    ),
    "Straight line LP": (
        "CC X+45 Y+25\nLP PR+30 PA+0 RR F300 M3\nLP PA+60\nLP IPA+60\nLP PA+180",
        [(75, 25), (60, 25 + 15 * ROOT3), (30, 25 + 15 * ROOT3), (15, 25)],
    ),
    "Circular path CP around pole CC": (
        "CC X+25 Y+25\nLP PR+20 PA+0 RR F250 M3\nCP PA+180 DR+", [(45, 25), (25, 45), (5, 25)],
    ),
    "Circular path CTP": (
        "CC X+40 Y+35\nL X+0 Y+35 RL F250 M3\nLP PR+25 PA+120\nCTP PR+30 PA+30\nL Y+0",
        [(0, 35), (27.5, 35 + 12.5 * ROOT3),
         middle_of_tangent_arc((27.5, 35 + 12.5 * ROOT3), (27.5, 12.5 * ROOT3), (40 + 15 * ROOT3, 50)),
         (40 + 15 * ROOT3, 50), (40 + 15 * ROOT3, 0)],
    ),
    "Helix": (
        "CC X+40 Y+25\nL Z+0 F100 M3\nLP PR+3 PA+270 RL F50\nCP IPA-1800 IZ+5 DR-",
        [(40, 22, 0), (37, 25, 0.25), (40, 28, 0.5), (43, 25, 0.75), *((40, 22, k) for k in range(1, 6))],
    ),
    "Approach APPR LT": (
        "L X+40 Y+10 R0 FMAX M3\nAPPR LT X+20 Y+20 Z-10 LEN15 RR F100\nL X+35 Y+35",
        [(40, 10, 0), (20 - SIDE, 20 - SIDE, 0), (20 - SIDE, 20 - SIDE, -10), (20, 20, -10), (35, 35, -10)],
    ),
    "Approach APPR LN": (
        "L X+40 Y+10 R0 FMAX M3\nAPPR LN X+10 Y+20 Z-10 LEN15 RR F100\nL X+20 Y+35",
        [(40, 10, 0), (*(P + 15 * ACROSS), -10), (10, 20, -10), (20, 35, -10)],
    ),
    "Approach APPR CT": (
        "L X+40 Y+10 R0 FMAX M3\nAPPR CT X+10 Y+20 Z-10 CCA180 R+10 RR F100\nL X+20 Y+35",
        [(40, 10, 0), (*(P + 20 * ACROSS), -10), (*(P + 10 * ACROSS - 10 * unit(10, 15)), -10), (10, 20, -10),
         (20, 35, -10)],
    ),
    "Approach APPR LCT": (
        "L X+40 Y+10 R0 FMAX M3\nAPPR LCT X+10 Y+20 Z-10 R10 RR F100\nL X+20 Y+35",
        [(40, 10, 0), (*touching((40, 10), P + 10 * ACROSS, 10, -1), -10), (10, 20, -10), (20, 35, -10)],
    ),
    "Departure DEP LT": ("L X+30 Y+35 RR F100\nL Y+20 RR F100\nDEP LT LEN12.5 F100", [(30, 20), (30, 7.5)]),
    "Departure DEP LN": ("L X+30 Y+35 RR F100\nL Y+20 RR F100\nDEP LN LEN+20 F100", [(30, 20), (10, 20)]),
    "Departure DEP CT": (
        "L X+30 Y+35 RR F100\nL Y+20 RR F100\nDEP CT CCA180 R+8 F100", [(30, 20), (22, 12), (14, 20)],
    ),
    "Departure DEP LCT": (
        "L X+30 Y+35 RR F100\nL Y+20 RR F100\nDEP LCT X+10 Y+12 R+8 F100",
        [(30, 20), touching((10, 12), (22, 20), 8, 1), (10, 12)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("section", ELEMENTS)
def test_examples_of_elements(section):
    text, places = ELEMENTS[section]
    way = tips(f"{TOOL}L X+0 Y+0 Z+0 R0 FMAX\n{text}")
    assert passes(way, places) == ""
    assert np.allclose(way[-1][: len(places[-1])], places[-1], atol=1e-6)


def test_a_place_that_is_not_on_the_way_is_seen():
    text, places = ELEMENTS["Rounding RND"]
    way = tips(f"{TOOL}L X+0 Y+0 Z+0 R0 FMAX\n{text}")
    assert passes(way, [places[0], (40, 25)]) and passes(way, places[::-1]) and passes(way, [(10, 40, 0.01)])


DOWN = "L Z+250 R0 FMAX\n{}L Z-5 R0 F1000 M3\n"
PROGRAMS = {
    "Example: Linear movements and chamfers with Cartesian coordinates": (
        DOWN.format("L X-10 Y-10 R0 FMAX\n")
        + "APPR LT X+5 Y+5 LEN10 RL F300\nL Y+95\nL X+95\nCHF 10\nL Y+5\nCHF 20\n"
        "L X+5\nDEP LT LEN10 F1000\nL Z+250 R0 FMAX M2",
        [(-10, -10, -5), (5, -5), (5, 5), (5, 95), (85, 95), (95, 85), (95, 25), (75, 5), (5, 5), (-5, 5),
         (-5, 5, 250)],
    ),
    "Example: Circular movements with Cartesian coordinates": (
        DOWN.format("L X-10 Y-10 R0 FMAX\n")
        + "APPR LCT X+5 Y+5 R5 RL F300\nL X+5 Y+85\nRND R10 F150\nL X+30 Y+85\n"
        "CR X+70 Y+95 R+30 DR-\nL X+95\nL X+95 Y+40\nCT X+40 Y+5\nL X+5\nDEP LCT X-20 Y-20 R5 F1000\nL Z+250 R0 "
        "FMAX M2",
        [(-10, -10, -5), touching((-10, -10), (0, 5), 5, 1), (5, 5), (5, 75),
         (15 - 5 * math.sqrt(2), 75 + 5 * math.sqrt(2)), (15, 85), (30, 85), (70, 95), (95, 95), (95, 40),
         middle_of_tangent_arc((95, 40), (0, -55), (40, 5)), (40, 5), (5, 5), (-20, -20), (-20, -20, 250)],
    ),
    "Example: Full circle with Cartesian coordinates": (
        "CC X+50 Y+50\n" + DOWN.format("L X-40 Y+50 R0 FMAX\n") + "APPR LCT X+0 Y+50 R5 RL F300\nC X+0 DR-\n"
        "DEP LCT X-40 Y+50 R5 F1000\nL Z+250 R0 FMAX M2",
        [(-40, 50, -5), touching((-40, 50), (-5, 50), 5, 1), (0, 50), (50, 100), (100, 50), (50, 0), (0, 50), (-40, 50),
         (-40, 50, 250)],
    ),
    "Example: Linear movement with polar coordinates": (
        "CC X+50 Y+50\nL Z+250 R0 FMAX\nLP PR+60 PA+180 R0 FMAX\nL Z-5 R0 F1000 M3\nAPPR PLCT PR+45 PA+180 R5 RL F250\n"
        "LP PA+120\nLP PA+60\nLP PA+0\nLP PA-60\nLP PA-120\nLP PA+180\nDEP PLCT PR+60 PA+180 R5 F1000\n"
        "L Z+250 R0 FMAX M2",
        [(-10, 50, -5), *(polar((50, 50), 45, angle) for angle in (180, 120, 60, 0, -60, -120, 180)), (-10, 50),
         (-10, 50, 250)],
    ),
    "Example: Helix": (
        "L Z+250 R0 FMAX\nL X+50 Y+50 R0 FMAX\nCC\nL Z-12.75 R0 F1000 M3\nAPPR PCT PR+32 PA-180 CCA180 R+2 RL F100\n"
        "CP IPA+3240 IZ+13.5 DR+ F200\nDEP CT CCA180 R+2\nL Z+250 R0 FMAX M2",
        [(50, 50, -12.75), (18, 50, -12.75), *((18, 50, -12.75 + 1.5 * k) for k in range(1, 10)), (22, 50)],
    ),
    "Example: Helix, with a program section repeat": (
        "L Z+250 R0 FMAX\nL X+50 Y+50 R0 FMAX\nCC\nL Z-12.75 R0 F1000 M3\nAPPR PCT PR+32 PA-180 CCA180 R+2 RL F100\n"
        "LBL 1\nCP IPA+360 IZ+1.5 DR+ F200\nCALL LBL 1 REP 8\nDEP CT CCA180 R+2\nL Z+250 R0 FMAX M2",
        [(18, 50, -12.75), *((18, 50, -12.75 + 1.5 * k) for k in range(1, 10)), (22, 50)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("section", PROGRAMS)
def test_examples_of_programs(section):
    text, places = PROGRAMS[section]
    assert passes(tips(TOOL + text), places) == ""


ELLIPSE = """
FN 0: Q1 = +50
FN 0: Q2 = +50
FN 0: Q3 = +50
FN 0: Q4 = +30
FN 0: Q5 = +0
FN 0: Q6 = +360
FN 0: Q7 = +40
FN 0: Q8 = +{}
FN 0: Q9 = +5
FN 0: Q10 = +100
FN 0: Q11 = +350
FN 0: Q12 = +2
L Z+250 R0 FMAX
CALL LBL 10
L Z+250 R0 FMAX M2
LBL 10
CYCL DEF 7.0 DATUM SHIFT
CYCL DEF 7.1 X+Q1
CYCL DEF 7.2 Y+Q2
CYCL DEF 10.0 ROTATION
CYCL DEF 10.1 ROT+Q8
Q35 = (Q6 - Q5) / Q7
Q36 = Q5
Q37 = 0
Q21 = Q3 * COS Q36
Q22 = Q4 * SIN Q36
L X+Q21 Y+Q22 R0 FMAX M3
L Z+Q12 R0 FMAX
L Z-Q9 R0 FQ10
LBL 1
Q36 = Q36 + Q35
Q37 = Q37 + 1
Q21 = Q3 * COS Q36
Q22 = Q4 * SIN Q36
L X+Q21 Y+Q22 R0 FQ11
FN 12: IF +Q37 LT +Q7 GOTO LBL 1
CYCL DEF 10.0 ROTATION
CYCL DEF 10.1 ROT+0
CYCL DEF 7.0 DATUM SHIFT
CYCL DEF 7.1 X+0
CYCL DEF 7.2 Y+0
L Z+Q12 R0 FMAX
LBL 0
"""


@pytest.mark.parametrize("turn", [0, 30])
def test_example_ellipse(turn):
    """ "Programming examples", "Ellipse": 40 straight lines between points of an ellipse, turned about its centre."""
    way = tips(TOOL + ELLIPSE.format(turn))
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    angles = np.radians(9.0 * np.arange(41))
    x, y = 50.0 * np.cos(angles), 30.0 * np.sin(angles)
    wanted = np.column_stack([50.0 + c * x - s * y, 50.0 + s * x + c * y])
    cut = way[np.abs(way[:, 2] + 5.0) < 1e-9]
    assert np.allclose(cut[:41, :2], wanted, atol=1e-6)


def test_example_coordinate_transformations():
    """ "Coordinate transformation cycles": a contour about X+65 Y+65, eight times, each turned by IROT+45."""
    contour = (
        "LBL 1\nL X+0 Y+0 R0 FMAX\nL Z+2 R0 FMAX M3\nL Z-5 R0 F200\nL X+30 RL\nL IY+10\nRND R5\nL IX+20\n"
        "L IX+10 IY-10\nRND R5\nL IX-10 IY-10\nL IX-20\nL IY+10\nL X+0 Y+0 R0 F5000\nL Z+20 R0 FMAX\nLBL 0"
    )
    text = (
        "L Z+250 R0 FMAX\nCYCL DEF 7.0\nCYCL DEF 7.1 X+65\nCYCL DEF 7.2 Y+65\nCALL LBL 1\nLBL 10\nCYCL DEF 10.0\n"
        "CYCL DEF 10.1 IROT+45\nCALL LBL 1\nCALL LBL 10 REP 6/6\nCYCL DEF 10.0\nCYCL DEF 10.1 ROT+0\nCYCL DEF 7.0\n"
        "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL Z+250 R0 FMAX M2\n"
    )
    corners = [(0, 0), (30, 0), (30, 5), (35, 10), (50, 10), (50, -10), (30, -10), (30, 0), (0, 0)]
    places = []
    for k in range(8):
        c, s = math.cos(k * math.pi / 4), math.sin(k * math.pi / 4)
        places += [(65 + c * x - s * y, 65 + s * x + c * y, -5) for x, y in corners]
    assert passes(tips(TOOL + text + contour), [*places, (65, 65, 20), (65, 65, 250)]) == ""


FORMULAS = {
    "FN 0: Q5 = +60\nL X+Q5": 60, "FN 0: Q2 = +3\nFN 1: Q1 = -Q2 + -5\nL X+Q1": -8, "FN 2: Q1 = +10 - +5\nL X+Q1": 5,
    "FN 3: Q2 = +3 * +3\nL X+Q2": 9, "FN 0: Q2 = +2\nFN 4: Q4 = +8 DIV +Q2\nL X+Q4": 4,
    "FN 5: Q20 = SQRT 4\nL X+Q20": 2, "FN 0: Q5 = +30\nFN 6: Q20 = SIN -Q5\nL X+Q20": -0.5,
    "FN 0: Q5 = +60\nFN 7: Q21 = COS -Q5\nL X+Q21": 0.5, "FN 8: Q10 = +5 LEN +4\nL X+Q10": math.sqrt(41.0),
    "FN 0: Q1 = -10\nFN 13: Q20 = +25 ANG -Q1\nL X+Q20": math.degrees(math.atan2(25.0, 10.0)),
    "Q1 = 5 * 3 + 2 * 10\nL X+Q1": 35, "Q2 = SQ 10 - 3^3\nL X+Q2": 73, "Q5 = 3 * (2 + 4)\nL X+Q5": 18,
}  # fmt: skip


@pytest.mark.parametrize("text", FORMULAS)
def test_examples_of_q_parameters(text):
    """ "Basic arithmetic", "Trigonometric functions", "Entering formulas directly"."""
    assert tips(f"{TOOL}L X+0 Y+0 Z+0 R0 FMAX\n{text} F100")[-1, 0] == pytest.approx(FORMULAS[text], abs=1e-6)

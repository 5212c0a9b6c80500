"""Worked examples of Siemens' manuals, against their numbers and arithmetic on them.

PF: Programming Manual Fundamentals (10.2004, 11/2006; NC Programming 12/2019, chapter 2), PJ: Job Planning, PZ:
Programming Guide Cycles (2002 to 2004), 802D: 802D sl, Operation and Programming Nibbling 06/2006, K2: Function Manual
Basic Functions. Numbers alone are theirs; what a shape L10 stands for in their pictures is a stroke of 10 mm along X.

Held against the page: the helix, totals and effects of G58 and G59, the arc by a pole in ZX, all of 802D, SCALE with
ATRANS, vectors of PJ. The others were written down from knowledge of the manuals; where a number were not theirs, the
arithmetic beside it would hold all the same.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.sinumerik import ends, last, read

CIRCLE = "G0 G90 X133 Y44.48\nG17 G1 Z-5 F1000\n"
CORNER = "G0 G90 X45 Y60 Z2\nG1 Z-5 F500\n"
NIBBLING = "G90 G0 X30 Y40\n"
PLACES = [
    # circles: PF 4.5 to 4.9, "milling", one arc by centre, radius, opening angle and in polar coordinates
    ("PF G2 with centre, incremental", f"{CIRCLE}G2 X115 Y113.3 I-43 J25.52", (115, 113.3, -5)),
    ("PF G2 with centre, absolute", f"{CIRCLE}G2 X115 Y113.3 I=AC(90) J=AC(70)", (115, 113.3, -5)),
    ("PF G2 with radius", f"{CIRCLE}G2 X115 Y113.3 CR=-50", (115, 113.3, -5)),
    ("PF G2 with opening angle and centre", f"{CIRCLE}G2 I-43 J25.52 AR=269.31", (115, 113.304, -5)),
    ("PF G2 with opening angle and end", f"{CIRCLE}G2 X115 Y113.3 AR=269.31", (115, 113.3, -5)),
    ("PF G2 in polar coordinates", f"{CIRCLE}G111 X90 Y70\nG2 RP=50 AP=60", (115, 113.301, -5)),
    ("PF G90 with AC", f"{CORNER}G2 X20 Y35 I=AC(45) J=AC(35)", (20, 35, -5)),
    ("PF G90 with I, J incremental", f"{CORNER}G2 X20 Y35 I0 J-25", (20, 35, -5)),
    ("PF G91", f"{CORNER}G91 G2 X-25 Y-25 I0 J-25", (20, 35, -5)),
    ("PF helix", "G17 G0 X27.5 Y32.99 Z3\nG1 Z-5 F50\nG3 X20 Y5 Z-20 I=AC(20) J=AC(20) TURN=2", (20, 5, -20)),
    ("PF CIP inclined", "G0 X130 Y60\nG17 G1 Z-2 F100\nCIP X80 Y120 Z-10 I1=IC(-85.35) J1=IC(-35.35) K1=-6",
     (80, 120, -10)),
    ("PF 4.10 arc by a pole in ZX", "G18\nG1 X40 Z-25\nG111 X33.33 Z-54.25\nG3 RP=30 AP=142.326",
     (33.33 + 30 * math.sin(math.radians(142.326)), 0, -54.25 + 30 * math.cos(math.radians(142.326)))),
    ("802D G2 with centre", f"{NIBBLING}G2 X50 Y40 I10 J-7", (50, 40, 0)),
    ("802D G2 with radius", f"{NIBBLING}G2 X50 Y40 CR=12.207", (50, 40, 0)),
    ("802D G2 with opening angle and end", f"{NIBBLING}G2 X50 Y40 AR=105", (50, 40, 0)),
    ("802D G2 in polar coordinates", f"{NIBBLING}G111 X40 Y33\nG2 RP=12.207 AP=21",
     (40 + 12.207 * math.cos(math.radians(21)), 33 + 12.207 * math.sin(math.radians(21)), 0)),
    ("802D CIP", f"{NIBBLING}CIP X50 Y40 I1=40 J1=45", (50, 40, 0)),
    # shifts: PF "axial programmable work offset" tells the total after each block
    ("PF G58 total 1", "TRANS X10 Y10 Z10\nG1 X0 Y0 Z0", (10, 10, 10)),
    ("PF G58 total 2", "TRANS X10 Y10 Z10\nATRANS X5 Y5\nG1 X0 Y0 Z0", (15, 15, 10)),
    ("PF G58 total 3", "TRANS X10 Y10 Z10\nATRANS X5 Y5\nG58 X20\nG1 X0 Y0 Z0", (25, 15, 10)),
    ("PF G59 total 4", "TRANS X10 Y10 Z10\nATRANS X5 Y5\nG58 X20\nG59 X10 Y10\nG1 X0 Y0 Z0", (30, 20, 10)),
    ("PF effects: G58", "G58 X10\nG1 X0 Y0 Z0", (10, 0, 0)), ("PF effects: G59", "G59 X10\nG1 X0 Y0 Z0", (10, 0, 0)),
    ("PF effects: [X,TR]", "$P_PFRAME[X,TR]=10\nG1 X0 Y0 Z0", (10, 0, 0)),
    ("PF effects: [X,FI]", "$P_PFRAME[X,FI]=10\nG1 X0 Y0 Z0", (10, 0, 0)),
    ("PF effects: ATRANS twice", "ATRANS X10\nATRANS X10\nG1 X0 Y0 Z0", (20, 0, 0)),
    ("PF effects: CTRANS", "ATRANS X7\n$P_PFRAME=CTRANS(X,10)\nG1 X0 Y0 Z0", (10, 0, 0)),
    ("PF effects: CTRANS()", "TRANS X7\n$P_PFRAME=CTRANS()\nG1 X1 Y0 Z0", (1, 0, 0)),
    ("PF effects: CFINE", "TRANS X7\n$P_PFRAME=CFINE(X,10)\nG1 X0 Y0 Z0", (10, 0, 0)),
    # scale: offsets that are programmed behind it are scaled
    ("PF SCALE with ATRANS", "SCALE X2 Y2\nATRANS X2.5 Y18\nG1 X0 Y0 Z0", (5, 36, 0)),
]  # fmt: skip


@pytest.mark.parametrize(("where", "text", "place"), PLACES, ids=[row[0] for row in PLACES])
def test_places(where, text, place):
    assert last(text) == pytest.approx(place, abs=2e-3)


RADII = [
    ("PF G2 with centre", f"{CIRCLE}G2 X115 Y113.3 I-43 J25.52", (90, 70), 50),
    ("PF G2 with radius", f"{CIRCLE}G2 X115 Y113.3 CR=-50", (90, 70), 50),
    ("PF G2 with opening angle", f"{CIRCLE}G2 X115 Y113.3 AR=269.31", (90, 70), 50),
    ("PF G2 polar", f"{CIRCLE}G111 X90 Y70\nG2 RP=50 AP=60", (90, 70), 50),
    ("PF G2, the corner", f"{CORNER}G2 X20 Y35 I0 J-25", (45, 35), 25),
    ("PF helix", "G17 G0 X27.5 Y32.99 Z3\nG1 Z-5 F50\nG3 X20 Y5 Z-20 I=AC(20) J=AC(20) TURN=2", (20, 20), 15),
    ("802D G2 with centre", f"{NIBBLING}G2 X50 Y40 I10 J-7", (40, 33), 12.207),
    ("802D G2 with radius", f"{NIBBLING}G2 X50 Y40 CR=12.207", (40, 33), 12.207),
    ("802D G2 polar", f"{NIBBLING}G111 X40 Y33\nG2 RP=12.207 AP=21", (40, 33), 12.207),
]


@pytest.mark.parametrize(("where", "text", "centre", "radius"), RADII, ids=[row[0] for row in RADII])
def test_centres_and_radii(where, text, centre, radius):
    path = read(text)
    arc = path.tip[path.block == path.block.max()] * 1e3
    assert np.hypot(*(arc[:, :2] - centre).T) == pytest.approx(np.full(len(arc), radius), abs=6e-3)


def test_the_helix_makes_two_turns_and_goes_on_to_its_end():
    """PF: "execute two full circles after the starting position, then travel to end point"; Z in proportion."""
    path = read("G17 G0 X27.5 Y32.99 Z3\nG1 Z-5 F50\nG3 X20 Y5 Z-20 I=AC(20) J=AC(20) TURN=2")
    way = path.tip[path.block >= 4] * 1e3 - [20, 20, 0]
    angle = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
    first, end = math.degrees(math.atan2(12.99, 7.5)), 270
    assert math.degrees(angle[-1] - angle[0]) == pytest.approx(720 + end - first, abs=1e-2)
    # two decimals leave the ends 0.1 micrometres off their circle, whose centre is moved by as much
    assert way[:, 2] == pytest.approx(-5 - 15 * (angle - angle[0]) / (angle[-1] - angle[0]), abs=1e-4)


def test_the_inclined_circle_passes_its_intermediate_point():
    """PF 4.10: the intermediate point is I1=IC(-85.35) J1=IC(-35.35) K1=-6."""
    path = read("G0 X130 Y60\nG17 G1 Z-2 F100\nCIP X80 Y120 Z-10 I1=IC(-85.35) J1=IC(-35.35) K1=-6")
    begin, way = path.tip[2:-1] * 1e3, np.diff(path.tip[2:], axis=0) * 1e3
    away = np.array([44.65, 24.65, -6]) - begin
    share = np.clip((away * way).sum(axis=1) / (way * way).sum(axis=1), 0, 1)
    assert np.linalg.norm(away - share[:, None] * way, axis=1).min() < 1e-3


def test_holes_in_polar_coordinates():
    """PF "polar coordinates", drilling pattern: pole X43 Y38, RP=30, first at 18 degrees, the others 72 on each."""
    text = "G111 X43 Y38\nG0 RP=30 AP=18 Z5\nAP=IC(72)\nAP=IC(72)\nAP=IC(72)\nAP=IC(72)"
    angles = np.radians([18, 90, 162, 234, 306])
    wanted = np.stack([43 + 30 * np.cos(angles), 38 + 30 * np.sin(angles), np.full(5, 5.0)], axis=1)
    assert ends(text)[-5:] == pytest.approx(wanted)


def strokes(text):
    """Begin and direction of each stroke L10 of a program: (n, 3) [mm]."""
    found = ends(f"G0 Z0\n{text}\nM30\nPROC L10\nG1 X0 Y0 Z0\nX10\nM17")[-2 * text.count("L10") :]
    return found[::2], (found[1::2] - found[::2]) / 10


def about(axis, degrees):
    """Rotation matrix (3, 3)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = [(1, 2), (2, 0), (0, 1)]["XYZ".index(axis)]
    made = np.eye(3)
    made[i, i], made[i, j], made[j, i], made[j, j] = c, -s, s, c
    return made


SPACE = about("Y", 30) @ about("X", 5)
SHAPES = [
    ("PF TRANS", "G54\nL10\nTRANS X10 Y10\nL10\nTRANS X50 Y10\nL10", [(0, 0, 0), (10, 10, 0), (50, 10, 0)],
     [(1, 0, 0)] * 3),
    ("PF ROT in the plane", "TRANS X20 Y10\nL10\nTRANS X55 Y35\nAROT RPL=45\nL10\nTRANS X20 Y40\nAROT RPL=60\nL10",
     [(20, 10, 0), (55, 35, 0), (20, 40, 0)], [(1, 0, 0), about("Z", 45)[:, 0], about("Z", 60)[:, 0]]),
    ("PF ROT in space", "TRANS X10 Y10\nL10\nATRANS X35\nAROT Y30\nAROT X5\nL10", [(10, 10, 0), (45, 10, 0)],
     [(1, 0, 0), SPACE[:, 0]]),
    ("PF machining from several sides", "L10\nTRANS X100 Z-100\nAROT Y90\nAROT Z90\nL10", [(0, 0, 0), (100, 0, -100)],
     [(1, 0, 0), (about("Y", 90) @ about("Z", 90))[:, 0]]),
    ("PF SCALE", "TRANS X15 Y15\nL10\nTRANS X40 Y20\nAROT RPL=35\nASCALE X0.7 Y0.7\nL10", [(15, 15, 0), (40, 20, 0)],
     [(1, 0, 0), 0.7 * about("Z", 35)[:, 0]]),
    ("PF SCALE, twice as large", "L10\nSCALE X2 Y2\nL10\nATRANS X2.5 Y18\nL10", [(0, 0, 0), (0, 0, 0), (5, 36, 0)],
     [(1, 0, 0), (2, 0, 0), (2, 0, 0)]),
    ("PF MIRROR", "L10\nMIRROR X0\nL10\nAMIRROR Y0\nL10\nMIRROR Y0\nL10\nMIRROR\nL10", [(0, 0, 0)] * 5,
     [(1, 0, 0), (-1, 0, 0), (-1, 0, 0), (1, 0, 0), (1, 0, 0)]),
    ("K2 chain of frames", "$P_PFRAME=CTRANS(X,10,Y,20,Z,5):CROT(Z,45)\nL10", [(10, 20, 5)], [about("Z", 45)[:, 0]]),
]  # fmt: skip


@pytest.mark.parametrize(("where", "text", "begins", "directions"), SHAPES, ids=[row[0] for row in SHAPES])
def test_shapes_in_frames(where, text, begins, directions):
    found, along = strokes(text)
    assert found == pytest.approx(np.array(begins, float), abs=1e-9)
    assert along == pytest.approx(np.array(directions, float), abs=1e-9)


VALUES = [
    ("PJ ATAN2", "ATAN2(30.5,80.1)", 20.8455), ("PJ ATAN2, second quadrant", "ATAN2(30,-80)", 159.444),
    ("PJ division", "3/4", 0.75), ("PJ DIV", "1+3 DIV 4", 1), ("PJ MOD", "3 MOD 4", 3),
    ("PF exponents", "1.874EX8/1.874EX7", 10),
]  # fmt: skip


@pytest.mark.parametrize(("where", "expression", "value"), VALUES, ids=[row[0] for row in VALUES])
def test_values(where, expression, value):
    assert last(f"G1 X={expression}")[0] == pytest.approx(value, abs=6e-4)


HOLES = [
    ("PZ CYCLE81 1", 110, "CYCLE81(110,100,2,35)", [102, 35, 110]),
    ("PZ CYCLE81 2", 110, "CYCLE81(110,102,,35)", [102, 35, 110]),
    ("PZ CYCLE81 3", 110, "CYCLE81(110,100,2,,65)", [102, 35, 110]),
    ("PZ CYCLE82", 110, "CYCLE82(110,102,4,75,,2)", [106, 75, 110]),
    ("PZ CYCLE83", 155, "CYCLE83(155,150,1,5,,100,,20,0,0,1,0)",
     [151, 100, 101, 70, 71, 50, 51, 30, 31, 17.5, 18.5, 5, 155]),
    ("PZ CYCLE84", 40, "CYCLE84(40,36,2,,30,,3,5,,90,200,500)", [38, 6, 38, 40]),
    ("PZ CYCLE86", 112, "CYCLE86(112,110,,77,0,2,3,-1,-1,1,45)", [110, 77, 78, 112]),
    ("PZ CYCLE87", 113, "CYCLE87(113,110,2,77,,3)", [112, 77, 113]),
    ("PZ CYCLE88", 105, "CYCLE88(105,102,3,,72,3,4)", [105, 30, 105]),
    ("PZ CYCLE89", 107, "CYCLE89(107,102,5,72,,3)", [107, 72, 107]),
]  # fmt: skip


@pytest.mark.parametrize(("where", "above", "call", "heights"), HOLES, ids=[row[0] for row in HOLES])
def test_heights_of_cycles(where, above, call, heights):
    path = read(f"S500 M3\nG0 X40 Y120 Z{above}\n{call}")
    found = np.round(path.tip[path.block >= path.block.max() - 1, 2] * 1e3, 6)
    changed = found[np.append(True, np.diff(found) != 0)]
    assert changed[-len(heights) :] == pytest.approx(heights)
    assert path.tip[-1, :2] * 1e3 == pytest.approx([40, 120])


PATTERNS = [
    ("PZ HOLES2", "HOLES2(70,60,42,33,0,4)",
     [(70 + 42 * math.cos(math.radians(a)), 60 + 42 * math.sin(math.radians(a))) for a in (33, 123, 213, 303)]),
    ("PZ HOLES1", "HOLES1(30,20,90,10,20,5)", [(30, 30 + 20 * k) for k in range(5)]),
    ("PZ CYCLE801", "CYCLE801(30,20,0,10,15,5,3)", [(30 + 10 * i, 20 + 15 * j) for i in range(5) for j in range(3)]),
]  # fmt: skip


@pytest.mark.parametrize(("where", "call", "places"), PATTERNS, ids=[row[0] for row in PATTERNS])
def test_patterns_of_holes(where, call, places):
    """PZ: four holes on a circle, five in a row whose first is 10 mm from its reference point, a grid of 5 by 3."""
    path = read(f"MCALL CYCLE82(5,0,2,-30)\n{call}\nMCALL")
    bottoms = path.tip[np.isclose(path.tip[:, 2], -0.03)] * 1e3
    assert np.array(sorted(np.round(bottoms[:, :2], 6).tolist())) == pytest.approx(np.array(sorted(places)), abs=1e-5)


DIRECTIONS = [
    ("PJ vector along Z", "A3=0 B3=0 C3=1", (0, 0, 1)),
    ("PJ vector turned by 45 degrees", "A3=0 B3=1 C3=1", (0, math.sqrt(0.5), math.sqrt(0.5))),
    ("PJ RPY of the picture", "ORIRPY A2=30 B2=45 C2=90", None), ("PJ Euler", "ORIEULER A2=30 B2=45 C2=90", None),
]


@pytest.mark.parametrize(("where", "words", "direction"), DIRECTIONS, ids=[row[0] for row in DIRECTIONS])
def test_directions(where, words, direction):
    """PJ "orientation": (0, 1, 1) is (0, 1/sqrt 2, 1/sqrt 2); angles by C2, B2, A2 about Z, Y', X'', or Z, X', Z''."""
    if direction is None:
        rpy, euler = (about("Z", 90) @ about("Y", 45) @ about("X", 30)), about("Z", 30) @ about("X", 45)
        direction = (rpy if "RPY" in words else euler)[:, 2]
    path = read(f"TRAORI\nG1 X0 Y0 Z5 A3=1 C3=5\nX1 {words}", "xyzac-trunnion")
    assert path.axis[-1] == pytest.approx(direction, abs=1e-9)

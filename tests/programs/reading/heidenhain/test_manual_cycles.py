"""Worked examples of cycles and of five axes in the manuals, word by word, and where they lead.

"TNC 640 Cycle Programming" and "iTNC 530 Cycle Programming": drilling, patterns, coordinate transformations;
"TNC 640 Klartext Programming" and "iTNC 530 Conversational": multiple-axis machining, miscellaneous functions.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
from tests.support.heidenhain import MACHINE, SetUp, findings, read
from toolpace.common.errors import ProgramError
from toolpace.common.units import DEGREE
from toolpace.machine.machine import Machine

TOOL = "TOOL CALL 1 Z S4000\nL X+0 Y+0 Z+0 R0 FMAX\n"


def ends(text, machine=None, **options):
    """Tips (n, 3) [mm] at the ends of blocks, each as often as the tool comes there."""
    return read(text, machine, begin=TOOL, **options).tip * 1e3


def bottoms(text):
    """Where holes end (n, 3) [mm]: the lowest places of the way, as the tool comes to them."""
    tip = ends(text)
    low = (tip[1:-1, 2] < tip[:-2, 2] - 1e-9) & (tip[1:-1, 2] <= tip[2:, 2] - 1e-9)
    found = tip[1:-1][low]
    deepest = found[found[:, 2] < found[:, 2].min() + 1e-6]
    return np.round(deepest, 6)


def on_circle(x, y, radius, start, step, count):
    angles = [math.radians(start + step * k) for k in range(count)]
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def turned(axis, degrees):
    c, s = math.cos(degrees * DEGREE), math.sin(degrees * DEGREE)
    rows = [[[1, 0, 0], [0, c, -s], [0, s, c]], [[c, 0, s], [0, 1, 0], [-s, 0, c]], [[c, -s, 0], [s, c, 0], [0, 0, 1]]]
    return np.array(rows[axis])


TWO = "L X+30 Y+20 R0 FMAX M3\nCYCL CALL\nL X+80 Y+50 FMAX M99\nL Z+100 FMAX"
DRILLING = {
    "200": ("Q200=2 Q201=-15 Q206=250 Q202=5 Q210=0 Q203=+20 Q204=100 Q211=0.1", 5),
    "201": ("Q200=2 Q201=-15 Q206=100 Q211=0.5 Q208=250 Q203=+20 Q204=100", 5),
    "203": ("Q200=2 Q201=-20 Q206=150 Q202=5 Q210=0 Q203=+20 Q204=50 Q212=0.2 Q213=3 Q205=3 Q211=0.25 Q208=500 "
            "Q256=0.2", 0),
    "205": ("Q200=2 Q201=-80 Q206=150 Q202=15 Q203=+100 Q204=50 Q212=0 Q205=3 Q258=0.5 Q259=1 Q257=5 Q256=0.2 "
            "Q211=0.25 Q379=0 Q253=750", 20),
    "206": ("Q200=2 Q201=-20 Q206=150 Q211=0.25 Q203=+25 Q204=50", 5),
    "207": ("Q200=2 Q201=-20 Q239=+1 Q203=+25 Q204=50", 5),
}  # fmt: skip


@pytest.mark.parametrize("number", DRILLING)
def test_examples_of_drilling(number):
    """Each cycle's "Example: NC blocks": holes from the surface Q203 to the depth Q201; that of 205
    without the starting depth Q379 and the decrement Q212."""
    words, depth = DRILLING[number]
    found = bottoms(f"L Z+100 R0 FMAX\nCYCL DEF {number} EXAMPLE ~\n {words}\n{TWO}")
    assert found.tolist() == [[30, 20, depth], [80, 50, depth]]


@pytest.mark.parametrize(
    ("words", "refused"),
    [
        (f"CYCL DEF 202 BORING ~\n {DRILLING['201'][0]} Q214=1 Q336=0\n{TWO}", "CYCL DEF 202 with Q214 of 1 to 4"),
        (f"CYCL DEF 205 UNIVERSAL PECKING ~\n {DRILLING['205'][0].replace('Q379=0', 'Q379=7.5')}\n{TWO}",
         "CYCL DEF 205 with Q379"),
        (f"CYCL DEF 205 UNIVERSAL PECKING ~\n {DRILLING['205'][0].replace('Q212=0', 'Q212=0.5')}\n{TWO}",
         "CYCL DEF 205 with Q257 that does not divide Q202"),
        (f"CYCL DEF 240 CENTERING ~\n Q200=2 Q343=1 Q201=+0 Q344=-9 Q206=250 Q211=0.1 Q203=+20 Q204=100\n{TWO}",
         "CYCL DEF 240"),
        ("PLANE PROJECTED PROPR+24 PROMIN+24 PROROT+30 STAY", "PLANE PROJECTED"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER", "FUNCTION TCPM REFPNT CENTER-CENTER"),
        ("TRANS DATUM TABLE TABLINE25", "TRANS DATUM TABLE"), ("CYCL DEF 7.1 #5", "CYCL DEF 7 #"),
        ("FL X+10 Y+10 RL", "FL"), ("L X+125 F200 M103 F20", "M103"), ("L X+0 Y+38.5 F125 M109", "M109"),
    ],
)  # fmt: skip
def test_examples_that_are_refused(words, refused):
    found = findings(f"L Z+100 R0 FMAX\n{words}\nL X+1 F100", MACHINE).refusals
    assert [refusal.word for refusal in found if refusal.word.startswith(refused)]
    assert all(refusal.cure for refusal in found)


DRILL = "L Z+250 R0 FMAX\nCYCL DEF 200 DRILLING ~\n Q200=2 Q201=-15 Q206=250 Q202=15 Q210=0 Q203={} Q204=20 Q211=0\n"
GRID = [(8 * i, 10 * j) for j in range(4) for i in range(5)]
PATTERNS = {
    "Example: Drilling cycles": (
        "L X+10 Y+10 R0 FMAX M3\nCYCL CALL\nL Y+90 R0 FMAX M99\nL X+90 R0 FMAX M99\nL Y+10 R0 FMAX M99",
        [(10, 10), (10, 90), (90, 90), (90, 10)],
    ),
    "Example: Groups of holes": (
        "L X+15 Y+10 R0 FMAX M3\nCALL LBL 1\nL X+45 Y+60 R0 FMAX\nCALL LBL 1\nL X+75 Y+10 R0 FMAX\nCALL LBL 1\n"
        "L Z+250 R0 FMAX M2\nLBL 1\nCYCL CALL\nL IX+20 R0 FMAX M99\nL IY+20 R0 FMAX M99\nL IX-20 R0 FMAX M99\nLBL 0",
        [(x + a, y + b) for x, y in ((15, 10), (45, 60), (75, 10)) for a, b in ((0, 0), (20, 0), (20, 20), (0, 20))],
    ),
    "Defining individual machining positions": (
        "PATTERN DEF POS1 (X+25 Y+33.5 Z+0) POS2 (X+15 Y+6.5 Z+0)\nCYCL CALL PAT FMAX M3", [(25, 33.5), (15, 6.5)],
    ),
    "Example: Using drilling cycles with PATTERN DEF": (
        "PATTERN DEF POS1 (X+10 Y+10 Z+0) POS2 (X+40 Y+30 Z+0) POS3 (X+20 Y+55 Z+0) POS4 (X+10 Y+90 Z+0) "
        "POS5 (X+90 Y+90 Z+0) POS6 (X+80 Y+65 Z+0) POS7 (X+80 Y+30 Z+0) POS8 (X+90 Y+10 Z+0)\nCYCL CALL PAT FMAX M13",
        [(10, 10), (40, 30), (20, 55), (10, 90), (90, 90), (80, 65), (80, 30), (90, 10)],
    ),
    "Defining a single row": (
        "PATTERN DEF ROW1 (X+25 Y+33.5 D+8 NUM5 ROT+0 Z+0)\nCYCL CALL PAT FMAX", [(25 + 8 * k, 33.5) for k in range(5)],
    ),
    "Defining a single pattern": (
        "PATTERN DEF PAT1 (X+25 Y+33.5 DX+8 DY+10 NUMX5 NUMY4 ROT+0 ROTX+0 ROTY+0 Z+0)\nCYCL CALL PAT FMAX",
        [(25 + x, 33.5 + y) for x, y in GRID],
    ),
    "Defining individual frames": (
        "PATTERN DEF FRAME1 (X+25 Y+33.5 DX+8 DY+10 NUMX5 NUMY4 ROT+0 ROTX+0 ROTY+0 Z+0)\nCYCL CALL PAT FMAX",
        [(25 + x, 33.5 + y) for x, y in GRID if x in (0, 32) or y in (0, 30)],
    ),
    "Defining a full circle": (
        "PATTERN DEF CIRC1 (X+25 Y+33 D80 START+45 NUM8 Z+0)\nCYCL CALL PAT FMAX",
        on_circle(25, 33, 40, 45, 45, 8),
    ),
    "Defining a pitch circle": (
        "PATTERN DEF PITCHCIRC1 (X+25 Y+33 D80 START+45 STEP30 NUM8 Z+0)\nCYCL CALL PAT FMAX",
        on_circle(25, 33, 40, 45, 30, 8),
    ),
    "Polar pattern (cycle 220)": (
        "CYCL DEF 220 POLAR PATTERN ~\n Q216=+50 Q217=+50 Q244=80 Q245=+0 Q246=+360 Q247=+0 Q241=8 Q200=2 Q203=+0 "
        "Q204=50 Q301=1 Q365=0",
        on_circle(50, 50, 40, 0, 45, 8),
    ),
    "Example: Polar hole patterns, first": (
        "CYCL DEF 220 POLAR PATTERN ~\n Q216=+30 Q217=+70 Q244=50 Q245=+0 Q246=+360 Q247=+0 Q241=10 Q200=2 Q203=+0 "
        "Q204=100 Q301=1 Q365=0",
        on_circle(30, 70, 25, 0, 36, 10),
    ),
    "Example: Polar hole patterns, second": (
        "CYCL DEF 220 POLAR PATTERN ~\n Q216=+90 Q217=+25 Q244=70 Q245=+90 Q246=+360 Q247=+30 Q241=5 Q200=2 Q203=+0 "
        "Q204=100 Q301=1 Q365=0",
        on_circle(90, 25, 35, 90, 30, 5),
    ),
    "Linear pattern (cycle 221)": (
        "CYCL DEF 221 CARTESIAN PATTERN ~\n Q225=+15 Q226=+15 Q237=+10 Q238=+8 Q242=6 Q243=4 Q224=+15 Q200=2 Q203=+0 "
        "Q204=50 Q301=1",
        [tuple(np.array([15, 15]) + turned(2, 15)[:2, :2] @ (10 * i, 8 * j)) for j in range(4) for i in range(6)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("section", PATTERNS)
def test_examples_of_patterns(section):
    """The holes of a pattern, in whatever order the control drills them."""
    words, places = PATTERNS[section]
    found = bottoms(DRILL.format("+0") + words)
    assert len(found) == len(places) and np.allclose(found[:, 2], -15)
    assert np.allclose(sorted(np.round(found[:, :2], 4).tolist()), sorted(np.round(places, 4).tolist()), atol=2e-4)


SHIFT = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+60\nCYCL DEF 7.2 Y+40\n"
FRAMES = {
    "Datum shift (cycle 7)": (SHIFT + "CYCL DEF 7.3 Z-5\n", lambda p: p + np.array([60, 40, -5])),
    "Mirroring (cycle 8)": (
        SHIFT + "CYCL DEF 8.0 MIRRORING\nCYCL DEF 8.1 X Y\n", lambda p: np.array([60 - p[0], 40 - p[1], p[2]]),
    ),
    "Rotation (cycle 10)": (
        SHIFT + "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+35\n", lambda p: turned(2, 35) @ p + (60, 40, 0),
    ),
    "Scaling (cycle 11)": (SHIFT + "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.75\n", lambda p: 0.75 * p + (60, 40, 0)),
    "Scaling, the block of the older manuals": (
        "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL0.99537\n", lambda p: 0.99537 * p,
    ),
    "Axis-specific scaling (cycle 26)": (
        "CYCL DEF 26.0 AXIS-SPECIFIC SCALING\nCYCL DEF 26.1 X 1.4 Y 0.6 CCX+15 CCY+20\n",
        lambda p: np.array([15.0, 20.0, 0.0]) + np.diag([1.4, 0.6, 1.0]) @ (p - np.array([15.0, 20.0, 0.0])),
    ),
    "TRANS DATUM AXIS": ("TRANS DATUM AXIS X+10 Y+25 Z+42\n", lambda p: np.array([10, 25, 42]) + p),
    "Spatial angles, A-B-C": ("PLANE SPATIAL SPA+45 SPB+0 SPC+90 STAY\n", lambda p: turned(2, 90) @ turned(0, 45) @ p),
    "PLANE SPATIAL": ("PLANE SPATIAL SPA+27 SPB+0 SPC+45 STAY\n", lambda p: turned(2, 45) @ turned(0, 27) @ p),
    "PLANE EULER": (
        "PLANE EULER EULPR45 EULNU20 EULROT22 STAY\n", lambda p: turned(2, 45) @ turned(0, 20) @ turned(2, 22) @ p,
    ),
    "PLANE RELATIV": (
        "PLANE SPATIAL SPA+27 SPB+0 SPC+45 STAY\nPLANE RELATIV SPB-45 STAY\n",
        lambda p: turned(2, 45) @ turned(0, 27) @ turned(1, -45) @ p,
    ),
}  # fmt: skip


@pytest.mark.parametrize("section", FRAMES)
def test_examples_of_frames(section):
    words, wanted = FRAMES[section]
    for place in (np.array([0.0, 0.0, 0.0]), np.array([10.0, -4.0, 7.0])):
        x, y, z = place
        tip = ends(f"{words}L X{x:+g} Y{y:+g} Z{z:+g} F500\nL IX+1", MACHINE)
        assert np.allclose(tip[-2], wanted(place), atol=1e-9)


BASE, NORMAL = np.array([0.8, -0.4, -0.42]), np.array([0.2, 0.2, 0.92])


def test_example_plane_vector():
    """ "PLANE VECTOR": X of the plane along B as far as it is across N, Z along N; both need no unit length."""
    tip = ends("PLANE VECTOR BX0.8 BY-0.4 BZ-0.42 NX0.2 NY0.2 NZ0.92 STAY\nL X+1 Y+0 Z+0 F100\nL X+0 Z+1", MACHINE)
    z = NORMAL / np.linalg.norm(NORMAL)
    x = BASE - (BASE @ z) * z
    assert np.allclose(tip[-2:], [x / np.linalg.norm(x), z], atol=1e-9)


def test_example_plane_points():
    """ "PLANE POINTS": X from P1 to P2, P3 on the side of +Y."""
    words = "P1X+0 P1Y+0 P1Z+20 P2X+30 P2Y+31 P2Z+20 P3X+0 P3Y+41 P3Z+32.5"
    tip = ends(f"PLANE POINTS {words} STAY\nL X+1 Y+0 Z+0 F100\nL X+0 Z+1", MACHINE)
    z = np.cross((30, 31, 0), (0, 41, 12.5))
    assert np.allclose(tip[-2:], [np.array([30, 31, 0]) / math.hypot(30, 31), z / np.linalg.norm(z)], atol=1e-9)


CRADLE = (Path(tp.__file__).parent / "machine" / "builtin" / "xyzac-trunnion.toml").read_text()
LIMITED = CRADLE.replace("travel = [-130, 130]", "travel = [-90, 10]")
"""The manual's machines: C table on a tilting A, without limits that count here, and with -90 < A < 10."""


@pytest.mark.parametrize(
    ("limited", "start", "sign", "wanted"),
    [
        (False, 0, "", (45, 90)), (False, 0, "SEQ+", (45, 90)), (False, 0, "SEQ-", (-45, -90)),
        (False, -105, "", (-45, -90)), (False, -105, "SEQ+", (45, 90)), (False, -105, "SEQ-", (-45, -90)),
        (True, 0, "", (-45, -90)), (True, 0, "SEQ+", None), (False, -135, "SEQ+", (45, 90)),
    ],
)  # fmt: skip
def test_the_table_of_tilting_possibilities(limited, start, sign, wanted):
    """ "Selection of tilting possibilities SEQ +/-": C table and A tilting table, PLANE SPATIAL SPA+0 SPB+45 SPC+0.

    C is the manual's but for whole turns: from -105 to 90 deg the way to -270 deg is the shorter one.
    """
    machine = Machine.from_toml(LIMITED if limited else CRADLE)
    text = f"L A+0 C{start:+d} FMAX\nPLANE SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX {sign}\nL X+1 F100"
    if wanted is None:
        with pytest.raises(ProgramError, match="out of travel"):
            read(text, machine, begin=TOOL)
        return
    path = read(text, machine, begin=TOOL)
    a, c = (path.rotary[-1, path.rotary_joints.index(name)] / DEGREE for name in "AC")
    assert a == pytest.approx(wanted[0]) and (c - wanted[1] + 180) % 360 == pytest.approx(180)


def test_example_cycle_19():
    """ "Working plane (cycle 19)": B+45 as a spatial angle, the axes by Q120 and Q122, then Z, then X and Y."""
    text = (
        "L Z+100 R0 FMAX\nL X+25 Y+10 R0 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+45 C+0\n"
        "L A+Q120 C+Q122 R0 F1000\nL Z+80 R0 FMAX\nL X-8.5 Y-10 R0 FMAX"
    )
    path = read(text, MACHINE, begin=TOOL)
    assert np.allclose(path.tip[-1] * 1e3, turned(1, 45) @ (-8.5, -10, 80), atol=1e-9)
    assert np.allclose(path.axis[-1], turned(1, 45)[:, 2], atol=1e-9)


ROTARY = [(350, 10, 20, -340), (10, 340, -30, 330)]


@pytest.mark.parametrize(("begin", "end", "shorter", "plain"), ROTARY)
def test_the_tables_of_m126(begin, end, shorter, plain):
    """ "Shorter-path traverse of rotary axes: M126": actual position, nominal position, traverse."""
    for word, way in (("M126", shorter), ("M127", plain)):
        path = read(f"L C+0 FMAX M127\nL C+{begin} FMAX\nL {word}\nL C+{end} FMAX\nL X+1 F100", MACHINE, begin=TOOL)
        assert (path.rotary[-1, 1] / DEGREE - begin) == pytest.approx(way)


def test_example_m94():
    """ "Reducing display of a rotary axis to a value less than 360: M94": from 538 to 180 it is -358, with M94 +2."""
    for word, way in (("", -358), (" M94", 2)):
        path = read(f"L C+538 FMAX\nL C+180 FMAX{word}\nL X+1 F100", MACHINE, begin=TOOL)
        assert path.rotary[-1, 1] / DEGREE - 538 == pytest.approx(way)


def test_example_m140():
    """ "Retraction from the contour in the tool-axis direction: M140": MB50 F750."""
    path = read("L Z+0 R0 FMAX\nL X+0 Y+38.5 F125 M140 MB50 F750\nL X+1", begin=TOOL)
    assert any(np.allclose(tip * 1e3, (0, 38.5, 50)) or np.allclose(tip * 1e3, (0, 0, 50)) for tip in path.tip)
    assert np.allclose(path.tip[-1] * 1e3, (1, 38.5, 50))


LN = "LN X+31.737 Y+21.954 Z+33.165 NX+0.2637581 NY+0.0078922 NZ-0.8764339 {}F1000 M128"


@pytest.mark.parametrize(
    ("vector", "wanted"),
    [("TX+0.0078922 TY-0.8764339 TZ+0.2590319 ", (0.0078922, -0.8764339, 0.2590319)),
     ("", (0.2637581, 0.0078922, -0.8764339))],
)  # fmt: skip
def test_examples_of_ln(vector, wanted):
    """ "Three-dimensional tool compensation": with and without tool orientation."""
    path = read("L X+0 Y+0 Z+50 R0 FMAX\n" + LN.format(vector), MACHINE, begin=TOOL)
    assert np.allclose(path.tip[-1] * 1e3, (31.737, 21.954, 33.165), atol=1e-9)
    assert np.allclose(path.axis[-1], np.array(wanted) / np.linalg.norm(wanted), atol=1e-9)


def test_example_of_rotary_axes_under_m128():
    """ "Peripheral milling": L X+31,737 Y+21,954 Z+33,165 B+12,357 C+5,896 RL F1000 M128."""
    machine = Machine.load("xyzbc-trunnion")
    text = "L X+0 Y+0 Z+50 R0 FMAX\nL X+31,737 Y+21,954 Z+33,165 B+12,357 C+5,896 RL F1000 M128"
    path = read(text, machine, begin=TOOL, compensation="program")
    assert np.allclose(path.tip[-1] * 1e3, (31.737, 21.954, 33.165), atol=1e-9)
    assert np.allclose(path.axis[-1], turned(2, 5.896) @ turned(1, 12.357)[:, 2], atol=1e-9)


def test_example_of_axis_spat():
    """ "Tool angle of inclination in the working plane coordinate system": L A+0 B+45 C+0 R0 F2500."""
    text = "L X+10 Y+5 Z+50 R0 FMAX\nFUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL A+0 B+45 C+0 R0 F2500"
    for machine in (MACHINE, Machine.load("xyzbc-head")):
        path = read(text, machine, begin=TOOL)
        assert np.allclose(path.axis[-1], (math.sqrt(0.5), 0, math.sqrt(0.5)), atol=1e-9)
        assert np.allclose(path.tip[-1] * 1e3, (10, 5, 50), atol=1e-9)


def test_example_dwell():
    """ "Dwell time (cycle 9)": CYCL DEF 9.1 DWELL 1.5."""
    path = read("L X+1 F100\nCYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 1.5\nL X+2", begin=TOOL)
    assert path.dwell.tolist() == [0, 1.5, 0] or path.dwell.max() == 1.5


def test_example_preset():
    """ "Presetting (cycle 247)": Q339=4 puts preset 4 in force."""
    setup = SetUp(offsets={"1": {"X": 0.0}, "4": {"X": 0.025, "Y": -0.01}})
    near, far = (
        read(f"CYCL DEF 247 PRESETTING ~\n Q339={k} ;PRESET NUMBER\nL X+0 Y+0 Z+0 R0 FMAX\nL X+1 F100", MACHINE,
             setup=setup, begin=TOOL).tip[-1]
        for k in (1, 4)
    )  # fmt: skip
    assert np.allclose((far - near) * 1e3, (25, -10, 0))

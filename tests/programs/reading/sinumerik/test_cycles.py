"""Cycles of holes (Programming Manual Cycles, chapter 2) against their motions written out by hand."""

from __future__ import annotations

import math
from fractions import Fraction

import msgspec
import numpy as np
import pytest

from tests.support.sinumerik import SINUMERIK, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.cycles.hole_geometry import strokes_of

STRICT = msgspec.structs.replace(SINUMERIK, options=SINUMERIK.options | {"strict_cycles": True})


def levels(call: str, start: str = "G54 G64 F300 S600\nG0 X0 Y0 Z50\n", **options):
    """(Z [mm], rapid, feed [mm/min], dwell) of each motion of a cycle at X10 Y20, behind the positioning."""
    path = read(f"MCALL {call}\nG0 X10 Y20\nMCALL", start=start, **options)
    assert path.tip[1:, 0] == pytest.approx(0.01) and path.tip[1:, 1] == pytest.approx(0.02)
    found = []
    for k in range(2, len(path.tip)):
        feed = 0.0 if path.rapid[k] else round(float(path.feed[k]) * 6e4, 6)
        found.append((round(float(path.tip[k, 2]) * 1e3, 6), bool(path.rapid[k]), feed, float(path.dwell[k])))
    return found


R, F = True, False


@pytest.mark.parametrize(
    ("call", "wanted"),
    [
        ("CYCLE81(10,0,2,-15)", [(2, R, 0, 0), (-15, F, 300, 0), (10, R, 0, 0)]),
        ("CYCLE81(10,1,2,,15)", [(3, R, 0, 0), (-14, F, 300, 0), (10, R, 0, 0)]),
        ("CYCLE82(10,0,2,-15,,0.5)", [(2, R, 0, 0), (-15, F, 300, 0.5), (10, R, 0, 0)]),
        ("CYCLE82(10,0,2,-15,,-5)", [(2, R, 0, 0), (-15, F, 300, 0.5), (10, R, 0, 0)]),
        ("CYCLE89(10,0,2,-15,,1)", [(2, R, 0, 0), (-15, F, 300, 1), (2, F, 300, 0), (10, R, 0, 0)]),
        ("CYCLE85(10,0,2,-15,,0,120,600)", [(2, R, 0, 0), (-15, F, 120, 0), (2, F, 600, 0), (10, R, 0, 0)]),
        ("CYCLE87(10,0,2,-15,,3)", [(2, R, 0, 0), (-15, F, 300, 0), (10, R, 0, 0)]),
        ("CYCLE88(10,0,2,-15,,1,3)", [(2, R, 0, 0), (-15, F, 300, 1), (10, R, 0, 0)]),
        ("CYCLE84(10,0,2,-15,,,3,,1.25,0,400,800)", [(2, R, 0, 0), (-15, F, 500, 0), (2, F, 1000, 0), (10, R, 0, 0)]),
        ("CYCLE84(10,0,2,-15,,,3,6)", [(2, R, 0, 0), (-15, F, 600, 0), (2, F, 600, 0), (10, R, 0, 0)]),
        (
            "CYCLE84(10,0,2,-12,,0,3,,1.25,0,400,800,0,1,,1,5,0.5,,,,0,0,1001002)",
            [(2, R, 0, 0), (-5, F, 500, 0), (-4.5, F, 1000, 0), (-10, F, 500, 0), (-9.5, F, 1000, 0), (-12, F, 500, 0),
             (2, F, 1000, 0), (10, R, 0, 0)],
        ),
        (
            "CYCLE84(10,0,2,-12,,0,3,,1.25,0,400,800,0,1,,2,10)",
            [(2, R, 0, 0), (-10, F, 500, 0), (2, F, 1000, 0), (-12, F, 500, 0), (2, F, 1000, 0), (10, R, 0, 0)],
        ),
        ("CYCLE840(10,0,2,-15,,0,4,3,0,,1.5)", [(2, R, 0, 0), (-15, F, 900, 0), (2, F, 900, 0), (10, R, 0, 0)]),
        ("CYCLE840(10,0,2,-15)", [(2, R, 0, 0), (-15, F, 300, 0), (2, F, 300, 0), (10, R, 0, 0)]),
        (
            "CYCLE83(10,0,2,-12,,,5,0,0.5,0.25,1,1)",
            [(2, R, 0, 0), (-5, F, 300, 0.5), (2, R, 0, 0.25), (-4.4, R, 0, 0), (-10, F, 300, 0.5), (2, R, 0, 0.25),
             (-9.4, R, 0, 0), (-12, F, 300, 0.5), (10, R, 0, 0)],
        ),
        (
            "CYCLE83(10,0,2,-9,,-5,,,,,,0)",
            [(2, R, 0, 0), (-5, F, 300, 0), (-4, F, 300, 0), (-9, F, 300, 0), (10, R, 0, 0)],
        ),
    ],
)  # fmt: skip
def test_motions_of_cycles(call, wanted):
    assert levels(call) == [pytest.approx(row) for row in wanted]


def test_boring_lifts_the_tool_off_the_wall():
    """CYCLE86: at the bottom the spindle stands, and the tool goes off by RPA, RPO, RPAP before it comes out."""
    path = read("MCALL CYCLE86(10,0,2,-15,,1,3,-1,0.5,2,0)\nG0 X10 Y20\nMCALL", start="G54 G64 F300\nG0 X0 Y0 Z50\n")
    assert (path.tip[2:] * 1e3).tolist() == [
        pytest.approx(row) for row in ([10, 20, 2], [10, 20, -15], [9, 20.5, -13], [9, 20.5, 10], [10, 20, 10])
    ]
    assert path.stop[3] and path.dwell[3] == 1


def test_the_tool_axis_follows_the_plane():
    path = read("G18\nCYCLE81(10,0,2,-15)", start="G54 G64 F300\nG0 X0 Z0 Y50\n")
    assert (path.tip[1:, 1] * 1e3).tolist() == pytest.approx([2, -15, 10])


def test_strokes_shrink_and_the_last_two_are_equal():
    """Cycles, CYCLE83: each stroke is DAM shorter down to DAM; a rest below twice DAM is cut into two."""
    assert strokes_of(50, 20, 5) == pytest.approx([20, 35, 45, 50])
    assert strokes_of(30, 10, 0) == pytest.approx([10, 20, 30])
    assert strokes_of(145, 50, 20) == pytest.approx([50, 80, 100, 120, 132.5, 145])
    with pytest.raises(BlockError, match="10000 strokes"):
        strokes_of(1e3, 1e-3, 0)


def by_the_rule(whole, first, less):
    """Depths in whole micrometres by the sentences of the manual, in fractions: nothing is rounded.

    Programming Guide Cycles (10.2004), CYCLE83: the first stroke is FDEP; then each is DAM shorter while it is longer
    than DAM; then each is DAM long as long as more than twice DAM remains; the last two are equal.
    """
    depth, stroke, found = Fraction(0), Fraction(first), []
    while whole - depth > stroke:
        depth += stroke
        found.append(depth)
        rest = whole - depth
        stroke = max(stroke - less, Fraction(less))
        if stroke < rest <= 2 * less:
            stroke = rest / 2
    return [*found, Fraction(whole)]


@pytest.mark.parametrize("reference", [-9, -7, -5])
def test_rounding_adds_no_stroke(reference):
    """To -15 first, 5 less each time, to -25: what is left below -20 is one stroke, and is not cut in two."""
    motions = levels(f"CYCLE83(10,{reference},2,-25,,-15,,5,0,0,1,0)")
    depths = [z for z, rapid, *_ in motions if not rapid]
    assert depths[::2] == pytest.approx([-15, -20, -25])


def test_strokes_are_those_of_exact_arithmetic():
    """Depths in metres, as binary fractions have them, take the same strokes as whole micrometres do."""
    rng = np.random.default_rng(83)
    for _ in range(3000):
        less = int(rng.integers(1, 80)) * 100
        first = less * int(rng.integers(1, 6)) if rng.random() < 0.5 else int(rng.integers(10, 400)) * 100
        whole = first + less * int(rng.integers(0, 20)) if rng.random() < 0.5 else int(rng.integers(100, 1200)) * 100
        wanted = by_the_rule(whole, min(first, whole), less)
        found = strokes_of(whole * 1e-6, first * 1e-6, less * 1e-6)
        assert len(found) == len(wanted) and np.array(found) * 1e6 == pytest.approx([float(each) for each in wanted])


def test_a_degression_from_minus_one_to_zero_is_a_factor():
    """DAM -0.5 halves each stroke (20, 10, 5), and _MDEP 4, the argument 14, is the least: not 2.5."""
    call = "CYCLE83(10,0,2,-45,,-20,,-0.5,0,0,1,0,3,{})"
    cut = [z for z, rapid, *_ in levels(call.format(4)) if not rapid]
    assert cut[::2] == pytest.approx([-20, -30, -35, -39, -43, -45])
    with pytest.raises(ProgramError, match="10000 strokes, or none: check its depths, or write the least stroke"):
        levels(call.format(0))


def test_patterns_of_holes():
    """Cycles, 2.3: HOLES1 is a row at an angle, HOLES2 a circle; the cycle under MCALL is done at each."""
    row = read("MCALL CYCLE81(5,0,1,-2)\nHOLES1(10,20,90,5,10,3)\nMCALL", start="G54 G64 F300\nG0 X0 Y0 Z5\n")
    deep = row.tip[row.tip[:, 2] < -1e-3] * 1e3
    assert deep == pytest.approx(np.array([[10, 25, -2], [10, 35, -2], [10, 45, -2]]))
    circle = read("MCALL CYCLE81(5,0,1,-2)\nHOLES2(1,2,10,30,0,4)\nMCALL", start="G54 G64 F300\nG0 X0 Y0 Z5\n")
    deep = circle.tip[circle.tip[:, 2] < -1e-3] * 1e3
    angles = np.deg2rad([30, 120, 210, 300])
    assert deep[:, :2] == pytest.approx(np.stack([1 + 10 * np.cos(angles), 2 + 10 * np.sin(angles)], axis=1))


def test_a_row_of_holes_begins_at_its_nearer_end():
    """Cycles, HOLES1: the cycle reckons from where the tool is whether it begins with the first hole or the last."""
    for start, ys in ((0, [10, 20, 30]), (19, [10, 20, 30]), (21, [30, 20, 10]), (50, [30, 20, 10])):
        path = read("MCALL CYCLE81(5,0,1,-2)\nHOLES1(0,0,90,10,10,3)\nMCALL", start=f"G54 F300\nG0 X0 Y{start} Z5\n")
        bottoms = path.tip[np.isclose(path.tip[:, 2], -2e-3)]
        assert bottoms[:, 1] * 1e3 == pytest.approx(ys), start
        assert any("nearer to the tool" in said for said in path.assumed) == (ys[0] == 30)


@pytest.mark.parametrize(
    ("call", "places"),
    [
        ("CYCLE801(10,20,90,3,7,2,3)", [[-4, 20], [-4, 23], [3, 23], [3, 20], [10, 20], [10, 23]]),
        ("CYCLE801(10,20,0,-7,3,2,3)", [[10, 20], [10, 23], [10, 26], [17, 26], [17, 23], [17, 20]]),
        ("CYCLE801(-9,-2,0,2,5,3,2)", [[-5, 3], [-7, 3], [-9, 3], [-9, -2], [-7, -2], [-5, -2]]),
    ],
)
def test_a_grid_of_holes(call, places):
    """Cycles, "Grid or frame of positions": from the corner nearer to the tool, the shorter distance first."""
    grid = read(f"MCALL CYCLE81(5,0,1,-2)\n{call}\nMCALL", start="G54 G64 F300\nG0 X0 Y2 Z5\n")
    deep = grid.tip[grid.tip[:, 2] < -1e-3] * 1e3
    assert deep[:, :2] == pytest.approx(np.array(places)) and "there and back" in " ".join(grid.assumed)


def test_between_the_holes_of_a_pattern_the_tool_stays_where_the_cycle_left_it():
    path = read("MCALL CYCLE81(3,0,1,-2)\nHOLES1(10,20,90,5,10,3)\nMCALL", start="G54 G64 F300\nG0 X0 Y0 Z5\n")
    first = int(np.argmin(path.tip[:, 2]))
    assert path.tip[first:, 2].max() == pytest.approx(3e-3)


def test_a_cycle_without_mcall_runs_where_the_tool_stands():
    path = read("CYCLE81(5,0,1,-2)\nG0 X9", start="G54 G64 F300\nG0 X3 Y4 Z5\n")
    assert (path.tip[-1] * 1e3).tolist() == pytest.approx([9, 4, 5]) and path.tip[:, 2].min() == pytest.approx(-0.002)


def test_thread_milling():
    """Cycles, 3.2, CYCLE90: a helix of the thread's diameter less the tool's, one pitch a turn."""
    setup = SetUp(tools={"1": Tool(0.0, 0.005)})
    text = "T1 M6\nCYCLE90(5,0,0,-8,,28,25,2,1000,2,0,10,20)"
    path = read(text, setup=setup, start="G54 G64\nG0 X0 Y0 Z5\n")
    tip = path.tip * 1e3
    helix = tip[(np.abs(np.hypot(tip[:, 0] - 10, tip[:, 1] - 20) - 9) < 1e-4)]
    turned = np.unwrap(np.arctan2(helix[:, 1] - 20, helix[:, 0] - 10))
    assert turned[-1] - turned[0] == pytest.approx(-8 * math.pi)
    assert helix[:, 2] == pytest.approx(np.interp(-turned, [0, 8 * math.pi], [0, -8]), abs=1e-6)
    assert tip[-1] == pytest.approx([10, 20, 5])
    assert tip[0] == pytest.approx([0, 0, 5])  # where the program positions all axes, the way to the thread is its own
    with pytest.raises(ProgramError, match="CYCLE90 is not read: it needs the radius of the tool"):
        read(text, start="G54\nG0 X0 Y0 Z5\n")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("CYCLE81()", "lacks RTP"),
        ("CYCLE81(5,0,1)", "lacks its depth"),
        ("CYCLE83(5,0,1,-900,,,0.001)", "10000 strokes"),
        ("CYCLE84(5,0,1,-9,,,3,7)", "M7 is no metric size"),
        ('CYCLE81("A",0,1,-9)', "is no number"),
        ("CYCLE81(" + ",".join("0" * 30) + ")", "at most 24 arguments"),
        ("HOLES1(0,0,0,0,1,0)", "number of its holes"),
        ("CYCLE801(0,0,0,1,1,200,200)", "at most 10000"),
        ("CYCLE801(0,0,0,1,1,2,2,1)", "_VARI"),
        ("POCKET3(1,2,3)", "POCKET3 is not read: cycles that clear areas"),
        ("CYCLE977(1)", "CYCLE977 is not read"),
    ],
)
def test_cycles_that_cannot_be(call, said):
    with pytest.raises(ProgramError, match=said):
        read(call)


@pytest.mark.parametrize(
    "call", ["CYCLE81(0.1,2,.1,1.5)", "CYCLE84(5,0,1,-9)", "CYCLE83(5,0,1,-9,,-20)", "CYCLE76(5,0,1,-9,,3,,,,)"]
)
def test_cycles_that_controls_stop_at_are_said_or_refused(call):
    path = read(f"{call}\nG0 X1", start="G54 F100\nG0 X0 Y0 Z9\n")
    assert any("controls may stop there" in sentence for sentence in path.assumed)
    with pytest.raises(ProgramError, match="the control stops there"):
        read(call, controller=STRICT)


def test_tolerances_of_cycle832_are_told_and_blend():
    for mode in ("3,1", "_ROUGH,1", "_TOP_SURFACE_SMOOTH_ON+_ORI_FINISH,0.5"):
        path = read(f"G60 G1 X1\nX2\nCYCLE832(0.02,{mode})\nX3\nX4\nCYCLE832()\nX5\nX6")
        assert path.stop.tolist() == [True, True, True, False, False, True, True] and path.skipped["CYCLE832"] == 2


def test_depths_on_the_wrong_side_are_refused():
    """Alarms 61101 and 61107: a depth between RTP and RFP, a first depth against the direction of the hole."""
    for call, said in (
        ("CYCLE81(10,0,2,5)", "61101"), ("CYCLE83(10,0,2,-20,,5,,2,0,0,1,1)", "61107"),
        ("CYCLE83(10,0,2,-20,,5,,2,0,0,1,0)", "61107"),
    ):  # fmt: skip
        with pytest.raises(ProgramError, match=said):
            levels(call)
    with pytest.raises(ProgramError, match="61101"):
        levels("CYCLE81(0,0,2,,15)", controller=STRICT)
    assert [row[0] for row in levels("CYCLE81(0,0,2,,15)")] == [2, -15, 2]


def test_the_first_stroke_by_its_place_or_by_its_depth():
    """CYCLE83: FDEP is a place, FDPR a depth below RFP; of both FDPR counts, as DPR does of DP and DPR."""
    by_place, by_depth, both = (
        levels(f"CYCLE83(10,-3,2,-23,,{first},4,0,0,1,0)") for first in ("-13,", ",10", "-7,10")
    )
    assert by_place == by_depth == both
    assert next(z for z, rapid, *_ in by_depth if not rapid) == -13

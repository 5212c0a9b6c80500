"""Curves of NX, Creo and CATIA."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.splines import CurveError, Spline
from toolpace.programs.toolpath import ToolPath


def path(body: str) -> ToolPath:
    return read_text("UNITS/MM\nFEDRAT/600\n" + body + "\n", None, "apt")


def turned(p: ToolPath, x: float = 0.0, y: float = 0.0) -> float:
    """Angle by which the tip goes round a point of XY [mm], counter-clockwise."""
    angle = np.unwrap(np.arctan2(p.tip[:, 1] * 1e3 - y, p.tip[:, 0] * 1e3 - x))
    return float(angle[-1] - angle[0])


@pytest.mark.parametrize(
    ("numbers", "sweep"),
    [("10", math.pi / 2), ("10,0.01,0.5,8,0", -1.5 * math.pi), ("10,TIMES,1", -1.5 * math.pi)],
)
def test_seven_numbers_turn_by_the_right_hand_and_eleven_clockwise(numbers, sweep):
    p = path(f"GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,{numbers}\nGOTO/0,10,0")
    assert turned(p) == pytest.approx(sweep)
    assert any("CIRCLE" in sentence for sentence in p.assumed) == ("0.01" not in numbers)


def test_a_list_of_points_ends_a_circle_of_creo_at_its_last():
    p = path("GOTO/10,0,0\nCIRCLE / 0,0,0,0,0,1,10\nGOTO / 7.0711,7.0711,1, $\n 0,10,2, $\n -10,0,4")
    assert turned(p) == pytest.approx(math.pi) and p.tip[-1, 2] * 1e3 == pytest.approx(4)


NURBS = "GOTO/1,2,3\nNURBS/\nKNOT/{knots}\n{points}\nGOTO/0,0,9"


def nurbs(inner, points, width=12):
    """The record of NX for inner knots and control points after the first."""
    knots = [*inner, 1.0]
    rows = [",".join(f"{k:.7f}" for k in knots[i : i + width]) for i in range(0, len(knots), width)]
    return NURBS.format(
        knots="\nKNOT/".join(rows), points="\n".join("CNTRL/" + ",".join(f"{x:.4f}" for x in p) for p in points)
    )


@pytest.mark.parametrize("count", [1, 2, 15, pytest.param(40, marks=pytest.mark.sweep)])
def test_nurbs_is_the_cubic_spline_within_half_a_micrometre(count):
    chance = np.random.default_rng(count)
    inner = np.sort(np.round(chance.uniform(0.01, 0.99, count - 1), 7))
    points = np.round(np.cumsum(chance.normal(0, 3, (count + 2, 3)), axis=0), 4)
    p = path(nurbs(inner, points))
    knots = np.concatenate((np.zeros(4), inner, np.ones(4)))
    exact = BSpline(knots, np.vstack(([1, 2, 3], points)) * 1e-3, 3)(np.linspace(0, 1, 20_000))
    on = p.block == p.block[1]
    tip = np.vstack((p.tip[:1], p.tip[on]))
    assert tip[-1] * 1e3 == pytest.approx(points[-1])
    way, step = np.diff(tip, axis=0), np.linalg.norm(np.diff(tip, axis=0), axis=1)
    off = np.full(len(exact), np.inf)
    for start, along, length in zip(tip[:-1], way, step):
        t = np.clip((exact - start) @ along / length**2, 0, 1)
        off = np.minimum(off, np.linalg.norm(exact - start - t[:, None] * along, axis=1))
    assert 0.2e-6 <= off.max() <= 0.5e-6


def test_evaluation_of_splines_with_repeated_knots():
    chance = np.random.default_rng(3)
    inner = np.array([0.2, 0.2, 0.5, 0.5, 0.5, 0.7])
    points = chance.normal(size=(10, 3))
    t = np.linspace(0, 1, 101)
    expected = BSpline(np.concatenate((np.zeros(4), inner, np.ones(4))), points, 3)(t)
    spline = Spline.clamped(inner, points)
    assert spline.evaluate(t) == pytest.approx(expected, abs=1e-14)
    assert spline.pieces() == len(spline.parameters()) and (np.diff(spline.parameters()) > 0).all()


@pytest.mark.parametrize(
    ("inner", "says"),
    [
        ([0.5], "5 control points need 1 inner knots|there are"),
        ([0.5, 0.4], "do not rise"),
        ([0.0, 0.4], "an inner knot is 0 or 1"),
        ([0.4, 1.0], "an inner knot is 0 or 1"),
    ],
)
def test_splines_that_cannot_be(inner, says):
    with pytest.raises(CurveError, match=says):
        Spline.clamped(np.array(inner), np.zeros((6, 3)))
    with pytest.raises(CurveError, match="more than three times"):
        Spline.clamped(np.full(4, 0.5), np.zeros((8, 3)))


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("GOTO/0,0,0\nNURBS/\nKNOT/0.5,1\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0", "NURBS: 4 control points need 0"),
        ("GOTO/0,0,0\nNURBS/\nKNOT/0.5\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0", "the last KNOT of NURBS is 0.5"),
        ("GOTO/0,0,0\nNURBS/\nGOTO/1,0,0", "NURBS is not followed by KNOT and CNTRL"),
        ("NURBS/\nKNOT/1\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0", "NURBS before any position"),
        ("GOTO/0,0,0\nNURBS/\nKNOT/1\nCNTRL/1,0,0,0,0,1\nGOTO/1,0,0", "NURBS with axes or weights is not read"),
        ("GOTO/0,0,0\nFNURBS/\nKNOT/1\nWEIGHT/1,2\nCNTRL/1,0,0,0,0,1\nGOTO/1,0,0", "FNURBS is not read"),
        ("GOTO/0,0,0\nCIRCLE/1,0,0,0,0,1,1\nNURBS/\nGOTO/1,0,0", "CIRCLE is not followed by the GOTO"),
    ],
)
def test_curves_that_do_not_fit_together(body, says):
    with pytest.raises(ProgramError, match=says):
        path(body)


@pytest.mark.parametrize(
    ("direction", "drive", "end", "sweep"),
    [
        ("0,1,0", "ON,(LINE/0,0,0,0,5,0)", (0, 10), math.pi / 2),
        ("0,-1,0", "ON,2,INTOF,(LINE/0,0,0,0,5,0)", (0, 10), -1.5 * math.pi),
        ("0,1,0", "ON,2,INTOF,$\n (LINE/0,0,0,10,0,0)", (10, 0), 2 * math.pi),
        ("0.1,-1,0", "ON,(LINE/0.0,0,0,-7,0.0,0)", (-10, 0), -math.pi),
    ],
)
def test_arcs_of_catia_in_the_plane(direction, drive, end, sweep):
    p = path(f"GOTO/10,0,-3\nAUTOPS\nINDIRV/{direction}\nTLON,GOFWD/(CIRCLE/0,0,0,10),{drive}\nGOTO/0,0,9")
    assert np.hypot(p.tip[:-1, 0], p.tip[:-1, 1]) == pytest.approx(0.01)
    assert p.tip[-2] * 1e3 == pytest.approx([*end, -3])
    angle = np.unwrap(np.arctan2(p.tip[:-1, 1], p.tip[:-1, 0]))
    assert angle[-1] - angle[0] == pytest.approx(sweep)


@pytest.mark.parametrize(("w", "sweep"), [(1, -math.pi / 2), (-1, 1.5 * math.pi)])
def test_arcs_of_catia_on_a_cylinder_end_at_the_last_point(w, sweep):
    plane = "(PLANE/PERPTO,(PLANE/(POINT/0,0,0),(POINT/1,0,0),(POINT/0,0,1)),(POINT/0,2,0),(POINT/0,2,10))"
    p = path(f"GOTO/10,2,0\nINDIRV/0,0,{w}\nTLON,GOFWD/(CYLNDR/0,2,0,0,1,0,10),ON,{plane}")
    assert p.tip[:, 1] * 1e3 == pytest.approx(2) and p.tip[-1] * 1e3 == pytest.approx([0, 2, 10])
    angle = np.unwrap(np.arctan2(p.tip[:, 0], p.tip[:, 2]))
    assert angle[-1] - angle[0] == pytest.approx(sweep)


@pytest.mark.parametrize(
    "body",
    [
        "TLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,5,0)",
        "INDIRV/1,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,5,0)",
        "INDIRV/1,0.05,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,5,0)",
        "INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,0,0)",
        "INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,9E99),ON,(LINE/0,0,0,0,1,0)",
        "INDIRV/0,1,0\nTLLFT,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,5,0)",
    ],
)
def test_drives_without_a_clear_direction_are_refused(body):
    with pytest.raises(ProgramError, match=r"GOFWD is not read|mm off its circle"):
        path(f"GOTO/10,0,0\n{body}\nGOTO/0,0,9")


def test_movnrb_of_creo_gives_way_to_its_points():
    body = "GOTO/0,0,0\nMOVNRB / M3AXIS\nMOVNRB / ON,4,2,1,3,10\nMOVNRB / 1,0,0,0,0,1,1,1,1\nMOVNRB / 2,1,0,0,2,0,0\n{}"
    p = path(body.format("MOVNRB / NEXT\nGOTO/1,0,0\nGOTO/2,0,0\nMOVNRB / OFF"))
    assert p.tip[:, 0] * 1e3 == pytest.approx([0, 1, 2]) and p.skipped == {"MOVNRB": 6}
    with pytest.raises(ProgramError, match="MOVNRB is not read: no GOTO points stand for its spline"):
        path(body.format("MOVNRB / OFF\nGOTO/2,0,0"))

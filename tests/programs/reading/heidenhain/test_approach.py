"""APPR and DEP after "TNC 640 Klartext Programming", chapter 6.3 "Contour approach and departure"."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import findings, read
from toolpace.common.errors import ProgramError

BEGIN = "L X+40 Y+10 Z+0 F600\n"


def ends(text, **options):
    """Ends (n, 2) [mm] of moves, and Z; points of arcs are left out by the blocks' angles."""
    return read(BEGIN + text, compensation="program", **options).tip * 1e3


def on_circle(points, centre, radius):
    return np.flatnonzero(np.abs(np.linalg.norm(points[:, :2] - centre, axis=1) - radius) < 1e-6)


def test_lt_comes_in_line_with_the_contour():
    """6.3 "Approaching on a straight line with tangential connection": PH lies LEN before the contour, in its line."""
    tip = ends("APPR LT X+20 Y+20 LEN15 RR F100\nL X+35 Y+35\n")
    side = 15 / np.sqrt(2)
    assert np.allclose(tip[2:, :2], [[20 - side, 20 - side], [20, 20], [35, 35]])


@pytest.mark.parametrize(("side", "sign"), [("RR", 1), ("RL", -1), ("R0", 1)])
def test_ln_comes_across_the_contour_from_the_side_of_the_tool(side, sign):
    """6.3 "... perpendicular to the first contour point"; with R0 the control takes RR."""
    tip = ends(f"APPR LN X+10 Y+20 LEN15 {side} F100\nL X+20 Y+35\n")
    right = np.array([15, -10]) / np.hypot(15, 10)
    assert np.allclose(tip[2:, :2], [[10, 20] + sign * 15 * right, [10, 20], [20, 35]])


def test_ct_comes_on_an_arc_of_radius_and_angle():
    """6.3 "... circular path with tangential connection": CCA its angle, R its radius, on the tool's side."""
    tip = ends("APPR CT X+10 Y+20 CCA180 R+10 RR F100\nL X+20 Y+20\n")
    # the contour runs along +X, the tool at its right: the arc lies about (10, 10), from (10, 0), clockwise
    assert np.allclose(tip[2, :2], [10, 0])
    arc = tip[2:-1]
    assert len(on_circle(arc, [10, 10], 10)) == len(arc) and arc[:, 0].min() == pytest.approx(0, abs=1e-3)
    other = ends("APPR CT X+10 Y+20 CCA180 R-10 RR F100\nL X+20 Y+20\n")
    assert np.allclose(other[2, :2], [10, 40]) and other[:, 1].max() == pytest.approx(40)


def test_lct_comes_on_a_line_and_an_arc_that_touch():
    """6.3 "... straight line and circular path": line and arc touch at PH, arc and contour at PA."""
    tip = ends("APPR LCT X+10 Y+20 R10 RR F100\nL X+20 Y+20\n")
    help_point, centre, start = tip[2, :2], np.array([10, 10]), np.array([40, 10])
    assert np.linalg.norm(help_point - centre) == pytest.approx(10)
    assert np.dot(help_point - centre, help_point - start) == pytest.approx(0, abs=1e-6)
    # clockwise about the centre, as the contour goes on: PH lies below
    assert help_point[1] < 10 and tip[:, 0].min() == pytest.approx(0, abs=1e-3)


def test_the_way_to_the_help_point_is_in_the_plane_first():
    """6.3: with a coordinate of the tool axis the tool moves in the plane to PH, then along the axis."""
    tip = ends("APPR LT X+20 Y+10 Z-5 LEN15 RR F100\nL X+30\n")
    assert np.allclose(tip[2:], [[5, 10, 0], [5, 10, -5], [20, 10, -5], [30, 10, -5]])


def test_the_help_point_is_gone_to_as_the_block_before_and_the_rest_at_the_feed_of_appr():
    """6.3: at the feed last programmed, or at rapid after FMAX; F of the block holds from PH on."""
    path = read("L X+40 Y+10 FMAX\nAPPR LT X+20 Y+10 LEN15 RR F100\nL X+30 F300", compensation="program")
    assert path.rapid.tolist()[-3:] == [True, False, False]
    assert np.allclose(path.feed[-2:] * 60e3, [100, 300])


def test_polar_points_of_approaches():
    """6.3: APPR PLT and its kin take the contour's first point as PR and PA about CC."""
    polar = ends("CC X+0 Y+0\nAPPR PLT PR+20 PA+90 LEN15 RR F100\nL X+10 Y+20\n")
    assert np.allclose(polar, ends("APPR LT X+0 Y+20 LEN15 RR F100\nL X+10 Y+20\n"))


def test_departures():
    """6.3: DEP LT in line, DEP LN across, DEP CT an arc, DEP LCT an arc and a line that touch."""
    contour = "L X+0 Y+0 RL\nL X+30 F100\n"
    assert np.allclose(ends(contour + "DEP LT LEN12.5 F50")[-1], [42.5, 0, 0])
    assert np.allclose(ends(contour + "DEP LN LEN+20 F100")[-1], [30, 20, 0])
    tip = ends(contour + "DEP CT CCA 90 R+8 F100")
    assert np.allclose(tip[-1], [38, 8, 0]) and len(on_circle(tip, [30, 8], 8)) > 10
    tip = ends(contour + "DEP LCT X+10 Y+40 R8 F100")
    touch = tip[-2, :2]
    assert np.linalg.norm(touch - [30, 8]) == pytest.approx(8) and np.allclose(tip[-1], [10, 40, 0])
    assert np.dot(touch - [30, 8], [10, 40] - touch) == pytest.approx(0, abs=1e-6)


def test_a_contour_that_begins_with_an_arc_is_touched():
    tip = ends("CC X+20 Y+0\nAPPR LT X+20 Y+20 LEN15 RR F100\nC X+40 Y+0 DR-\n")
    assert np.allclose(tip[2:4, :2], [[5, 20], [20, 20]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("APPR LT X+20 LEN15 RL", "APPR is not read: write the approach"),
        ("APPR LT X+20 RL\nL X+30", "LEN is missing"),
        ("APPR XX X+20\nL X+30", "LT, LN, CT or LCT"),
        ("APPR LCT X+38 Y+11 R40 RR\nL X+40 Y+12", "make R smaller"),
        ("APPR CT X+20 CCA0 R5\nL X+30", "CCA of CT"),
    ],
)
def test_ways_that_cannot_be(text, message):
    with pytest.raises(ProgramError, match=message):
        ends(text)


def test_compensation_is_refused_as_in_other_blocks():
    assert any(refusal.word == "RL" for refusal in findings(BEGIN + "APPR LT X+20 LEN5 RL\nL X+30").refusals)

"""Motion: TNC 640 Klartext manual, "Programming contours"."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.heidenhain import findings, last, read, tips
from toolpace.common.errors import ProgramError
from toolpace.common.units import DEGREE
from toolpace.programs.reading.setup_file import setup_of_text


def circle_of(points, centre, radius):
    """Whether points (n, 3) [mm] lie on a circle in XY."""
    return np.abs(np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1]) - radius).max() < 1e-6


def sweep(points, centre):
    """Angle [deg] that points go through about a centre, counter-clockwise positive."""
    angle = np.unwrap(np.arctan2(points[:, 1] - centre[1], points[:, 0] - centre[0]))
    return float(angle[-1] - angle[0]) / DEGREE


# Straight lines and feed


def test_incremental_words_count_from_where_the_tool_is_each_for_itself():
    assert last("L X+10 Y+5 F100\nL IX+5 Y+7\nL IX-2 IY-3") == (13, 4, 0)


def test_feed_is_modal_and_fmax_is_for_its_block_only():
    path = read("L X+1 F600\nL X+2 FMAX\nL X+3")
    assert path.feed[1:] == pytest.approx([0.01, np.inf, 0.01]) and list(path.rapid[1:]) == [False, True, False]


def test_fauto_is_the_feed_of_the_tool_call():
    path = read("TOOL CALL 1 Z S1000 F300\nL X+1\nL X+2 F900\nL X+3 FAUTO")
    assert path.feed[1:] == pytest.approx([0.005, 0.015, 0.005])


def test_feed_per_revolution():
    """M136: F in mm per spindle revolution until M137; FU for a block's F."""
    path = read("TOOL CALL 1 Z S600\nL X+1 F0.5 M136\nL X+2 F60 M137\nL X+3 F60\nL X+4 FU0.2")
    assert path.feed[1] == pytest.approx(0.005) and path.feed[3:] == pytest.approx([0.001, 0.002])


def test_a_motion_without_any_feed_is_one_error():
    with pytest.raises(ProgramError, match="feed missing"):
        read("L X+1")


def test_feed_per_tooth_counts_the_teeth_of_the_tool_in_the_spindle():
    text = "TOOL CALL 1 Z S600\nL X+1 FZ0.1\nTOOL CALL 2 Z\nL X+2\nL X+3 F60"
    setup = setup_of_text("".join(f'[tools.{k}]\nkind = "flat"\ndiameter = 9\nteeth = {k + 2}\n' for k in (1, 2)))
    path = read(text, setup=setup)
    assert path.feed[-3:] == pytest.approx([0.003, 0.004, 0.001])
    with pytest.raises(ProgramError, match="write teeth in the tool's table"):
        read(text)


def test_feeds_by_time_are_refused():
    found = findings("L X+1 F100\nL X+3 FT 5\nL X+4 FMAXT 5")
    assert [refusal.word for refusal in found.refusals] == ["FT", "FMAXT"]


# Arcs


def test_c_about_the_pole():
    """CC and C: DR+ is counter-clockwise; the centre stays."""
    quarter = tips("L X+10 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+")
    assert circle_of(quarter, (0, 0), 10) and sweep(quarter, (0, 0)) == pytest.approx(90)
    three = tips("L X+10 F100\nCC X+0 Y+0\nC X+0 Y+10 DR-")
    assert sweep(three, (0, 0)) == pytest.approx(-270) and circle_of(three, (0, 0), 10)


def test_a_full_circle():
    round_ = tips("L X+10 F100\nCC X+0 Y+0\nC X+10 Y+0 DR-")
    assert sweep(round_, (0, 0)) == pytest.approx(-360)


def test_the_pole_is_modal_incremental_or_where_the_tool_is():
    assert sweep(tips("L X+10 F100\nCC IX-10 Y+0\nC Y+10 X+0 DR+"), (0, 0)) == pytest.approx(90)
    assert last("L X+10 F100\nCC\nLP PR+5 PA+90") == (10, 5, 0)


@pytest.mark.parametrize(
    ("radius", "sense", "centre", "angle"),
    [("+10", "+", (0, 0), 90), ("-10", "+", (10, 10), 270), ("+10", "-", (10, 10), -90), ("-10", "-", (0, 0), -270)],
)
def test_cr(radius, sense, centre, angle):
    """CR: R above zero up to 180 degrees, below zero more."""
    arc = tips(f"L X+10 F100\nCR X+0 Y+10 R{radius} DR{sense}")
    assert circle_of(arc, centre, 10) and sweep(arc, centre) == pytest.approx(angle)


def test_ct_goes_on_in_the_direction_of_the_line_before():
    arc = tips("L X+10 F100\nCT X+20 Y+10")
    assert circle_of(arc, (10, 10), 10) and sweep(arc, (10, 10)) == pytest.approx(90)


def test_ct_behind_an_arc_and_straight_ahead():
    arc = tips("L X+10 F100\nCT X+20 Y+10\nCT X+10 Y+20\nL X+9\nCT X+3 Y+20")
    assert circle_of(arc[:-2], (10, 10), 10) and sweep(arc[:-2], (10, 10)) == pytest.approx(180)
    assert tuple(arc[-1].round(9)) == (3, 20, 0)


def test_ct_without_an_element_before_it_in_the_plane():
    with pytest.raises(ProgramError, match="needs an element before it"):
        read("L Z+10 F100\nCT X+20 Y+10")


def test_polar_lines():
    """The manual's hexagon: LP PR PA, then PA alone, then IPA: the radius stays."""
    points = tips("CC X+45 Y+25\nLP PR+30 PA+0 F100\nLP PA+60\nLP IPA+60\nLP PA+180\nLP IPR-10")
    angle = np.array([0, 60, 120, 180, 180]) * DEGREE
    radius = np.array([30, 30, 30, 30, 20])
    wanted = np.stack([45 + radius * np.cos(angle), 25 + radius * np.sin(angle)], axis=1)
    assert np.allclose(points[:, :2], wanted, atol=1e-9)


def test_polar_arcs_and_the_helix():
    """CP IPA with IZ is a helix; the sign of IPA is that of DR; 720 degrees are two turns."""
    helix = tips("L X+10 F100\nCC X+0 Y+0\nCP IPA-720 IZ-5 DR-")
    assert circle_of(helix, (0, 0), 10) and sweep(helix, (0, 0)) == pytest.approx(-720)
    assert helix[-1] == pytest.approx((10, 0, -5))
    mid = helix[len(helix) // 2]
    assert mid[2] == pytest.approx(-5 * (len(helix) // 2) / (len(helix) - 1), abs=1e-6)
    assert sweep(tips("L X+10 F100\nCC X+0 Y+0\nCP PA+90 DR-"), (0, 0)) == pytest.approx(-270)


def test_ctp():
    arc = tips("L X+10 F100\nCC X+10 Y+10\nCTP PR+10 PA+0")
    assert circle_of(arc, (10, 10), 10) and last("L X+10 F100\nCC X+10 Y+10\nCTP PR+10 PA+0") == (20, 10, 0)


@pytest.mark.parametrize(
    ("pole", "begin", "end"),
    [("Y+0 Z+0", (0, 0, -10), (0, 10, 0)), ("X+0 Z+0", (-10, 0, 0), (0, 0, 10)), ("X+0 Y+0", (0, -10, 0), (10, 0, 0))],
)
def test_the_coordinates_of_the_pole_tell_the_plane(pole, begin, end):
    """ "Setting the datum for polar coordinates": poles in YZ, ZX and XY count angles from +Y, +Z and +X.

    Fusion's post writes its upright arcs so."""
    there = "L X{:+d} Y{:+d} Z{:+d} F100\n".format(*begin)
    assert last(f"{there}CC {pole}\nCP IPA+90 DR+") == end
    points = tips(f"{there}CC {pole}\nCP IPA+90 DR+")[1:]
    assert np.linalg.norm(points, axis=1) == pytest.approx(10, abs=1e-3)
    assert last(there + f"CC {pole}\nC X{end[0]:+d} Y{end[1]:+d} Z{end[2]:+d} DR+") == end
    assert last(there + f"CC {pole}\nCC X+5 Y+0\nLP PR+5 PA+90") == (5, 5, begin[2])


def test_a_tangent_arc_in_an_upright_plane_is_refused():
    with pytest.raises(ProgramError, match="across the tool only"):
        read("L Y+5 F100\nCC Y+5 Z+5\nCTP PR+5 PA+0")


@pytest.mark.parametrize(
    ("axis", "start", "end"), [("X", "Y+10", "Z+10 Y+0"), ("Y", "Z+10", "X+10 Z+0"), ("Z", "X+10", "Y+10 X+0")]
)
def test_the_plane_is_across_the_tool_axis(axis, start, end):
    """TOOL CALL .. X: YZ, Y: ZX, Z: XY, with DR+ from the first axis to the second."""
    arc = tips(f"TOOL CALL 3 {axis} S100\nL {start} F100\nCC X+0 Y+0 \nCC Z+0\nC {end} DR+")
    assert np.abs(np.linalg.norm(arc, axis=1) - 10).max() < 1e-6 and arc.min() > -1e-9


def test_arcs_of_nx_across_another_axis():
    """A CC of three coordinates: the arc lies across the axis that start, centre and end share; where two are shared
    the motion before lies in the plane. DR+ is counter-clockwise seen from the positive axis."""
    arc = tips("L Y+0 Z+0 F100\nL X+5\nL Y+3\nCC X+5 Y+3 Z-4\nC X+5 Y+3 Z-8 DR-")
    spoke = arc[3:] - (5, 3, -4)
    assert np.abs(np.hypot(spoke[:, 1], spoke[:, 2]) - 4).max() < 1e-6 and np.abs(spoke[:, 0]).max() < 1e-9
    assert spoke[:, 1].max() == pytest.approx(4, abs=1e-3)


def test_rapid_arcs():
    path = read("L X+10 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+ FMAX")
    assert path.rapid[2:].all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("C X+1 Y+1 DR+", "no CC before"),
        ("CC X+5 Y+0\nC X+1 Y+1", "no sense"),
        ("CC X+5 Y+0\nC X+1 Y+1 DR+", "off its circle"),
        ("CR X+50 Y+0 R5 DR+", "too small"),
        ("CR X+5 Y+0 DR+", "needs its radius"),
        ("CC X+5 Y+0\nCP IPA+90 DR-", "different signs"),
        ("CC X+5 Y+0\nCP IPA+5401 DR+", "5400"),
        ("CC X+5 Y+0\nLP X+3 PA+5", "beside PR and PA only"),
        ("L X+1\nCT X+0 Y+0", "straight behind"),
        ("L X+1 PR+3", "PR is no word of L"),
    ],
)
def test_faults_of_arcs(text, message):
    with pytest.raises(ProgramError, match=message):
        read(f"L Z+1 F100\n{text}")


def test_compensation_is_refused_or_the_programmed_contour():
    text = "L X+10 RL F100\nL Y+10 RR\nL X+0 R0"
    assert [refusal.word for refusal in findings(text).refusals] == ["RL", "RR"]
    assert last(text, compensation="program") == (0, 10, 0)


# Corners


@pytest.mark.parametrize(("corner", "feed"), [("RND R5 F60", 0.001), ("RND R5", 0.01), ("RND5", 0.01)])
def test_a_corner_is_rounded(corner, feed):
    """ "Corner rounding RND": a tangent arc between both lines; its F is for the rounding only."""
    path = read(f"L X+40 F600\n{corner}\nL Y+30\nL X+0")
    arc = tips(f"L X+40 F600\n{corner}\nL Y+30\nL X+0")[:-2]
    assert tuple(arc[0].round(9)) == (35, 0, 0) and circle_of(arc, (35, 5), 5) and arc[-1, 1] == pytest.approx(5)
    assert sweep(arc, (35, 5)) == pytest.approx(90)
    assert path.feed[5] == pytest.approx(feed) and path.feed[-1] == pytest.approx(0.01)


def test_a_corner_to_the_right_and_two_in_a_row():
    points = tips("L X+40 F600\nRND R5\nL Y-30\nRND R10\nL X+0\nL Y+1")
    near = [
        np.abs(np.hypot(*(points[:, :2] - centre).T) - radius) < 1e-6
        for centre, radius in (((35, -5), 5), ((30, -20), 10))
    ]
    assert (near[0] | near[1])[:-2].all() and near[0].sum() > 10 and near[1].sum() > 10


def test_a_corner_is_cut():
    """ "Chamfer CHF": the corner is cut by a length on both lines."""
    points = tips("L X+40 F600\nCHF 12 F60\nL X+45 Y+30")
    assert points[0] == pytest.approx((28, 0, 0))
    assert points[1] == pytest.approx((40 + 12 * 5 / math.hypot(5, 30), 12 * 30 / math.hypot(5, 30), 0))


def test_a_corner_between_lines_that_go_on_straight_is_none():
    assert [tuple(tip) for tip in tips("L X+40 F600\nRND R5\nL X+50").round(9)] == [(40, 0, 0), (50, 0, 0)]


@pytest.mark.parametrize(
    "text",
    [
        "RND R5\nL Z+5",
        "RND R5\nCT X+45 Y+5",
        "RND R5\nL Y+30 FMAX",
        "L Z+1\nCHF 2\nL X+1",
        "CT X+50 Y+5\nRND R1\nL X+0",
    ],
)
def test_corners_between_other_elements_are_refused(text):
    (refusal,) = findings(f"L X+40 F600\n{text}").refusals
    assert refusal.word in ("RND", "CHF")


def test_a_corner_that_does_not_fit():
    with pytest.raises(ProgramError, match="takes 50 mm of both lines"):
        read("L X+40 F600\nRND R50\nL Y+90")


# Between blocks that hang together


CHANGES = {
    "shift": "CYCL DEF 7.0\nCYCL DEF 7.1 X+90", "turn": "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+90",
    "mirror": "CYCL DEF 8.0\nCYCL DEF 8.1 Y", "plane": "PLANE SPATIAL SPA+0 SPB+0 SPC+45 STAY",
}  # fmt: skip


@pytest.mark.parametrize("change", CHANGES)
def test_a_tangent_arc_or_corner_over_a_change_of_coordinates_is_refused(change):
    """The way before was taken in the new coordinates: a tangent arc began backwards, a corner lay beside the lines."""
    before, words = f"L X+10 F100\n{{}}{CHANGES[change]}\n", ["a tangent arc behind a change of coordinates"]
    assert [each.word for each in findings(before.format("") + "CT X+20 Y+10").refusals] == words
    assert [each.word for each in findings(before.format("RND R2\n") + "L Y+20").refusals] == ["RND"]
    same = CHANGES["shift"].replace("+90", "+0")
    arc = tips(f"L X+10 F100\n{same}\nCT X+20 Y+10")
    assert circle_of(arc[1:], (10, 10), 10)


def test_a_pole_before_a_change_of_coordinates_is_said():
    said = "a CC before a change of coordinates keeps the figures"
    path = read(f"CC X+10 Y+0\n{CHANGES['shift']}\nLP PR+5 PA+90 F100")
    assert any(said in each for each in path.assumed) and np.allclose(path.tip[-1], (0.1, 0.005, 0.0))
    assert not any(said in each for each in read("CC X+10 Y+0\nLP PR+5 PA+90 F100").assumed)


@pytest.mark.parametrize("words", ["PR+10 IPA+30", "PR+10", "IPR+5"])
def test_a_polar_block_from_the_pole_itself_needs_its_angle(words):
    with pytest.raises(ProgramError, match="from the pole itself a polar block needs the angle of its end"):
        read(f"L X+25 Y+25 F100\nCC\nLP {words}")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("CP IPA+0 IZ+5 DR+", "IPA of CP is zero"), ("CP PA+90 IPA+90 DR+", "PA or IPA, and PR or IPR"),
        ("LP PR+5 IPR+1 PA+0", "PA or IPA, and PR or IPR"),
    ],
)  # fmt: skip
def test_faults_of_polar_blocks(words, message):
    """The first was a whole turn of a helix, of the others one word was passed over."""
    with pytest.raises(ProgramError, match=message):
        read(f"CC X+0 Y+0\nL X+10 F100\n{words}")


def test_a_radius_that_is_too_short_by_some_micrometres_is_said():
    said = "a CR whose R is shorter than half the way to its end"
    for radius, there in ((4.99, True), (4.999, False), (5.01, False)):
        assert any(said in each for each in read(f"CR X+10 Y+0 R+{radius} DR+ F100").assumed) == there
    with pytest.raises(ProgramError, match="is too small"):
        read("CR X+10 Y+0 R+4.98 DR+ F100")


def test_what_a_polar_block_leaves_out_is_said_where_the_last_motion_was_no_polar_one():
    said, begin = "takes the distance and the angle of the place where the tool is", "CC X+0 Y+0\nLP PR+10 PA+0 F100\n"
    path = read(begin + "L X+20 Y+0\nLP PA+90")
    assert any(said in each for each in path.assumed) and np.allclose(path.tip[-1], (0.0, 0.02, 0.0))
    assert not any(said in each for each in read(begin + "LP IPA+30\nLP PR+20\nCP IPA+40 DR+").assumed)

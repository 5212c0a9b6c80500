"""Corners, beginnings and ends of compensation, by numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.compensated import HEADS, SHEET, R, read
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool


def corners(text: str, control: str) -> list[tuple[float, float]]:
    """X, Y [mm] of the ends of straight motions, in order."""
    found = read(text, control)
    assert (found.bow == 0.0).all(), "there are arcs in it"
    return [(round(float(x) * 1e3, 4), round(float(y) * 1e3, 4)) for x, y, _ in found.tip]


# --- Fanuc: B-63944EN, "Details of cutter or tool nose radius compensation" -----------------------


def test_fanuc_goes_round_outside_corners_in_lines():
    """The offset ways meet at corners of up to a right angle; where less is left of it, each goes on by the radius."""
    root = math.sqrt(0.5) * R
    path = corners(
        "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nX50\nX80 Y20\nX-30\nG40 X-30 Y-40\nM30\n", "fanuc"
    )
    wanted = [
        (-20, -20), (-4, 0), (-4, 54), (50 + R * math.tan(math.pi / 8), 54),
        (80 + 2 * root, 20), (84, 16), (-30, 16), (-30, -40),
    ]  # fmt: skip
    assert np.allclose(path, wanted, atol=1e-4)


def test_fanuc_shortens_inside_corners_to_the_intersection():
    path = corners("G0 X20 Y20 Z0\nG41 D1 G1 X0 Y0 F500\nX50\nX20 Y30\nG40 X25 Y12\nM30\n", "fanuc")
    # the line back turns left by 135 degrees: its offset is y - 50 = -(x - 50) - 4 sqrt 2, of slope -1
    assert np.allclose(path[1:3], [(0, 4), (46 - 4 * math.sqrt(2), 4)], atol=1e-4)


def test_fanuc_reaches_an_arc_behind_an_outside_corner_by_its_tangent():
    """A line, and an arc about (40, 0) that begins upwards: their corner turns left, the tool is at the right."""
    found = read("G0 X-20 Y5 Z0\nG42 D1 G1 X0 Y0 F500\nX30\nG2 X40 Y10 I10 J0\nG1 X60\nG40 X80 Y30\nM30\n", "fanuc")
    path = (found.tip[:, :2] * 1e3).round(4).tolist()
    # along y = -4 to the tangent at x = 34, and along that to the arc of radius 6
    assert path[2:4] == [[34.0, -4.0], [34.0, 0.0]]
    on_arc = found.tip[4:-3, :2] * 1e3 - [40.0, 0.0]
    assert np.allclose(np.linalg.norm(on_arc, axis=1), 6.0, atol=1e-3)


@pytest.mark.parametrize(
    ("kind", "contour", "wanted"),
    [
        ("type A", "G42 D1 G1 X0 Y0 F500\nY40\nG40 X30 Y40\n", [(4, 0), (4, 40), (30, 40)]),
        ("type B", "G42 D1 G1 X0 Y0 F500\nY40\nG40 X-30 Y40\n", [(4, -4), (4, 44), (-30, 40)]),
        ("type B", "G42 D1 G1 X0 Y0 F500\nY40\nG40 X30 Y40\n", [(4, -4), (4, 40), (30, 40)]),
        ("type B", "G41 D1 G1 X0 Y0 F500\nY40\nG40 X30 Y40\n", [(-4, 0), (-4, 44), (30, 40)]),
        ("type B", "G42 D1 G1 X0 Y0 F500\nX-40 Y40\nG40 X-40 Y80\n", [(4, -4), (4 * math.sqrt(2), 0)]),
    ],
)
def test_types_of_beginning_and_end(tmp_path, kind, contour, wanted):
    """By type A across the contour's ends, by type B around the corner, where that is an outside one."""
    file = tmp_path / "mine.toml"
    file.write_text(f'name = "mine"\nlike = "fanuc"\nlanguage = "word-address"\n[options]\ncompensation = "{kind}"\n')
    found = read_text(
        HEADS["fanuc"] + f"G0 X-20 Y0 Z0\n{contour}M30\n", None, controller=file, setup=SHEET, name="part.nc"
    )
    path = [(float(x) * 1e3, float(y) * 1e3) for x, y, _ in found.tip]
    assert np.allclose(path[1 : 1 + len(wanted)], wanted, atol=1e-4)


def test_corners_of_arcs_are_an_option(tmp_path):
    """Yasnac's corners of Haas: each place of the centre is a radius away from the corner."""
    file = tmp_path / "mine.toml"
    head = 'name = "mine"\nlike = "haas"\nlanguage = "word-address"\n'
    file.write_text(f'{head}[options]\ncompensation_corners = "arcs"\n')
    text = HEADS["haas"] + "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nX50\nG40 X80\nM30\n"
    found = read_text(text, None, controller=file, setup=SHEET, name="part.nc")
    assert np.allclose(np.linalg.norm(found.tip[2:-2, :2] * 1e3 - [0, 50], axis=1), R) and len(found.tip) > 10


def test_one_plunge_between_two_elements_stands_at_their_corner():
    found = read("G0 X-20 Y-20 Z5\nG41 D1 G1 X0 Y0 F500\nZ-5\nY50\nX50\nG40 Y80\nM30\n", "fanuc")
    assert (found.tip[:3] * 1e3).round(4).tolist() == [[-20, -20, 5], [-4, 0, 5], [-4, 0, -5]]


def test_a_rounded_corner_is_compensated_too():
    found = read("G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50 ,R6\nX50\nG40 Y80\nM30\n", "fanuc")
    beside = np.linalg.norm(found.tip[3:-2, :2] * 1e3 - [6, 44], axis=1)
    assert np.allclose(beside, 10.0, atol=1e-3) and len(beside) > 5
    assert np.allclose(found.tip[2, :2] * 1e3, [-4, 44], atol=1e-6)


def test_the_centre_is_slower_within_arcs():
    """F is of the contour on arcs that the tool goes within, by their radii; else of the centre."""
    program = "G0 X-20 Y0 Z0\n{} D1 G1 X0 Y0 F600\nX20\nG3 X20 Y20 I0 J10\nG1 X-10\nG40 Y60\nM30\n"
    within = read(program.format("G41"), "fanuc")
    without = read(program.format("G42"), "fanuc")
    assert np.allclose(within.feed[within.block == 6], 0.01 * 6 / 10)
    assert np.allclose(without.feed[without.block == 6], 0.01)


# --- Sinumerik: Programming Manual Fundamentals, "Tool radius compensation" ------------------------------------------


def test_g451_lets_the_ways_meet():
    path = corners("G0 X-20 Y-20 Z0\nG451 G41 G1 X0 Y0 F500\nY50\nX50\nX80 Y20\nG40 X90 Y40\nM30\n", "sinumerik")
    root = math.sqrt(0.5) * R
    assert np.allclose(
        path, [(-20, -20), (-4, 0), (-4, 54), (50 + R * math.tan(math.pi / 8), 54), (80 + root, 20 + root), (90, 40)],
        atol=1e-4,
    )  # fmt: skip


def test_a_pointed_corner_has_an_arc_under_g451_and_a_slight_one_none_under_g450():
    """MD20210 (100 degrees) and MD20230 (10), as they are delivered; both are said."""
    pointed = read("G0 X-20 Y-20 Z0\nG451 G41 G1 X0 Y0 F500\nX60\nX0 Y-20\nG40 X-20 Y-60\nM30\n", "sinumerik")
    around = np.linalg.norm(pointed.tip[3:-3, :2] * 1e3 - [60, 0], axis=1)
    assert np.allclose(around, R, atol=1e-3) and len(around) > 5
    slight = corners("G0 X-20 Y-20 Z0\nG41 G1 X0 Y0 F500\nX60\nX120 Y-6\nG40 X140\nM30\n", "sinumerik")
    turned = math.atan2(6, 60)
    assert slight[2] == pytest.approx((60 + R * math.tan(turned / 2), R), abs=1e-4)
    for found in (pointed, read("G0 X-20 Y-20\nG41 G1 X0 Y0 F500\nX60\nX120 Y-6\nG40 X140\nM30\n", "sinumerik")):
        assert any("MD20230, MD20210" in said for said in found.assumed)


CONTOUR = "G41 {} G1 X10 Y10 F500\nY60\nX50 Y30\nG40 {}\nM30\n"


def test_kont_goes_round_the_ends_of_the_contour_where_it_comes_from_behind():
    """A line touches the circle about the contour's first point, an arc leads round it; away in the same way."""
    found = read("G0 X35 Y0 Z0\n" + CONTOUR.format("KONT G450", "X15 Y10"), "sinumerik")
    path = found.tip[:, :2] * 1e3
    first, last = np.array([10.0, 10.0]), np.array([50.0, 30.0])
    assert np.linalg.norm(path[1] - first) == pytest.approx(R) and path[-1] == pytest.approx([15, 10])
    assert (path[1] - path[0]) @ (path[1] - first) == pytest.approx(0.0, abs=1e-6)
    assert (path[-2] - path[-1]) @ (path[-2] - last) == pytest.approx(0.0, abs=1e-6)
    up = np.flatnonzero(np.isclose(path, [6, 10]).all(axis=1))[0]
    assert np.allclose(np.linalg.norm(path[1:up] - first, axis=1), R, atol=1e-3) and up > 5
    assert path[1][0] < 10.0 > path[up][0] and path[1][1] < 10.0


def test_kont_with_g451_lets_the_touching_line_meet_the_contour():
    found = read("G0 X35 Y0 Z0\n" + CONTOUR.format("KONT G451", "X90 Y60"), "sinumerik")
    begin, met = found.tip[:2, :2] * 1e3
    along = (met - begin) / np.linalg.norm(met - begin)
    assert met[0] == pytest.approx(6.0)
    assert abs(along[0] * (10 - begin[1]) - along[1] * (10 - begin[0])) == pytest.approx(R)


@pytest.mark.parametrize("word", ["NORM", "KONT"])
def test_norm_and_kont_are_one_before_the_contour(word):
    """From the side of the tool: straight to the place across the first point, and away from that across the last."""
    path = read("G0 X-20 Y-20 Z0\n" + CONTOUR.format(word, "X90 Y60"), "sinumerik").tip[:, :2] * 1e3
    assert np.allclose(path[[1, -2, -1]], [[6, 10], [52.4, 33.2], [90, 60]])


def test_cfc_and_cftcp_tell_what_f_is_the_speed_of():
    program = "G0 X-20 Y0 Z0\n{} G42 G1 X0 Y0 F600\nX20\nG3 X20 Y20 I0 J10\nG1 X-10\nG40 Y60\nM30\n"
    for word, speed in (("CFC", 0.014), ("CFTCP", 0.01), ("CFIN", 0.01), ("", 0.014)):
        found = read(program.format(word), "sinumerik")
        assert np.allclose(found.feed[found.block == 6], speed), word


def test_a_corner_is_gone_round_before_the_block_moves_across_the_plane():
    found = read("G0 X-20 Y-20 Z0\nG41 G1 X0 Y0 F500\nX50\nY-40 Z-8\nG40 X60\nM30\n", "sinumerik")
    points = found.tip * 1e3 - [0.0, 0.0, 100.0]  # words are those of the spindle's nose
    around = np.isclose(np.linalg.norm(points[:, :2] - [50, 0], axis=1), R, atol=1e-3)
    assert around.sum() > 5 and np.allclose(points[around, 2], 0.0)
    assert np.allclose(points[-2], [54, -40, -8])


@pytest.mark.parametrize("word", ["G41", "G42"])
def test_another_plane_is_the_same_way(word):
    """G18: Z is its first axis, X its second."""
    contour = [(0, 0), (50, 0), (50, 30), (20, 60), (-30, 60)]

    def path(plane: str, first: str, second: str, slots: list[int]) -> np.ndarray:
        lines = [f"G1 {first}{a} {second}{b}" for a, b in contour]
        text = f"{plane} G0 {first}-20 {second}-20\n{word} D1 F500 " + "\n".join(lines) + f"\nG40 {first}-90\nM30\n"
        return read(f"G0 X0 Y0 Z0\n{text}", "fanuc").tip[1:, slots]

    assert np.allclose(path("G17", "X", "Y", [0, 1]), path("G18", "Z", "X", [2, 0]))


def test_a_program_in_inches_has_the_radius_of_the_sheet():
    found = read("G20\nG0 X-1 Y-1 Z0\nG41 D1 G1 X0 Y0 F20\nY2\nG91 X2\nG40 Y1\nM30\n", "fanuc")
    assert np.allclose(found.tip[1:4, :2] * 1e3, [[-R, 0], [-R, 50.8 + R], [50.8, 50.8 + R]])


# --- Klartext, and all -----------------------------------------------------------------------------------------------

KLARTEXT = "L X-20 Y-20 Z+0 R0 FMAX\nL X+0 Y+0 RL F500\nL Y+50\n{}L X-20 R0\nM30\nEND PGM A MM\n"


@pytest.mark.parametrize(
    ("approach", "helper", "departure", "away"),
    [
        ("APPR LT X+5 Y+5 LEN10 RL", (1, -5), "DEP LT LEN10", [(105, 99)]),
        # across: "PN is separated from PE by the distance LEN plus the tool radius"
        ("APPR LN X+5 Y+5 LEN10 RL", (-9, 5), "DEP LN LEN20", [(95, 119)]),
        ("APPR LCT X+5 Y+5 R5 RL", None, "DEP LCT X+105 Y+120 R5", [(100, 104), (100, 120), (105, 120)]),
        ("APPR CT X+5 Y+5 CCA90 R+8 RL", (-7, -3), "DEP CT CCA90 R+8", [(103, 107)]),
    ],
)
def test_approach_and_departure_are_ways_of_the_centre(approach, helper, departure, away):
    """Their sizes are those of the centre's way, to and from the places across the contour's ends."""
    text = f"L X-10 Y-10 Z+0 R0 FMAX\n{approach} F300\nL Y+95\nL X+95\n{departure}\nM30\nEND PGM A MM\n"
    found = read(text, "heidenhain")
    path, line = found.tip[:, :2] * 1e3, found.block
    if helper is not None:
        assert np.allclose(path[1], helper)
    assert np.isclose(path, (1, 5)).all(axis=1).any() and np.allclose(path[line == 5][-1], (1, 95))
    assert np.allclose(path[line == 6][-1], (95, 99))
    assert np.allclose(path[-1], away[-1])


def test_the_examples_of_the_manual_with_a_tool_of_ten_millimetres():
    """APPR LCT R5 stands there with a tool of radius 10: an arc of the contour could have no room for it."""
    sheet = SetUp(tools={"1": Tool(0.0, 0.010)})
    linear = (
        "L X-10 Y-10 R0 FMAX\nL Z-5 R0 F1000 M3\nAPPR LT X+5 Y+5 LEN10 RL F300\nL Y+95\nL X+95\nCHF 10\nL Y+5\n"
        "CHF 20\nL X+5\nDEP LT LEN10 F1000\nL Z+250 R0 FMAX M2\nEND PGM A MM\n"
    )
    circular = (
        "L X-10 Y-10 R0 FMAX\nL Z-5 R0 F1000 M3\nAPPR LCT X+5 Y+5 R5 RL F300\nL X+5 Y+85\nRND R10 F150\n"
        "L X+30 Y+85\nCR X+70 Y+95 R+30 DR-\nL X+95\nL X+95 Y+40\nCT X+40 Y+5\nL X+5\nDEP LCT X-20 Y-20 R5 F1000\n"
        "L Z+250 R0 FMAX M2\nEND PGM A MM\n"
    )
    ends = [read(text, "heidenhain", sheet).tip[-1] * 1e3 for text in (linear, circular)]
    assert np.allclose(ends, [(-5, -5, 250), (-20, -20, 250)])


def test_dr_of_tool_call_adds_to_the_radius():
    text = KLARTEXT.format("L X+50\nL Y+0\n").replace("L X-20 Y-20 Z+0", "TOOL CALL 1 Z DR+0.5\nL X-20 Y-20 Z+0")
    found = read(text, "heidenhain")
    assert np.allclose(found.tip[1, :2] * 1e3, [-4.5, 0.0])


def test_a_radius_of_zero_is_the_contour():
    sheet = SetUp(tools={"1": Tool(0.1, 0.0)})
    for control, text in (("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG40 X9\nM30\n"), ("heidenhain", KLARTEXT.format(""))):
        text = text if control == "heidenhain" else f"G0 X-20 Y-20 Z0\n{text}"
        assert (read(text, control, sheet).tip[2, :2] * 1e3).tolist() == [0.0, 50.0]


def test_a_mirror_takes_the_tool_to_the_other_side():
    """The way under G51.1 is the mirrored way: the tool stays at the same face of the part."""
    contour = "G41 D1 G1 X10 Y0 F500\nY50\nX50\nG40 Y80\n"
    plain = corners(f"G0 X-20 Y-20 Z0\n{contour}M30\n", "fanuc")
    mirrored = corners(f"G51.1 X0\nG0 X-20 Y-20 Z0\n{contour}G50.1 X0\nM30\n", "fanuc")
    assert np.allclose(mirrored, np.array(plain) * [-1.0, 1.0])

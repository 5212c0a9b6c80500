"""Compensation by the rules of Fanuc, Sinumerik and Klartext.

The centre's distance from random contours, numbers worked out by hand, and what is refused.
"""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from testbed.linuxcnc.job import Cartesian
from toolpace.errors import ProgramError
from toolpace.reading import read_text
from toolpace.reading.coordinates.setup import SetUp, Tool

R = 4.0
"""Of the tool [mm]."""
SHEET = SetUp(tools={"1": Tool(0.1, R * 1e-3), "2": Tool(0.1)})
HEADS = {
    "fanuc": "G21 G90 G17 G94\nT1 M6\n",
    "haas": "G21 G90 G17 G94\nT1 M6\n",
    "sinumerik": "G71 G90 G17 G94\nT1 M6\n",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n",
}


def read(text: str, control: str, sheet: SetUp = SHEET):
    return read_text(HEADS[control] + text, None, controller=control, setup=sheet, name="part.nc")


def corners(text: str, control: str) -> list[tuple[float, float]]:
    """X, Y [mm] of the ends of straight motions, in order."""
    found = read(text, control)
    assert (found.bow == 0.0).all(), "there are arcs in it"
    return [(round(float(x) * 1e3, 4), round(float(y) * 1e3, 4)) for x, y, _ in found.tip]


def refused(text: str, control: str, sheet: SetUp = SHEET) -> str:
    with pytest.raises(ProgramError) as caught:
        read(text, control, sheet)
    return str(caught.value)


# --- random contours: every place of the centre lies at the tool's radius from its element ---------------------------


class Contour:
    """Lines and arcs, each larger than the tool, and their text for a control."""

    def __init__(self, seed: int, sharpest: float) -> None:
        random = Random(seed)
        self.side = random.choice([-1, 1])
        self.elements: list[tuple[complex, complex, complex | None, int]] = []
        """Start, end, centre or None, and sense."""
        at, heading = complex(random.uniform(-9, 9), random.uniform(-9, 9)), random.uniform(-3, 3)
        self.begin = at - cmath.rect(3 * R, heading + random.uniform(-1, 1))
        at, begin = self._rounded(at), self.begin
        self.begin = self._rounded(begin)
        for _ in range(random.randint(2, 7)):
            size = R * random.uniform(8, 14)
            if random.random() < 0.55:
                end = self._rounded(at + cmath.rect(size, heading))
                self.elements.append((at, end, None, 0))
                at, heading = end, cmath.phase(end - self.elements[-1][0])
            else:
                sense = random.choice([-1, 1])
                centre = self._rounded(at + cmath.rect(size, heading + sense * math.pi / 2))
                sweep = random.uniform(0.9, 2.5)
                end = centre + (at - centre) * cmath.exp(1j * sense * sweep)
                self.elements.append((at, end, centre, sense))
                at, heading = end, heading + sense * sweep
            heading += random.choice([0.0, -1.0, 1.0]) * random.uniform(0.2, sharpest)
        self.away = at + cmath.rect(3 * R, heading)

    @staticmethod
    def _rounded(point: complex) -> complex:
        return complex(round(point.real, 6), round(point.imag, 6))

    def text(self, control: str) -> str:
        """Blocks; each element is on the line of its number, from line 5 on."""
        klartext = control == "heidenhain"
        left = self.side > 0

        def xy(point: complex) -> str:
            return f"X{point.real:+.9f} Y{point.imag:+.9f}"

        if klartext:
            lines = [f"L {xy(self.begin)} Z+0 R0 FMAX", f"L {xy(self.elements[0][0])} {'RL' if left else 'RR'} F500"]
        else:
            word = "G41" if left else "G42"
            word = word if control == "sinumerik" else f"{word} D1"
            lines = [f"G0 {xy(self.begin)} Z0", f"{word} G1 {xy(self.elements[0][0])} F500"]
        for start, end, centre, sense in self.elements:
            if centre is None:
                lines.append(f"{'L' if klartext else 'G1'} {xy(end)}")
            elif klartext:
                lines += [f"CC {xy(centre)}", f"C {xy(end)} DR{'+' if sense > 0 else '-'}"]
            else:
                spoke = centre - start
                lines.append(f"{'G3' if sense > 0 else 'G2'} {xy(end)} I{spoke.real:.9f} J{spoke.imag:.9f}")
        lines.append(f"L {xy(self.away)} R0" if klartext else f"G40 G1 {xy(self.away)}")
        return "\n".join([*lines, "M30", *(["END PGM A MM"] if klartext else [])]) + "\n"


def distance(point: complex, element: tuple[complex, complex, complex | None, int]) -> float:
    """Of a point from an element, with its ends [mm]."""
    start, end, centre, sense = element
    if centre is None:
        return from_chord(point, start, end)
    swept, whole = ((cmath.phase((to - centre) / (start - centre)) * sense) % (2 * math.pi) for to in (point, end))
    if swept <= whole:
        return abs(abs(point - centre) - abs(start - centre))
    return min(abs(point - start), abs(point - end))


def elements_by_line(contour: Contour, text: str) -> dict[int, int]:
    """Number of the element of a line."""
    lines = text.splitlines()
    motions = [k for k, line in enumerate(lines, start=3) if line[:2] in ("L ", "C ", "G1", "G2", "G3", "G4", "G0")]
    return {line: number for number, line in enumerate(motions[2:-1])}


def check_distances(seed: int, control: str, sharpest: float) -> bool:
    """Whether the contour was read; then every place of the centre is checked."""
    contour = Contour(seed, sharpest)
    text = contour.text(control)
    try:
        found = read(text, control)
    except ProgramError as error:
        assert "does not fit" in str(error)
        return False
    of_line = elements_by_line(contour, text)
    reached = set()
    path = [complex(x, y) * 1e3 for x, y, _ in found.tip]
    for point, line in zip(path, found.block.tolist()):
        number = of_line.get(line)
        if number is None:
            continue
        reached.add(number)
        assert distance(point, contour.elements[number]) == pytest.approx(R, abs=1e-4)
        # beside a corner both its elements keep away
        for other, corner in ((number - 1, contour.elements[number][0]), (number + 1, contour.elements[number][1])):
            if 0 <= other < len(contour.elements) and abs(point - corner) < 2.0 * R:
                assert distance(point, contour.elements[other]) > R - 1e-4
    assert reached == set(range(len(contour.elements)))
    chords = list(pairwise(path))
    for start, end, centre, sense in contour.elements:
        if centre is None:
            middle, normal = (start + end) / 2, 1j * (end - start) / abs(end - start)
        else:
            half = (cmath.phase((end - centre) / (start - centre)) * sense) % (2 * math.pi) / 2
            middle = centre + (start - centre) * cmath.exp(1j * sense * half)
            normal = (centre - middle) / abs(centre - middle) * sense
        beside = middle + contour.side * R * normal
        assert min(from_chord(beside, a, b) for a, b in chords) < 1e-3
    return True


def from_chord(point: complex, start: complex, end: complex) -> float:
    way = end - start
    share = 0.0 if way == 0 else min(max(((point - start) * way.conjugate()).real / abs(way) ** 2, 0.0), 1.0)
    return abs(point - start - share * way)


def test_klartext_keeps_its_distance():
    """Outside corners are arcs, inside ones intersections (TNC 640, Klartext, "Tool radius compensation")."""
    assert sum(check_distances(seed, "heidenhain", 2.4) for seed in range(25)) >= 15


def test_sinumerik_keeps_its_distance():
    """G450, at corners that turn by more than the ten degrees up to which there is no arc."""
    assert sum(check_distances(seed, "sinumerik", 2.4) for seed in range(100, 125)) >= 12


@pytest.mark.sweep
def test_a_thousand_contours_keep_their_distance():
    assert sum(check_distances(seed, "heidenhain", 2.4) for seed in range(1000, 2000)) >= 500


# --- Fanuc: B-63944EN, "Details of cutter compensation" --------------------------------------------------------------


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


def offset_corners(points: list[np.ndarray], side: int, most: float) -> list[np.ndarray]:
    """The centre's corners along a polyline, by linear equations: n . x = n . p + R for the line of each edge.

    most: beyond how many radii from the edges' own ends two points stand in place of one.
    """
    ways = [(b - a) / np.linalg.norm(b - a) for a, b in pairwise(points)]
    normals = [side * np.array([-way[1], way[0]]) for way in ways]
    found = [points[0] + R * normals[0]]
    for k in range(1, len(ways)):
        sides = np.stack([normals[k - 1], normals[k]])
        met = np.linalg.solve(sides, sides @ points[k] + R)
        ends = [points[k] + R * normals[k - 1], points[k] + R * normals[k]]
        beyond = (met - ends[0]) @ ways[k - 1]
        if beyond > most * R:
            found += [ends[0] + R * ways[k - 1], ends[1] - R * ways[k]]
        else:
            found.append(met)
    return [*found, points[-1] + R * normals[-1]]


@pytest.mark.parametrize(
    ("control", "most", "sharpest"), [("fanuc", 1.0, 2.6), ("haas", 1.0, 2.6), ("sinumerik", 9.0, 1.7)]
)
def test_random_polylines_have_the_corners_of_linear_equations(control, most, sharpest):
    """Fanuc, and Sinumerik under G451 up to its 100 degrees."""
    for seed in range(60):
        random = Random(seed)
        side, heading = random.choice([-1, 1]), random.uniform(-3, 3)
        points = [np.array([0.0, 0.0])]
        for _ in range(random.randint(1, 8)):
            size = R * random.uniform(9, 30)
            points.append(points[-1] + size * np.array([math.cos(heading), math.sin(heading)]))
            heading += random.choice([-1, 1]) * random.uniform(0.05, sharpest)
        points = [np.round(point, 6) for point in points]
        word = ("G41" if side > 0 else "G42") + ("" if control == "sinumerik" else " D1")
        lines = [f"G1 X{x:.6f} Y{y:.6f}" for x, y in points[1:]]
        head = "G451\n" if control == "sinumerik" else ""
        text = f"{head}G0 X-40 Y-40 Z0\n{word} G1 X0 Y0 F500\n" + "\n".join([*lines, "G40 X99 Y99", "M30"])
        assert np.allclose(corners(text, control)[1:-1], offset_corners(points, side, most), atol=2e-4), text


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


def test_cfc_and_cftcp_tell_what_f_is_the_speed_of():
    program = "G0 X-20 Y0 Z0\n{} G42 G1 X0 Y0 F600\nX20\nG3 X20 Y20 I0 J10\nG1 X-10\nG40 Y60\nM30\n"
    for word, speed in (("CFC", 0.014), ("CFTCP", 0.01), ("CFIN", 0.01), ("", 0.014)):
        found = read(program.format(word), "sinumerik")
        assert np.allclose(found.feed[found.block == 6], speed), word


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("control", "contour", "said"),
    [
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nX-3\nY0\nG40 X9\n", "PS0041"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nG3 X53 Y3 R3\nG1 Y20\nG40 X9\n", "does not fit into this arc"),
        ("fanuc", "G41 D1 G2 X0 Y0 R30 F500\nY50\nG40 X9\n", "begins with a straight motion"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG40 G2 X30 Y50 R15\n", "straight motion behind G40"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nZ-5\nZ-6\nY50\nG40 X9\n", "2 blocks before this one"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nM8\nM3\nY50\nG40 X9\n", "2 blocks before this one"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nM0\nY50\nG40 X9\n", "M0 or M1 stands"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nX50\nZ-5\nX0 Y-20\nG40 X-20\n", "in several lines"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nY20\nG40 X9\n", "goes back on itself"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG42 D1 X50\nG40 X9\n", "write G40 before it"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG18 X50\nG40 X9\n", "change of the plane"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG81 X50 Y0 Z-3 R2\nG40 X9\n", "cycle of holes"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nY50\nG52 X5\nX50\nG40 X9\n", "change of coordinates"),
        ("fanuc", "G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "without D"),
        ("fanuc", "G41 D2 G1 X0 Y0 F500\nY50\nG40 X9\n", "radius"),
        ("fanuc", "G41 D9 G1 X0 Y0 F500\nY50\nG40 X9\n", "radius"),
        ("fanuc", "G10 L12 P1 R3\nG41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "G10 tells its radius"),
        ("fanuc", "G51 X0 Y0 P2.\nG41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "scaled"),
        ("fanuc", "G93\nG41 D1 G1 X0 Y0 F5\nY50 F5\nG40 X9 F5\n", "G93"),
        ("fanuc", "G41 D1 G1 X0 Y0 F500\nG40 X9\n", "before it has followed a contour"),
        ("iso", "G41 D1 G1 X0 Y0 F500\nY50\nG40 X9\n", "how this control compensates is not known"),
        ("sinumerik", "G41 KONT G1 X0 Y0 F500\nY50\nG40 X9\n", "NORM is read"),
        ("sinumerik", "DISC=50 G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "arcs are read without it"),
        ("sinumerik", "G462 G41 G1 X0 Y0 F500\nY50\nG40 X9\n", "G460 is read"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nG42 X50\nG40 X9\n", "changes the side"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nTRANS X5\nX50\nG40 X9\n", "change of coordinates"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nD2 X50\nG40 X9\n", "write G40 before it"),
        ("sinumerik", "AROT X30\nG41 G1 X0 Y0 F500\nY50\nG40 X9\n", "CUT2DF"),
        ("sinumerik", "G41 G1 X0 Y0 F500\nY50\nX-3\nY0\nG40 X9\n", "10750"),
    ],
)
def test_what_is_refused(control, contour, said):
    head = HEADS.get(control, HEADS["fanuc"])
    with pytest.raises(ProgramError, match=r"part\.nc") as caught:
        read_text(head + f"G0 X-20 Y-20 Z0\n{contour}M30\n", None, controller=control, setup=SHEET, name="part.nc")
    assert said in str(caught.value)


def test_a_reference_point_is_not_gone_to_from_a_compensated_contour():
    text = HEADS["fanuc"] + "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nG28 Z0\nG40 X9\nM30\n"
    with pytest.raises(ProgramError, match="machine coordinates under cutter compensation"):
        read_text(text, Cartesian(), controller="fanuc", setup=SHEET)


def test_axes_that_are_not_named_stay_beside_the_contour_until_a_motion_leads_away():
    """G40 alone: Z goes up where the centre is, in machine coordinates too, and the next motion starts there."""
    text = HEADS["fanuc"] + "G0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y0 F500\nY50\nG40\nZ5\nG53 Z0\nG0 X30\nM30\n"
    sheet = SetUp(tools=SHEET.tools, machine_zero=dict.fromkeys("XYZ", 0.0))
    found = read_text(text, Cartesian(), controller="fanuc", setup=sheet)
    assert np.allclose(found.tip[2:, :2] * 1e3, [[-4, 50], [-4, 50], [-4, 50], [30, 50]])
    assert any("stays beside the contour" in said for said in found.assumed)


KLARTEXT = "L X-20 Y-20 Z+0 R0 FMAX\nL X+0 Y+0 RL F500\nL Y+50\n{}L X-20 R0\nM30\nEND PGM A MM\n"


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("L X-3\nL Y+0\n", "does not fit"), ("L X+50 RR\n", "write R0 before it"),
        ("APPR LT X+20 Y+60 LEN5 RL\n", "APPR under RL"), ("L X+50 M97\n", "M97"),
        ("TOOL CALL 2 Z\n", "write R0 before it"),
        ("LN X+5 Y+5 Z+5 NX0 NY0 NZ1 TX0 TY0 TZ1\n", "LN"), ("CYCL DEF 7.0\nCYCL DEF 7.1 X+5\n", "coordinates"),
    ],
)  # fmt: skip
def test_what_is_refused_in_klartext(block, said):
    assert said in refused(KLARTEXT.format(block), "heidenhain")


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


def test_klartext_without_a_radius_names_the_cure():
    assert "[tools.N] radius" in refused(KLARTEXT.format(""), "heidenhain", SetUp(tools={"1": Tool(0.1)}))


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

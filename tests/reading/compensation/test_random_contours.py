"""Compensation on random contours: the centre's distance from them, and its corners by linear equations."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from tests.support.compensated import R, read
from toolpace.errors import ProgramError


def corners(text: str, control: str) -> list[tuple[float, float]]:
    """X, Y [mm] of the ends of straight motions, in order."""
    found = read(text, control)
    assert (found.bow == 0.0).all(), "there are arcs in it"
    return [(round(float(x) * 1e3, 4), round(float(y) * 1e3, 4)) for x, y, _ in found.tip]


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

"""Compensation on random contours, held against ways that are sampled, and against linear equations."""

from __future__ import annotations

import cmath
import math
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from testbed.compensation.held import ACCEPTED, ELSEWHERE, REFUSED, RULES, SAME, held, in_plane
from testbed.compensation.written import Form
from tests.support.compensated import R, read

PLAIN = Form()
EXTENDED = ("fanuc", "haas", "mazak", "type B", "G450", "G451")
"""Rules by which an outside corner makes a line longer that the inside corner before it takes away: sampling, which
looks at one corner alone, calls it a gouge."""


def outcomes(rule: str, seeds: range, form: Form = PLAIN, places: Callable = in_plane, controller=None) -> Counter:
    """How often what came of the contours; none is elsewhere, and none is refused that fits."""
    found = {seed: held(seed, rule, form, places=places, controller=controller) for seed in seeds}
    for seed, (outcome, off, said) in found.items():
        assert outcome not in (ELSEWHERE, REFUSED), f"seed {seed}: {outcome} by {off:.4g} mm, {said}"
        assert outcome != ACCEPTED or rule in EXTENDED, f"seed {seed}: {said}"
    return Counter(each.outcome for each in found.values())


@pytest.mark.parametrize("rule", [rule for rule in RULES if rule != "type B"])
def test_the_centre_goes_where_distances_say(rule):
    """Elements of all sizes, whole circles, corners of all angles: the same way, or refused by both."""
    assert outcomes(rule, range(16))[SAME] >= 9


def test_type_b_goes_round_the_ends_of_a_contour_by_their_tangents(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('name = "mine"\nlike = "fanuc"\nlanguage = "word-address"\n[options]\ncompensation = "type B"\n')
    assert outcomes("type B", range(20), controller=file)[SAME] >= 12


def turned(tip: np.ndarray) -> np.ndarray:
    """Places before a turn by 37 degrees about X3 Y-2."""
    return (in_plane(tip) - (3 - 2j)) * cmath.exp(-1j * math.radians(37.0)) + (3 - 2j)


@pytest.mark.parametrize(
    ("rule", "form", "places"),
    [
        ("fanuc", Form(plane="G18", ramps=True), lambda tip: (tip[:, 2] + 1j * tip[:, 0]) * 1e3),
        ("mazak", Form(plane="G19", incremental=True), lambda tip: (tip[:, 1] + 1j * tip[:, 2]) * 1e3),
        # the tool of 100 mm stands along the axis of the plane on a Sinumerik, and the tip is told along Z
        ("G450", Form(plane="G18", incremental=True), lambda tip: (tip[:, 2] - 0.1 + 1j * tip[:, 0]) * 1e3),
        ("G451", Form(plane="G19", ramps=True), lambda tip: (tip[:, 1] + 1j * (tip[:, 2] - 0.1)) * 1e3),
        ("haas", Form(inch=True, incremental=True, ramps=True), in_plane),
        ("G450", Form(inch=True, incremental=True, ramps=True), in_plane),
        ("heidenhain", Form(incremental=True), in_plane),
        ("fanuc", Form(head="G68 X3. Y-2. R37.", tail="G69"), turned),
        ("fanuc", Form(head="G51.1 X2.", tail="G50.1 X0"), lambda tip: 4.0 - in_plane(tip).conjugate()),
        ("G451", Form(head="MIRROR X0", tail="MIRROR"), lambda tip: -in_plane(tip).conjugate()),
        ("heidenhain", Form(head="CYCL DEF 8.0 M\nCYCL DEF 8.1 Y"), lambda tip: in_plane(tip).conjugate()),
    ],
)  # fmt: skip
def test_a_contour_written_in_another_way_is_gone_the_same_way(rule, form, places):
    """Other planes and units, increments, moves down within, turned and mirrored coordinates."""
    assert outcomes(rule, range(100, 112), form, places)[SAME] >= 6


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(1000, 1080), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(1080, 1200), marks=pytest.mark.thorough, id="many"),
    ],
)
@pytest.mark.parametrize("rule", [rule for rule in RULES if rule != "type B"])
def test_hundreds_of_contours(rule, seeds):
    assert outcomes(rule, seeds)[SAME] >= 0.6 * len(seeds)


def corners(text: str, control: str) -> list[tuple[float, float]]:
    """X, Y [mm] of the ends of straight motions, in order."""
    found = read(text, control)
    assert (found.bow == 0.0).all(), "there are arcs in it"
    return [(round(float(x) * 1e3, 4), round(float(y) * 1e3, 4)) for x, y, _ in found.tip]


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

"""Splines as the manuals define them, against their formulas."""

from __future__ import annotations

from itertools import pairwise
from math import comb

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from tests.support.controllers import read_for
from tests.support.sinumerik import read
from toolpace.common.errors import ProgramError

START = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0\n"
MOST = 0.5e-6
"""The promise: chords stay within half a micrometre [m]."""


def points(controller, body, **options):
    """Tips (n, 3) [mm] from the start of the spline on."""
    path = read_for(controller, body, **options)
    return path.tip * 1e3


def chord_gap(tips, curve, fine=200_001):
    """Greatest distance [m] from points of the curve (n, 2) [mm] to the chords between tips, by dense sampling."""
    places = curve(np.linspace(0.0, 1.0, fine))
    ends = tips[:, :2]
    # each chord is compared with the stretch of the curve between its ends, the first and the last being the curve's
    assert max(np.linalg.norm(ends[0] - places[0]), np.linalg.norm(ends[-1] - places[-1])) < 1e-6
    nearest = [0, *cKDTree(places).query(ends[1:-1])[1].tolist(), fine - 1]
    assert nearest == sorted(nearest)
    worst = 0.0
    for (a, b), (i, j) in zip(pairwise(ends), pairwise(nearest)):
        way = (b - a) / max(np.linalg.norm(b - a), 1e-12)
        off = places[i : j + 1] - a
        worst = max(worst, np.abs(off[:, 0] * way[1] - off[:, 1] * way[0]).max(initial=0.0))
    return worst * 1e-3


def bezier(*control):
    """Points of a Bezier curve by Bernstein's polynomials."""
    degree = len(control) - 1

    def curve(t):
        return sum(
            comb(degree, k) * (t**k * (1 - t) ** (degree - k))[:, None] * np.array(p) for k, p in enumerate(control)
        )

    return curve


def test_g5_is_a_cubic_spline_and_the_next_goes_on_smoothly():
    """LinuxCNC 2.9, G Codes, "G5 Cubic Spline": the curvy N of its example; I, J left out go on in line."""
    got = points("linuxcnc", START + "G5 I0 J3 P0 Q-3 X1 Y1\nM2")
    curve = bezier((0, 0), (0, 3), (1, -2), (1, 1))
    assert chord_gap(got, curve) < MOST and got[-1].tolist() == [1, 1, 0]
    both = points("linuxcnc", START + "G5 I0 J3 P0 Q-3 X1 Y1\nG5 P0 Q-3 X2 Y2\nM2")
    second = both[len(got) - 1 :]
    assert chord_gap(second, bezier((1, 1), (1, 4), (2, -1), (2, 2))) < MOST


def test_g51_is_a_parabola():
    """LinuxCNC 2.9, G Codes, "G5.1 Quadratic Spline": the parabola through the origin of its example."""
    got = points("linuxcnc", "G90 G17 G21 F600\nG0 X-2 Y4 Z0\nG5.1 X2 I2 J-8\nM2")
    assert chord_gap(got, lambda t: np.stack([4 * t - 2, (4 * t - 2) ** 2], axis=1)) < MOST


def test_g52_is_a_nurbs_with_weights():
    """LinuxCNC 2.9, G Codes, "G5.2 G5.3 NURBS Block": order 3, the present place first, P weights, even knots."""
    body = START + "G5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nG0 Z5\nM2"
    got = points("linuxcnc", body)[:-1]
    control = np.array([[0, 0], [0, 1], [2, 2], [2, 0], [0, 0]], dtype=float)
    weights = np.array([1, 1, 1, 1, 2.0])[:, None]
    knots = [0, 0, 0, 1, 2, 3, 3, 3]
    spline = BSpline(knots, np.hstack([control * weights, weights]), 2)

    def curve(t):
        found = spline(np.clip(t * 3, 0, 3 - 1e-12))
        return found[:, :2] / found[:, 2:]

    assert chord_gap(got, curve) < MOST and got[-1].tolist() == [0, 0, 0]


NURBS = (
    "G06.2 K0. X0. Z0.\nK0. X300. Z100.\nK0. X700. Z100.\nK0. X1300. Z-100.\n"
    "K0.5 X1700. Z-100.\nK0.5 X2000. Z0.\nK1.0\nK1.0\nK1.0\nK1.0\n"
)


def test_g62_is_a_nurbs_by_its_knots():
    """Fanuc B-63944EN, chapter "NURBS interpolation (G06.2)": the example, of order 4 with ten knots."""
    got = points("fanuc", START + NURBS + "G01 Y0.5\nM30")[:-1, [0, 2, 1]]
    control = np.array([[0, 0], [300, 100], [700, 100], [1300, -100], [1700, -100], [2000, 0]], dtype=float)
    spline = BSpline([0, 0, 0, 0, 0.5, 0.5, 1, 1, 1, 1], control, 3)
    assert chord_gap(got, lambda t: spline(np.clip(t, 0, 1 - 1e-12))) < MOST


def test_g62_with_weights_is_a_circle():
    """A quarter of a circle as a rational quadratic (Piegl and Tiller, The NURBS Book, 7.3): order P3, weights R."""
    body = "G90 G21 G17 F600\nG0 X10. Y0 Z0\nG6.2 P3 K0 X10. Y0\nK0 X10. Y10. R0.70710678118655\nK0 X0 Y10.\n"
    got = points("fanuc", body + "K1.\nK1.\nK1.\nG1 Y20.\nM30")[:-1]
    radius = np.linalg.norm(got[:, :2], axis=1)
    middle = np.linalg.norm((got[1:, :2] + got[:-1, :2]) / 2, axis=1)
    assert np.abs(radius - 10).max() < 1e-9 and (10 - middle).max() < MOST * 1e3


def test_a_spline_keeps_the_feed_and_its_time_under_g93():
    """The tip goes at F; under G93 the whole spline takes 1/F minutes (LinuxCNC 2.9, G Codes, "G93")."""
    path = read_for("linuxcnc", START + "G5.1 X4 I2 J-8\nM2")
    assert set(np.round(path.feed[1:], 9)) == {0.01}
    path = read_for("linuxcnc", START + "G93\nG5.2 L3 X0 Y1 F30\nX2 Y2\nX2 Y0\nG5.3\nM2")
    assert np.sum(path.least_time) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("controller", "body", "message"),
    [
        ("linuxcnc", "G5 X1 Y1 P0 Q-3", "first control point"),
        ("linuxcnc", "G5 X1 Y1 I0 J3", "write P and Q"),
        ("linuxcnc", "G5 X1 Y1 I0 P0 Q1", "takes both"),
        ("linuxcnc", "G18 G5 X1 Y1 I0 J1 P0 Q1", "G17"),
        ("linuxcnc", "G5.1 X1 Y1", "control point"),
        ("linuxcnc", "G5.2 L3\nX1 Y1\nG5.3", "at least 3 control points"),
        ("linuxcnc", "G5.2 L3\nX1 Y1\nX2 Y1 P-1\nG5.3", "above zero"),
        ("fanuc", "G6.2 K0 X0 Y0\nK0 X1.\nG1 X1.", "at least 4"),
        ("fanuc", "G6.2 X0 Y0", "write K"),
        ("fanuc", NURBS.replace("K0.5 X2", "K0.7 X2").replace("K1.0\n", "", 1), "is the program complete"),
        ("fanuc", NURBS.replace("K0. X0.", "K0. X1."), "1 mm from where the tool is"),
        ("fanuc", NURBS.replace("K0. X700.", "K-1. X700."), "knots of the spline fall"),
        ("fanuc", "G6.2 P99 K0 X0 Y0", "order 99"),
    ],
)
def test_splines_that_cannot_be_are_refused_with_what_to_write(controller, body, message):
    with pytest.raises(ProgramError, match=message):
        read_for(controller, START + body + "\nM30")


def test_bspline_of_sinumerik_goes_between_its_control_points():
    """Siemens NC Programming, "Spline interpolation": control points; SD the degree, PW weights; the ends are met."""
    text = "G1 X0 Y0\nBSPLINE SD=2 X0 Y10\nX20 Y20 PW=2\nX20 Y0\nX30 Y5\nG1 X40"
    path = read(text)
    got = path.tip[:-1] * 1e3
    control = np.array([[0, 0], [0, 10], [20, 20], [20, 0], [30, 5]], dtype=float)
    weights = np.array([1, 1, 2, 1, 1.0])[:, None]
    spline = BSpline([0, 0, 0, 1, 2, 3, 3, 3], np.hstack([control * weights, weights]), 2)

    def curve(t):
        found = spline(np.clip(t * 3, 0, 3 - 1e-12))
        return found[:, :2] / found[:, 2:]

    assert chord_gap(got, curve) < MOST and got[-1].tolist() == [30, 5, 0]
    assert any("knots of BSPLINE" in said for said in path.assumed)


def test_distances_of_control_points_count_from_the_last():
    """Siemens NC Programming, "Incremental dimensions": G91 counts from the last programmed position."""
    both = [read(f"BSPLINE {body}\nG1 G90 X9").tip for body in ("X1 Y1\nX2 Y3\nX4 Y4", "G91 X1 Y1\nX1 Y2\nX2 Y1")]
    assert np.allclose(both[0], both[1], atol=1e-12)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("BSPLINE X1 PL=1\nX2 PL=2\nX3 Y2 PL=1", "PL= is not read"),
        ("BSPLINE SD=5 X1\nX2\nX3 Y2", "SD=5"),
        ("BSPLINE X1 PW=0\nX2", "PW is the weight"),
        ("CSPLINE X1\nX2 Y2", "CSPLINE is not read: its tangents"),
        ("ASPLINE X1\nX2 Y2", "ASPLINE is not read: its tangents"),
        ("POLY PO[X]=(1,2,3) X1", "POLY"),
    ],
)
def test_splines_of_sinumerik_that_are_not_read(body, message):
    with pytest.raises(ProgramError, match=message):
        read(body + "\nG1 X50")

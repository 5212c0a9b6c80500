"""Arcs whose radii differ at their ends: MD21000, MD21010, and alarm 14040 (Parameter Manual; Diagnostics Guide)."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.support.sinumerik import SINUMERIK, read
from toolpace.common.errors import ProgramError

SAID = "MD21000, MD21010"


def half(off: float, radius: float = 10.0, **options):
    """Half a circle about the origin, whose end is so much farther out [mm]."""
    return read(f"G0 X{radius}\nG3 X{-radius - off} Y0 I{-radius} J0", start="G54 F900\nG0 X0 Y0 Z0\n", **options)


def circle_through(path):
    """Centre and radius [mm] of the points of an arc, by least squares, and how far the points are off it."""
    points = path.tip[2:, :2] * 1e3
    left = np.column_stack([2 * points, np.ones(len(points))])
    x, y, c = np.linalg.lstsq(left, (points**2).sum(axis=1), rcond=None)[0]
    radius = math.sqrt(c + x * x + y * y)
    return (x, y), radius, np.abs(np.hypot(*(points - [x, y]).T) - radius).max()


@pytest.mark.parametrize("off", [0.009, -0.009, 0.001])
def test_the_centre_is_moved_between_the_ends(off):
    """Of half a circle the nearest centre that is as far from both ends is their middle."""
    centre, radius, beside = circle_through(half(off))
    assert centre == pytest.approx((-off / 2, 0), abs=1e-6)
    assert radius == pytest.approx(10 + off / 2, abs=1e-6) and beside < 1e-6


def test_the_nearest_centre_that_is_as_far_from_both_ends():
    """A quarter from X20 to Y20.015 about the origin: the centre goes along the chord."""
    path = read("G0 X20\nG3 X0 Y20.015 I-20 J0", start="G54 F900\nG0 X0 Y0 Z0\n")
    (x, y), radius, beside = circle_through(path)
    assert x / y == pytest.approx(-20 / 20.015, rel=1e-4) and beside < 1e-6
    assert math.hypot(20 - x, y) == pytest.approx(radius, abs=1e-6) == math.hypot(x, 20.015 - y)


def test_from_five_micrometres_on_it_is_said():
    assert any(SAID in sentence for sentence in half(0.006).assumed)
    assert not any(SAID in sentence for sentence in half(0.004).assumed)


def test_how_far_they_may_differ_is_data_of_the_machine():
    with pytest.raises(ProgramError, match=r"mm off its circle .*at most 0\.01 mm or 0\.1 percent"):
        half(0.012)
    half(0.09, radius=100)
    with pytest.raises(ProgramError, match="mm off its circle"):
        half(0.11, radius=100)
    coarse = msgspec.structs.replace(SINUMERIK, options={**SINUMERIK.options, "arc_radii_mm": 0.05})
    half(0.045, controller=coarse)


def test_ends_too_close_for_their_radii_tell_no_centre():
    """14040, the root of 0.001: of a circle but for one degree 9 micrometres move the centre by half a millimetre."""
    end = 10.009 * np.array([math.cos(math.radians(-1)), math.sin(math.radians(-1))])
    with pytest.raises(ProgramError, match="alarm 14040"):
        read(f"G0 X10\nG3 X{end[0]:.6f} Y{end[1]:.6f} I-10 J0")

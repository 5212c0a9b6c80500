"""Profiles of tools of all kinds: they join, are convex, and are as wide and round as their figures say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from toolpace.cutting.tool_profile import ToolProfile
from toolpace.errors import UsageError
from toolpace.kernels.cutting.intrusion import depth_within
from toolpace.programs.tool_figures import Frustum, ToolFigures

TOOLS = {
    "flat": ToolFigures("flat", 0.01, flute_length=0.02),
    "face": ToolFigures("face", 0.05, flute_length=0.004),
    "bull": ToolFigures("bull", 0.01, corner_radius=0.002, flute_length=0.02),
    "ball": ToolFigures("ball", 0.01, flute_length=0.02),
    "cone": ToolFigures("taper", 0.004, taper=math.radians(5.0), flute_length=0.02),
    "tapered ball": ToolFigures("taper", 0.004, corner_radius=0.002, taper=math.radians(5.0), flute_length=0.02),
    "barrel": ToolFigures("barrel", 0.01, corner_radius=0.002, barrel_radius=0.06, flute_length=0.022),
    "lens": ToolFigures("lens", 0.01, corner_radius=0.001, barrel_radius=0.02, flute_length=0.02),
    "sharp lens": ToolFigures("lens", 0.01, barrel_radius=0.02, flute_length=0.02),
    "drill": ToolFigures("drill", 0.008, point_angle=math.radians(118.0), flute_length=0.04),
    "chamfer": ToolFigures("chamfer", 0.008, point_angle=math.radians(90.0), flute_length=0.01),
    "short ball": ToolFigures("ball", 0.01, flute_length=0.003),
}


@pytest.mark.parametrize("name", TOOLS)
def test_pieces_join_without_a_step_and_are_convex(name):
    profile = ToolProfile.of(TOOLS[name])
    z = np.linspace(0.0, profile.length, 4001)[1:-1]
    radius, across, along = profile.surface(z)
    slope = np.diff(radius) / np.diff(z)
    assert profile.cutting[0, 0] == 0.0 and profile.length == pytest.approx(TOOLS[name].flute_length)
    assert profile.cutting[1:, 0] == pytest.approx(profile.cutting[:-1, 1])
    assert (np.diff(slope) < 1e-6).all()
    assert np.hypot(across, along) == pytest.approx(1.0)
    # the normal is across the slope
    middle = np.abs(slope - -(along / across)[:-1]) < 0.02 * (1.0 + np.abs(slope))
    assert middle[50:].mean() > 0.99
    assert radius.max() <= profile.radius * (1.0 + 1e-12)


@pytest.mark.parametrize("name", ["flat", "face", "bull", "ball", "barrel", "lens", "sharp lens", "drill", "chamfer"])
def test_the_widest_place_is_half_the_diameter(name):
    assert ToolProfile.of(TOOLS[name]).radius == pytest.approx(0.5 * TOOLS[name].diameter)


def test_flat_ends():
    flats = {name: ToolProfile.of(figures).flat_radius for name, figures in TOOLS.items()}
    assert flats["flat"] == 0.005 and flats["bull"] == pytest.approx(0.003) and flats["cone"] == 0.002
    for name in ("ball", "tapered ball", "barrel", "lens", "sharp lens", "drill", "chamfer"):
        assert flats[name] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("corner", [0.0, 0.001, 0.004])
def test_a_lens_is_a_sphere_about_its_axis_a_corner_and_a_cylinder(corner):
    profile = ToolProfile.of(replace(TOOLS["lens"], corner_radius=corner))
    z = np.linspace(1e-6, 0.02, 2001)
    radius, across, along = profile.surface(z)
    on_end = np.abs(np.hypot(radius, 0.02 - z) - 0.02) < 1e-12
    # a ball of the corner's radius that rolls within the profile touches the end there, and the side
    height = z[~on_end][0]
    assert height == pytest.approx(profile.cutting[0, 1], abs=2e-5)
    centre = radius - corner * across, z - corner * along
    of_corner = ~on_end & (z < profile.cutting[-1, 0])
    assert np.ptp(centre[0][of_corner], axis=0) < 1e-12 if corner else not of_corner.sum() > 1
    assert radius[-1] == 0.005 and along[-1] == 0.0
    # with a corner of half the diameter it is a ball, with an end of a large radius a bull-nose mill
    ball = ToolProfile.of(replace(TOOLS["lens"], corner_radius=0.005)).surface(z)[0]
    assert ball == pytest.approx(ToolProfile.of(TOOLS["ball"]).surface(z)[0], abs=1e-9)
    bull = ToolProfile.of(replace(TOOLS["lens"], corner_radius=0.002, barrel_radius=1e3)).surface(z[50:])[0]
    assert bull == pytest.approx(ToolProfile.of(TOOLS["bull"]).surface(z[50:])[0], abs=1e-7)


def test_shank_and_holder_stand_on_the_edge():
    figures = ToolFigures(
        "flat",
        0.01,
        flute_length=0.02,
        stick_out=0.05,
        shank_diameter=0.008,
        holder=(Frustum(0.03, 0.04, 0.05), Frustum(0.02, 0.06, 0.06)),
    )
    profile = ToolProfile.of(figures)
    assert [piece[0, :2].tolist() for piece in profile.shank] == [[0.02, 0.05]]
    assert profile.shank[0][0, 5] == 0.004
    assert np.concatenate([piece[:, :2] for piece in profile.holder]).ravel() == pytest.approx([0.05, 0.08, 0.08, 0.1])


def test_the_last_piece_of_a_shank_goes_on_to_the_holder():
    shank = (Frustum(0.01, 0.01, 0.012),)
    profile = ToolProfile.of(ToolFigures("ball", 0.01, flute_length=0.02, stick_out=0.05, shank=shank))
    assert np.concatenate([piece[:, :2] for piece in profile.shank]).ravel() == pytest.approx([0.02, 0.03, 0.03, 0.05])
    assert profile.shank[1][0, 5] == 0.006


def test_a_point_as_flat_as_can_be_is_a_flat_end():
    profile = ToolProfile.of(ToolFigures("drill", 0.008, point_angle=math.pi, flute_length=0.02))
    assert profile.flat_radius == 0.004 and len(profile.cutting) == 1


def test_arcs_that_do_not_meet_are_refused():
    with pytest.raises(UsageError, match="barrel"):
        ToolProfile.of(ToolFigures("barrel", 0.01, barrel_radius=0.004))


@pytest.mark.parametrize("name", TOOLS)
def test_the_depth_of_a_place_within_is_its_distance_from_the_outline(name):
    """Of a drill or a tapered ball the nearest place may be on the point, below the height of the place."""
    profile = ToolProfile.of(TOOLS[name])
    z = np.linspace(0.0, profile.length, 4001)
    radius = profile.surface(z)[0]
    inward = np.linspace(0.0, 1.0, 400)
    outline = np.concatenate([np.c_[radius, z], np.c_[radius[0] * inward, 0.0 * inward]])
    outline = np.concatenate([outline, np.c_[radius[-1] * inward, profile.length + 0.0 * inward]])
    random = np.random.default_rng(4)
    for height in random.uniform(0.0, profile.length, 60):
        rho = random.uniform(0.0, float(profile.surface(np.array([height]))[0][0]))
        distance = np.hypot(*(outline - [rho, height]).T).min()
        assert depth_within(profile.cutting, rho, height) == pytest.approx(distance, abs=1e-5)

"""Engagement against closed forms: slots, shoulders, balls in planes, plunges, bores; and how errors fall."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.cut_scenes import Scene, never_cut, stations, straight
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

UPRIGHT = np.array([0.0, 0.0, 1.0])
DEPTH, BALL = 0.00243, 0.00103
LOW, HIGH = (-0.014, -0.01, -0.004), (0.01, 0.01, 0.0)
DEFAULT = 2e-4
"""A fiftieth of the tool's diameter."""


def tool(kind: str, **figures: float) -> ToolFigures:
    return ToolFigures(kind, 0.01, flute_length=0.008, **figures)


def below(y0: float, y1: float):
    """Material below z = 0 between two planes."""
    return lambda p: (p[:, 2] < 0.0) & (p[:, 1] > y0) & (p[:, 1] < y1)


def beside(figures: ToolFigures, depth: float, y0: float = -1.0, y1: float = 1.0) -> Scene:
    """A straight cut along x, with material between two planes."""
    tip = straight((-0.009, 0.0, -depth), (-0.003, 0.0, -depth))
    low, high = (LOW[0] + 0.008, max(LOW[1], y0), LOW[2]), (HIGH[0], min(HIGH[1], y1), 0.0)
    return Scene(figures, tip, UPRIGHT, len(tip) - 1, below(y0, y1), low, high)


def tilted(tilt: float, azimuth: float) -> Scene:
    """A ball in a plane, its axis tilted; the tip of the ball goes straight."""
    a, b = math.radians(tilt), math.radians(azimuth)
    axis = np.array([math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)])
    centre = straight((-0.009, 0.0, 0.005 - BALL), (-0.003, 0.0, 0.005 - BALL))
    return Scene(
        tool("ball"), centre - 0.005 * axis, axis, len(centre) - 1, below(-1.0, 1.0), (-0.006, LOW[1], LOW[2]), HIGH
    )


def plunged(figures: ToolFigures) -> Scene:
    tip = straight((0.0, 0.0, 0.0005), (0.0, 0.0, -DEPTH))
    return Scene(figures, tip, UPRIGHT, len(tip) - 1, below(-1.0, 1.0), (-0.007, -0.007, LOW[2]), (0.007, 0.007, 0.0))


SCENES = {
    "slot": beside(tool("flat"), DEPTH),
    "shoulder, up": beside(tool("flat"), DEPTH, y0=0.0025),
    "shoulder, down": beside(tool("flat"), DEPTH, y1=-0.0025),
    "wide shoulder, up": beside(tool("flat"), DEPTH, y0=-0.002),
    "ball, upright": tilted(0.0, 0.0),
    "ball, 15 ahead": tilted(15.0, 0.0),
    "ball, 30 aside": tilted(30.0, 90.0),
    "ball, 45 back": tilted(45.0, 180.0),
    "ball, 60 aside": tilted(60.0, -90.0),
    "ball on a step": beside(tool("ball"), BALL, y0=0.001),
    "bull nose in a corner": beside(tool("bull", corner_radius=0.002), DEPTH, y0=0.001),
    "plunge, ball": plunged(tool("ball")),
    "plunge, drill": plunged(tool("drill", point_angle=math.radians(118.0))),
}


def share_wrong(name: str, resolution: float, seed: int | None) -> float:
    """The angle over which arcs are wrong, as a share of all immersion, where chips are thick."""
    engagement, profile, _ = SCENES[name].cut(resolution, seed)
    errors = SCENES[name].errors(engagement, profile)
    return float(errors[:, 1].sum() / errors[:, 0].sum())


@pytest.mark.parametrize("name", SCENES)
def test_immersion_is_right_to_a_hundredth_at_a_fiftieth_of_the_diameter(name):
    assert share_wrong(name, DEFAULT, seed=1) < 0.01


@pytest.mark.sweep
def test_errors_fall_with_the_resolution():
    cells = (4e-4, 2e-4, 1e-4)
    means = [np.mean([share_wrong(name, cell, seed) for name in SCENES for seed in (None, 2)]) for cell in cells]
    assert means[0] < 0.02 and means[2] < 0.002
    assert means[2] < 0.3 * means[0]


@pytest.mark.parametrize(("side", "entry", "leave"), [("up", 0.0, 60.0), ("down", 120.0, 180.0)])
def test_a_shoulder_is_entered_and_left_where_the_textbook_says(side, entry, leave):
    # acos(1 - 2 a_e / D), with a quarter of the diameter
    engagement, _, _ = SCENES[f"shoulder, {side}"].cut(DEFAULT, 3)
    first, last = engagement.first_arc[-2:]
    assert np.degrees(engagement.entry[first : last - 2]) == pytest.approx(entry, abs=0.5)
    assert np.degrees(engagement.exit[first : last - 2]) == pytest.approx(leave, abs=0.5)
    assert engagement.width[-1] == pytest.approx(0.0025, abs=3e-5)
    assert engagement.depth[-1] == pytest.approx(DEPTH, abs=3e-5)


def test_width_depth_and_volume_of_a_slot():
    engagement, _, _ = SCENES["slot"].cut(DEFAULT, None)
    assert engagement.width[-10:] == pytest.approx(0.01, rel=1e-3)
    assert engagement.depth[-10:] == pytest.approx(DEPTH, abs=2e-5)
    assert engagement.removed[-20:].mean() == pytest.approx(0.01 * DEPTH * 1e-4, rel=5e-3)
    assert (engagement.bottom == 0.0).all()


def test_width_of_a_ball_in_a_plane():
    engagement, _, _ = SCENES["ball, upright"].cut(DEFAULT, None)
    segment = 0.005**2 * math.acos(1.0 - BALL / 0.005) - (0.005 - BALL) * math.sqrt(0.01 * BALL - BALL**2)
    # over ten cells of the way
    assert engagement.removed[-20:].mean() == pytest.approx(segment * 1e-4, rel=0.02)
    assert 0.98 < engagement.width[-1] / (2.0 * math.sqrt(0.01 * BALL - BALL**2)) <= 1.001
    assert engagement.depth[-1] == pytest.approx(BALL, abs=2e-5)


@pytest.mark.parametrize(("side", "cell"), [(1.0, 1e-4), (-1.0, 1e-4), (1.0, 3e-4), (-1.0, 3e-4)])
def test_the_thickest_chip_of_a_ball_is_at_the_border_of_its_cut(side, cell):
    """In a plane, and beside the groove of a pass before, where it is in the corner of both: closed forms."""
    radius, depth, step, axis = 4e-3, 1.636e-3, 2e-3, np.array([0.0, side * math.sin(0.26), math.cos(0.26)])
    profile = ToolProfile.of(ToolFigures("ball", 2.0 * radius, flute_length=6e-3))
    stock = DexelStock.box((0.0, -6e-3, -4e-3), (8e-3, 8e-3, 0.0), cell)
    wide = math.sqrt(radius**2 - (radius - depth) ** 2)
    shares = []
    for y in (0.0, step):
        centre = straight((-5e-3, y, radius - depth), (9e-3, y, radius - depth))
        found = stock.cut(profile, stations(centre - radius * axis, np.tile(axis, (len(centre), 1))))
        shares.append(found.chip_share[(centre[:, 0] > 2e-3) & (centre[:, 0] < 4.5e-3)])
    assert shares[0] == pytest.approx(np.full(len(shares[0]), wide / radius), rel=1e-3)
    corner = math.sqrt(wide**2 - (wide - step) ** 2) / radius
    assert (1.0 - 3e-3) * corner <= shares[1].min() and shares[1].max() <= 1.003 * corner


@pytest.mark.parametrize("depth", [0.00009, 0.0003, 0.0007])
def test_a_cut_counts_by_its_depth_in_part_of_a_slice(depth):
    """Less deep than half a slice, too: with an edge of one slice a force is in proportion to the depth."""
    figures = ToolFigures("flat", 0.01, flute_length=0.008, teeth=3, spindle_speed=100.0)
    tip = straight((-0.009, 0.0, -depth), (-0.003, 0.0, -depth))
    found = DexelStock.box((-0.006, -0.01, -0.004), HIGH, 2.5e-4).cut(
        ToolProfile.of(figures), stations(tip, np.tile(UPRIGHT, (len(tip), 1)))
    )
    assert found.top[-1] == pytest.approx(depth, abs=5e-6) and found.chip_share[-1] == pytest.approx(1.0, abs=1e-3)
    loads = EngagedForces(found, figures, Coefficients(800e6, 300e6)).loads(np.full(len(tip), 0.01))
    # K a f R times the sum of the sines of teeth that are a third of a turn apart, which is 1 at most
    assert loads.torque[-1] == pytest.approx(800e6 * depth * 0.01 / 300.0 * 5e-3, rel=0.02)


def test_some_stations_of_a_table_are_as_they_were():
    table, _, _ = SCENES["ball, 30 aside"].cut(4e-4, None)
    chosen = np.array([3, 5, len(table.along) - 1])
    part = table.at(chosen)
    assert len(part.first_arc) == 4 and part.slice_height == table.slice_height
    for k, i in enumerate(chosen):
        own, old = (slice(*each.first_arc[j : j + 2]) for each, j in ((part, k), (table, i)))
        assert (part.entry[own] == table.entry[old]).all() and (part.slice[own] == table.slice[old]).all()
    assert (part.chip_share == table.chip_share[chosen]).all()


def test_the_end_cuts_in_a_plunge():
    engagement, _, stock = plunged(tool("flat")).cut(DEFAULT, 5)
    assert engagement.bottom[-1] == 1.0 and engagement.along[-1] == pytest.approx(-1.0)
    assert len(engagement.slice) == 0
    assert engagement.width[-1] == pytest.approx(0.01, rel=1e-3)
    assert engagement.removed.sum() == pytest.approx(math.pi * 25e-6 * DEPTH, rel=5e-3)
    assert stock.volume_by_rays() == pytest.approx(stock.volume(), rel=1e-3)


@pytest.mark.parametrize("height", [8e-4, 4.17e-4])
def test_a_drill_is_nearly_as_wide_as_its_hole_in_slices_of_any_height(height):
    figures = tool("drill", point_angle=math.radians(118.0))
    tip = straight((0.0, 0.0, 0.001), (0.0, 0.0, -0.0038))
    stock = DexelStock.box((-0.007, -0.007, -0.008), (0.007, 0.007, 0.0), DEFAULT)
    widths = stock.cut(ToolProfile.of(figures), stations(tip), slice_height=height).width
    assert 0.975 < widths.max() / 0.01 < 1.001


def test_nothing_is_told_of_a_way_that_is_cut_already():
    profile, tip = ToolProfile.of(tool("ball")), SCENES["ball, upright"].tip
    stock = DexelStock.box(LOW, HIGH, DEFAULT)
    stock.cut(profile, stations(tip))
    left = stock.volume()
    again = stock.cut(profile, stations(tip))
    assert len(again.entry) == 0 and (again.width == 0.0).all() and (again.bottom == 0.0).all()
    assert stock.volume() == pytest.approx(left, rel=1e-6)


@pytest.mark.sweep
def test_a_helical_bore():
    turn = np.linspace(0.0, 3.3 * math.pi, 260)
    tip = np.stack([0.003 * np.cos(turn), 0.003 * np.sin(turn), -0.001 * turn / (2.0 * math.pi) + 1e-5], axis=1)
    profile = ToolProfile.of(tool("bull", corner_radius=0.002))
    axes = np.tile(UPRIGHT, (len(tip), 1))
    low, high = (-0.01, -0.01, -0.004), (0.01, 0.01, 0.0)
    scene = Scene(
        tool("bull", corner_radius=0.002),
        tip,
        UPRIGHT,
        len(tip) - 1,
        lambda p: ((p > low) & (p < high)).all(axis=1) & never_cut(profile, tip[:-1], axes[:-1], p),
        low,
        high,
    )
    engagement, _, _ = scene.cut(DEFAULT, 1)
    errors = scene.errors(engagement, profile)
    assert errors[:, 1].sum() < 0.01 * errors[:, 0].sum()


def test_stations_far_apart_are_cut_like_close_ones():
    profile = ToolProfile.of(tool("ball"))
    close, apart = (DexelStock.box(LOW, HIGH, DEFAULT) for _ in range(2))
    tip = straight((-0.02, 0.001, -BALL), (0.02, -0.002, -2.0 * BALL), 1e-4)
    close.cut(profile, stations(tip))
    found = apart.cut(profile, stations(tip[[0, -1]]))
    assert apart.volume() == pytest.approx(close.volume(), rel=1e-4)
    assert found.removed[1] == pytest.approx(found.removed.sum())


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_tool_that_stays_has_no_arcs(count):
    stock = DexelStock.box(LOW, HIGH, 4e-4)
    found = stock.cut(ToolProfile.of(tool("ball")), stations(np.tile([[0.0, 0.0, -0.002]], (count, 1))))
    assert len(found.first_arc) == count + 1 and len(found.entry) == 0
    assert (found.removed > 0.0).tolist() == [k == 0 for k in range(count)]


def random_scene(seed: int) -> Scene:
    """A tool that turns while it goes a curved way through a block that it has cut before."""
    random = np.random.default_rng(seed)
    kind = str(random.choice(["ball", "bull", "flat"]))
    figures = tool(kind, corner_radius=0.0015 if kind == "bull" else 0.0)
    s = np.linspace(0.0, 1.0, 90)[:, None]
    a, b, c = (random.uniform([-0.006, -0.004, -0.002], [0.002, 0.004, -0.001]) for _ in range(3))
    first = (1.0 - s) ** 2 * a + 2.0 * s * (1.0 - s) * b + s**2 * c
    tip = np.concatenate([first, c + s[1:] * random.uniform([-0.005, -0.005, -0.0005], [0.005, 0.005, 0.0005])])
    turn = np.linspace(0.0, 1.0, len(tip))[:, None]
    lean = random.uniform(-0.3, 0.3, 2) + turn * random.uniform(-0.3, 0.3, 2)
    axis = np.concatenate([lean, np.ones((len(tip), 1))], axis=1)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    last = int(random.integers(100, len(tip)))
    tip, axis, profile = tip[: last + 1], axis[: last + 1], ToolProfile.of(figures)
    fine = np.linspace(0.0, last, 3 * last + 1)[:-1]
    k, share = fine.astype(int), (fine % 1.0)[:, None]
    between = axis[k] + share * (axis[k + 1] - axis[k])
    between /= np.linalg.norm(between, axis=1)[:, None]
    ways = tip[k] + share * (tip[k + 1] - tip[k])

    def engaged(points):
        inside = ((points > LOW) & (points < HIGH)).all(axis=1)
        inside[inside] = never_cut(profile, ways, between, points[inside])
        return inside

    return Scene(figures, tip, axis, last, engaged, LOW, HIGH)


def missed(seed: int) -> tuple[float, float]:
    """The angle over which arcs are wrong, as a share of the immersion, and the immersion [rad]."""
    scene = random_scene(seed)
    engagement, profile, _ = scene.cut(DEFAULT, None)
    errors = scene.errors(engagement, profile, least=0.3)
    return (float(errors[:, 1].sum()), float(errors[:, 0].sum())) if len(errors) else (0.0, 0.0)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", [1])
def test_random_motions_in_what_they_have_cut_themselves(seed):
    wrong, whole = missed(seed)
    assert whole > 1.0 and wrong < 0.03 * whole


@pytest.mark.thorough
def test_200_random_motions():
    found = np.array([missed(seed) for seed in range(200)])
    assert found[:, 0].sum() < 0.01 * found[:, 1].sum()

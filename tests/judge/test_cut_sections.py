"""What the judge of the cut finds of sections, shapes and loads, against closed forms and the library."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import toolpace as tp
from tests.support.engagements import engagement
from toolpace.cutting.stock.solids import Body
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.judge.cut import (
    stocks,
)
from toolpace.judge.cut.beam import ToolBeam
from toolpace.judge.cut.sections import Poses, Section, Surface, SweptTools, ToolMotion
from toolpace.judge.cut.shapes import shape_of
from toolpace.judge.cut.stocks import MeshStock, box_stock, cylinder_stock
from toolpace.judge.cut.turning import Cutting, loads_of
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.tool_figures import ToolFigures

ALUMINIUM = Coefficients(800e6, 250e6, 100e6, 15e3, 20e3, 3e3)
FEED = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])


def straight(figures, stock, y=0.0, z=-2e-3, axis=UP):
    """The surface of a tool on its way along x through a stock."""
    x = np.arange(-20e-3, 20e-3, 0.1e-3)
    poses = Poses(
        np.column_stack([x, np.full_like(x, y), np.full_like(x, z)]), np.tile(axis, (len(x), 1)),
        np.zeros(len(x), dtype=np.int64),
    )  # fmt: skip
    shape = shape_of(figures)
    motion = ToolMotion(shape, poses.tip[-1], np.asarray(axis), 0.01 * FEED, np.zeros(3))
    return Surface(motion, len(x) - 1, poses, (shape,), stock)


def arcs_at(surface, heights):
    """Slice, entry and exit at heights."""
    return surface.arcs(surface.shape.length_at(np.asarray(heights)))


def immersion_at(surface, heights):
    """The angle in material at heights."""
    found = np.zeros(len(heights))
    for j, entry, leave in arcs_at(surface, heights):
        found[j] += leave - entry
    return found


def box(low, high, uncertainty=0.0):
    return box_stock(np.array(low), np.array(high), uncertainty)


WIDE = box([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])


def test_a_slot_is_half_a_turn_up_to_the_top_of_the_stock():
    surface = straight(ToolFigures("flat", 10e-3, flute_length=20e-3), WIDE)
    arcs = arcs_at(surface, (np.arange(8) + 0.5) * 0.5e-3)
    assert [j for j, _, _ in arcs] == [0, 1, 2, 3]
    for _, entry, leave in arcs:
        assert entry % (2.0 * math.pi) == pytest.approx(0.0, abs=1e-4)
        assert leave - entry == pytest.approx(math.pi, abs=1e-4)
    assert surface.top() == pytest.approx(5e-3 + 2e-3, abs=0.01e-3)


@pytest.mark.parametrize("width", [0.5e-3, 3e-3, 7e-3])
def test_a_shoulder_begins_where_its_width_says(width):
    """The stock is on the right of the feed: the edge leaves it where the chip is nothing."""
    stock = box([-1.0, -1.0, -1.0], [1.0, -5e-3 + width, 0.0])
    arcs = arcs_at(straight(ToolFigures("flat", 10e-3, flute_length=20e-3), stock), [0.5e-3, 1e-3])
    arc = math.acos(1.0 - width / 5e-3)
    assert len(arcs) == 2
    for _, entry, leave in arcs:
        assert leave == pytest.approx(math.pi, abs=1e-4) and leave - entry == pytest.approx(arc, abs=2e-3)


def test_a_ball_cuts_below_the_surface_it_is_tilted_on():
    """Against the circle in which a ball at depth meets a plane: the highest slice ends at the depth."""
    tool = ToolFigures("ball", 10e-3, flute_length=20e-3)
    immersion = immersion_at(straight(tool, WIDE, z=-1e-3), np.linspace(0.05e-3, 1.45e-3, 15))
    assert immersion == pytest.approx([math.pi] * 10 + [0.0] * 5, abs=1e-3)


def test_a_stock_is_larger_by_its_uncertainty_with_round_edges():
    stock = box([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 0.1)
    corner = 0.1 / math.sqrt(3.0)
    place = np.array([[-0.099, 0.5, 0.5], [-0.101, 0.5, 0.5], [-corner] * 3, [-0.1, -0.1, 0.5]]) * (1.0 - 1e-9)
    assert stock(place).tolist() == [True, False, True, False]
    round_bar = cylinder_stock(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.4, 0.1)
    place = np.array([[0.299, 0.0, 0.5], [0.301, 0.0, 0.5], [0.0, 0.0, 1.099], [0.29, 0.0, 1.09]])
    assert round_bar(place).tolist() == [True, False, True, False]


TOOLS = {
    "flat": ToolFigures("flat", 10e-3, flute_length=20e-3),
    "bull": ToolFigures("bull", 10e-3, corner_radius=2e-3, flute_length=20e-3),
    "ball": ToolFigures("ball", 10e-3, flute_length=20e-3),
    "taper": ToolFigures("taper", 6e-3, corner_radius=1e-3, taper=math.radians(10.0), flute_length=20e-3),
    "barrel": ToolFigures("barrel", 10e-3, corner_radius=2e-3, barrel_radius=60e-3, flute_length=25e-3),
    "lens": ToolFigures("lens", 10e-3, corner_radius=1e-3, barrel_radius=12e-3, flute_length=20e-3),
    "drill": ToolFigures("drill", 8e-3, point_angle=math.radians(118.0), flute_length=30e-3),
    "chamfer": ToolFigures("chamfer", 10e-3, point_angle=math.radians(90.0), flute_length=8e-3),
    "cut off": ToolFigures("ball", 10e-3, flute_length=3e-3),
}


@pytest.mark.parametrize("name", TOOLS)
def test_shapes_are_those_of_the_library(name):
    """The meridian, written apart, has the radii and normals of the tool that cuts the stock."""
    shape, profile = shape_of(TOOLS[name]), ToolProfile.of(TOOLS[name])
    height = np.linspace(1e-6, 0.999 * profile.length, 400)
    assert shape.reach == pytest.approx(profile.length) and shape.flat == pytest.approx(profile.flat_radius, abs=1e-9)
    radius, there, kappa = shape.at(shape.length_at(height))
    wanted, sine, cosine = profile.surface(height)
    assert there == pytest.approx(height, abs=1e-12) and radius == pytest.approx(wanted, abs=1e-9)
    assert np.sin(kappa) == pytest.approx(sine, abs=1e-6) and -np.cos(kappa) == pytest.approx(cosine, abs=1e-6)
    swept = SweptTools(np.array([0]), Poses(np.zeros((1, 3)), UP[None], np.array([0])), (shape,))
    for off in (-1e-6, 1e-6):
        place = np.column_stack([0.6 * (wanted + off), 0.8 * (wanted + off), height])
        assert (swept(place) == ((off < 0.0) & (height > 1e-9))).all()
    assert shape.widest == pytest.approx(profile.radius)


def test_a_lens_whose_end_is_as_round_as_it_is_wide_is_a_ball():
    lens = shape_of(ToolFigures("lens", 10e-3, corner_radius=1e-3, barrel_radius=5e-3, flute_length=20e-3))
    ball = shape_of(TOOLS["ball"])
    height = np.linspace(1e-6, 19e-3, 200)
    assert lens.at(lens.length_at(height))[0] == pytest.approx(ball.at(ball.length_at(height))[0], abs=1e-12)


def test_many_poses_hold_what_each_of_them_holds():
    """Poses are looked at in groups; here of two tools, which turn as they go, against each pose by itself."""
    rng = np.random.default_rng(5)
    shapes, count = tuple(shape_of(TOOLS[name]) for name in ("flat", "lens")), 150
    tip = np.cumsum(rng.normal(0.0, 1e-3, (count, 3)), axis=0)
    axis = UP + np.cumsum(rng.normal(0.0, 0.03, (count, 3)), axis=0)
    poses = Poses(tip, axis / np.linalg.norm(axis, axis=1)[:, None], rng.integers(0, 2, count))
    place = tip[rng.integers(0, count, 2000)] + rng.uniform(-8e-3, 8e-3, (2000, 3))
    found, some = SweptTools(np.arange(count), poses, shapes)(place), np.zeros(2000, dtype=bool)
    for k in range(count):
        off = place - poses.tip[k]
        height = off @ poses.axis[k]
        shape = shapes[poses.tool[k]]
        within = (height > 1e-9) & (height < shape.reach)
        radius = shape.at(shape.length_at(np.clip(height, 0.0, 0.9999 * shape.reach)))[0]
        some |= within & (np.linalg.norm(off - height[:, None] * poses.axis[k], axis=1) < radius)
    assert 300 < some.sum() < 1900 and (found == some).all()


def tilted_block(low, high, degrees):
    """The triangles of a box that is turned, and the turn."""
    turn = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()
    return Body(box=(np.array(low), np.array(high))).triangles() @ turn.T, turn


@pytest.mark.parametrize("uncertainty", [0.0, 2e-3])
def test_a_mesh_is_as_the_closed_form_of_its_body(uncertainty):
    triangles, turn = tilted_block([-20e-3, -10e-3, -5e-3], [15e-3, 12e-3, 8e-3], (20.0, 35.0, -50.0))
    # a second body that overlaps counts once
    both = np.concatenate([triangles, triangles + turn @ np.array([3e-3, 0.0, 0.0])])
    place = np.random.default_rng(4).uniform(-30e-3, 30e-3, (4000, 3))
    first = box_stock(np.array([-20e-3, -10e-3, -5e-3]), np.array([15e-3, 12e-3, 8e-3]), uncertainty)
    second = first(place @ turn - np.array([3e-3, 0.0, 0.0]))
    for mesh, wanted in ((triangles, first(place @ turn)), (both, first(place @ turn) | second)):
        assert 100 < wanted.sum() < 2000
        assert (MeshStock(mesh, uncertainty)(place) == wanted).all()


def test_a_mesh_of_many_triangles_is_looked_at_in_pieces(monkeypatch):
    monkeypatch.setattr(stocks, "AT_ONCE", 100)
    ball = Body(cylinder=(np.zeros(3), np.array([0.0, 0.0, 20e-3]), 30e-3)).triangles()
    place = np.random.default_rng(1).uniform(-20e-3, 25e-3, (600, 3))
    wanted = cylinder_stock(np.zeros(3), np.array([0.0, 0.0, 20e-3]), 30e-3, 1e-3)(place)
    off = MeshStock(ball, 1e-3)(place) != wanted
    assert off.sum() <= 1, "its facets are within a micrometre of the cylinder"


def down_into(figures, velocity, depth, hole=0.0):
    """The surface of a tool that has gone straight into a block, with a hole below it."""
    steps = np.arange(0.0, 1.0, 0.02)
    way = np.asarray(velocity) / np.linalg.norm(velocity)
    tip = (steps[:, None] - 1.0) * 5e-3 * way + np.array([0.0, 0.0, -depth])
    tip = np.concatenate([tip, [[0.0, 0.0, -depth]]])
    poses = Poses(tip, np.tile(UP, (len(tip), 1)), np.zeros(len(tip), dtype=np.int64))
    shape = shape_of(figures)
    hollow = cylinder_stock(np.array([0.0, 0.0, -1.0]), np.array([0.0, 0.0, 1.0]), 2.0 * hole, 0.0)

    def stock(place, margin=0.0):
        return WIDE(place, margin) & ~(hollow(place) & (hole > 0.0))

    motion = ToolMotion(shape, tip[-1], UP, np.asarray(velocity), np.zeros(3))
    return Surface(motion, len(tip) - 1, poses, (shape,), stock)


def test_a_plunge_cuts_with_the_whole_end_and_nothing_of_the_side():
    tool = ToolFigures("flat", 10e-3, teeth=2, flute_length=20e-3)
    surface = down_into(tool, [0.0, 0.0, -0.005], 3e-3)
    section = surface.section()
    ends = section.edges[[j for j, _, _ in section.arcs]]
    assert ends.min() == 0.0 and ends.max() == pytest.approx(5e-3)
    found = loads_of(section, Cutting(tool, ALUMINIUM, 50.0), surface.motion)
    assert found["removal_rate"] == pytest.approx(math.pi * 25e-6 * 0.005, rel=1e-3)
    assert found["chip"] == pytest.approx(0.005 / 100.0)
    # both teeth cut 5 mm each, at a mean radius of half of it
    tangential = 2.0 * 5e-3 * (800e6 * 5e-5 + 15e3)
    assert found["torque"] == pytest.approx(tangential * 2.5e-3, rel=1e-3)


def test_a_hole_below_a_plunge_leaves_a_ring():
    tool = ToolFigures("flat", 10e-3, teeth=2, flute_length=20e-3)
    surface = down_into(tool, [0.0, 0.0, -0.005], 3e-3, hole=3e-3)
    found = loads_of(surface.section(), Cutting(tool, None, 50.0), surface.motion)
    assert found["removal_rate"] == pytest.approx(math.pi * 16e-6 * 0.005, rel=0.1)


def test_a_ramp_cuts_with_side_and_end():
    tool = ToolFigures("flat", 10e-3, teeth=2, flute_length=20e-3)
    surface = down_into(tool, [0.01, 0.0, -0.001], 1e-3)
    section = surface.section()
    rate = loads_of(section, Cutting(tool, None, 50.0), surface.motion)["removal_rate"]
    # the whole end goes down; in front it is 1 mm deep
    assert rate == pytest.approx(0.001 * math.pi * 25e-6 + 0.01 * 10e-3 * 1e-3, rel=0.02)


def test_a_drill_takes_its_cross_section():
    tool = ToolFigures("drill", 8e-3, point_angle=math.radians(118.0), teeth=2, flute_length=30e-3)
    surface = down_into(tool, [0.0, 0.0, -0.004], 6e-3)
    found = loads_of(surface.section(), Cutting(tool, None, 20.0), surface.motion)
    assert found["removal_rate"] == pytest.approx(math.pi * 16e-6 * 0.004, rel=1e-3)
    assert found["chip"] == pytest.approx(0.004 / 40.0 * math.sin(math.radians(59.0)), rel=1e-3)


@pytest.mark.parametrize(
    "tool",
    [
        ToolFigures("flat", 10e-3, teeth=3, helix=0.5, stick_out=40e-3, flute_length=20e-3, material="carbide"),
        ToolFigures("bull", 8e-3, corner_radius=1e-3, teeth=2, helix=0.4, runout=5e-6, stick_out=30e-3, material="HSS"),
        ToolFigures("ball", 6e-3, teeth=2, helix=-0.5, clockwise=False, stick_out=25e-3, material="carbide"),
    ],
)  # fmt: skip
def test_loads_are_those_of_the_library(tool):
    """Two simulations that share no code, on one engagement."""
    arcs, shape = [(j, 0.4, 2.2) for j in range(10)], shape_of(tool)
    rims = shape.length_at(np.arange(11) * 0.2e-3)
    section = Section(np.column_stack([rims[:-1], rims[1:]]), tuple(arcs))
    speed, turns = 0.02, 100.0
    motion = ToolMotion(shape, np.zeros(3), UP, speed * FEED, np.zeros(3))
    found = loads_of(section, Cutting(tool, ALUMINIUM, turns), motion, ToolBeam(tool))
    theirs = tp.EngagedForces(engagement(arcs, 0.2e-3), tool, ALUMINIUM, turns).loads([speed])
    for name, value in (
        ("force", theirs.resultant), ("torque", np.abs(theirs.torque)), ("power", np.abs(theirs.power)),
        ("moment", theirs.moment), ("deflection", theirs.deflection), ("chip", theirs.chip),
    ):  # fmt: skip
        if name == "chip" and tool.runout > 0.0:
            continue
        assert found[name] == pytest.approx(value[0], rel=0.03), name


def test_angles_may_be_told_about_another_direction_of_the_feed():
    """Where a tool goes down nearly along its axis, the feed from station to station is not that of an instant."""
    surface = straight(ToolFigures("flat", 10e-3, flute_length=20e-3), WIDE)
    length = surface.shape.length_at(np.array([1e-3]))
    own, aside = (surface.motion.angle_of_feed(np.array(feed)) for feed in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]))
    seen = surface.seen_at(length, 120, first=own)
    assert own == 0.0 and seen.sum() == 60
    # seen from the spindle, what is ahead of a feed along x is 90 degrees clockwise of a feed along y
    assert (surface.seen_at(length, 120, first=aside) == np.roll(seen, 30, axis=1)).all()

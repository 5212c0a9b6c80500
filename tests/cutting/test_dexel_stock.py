"""The stock as dexels: volumes, offsets, depths, its surface, and what it refuses."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.cut_scenes import box_mesh, rotation, stations
from toolpace.cutting.stock.dexels import FRAME, DexelStock, check_memory
from toolpace.errors import UsageError

LOW, HIGH = (0.001, -0.004, 0.002), (0.013, 0.005, 0.0093)


def sphere(radius: float, rings: int = 48) -> np.ndarray:
    """A closed mesh (n, 3, 3) inscribed into a sphere."""
    polar = np.linspace(0.0, math.pi, rings + 1)
    turn = np.linspace(0.0, 2.0 * math.pi, 2 * rings + 1)
    points = radius * np.stack(
        [
            np.sin(polar)[:, None] * np.cos(turn),
            np.sin(polar)[:, None] * np.sin(turn),
            np.repeat(np.cos(polar)[:, None], len(turn), axis=1),
        ],
        axis=-1,
    )
    points[:, -1], points[0], points[-1] = points[:, 0], points[0, 0], points[-1, 0]
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    quads = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)
    normal = np.cross(quads[:, 1] - quads[:, 0], quads[:, 2] - quads[:, 0])
    return np.ascontiguousarray(quads[np.linalg.norm(normal, axis=1) > 0.0])


def mesh_volume(triangles: np.ndarray) -> float:
    return float(np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum() / 6.0)


def test_rays_see_the_volume():
    box = DexelStock.box(LOW, HIGH, 2e-4)
    assert box.volume() == pytest.approx(np.prod(np.subtract(HIGH, LOW)), rel=1e-12)
    assert box.volume_by_rays() == pytest.approx(box.volume(), rel=3e-4)
    cylinder = DexelStock.cylinder((0.0, 0.0, 0.0), (0.003, 0.004, 0.012), 0.01, 2e-4)
    assert cylinder.volume() == pytest.approx(math.pi * 25e-6 * 0.013, rel=1e-12)
    assert cylinder.volume_by_rays() == pytest.approx(cylinder.volume(), rel=1e-3)
    ball = sphere(0.006)
    assert DexelStock.mesh(ball, 2e-4).volume() == pytest.approx(mesh_volume(ball), rel=1e-3)


def test_a_mesh_whose_faces_and_edges_lie_in_rays_is_closed():
    # in the frame of the rays, with corners in the middle of cells: every edge is met by rays
    box = box_mesh((0.0, 0.0, 0.0), (0.002, 0.003, 0.004))
    box = np.concatenate([box, box_mesh((0.0005, 0.0005, 0.004), (0.0015, 0.0015, 0.005))])
    stock = DexelStock.mesh(box @ FRAME, 1e-3)
    assert stock.volume() == pytest.approx(25e-9, rel=0.1)


def test_overlapping_bodies_count_once():
    both = np.concatenate([box_mesh(LOW, HIGH), box_mesh(np.add(LOW, 0.001), np.add(HIGH, 0.001))])
    side = np.subtract(HIGH, LOW)
    assert DexelStock.mesh(both, 1e-4).volume() == pytest.approx(2.0 * side.prod() - (side - 0.001).prod(), rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_depth_is_the_distance_from_a_face(seed):
    turn = rotation(seed)
    stock = DexelStock.mesh(box_mesh((-0.01, -0.01, -0.01), (0.01, 0.01, 0.0)) @ turn.T, 2e-4)
    random = np.random.default_rng(seed)
    points = random.uniform(-0.008, 0.008, (2000, 3))
    points[:, 2] = random.uniform(-5e-4, 5e-4, 2000)
    assert stock.depths(points @ turn.T, 1e-3) == pytest.approx(-points[:, 2], abs=1e-9)
    assert np.array_equal(stock.contains(points @ turn.T), points[:, 2] < 0.0)


@pytest.mark.parametrize("distance", [0.0, 1e-4, 3e-4, 1.1e-3])
def test_grown_holds_the_offset_and_shrunk_is_within_it(distance):
    radius, cell = 0.005, 2e-4
    stock = DexelStock.cylinder((0.0, 0.0, -0.004), (0.0, 0.0, 0.004), 2.0 * radius, cell)
    grown, shrunk = stock.grown(distance), stock.shrunk(distance)
    turn = np.linspace(0.0, 2.0 * math.pi, 500)
    circle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    diagonal = math.sqrt(2.0) * cell
    top = np.array([0.0, 0.0, 0.004])
    higher, lower = top * (1.0 + (distance - 1e-7) / 0.004), top * (1.0 - (distance - 1e-7) / 0.004)
    assert grown.contains(np.concatenate([(radius + distance - 1e-7) * circle, 0.9 * radius * circle + higher])).all()
    left = shrunk.contains(np.concatenate([(radius - distance + 1e-7) * circle, 0.9 * radius * circle + lower]))
    assert not left.any()
    # and by no more than a cell's diagonal, with what askew rays round off
    assert not grown.contains((radius + distance + 1.5 * diagonal) * circle).any()
    assert shrunk.contains((radius - distance - 1.5 * diagonal) * circle).all()


def test_depth_of_a_solid_in_material():
    stock = DexelStock.box((-0.03, -0.03, -0.01), (0.03, 0.03, 0.0), 2e-4)
    holder = np.array([[0.02, 0.05, 0.01, 0.0, 0.0, 0.01]])
    tip = np.array([[0.0, 0.0, -0.019], [0.0, 0.0, -0.0203], [0.0, 0.0, -0.024], [0.2, 0.0, -0.024]])
    depth, place = stock.deepest((holder,), stations(tip))
    assert depth == pytest.approx([0.0, 0.0003, 0.004, 0.0], abs=2e-5)
    assert np.isnan(place[[0, 3]]).all() and (np.abs(place[2]) < 0.01).all()
    # beside a wall, by a tenth of a millimetre
    beside = stations(np.array([[0.0399, 0.0, -0.025], [0.0401, 0.0, -0.025]]))
    assert stock.depth_in_material((holder,), beside) == pytest.approx([1e-4, 0.0], abs=4e-5)


def test_a_copy_is_cut_apart():
    from toolpace.cutting.tool_profile import ToolProfile
    from toolpace.programs.tool_figures import ToolFigures

    stock = DexelStock.box((0.0, 0.0, 0.0), (0.01, 0.01, 0.01), 2e-4)
    other = stock.copy()
    ball = ToolProfile.of(ToolFigures("ball", 0.004, flute_length=0.01))
    found = other.cut(ball, stations(np.array([[0.005, 0.005, 0.004]])))
    assert stock.volume() == pytest.approx(1e-6) and stock.volume_by_rays() > other.volume_by_rays()
    hole = math.pi * (0.002**2 * 0.004 + 2.0 / 3.0 * 0.002**3)
    assert found.removed.sum() == pytest.approx(hole, rel=0.01)
    assert other.volume() == pytest.approx(1e-6 - hole, rel=1e-3)


def test_the_surface_is_closed():
    stock = DexelStock.mesh(sphere(0.006), 3e-4)
    triangles = stock.triangles()
    assert mesh_volume(triangles) == pytest.approx(stock.volume(), rel=5e-3)
    corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    there = {tuple(edge) for edge in edges.tolist()}
    assert all((b, a) in there for a, b in there)
    assert np.abs(np.linalg.norm(triangles, axis=2) - 0.006).max() < 1e-4


@pytest.mark.parametrize(
    ("build", "told"),
    [
        (lambda: DexelStock.box((0, 0, 0), (0.1, 0.0, 0.1)), "it is 100 x 0 x 100 mm"),
        (lambda: DexelStock.box((0, 0, 0), (0.1, 0.1, 0.1), 1e-6), "take .* MB, and 512 MB are allowed"),
        (lambda: check_memory(box_mesh(LOW, HIGH), 1e-5, 3e6, 3), "for 3 stocks .*, and 3 MB are allowed"),
        (lambda: DexelStock.box((0, 0, 0), (0.1, 0.1, 0.1), -1.0), "resolution"),
        (lambda: DexelStock.box((0, 0, math.nan), (0.1, 0.1, 0.1)), "low"),
        (lambda: DexelStock.cylinder((0, 0, 0), (0, 0, 0), 0.1), "both ends"),
        (lambda: DexelStock.mesh(np.zeros((0, 3, 3))), "no triangle"),
        (lambda: DexelStock.mesh(box_mesh(LOW, HIGH)[1:], 5e-4), "do not leave the mesh as they enter it"),
        (lambda: DexelStock.mesh(box_mesh(LOW, HIGH)[:, ::-1], 5e-4), "counterclockwise"),
    ],
)
def test_refused(build, told):
    with pytest.raises(UsageError, match=told):
        build()


def test_the_resolution_keeps_within_memory():
    for memory in (1e6, 1e7):
        stock = DexelStock.box((0.0, 0.0, 0.0), (0.1, 0.05, 0.02), memory=memory)
        assert stock.memory <= memory


def test_poses_need_unit_axes():
    from toolpace.cutting.tool_profile import ToolProfile
    from toolpace.programs.tool_figures import ToolFigures

    stock = DexelStock.box((0.0, 0.0, 0.0), (0.01, 0.01, 0.01), 1e-3)
    good = stations(np.zeros((2, 3)))
    bad = SimpleNamespace(tip=good.tip, axis=2.0 * good.axis)
    with pytest.raises(UsageError, match="no unit vectors"):
        stock.cut(ToolProfile.of(ToolFigures("ball", 0.004)), bad)

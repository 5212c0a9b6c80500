"""What is left above the finished part: scallops and corners by their closed forms, places, and nothing invented."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.support.cut_scenes import box_mesh
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.left_above_part import left_above_part, nearest_on_mesh, outside
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures

MM = 1e-3
CELL = 0.25 * MM


def along(corners) -> Stations:
    """Stations a cell apart along straight ways [mm], the tool upright."""
    corners = np.array(corners, dtype=float) * MM
    tips = [corners[:1]]
    for start, end in pairwise(corners):
        count = max(int(np.ceil(np.linalg.norm(end - start) / CELL)), 1)
        tips.append(start + np.arange(1, count + 1)[:, None] / count * (end - start))
    tip = np.concatenate(tips)
    n = len(tip)
    axis, none = np.tile([0.0, 0.0, 1.0], (n, 1)), np.zeros(n, dtype=np.int64)
    return Stations(tip, axis, np.arange(n, dtype=float), none, none, np.zeros(n, dtype=bool))


def raster(stepover):
    ways = []
    for k, y in enumerate(np.arange(-2.0, 8.01, stepover)):
        ways += [(-2.0, y, 0.0), (12.0, y, 0.0)][:: 1 if k % 2 == 0 else -1]
    return along(ways)


@pytest.mark.parametrize("stepover", [1.0, 2.0])
def test_a_raster_of_a_ball_leaves_its_scallops(stepover):
    stock = DexelStock.box(np.array([0, 0, -1]) * MM, np.array([10, 6, 0.4]) * MM, CELL)
    stock.cut(ToolProfile.of(ToolFigures("ball", 6 * MM, flute_length=20 * MM)), raster(stepover))
    part = box_mesh(np.array([0, 0, -1]) * MM, np.array([10, 6, 0]) * MM)
    found = left_above_part(stock, part, 10e-6)
    height = 3.0 - np.sqrt(9.0 - stepover**2 / 4.0)
    assert found.height == pytest.approx(height * MM, abs=0.8e-6)
    under_the_ball = 9.0 * np.arcsin(stepover / 6.0) + 0.5 * stepover * np.sqrt(9.0 - stepover**2 / 4.0)
    assert found.volume == pytest.approx((3.0 * stepover - under_the_ball) / stepover * 60 * MM**3, rel=0.05)
    # the ridges stand a step-over apart, and no place is told that is not on one
    assert all(abs((region.place[1] / MM / stepover) % 1.0 - 0.5) < 0.1 for region in found.regions)
    assert left_above_part(stock, part, 1.05 * height * MM).regions == ()


def test_a_mill_leaves_the_corners_of_a_pocket():
    """The place of the round that is farthest from both walls is on the diagonal, r (1 - 1 / sqrt 2) from each."""
    stock = DexelStock.box(np.array([0, 0, -3]) * MM, np.array([12, 12, 0]) * MM, CELL)
    inner = [(4, 4), (8, 4), (8, 8), (4, 8), (4, 4), (6, 6)]
    stock.cut(ToolProfile.of(ToolFigures("flat", 6 * MM, flute_length=20 * MM)), along([(*p, -2) for p in inner]))
    walls = [((0, 0, -3), (1, 12, 0)), ((11, 0, -3), (12, 12, 0)), ((1, 0, -3), (11, 1, 0)), ((1, 11, -3), (11, 12, 0))]
    boxes = [*walls, ((0.5, 0.5, -3), (11.5, 11.5, -2))]
    # bodies of one mesh may overlap
    part = np.concatenate([box_mesh(np.array(low) * MM, np.array(high) * MM) for low, high in boxes])
    found = left_above_part(stock, part, 0.1 * MM)
    assert len(found.regions) == 4
    for region in found.regions:
        # no ray may go along the very edge of the round
        assert -0.5 * CELL < region.height - 3.0 * (1.0 - np.sqrt(0.5)) * MM < 10e-6
        x, y, _ = np.minimum(region.place, 12 * MM - region.place)
        assert x == pytest.approx(y, abs=CELL) and x == pytest.approx(1 * MM + region.height, abs=CELL)
    assert found.volume == pytest.approx((4.0 - np.pi) * 9.0 * 2.0 * MM**3, rel=0.1)


def test_what_was_not_cut_at_all_is_as_high_as_it_stands_and_what_fits_leaves_nothing():
    stock = DexelStock.box(np.zeros(3), np.array([10, 8, 5]) * MM, CELL)
    found = left_above_part(stock, box_mesh(np.zeros(3), np.array([10, 8, 3]) * MM), 0.1 * MM)
    assert found.height == pytest.approx(2.0 * MM, abs=1e-9) and len(found.regions) == 1
    assert found.volume == pytest.approx(160 * MM**3, rel=1e-3)
    assert found.regions[0].volume == pytest.approx(found.volume, rel=1e-3)
    # a part that is as large, or larger
    for more in (0.0, 1.0):
        part = box_mesh(np.array([-more, 0, 0]) * MM, np.array([10 + more, 8, 5]) * MM)
        none = left_above_part(stock, part, 1e-6)
        assert none.volume < 1e-3 * MM**3 and none.regions == () and none.height < 1e-6
    # beside a part in a corner of the stock the far corner is the farthest
    far = left_above_part(stock, box_mesh(np.zeros(3), np.array([7, 4, 5]) * MM), 0.1 * MM)
    assert far.height == pytest.approx(5.0 * MM, abs=1.5 * CELL) and far.height <= 5.0 * MM


def test_a_part_that_no_ray_meets_leaves_all_of_the_stock():
    stock = DexelStock.box(np.zeros(3), np.array([4, 4, 4]) * MM, CELL)
    found = left_above_part(stock, box_mesh(np.full(3, 10) * MM, np.full(3, 12) * MM), 0.1 * MM)
    assert found.volume == pytest.approx(64 * MM**3, rel=4e-3)
    assert found.height == pytest.approx(np.sqrt(3) * 10 * MM, rel=0.05)


def test_intervals_outside_of_others_are_those_of_dense_samples():
    r = np.random.default_rng(3)
    sets = []
    for _ in range(2):
        ends = np.sort(r.uniform(0.0, 1.0, (50, 6)), axis=1)
        sets.append((np.repeat(np.arange(50), 3), ends[:, ::2].ravel(), ends[:, 1::2].ravel()))
    found = outside(*sets)
    at = r.uniform(0.0, 1.0, (50, 400))

    def within(rays, begin, end):
        inside = np.zeros(at.shape, dtype=bool)
        for ray, low, high in zip(rays, begin, end):
            inside[ray] |= (at[ray] > low) & (at[ray] < high)
        return inside

    assert (within(*found[:3]) == (within(*sets[0]) & ~within(*sets[1]))).all()


def test_the_nearest_place_of_a_mesh_is_that_of_dense_samples():
    r = np.random.default_rng(5)
    mesh = box_mesh(np.zeros(3), np.array([1.0, 2.0, 3.0]))
    for place in r.uniform(-2.0, 5.0, (60, 3)):
        exact = np.clip(place, 0.0, [1.0, 2.0, 3.0])
        if (exact != place).any():
            assert np.abs(nearest_on_mesh(place, mesh, 20.0) - exact).max() < 1e-12

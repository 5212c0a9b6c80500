"""Cut stocks against exact booleans of swept tools (manifold3d), on random five-axis sweeps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from tests.support.cut_scenes import box_mesh, stations
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures

manifold3d = pytest.importorskip("manifold3d")
FACETS = 64
LOW, HIGH = np.array([-0.012, -0.012, -0.012]), np.array([0.012, 0.012, 0.0])
SLOPES = 16
"""Steps of a rounded profile."""


def area_kept(step: float) -> float:
    """By how much a polygon with steps of this angle is larger than the circle in it that has its area."""
    return math.sqrt(step / math.sin(step))


def outline(profile: ToolProfile) -> np.ndarray:
    """Heights and radii (k, 2) of a tool; where it is round, of a polygon that has the area of the arc.

    With its corners on the arc, a shallow cut of a ball would be half a percent too small.
    """
    found = []
    for z0, z1, a, b, arc, _ in profile.cutting:
        if arc == 0.0:
            found += [[z0, a + b * z0], [z1, a + b * z1]]
            continue
        angle = np.linspace(math.asin((z0 - b) / arc), math.asin((z1 - b) / arc), SLOPES + 1)
        wide = arc * area_kept(angle[1] - angle[0])
        found += np.stack([b + wide * np.sin(angle), np.maximum(a + wide * np.cos(angle), 0.0)], axis=1).tolist()
    return np.array(found)


def tool_points(profile: ToolProfile) -> np.ndarray:
    """Points (k, 3) whose convex hull is the tool; the polygon has the area of the circle."""
    turn = 2.0 * math.pi * np.arange(FACETS) / FACETS
    wider = area_kept(2.0 * math.pi / FACETS)
    rings = [
        np.stack([wider * r * np.cos(turn), wider * r * np.sin(turn), np.full(FACETS, z)], axis=1)
        for z, r in outline(profile)
    ]
    return np.concatenate(rings)


def swept(points: np.ndarray, tip: np.ndarray, axis: np.ndarray):
    """The union of the hulls of neighbouring poses (n, 3)."""
    placed = []
    for one, up in zip(tip, axis):
        side = np.cross(up, [0.0, 1.0, 0.0])
        side /= np.linalg.norm(side)
        placed.append(one + points @ np.array([side, np.cross(up, side), up]))
    hulls = [manifold3d.Manifold.hull_points(np.concatenate(pair)) for pair in itertools.pairwise(placed)]
    return manifold3d.Manifold.batch_boolean(hulls, manifold3d.OpType.Add)


def random_sweep(random: np.random.Generator, count: int) -> tuple[ToolFigures, np.ndarray, np.ndarray]:
    """A tool, and a smooth motion of tip and axis (n, 3) through the top of the block."""
    kind = random.choice(["ball", "bull", "flat", "taper"])
    figures = ToolFigures(
        str(kind),
        random.uniform(0.004, 0.01),
        corner_radius=0.001 if kind in ("bull", "taper") else 0.0,
        taper=0.1 if kind == "taper" else 0.0,
        flute_length=0.02,
    )
    s = np.linspace(0.0, 1.0, count)[:, None]
    a, b, c = (random.uniform([-0.014, -0.014, -0.005], [0.014, 0.014, -0.0015]) for _ in range(3))
    tip = (1.0 - s) ** 2 * a + 2.0 * s * (1.0 - s) * b + s**2 * c
    lean = (1.0 - s) * random.uniform(-0.4, 0.4, 2) + s * random.uniform(-0.4, 0.4, 2)
    axis = np.concatenate([lean, np.ones((count, 1))], axis=1)
    return figures, tip, axis / np.linalg.norm(axis, axis=1)[:, None]


def exact_volume(figures: ToolFigures, tip: np.ndarray, axis: np.ndarray) -> float:
    """Volume of the block within the sweep of a tool through poses (n, 3) [m3]."""
    # in micrometres, so that the coordinates are far from the tolerance of the booleans
    block = manifold3d.Manifold.cube((1e6 * (HIGH - LOW)).tolist()).translate((1e6 * LOW).tolist())
    return (block ^ swept(1e6 * tool_points(ToolProfile.of(figures)), 1e6 * tip, axis)).volume() * 1e-18


def compared(seed: int, count: int) -> tuple[float, float, float]:
    """Exact volume of a random cut [m3]; what the table and what the rays say, as shares of it.

    The hull of two poses holds more than the sweep. Of a flat end that turns, this falls with the first power of the
    step: 0.35 percent with 41 poses and 36 degrees. Hulls of `count` poses and of half their step are extrapolated.
    """
    coarse, fine, path = (random_sweep(np.random.default_rng(seed), n) for n in (count, 2 * count - 1, 161))
    exact = 2.0 * exact_volume(*fine) - exact_volume(*coarse)
    stock = DexelStock.mesh(box_mesh(LOW, HIGH), 2e-4)
    before = stock.volume_by_rays()
    figures, tip, axis = path
    engagement = stock.cut(ToolProfile.of(figures), stations(tip, axis))
    return exact, engagement.removed.sum() / exact, (before - stock.volume_by_rays()) / exact


@pytest.mark.parametrize(
    "seed", [0, pytest.param(1, marks=pytest.mark.sweep), pytest.param(10, marks=pytest.mark.sweep)]
)
def test_the_volume_of_a_sweep_is_that_of_exact_booleans(seed):
    exact, removed, by_rays = compared(seed, 11)
    assert exact > 1e-9
    assert removed == pytest.approx(1.0, abs=0.005) and by_rays == pytest.approx(1.0, abs=0.005)


@pytest.mark.thorough
def test_the_volumes_of_200_sweeps_are_those_of_exact_booleans():
    found = np.array([compared(seed, 21) for seed in range(200)])
    assert np.abs(found[:, 1:] - 1.0).max() < 0.005

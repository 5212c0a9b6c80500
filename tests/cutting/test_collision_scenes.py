"""Collisions of random tools with a box, a fixture or a finished part, against the depth of convex bodies.

The depth of a point in a cone about the tool axis is a concave function; its maximum over a box is found by a grid that
closes in. Of this, contacts deeper than the stated size are told, and what is told is there.
"""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.simulate import TOLD, UNSEEN, Surroundings, ToolInUse, cut_stations
from toolpace.cutting.simulation.stock_range import StockRange
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import Frustum, ToolFigures
from toolpace.programs.toolpath import Operation

MM = 1e-3
CELL = 0.5 * MM
LOW, HIGH = np.array([0.0, 0.0, -15.0]) * MM, np.array([30.0, 20.0, 0.0]) * MM
KIND = {"cutting": "rapid", "shank": "shank", "holder": "holder"}


def depth_in_box(solid: np.ndarray, tip: np.ndarray, axis: np.ndarray) -> float:
    """How deep a cone or a cylinder is in the box; below zero: how far it is away, or less."""
    ((z0, z1, a, b, arc, _),) = solid
    assert arc == 0.0
    low, high = LOW, HIGH
    deepest = -np.inf
    for _ in range(10):
        sides = [np.linspace(low[k], high[k], 17) for k in range(3)]
        points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
        off = points - tip
        height = off @ axis
        across = np.sqrt(np.maximum((off**2).sum(axis=1) - height**2, 0.0))
        depth = np.minimum(np.minimum(height - z0, z1 - height), (a + b * height - across) / np.hypot(1.0, b))
        deepest, best = max(deepest, float(depth.max())), points[depth.argmax()]
        reach = 0.3 * (high - low)
        low, high = np.maximum(LOW, best - reach), np.minimum(HIGH, best + reach)
    return deepest


def scene(rng: np.random.Generator) -> tuple[ToolFigures, Stations, dict[str, float]]:
    """A tool that goes straight a short way at rapid, and how deep each of its parts gets into the box."""
    figures = ToolFigures(
        "flat", rng.uniform(4.0, 12.0) * MM, flute_length=rng.uniform(4.0, 12.0) * MM, stick_out=25.0 * MM,
        shank_diameter=rng.uniform(4.0, 12.0) * MM,
        holder=(Frustum(rng.uniform(10.0, 30.0) * MM, *(rng.uniform(13.0, 40.0, 2) * MM)),),
    )  # fmt: skip
    axis = np.array([0.0, 0.0, 1.0]) if rng.random() < 0.3 else rng.normal(size=3)
    axis[2] = abs(axis[2])
    axis /= np.linalg.norm(axis)
    begin = rng.uniform([-15.0, -15.0, -25.0], [45.0, 35.0, 8.0]) * MM
    tips = begin + np.linspace(0.0, 1.0, 7)[:, None] * rng.normal(size=3) * 2.0 * MM
    n = len(tips)
    stations = Stations(
        tips, np.tile(axis, (n, 1)), np.arange(n) * 0.1, np.full(n, 7), np.zeros(n, dtype=int), np.ones(n, dtype=bool)
    )
    profile = ToolProfile.of(figures)
    parts = {"cutting": (profile.cutting,), "shank": profile.shank, "holder": profile.holder}
    return figures, stations, {
        name: max(depth_in_box(solid, tip, axis) for solid in solids for tip in tips) for name, solids in parts.items()
    }  # fmt: skip


def check(seed: int) -> int:
    rng = np.random.default_rng(seed)
    figures, stations, depths = scene(rng)
    role = ("stock", "fixture clamp", "finished part")[seed % 3]
    body = DexelStock.box(LOW, HIGH, CELL)
    far = DexelStock.box(LOW + 1.0, LOW + 1.0 + 10 * CELL, CELL)
    stock = body if role == "stock" else far
    around = Surroundings(
        body if role == "finished part" else None, 0.0, {"clamp": body} if role == "fixture clamp" else {}
    )
    tool = ToolInUse(figures, ToolProfile.of(figures))
    found = cut_stations(
        [stations], [Operation()], [tool], StockRange(stock, stock, stock), around, resolution=CELL
    )
    told = {each.kind: each for each in found.findings}
    assert all(each.body == role and each.line == 7 for each in found.findings)
    kinds = {"gouge": depths["cutting"]} if role == "finished part" else {
        KIND[name]: depth for name, depth in depths.items()
    }  # fmt: skip
    # rapids have no findings of cuts above the flutes: the edge meets nothing beside
    told |= {"shank": told["flute"]} if "flute" in told and "shank" not in told else {}
    assert set(told) - {"flute"} <= set(kinds)
    for kind, depth in kinds.items():
        if depth > UNSEEN * CELL:
            assert kind in told, f"seed {seed}: {kind}, {depth / CELL:.2f} cells deep, is not told"
        if kind in told:
            assert depth > 0.0, f"seed {seed}: {kind} is told, and {-depth / CELL:.2f} cells away"
            assert told[kind].depth - depth < TOLD * CELL
            assert depth - told[kind].depth < UNSEEN * CELL
    return len(told)


@pytest.mark.parametrize("first", range(0, 30, 15))
def test_collisions_of_random_scenes(first):
    assert sum(check(seed) for seed in range(first, first + 15)) > 5


@pytest.mark.parametrize(
    "first",
    [
        pytest.param(first, marks=pytest.mark.sweep if first < 120 else pytest.mark.thorough)
        for first in range(30, 300, 45)
    ],
)
def test_collisions_of_many_random_scenes(first):
    assert sum(check(seed) for seed in range(first, first + 45)) > 10

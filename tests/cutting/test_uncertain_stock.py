"""What is told of a stock that is known within an uncertainty only, against a true stock anywhere between.

The true stock is a cloud of points, taken away where the tool is: it shares no code with the dexels.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.point_stock import PointStock
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import Surroundings, ToolInUse, cut_stations
from toolpace.cutting.simulation.stock_range import StockRange
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.tool_figures import ToolFigures, ToolKind
from toolpace.programs.toolpath import Operation

MM = 1e-3
CELL = 0.5 * MM
SIZE = np.array([16.0, 12.0, 6.0]) * MM
KINDS: tuple[ToolKind, ...] = ("flat", "ball", "bull")
FEW = 20
"""Points of the true stock that a run of stations must at least cut to tell a cut of a point that is missed."""


def random_tool(rng: np.random.Generator) -> ToolFigures:
    kind, diameter = KINDS[rng.integers(3)], rng.uniform(3.0, 8.0) * MM
    corner = {"flat": 0.0, "ball": 0.5 * diameter, "bull": 0.2 * diameter}[kind]
    return ToolFigures(kind, diameter, corner, flute_length=15 * MM, stick_out=15 * MM)


def random_program(rng: np.random.Generator) -> Stations:
    """Straight ways over and through the stock, with a tool axis that turns from one to the next."""
    count = 6
    corners = rng.uniform([-4, -4, 2], [20, 16, 8], (count, 3)) * MM
    corners[::3, 2] = rng.uniform(6.5, 9.0, len(corners[::3])) * MM
    lean = np.column_stack([rng.uniform(-0.4, 0.4, (count, 2)), np.ones(count)]) * [1.0, 1.0, 1.0]
    lean[:, :2] *= rng.random() < 0.5
    tips, axes = [corners[:1]], [lean[:1]]
    for k in range(1, count):
        steps = int(np.ceil(np.linalg.norm(corners[k] - corners[k - 1]) / CELL))
        share = np.arange(1, steps + 1)[:, None] / steps
        tips.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        axes.append(lean[k - 1] + share * (lean[k] - lean[k - 1]))
    tip, axis = np.concatenate(tips), np.concatenate(axes)
    n = len(tip)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    return Stations(
        tip, axis, np.arange(n) * 0.01, np.arange(n), np.zeros(n, dtype=int), np.zeros(n, dtype=bool), np.arange(n)
    )


def true_stock(rng: np.random.Generator, off: float) -> PointStock:
    """A box whose faces are anywhere within `off` of where they should be, wavy."""
    cloud = PointStock.box(-np.full(3, off), SIZE + off, 0.5 * CELL)
    outside = np.maximum(-cloud.points, cloud.points - SIZE).max(axis=1)
    wave = np.sin(cloud.points @ rng.uniform(-600.0, 600.0, (3, 3)) + rng.uniform(0.0, 6.0, 3)).mean(axis=1)
    level = rng.uniform(-1.0, 1.0)
    return PointStock(cloud.points[outside <= off * np.clip(level + wave, -1.0, 1.0)], 0.5 * CELL)


def simulated(seed: int) -> tuple[CutStretch, np.ndarray]:
    """What is told of a random program, and how many points of the true stock are cut on the way to each station."""
    rng = np.random.default_rng(seed)
    figures, stations, off = random_tool(rng), random_program(rng), rng.uniform(0.1, 1.5) * MM
    nominal = DexelStock.box(np.zeros(3), SIZE, CELL)
    stock = StockRange(nominal.shrunk(off), nominal, nominal.grown(off), off)
    before = stock.nominal.volume()
    profile = ToolProfile.of(figures)
    found = cut_stations(
        [stations], [Operation()], [ToolInUse(figures, profile)], stock, Surroundings(), resolution=CELL
    )
    assert found.removed_volume + found.left_volume == pytest.approx(before, rel=1e-3)
    true = true_stock(rng, off)
    # between two stations too, so that the true cut is that of the motion
    points = true.cut(profile, halved(stations)).removed / true.cell**3
    return found.stretches[0], np.concatenate([points[:1], points[1:].reshape(-1, 2).sum(axis=1)])


def halved(stations: Stations) -> Stations:
    """The same motion with a station between each two."""
    n = len(stations)
    at = np.arange(2 * n - 1) / 2.0
    tip, axis = (
        np.column_stack([np.interp(at, np.arange(n), column) for column in each.T])
        for each in (stations.tip, stations.axis)
    )
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    whole = np.ceil(at).astype(int)
    return Stations(tip, axis, at * 0.01, whole, np.zeros(len(at), dtype=int), np.zeros(len(at), dtype=bool), whole)


def check(seed: int) -> None:
    stretch, points = simulated(seed)
    air, cutting = stretch.air, stretch.cutting
    assert not (air & cutting).any()
    # a point between the rays is a contact below the stated size
    assert points[air].sum() <= 2, f"seed {seed}: {points[air].sum():.0f} points are cut in air"
    wanted = stretch.certain.removed / (0.5 * CELL) ** 3
    run = np.cumsum(np.diff(cutting, prepend=False))
    for each in np.unique(run[cutting]):
        here = (run == each) & cutting
        if wanted[here].sum() >= FEW:
            assert points[here].sum() > 0, f"seed {seed}: nothing is cut at stations {np.flatnonzero(here)}"


@pytest.mark.parametrize("seed", range(3))
def test_air_is_never_cut_and_a_cut_is_never_air(seed):
    check(seed)


@pytest.mark.parametrize(
    "seed",
    [pytest.param(seed, marks=pytest.mark.sweep if seed < 14 else pytest.mark.thorough) for seed in range(3, 200)],
)
def test_air_is_never_cut_and_a_cut_is_never_air_on_many_programs(seed):
    check(seed)

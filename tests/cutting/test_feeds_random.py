"""Feeds of random programs in a stock that ends elsewhere than told, by a simulation that shares no code.

Nowhere may the tool be loaded more than the program itself loads it at most, whatever the material.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import toolpace as tp
from tests.support.feed_programs import SHEET
from tests.support.height_field import HeightField, chips_of_ways, forces_of
from tests.support.program_with_feeds import with_feeds
from toolpace.cutting.feeds.feed_plan import plan_feeds
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import WAYS, FeedRules
from toolpace.cutting.feeds.schedule import Steps
from toolpace.programs.reading.setup_file import setup_of_text

LOW, HIGH = np.array([0.0, -20.0, -20.0]), np.array([60.0, 20.0, 0.0])
"""The stock of the sheet [mm]."""
RADIUS, TEETH, TURNS = 5.0, 3, 100.0
GRID = 0.03
"""Share by which a force may be above by the grid: its angles and cells."""
FINE = 0.5
"""Size of a cell of the stock [mm]: bodies that are narrower may stand between its rays."""
USUAL = 0.0201
"""Feed up to which a way is one of the cut [m/s]: links are faster."""
AS_WIDE_AS_A_CELL = (252, "sliver")
"""A program with a fin that hardly any ray meets: 1.21 of the largest force, 1.00 with cells of 0.4 mm."""
SCENES = ("anywhere", "larger", "smaller", "sliver", "in air")
SHARES = (0.0, 0.02, 0.2, 100.0)
"""Edge coefficients over cutting coefficients [mm]: from none to nothing else."""


def random_program(rng, scene):
    """Level ways in, through and beside the stock at their depths, with links at a high feed."""
    lines = ["G21 G90 G54 G17", "T1 M6", "G43 H1", "S6000 M3", "G0 X-12 Y0 Z20"]
    depth = 0.0
    for _ in range(int(rng.integers(2, 5))):
        depth -= float(rng.uniform(1.0, 4.0))
        begin = rng.uniform([-10.0, -28.0], [-7.0, 28.0])
        lines += [f"G0 X{begin[0]:.3f} Y{begin[1]:.3f}", f"G0 Z{depth:.3f}"]
        for _ in range(int(rng.integers(1, 4))):
            to = rng.uniform([-8.0, -28.0], [68.0, 28.0])
            lines.append(f"G1 X{to[0]:.3f} Y{to[1]:.3f} F{rng.integers(3, 12) * 100}")
        if scene == "sliver":
            # along a face, a little within it, or where a smaller stock has nothing
            y = 20.0 + RADIUS - float(rng.uniform(-0.2, 0.4))
            lines += ["G0 Z20", f"G0 X-9 Y{y:.3f}", f"G0 Z{depth:.3f}", f"G1 X69 F{rng.integers(40, 100) * 100}"]
        if scene == "in air":
            # deep in a corner that the smaller stock does not have
            lines += ["G0 Z20", "G0 X-9 Y-24.5", f"G0 Z{depth - 6.0:.3f}", f"G1 X-4.6 Y-24.2 F{rng.integers(20, 40)}00"]
        lines.append("G0 Z20")
    return "\n".join([*lines, "M30", ""])


def true_stock(rng, scene, off):
    """Lowest and highest corner of a box whose faces are within `off` of where they are told [mm]."""
    faces = {
        "larger": np.full((2, 3), off), "smaller": np.full((2, 3), -off), "in air": np.full((2, 3), -off)
    }.get(scene, rng.uniform(-off, off, (2, 3)))  # fmt: skip
    return LOW - faces[0], HIGH + faces[1]


@lru_cache(maxsize=2)
def fed(text, off, way, cell):
    """A program, the same with the feeds that its cut allows, and the share of its time at feed that is saved."""
    sheet = SHEET.replace("uncertainty = 0.5", f"uncertainty = {off}")
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(sheet)
    toolpath = tp.read_text(text, machine, setup=setup)
    plan = tp.plan_program(toolpath, machine, effort="low")
    simulation = tp.simulate_cut(plan.trajectory, toolpath, setup, resolution=1e-3 * cell)
    rules = FeedRules(way, air_feed=0.2, finishing=True, steps=Steps(ratio=1.05))
    feeds = plan_feeds(simulation, toolpath, [setup.figures_of(each.tool) for each in toolpath.operations], rules)
    before, after = (sum(getattr(each, name) for each in feeds.operations) for name in ("before", "after"))
    return toolpath, with_feeds(toolpath, machine, list(feeds.places), list(feeds.feeds)), 1.0 - after / before


def check(seed, scene, way, shares=SHARES, cell=FINE):
    """The time saved, after the loads were compared."""
    rng = np.random.default_rng(seed)
    off = float(rng.uniform(0.2, 1.0))
    toolpath, new, saved = fed(random_program(rng, scene), off, way, cell)
    # the loads of both are found at the same places: a narrow fin is met or missed by where a way begins
    by_line = np.zeros(int(toolpath.block.max()) + 1)
    by_line[toolpath.block] = toolpath.most_speed
    # what a fast link does is no measure of what the tool bears
    usual = (~new.rapid & (by_line[new.block] <= USUAL))[1:]
    box = true_stock(rng, scene, off)
    feeds = [np.where(usual, 1e3 * speed[1:], 0.0) for speed in (by_line[new.block], new.most_speed)]
    for finer in (1, 2):
        # what is above by the grid is looked at twice as fine: the program's own worst may be a moment
        chips = chips_of_ways(HeightField(*box, 20.0, finer), new.tip * 1e3, RADIUS, TEETH, cell)
        own, now = (
            np.array([forces_of(chips, each, TEETH, TURNS, share)[usual].max() for share in shares]) for each in feeds
        )
        if (now <= own * (1.0 + GRID)).all():
            break
    else:
        worst = int((now / own).argmax())
        pytest.fail(f"seed {seed}: {now[worst] / own[worst]:.3f} of the largest force at Ke / Kc = {shares[worst]} mm")
    return saved


@pytest.mark.parametrize("seed, scene", [(2, "smaller"), (3, "in air"), (0, "larger"), (3, "sliver")])
def test_no_place_is_loaded_more_than_the_program_loads_the_tool(seed, scene):
    assert check(seed, scene, "learned", SHARES[1:2], 1.0) > 0.01


@pytest.mark.thorough
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("seed", range(100, 300))
def test_no_place_is_loaded_more_in_many_programs(request, seed, scene):
    if (seed, scene) == AS_WIDE_AS_A_CELL:
        request.applymarker(pytest.mark.xfail(strict=True, reason="a fin of 0.50 to 0.55 mm stands between the rays"))
    check(seed, scene, "learned")


def check_guessed(seed, scene):
    """No way changes a feed where the sheet has no stock."""
    machine = tp.Machine.load("xyzac-trunnion")
    setup = setup_of_text(SHEET[SHEET.index("[tools") :])
    toolpath = tp.read_text(random_program(np.random.default_rng(seed), scene), machine, setup=setup)
    simulation = tp.simulate_cut(
        tp.plan_program(toolpath, machine, effort="low").trajectory, toolpath, setup, resolution=2e-3
    )
    tools = [setup.figures_of(each.tool) for each in toolpath.operations]
    own = [toolpath.most_speed[each.stations.point[1:]] for each in simulation.stretches if not each.rapid]
    for way in WAYS:
        plan = plan_feeds(simulation, toolpath, tools, FeedRules(way, limits={"": CutLimits(chip=1e-5)}, air_feed=0.2))
        assert all((feeds[1:] == speed).all() for speed, feeds in zip(own, plan.feeds, strict=True)), way


def test_on_a_guessed_stock_no_feed_changes():
    check_guessed(7, "sliver")


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(100, 300))
def test_on_a_guessed_stock_no_feed_changes_in_many_programs(seed):
    check_guessed(seed, SCENES[seed % len(SCENES)])


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(100, 300))
def test_air_loads_nothing_more_in_many_programs(seed):
    check(seed, SCENES[seed % len(SCENES)], "air")

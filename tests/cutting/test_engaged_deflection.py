"""Deflection along a program by what is cut of a stock: at a wall against a tool turned through time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.bending import TOOL_OF_STOCK
from tests.support.engagements import shoulder
from tests.support.set_up_sheets import milling_sheet
from tests.support.turned_tool import turned_tool
from toolpace.cutting.forces.engaged import EngagedForces
from toolpace.cutting.forces.engaged_deflection import with_engaged_deflection
from toolpace.cutting.forces.tool_beam import ToolBeam
from toolpace.cutting.tool_file import tool_of_bytes
from toolpace.errors import UsageError
from toolpace.programs.reading.setup_file import setup_of_text

MACHINE = tp.Machine.load("xyzac-trunnion")
SHEET = milling_sheet([(0, -20, -10), (20, 0, 0)], 4, 12, 40, teeth=2, helix=30)
WIDE = 0.6e-3
"""Of the cut [m]."""


def simulated(begin, end):
    text = f"G21 G90 G94\nT1 M6\nS18000 M3\nG0 {begin} Z20\nG0 Z-3\nG1 {end} F1500\nG0 Z20\nM30\n"
    toolpath = tp.read_text(text, MACHINE)
    motion = tp.plan(tp.Path.fit(toolpath, machine=MACHINE), MACHINE, bound=False)
    setup = setup_of_text(SHEET)
    return toolpath, tp.simulate_cut(motion, toolpath, setup, resolution=0.2e-3), setup


def engaged(begin="X-6 Y1.4", end="X26", tool=TOOL_OF_STOCK):
    toolpath, cut, setup = simulated(begin, end)
    figures = [setup.figures_of(each.tool) for each in toolpath.operations]
    return with_engaged_deflection(tool_of_bytes(tool.encode(), "tool.toml"), cut, toolpath, figures), toolpath, cut


@pytest.mark.parametrize("down", [True, False])
def test_at_a_wall_it_is_that_of_the_turned_tool_when_the_edge_passes_the_wall(down):
    tool, _, cut = engaged() if down else engaged("X26 Y1.4", "X-6")
    figures, law = cut.operations[0].figures, tool.engaged
    middle = np.searchsorted(law.way, law.way[-1] - 16e-3)
    immersion = np.arccos(1.0 - WIDE / 2e-3)
    # looking along the feed the wall is on the right where it cuts down, and on the left where it cuts up
    wall = np.pi if down else 0.0
    table = shoulder(3e-3, *((np.pi - immersion, np.pi) if down else (0.0, immersion)), slices=12)
    heights, steps = np.linspace(0.05e-3, 2.95e-3, 30), 1440
    for speed in (25e-3, 10e-3):
        bent = turned_tool(
            figures, tool.cut.coefficients, table, 0, speed, 300.0, steps=steps,
            bend=lambda z: ToolBeam.of(figures).compliance(heights, z),
        )[2]  # fmt: skip
        slope = 2.0 * np.tan(figures.helix) / figures.diameter
        at = np.rint((wall + slope * heights) / (2.0 * np.pi) * steps).astype(int) % steps
        across = bent[at, np.arange(len(heights)), 1]
        found = law.slope[middle] * speed + law.constant[middle]
        assert found[1] == pytest.approx(0.5 * (across.min() + across.max()), abs=0.04 * np.abs(across).max())
        assert found[0] == 0.0 and abs(found[2]) < 1e-12
        # climbing, it is pushed off the wall
        assert found[1] > 0.0 or not down


def test_nothing_bends_in_air_and_in_a_slot_it_is_the_mean_of_the_tip():
    tool, _, _ = engaged()
    law = tool.engaged
    bends = np.abs(law.constant).max(axis=1) > 0.0
    # 20 mm of stock, and up to 1.4 mm before it, where the edge comes in beside the middle; 12 mm are in air
    assert 20e-3 < np.ptp(law.way[bends]) < 22e-3
    assert not bends[0] and not bends[-1]
    tool, _, cut = engaged("X-6 Y-10")
    law = tool.engaged
    middle = np.argmin(np.abs(law.way - (law.way[-1] - 16e-3)))
    stretch = max((each for each in cut.stretches if not each.rapid), key=lambda each: each.removed)
    forces = EngagedForces(stretch.engagement, replace(cut.operations[0].figures), tool.cut.coefficients, 300.0)
    mean = forces.loads(25e-3).mean_deflection[len(stretch.stations) // 2]
    found = law.slope[middle] * 25e-3 + law.constant[middle]
    np.testing.assert_allclose(found[:2], mean, rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('diameter = "4mm"', 'diameter = "5mm"'), "its tool has 5 mm and 2 teeth"),
        (("teeth = 2", "teeth = 3"), "3 teeth"),
        (('youngs_modulus = "580GPa"', 'stiffness = ["1N/um", "1N/um", "9N/um"]'), "write its youngs_modulus"),
        (('milling = "stock"', 'milling = "stock"\naxial_depth = "3mm"'), "the stock tells it"),
        (('teeth = 2', 'teeth = 2\nonly = ["9"]'), "nothing bends"),
    ],
)  # fmt: skip
def test_what_contradicts_the_sheet_is_refused(change, words):
    with pytest.raises(UsageError, match=words):
        engaged(tool=TOOL_OF_STOCK.replace(*change))


def test_without_its_deflection_such_a_tool_compensates_nothing():
    toolpath, _, _ = simulated("X-6 Y1.4", "X26")
    with pytest.raises(UsageError, match="name a stock and this tool on the set-up sheet"):
        tp.compensate_bending(toolpath, MACHINE, tool_of_bytes(TOOL_OF_STOCK.encode(), "tool.toml"))

"""A slender tool on a wall, whose deflection may leave 20 micrometres: limited, compensated, and both.

    python -m testbed.deflection_on_a_wall

Three motions of one program: as fast as 20 micrometres of deflection on the surface allow; by the program's feed, the
path compensated for the mean deflection over the height; and compensated, as fast as 20 micrometres of what is left
allow. What each leaves on the wall is found by the judge's sections and a tool turned through in time.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

import toolpace as tp
from toolpace.cutting.feeds.limited_plan import plan_within_cut
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.cutting.forces.engaged_deflection import with_engaged_deflection
from toolpace.cutting.simulation import simulate_cut
from toolpace.cutting.tool_file import tool_of_bytes
from toolpace.judge.cut.instants import CutJudge, CutPromise
from toolpace.judge.cut.stocks import box_stock
from toolpace.machine.cutting_tool import Coefficients
from toolpace.programs.reading.setup_file import setup_of_text

ALLOWED = 20e-6
"""Deflection on the surface [m]."""
CENTRE = 3e-3
"""Of the tool, beside the wall [m]."""
CELL = 0.1e-3
COEFFICIENTS = Coefficients(800e6, 250e6, 100e6, 8e3, 6e3)
"""Of an aluminium alloy with a sharp edge, the same as in the tool file below."""
SHEET = """
[stock]
box = [[0, -20, -20], [40, 0.3, 0]]
uncertainty = 0
[tools.1]
kind = "flat"
diameter = 6
flute_length = 15
teeth = 3
helix = 30
stick_out = 40
material = "carbide"
spindle_speed = 8000
"""
PROGRAM = """G21 G90 G54 G17
T1 M6
S8000 M3
G0 X-8 Y3 Z5
G1 Z-8 F3000
G1 X48 F1200
G0 Z20
M30
"""
TOOL = """
[tool]
diameter = "6mm"
teeth = 3
helix = "30deg"
stick_out = "40mm"
[bending]
youngs_modulus = "580GPa"
blend = "3mm"
[cutting]
spindle_speed = "8000rpm"
Ktc = "800MPa"
Krc = "250MPa"
Kac = "100MPa"
Kte = "8N/mm"
Kre = "6N/mm"
[engagement]
milling = "stock"
"""


class OnTheWall(NamedTuple):
    """What a motion leaves in the middle of the wall."""

    name: str
    seconds: float
    """Of the cut [s]."""
    feed: float
    """[m/s]"""
    least: float
    most: float
    """Material left over the height, below zero where the tool cut too deep [m]."""


def motions() -> list[OnTheWall]:
    """The three, and the program's own."""
    machine, setup = tp.Machine.load("xyzac-trunnion"), setup_of_text(SHEET)
    toolpath = tp.read_text(PROGRAM, machine, controller="linuxcnc", setup=setup)

    def limited(**limits: float) -> tuple[tp.ToolPath, tp.Trajectory]:
        rules = FeedRules(
            "limits", air_feed=0.1, finishing=True, limits={"": CutLimits(**limits)}, materials={"": COEFFICIENTS}
        )
        plan = plan_within_cut(toolpath, machine, setup, rules, effort="low", resolution=CELL)
        return plan.toolpath, plan.plan.trajectory

    def compensated(path: tp.ToolPath) -> tp.Trajectory:
        stiff = tp.plan_program(path, machine, effort="low").trajectory
        cut = simulate_cut(stiff, path, setup, resolution=CELL)
        tools = [setup.figures_of(each.tool) for each in path.operations]
        tool = with_engaged_deflection(tool_of_bytes(TOOL.encode(), "wall"), cut, path, tools)
        return tp.compensate_bending(path, machine, tool).trajectory

    only_limited = limited(surface_deflection=ALLOWED)[1]
    left_over = limited(compensated_deflection=ALLOWED)[0]
    program = tp.plan_program(toolpath, machine, effort="low").trajectory
    named = (
        ("program", program), ("limited", only_limited), ("compensated", compensated(toolpath)),
        ("both", compensated(left_over)),
    )  # fmt: skip
    promise = CutPromise(
        "limits", box_stock(np.array([0.0, -20e-3, -20e-3]), np.array([40e-3, 0.3e-3, 0.0]), 0.0),
        [setup.figures_of("1")], {}, {"": COEFFICIENTS}, {}, CELL,
    )  # fmt: skip
    return [on_the_wall(name, trajectory, toolpath, promise) for name, trajectory in named]


def on_the_wall(name: str, trajectory: tp.Trajectory, toolpath: tp.ToolPath, promise: CutPromise) -> OnTheWall:
    """What a motion leaves between the first and the last quarter of the wall."""
    points = trajectory.sample(0.5e-3)
    along = np.flatnonzero((points.block == 6) & (points.tip[:, 0] > 10e-3) & (points.tip[:, 0] < 30e-3))
    # the bent tool is where the program says: its engagement is that of the path without compensation
    shift = CENTRE - points.tip[:, 1]
    tip = points.tip.copy()
    tip[:, 1] = CENTRE
    judge = CutJudge(replace(points, tip=tip), toolpath, promise)
    found = [(row, judge.instant(int(row))) for row in along[:: max(len(along) // 6, 1)]]
    left = [(each.loads["surface_mean"] - shift[row], each.loads["compensated_deflection"]) for row, each in found]
    least, most = min(mean - half for mean, half in left), max(mean + half for mean, half in left)
    cut = points.t[(points.block == 6) & (points.tip[:, 0] > 0.0) & (points.tip[:, 0] < 40e-3)]
    speed = float(np.median([each.speed for _, each in found]))
    return OnTheWall(name, float(cut[-1] - cut[0]), speed, least, most)


if __name__ == "__main__":
    for each in motions():
        print(
            f"{each.name:12} {each.seconds:7.3f} s  {60e3 * each.feed:7.0f} mm/min  "
            f"{1e6 * each.least:7.2f} to {1e6 * each.most:6.2f} um"
        )

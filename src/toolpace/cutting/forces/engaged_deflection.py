"""How far a tool gives way where it makes the surface, along a program, from what it cuts of a stock.

of each station of the simulated cut                forces by its arcs, at its speed and at half of it
the surface is made on the left, or on the right    deflection along its normal, mean of the least and the most
on both sides, or on none                           mean deflection of the tip
over the speed                                      a straight line through both
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.common.errors import UsageError
from toolpace.cutting.engagement.table import EngagementTable
from toolpace.cutting.forces.engaged import CutLoads, EngagedForces, turning_of
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.machine.cutting_tool import CuttingTool, EngagedDeflection
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

SIDE = math.radians(10.0)
"""How near to the left or the right of the feed an arc must end for the surface to be made there [rad]."""


def with_engaged_deflection(
    tool: CuttingTool, simulation: CutSimulation, toolpath: ToolPath, tools: Sequence[ToolFigures | None]
) -> CuttingTool:
    """A tool of `milling = "stock"` with its deflection along the program of a simulated cut.

    tools: figures of each operation's tool. Raises UsageError for a guessed stock, where a tool is another than the
    tool file's or lacks a figure, and where nothing is cut with it.
    """
    if simulation.guessed:
        raise UsageError(f'{tool.source}: milling = "stock" needs a stock on the set-up sheet, and it is guessed')
    way = np.cumsum(toolpath.way_length)
    places, slopes, constants = [np.zeros(0)], [np.zeros((0, 3))], [np.zeros((0, 3))]
    for stretch in simulation.stretches:
        called = toolpath.operations[stretch.operation].tool
        figures = tools[stretch.operation]
        if stretch.rapid or len(stretch.stations) < 2 or figures is None or (tool.only and called not in tool.only):
            continue
        slope, constant = _over_speed(stretch, tool, _checked(figures, tool))
        point, tip = stretch.stations.point[1:], stretch.stations.tip[1:]
        left = np.linalg.norm(toolpath.tip[point] - tip, axis=1)
        places.append(np.maximum(way[point] - left, way[np.maximum(point - 1, 0)]))
        slopes.append(slope[1:])
        constants.append(constant[1:])
    at = np.concatenate(places)
    if not len(at):
        raise UsageError(f"{tool.source}: nothing of the program is at feed with this tool, so nothing bends")
    order = np.argsort(at, kind="stable")
    engaged = EngagedDeflection(at[order], np.concatenate(slopes)[order], np.concatenate(constants)[order])
    return replace(tool, engaged=engaged)


def _checked(figures: ToolFigures, tool: CuttingTool) -> ToolFigures:
    """The figures of the sheet, with what only the tool file tells. Raises UsageError where they differ."""
    cutter = tool.cut.cutter
    if abs(figures.diameter - cutter.diameter) > 1e-6 or (figures.teeth or cutter.teeth) != cutter.teeth:
        raise UsageError(
            f"{tool.source}: its tool has {cutter.diameter * 1e3:g} mm and {cutter.teeth} teeth, that of "
            f"{figures.source or 'the set-up sheet'} {figures.diameter * 1e3:g} mm and {figures.teeth} teeth; correct "
            "one, or name the tools of the program that this is (only)"
        )
    if figures.stick_out is None:
        raise UsageError(f"{figures.source or 'the set-up sheet'}: stick_out is missing: bending needs it")
    return replace(
        figures,
        teeth=cutter.teeth,
        helix=figures.helix or cutter.helix,
        runout=figures.runout or cutter.runout,
        clockwise=tool.cut.clockwise,
    )


def _over_speed(stretch: CutStretch, tool: CuttingTool, figures: ToolFigures) -> tuple[Floats, Floats]:
    """Slope [s] and constant [m] (n, 3) of the deflection at n stations over the speed of the tip."""
    cut, stations, table = tool.cut, stretch.stations, stretch.engagement
    forces = EngagedForces(
        table, figures, cut.coefficients, cut.spindle_speed,
        runout_angle=cut.cutter.runout_angle, youngs_modulus=tool.youngs_modulus,
    )  # fmt: skip
    duration = np.diff(stations.time, prepend=stations.time[:1])
    step = np.linalg.norm(np.diff(stations.tip, axis=0, prepend=stations.tip[:1]), axis=1)
    speed = np.divide(step, duration, where=duration > 0.0, out=np.zeros(len(step)))
    turning = turning_of(stations.axis, stations.time, table)
    whole, half = forces.loads(speed, turning), forces.loads(0.5 * speed, 0.5 * turning)
    side = _side_of_surface(table)
    on_surface = (side != 0.0) & np.isfinite(whole.surface[:, 0]) & np.isfinite(half.surface[:, 0])
    profile = ToolProfile.of(figures)
    at_whole, at_half = (_deflection(each, side, on_surface, profile) for each in (whole, half))
    slope = np.divide(at_whole - at_half, 0.5 * speed[:, None], where=speed[:, None] > 0.0, out=np.zeros_like(at_half))
    return slope, np.where(speed[:, None] > 0.0, 2.0 * at_half - at_whole, 0.0)


def _deflection(loads: CutLoads, side: Floats, on_surface: Bools, profile: ToolProfile) -> Floats:
    """(n, 3) along feed, normal and axis [m]."""
    found = np.zeros((len(side), 3))
    found[:, :2] = loads.mean_deflection
    # what is left is against the outward normal of the tool's surface
    bent = -loads.surface[on_surface].mean(axis=1)
    across, along = profile.surface(loads.surface_height[on_surface].mean(axis=1))[1:]
    found[on_surface] = np.stack([0.0 * bent, bent * side[on_surface] * across, bent * along], axis=1)
    return found


def _side_of_surface(table: EngagementTable) -> Floats:
    """(n,) 1 where the surface is made on the left of the feed, -1 on the right, 0 on both or none."""
    count = len(table.along)
    station = np.repeat(np.arange(count), np.diff(table.first_arc))

    def near(angle: Floats, place: float) -> Bools:
        off = np.abs((angle - place + math.pi) % (2.0 * math.pi) - math.pi)
        return np.asarray(np.bincount(station, off < SIDE, count) > 0.0)

    side: Floats = near(table.entry, 0.0).astype(float) - near(table.exit, math.pi).astype(float)
    return side

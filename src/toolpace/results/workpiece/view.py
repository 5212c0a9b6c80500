"""What pages and pictures show of a workpiece: stock by stages, finished part, fixtures, tools, tracks of the cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.results.workpiece.stock_stages import POINTS, Cut, StockStages, stages_of
from toolpace.results.workpiece.tracks import CutTracks, cut_tracks

if TYPE_CHECKING:
    from toolpace.cutting.simulation.simulate import CutSimulation, ToolInUse
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.stock_figures import Solid
    from toolpace.programs.toolpath import ToolPath

CELLS = 160
"""Along the longest side of a stock that is cut for a report only."""
TRIANGLES = 8000
"""Of a mesh that is shown as it is; of more, its surface on a lattice."""

ARC_POINTS = 9
"""Of an arc in the outline of a tool."""


@dataclass(frozen=True)
class WorkpieceView:
    """What there is to be seen; what is not known is None. Meshes are triangles (n, 3, 3) [m], frame of the part."""

    tools: tuple[ToolProfile | None, ...] = ()
    """Of each operation."""
    stages: StockStages | None = None
    finished_part: Floats | None = None
    fixtures: tuple[tuple[str, Floats], ...] = ()
    """By name."""
    tracks: CutTracks | None = None
    guessed: bool = False
    """Whether the stock is a guess."""
    resolution: float = 0.0
    """Cells of the simulation that the tracks are of [m]."""
    note: str = ""
    """Why the stock is not shown, where the sheet names one."""


def view_of_plan(
    trajectory: Trajectory, toolpath: ToolPath | None, setup: SetUp, simulation: CutSimulation | None = None
) -> WorkpieceView | None:
    """What the sheet of a plan tells to be seen; None where it tells nothing.

    Where the cut was not simulated, it is, coarsely: of a stock that the program tells. A sheet whose stock or tools
    cannot be cut is no reason for a plan to fail: `note` says why.
    """
    machine = trajectory.axis_path.machine
    if machine is None or toolpath is None or not hasattr(trajectory, "laws"):
        return None
    workpiece = setup.workpiece
    stock = workpiece.stock or toolpath.workpiece.stock
    if stock is None and workpiece.finished_part is None and not workpiece.fixtures:
        return None
    try:
        if stock is None:
            return WorkpieceView((), None, *_around(setup, machine))
        if simulation is None:
            simulation = coarse_cut(trajectory, toolpath, setup, machine)
        return view_of_cut(simulation, trajectory, toolpath, setup)
    except UsageError as error:
        return WorkpieceView(note=str(error))


def view_of_stock(trajectory: Trajectory, toolpath: ToolPath, setup: SetUp) -> WorkpieceView:
    """The stock by stages and what is around it, without what the tool meets: faster. `note` as in `view_of_plan`."""
    from toolpace.cutting.engagement.stations import motion_stations
    from toolpace.cutting.simulation import set_up
    from toolpace.cutting.simulation.simulate import reach_of

    machine = trajectory.axis_path.machine
    assert machine is not None
    around = _around(setup, machine)
    try:
        tools, _ = set_up.tools_in_use(toolpath, setup)
        profiles = tuple(None if tool is None else tool.profile for tool in tools)
        if (setup.workpiece.stock or toolpath.workpiece.stock) is None:
            return WorkpieceView(profiles, None, *around)
        stock = set_up.stock_body(toolpath, setup, machine, tools)[1].triangles()
    except UsageError as error:
        return WorkpieceView((), None, *around, note=str(error))
    cell = float(np.ptp(stock, axis=(0, 1)).max()) / POINTS
    reach = [0.0 if tool is None else reach_of(tool.figures) for tool in tools]
    parts = motion_stations(trajectory, toolpath, cell, reach)
    cuts = [(each, tool) for each in parts if (tool := tools[int(each.operation[-1])]) is not None and len(each) > 1]
    return WorkpieceView(profiles, stages_of(stock, cuts, trajectory.duration), *around)


def coarse_cut(trajectory: Trajectory, toolpath: ToolPath, setup: SetUp, machine: Machine) -> CutSimulation:
    """What a motion cuts of the stock as its figures are, in CELLS. Raises UsageError."""
    from toolpace.cutting.simulation import set_up, simulate_cut
    from toolpace.cutting.simulation.stock_range import StockRange

    tools, _ = set_up.tools_in_use(toolpath, setup)
    figures, body = set_up.stock_body(toolpath, setup, machine, tools)
    low, high = body.bounds
    stock = set_up.dexels(body, float((high - low).max()) / CELLS, 1e9)
    return simulate_cut(trajectory, toolpath, setup, stock=StockRange(stock, stock, stock, guessed=figures.guessed))


def view_of_cut(
    simulation: CutSimulation,
    trajectory: Trajectory,
    toolpath: ToolPath,
    setup: SetUp,
    stock: Floats | None = None,
    before: Sequence[Cut] = (),
    tracks: CutTracks | None = None,
) -> WorkpieceView:
    """What is to be seen of a cut. Raises UsageError.

    stock: triangles (n, 3, 3) [m] that other programs have cut, and `before` is along what; None: it is the sheet's.
    tracks: what is shown over time; None: what the tool does and takes.
    """
    from toolpace.cutting.simulation import set_up

    machine = trajectory.axis_path.machine
    assert machine is not None
    tools, _ = set_up.tools_in_use(toolpath, setup)
    if stock is None:
        stock = set_up.stock_body(toolpath, setup, machine, tools)[1].triangles()
    return WorkpieceView(
        tuple(None if tool is None else tool.profile for tool in tools),
        stages_of(stock, cuts_of(simulation, tools), trajectory.duration, before),
        *_around(setup, machine),
        cut_tracks(simulation, toolpath, trajectory.duration) if tracks is None else tracks,
        simulation.guessed,
        simulation.resolution,
    )


def cuts_of(simulation: CutSimulation, tools: Sequence[ToolInUse | None]) -> list[Cut]:
    """The stretches of a simulation, each with its tool."""
    found = ((each.stations, tools[each.operation]) for each in simulation.stretches if len(each.stations) > 1)
    return [(stations, tool) for stations, tool in found if tool is not None]


def outline(solid: Floats) -> Floats:
    """(n, 2) heights above the tip and radii [m] of a solid of a ToolProfile, from below."""
    points: list[tuple[float, float]] = []
    for z0, z1, a, b, arc, _ in solid.tolist():
        heights = np.array([z0, z1])
        radii = a + b * heights
        if arc > 0.0:
            # even in angle: an arc may begin across the axis
            begin, end = np.arcsin(np.clip((heights - b) / arc, -1.0, 1.0)).tolist()
            angles = np.linspace(begin, end, ARC_POINTS)
            heights, radii = b + arc * np.sin(angles), a + arc * np.cos(angles)
        points += zip(heights.tolist(), np.maximum(radii, 0.0).tolist())
    return np.array(points)


def _around(setup: SetUp, machine: Machine) -> tuple[Floats | None, tuple[tuple[str, Floats], ...]]:
    """The finished part and the fixtures of a sheet."""
    from toolpace.cutting.stock.dexels import DexelStock
    from toolpace.cutting.stock.solids import body_of

    def mesh(solid: Solid) -> Floats:
        triangles = body_of(solid, machine, setup).triangles()
        if len(triangles) <= TRIANGLES:
            return triangles
        return DexelStock.mesh(triangles, float(np.ptp(triangles, axis=(0, 1)).max()) / POINTS).triangles(POINTS)

    part = setup.workpiece.finished_part
    return None if part is None else mesh(part), tuple((name, mesh(each)) for name, each in setup.workpiece.fixtures)

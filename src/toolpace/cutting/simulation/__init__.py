"""What a planned motion cuts: time in air and in material, volume, what is left, and collisions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.programs.toolpath import ToolPath, check_toolpath

if TYPE_CHECKING:
    from toolpace.cutting.engagement.stations import Stations
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import Stock, StockRange
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading.coordinates.setup import SetUp

MEMORY = 1e9
"""Most that a stock takes [bytes], where nothing else is asked for."""


def simulate_cut(
    trajectory: Trajectory,
    toolpath: ToolPath,
    setup: SetUp,
    *,
    resolution: float | None = None,
    finest: float = 0.0,
    memory: float = MEMORY,
    stock: StockRange | None = None,
    after_operation: Callable[[int, Stock], None] | None = None,
    progress: Callable[[float], None] | None = None,
) -> CutSimulation:
    """What a planned motion cuts of the stock on a set-up sheet, with the tools on it.

    The stock is cut three times: as its figures are, smaller by its uncertainty all round, and larger by it. Time in
    air is that in which nothing can be cut of the largest one; cutting is the time in which something is cut of the
    smallest one too. Without a stock on the sheet or in the program, the box around all cutting moves stands in, and
    the result is marked as guessed: then neither air nor collisions with the stock are findings.

    resolution: size of a cell [m]; without it the finest of use that `memory` [bytes] has room for, but not below
    `finest` [m]. stock: what another program left (`CutSimulation.left`); it is copied. `after_operation` is given the
    index in `CutSimulation.operations` of each operation when it ends, and the stock then. `progress` is told the share
    done.

    Raises UsageError for a motion along another program, for a tool whose figures nothing tells, and for solids that
    make no stock.
    """
    from toolpace.cutting.engagement.stations import motion_stations

    check_toolpath(toolpath, "simulate_cut")
    if not hasattr(trajectory, "axis_path"):
        kind = type(trajectory).__name__
        raise UsageError(f"simulate_cut: {kind} in place of a trajectory; give what tp.plan returns")
    if not hasattr(setup, "workpiece"):
        raise UsageError(f"simulate_cut: {type(setup).__name__} in place of a set-up sheet; give a tp.SetUp")
    machine = trajectory.axis_path.machine
    if machine is None:
        raise UsageError("simulate_cut: the motion has no machine, and so no tool; plan a Path on a Machine")
    stations = partial(motion_stations, trajectory, toolpath)
    return _simulated(
        stations, toolpath, setup, machine, resolution, memory, finest, stock, after_operation, progress
    )  # fmt: skip


def simulate_cut_at_times(
    toolpath: ToolPath,
    times: Floats,
    machine: Machine,
    setup: SetUp,
    *,
    resolution: float | None = None,
    memory: float = MEMORY,
    finest: float = 0.0,
    stock: StockRange | None = None,
    progress: Callable[[float], None] | None = None,
) -> CutSimulation:
    """What a control cuts that passes the points of a tool path at `times` (n,) [s], straight from one to the next.

    For all else see `simulate_cut`.
    """
    from toolpace.cutting.engagement.stations import program_stations

    stations = partial(program_stations, toolpath, times)
    return _simulated(stations, toolpath, setup, machine, resolution, memory, finest, stock, None, progress)


def _simulated(
    stations: Callable[[float, list[float]], list[Stations]],
    toolpath: ToolPath,
    setup: SetUp,
    machine: Machine,
    resolution: float | None,
    memory: float,
    finest: float,
    stock: StockRange | None,
    after_operation: Callable[[int, Stock], None] | None,
    progress: Callable[[float], None] | None,
) -> CutSimulation:
    """`stations` makes them of their spacing [m] and of how far the tool of each operation reaches up [m]."""
    from toolpace.cutting.simulation import set_up
    from toolpace.cutting.simulation.simulate import cut_stations, reach_of

    tools, assumed = set_up.tools_in_use(toolpath, setup)
    if stock is not None:
        cut = stock.copy()
    else:
        cut, notes = set_up.stock_range(toolpath, setup, machine, tools, resolution, memory, finest)
        assumed += notes
    cell = cut.nominal.resolution
    reach = [0.0 if tool is None else reach_of(tool.figures) for tool in tools]
    return cut_stations(
        stations(cell, reach),
        toolpath.operations, tools, cut, set_up.surroundings(setup, machine, cell, memory),
        resolution=cell,
        assumed=[*assumed, *toolpath.assumed],
        after_operation=after_operation or (lambda operation, stock: None),
        progress=progress,
    )  # fmt: skip

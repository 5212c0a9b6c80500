"""What a planned motion cuts of the stock on its set-up sheet, as a step of a job."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from toolpace.cutting.simulation import MEMORY
from toolpace.jobs import TimedSteps

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import Stock, StockRange
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.toolpath import ToolPath

CELL_FOR_TIMES = 0.2e-3
"""Finest cell of a stock that is cut for the time in air and in material [m]: 10 ms at 1200 mm/min."""


def cut_motion(
    setup: SetUp,
    steps: TimedSteps,
    trajectory: Trajectory,
    toolpath: ToolPath,
    resolution: float | None = None,
    memory: float = MEMORY,
    finest: float = 0.0,
    stock: StockRange | None = None,
    after_operation: Callable[[int, Stock], None] = lambda operation, stock: None,
) -> CutSimulation:
    """What a motion cuts of the stock on the set-up sheet, or of the `stock` that another program left. Raises
    UsageError as `simulate_cut`."""
    from toolpace.cutting.simulation import simulate_cut

    with steps.step("cutting") as step:
        simulation = simulate_cut(
            trajectory, toolpath, setup, resolution=resolution, memory=memory, finest=finest, stock=stock,
            after_operation=after_operation, progress=step,
        )  # fmt: skip
        places = sum(len(each.stations) for each in simulation.stretches)
        step.note = f"{places} stations, cells of {simulation.resolution * 1e3:.3g} mm"
    return simulation


def cut_of_known_stock(
    setup: SetUp, steps: TimedSteps, trajectory: Trajectory, toolpath: ToolPath
) -> CutSimulation | None:
    """What a motion cuts, where the set-up sheet names a stock; None where it does not."""
    if setup.workpiece.stock is None:
        return None
    with without_cut(steps):
        return cut_motion(setup, steps, trajectory, toolpath, finest=CELL_FOR_TIMES)
    return None


@contextmanager
def without_cut(steps: TimedSteps) -> Iterator[None]:
    """Go on where a set-up sheet tells too little for a cut, and say what: a time does not need it."""
    from toolpace.common.errors import UsageError

    try:
        yield
    except UsageError as error:
        steps.say(f"air and material are not told apart: {error}")

"""What programs cut, one after the other: the stock that one leaves is the stock of the next."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.common.errors import UnitWarning
from toolpace.jobs import TimedSteps, job, plan_steps
from toolpace.jobs.motion_cut import cut_motion

if TYPE_CHECKING:
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import Stock, StockRange
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.toolpath import ToolPath


@dataclass(frozen=True)
class CutRequest:
    """What all programs of one call have in common."""

    machine: Machine
    options: ReadOptions
    tip_tolerance: float | Tolerances
    axis_tolerance: float | Tolerances
    effort: str
    feed: str | None
    dialect: str | None
    resolution: float | None
    """Size of a cell [m]; None: the finest that `memory` has room for, and no finer than is of use."""
    memory: float
    """Most that the stock takes [bytes]."""


@dataclass(frozen=True)
class ProgramCut:
    """One program, planned and cut."""

    program: str
    toolpath: ToolPath
    trajectory: Trajectory
    simulation: CutSimulation
    setup: SetUp
    text: bytes
    """What its file holds."""


AfterOperation = Callable[[int, int, "Stock"], None]
"""Takes the index of the program, that of the operation that has ended, and the stock then."""


def cut_programs(
    programs: Sequence[str],
    request: CutRequest,
    steps: TimedSteps,
    after_operation: AfterOperation = lambda program, operation, stock: None,
) -> list[ProgramCut]:
    """Plan and cut each program with the stock that the one before left. Raises ToolpaceError."""
    found: list[ProgramCut] = []
    for k, program in enumerate(programs):
        left = found[-1].simulation.left if found else None
        found.append(cut_program(program, request, steps, left, partial(after_operation, k)))
    return found


def cut_program(
    program: str,
    request: CutRequest,
    steps: TimedSteps,
    left: StockRange | None,
    after_operation: Callable[[int, Stock], None],
    check: Callable[[ToolPath], None] = lambda toolpath: None,
) -> ProgramCut:
    """Plan and cut one program; `left` is the stock that another one left, else it is the sheet's. check: raises
    UsageError for what is not known of the program that was read."""
    from toolpace.cutting.simulation import set_up
    from toolpace.programs.reading.setup_file import with_cure_of_zero

    task = job.loaded(
        job.Job(
            program=Path(program),
            machine=request.machine,
            out=Path(),
            tip_tolerance=request.tip_tolerance,
            axis_tolerance=request.axis_tolerance,
            effort=request.effort,
            feed=request.feed,
            dialect=request.dialect,
            options=request.options,
            report=False,
        )
    )
    plan_steps.warm_up(steps)
    toolpath = plan_steps.read_program(task, steps)
    set_up.check_before_planning(
        toolpath, request.options.setup, request.machine, request.resolution, request.memory, stock=left is None
    )
    check(toolpath)
    with with_cure_of_zero(toolpath.assumed):
        planned = plan_steps.plan_motion(task, steps, plan_steps.fit_path(task, steps, toolpath))
    with warnings.catch_warnings():
        # what the place of the stock asks has been asked before the plan
        warnings.simplefilter("ignore", UnitWarning)
        simulation = cut_motion(
            request.options.setup, steps, planned.trajectory, toolpath, request.resolution, request.memory, 0.0, left,
            after_operation,
        )  # fmt: skip
    text = task.source.data if task.source is not None else b""
    return ProgramCut(program, toolpath, planned.trajectory, simulation, request.options.setup, text)

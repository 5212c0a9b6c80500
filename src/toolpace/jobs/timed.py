"""The time of a program on a control, beside its optimum."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from toolpace.common.arrays import Floats
from toolpace.common.errors import ToolpaceError, printable
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.jobs import TimedSteps, job, motion_cut, plan_steps

if TYPE_CHECKING:
    from toolpace.controls.timing.figures import ControlFigures
    from toolpace.controls.timing.program_time import ProgramTime
    from toolpace.controls.timing.uncertainty import TimeRange
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.cutting.simulation.stock_range import StockRange
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import OperationTime, Trajectory
    from toolpace.programs.commanded import Commanded
    from toolpace.programs.reading import ReadOptions, Source
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.write.plan_json import CutRecord

TURN_ARM = 0.05
"""Way of a turning axis for its angle, where the points of one block share its time [m]."""
KINDS = ("cutting", "rapid", "dwell", "tool_change")
"""What time goes to."""


@dataclass(frozen=True)
class Timed:
    """What was found of one program."""

    program: str
    error: str = ""
    control: str = ""
    """Empty for cutter-location data and tables, which are for none."""
    model: str = ""
    blocks: int = 0
    time: ProgramTime | None = None
    best: tuple[OperationTime, ...] = ()
    """The parts of the optimum."""
    optimum: float | None = None
    """[s], with the tool changes; None where it was not wanted."""
    optimum_likewise: float | None = None
    """The same with each limit as high as the control went; None where it exceeds none, or no motion is found."""
    cut: CutRecord | None = None
    """What the control cuts, where the set-up sheet names a stock and its tools."""
    left: StockRange | None = None
    """The stock that is left then."""
    assumed: tuple[str, ...] = ()
    program_tolerance: tuple[float, float] | None = None
    """The least and the widest tolerance of the tip that the program asks for [m]; None where it asks for none."""
    model_tolerance: float | None = None
    """That of the model where the program asks for none [m]; None where the model has none, or its own."""


@dataclass(frozen=True)
class TimeRequest:
    """What all programs of one call have in common."""

    machine: Machine
    options: ReadOptions
    model: str | None
    """In place of the controller's own."""
    feed: str | None
    dialect: str | None
    tolerances: tuple[float | Tolerances | None, float | Tolerances | None]
    """Of tip [m] and axis [rad], for the optimum; None: those of the program, else those of its control."""
    optimum: bool


def timed_or_wrong(program: str, request: TimeRequest, steps: TimedSteps, stock: StockRange | None = None) -> Timed:
    """The time of one program, or what is wrong with it; then the stock is left as it was."""
    try:
        return timed(program, request, steps, stock=stock)
    except ToolpaceError as error:
        return Timed(program, str(error), left=stock)


def timed(
    program: str,
    request: TimeRequest,
    steps: TimedSteps,
    source: Source | None = None,
    stock: StockRange | None = None,
) -> Timed:
    """The time of one program, which may have been loaded before, and what it cuts of a stock: of the one that another
    program left, else of that of the set-up sheet.

    Raises ToolpaceError: of a program that the machine cannot follow too, whether it is planned or not.
    """
    from toolpace.controls.timing.program_time import figures_for, moves_of, of_operations
    from toolpace.programs.reading import Findings, Source
    from toolpace.programs.reading.languages import with_controller
    from toolpace.results.write.plan_json import cut_sums

    source = source if source is not None else Source.load(program)
    options, found = with_controller(source, request.dialect, request.options)
    figures, findings = figures_for(options, request.model), Findings()
    with steps.step("moves") as step:
        moves = moves_of(source, request.machine, options, request.feed, request.dialect, findings)
        step.note = f"{program}: {moves.blocks} blocks, {len(moves)} moves"
    change, waits_only = options.setup.tool_change, len(moves) < 2
    ideal = figures.model == "ideal" and not waits_only
    planned = request.optimum or figures.model == "ideal"
    task = planned_job(source, replace(request, options=options), figures)
    best, trajectory, toolpath = ((), None, None) if waits_only else followed(task, steps, ideal, planned)
    time = of_operations(best, moves, change) if ideal else time_on_control(moves, request, figures, change, steps)
    cut: CutSimulation | None = None
    if options.setup.workpiece.stock is not None and not waits_only:
        toolpath = toolpath if toolpath is not None else plan_steps.read_program(task, steps)
        with motion_cut.without_cut(steps):
            if trajectory is not None:
                finest = motion_cut.CELL_FOR_TIMES
                cut = motion_cut.cut_motion(options.setup, steps, trajectory, toolpath, finest=finest, stock=stock)
            else:
                cut = cut_on_control(task, steps, toolpath, times_of_points(toolpath, moves, time.times), stock)
    least = sum(each.time for each in best) + time.sum("tool_change") if best else None
    return Timed(
        program,
        control=found.controller.name if found.controller is not None else "",
        model=figures.model,
        blocks=moves.blocks,
        time=time,
        best=best,
        optimum=time.total if planned and waits_only else least,
        optimum_likewise=optimum_likewise(task, steps, time) if best else None,
        cut=None if cut is None else cut_sums(cut),
        left=stock if cut is None else cut.left,
        assumed=findings.assumptions,
        program_tolerance=tolerances_of(moves),
        model_tolerance=figures.room if figures.model in ("sinumerik", "heidenhain", "lookahead") else None,
    )


def followed(
    task: job.Job, steps: TimedSteps, ideal: bool, planned: bool
) -> tuple[tuple[OperationTime, ...], Trajectory | None, ToolPath | None]:
    """The parts of the optimum, its motion where that is the time itself (ideal), and the program as far as it is kept.

    Raises ToolpaceError where the machine cannot follow the program, whether it is planned or not.
    """
    from toolpace.jobs.inspection import follow_as_planned
    from toolpace.motion.trajectory import operation_times
    from toolpace.programs.reading.setup_file import with_cure_of_zero

    if ideal:
        trajectory, toolpath = fastest_motion(task, steps)
        return tuple(operation_times(trajectory, toolpath)), trajectory, toolpath
    if planned:
        return optimum_of(task, steps), None, None
    toolpath = plan_steps.read_program(task, steps)
    with with_cure_of_zero(toolpath.assumed):
        follow_as_planned(task.machine, toolpath)
    return (), None, toolpath


def time_on_control(
    moves: Commanded, request: TimeRequest, figures: ControlFigures, change: float, steps: TimedSteps
) -> ProgramTime:
    """The time that a control takes by its model, with its range; change: of a tool [s]."""
    from toolpace.controls.timing.program_time import time_of_moves, with_range

    time = time_of_moves(moves, request.machine, figures, change)
    with steps.step("range"):
        return with_range(time, moves, request.machine, figures)


def optimum_likewise(task: job.Job, steps: TimedSteps, time: ProgramTime) -> float | None:
    """The least time with each limit as high as the control went, tool changes with it [s]; None where it exceeded
    none, or no motion is found."""
    from toolpace.controls.timing.exceeded import raised_limits
    from toolpace.controls.timing.figures import within_limits

    if not time.exceeded:
        return None
    raised = within_limits(task.machine, raised_limits(task.machine, time.exceeded))
    steps.say("optimum with the limits that the control exceeds as high as it goes")
    try:
        return sum(each.time for each in optimum_of(replace(task, machine=raised), steps)) + time.sum("tool_change")
    except ToolpaceError as error:
        # limits some thousand times as high are no machine's: what else was found still counts
        steps.say(f"left out, since no motion was found with these limits: {error}")
        return None


def tolerances_of(moves: Commanded) -> tuple[float, float] | None:
    """The least and the widest tolerance of the tip that a program asks for [m]; None where it asks for none."""
    import numpy as np

    found = moves.tolerance[np.isfinite(moves.tolerance) & (moves.tolerance > 0.0)]
    return (float(found.min()), float(found.max())) if len(found) else None


def planned_job(source: Source, request: TimeRequest, figures: ControlFigures) -> job.Job:
    """The program as `plan` would have it, within the tolerances of the control, without a place for the results."""
    from toolpace.programs.tolerances import Tolerances

    tip, axis = request.tolerances
    tip = Tolerances(figures.room, program=True) if tip is None else tip
    axis = Tolerances(figures.axis_tolerance * DEGREE, program=True) if axis is None else axis
    return job.Job(
        program=Path(source.name), machine=request.machine, out=Path(), tip_tolerance=tip, axis_tolerance=axis,
        feed=request.feed, dialect=request.dialect, options=request.options, source=source,
    )  # fmt: skip


def times_of_points(toolpath: ToolPath, moves: Commanded, times: Floats) -> Floats:
    """(n,) when a control passes the points of a tool path [s], dwells left out, from the times of its moves.

    The moves of a line in an operation are told as one time, which its points share by their ways.
    """
    import numpy as np

    lines = int(max(toolpath.block.max(), moves.line.max())) + 1
    key = 2 * (toolpath.operation * lines + toolpath.block) + toolpath.rapid
    keys, which = np.unique(key, return_inverse=True)
    own = 2 * (moves.operation * lines + moves.line) + moves.rapid
    at = np.minimum(np.searchsorted(keys, own), len(keys) - 1)
    of_key = np.bincount(at, np.where(keys[at] == own, times - moves.dwell, 0.0), len(keys))
    turn = np.linalg.norm(np.diff(toolpath.axis, axis=0, prepend=toolpath.axis[:1]), axis=1)
    way = toolpath.way_length + TURN_ARM * turn
    whole = np.bincount(which, way, len(keys))[which]
    found: Floats = np.cumsum(np.divide(of_key[which] * way, whole, out=np.zeros(len(way)), where=whole > 0.0))
    return found


def cut_on_control(
    task: job.Job, steps: TimedSteps, toolpath: ToolPath, times: Floats, stock: StockRange | None
) -> CutSimulation:
    """What is cut along a program whose points are passed at `times` (n,) [s]. Raises UsageError."""
    from toolpace.cutting.simulation import simulate_cut_at_times

    with steps.step("cutting") as step:
        return simulate_cut_at_times(
            toolpath, times, task.machine, task.options.setup, finest=motion_cut.CELL_FOR_TIMES, stock=stock,
            progress=step,
        )


def optimum_of(task: job.Job, steps: TimedSteps) -> tuple[OperationTime, ...]:
    """The parts of the fastest motion along the program. Raises ToolpaceError."""
    from toolpace.motion.trajectory import operation_times

    return tuple(operation_times(*fastest_motion(task, steps)))


def fastest_motion(task: job.Job, steps: TimedSteps) -> tuple[Trajectory, ToolPath]:
    """The fastest motion along the program, and the program. Raises ToolpaceError."""
    from toolpace.programs.reading.setup_file import with_cure_of_zero

    plan_steps.warm_up(steps)
    toolpath = plan_steps.read_program(task, steps)
    with with_cure_of_zero(toolpath.assumed):
        return plan_steps.plan_motion(task, steps, plan_steps.fit_path(task, steps, toolpath)).trajectory, toolpath


def optimum_of_parts(found: Timed) -> list[float | None]:
    """The optimum of each part of the time [s], tool changes left out; of parts that are called alike in their order.

    None of a part without one.
    """
    best: dict[tuple[str, str], list[float]] = {}
    for each in reversed(found.best):
        best.setdefault((each.name, each.tool), []).append(each.time)
    parts = () if found.time is None else found.time.parts
    return [left.pop() if (left := best.get((part.name, part.tool))) else None for part in parts]


def time_record(found: Timed, machine: str) -> dict[str, object]:
    """An entry of JSON, times in seconds; what could not be timed has an `error` and no times."""
    entry: dict[str, object] = {"program": printable(found.program), "machine": machine}
    time = found.time
    if time is None:
        return entry | {"error": printable(found.error), "total_s": None, "optimum_s": None}
    entry |= {"controller": found.control, "model": found.model, "blocks": found.blocks}
    entry |= {"total_s": time.total, "optimum_s": found.optimum, "optimum_likewise_s": found.optimum_likewise}
    entry |= _range_record(time.range)
    entry |= {f"{kind}_s": time.sum(kind) for kind in KINDS}
    tools: dict[str, float] = {}
    for part in time.parts:
        tools[part.tool] = tools.get(part.tool, 0.0) + part.time
    entry["tools"] = [{"tool": printable(tool), "total_s": seconds} for tool, seconds in tools.items()]
    entry["operations"] = [
        {
            "name": printable(part.name),
            "tool": printable(part.tool),
            "total_s": part.time,
            **{f"{kind}_s": getattr(part, kind) for kind in KINDS},
            "rests": part.rests,
            "optimum_s": least,
        }
        for part, least in zip(time.parts, optimum_of_parts(found))
    ]
    entry["cut"] = None if found.cut is None else msgspec.to_builtins(found.cut)
    tolerances = found.program_tolerance
    entry["program_tolerance_mm"] = None if tolerances is None else [each / MILLIMETRE for each in tolerances]
    entry["exceeded"] = [
        {
            "kind": each.kind,
            "axis": each.axis,
            "ratio": each.ratio,
            "where": each.where,
            "count": each.count,
            "line": each.line,
        }
        for each in time.exceeded
    ]
    entry["assumed"] = [printable(sentence) for sentence in found.assumed]
    return entry


def _range_record(found: TimeRange | None) -> dict[str, object]:
    """The range of a control's time; null of the optimum, which is exact."""
    if found is None:
        return {"range_s": None, "range_mostly_from": None, "uncertain": []}
    effects = [{"figure": each.figure, "range_s": [each.least, each.most]} for each in found.effects]
    return {"range_s": [found.least, found.most], "range_mostly_from": found.mostly or None, "uncertain": effects}

"""The command `time`: how long programs take on a control, and how long they need to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.cli.steps import Steps
from toolpace.cli.timing.timed import Timed
from toolpace.errors import ToolpaceError

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.operations import OperationTime
    from toolpace.reading import ReadOptions, Source


@dataclass(frozen=True)
class Asked:
    """What all programs of one call have in common."""

    machine: Machine
    options: ReadOptions
    model: str | None
    """In place of the controller's own."""
    feed: str | None
    dialect: str | None
    tolerances: tuple[float, float]
    """Of tip [m] and axis [rad], for the optimum."""
    optimum: bool


def timed_or_wrong(program: str, asked: Asked, steps: Steps) -> Timed:
    """The time of one program, or what is wrong with it."""
    try:
        return timed(program, asked, steps)
    except ToolpaceError as error:
        return Timed(program, str(error))


def timed(program: str, asked: Asked, steps: Steps) -> Timed:
    """The time of one program. Raises ToolpaceError."""
    from toolpace.reading import Findings, Source
    from toolpace.reading.languages import with_controller
    from toolpace.timing.program import figures_for, moves_of
    from toolpace.timing.program_time import of_operations, time_of_moves

    source = Source.load(program)
    options, found = with_controller(source, asked.dialect, asked.options)
    figures, findings = figures_for(options, asked.model), Findings()
    with steps.step("moves", program) as step:
        moves = moves_of(source, asked.machine, options, asked.feed, asked.dialect, findings)
        step.note = f"{moves.blocks} blocks, {len(moves)} moves"
    best: tuple[OperationTime, ...] = ()
    planned = asked.optimum or figures.model == "ideal"
    waits_only = len(moves) < 2
    if planned and not waits_only:
        best = optimum_of(source, replace(asked, options=options), steps)
    change = options.setup.tool_change
    if figures.model == "ideal" and not waits_only:
        time = of_operations(best, moves, change)
    else:
        time = time_of_moves(moves, asked.machine, figures, change)
    least = sum(each.time for each in best) + time.sum("tool_change") if best else None
    return Timed(
        program,
        control=found.controller.name if found.controller is not None else "",
        model=figures.model,
        blocks=moves.blocks,
        time=time,
        best=best,
        optimum=time.total if planned and waits_only else least,
        assumed=findings.assumptions,
    )


def optimum_of(source: Source, asked: Asked, steps: Steps) -> tuple[OperationTime, ...]:
    """The parts of the fastest motion along the program. Raises ToolpaceError."""
    from toolpace.cli import job
    from toolpace.operations import operation_times

    tip, axis = asked.tolerances
    task = job.Job(
        program=Path(source.name), machine=asked.machine, out=Path(), tip_tolerance=tip, axis_tolerance=axis,
        feed=asked.feed, dialect=asked.dialect, options=asked.options, source=source,
    )  # fmt: skip
    job.warm_up(steps)
    toolpath = job.read_program(task, steps)
    trajectory = job.plan_motion(task, steps, job.fit_path(task, steps, toolpath))
    return tuple(operation_times(trajectory, toolpath))


def run_time(programs: Sequence[str], asked: Asked, as_json: bool) -> int:
    """Time each program and print what was found; 0 where all could be, else 2. A single one raises ToolpaceError."""
    from rich.console import Console

    from toolpace.cli.steps import new_console
    from toolpace.cli.timing import table

    console = new_console()
    # what is under way is shown beside JSON, too, but not among it
    place = Console(stderr=True, highlight=False, markup=False) if as_json else console
    alone = len(programs) == 1 and not as_json
    found = [(timed if alone else timed_or_wrong)(program, asked, Steps(place)) for program in programs]
    if as_json:
        table.print_json(found, asked.machine.name)
    else:
        table.show(console, found, asked.machine.name)
    return 2 if any(each.error for each in found) else 0

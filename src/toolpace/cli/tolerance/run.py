"""`toolpace tolerance`: what a micrometre costs, as a table and a picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rich.box import SIMPLE
from rich.table import Table

from toolpace.common.units import format_length, format_time
from toolpace.common.workers import Progress
from toolpace.jobs import job

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from toolpace.cli.steps import Steps


ONE_LENGTH = 1e-9
"""Tolerances that differ by less than this are one [m]: 10um and 0.01mm differ by a rounding."""


class Cost(NamedTuple):
    """How long a program takes within a tolerance of the tip."""

    tip_tolerance: float
    """[m]"""
    duration: float
    """[s]"""


def costs(task: job.Job, tolerances: Sequence[float], steps: Steps) -> list[Cost]:
    """The duration within each of the ascending tolerances [m]. Raises ToolpaceError.

    A path within a tolerance is one within a wider, which takes it where it finds no faster one.
    """
    from toolpace.planning.optimal.planner import Optimal
    from toolpace.planning.program_plan import plan_program
    from toolpace.programs.reading.setup_sheet import with_cure_of_zero

    task = job.loaded(task)
    job.warm_up(steps)
    toolpath = job.read_program(task, steps)
    found: list[Cost] = []
    for k, tip in enumerate(tolerances):
        with with_cure_of_zero(toolpath.assumed), steps.step("planning") as step:
            planned = plan_program(
                toolpath, task.machine, tip, task.axis_tolerance, effort=task.effort, planner=Optimal(bound=False),
                progress=Progress(step).part(k / len(tolerances), (k + 1) / len(tolerances)),
            )  # fmt: skip
            duration = min([planned.trajectory.duration, *(each.duration for each in found)])
            step.note = f"within {format_length(tip)}: {format_time(duration)}"
        found.append(Cost(tip, duration))
    return found


def apart(tolerances: Sequence[float], usual: float) -> list[float]:
    """The tolerances [m] in ascending order, the usual one among them, each length once."""
    found = [usual]
    for tip in tolerances:
        if all(abs(tip - other) >= ONE_LENGTH for other in found):
            found.append(tip)
    return sorted(found)


def show_costs(console: Console, usual: float, found: Sequence[Cost]) -> None:
    """A row a tolerance: the duration, and what it takes beside the usual one [m] and the one before it."""
    table = Table(box=SIMPLE, pad_edge=False)
    for name in (
        "tip within",
        "duration",
        f"against {format_length(usual)}",
        "saved by 1 µm more",
    ):
        table.add_column(name, justify="right")
    beside = next(each.duration for each in found if each.tip_tolerance == usual)
    for k, each in enumerate(found):
        gain = ""
        if k + 1 < len(found):
            wider = found[k + 1]
            gain = format_time((each.duration - wider.duration) / (wider.tip_tolerance - each.tip_tolerance) * 1e-6)
        table.add_row(
            format_length(each.tip_tolerance), format_time(each.duration),
            f"{100.0 * (each.duration / beside - 1.0):+.2f} %", gain,
        )  # fmt: skip
    console.print()
    console.print(table)


def run_tolerance(task: job.Job, tolerances: Sequence[float], picture: Path | None, steps: Steps) -> int:
    """Plan a program within each tolerance, that of the job among them, and show what they cost."""
    from toolpace.cli.tolerance.picture import drawn
    from toolpace.common.files import whole_file

    assert isinstance(task.tip_tolerance, float)
    asked = apart(tolerances, task.tip_tolerance)
    found = costs(replace(task, report=False), asked, steps)
    show_costs(steps.console, task.tip_tolerance, found)
    if picture is not None:
        with whole_file(picture) as temporary:
            temporary.write_text(drawn(found, task.program.name), encoding="utf-8")
        steps.console.print(f"written   {picture}", soft_wrap=True)
    return 0

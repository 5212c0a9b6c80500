"""The options of the command `batch`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from toolpace.cli import options

ProgramsOrJobs = Annotated[
    list[str],
    Parameter(help="Programs, folders of programs, patterns of names, or one file of jobs (.toml)."),
]
What = Annotated[
    str,
    Parameter(
        help="plan; time, on its control, and the optimum; inspect; export: plan, and write files for a control."
    ),
]
Machines = Annotated[
    list[str],
    Parameter(
        name=["--machine", "-m"],
        negative="",
        help="Built-in machine or machine file; named several times, each program is planned on each of them.",
    ),
]
Target = Annotated[str | None, Parameter(name="--to", help="Of export: the target, as of `toolpace export`.")]
Out = Annotated[str, Parameter(name=["--out", "-o"], help="Folder for all; one that a batch has left is gone on with.")]
Memory = Annotated[
    str | None, Parameter(help="What each worker that is started may take, like 4GB; by default an equal share of all.")
]


@Parameter(name="*")
@dataclass(frozen=True)
class Each:
    """What each job is planned with; each of these may be given several times, for a job with each."""

    tip_tolerance: Annotated[list[str] | None, Parameter(negative="", help="0.01mm by default.")] = None
    axis_tolerance: Annotated[list[str] | None, Parameter(negative="", help="0.05deg by default.")] = None
    planner: Annotated[list[str] | None, Parameter(negative="", help="optimal by default.")] = None
    effort: Annotated[list[str] | None, Parameter(negative="", help="low, normal (default) or high.")] = None
    feed: Annotated[
        list[str] | None, Parameter(negative="", help="In place of the program's: 120%, 3000mm/min, none.")
    ] = None
    prove: options.Prove = False
    prove_within: options.ProveWithin = "60s"
    bend: options.Bend = None
    tool_length: options.ToolLength = None
    dialect: options.Dialect = None
    model: options.ControlModel = None
    no_optimum: options.NoOptimum = False


AS_USUAL = Each()
NO_MACHINES: list[str] = []
"""Nothing was given."""

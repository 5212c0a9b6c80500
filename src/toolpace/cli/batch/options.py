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
        help="plan. time: on its control, and the optimum. inspect. export: plan, and write files for a control."
    ),
]
Machines = Annotated[
    list[str],
    Parameter(
        name=["--machine", "-m"],
        negative="",
        help="Built-in machine or machine file; may be given several times: each program is planned on each.",
    ),
]
Target = Annotated[str | None, Parameter(name="--to", help="With --what export: the target, as for `toolpace export`.")]
Out = Annotated[
    str, Parameter(name=["--out", "-o"], help="Folder for all jobs; a batch that was stopped there continues.")
]
Memory = Annotated[
    str | None, Parameter(help="Memory of each worker that is started, like 4GB; by default an equal share.")
]


@Parameter(name="*")
@dataclass(frozen=True)
class Each:
    """What each job is planned with; each of these may be given several times, for a job with each."""

    tip_tolerance: Annotated[
        list[str] | None, Parameter(negative="", help="Tolerance of the tip; 0.01mm by default.")
    ] = None
    axis_tolerance: Annotated[
        list[str] | None, Parameter(negative="", help="Tolerance of the tool axis; 0.05deg by default.")
    ] = None
    planner: Annotated[
        list[str] | None, Parameter(negative="", help="optimal (default), genetic or second-order.")
    ] = None
    effort: Annotated[list[str] | None, Parameter(negative="", help="low, normal (default) or high.")] = None
    feed: Annotated[
        list[str] | None, Parameter(negative="", help="Feed in place of the program's: 120%, 3000mm/min, none.")
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

"""The checked arguments of the command `tolerance`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from toolpace.cli import options
from toolpace.cli.steps import Steps, new_console

TIPS = "1um,2um,5um,10um,20um,50um"
Tips = Annotated[str, Parameter(help="Tolerances of the tip, separated by commas.")]
Picture = Annotated[
    str | None, Parameter(name=["--out", "-o"], help="Draw duration over tolerance into this file (.svg).")
]


def tolerance_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    tips: Tips = TIPS,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    effort: options.Effort = "normal",
    feed: options.Feed = None,
    out: Picture = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Show what a micrometre costs: the duration of a program over the tolerance of its tip.

    The program is planned within each tolerance. The times are compared with that
    of --tip-tolerance.

    For example:

        toolpace tolerance part.ngc -m xyzac-trunnion
        toolpace tolerance part.ngc -m xyzbc-head --tips 2um,5um,20um --out costs.svg
    """
    from toolpace.cli import arguments
    from toolpace.cli.tolerance import run
    from toolpace.jobs import job

    tip, axis = arguments.even_tolerances(tolerances)
    asked = arguments.tip_tolerances(tips)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    task = job.Job(
        program=Path(program), machine=on, out=Path(), tip_tolerance=tip, axis_tolerance=axis,
        effort=arguments.effort_named(effort), feed=arguments.feed_asked(feed), dialect=dialect, options=how,
    )  # fmt: skip
    picture = arguments.file_for_result("--out", out)
    return run.run_tolerance(task, asked, picture, Steps(new_console()))

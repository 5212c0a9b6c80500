"""The commands and what `--help` says of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from toolpace import __version__
from toolpace.cli.steps import Steps, new_console

INTRODUCTION = """The fastest motion along a five-axis tool path, within every axis's limits.

Give it a program and a machine: it finds the least-time motion within velocity,
acceleration and jerk limits, judges it independently, and shows it in a report.
"""

EXAMPLES = """
Examples:

    toolpace demo                     see it work, on a part of its own
    toolpace machines                 the built-in machines and their limits
    toolpace plan part.ngc -m xyzac-trunnion        plan, and write a report
    toolpace verify part-plan         judge a plan again, from its files alone

Exit codes: 0 all is well; 1 a verification failed; 2 something in the input is
wrong, and one line says what, where and how to cure it.
"""

app = App(
    name="toolpace",
    version=__version__,
    help=INTRODUCTION,
    help_epilogue=EXAMPLES,
    help_format="rich",
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,
)

Switch = Parameter(negative="", show_default=False)


@app.command(help_epilogue="")
def plan(
    program: str,
    /,
    *,
    machine: Annotated[str | None, Parameter(name=["--machine", "-m"])] = None,
    tip_tolerance: str = "0.01mm",
    axis_tolerance: str = "0.05deg",
    planner: str = "optimal",
    prove: Annotated[bool, Switch] = False,
    prove_within: str = "60s",
    feed: str | None = None,
    dt: str = "1ms",
    out: Annotated[str | None, Parameter(name=["--out", "-o"])] = None,
    csv: Annotated[bool, Switch] = False,
    tool_length: str | None = None,
    dialect: str | None = None,
    no_report: Annotated[bool, Switch] = False,
) -> int:
    """Plan the fastest motion of a program on a machine; write plan.json, setpoints.npz and report.html.

    The program is smoothed within the tolerances, planned to the limits of the
    machine and its own feeds, judged independently, and written with a report
    that opens in any browser.

    For example:

        toolpace plan part.ngc --machine xyzac-trunnion
        toolpace plan part.cls -m my-mill.toml --tip-tolerance 5um --feed 120%
        toolpace plan part.ngc -m xyzbc-head --feed none --out fastest --csv
        toolpace plan part.ngc -m xyzbc-head --prove --prove-within 5min

    Parameters
    ----------
    program
        G-code, APT, CLSF or a table (CSV) of points and tool axes.
    machine
        Name of a built-in machine (see `toolpace machines`) or a machine file (.toml). Required.
    tip_tolerance
        How far the tool tip may stray from the program, to be smooth: 0.01mm, 5um, 0.0004in.
    axis_tolerance
        How far the tool axis may turn from the program's: 0.05deg, 1e-3rad.
    planner
        optimal: least time, the default. genetic: the method of Wu, Li, Liu and Perez (ACC 2009).
        second-order: least time without jerk limits, to compare with; it fails the verification of jerk.
    prove
        After planning, prove how close the plan is to the fastest possible one: raises the lower bound until the gap
        is 0.01 % or the time for it is up.
    prove_within
        That time.
    feed
        In place of the program's feeds: a factor (120%), a value (3000mm/min), or none: as fast as the machine can.
    dt
        Time between set-points.
    out
        Folder for the results; by default PROGRAM-plan, here.
    csv
        Write the set-points as a table (setpoints.csv) too.
    tool_length
        From the spindle nose to the tip, in place of the machine file's: 120mm.
    dialect
        gcode, apt or csv, where the name of the program does not tell.
    no_report
        Leave report.html out.
    """
    from toolpace import units
    from toolpace.cli import arguments, job, summary

    tip, axis = arguments.tolerances(tip_tolerance, axis_tolerance)
    arguments.planner_named(planner)
    task = job.Job(
        program=Path(program),
        machine=arguments.machine_named(machine, tool_length),
        out=arguments.folder_to_write(out or f"{Path(program).stem}-plan"),
        tip_tolerance=tip,
        axis_tolerance=axis,
        planner=planner,
        prove_within=arguments.time_to_prove(prove_within, planner) if prove else None,
        feed=arguments.feed_asked(feed),
        dialect=dialect,
        dt=units.parse_time(dt),
        csv=csv,
        report=not no_report,
    )
    console = new_console()
    record, verification = job.run(task, Steps(console))
    summary.show_plan(console, record, verification)
    summary.show_files(console, task.out, job.written(task))
    return job.exit_code(record, verification)


@app.command(help_epilogue="")
def verify(directory: str, /) -> int:
    """Judge a plan again, from the files in its folder alone: limits, feeds, tolerances, rest, travel.

    Nothing of the planner is used: set-points are differentiated, put through the
    machine's forward kinematics and compared with the program. Exit code 1 if
    anything fails.

    For example:

        toolpace verify part-plan

    Parameters
    ----------
    directory
        The folder that `toolpace plan` wrote.
    """
    from toolpace.cli import folder, summary

    console = new_console()
    verification = folder.verify_folder(Path(directory), Steps(console))
    summary.show_verification(console, verification)
    return 0 if verification.ok else 1


@app.command(help_epilogue="")
def machines(name: str | None = None, /, *, toml: Annotated[bool, Switch] = False) -> int:
    """List the built-in machines with their class, travel and limits.

    For example:

        toolpace machines
        toolpace machines xyzac-trunnion --toml > my-mill.toml

    Parameters
    ----------
    name
        One machine, or a machine file to look at; all built-in ones without.
    toml
        Print the machine file.
    """
    from toolpace.cli import summary
    from toolpace.errors import UsageError
    from toolpace.machine.machine import Machine

    if toml:
        if name is None:
            raise UsageError("--toml needs the name of one machine: toolpace machines xyzac-trunnion --toml")
        print(Machine.load(name).to_toml(), end="")
        return 0
    console = new_console()
    for each in (name,) if name else Machine.names():
        summary.show_machine(console, Machine.load(each))
    return 0


@app.command(help_epilogue="")
def demo(*, out: Annotated[str, Parameter(name=["--out", "-o"])] = "toolpace-demo") -> int:
    """Plan an impeller of seven blades on a built-in machine, and name the report to open.

    The program is written beside the plan, as program.ngc.

    Parameters
    ----------
    out
        Folder for the results.
    """
    from toolpace.cli import arguments, folder

    return folder.run_demo(arguments.folder_to_write(out), new_console())


@app.command(help_epilogue="")
def study(*, out: Annotated[str, Parameter(name=["--out", "-o"])] = "toolpace-study") -> int:
    """Redo the simulation study of Wu, Li, Liu and Perez (ACC 2009): its figures beside ours.

    Parameters
    ----------
    out
        Folder for the results.
    """
    from toolpace.cli import arguments, folder

    return folder.run_study(arguments.folder_to_write(out), new_console())

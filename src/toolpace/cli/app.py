"""The commands and their `--help`."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App

from toolpace.cli import comparing, exporting, options
from toolpace.cli.batch import command as many
from toolpace.cli.follow import run as live
from toolpace.cli.setup import command as placing
from toolpace.cli.steps import Steps, new_console
from toolpace.cli.tolerance import command as tolerance
from toolpace.common.errors import UsageError
from toolpace.common.version import __version__

INTRODUCTION = """The fastest motion along a five-axis tool path, within every axis's limits.

Give it a program and a machine: it finds the least-time motion within velocity,
acceleration and jerk limits, verifies it independently, and shows it in a report.
"""

EXAMPLES = """
Examples:

    toolpace inspect part.ngc         what a program contains and needs
    toolpace demo                     see it work, on a part of its own
    toolpace machines                 the built-in machines and their limits
    toolpace plan part.ngc -m xyzac-trunnion        plan, and write a report
    toolpace time part.ngc -m xyzac-trunnion        how long its control takes, and the optimum
    toolpace setup part.ngc -m xyzac-trunnion       where to clamp the part for the least time
    toolpace tolerance part.ngc -m xyzac-trunnion   what a micrometre costs
    toolpace verify part-plan         verify a plan again, from its files alone
    toolpace export part-plan --to table            files that a control loads
    toolpace batch parts/ -m xyzac-trunnion         many programs, on all cores or a cluster
    toolpace follow part.law          follow a plan live, as a component of LinuxCNC's HAL

Exit codes: 0 success; 1 a verification failed; 2 the input is wrong: one line
says what, where, and how to cure it.
"""

app = App(
    name="toolpace",
    version=__version__,
    help=INTRODUCTION,
    help_epilogue=EXAMPLES,
    help_format="plaintext",
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,
)


@app.command(name="plan", help_epilogue="")
def plan_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    planner: options.PlannerName = "optimal",
    effort: options.Effort = "normal",
    prove: options.Prove = False,
    prove_within: options.ProveWithin = "60s",
    feed: options.Feed = None,
    bend: options.Bend = None,
    out: options.Out = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    files: options.Files = options.USUAL_FILES,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Plan the fastest motion of a program on a machine; write plan.json, set-points and report.html.

    The program is smoothed within the tolerances and planned up to the limits of
    the machine and its own feeds. The motion is verified independently, and written
    with a report that opens in any browser.

    For example:

        toolpace plan part.ngc --machine xyzac-trunnion
        toolpace plan part.cls -m my-mill.toml --tip-tolerance 5um --feed 120%
        toolpace plan part.ngc -m xyzbc-head --feed none --out fastest --csv
        toolpace plan part.ngc -m xyzbc-head --effort high
        toolpace plan part.ngc -m xyzbc-head --prove --prove-within 5min
        toolpace plan part.mpf -m my-mill.toml --controller sinumerik --setup setup.toml
        toolpace plan part.ngc -m xyzac-trunnion --bend tool.toml
        post part.cls | toolpace plan - -m xyzbc-head --out part-plan
    """
    from toolpace.cli import arguments, summary
    from toolpace.jobs import job

    tip, axis = arguments.tolerances(tolerances)
    arguments.planner_named(planner)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    task = job.Job(
        program=Path(program),
        machine=on,
        out=arguments.folder_for_results(arguments.default_folder(program) if out is None else out),
        tip_tolerance=tip,
        axis_tolerance=axis,
        planner=planner,
        effort=arguments.effort_named(effort),
        prove_within=arguments.time_to_prove(prove_within, planner) if prove else None,
        feed=arguments.feed_asked(feed),
        dialect=dialect,
        options=how,
        tool=arguments.tool_named(bend),
        dt=arguments.time_step(files.dt),
        csv=files.csv,
        npz=arguments.form_of_set_points(files.npz),
        report=not files.no_report,
    )
    console = new_console()
    record, verification = job.carry_out(task, Steps(console))
    summary.show_plan(console, record, verification)
    summary.show_files(console, task.out, job.written(task, record), record)
    return job.exit_code(record, verification)


app.command(many.batch_command, name="batch", help_epilogue="")


@app.command(name="verify", help_epilogue="")
def verify_command(directory: options.PlanFolder, /, *, reading: options.Reading = options.AS_WRITTEN) -> int:
    """Verify a plan again, from the files in its folder alone: limits, feeds, tolerances, rest, travel, figures.

    Nothing of the planner is used. Set-points are differentiated, put through the
    machine's forward kinematics and compared with the program. Each column and each
    figure of plan.json is recomputed; those that only the planner knows are listed.
    Exit code 1 if a check fails. The program is read as it was for the plan; options
    given here replace those of the plan.

    For example:

        toolpace verify part-plan
    """
    from toolpace.cli import folder, summary

    console = new_console()
    record, verification = folder.verify_folder(Path(directory), Steps(console), reading)
    summary.show_verification(console, record, verification)
    return 0 if verification.ok else 1


app.command(comparing.compare_command, name="compare", help_epilogue="")


@app.command(name="export", help_epilogue="")
def export_command(
    directory: options.PlanFolder,
    /,
    *,
    to: exporting.TargetName,
    out: exporting.ExportOut = None,
    target: exporting.TargetOptions = exporting.AS_USUAL,
) -> int:
    """Write a plan as files that a control loads: a table, streams for LinuxCNC, rows of a FIFO, or the program itself.

    The files are read back and compared with the plan before the folder is put in
    place. Each says at its head how to use it. What a target cannot hold is refused.
    docs: from plan to machine.

    For example:

        toolpace export part-plan --to table --period 4ms --columns t,q,qd
        toolpace export part-plan --to linuxcnc-g93 --out part-stream
        toolpace export part-plan --to program --inverse-time
    """
    return exporting.run_export(directory, to, out, target)


@app.command(name="follow", help_epilogue="")
def follow_command(
    law: live.LawFile,
    /,
    *,
    backlog: live.Backlog = "20ms",
    record: live.RecordFile = None,
    name: live.ComponentName = "toolpace",
    streamer: live.StreamerNumber = 0,
) -> int:
    """Follow a plan live as a component of LinuxCNC's HAL: at any pace, corrected by the pins deflection-x, -y and -z.

    LAW is the file that Follower.save wrote. The component is not realtime: it
    keeps the queue of HAL's streamer full, and the streamer gives one row to the
    joints in each servo period. A measurement therefore reaches the joints one
    backlog later. SIGTERM (unloadusr) or Ctrl-C ends the component, after a stop on
    the path within the limits.
    docs: from plan to machine.

    For example:

        toolpace follow part.law --backlog 10ms
        toolpace follow part.law --record given.csv
    """
    return live.run_follow(law, backlog, record, name, streamer)


@app.command(name="inspect", help_epilogue="")
def inspect_command(
    programs: options.Programs,
    /,
    *,
    machine: options.MachineToInspect = None,
    dialect: options.Dialect = None,
    feed: options.Feed = None,
    json: options.Json = False,
    write_setup: options.WriteSetup = None,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Show what programs contain and need: dialect, blocks, extents, words that are not read, fitting machines.

    Nothing is planned. Several programs are listed in one table. Exit code 0 if
    every word is read, 2 if one is refused. Each refused word is listed with its
    first line, its count and its cure.

    For example:

        toolpace inspect part.ngc
        toolpace inspect part.mpf -m my-mill.toml --write-setup setup.toml
        toolpace inspect first.nc second.nc --json
    """
    from toolpace.cli import inspecting

    return inspecting.run_inspect(programs, machine, dialect, feed, json, write_setup, reading)


@app.command(name="time", help_epilogue="")
def time_command(
    programs: options.Programs,
    /,
    *,
    machine: options.MachineName = None,
    model: options.ControlModel = None,
    no_optimum: options.NoOptimum = False,
    fit: options.FitLog = None,
    write_controller: options.WriteController = None,
    feed: options.Feed = None,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    json: options.Json = False,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Estimate how long programs take on a control, by operation, and how long the fastest motion takes.

    The control is recognised from the program, or named by --controller. A few
    figures in its file (table [time]) describe how it executes blocks. The set-up
    sheet gives the time of a tool change ([times] tool_change, in seconds).

    For example:

        toolpace time part.ngc -m xyzac-trunnion --controller linuxcnc
        toolpace time first.nc second.nc -m my-mill.toml --controller my-control.toml --setup setup.toml
        toolpace time part.mpf -m xyzbc-head --model fir --no-optimum --json
        toolpace time part.nc -m my-mill.toml --fit log.csv --write-controller my-control.toml
    """
    from toolpace.cli import arguments
    from toolpace.cli.time import fitting, run
    from toolpace.jobs.timed import Asked

    within = arguments.tolerances(tolerances)
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    asked = Asked(
        machine=on,
        options=how,
        model=arguments.control_model(model),
        feed=arguments.feed_asked(feed),
        dialect=dialect,
        tolerances=within,
        optimum=not no_optimum,
    )
    if fit is not None:
        return fitting.run_fit(programs, fit, asked, write_controller)
    if write_controller is not None:
        raise UsageError("--write-controller goes with --fit LOG.csv: figures come from a log")
    return run.run_time(programs, asked, json)


app.command(tolerance.tolerance_command, name="tolerance", help_epilogue="")


app.command(placing.setup_command, name="setup", help_epilogue="")


@app.command(name="controllers", help_epilogue="")
def controllers_command(name: options.OneController = None, /, *, toml: options.ControllerToml = False) -> int:
    """List the controllers whose programs are read.

    For example:

        toolpace controllers
        toolpace controllers fanuc --toml > my-control.toml
    """
    from rich.box import SIMPLE
    from rich.table import Table
    from rich.text import Text

    from toolpace.common.errors import UsageError, printable
    from toolpace.programs.reading.controllers.controller import Controller

    if toml:
        if name is None:
            raise UsageError("--toml needs the name of one controller: toolpace controllers fanuc --toml")
        print(Controller.text_of(name), end="")
        return 0
    table = Table(box=SIMPLE, pad_edge=False)
    for heading in ("controller", "language", "note"):
        table.add_column(heading, overflow="fold")
    for each in Controller.names() if name is None else (name,):
        controller = Controller.load(each)
        cells = (controller.name, controller.language, controller.note)
        table.add_row(*(Text(printable(cell)) for cell in cells))
    new_console().print(table)
    return 0


@app.command(name="machines", help_epilogue="")
def machines_command(
    name: options.OneMachine = None, /, *, toml: options.Toml = False, poses: options.Poses = False
) -> int:
    """List the built-in machines with their class, travel and limits.

    Start your own machine file from a built-in one. Before the first program runs,
    drive the real machine to a few of the poses and compare: a wrong sign or order
    shows in the tool axis, a wrong point in the tip.

    For example:

        toolpace machines
        toolpace machines xyzac-trunnion --toml > my-mill.toml
        toolpace machines my-mill.toml --poses
    """
    from toolpace.cli import arguments, summary
    from toolpace.machine.machine import Machine

    console = new_console()
    if toml or poses:
        machine = Machine.load(arguments.one_machine(name, toml, poses))
        if toml:
            print(machine.to_toml(), end="")
        else:
            summary.show_poses(console, machine)
        return 0
    for each in Machine.names() if name is None else (name,):
        summary.show_machine(console, Machine.load(each))
    return 0


@app.command(name="demo", help_epilogue="")
def demo_command(*, out: options.Results = "toolpace-demo") -> int:
    """Plan an impeller of seven blades on a built-in machine, and name the report to open.

    The program is written beside the plan, as program.ngc.
    """
    from toolpace.cli import arguments, folder

    return folder.run_demo(arguments.folder_for_results(out), new_console())


@app.command(name="study", help_epilogue="")
def study_command(*, out: options.Results = "toolpace-study") -> int:
    """Redo the simulation study of Wu, Li, Liu and Perez (ACC 2009): its figures beside ours."""
    from toolpace.cli import arguments, folder

    return folder.run_study(arguments.folder_for_results(out), new_console())

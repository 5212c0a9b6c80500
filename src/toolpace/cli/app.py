"""The application of all commands, with their `--help`; short commands are carried out here."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App, Group

from toolpace.cli import options
from toolpace.cli.commands import app as app_page
from toolpace.cli.commands import batch, compare, cut, export, feeds, follow, machines, picture, setup, tolerance
from toolpace.cli.console import Steps, cells, new_console, new_table
from toolpace.common import __version__
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import DEGREE, MILLIMETRE

INTRODUCTION = """The fastest motion along a five-axis tool path, within every axis's limits.

Give it a program and a machine: it finds the least-time motion within velocity,
acceleration and jerk limits, verifies it independently, and shows it in a report.
"""

EXAMPLES = """
Examples:

    toolpace inspect part.ngc         what a program contains and needs
    toolpace demo                     see it work, on a part of its own
    toolpace machines                 the built-in machines and their limits
    toolpace machines --from mill.ini --write mill.toml    a machine from its control's files
    toolpace plan part.ngc -m xyzac-trunnion        plan, and write a report
    toolpace time part.ngc -m xyzac-trunnion        how long its control takes, and the optimum
    toolpace setup part.ngc -m xyzac-trunnion       where to clamp the part for the least time
    toolpace tolerance part.ngc -m xyzac-trunnion   what a micrometre costs
    toolpace cut part.ngc -m xyzac-trunnion --setup setup.toml   what it cuts: air, material, collisions
    toolpace feeds part.ngc -m xyzac-trunnion --setup s.toml -o new.ngc   the program with the feeds that its cut allows
    toolpace verify part-plan         verify a plan again, from its files alone
    toolpace export part-plan --to table            files that a control loads
    toolpace picture part-plan --at 12.5s -o part.png    the motion at a moment, or --to part.gif
    toolpace batch parts/ -m xyzac-trunnion         many programs, on all cores or a cluster
    toolpace app                      a page in the browser: inspect, plan, compare, export
    toolpace follow part.law          follow a plan live, as a component of LinuxCNC's HAL

Exit codes: 0 success; 1 a verification failed; 2 the input is wrong: one line
says what, where, and how to cure it.
"""

START, PLAN, CUT, CONTROL, OPTIONS = (
    Group(name, sort_key=number)
    for number, name in enumerate(("Begin", "Plan and compare", "What the tool cuts", "The control", "Options"))
)

app = App(
    name="toolpace",
    version=__version__,
    help=INTRODUCTION,
    help_epilogue=EXAMPLES,
    help_format="plaintext",
    version_flags=["--version"],
    suppress_keyboard_interrupt=False,
)

for flag in ("--help", "--version"):
    app[flag].group = (OPTIONS,)


@app.command(name="plan", group=PLAN, help_epilogue="")
def plan_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    tolerances: options.Tolerances = options.TIGHTER_TOLERANCES,
    planner: options.PlannerName = "optimal",
    effort: options.Effort = "normal",
    prove: options.Prove = False,
    prove_within: options.ProveWithin = "60s",
    prices: options.Prices = False,
    feed: options.Feed = None,
    allowed: feeds.AllowedInPlan = feeds.AS_PROGRAMMED,
    resolution: cut.Resolution = None,
    memory: cut.Memory = cut.MEMORY,
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
        toolpace plan part.ngc -m xyzac-trunnion --prices
        toolpace plan part.mpf -m my-mill.toml --controller sinumerik --setup setup.toml
        toolpace plan part.ngc -m xyzac-trunnion --bend tool.toml
        toolpace plan part.ngc -m xyzac-trunnion --setup setup.toml --feeds limits --limit chip=0.08mm
        post part.cls | toolpace plan - -m xyzbc-head --out part-plan
    """
    from toolpace.cli import arguments, summary
    from toolpace.jobs import job, plan_steps

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
        prices=arguments.priced(prices, planner),
        feed=arguments.feed_option(feed),
        dialect=dialect,
        options=how,
        tool=arguments.tool_named(bend),
        cut_options=allowed.of_plan(resolution, memory, bend),
        dt=arguments.time_step(files.dt),
        csv=files.csv,
        npz=arguments.form_of_set_points(files.npz),
        report=not files.no_report,
    )
    console = new_console()
    record, verification = plan_steps.carry_out(task, Steps(console))
    summary.show_plan(console, record, verification)
    summary.show_prices(console, record, task.machine)
    summary.show_files(console, task.out, plan_steps.written(task, record), record)
    return plan_steps.exit_code(record, verification)


app.command(batch.batch_command, name="batch", group=PLAN, help_epilogue="")
app.command(app_page.app_command, name="app", group=START, help_epilogue="")


@app.command(name="verify", group=PLAN, help_epilogue="")
def verify_command(
    directory: options.PlanFolder,
    /,
    *,
    stated: feeds.StatedCut = feeds.NOTHING_STATED,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Verify a plan again, from the files in its folder alone: limits, feeds, tolerances, rest, travel, figures.

    Nothing of the planner is used. Set-points are differentiated, put through the
    machine's forward kinematics and compared with the program. Each column and each
    figure of plan.json is recomputed; those that only the planner knows are listed.
    Exit code 1 if a check fails. The program is read as it was for the plan; options
    given here replace those of the plan. What its cut was promised to be is what the
    folder says, and held against --limit, --material and --setup where they are given.

    For example:

        toolpace verify part-plan
    """
    from toolpace.cli import summary
    from toolpace.cli.commands import verify

    console = new_console()
    record, verification = verify.verify_folder(Path(directory), Steps(console), reading, stated.promise())
    summary.show_verification(console, record, verification)
    return 0 if verification.ok else 1


app.command(compare.compare_command, name="compare", group=PLAN, help_epilogue="")


app.command(export.export_command, name="export", group=CONTROL, help_epilogue="")


app.command(picture.picture_command, name="picture", group=PLAN, help_epilogue="")


app.command(follow.follow_command, name="follow", group=CONTROL, help_epilogue="")


@app.command(name="inspect", group=START, help_epilogue="")
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
    from toolpace.cli.commands import inspect

    return inspect.run_inspect(programs, machine, dialect, feed, json, write_setup, reading)


@app.command(name="time", group=CONTROL, help_epilogue="")
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
    tolerances: options.Tolerances = options.TOLERANCES_OF_PROGRAM,
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
        toolpace time part.mpf -m xyzbc-head --model sinumerik --no-optimum --json
        toolpace time part.nc -m my-mill.toml --fit log.csv --write-controller my-control.toml
        toolpace time part.nc -m my-mill.toml --fit 3:12
    """
    from toolpace.cli import arguments
    from toolpace.cli.commands import time
    from toolpace.jobs.timed import TimeRequest

    tip, axis = arguments.tolerances(tolerances)
    usual = options.TOLERANCES_OF_PROGRAM
    on, how = arguments.machine_with_setup(arguments.machine_named(machine, tool_length), reading)
    request = TimeRequest(
        machine=on,
        options=how,
        model=arguments.control_model(model),
        feed=arguments.feed_option(feed),
        dialect=dialect,
        tolerances=(
            None if (tolerances.tip_tolerance, tolerances.side) == (usual.tip_tolerance, usual.side) else tip,
            None if tolerances.axis_tolerance == usual.axis_tolerance else axis,
        ),
        optimum=not no_optimum,
    )
    if fit is not None:
        return time.run_fit(programs, fit, request, write_controller)
    if write_controller is not None:
        raise UsageError("--write-controller goes with --fit: figures come from a log or from measured times")
    return time.run_time(programs, request, json)


app.command(cut.cut_command, name="cut", group=CUT, help_epilogue="")
app.command(feeds.feeds_command, name="feeds", group=CUT, help_epilogue="")


app.command(tolerance.tolerance_command, name="tolerance", group=PLAN, help_epilogue="")


app.command(setup.setup_command, name="setup", group=PLAN, help_epilogue="")


@app.command(name="controllers", group=START, help_epilogue="")
def controllers_command(name: options.OneController = None, /, *, toml: options.ControllerToml = False) -> int:
    """List the controllers whose programs are read.

    For example:

        toolpace controllers
        toolpace controllers fanuc --toml > my-control.toml
    """
    from toolpace.programs.reading.controllers.controller import Controller

    if toml:
        if name is None:
            raise UsageError("--toml needs the name of one controller: toolpace controllers fanuc --toml")
        print(Controller.text_of(name), end="")
        return 0
    headings = ("controller", "language", "note")
    table = new_table(headings, left=headings)
    for each in Controller.names() if name is None else (name,):
        controller = Controller.load(each)
        table.add_row(*cells([controller.name, controller.language, controller.note]))
    new_console().print(table)
    return 0


app.command(machines.machines_command, name="machines", group=START, help_epilogue="")


@app.command(name="demo", group=START, help_epilogue="")
def demo_command(*, out: options.Results = "toolpace-demo") -> int:
    """Plan an impeller of seven blades on a built-in machine, and name the report to open.

    The program is written beside the plan, as program.ngc.
    """
    from toolpace.cli import arguments, demo_programs, summary
    from toolpace.jobs import job, plan_steps
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import Source
    from toolpace.results import write

    place = arguments.folder_for_results(out)
    machine = Machine.load(demo_programs.MACHINE)
    console = new_console()
    steps = Steps(console)
    plan_steps.warm_up(steps)
    with steps.step("generating") as step:
        source = Source.from_bytes(demo_programs.impeller_program(machine).encode("ascii"), "impeller.ngc")
        step.note = "the program of an impeller, seven blades"
    task = job.Job(Path(source.name), machine, place, 0.01 * MILLIMETRE, 0.05 * DEGREE, source=source)
    record, verification = plan_steps.carry_out(task, steps)
    summary.show_plan(console, record, verification)
    summary.show_files(console, place, plan_steps.written(task, record), record)
    report = (place / write.REPORT).resolve()
    console.print(f"\nOpen the report in a browser:\n{printable(str(report))}", soft_wrap=True)
    return plan_steps.exit_code(record, verification)


@app.command(name="study", group=PLAN, help_epilogue="")
def study_command(*, out: options.Results = "toolpace-study") -> int:
    """Redo the simulation study of Wu, Li, Liu and Perez (ACC 2009): its figures beside ours."""
    from toolpace import study
    from toolpace.cli import arguments
    from toolpace.jobs import plan_steps

    place = arguments.folder_for_results(out)
    console = new_console()
    steps = Steps(console)
    plan_steps.warm_up(steps)
    with steps.step("studying") as step:
        study.write_study(place, step)
    console.print(f"Open the study in a browser:\n{printable(str((place / 'study.html').resolve()))}", soft_wrap=True)
    return 0

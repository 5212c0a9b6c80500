"""The command `follow`: a plan followed live, as a component of LinuxCNC's HAL."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.text import Text

from toolpace.cli import options
from toolpace.cli.console import new_console
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time

LawFile = Annotated[str, Parameter(help="Law that Follower.save wrote.")]
Backlog = Annotated[
    str,
    Parameter(help="Lead of the rows over the servo thread; the delay in the law is this, drives and sensor."),
]
RecordFile = Annotated[str | None, Parameter(name="--record", help="Table (CSV) of the rows that are sent.")]
ComponentName = Annotated[str, Parameter(name="--name", help="Name of the component; its pins begin with it.")]
StreamerNumber = Annotated[int, Parameter(name="--streamer", help="Number of the streamer that takes the rows.")]
Watch = Annotated[bool, options.Switch, Parameter(help="Show it in a browser, at an address of this computer alone.")]
STREAMERS = 8
"""Most of them (streamer(9))."""


def follow_command(
    law: LawFile,
    /,
    *,
    backlog: Backlog = "20ms",
    record: RecordFile = None,
    name: ComponentName = "toolpace",
    streamer: StreamerNumber = 0,
    watch: Watch = False,
    machine: options.MachineName = None,
) -> int:
    """Follow a plan live as a component of LinuxCNC's HAL: at any pace, corrected by the pins deflection-x, -y and -z.

    LAW is the file that Follower.save wrote. The component is not realtime: it
    keeps the queue of HAL's streamer full, and the streamer gives one row to the
    joints in each servo period. A measurement therefore reaches the joints one
    backlog later. SIGTERM (unloadusr) or Ctrl-C ends the component, after a stop on
    the path within the limits.
    --watch shows it in a browser of this computer: joints, correction and use of
    the limits, and with --machine the machine as it moves. The follower never
    waits for the page. docs: from plan to machine.

    For example:

        toolpace follow part.law --backlog 10ms
        toolpace follow part.law --record given.csv
        toolpace follow part.law --watch --machine my-mill.toml
    """
    from toolpace.cli import arguments
    from toolpace.controls.hal import hal_module
    from toolpace.controls.hal_component import Component, Settings
    from toolpace.controls.live.view import LiveView
    from toolpace.deflection.following import Follower

    ahead = arguments.time_option("--backlog", backlog)
    if not 0 <= streamer < STREAMERS:
        raise UsageError(f"--streamer {streamer}: give 0 to {STREAMERS - 1}")
    if machine is not None and not watch:
        raise UsageError("--machine is what --watch shows; give both")
    on = None if machine is None else arguments.machine_named(machine, None)
    follower = Follower.load(law)
    settings = Settings(name, streamer, ahead, None if record is None else Path(record))
    console, module = new_console(), hal_module()
    with ExitStack() as ended:
        view = ended.enter_context(LiveView(follower, Path(law).name, on)) if watch else None
        component = Component(follower, module, settings, *([view.show] if view is not None else []))
        if view is not None:
            console.print(Text(f"watch it   {view.address}"), soft_wrap=True)
        console.print(f"{law}: {format_time(follower.duration)}, component {name} is ready", highlight=False)
        component.run()
    console.print(f"{component.rows.given} rows were sent, none too late", highlight=False)
    return 0

"""The option `--fit` of `time`: figures of a control from a log."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.text import Text

from toolpace.cli.steps import Steps, new_console
from toolpace.common.errors import UsageError, printable
from toolpace.common.units import format_time
from toolpace.jobs.timed import Asked

if TYPE_CHECKING:
    from toolpace.controls.timing.figures import ControlFigures
    from toolpace.controls.timing.identify import Identified
    from toolpace.programs.reading import Controller

POOR = 0.05
"""Share of the duration by which the model may be off on the way; beyond, another model fits better."""


def run_fit(programs: list[str], log: str, asked: Asked, write: str | None) -> int:
    """Find the figures from a log of one program, and print them. Raises ToolpaceError."""
    from toolpace.cli import arguments
    from toolpace.common.files import write_text
    from toolpace.controls.timing.identify import identify, load_log
    from toolpace.controls.timing.program_time import figures_for, moves_of
    from toolpace.programs.reading import Source
    from toolpace.programs.reading.languages import with_controller

    if len(programs) != 1:
        raise UsageError(f"--fit {log}: is the log of one program; give that program alone")
    target = arguments.file_for_result("--write-controller", write)
    source = Source.load(programs[0])
    options, found = with_controller(source, asked.dialect, asked.options)
    figures = figures_for(options, asked.model)
    if figures.model == "ideal":
        raise UsageError("--fit: the model ideal has no figures; choose --model linuxcnc, lookahead or fir")
    console = new_console()
    steps = Steps(console)
    with steps.step("reading", programs[0]) as step:
        moves = moves_of(source, asked.machine, options, asked.feed, asked.dialect)
        logged = load_log(log, asked.machine)
        step.note = f"{len(moves)} moves, {len(logged.q)} rows of the log"
    with steps.step("fitting"):
        identified = identify(moves, asked.machine, logged, figures)
    _say(steps, identified)
    text = controller_text(found.controller, identified.figures, target.stem if target is not None else "")
    if target is None:
        console.print(Text(text), soft_wrap=True)
    else:
        write_text(target, text)
        console.print(Text(printable(f"controller's file: {target}; give it with --controller")), soft_wrap=True)
    return 0


def _say(steps: Steps, found: Identified) -> None:
    steps.say(f"the log takes {format_time(found.logged)}, the model {format_time(found.modelled)}")
    steps.say(f"along the program they differ by {format_time(found.misfit)} (root mean square)")
    if found.misfit > POOR * found.logged:
        steps.say("that is a lot: is it the log of this program? Does another --model fit better?")


def controller_text(controller: Controller | None, figures: ControlFigures, name: str) -> str:
    """The text of a controller's file that is like another, with these figures."""
    import msgspec

    from toolpace.common.files.toml import toml_text

    given = msgspec.to_builtins(figures)
    usual = msgspec.to_builtins(type(figures)())
    time = {key: value for key, value in given.items() if key == "model" or value != usual[key]}
    head: dict[str, object] = {} if controller is None else {"name": name or f"my-{controller.name}"}
    if controller is not None:
        base = controller.like or controller.name
        head["like"] = base if base in controller.names() else ""
    return toml_text(head | {"time": {key: _rounded(value) for key, value in time.items()}})


def _rounded(value: object) -> object:
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    return float(f"{value:.5g}") if isinstance(value, float) else value

"""The command `machines`: the machines that there are, and one from the files of its control."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from rich.text import Text

from toolpace.cli import options
from toolpace.cli.console import new_console
from toolpace.common.errors import UsageError, printable

if TYPE_CHECKING:
    from rich.console import Console

    from toolpace.machine.from_control import MachineDraft
    from toolpace.machine.from_control.stand_ins import Question

FromFiles = Annotated[
    list[str] | None,
    Parameter(
        name="--from",
        consume_multiple=True,
        help="Files of a machine's control, from which to make a machine: of LinuxCNC its INI, of a Fanuc the"
        " parameters as punched, of a Sinumerik machine data and swivel data as text, of a Heidenhain machine"
        " parameters and kinematics. Files that an INI names are found beside it, or given too.",
    ),
]
WriteMachine = Annotated[
    str | None, Parameter(name="--write", help="With --from: write the machine to this file (.toml).")
]
WriteController = Annotated[
    str | None,
    Parameter(
        name="--write-controller",
        help="With --from: write the figures by which the control moves to this file (.toml), for --controller.",
    ),
]


def machines_command(
    name: options.OneMachine = None,
    /,
    *,
    toml: options.Toml = False,
    poses: options.Poses = False,
    from_files: FromFiles = None,
    write: WriteMachine = None,
    write_controller: WriteController = None,
) -> int:
    """List the built-in machines with their class, travel and limits; or make a machine from its control's files.

    Start your own machine file from the files of its control, or from a built-in
    machine. Before the first program runs, drive the real machine to a few of the
    poses and compare: a wrong sign or order shows in the tool axis, a wrong point in
    the tip.

    For example:

        toolpace machines
        toolpace machines --from my-mill.ini --write my-mill.toml
        toolpace machines xyzac-trunnion --toml > my-mill.toml
        toolpace machines my-mill.toml --poses
    """
    from toolpace.cli import arguments, summary
    from toolpace.machine.machine import Machine

    console = new_console()
    if from_files is not None:
        if name is not None:
            raise UsageError(f"machine {name[:40]} and --from: give one of both")
        return _from_control(console, from_files, toml, poses, write, write_controller)
    for option, place in (("--write", write), ("--write-controller", write_controller)):
        if place is not None:
            raise UsageError(f"{option} goes with --from FILE...: what it writes is made from a control's files")
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


def _from_control(
    console: Console, files: list[str], toml: bool, poses: bool, write: str | None, write_controller: str | None
) -> int:
    """Show the machine that the files tell, or write it, and the controller."""
    from toolpace.cli import arguments, summary
    from toolpace.common.files import write_text
    from toolpace.machine.from_control import read_control
    from toolpace.machine.from_control.stand_ins import Answers

    if toml and poses:
        raise UsageError("--toml and --poses: one at a time, so that what is printed by --toml is a machine file")
    place = arguments.file_for_result("--write", write)
    controller_place = arguments.file_for_result("--write-controller", write_controller)
    at_terminal = place is not None and sys.stdin.isatty() and sys.stdout.isatty()
    draft = read_control([Path(file) for file in files], Answers(_ask if at_terminal else None))
    if controller_place is not None and not draft.controller:
        raise UsageError(f"--write-controller: files of {draft.record.control} have no figures that a model here takes")
    if place is not None:
        write_text(place, draft.text)
    if controller_place is not None:
        write_text(controller_place, draft.controller)
    if toml:
        print(draft.text, end="")
        return 0
    if poses:
        summary.show_poses(console, draft.machine)
    else:
        summary.show_machine(console, draft.machine)
    _show_notes(console, draft)
    if place is not None:
        shown = printable(str(place))
        line = f"   {shown}: compare it with the real machine, `toolpace machines {shown} --poses`"
        console.print(Text.assemble(("written", "dim"), line), soft_wrap=True)
    if controller_place is not None:
        line = f"   {printable(str(controller_place))}: give it with --controller"
        console.print(Text.assemble(("written", "dim"), line), soft_wrap=True)
    return 0


def _ask(question: Question) -> str:
    """What a person types for what is missing; nothing, and the end of input, are the stand-in."""
    if question.complaint:
        print(printable(question.complaint))
    print(f"{printable(question.what)}\n  [{question.stand_in}: {printable(question.reason)}] ", end="", flush=True)
    return sys.stdin.readline()


def _show_notes(console: Console, draft: MachineDraft) -> None:
    """Stand-ins first, which a person has to look at; then what else should be known."""
    for each in draft.stand_ins:
        line = f"   {each.what}: not in these files; {each.stand_in} is taken, {each.reason}"
        console.print(Text.assemble(("stand-in", "yellow"), printable(line)), soft_wrap=True)
    for remark in draft.record.remarks:
        console.print(Text.assemble(("note", "dim"), f"   {printable(remark)}"), soft_wrap=True)
    for name, figure in draft.record.control_figures.items():
        line = printable(f"   {name} = {figure.words} ({figure.origin})")
        console.print(Text.assemble(("control", "dim"), line), soft_wrap=True)

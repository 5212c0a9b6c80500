"""Readers: from programs, cutter-location data and tables of points to tool paths."""

from __future__ import annotations

import dataclasses
import gc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.controllers.recognise import doubts
from toolpace.programs.reading.controllers.tool_rules import with_rules
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.feeds import FeedChange, apply_feed, with_doubt_of_slow_feeds
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.languages import CONTROLS, Recognised, reader_of, recognised
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source, numbered_blocks
from toolpace.programs.toolpath import ToolPath

__all__ = [
    "Controller", "Findings", "Kinematics", "ReadOptions", "SetUp", "Source", "apply_feed", "read", "read_commanded",
    "read_source", "read_text",
]  # fmt: skip


def read(
    path: str | Path,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    *,
    feed: str | None = None,
    block_delete: bool = True,
    controller: str | Path | Controller | None = None,
    setup: str | Path | SetUp | None = None,
    skip_unknown: bool = False,
    compensation: str = "",
    max_blocks: int | None = None,
    lenient: bool = False,
    columns: str = "",
    units: str = "",
) -> ToolPath:
    """Read a program.

    path: a file, a pipe, or `-` for standard input; it is read once, from its beginning to its end.
    machine: needed by G-code with rotary words. Outside tool-centre-point mode axis words are joint positions;
        without a machine they are the tip, under the tool axis +z.
    dialect: `gcode` (any program for a controller), `apt` or `csv`; None tells it by the file's name and content.
    feed: `none`, a factor such as `120%`, or a value such as `3000mm/min` in place of the program's feeds.
    block_delete: whether blocks that begin with `/` are passed over.
    controller: name of a built-in controller or a file (TOML); None tells it by the program's content.
    setup: set-up sheet (TOML file) with offsets, references and tools; None takes the one in the machine file, if any.
        Where it tells how the part is clamped, the machine must be mounted so: `machine.mounted(**setup.part)`.
    skip_unknown: whether words that are not read are passed over, and said in `ToolPath.assumed`.
    compensation: `program` where under G41, G42, RL and RR the tool's centre follows the programmed contour; else the
        radius is that of the set-up sheet's tool.
    max_blocks: most blocks that may be executed; more is taken for a loop without end.
    lenient: whether blocks at which the control itself would stop are read where their meaning is certain (a file
        without M2, a word twice), and said in `ToolPath.assumed`.
    columns: names of the columns of a table without a header, or in place of it: `x,y,z,i,j,k`.
    units: unit of the lengths of a table whose header names none: `mm`; feeds are in it per minute, dwells in seconds.

    The path starts where the program first has every axis positioned: where the machine stands before is
    unknown. Rotary joints that are not named by then are at zero. Raises ProgramError with file, line, text and cure.
    """
    options = ReadOptions.of(
        machine, controller, setup, skip_unknown, block_delete, compensation, max_blocks, lenient, columns, units
    )
    return read_source(Source.load(path), machine, dialect, options, feed=feed)


def read_text(
    text: str,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    *,
    feed: str | None = None,
    block_delete: bool = True,
    controller: str | Path | Controller | None = None,
    setup: str | Path | SetUp | None = None,
    skip_unknown: bool = False,
    compensation: str = "",
    max_blocks: int | None = None,
    lenient: bool = False,
    columns: str = "",
    units: str = "",
    name: str = "program",
) -> ToolPath:
    """Read a program from its text; as `read`, with `name` in messages."""
    options = ReadOptions.of(
        machine, controller, setup, skip_unknown, block_delete, compensation, max_blocks, lenient, columns, units
    )
    return read_source(Source.from_text(text, name), machine, dialect, options, feed=feed)


def read_source(
    source: Source,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    options: ReadOptions | None = None,
    *,
    feed: str | None = None,
    findings: Findings | None = None,
) -> ToolPath:
    """Read a program that was loaded before: its bytes can be kept as they were read; as `read`.

    findings: collects what the reader comes upon, also where it ends with an error.
    """
    change = None if feed is None else FeedChange.parse(feed)
    options = dataclasses.replace(options or ReadOptions(), default_feed=None if change is None else change.speed)
    options.check(machine)
    findings = Findings() if findings is None else findings
    found = recognised(source, dialect, options)
    with _without_garbage_collection():
        toolpath = _run(found, source, machine, options, findings)
        said = _doubts(found, source, machine, options, toolpath, findings)
        for sentence in said:
            findings.assumed(sentence)
        # first, since a summary shows a dozen
        toolpath = dataclasses.replace(toolpath, assumed=(*said, *toolpath.assumed))
    return with_doubt_of_slow_feeds(toolpath) if change is None else change.apply(toolpath)


def read_commanded(
    source: Source,
    machine: Kinematics | None = None,
    dialect: str | None = None,
    options: ReadOptions | None = None,
    *,
    findings: Findings | None = None,
) -> Commanded:
    """The moves that a program commands, as its control sees them; arguments as of `read_source`.

    Raises UsageError for cutter-location data and tables, which are for no control.
    """
    options = options or ReadOptions()
    options.check(machine)
    found = recognised(source, dialect, options)
    if found.controller is None:
        raise UsageError(
            f"{source.name} is {found.dialect}, and for no control: what a control makes of it begins with the "
            "program that a post-processor writes from it"
        )
    findings = Findings() if findings is None else findings
    with _without_garbage_collection():
        control = reader_of(source, machine, found.controller, options, findings).executed()
        commanded = control.commanded()
        if found.others and len(commanded) > 1:
            for sentence in _doubts(found, source, machine, options, control.toolpath(), findings):
                findings.assumed(sentence)
        return commanded


def _doubts(
    found: Recognised,
    source: Source,
    machine: Kinematics | None,
    options: ReadOptions,
    toolpath: ToolPath,
    findings: Findings,
) -> tuple[str, ...]:
    """Sentences on what the other controls, that a program may be for, would read otherwise than it was read."""
    if not found.others:
        return ()
    refused = {refusal.word for refusal in findings.refusals}
    lenient = dataclasses.replace(options, skip_unknown=True)

    def as_for(controller: Controller, program: Source) -> ToolPath | None:
        own = Findings()
        read = _run(dataclasses.replace(found, controller=controller), program, machine, lenient, own)
        # where a control only stops, it has moved till then
        unread = {refusal.word for refusal in own.refusals if not refusal.certain}
        return read if unread <= refused else None

    assert found.controller is not None
    return doubts(toolpath, found.controller, source, found.others, as_for)


def _run(
    found: Recognised, source: Source, machine: Kinematics | None, options: ReadOptions, findings: Findings
) -> ToolPath:
    if found.dialect == CONTROLS:
        assert found.controller is not None
        toolpath = reader_of(source, machine, found.controller, options, findings).executed().toolpath()
        operations = with_rules(toolpath.operations, found.controller.tools, source.lines, source.name)
        return dataclasses.replace(toolpath, numbered=numbered_blocks(source), operations=operations)
    if found.dialect == "cldata":
        from toolpace.programs.reading.cldata.reader import ClReader

        return ClReader(source, machine, options, findings).run()
    from toolpace.programs.reading.points import ToolLengths
    from toolpace.programs.reading.table import read_table

    lengths = ToolLengths(source, options.setup, machine, findings)
    return read_table(source, lengths, options)


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Reading makes millions of moves and no cycles of objects; the collector would go through them again and again."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()

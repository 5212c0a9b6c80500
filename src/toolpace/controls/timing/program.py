"""From a program to its time on a control, in one call."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.common.errors import UsageError
from toolpace.controls.timing.feed_override import refed
from toolpace.controls.timing.figures import ControlFigures, figures_of
from toolpace.controls.timing.points import moves_of_points
from toolpace.controls.timing.program_time import ProgramTime, time_of_moves
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import Findings, ReadOptions, Source, read_commanded, read_source
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.feeds import FeedChange
from toolpace.programs.reading.languages import with_controller

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import Controller


def program_time(
    program: str | Path,
    machine: Machine,
    *,
    controller: str | Path | Controller | None = None,
    model: str | None = None,
    feed: str | None = None,
    setup: str | Path | SetUp | None = None,
    dialect: str | None = None,
) -> ProgramTime:
    """How long a program takes on a control as it is written, without a plan.

    controller: a built-in controller or a file (TOML), whose table [time] describes how it goes through blocks; None
        tells it by the program's content. model: `linuxcnc`, `lookahead` or `fir`, in place of what the file says.
    feed, setup, dialect: as of `read`. Cutter-location data are timed as a post would write them, tool-centre-point
        mode on.

    Raises ProgramError, UsageError, ReachError. What the fastest motion takes is `plan(path, machine).duration`.
    """
    source = Source.load(program)
    options, _ = with_controller(source, dialect, ReadOptions.of(machine, controller, setup))
    figures = figures_for(options, model)
    if figures.model == "ideal":
        raise UsageError("the model ideal is the fastest motion: its time is plan(path, machine).duration")
    moves = moves_of(source, machine, options, feed, dialect)
    return time_of_moves(moves, machine, figures, options.setup.tool_change)


def figures_for(options: ReadOptions, model: str | None) -> ControlFigures:
    """The figures of the controller that a program is read for. Raises UsageError."""
    controller = options.controller
    if controller is None:
        return figures_of({}, "", model)
    return figures_of(controller.time, controller.source or controller.name, model)


def moves_of(
    source: Source,
    machine: Machine,
    options: ReadOptions,
    feed: str | None = None,
    dialect: str | None = None,
    findings: Findings | None = None,
) -> Commanded:
    """The moves of a program; those of points where it is for no control. Raises ToolpaceError."""
    if options.controller is None:
        toolpath = read_source(source, machine, dialect, options, feed=feed, findings=findings)
        return moves_of_points(toolpath, machine)
    change = None if feed is None else FeedChange.parse(feed)
    default = None if change is None else change.speed
    reading = dataclasses.replace(options, default_feed=default)
    moves = read_commanded(source, machine, dialect, reading, findings=findings)
    return moves if change is None else refed(moves, change)

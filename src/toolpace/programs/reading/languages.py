"""The controller of a program, and the reader of its language."""

from __future__ import annotations

import dataclasses
import importlib
from dataclasses import dataclass
from typing import Protocol

from toolpace.common.errors import ProgramError, UsageError
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers import din_iso
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.dialect import CONTROLS, Told, dialect_of
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

READERS = {
    "word-address": ("toolpace.programs.reading.gcode.reader", "WordAddressReader"),
    "sinumerik": ("toolpace.programs.reading.sinumerik.reader", "SinumerikReader"),
    "heidenhain": ("toolpace.programs.reading.heidenhain.reader", "HeidenhainReader"),
}
"""Language to the module and the class that read it; a module is imported when a program is in its language."""


class Reader(Protocol):
    """One reading of one program."""

    def executed(self) -> Control:
        """The control, with all of it executed. Raises ProgramError."""


@dataclass(frozen=True)
class Recognised:
    """What a program is, and why it is taken for that."""

    dialect: str
    """`gcode`, `cldata` or `csv`; gcode is every language of controllers."""
    controller: Controller | None
    """None for cutter-location data and tables, which are for no controller."""
    reason: str
    others: tuple[Controller, ...] = ()
    """Controllers that it may be for as well."""


def recognised(source: Source, dialect: str | None, options: ReadOptions) -> Recognised:
    """What a program is: as named, else by its content. Raises ProgramError, UsageError."""
    if options.columns or options.units:
        return _table(source, dialect, options)
    din_iso.refuse(source)
    if options.controller is not None:
        told = dialect_of(source, dialect or CONTROLS)
        if told.dialect != CONTROLS:
            raise UsageError(
                f"--controller {options.controller.name} goes with programs for controllers, and --dialect {dialect} "
                "is none: leave one of them out"
            )
        return Recognised(CONTROLS, options.controller, "named", options.others)
    told = dialect_of(source, dialect)
    if told.dialect != CONTROLS:
        return Recognised(told.dialect, None, told.reason)
    from toolpace.programs.reading.controllers.recognise import recognise

    controller, reason, others = recognise(source)
    return Recognised(CONTROLS, controller, reason, others)


def _table(source: Source, dialect: str | None, options: ReadOptions) -> Recognised:
    """A table of which the options tell what its header does not. Raises UsageError where it is none."""
    named, what = "--columns" if options.columns else "--units", ""
    try:
        told = dialect_of(source, dialect)
    except ProgramError:
        # rows of numbers alone cannot be told from anything
        if not options.columns:
            raise
        told = Told("csv", "its columns are given")
    if options.controller is not None:
        what = f"for {options.controller.name}"
    elif told.dialect != "csv":
        what = told.dialect
    if what:
        cure = "leave it out, or give --dialect csv"
        raise UsageError(f"{named} is of a table (csv), and {source.name} is {what}: {cure}")
    return Recognised("csv", None, told.reason)


def reader_of(
    source: Source, machine: Kinematics | None, controller: Controller, options: ReadOptions, findings: Findings
) -> Reader:
    """The reader of a program for a controller. Raises UsageError where its language has none."""
    module, name = READERS[controller.language]
    try:
        reader = getattr(importlib.import_module(module), name)
    except ModuleNotFoundError:
        raise UsageError(
            f"controller {controller.name}: its language '{controller.language}' is not read yet"
        ) from None
    made: Reader = reader(source, machine, controller, options, findings)
    return made


def with_controller(source: Source, dialect: str | None, options: ReadOptions) -> tuple[ReadOptions, Recognised]:
    """The options with the controller that the program is read for, and what it was taken for."""
    found = recognised(source, dialect, options)
    return dataclasses.replace(options, controller=found.controller, others=found.others), found

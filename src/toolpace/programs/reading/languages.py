"""The language of a program and its reader, from the program's name and content."""

from __future__ import annotations

import dataclasses
import importlib
import re
from dataclasses import dataclass
from pathlib import PurePath
from typing import Protocol

from toolpace.common.errors import ProgramError, UsageError, printable
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

DIALECTS = {
    "gcode": "gcode",
    "ngc": "gcode",
    "cldata": "cldata",
    "apt": "cldata",
    "cls": "cldata",
    "csv": "csv",
    "table": "csv",
}
SUFFIXES = {
    **dict.fromkeys((".ngc", ".nc", ".gcode", ".gc", ".g", ".tap", ".cnc", ".eia", ".ncc", ".din", ".iso"), "gcode"),
    **dict.fromkeys((".mpf", ".spf", ".h", ".ptp", ".min"), "gcode"),
    **dict.fromkeys((".apt", ".cls", ".cl", ".clsf", ".cldata", ".aptsource", ".ncl"), "cldata"),
    **dict.fromkeys((".csv", ".tsv"), "csv"),
}
# Blanks within a line only, and none given back: blank lines would else be gone through from every line again.
_BLANK = r"[^\S\n]*+"
_CLDATA = re.compile(
    rf"^{_BLANK}(?:(?:GOTO|TOOL PATH|FEDRAT){_BLANK}/|PARTNO|RAPID{_BLANK}$|MULTAX|\$\$)", re.IGNORECASE | re.MULTILINE
)
_TABLE = re.compile(
    rf"^{_BLANK}\"?x(?:{_BLANK}(?:[\[(]{_BLANK}[a-z]++{_BLANK}[\])]|[,;])|[^\S\n\t]*+\t)", re.IGNORECASE | re.MULTILINE
)
"""A header; X[ alone begins a value of many controls."""
_GCODE = re.compile(
    rf"^{_BLANK}(?:%|/?(?:N{_BLANK}[0-9]++{_BLANK})?[GM][ \t]*+[0-9]|O[0-9]++\b)", re.IGNORECASE | re.MULTILINE
)
_CONVERSATIONAL = re.compile(
    rf"^{_BLANK}(?:N?[0-9]++{_BLANK}(?<=\s))?(?:BEGIN PGM\b|L{_BLANK}(?<=\s)I?[XYZ]|TOOL CALL\b)",
    re.IGNORECASE | re.MULTILINE,
)
_OSP = re.compile(r"\s*+\$[A-Z0-9_-]++(?:\.[A-Z]{3})?%", re.IGNORECASE)
"""The header of a program for Okuma's controls."""
OSP = (
    "to which words mean other things (G15 H is a work offset, G56 H the length of the tool), and which is not read: "
    "let the CAM system write for Fanuc"
)
"""Why no program for them is read, and the cure."""
HEAD = 200
"""Lines by which a program without a known suffix is told."""
CONTROLS = "gcode"
"""The dialect of all programs for controllers, of whatever language."""
READERS = {
    "word-address": ("toolpace.programs.reading.gcode.reader", "WordAddressReader"),
    "sinumerik": ("toolpace.programs.reading.sinumerik.reader", "SinumerikReader"),
    "heidenhain": ("toolpace.programs.reading.heidenhain.reader", "HeidenhainReader"),
}
"""Language to the module and the class that read it; a module is imported when a program is in its language."""
_DIN_ISO = re.compile(r"%\s*\S.*\sG7[01]\s*\*?", re.IGNORECASE)


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


def dialect_of(source: Source, wanted: str | None = None) -> Recognised:
    """The dialect: as wanted, else by the file's suffix, else by its first lines. Raises ProgramError, UsageError."""
    if wanted is not None:
        if wanted.lower() not in DIALECTS:
            raise UsageError(f"dialect '{wanted}' is not known: use gcode, apt or csv")
        return Recognised(DIALECTS[wanted.lower()], None, "named")
    head = "\n".join(source.lines[:HEAD])
    if _OSP.match(head):
        source.fail(f"this header is of Okuma's OSP, {OSP}", 1)
    if is_conversational(source):
        return Recognised(CONTROLS, None, "it has blocks of Heidenhain conversational code")
    suffix = PurePath(source.name).suffix.lower()
    if suffix in SUFFIXES:
        return Recognised(SUFFIXES[suffix], None, f"its name ends in {suffix}")
    for dialect, pattern in (("cldata", _CLDATA), ("csv", _TABLE), (CONTROLS, _GCODE)):
        if found := pattern.search(head):
            line = head[: found.end()].rpartition("\n")[2].strip()
            return Recognised(dialect, None, f"it has lines like '{printable(line[:30])}'")
    source.fail(
        "neither a program for a controller nor APT, CLSF or CSV can be recognised here: name it with --dialect gcode, "
        "apt or csv",
        0,
    )


def is_conversational(source: Source) -> bool:
    """Whether the first lines are Heidenhain conversational code."""
    return _CONVERSATIONAL.search("\n".join(source.lines[:HEAD])) is not None


class Reader(Protocol):
    """One reading of one program."""

    def executed(self) -> Control:
        """The control, with all of it executed. Raises ProgramError."""


def recognised(source: Source, dialect: str | None, options: ReadOptions) -> Recognised:
    """What a program is: as named, else by its content. Raises ProgramError, UsageError."""
    if options.columns or options.units:
        return _table(source, dialect, options)
    _refuse_din_iso(source)
    if options.controller is not None:
        found = dialect_of(source, dialect or CONTROLS)
        if found.dialect != CONTROLS:
            raise UsageError(
                f"--controller {options.controller.name} goes with programs for controllers, and --dialect {dialect} "
                "is none: leave one of them out"
            )
        return Recognised(CONTROLS, options.controller, "named", options.others)
    found = dialect_of(source, dialect)
    if found.dialect != CONTROLS:
        return found
    from toolpace.programs.reading.controllers.recognise import recognise

    controller, reason, others = recognise(source)
    return Recognised(CONTROLS, controller, reason, others)


def _table(source: Source, dialect: str | None, options: ReadOptions) -> Recognised:
    """A table of which the options tell what its header does not. Raises UsageError where it is none."""
    named, what = "--columns" if options.columns else "--units", ""
    try:
        found = dialect_of(source, dialect)
    except ProgramError:
        # rows of numbers alone cannot be told from anything
        if not options.columns:
            raise
        found = Recognised("csv", None, "its columns are given")
    if options.controller is not None:
        what = f"for {options.controller.name}"
    elif found.dialect != "csv":
        what = found.dialect
    if what:
        cure = "leave it out, or give --dialect csv"
        raise UsageError(f"{named} is of a table (csv), and {source.name} is {what}: {cure}")
    return found


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


def _refuse_din_iso(source: Source) -> None:
    """Raise ProgramError where the program is DIN/ISO for Heidenhain's controls: it begins like %NAME G71 *.

    G54 shifts the datum by X, Y, Z, G28 mirrors, G72 scales, G73 turns, G79 calls a cycle, G83 drills ("TNC 640 DIN/ISO
    Programming"): read as the words of another control they would move elsewhere.
    """
    for number, line in enumerate(source.lines, start=1):
        if line.strip():
            if _DIN_ISO.fullmatch(line.strip()):
                source.fail(
                    "the program is DIN/ISO for Heidenhain's controls (%NAME G71), which is not read: there G54 "
                    "shifts, G28 mirrors and G73 turns; post it as Klartext (.H)",
                    number,
                )
            return

"""The dialect of a program, from its name and content."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import NamedTuple

from toolpace.common.errors import UsageError, printable
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


class Told(NamedTuple):
    """What a program is written in, and why it is taken for that."""

    dialect: str
    """`gcode`, `cldata` or `csv`."""
    reason: str


def dialect_of(source: Source, wanted: str | None = None) -> Told:
    """The dialect: as wanted, else by the file's suffix, else by its first lines. Raises ProgramError, UsageError."""
    if wanted is not None:
        if wanted.lower() not in DIALECTS:
            raise UsageError(f"dialect '{wanted}' is not known: use gcode, apt or csv")
        return Told(DIALECTS[wanted.lower()], "named")
    head = "\n".join(source.lines[:HEAD])
    if _OSP.match(head):
        source.fail(
            f"this header is of Okuma's OSP, {OSP}",
            1,
        )
    if is_conversational(source):
        return Told(CONTROLS, "it has blocks of Heidenhain conversational code")
    suffix = PurePath(source.name).suffix.lower()
    if suffix in SUFFIXES:
        return Told(SUFFIXES[suffix], f"its name ends in {suffix}")
    for dialect, pattern in (("cldata", _CLDATA), ("csv", _TABLE), (CONTROLS, _GCODE)):
        if found := pattern.search(head):
            line = head[: found.end()].rpartition("\n")[2].strip()
            return Told(dialect, f"it has lines like '{printable(line[:30])}'")
    source.fail(
        "neither a program for a controller nor APT, CLSF or CSV can be recognised here: name it with --dialect gcode, "
        "apt or csv",
        0,
    )


def is_conversational(source: Source) -> bool:
    """Whether the first lines are Heidenhain conversational code."""
    return _CONVERSATIONAL.search("\n".join(source.lines[:HEAD])) is not None

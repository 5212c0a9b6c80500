"""Tells by name and content which dialect a program is written in."""

from __future__ import annotations

import re
from pathlib import PurePath

from toolpace.errors import UsageError
from toolpace.reading.source import Source

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
    **dict.fromkeys((".apt", ".cls", ".cl", ".clsf", ".cldata", ".aptsource", ".ncl"), "cldata"),
    **dict.fromkeys((".csv", ".tsv"), "csv"),
}
# Blanks within a line only, and none given back: blank lines would else be gone through from every line again.
_BLANK = r"[^\S\n]*+"
_CLDATA = re.compile(
    rf"^{_BLANK}(?:(?:GOTO|TOOL PATH|FEDRAT){_BLANK}/|PARTNO|RAPID{_BLANK}$|MULTAX|\$\$)", re.IGNORECASE | re.MULTILINE
)
_TABLE = re.compile(rf"^{_BLANK}\"?x(?:{_BLANK}[\[(,;]|[^\S\n\t]*+\t)", re.IGNORECASE | re.MULTILINE)
_GCODE = re.compile(
    rf"^{_BLANK}(?:%|/?(?:N{_BLANK}[0-9]++{_BLANK})?[GM][ \t]*+[0-9]|O[0-9]++\b)", re.IGNORECASE | re.MULTILINE
)
_CONVERSATIONAL = re.compile(
    rf"^{_BLANK}[0-9]++{_BLANK}(?<=\s)(?:BEGIN PGM|L{_BLANK}(?<=\s)[XYZ]|TOOL CALL)", re.IGNORECASE | re.MULTILINE
)
HEAD = 200
"""Lines by which a program without a known suffix is told."""


def dialect_of(source: Source, wanted: str | None = None) -> str:
    """`gcode`, `cldata` or `csv`: as wanted, else by the file's suffix, else by its first lines."""
    if wanted is not None:
        if wanted.lower() not in DIALECTS:
            raise UsageError(f"dialect '{wanted}' is not known: use gcode, apt or csv")
        return DIALECTS[wanted.lower()]
    head = "\n".join(source.lines[:HEAD])
    if _CONVERSATIONAL.search(head):
        source.fail(
            "this looks like Heidenhain conversational code, which is not read: "
            "export G-code (ISO), APT or CLSF from the CAM system",
            0,
        )
    by_name = SUFFIXES.get(PurePath(source.name).suffix.lower())
    if by_name is not None:
        return by_name
    for dialect, pattern in (("cldata", _CLDATA), ("csv", _TABLE), ("gcode", _GCODE)):
        if pattern.search(head):
            return dialect
    source.fail(
        "neither G-code nor APT, CLSF or CSV can be recognised here: name it with --dialect gcode, apt or csv",
        0,
    )

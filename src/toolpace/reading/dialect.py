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
_CLDATA = re.compile(
    r"^\s*(?:GOTO\s*/|TOOL PATH\s*/|PARTNO|FEDRAT\s*/|RAPID\s*$|MULTAX|\$\$)", re.IGNORECASE | re.MULTILINE
)
_TABLE = re.compile(r"^\s*\"?x\s*[\[(,;\t]", re.IGNORECASE | re.MULTILINE)
_GCODE = re.compile(r"^\s*(?:%|/?(?:N\s*[0-9]+\s*)?[GM][ \t]*[0-9]|O[0-9]+\b)", re.IGNORECASE | re.MULTILINE)
_CONVERSATIONAL = re.compile(r"^\s*[0-9]+\s+(?:BEGIN PGM|L\s+[XYZ]|TOOL CALL)", re.IGNORECASE | re.MULTILINE)
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

"""Programs in DIN/ISO for Heidenhain's controls: other words than those of all other controls, and not read."""

from __future__ import annotations

import re

from toolpace.programs.reading.source import Source

_BEGINNING = re.compile(r"%\s*\S.*\sG7[01]\s*\*?", re.IGNORECASE)


def refuse(source: Source) -> None:
    """Raise ProgramError where the program is one: it begins with its name and its unit (%NAME G71 *).

    G54 shifts the datum by X, Y, Z, G28 mirrors, G72 scales, G73 turns, G79 calls a cycle, G83 drills ("TNC 640 DIN/ISO
    Programming"): read as the words of another control they would move elsewhere.
    """
    for number, line in enumerate(source.lines, start=1):
        if line.strip():
            if _BEGINNING.fullmatch(line.strip()):
                source.fail(
                    "the program is DIN/ISO for Heidenhain's controls (%NAME G71), which is not read: there G54 "
                    "shifts, G28 mirrors and G73 turns; post it as Klartext (.H)",
                    number,
                )
            return

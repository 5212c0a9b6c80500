"""Operations and tools of cutter-location data."""

from __future__ import annotations

import re

from toolpace.programs.reading.cldata.motion import ClMotion
from toolpace.programs.reading.cldata.words import NUMBER, Statement
from toolpace.programs.reading.coordinates.tool_lengths import ToolLengths
from toolpace.programs.toolpath import Operation

_NAME = re.compile(r"OPERATION NAME\s*+:(.*)", re.IGNORECASE)
CHANGE = "a tool change is a stop; the machine's own motion in it is left out"


class ClOperations:
    """TOOL PATH and LOADTL, and what NX, Creo and CATIA write in their place."""

    def __init__(self, motion: ClMotion, lengths: ToolLengths) -> None:
        self.motion, self.track, self.lengths = motion, motion.track, lengths
        self._tool_named = False
        """Whether TOOL PATH named the tool: a number that is loaded then is the same tool's."""
        self._loaded = ""

    def tool_path(self, statement: Statement) -> None:
        """TOOL PATH/name,TOOL,tool: begins an operation, and stops where it takes another tool."""
        words = [word.strip() for word in statement.text.split(",")]
        at = next((i for i, word in enumerate(words) if word.upper() == "TOOL"), len(words))
        name, tool = ",".join(words[:at]), ",".join(words[at + 1 :])
        if tool != self.track.operation.tool and self.track.points:
            self.motion.findings.assumed(CHANGE)
            self.track.stop()
        self._tool_named, self._loaded = tool != "", ""
        self.motion.begin_operation()
        self.motion.frame.centre_line = False
        self.track.begin(Operation(name, tool), always=True)

    def load(self, statement: Statement) -> None:
        """LOADTL/3, LOAD/TOOL,3: the tool of what follows; the stop is the reader's."""
        words = [word for word in statement.minors if word != "TOOL"]
        tool = next((word for word in words if NUMBER.fullmatch(word)), words[0] if words else "")
        changed, self._loaded = tool != self._loaded, tool
        if not tool or not changed:
            return
        current, begins = self.track.operation, self.track.begins
        if not begins:
            self.motion.findings.assumed(CHANGE)
            self.motion.drilling.end()
            self._tool_named = False
        if not self._tool_named or (self.lengths.lists(tool) and not self.lengths.lists(current.tool)):
            self.track.begin(Operation(current.name, tool))

    def feature(self, statement: Statement) -> None:
        """`$$-> FEATNO / 31` of Creo: a sequence of its own."""
        self._named(f"FEATNO {statement.text.strip()}")

    def note(self, statement: Statement) -> None:
        """`$$ OPERATION NAME : drilling` of CATIA."""
        match = _NAME.match(statement.text)
        if match is not None:
            self._named(match[1].strip())

    def _named(self, name: str) -> None:
        self.track.begin(Operation(name, self.track.operation.tool))

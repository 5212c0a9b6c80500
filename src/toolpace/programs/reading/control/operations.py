"""The named operations of a program, with their tools."""

from __future__ import annotations

from dataclasses import replace

from toolpace.programs.reading.control.moves import Moves
from toolpace.programs.toolpath import Operation


class Operations:
    """What motions belong to: each is noted with the operation that is the last when it is added."""

    def __init__(self, moves: Moves) -> None:
        self.moves = moves
        self.all: list[Operation] = [Operation()]

    def begin(self, *, name: str | None = None, tool: str | None = None) -> None:
        """Begin the next one, of this name, or with this tool; what is not given stays."""
        last = self.all[-1]
        if not self._moved():
            self.all.pop()
        told = last.told_lengths if tool is None else ()
        self.all.append(
            Operation(last.name if name is None else name.strip(), last.tool if tool is None else tool, told)
        )
        self.moves.operation = len(self.all) - 1

    def tell_length(self, length: float) -> None:
        """The tool of the present one is reckoned with another length than its table's [m]."""
        last = self.all[-1]
        if length not in last.told_lengths:
            self.all[-1] = replace(last, told_lengths=(*last.told_lengths, length))

    def _moved(self) -> bool:
        """Whether there was any motion in the last one."""
        return bool(self.moves.rows) and self.moves.rows[-1][-2] >= self.moves.operation

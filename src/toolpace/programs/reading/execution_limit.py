"""The limit of executed blocks, beyond which a program counts as endless."""

from __future__ import annotations

from collections.abc import Callable

from toolpace.common.errors import ProgramError
from toolpace.programs.reading.source import Source

REPEATED = 400_000
"""Steps beyond which a short program runs in a loop: a few seconds of reading."""
A_LINE, MOST_REPEATED = 100, 4_000_000
"""Of a longer one so many for each of its lines, and at most: subprograms are called for each part on a table."""
ONCE = 30
"""Steps that a line may take which is executed once: its block, its motions, and a change."""
CHANGED = 20
"""Steps that a change of frames, offsets or modes takes, or a spline, by the time that it needs."""


class EndlessError(ProgramError):
    """A program that has been executed for longer than its length explains."""


class Effort:
    """Counts blocks, and steps by the time that they take to read."""

    def __init__(self, source: Source, most_blocks: int | None) -> None:
        self.source, self.most_blocks = source, most_blocks
        self.blocks = 0
        """Blocks that were executed, those of loops and calls each time."""
        self.changes = 0
        """Of frames, offsets and modes, and splines."""
        self.lines_beside: Callable[[], int] = lambda: 0
        """Lines of the files that the program calls."""
        self.enough = _enough(len(source.lines))

    def block(self, line: int, motions: int) -> None:
        """A block more is executed, with so many motions noted before it. Raises EndlessError."""
        self.blocks += 1
        if self.most_blocks is not None:
            if self.blocks > self.most_blocks:
                self._fail(f"more than {self.most_blocks} blocks have been executed", line)
        elif self.blocks + motions + CHANGED * self.changes > self.enough:
            self.enough = _enough(len(self.source.lines) + self.lines_beside())
            if self.blocks + motions + CHANGED * self.changes > self.enough:
                self._fail(f"{self.blocks} blocks have been executed of {len(self.source.lines)} lines", line)

    def _fail(self, what: str, line: int) -> None:
        self.source.fail(f"{what}: is there a loop without end? --max-blocks N allows more", line, EndlessError)


def _enough(lines: int) -> int:
    """Steps that a program of so many lines may take."""
    return ONCE * lines + max(REPEATED, min(A_LINE * lines, MOST_REPEATED))

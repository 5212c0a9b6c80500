"""A compensation that is suppressed: blocks that are shifted as the contour's last point was."""

from __future__ import annotations

from typing import NoReturn

from toolpace.programs.reading.compensation.elements import Line, Turn
from toolpace.programs.reading.compensation.following import Follower
from toolpace.programs.reading.compensation.stage import OffsetStage
from toolpace.programs.reading.control.moves import Rate
from toolpace.programs.reading.curves.arcs import Arc


class Suppressed(OffsetStage):
    """The stage between CUTCONON and CUTCONOF of a Sinumerik.

    "They are displaced, however, by the vector from the end point of the last compensated block to its offset point",
    and behind it "a linear block is inserted" to where the next element begins (Programming Guide Advanced, 04.00,
    8.4, "Maintain tool radius compensation at constant level").
    """

    def __init__(self, follower: Follower) -> None:
        """Raises ProgramError where the contour has no element yet, or its last one was a gouge."""
        if follower.last is None:
            follower.fail("CUTCONON stands before the first element of the contour: write it behind that")
        follower.pause()
        super().__init__(follower.control, follower.side, follower.radius, follower.plane)
        self.follower, self.at = follower, follower.at
        self.shift = follower.last.way.end - follower.last.element.end

    def move(self, start: list[float], end: list[float], arc: Arc | None, rate: Rate, kind: float) -> None:
        """A motion of the program between words (3 + rotary), shifted. Raises ProgramError."""
        path = self.follower.element(start, end, arc)
        goal = self.point(end) + self.shift
        shifted: Line | Turn | None = None
        if isinstance(path, Turn):
            shifted = Turn(self.at, goal, path.centre + self.shift, path.sweep)
        self.add(goal, start, end, shifted, rate, kind)

    def redirect(self, end: list[float]) -> None:
        """Corners of lines. Raises ProgramError."""
        self.fail("a rounded corner under CUTCONON is not read: write the corner out")

    def other_motion(self, what: str) -> NoReturn:
        """ProgramError."""
        self.fail(f"{what} under CUTCONON is not read: write CUTCONOF, and end the compensation before it")

    def pause(self) -> None:
        """Nothing waits."""

    def resume(self) -> None:
        """The next element is compensated, and a line leads to where it begins."""
        self.follower.resume(self.at)
        self.control.stage = self.follower

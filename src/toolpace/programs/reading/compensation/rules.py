"""The rules by which controls differ: corners, approach, departure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from toolpace.programs.reading.compensation.elements import Element, Turn

ARC, MEETING, LINES = "arc", "meeting", "lines"
"""Outside corners: an arc about the corner; the point where the offset ways meet; that point, or two points at the
tool's radius beyond the ends of both ways where it would lie farther."""
ACROSS, AROUND, TOUCHING = "across", "around", "touching"
"""The first and the last point: across the contour's end; as at any other corner, where that is an outside one; or,
where the way comes from behind the contour, along a line that touches the circle of the tool's radius about its end,
and round that as round a corner."""
CENTRE, CONTOUR, INSIDE = "centre", "contour", "inside"
"""What F is the speed of on arcs: the tool's centre; the point that cuts; that on arcs that the tool goes inside of."""


@dataclass(frozen=True)
class Rules:
    """Of one control, with the words that are in force."""

    outside: str = ARC
    """ARC, MEETING or LINES."""
    ends: str = ACROSS
    """ACROSS, AROUND or TOUCHING."""
    feed: str = CENTRE
    """CENTRE, CONTOUR or INSIDE."""
    most_met: float = math.pi
    """Turn of an outside corner [rad] up to which ways meet; beyond, there is an arc."""
    slight: float = 0.0
    """Turn [rad] up to which an outside corner has no arc: the ways meet."""
    said_of_limits: str = ""
    """What is taken for granted where a corner is read by one of these two."""
    shifts: bool = False
    """Whether a block that begins or ends it without a motion moves the tool across the contour's end."""
    most_idle: int = 1
    """Blocks that move nothing in the plane which may stand between two elements."""
    looks_ahead: int = 0
    """Elements within which the control leaves out what lies between two crossings of the way; 0 where it does not."""
    gouge: str = "the control stops with an alarm"
    """What the control does where the tool does not fit."""
    assumed: str = ""
    """What is taken for granted wherever compensation is read."""

    def share_of_feed(self, path: Element, side: int, radius: float) -> float:
        """Speed of the centre of a tool of a radius [m] at a side of an element (1 left, -1 right), as a share of F."""
        if self.feed == CENTRE or not isinstance(path, Turn):
            return 1.0
        inner = path.holds(side)
        if self.feed == INSIDE and not inner:
            return 1.0
        return 1.0 + (-radius if inner else radius) / path.radius

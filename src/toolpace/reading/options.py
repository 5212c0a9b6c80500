"""How a program is to be read, beside what stands in it."""

from __future__ import annotations

from dataclasses import dataclass, field

from toolpace.reading.control.control import MOST_BLOCKS
from toolpace.reading.control.setup import SetUp
from toolpace.reading.controllers.controller import Controller

PROGRAM = "program"


@dataclass(frozen=True)
class ReadOptions:
    """What a user may choose."""

    controller: Controller | None = None
    """The control that the program is for; None: found from its content."""
    setup: SetUp = field(default_factory=SetUp)
    skip_unknown: bool = False
    """Whether words that are not read are passed over, and said, in place of being refused."""
    block_delete: bool = True
    """Whether blocks that begin with `/` are passed over."""
    compensation: str = ""
    """"program": what G41 and G42 follow is the programmed contour; "": they are refused, but with D of zero."""
    most_blocks: int = MOST_BLOCKS
    default_feed: float | None = None
    """Speed of motions for which the program gives no F [m/s]; None makes that an error."""

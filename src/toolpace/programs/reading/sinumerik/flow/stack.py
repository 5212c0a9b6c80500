"""The call levels of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from toolpace.programs.reading.language.expressions import BlockError
from toolpace.programs.reading.sinumerik.flow.memory import Local
from toolpace.programs.reading.sinumerik.flow.routines import Routine

DEEPEST = 60
"""Levels of calls and repetitions."""
DEEPEST_CALL = 16
"""Levels of programs, the main program too (Job Planning, "Subprogram nesting")."""
MOST_TIMES = 9999
"""Times of P."""


@dataclass
class Frame:
    """A routine that is being executed, or a part of it that is repeated."""

    routine: Routine
    at: int
    end: int
    start: int = 0
    left: int = 1
    local: Local | None = None
    """Variables of the caller, where this is a call."""
    restore: Callable[[], None] | None = None
    """Brings the modes of the caller back, where the subprogram saves them."""
    modal: bool = False
    """Whether MCALL made this call: blocks within make none."""
    line: int = 0
    """Line of the caller, for routines of other files."""
    begun: bool = False
    """Whether a block has been executed that declares nothing."""
    defined: dict[str, int] = field(default_factory=dict)
    """Index of the line of each DEF, by name."""


class Stack(list[Frame]):
    """Frames, the one that is executed last."""

    def push(self, frame: Frame) -> None:
        """Go one level deeper. Raises BlockError."""
        calls = 1 + sum(each.local is not None for each in self)
        if frame.local is not None and calls >= DEEPEST_CALL:
            raise BlockError(
                f"calls are more than {DEEPEST_CALL} levels deep (alarm 14012): does {frame.routine.name} call itself?"
            )
        if len(self) >= DEEPEST:
            raise BlockError(f"calls are more than {DEEPEST} levels deep: does {frame.routine.name} call itself?")
        self.append(frame)


def times_of(value: int, name: str) -> int:
    """How often a subprogram or a part is executed."""
    if not 1 <= value <= MOST_TIMES:
        raise BlockError(f"{name} P={value}: it can be executed 1 to {MOST_TIMES} times (alarm 14013)")
    return value

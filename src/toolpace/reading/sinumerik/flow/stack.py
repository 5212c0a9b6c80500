"""The levels of a run: the main program, calls within it, parts that are repeated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from toolpace.reading.sinumerik.flow.memory import Local
from toolpace.reading.sinumerik.flow.routines import Routine
from toolpace.reading.sinumerik.syntax.values import ValueFault

DEEPEST = 60
"""Levels of calls and repetitions; the control has 16."""
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


class Stack(list[Frame]):
    """Frames, the one that is executed last."""

    def push(self, frame: Frame) -> None:
        """Go one level deeper. Raises ValueFault."""
        if len(self) >= DEEPEST:
            raise ValueFault(f"calls are more than {DEEPEST} levels deep: does {frame.routine.name} call itself?")
        self.append(frame)


def times_of(value: int, name: str) -> int:
    """How often a subprogram or a part is executed."""
    if not 0 <= value <= MOST_TIMES:
        raise ValueFault(f"{name} P={value}: it can be executed 0 to {MOST_TIMES} times")
    return value

"""The flow from block to block: labels, loops and choices with their ends, calls and repetitions with their limits.

Calls and repetitions are frames of one stack, never Python's own: a program that calls itself without end is told by
the number of its levels, and one that loops without end by its blocks (`control/state.py`).
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

from toolpace.programs.reading.expressions import BlockError

# Labels


class Labels:
    """Indices of the blocks that have a label, by label, in the order of the program."""

    def __init__(self) -> None:
        self.blocks: dict[Hashable, list[int]] = defaultdict(list)

    def add(self, label: Hashable, index: int) -> None:
        """Meet a block with a label; blocks are met in their order."""
        self.blocks[label].append(index)

    def all(self, label: Hashable) -> list[int]:
        """Every block of a label."""
        return self.blocks.get(label, [])

    def below(self, label: Hashable, index: int) -> int | None:
        """The next block of a label behind an index; None where there is none."""
        blocks = self.all(label)
        place = bisect_right(blocks, index)
        return blocks[place] if place < len(blocks) else None

    def above(self, label: Hashable, index: int) -> int | None:
        """The last block of a label up to an index; None where there is none."""
        blocks = self.all(label)
        place = bisect_right(blocks, index)
        return blocks[place - 1] if place else None


# Loops and choices


class Opened(NamedTuple):
    """A loop, choice or subprogram whose end has not been met yet."""

    kind: str
    parts: list[int]
    """Its beginning and its branches."""


class Nesting:
    """Which beginnings, branches and ends belong together, as the blocks are met from the first to the last.

    What has a name nests with its like only: blocks of another name may cross it.
    """

    def __init__(self) -> None:
        self.partner: dict[int, int] = {}
        """Of a beginning its end, and of an end its beginning."""
        self.following: dict[int, int] = {}
        """Of a beginning or a branch the next branch, or the end."""
        self.end: dict[int, int] = {}
        """Of a branch the end."""
        self.opened: dict[Hashable, list[Opened]] = defaultdict(list)

    def innermost(self, name: Hashable = "") -> Opened | None:
        """What an end or a branch would belong to."""
        return self.opened[name][-1] if self.opened[name] else None

    def begin(self, kind: str, index: int, name: Hashable = "") -> None:
        """Meet a beginning."""
        self.opened[name].append(Opened(kind, [index]))

    def branch(self, index: int, name: Hashable = "") -> None:
        """Meet a branch of the innermost choice."""
        parts = self.opened[name][-1].parts
        self.following[parts[-1]] = index
        parts.append(index)

    def close(self, index: int, name: Hashable = "") -> int:
        """Meet the end of the innermost; its beginning."""
        begin, *branches = parts = self.opened[name].pop().parts
        self.following[parts[-1]] = index
        self.partner[begin], self.partner[index] = index, begin
        self.end.update(dict.fromkeys(branches, index))
        return begin


# Calls and repetitions

MAIN, CALL, PART = "main", "call", "part"
"""Kinds of frames: the main program, one that is called, and a part of one that is repeated."""


@dataclass(kw_only=True)
class Frame:
    """A program, a subprogram or a part of one that is executed, perhaps several times."""

    kind: str = CALL
    next: int = 0
    """Index of the block that comes next."""
    begin: int = 0
    again: int = 0
    """How often it is still to be executed after this time."""
    called_at: int = 0
    """Line of the main program that stands for its lines; 0 where they are its own."""
    at_return: list[Callable[[], None]] = field(default_factory=list)
    """Gives the caller back what it had: its local variables, its modes."""


SomeFrame = TypeVar("SomeFrame", bound=Frame)


class CallStack(list[SomeFrame]):
    """Frames, the innermost last."""

    def __init__(self, main: SomeFrame, deepest: Mapping[str, tuple[int, str]]) -> None:
        """deepest: frames within each other in the main program, of a kind or ("") of all, and what to say of it."""
        super().__init__([main])
        self.deepest = deepest

    def enter(self, frame: SomeFrame, name: str) -> None:
        """Go one level deeper. Raises BlockError where it is too deep."""
        for kind, (most, note) in self.deepest.items():
            if kind in (frame.kind, "") and sum(kind in (each.kind, "") for each in self[1:]) >= most:
                raise BlockError(f"calls are nested more than {most} deep{note}: does {name} call itself?")
        self.append(frame)

    def leave(self) -> SomeFrame | None:
        """Begin the innermost frame again where it is to be repeated; else leave it: the frame that was left."""
        frame = self[-1]
        if frame.again:
            frame.again -= 1
            frame.next = frame.begin
            return None
        self.pop()
        for give_back in frame.at_return:
            give_back()
        return frame


def times(value: float, word: str, most: int, note: str = "", least: int = 1) -> int:
    """How often something is executed. Raises BlockError."""
    if not least <= value <= most or value != int(value):
        raise BlockError(f"{word}{value:g} is no number of times: write a whole number from {least} to {most}{note}")
    return int(value)

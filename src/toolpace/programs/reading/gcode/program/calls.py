"""Calls by words: M97, M98, M99, G65."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.expressions import Node, value_of, whole
from toolpace.programs.reading.gcode.program.flow import Flow
from toolpace.programs.reading.gcode.program.variables import Key
from toolpace.programs.reading.gcode.program.words import Numbers, RefusedError

ARGUMENTS = {
    **dict(zip("ABC", (1, 2, 3))), **dict(zip("DEF", (7, 8, 9))), "H": 11, "M": 13,
    **dict(zip("QRSTUVWXYZ", range(17, 27))),
}  # fmt: skip
"""Variable of each letter; I, J and K are 4 to 6, and if they are repeated 7 to 9, up to 31 to 33."""
NO_ARGUMENTS = frozenset("GLNOP")


@dataclass(frozen=True)
class Modal:
    """A macro that is called behind each motion."""

    number: str
    times: float
    local: dict[Key, float | None]
    """Its local variables: they are set once, and stay from call to call."""
    depth: int
    """Programs that were being run where it was asked for: its own motions do not call it."""


class Missing(NamedTuple):
    """A call of a macro that is neither in the file nor beside it."""

    word: str
    """G65 P9810."""
    local: dict[Key, float | None]
    """Arguments by variable."""


VALUES = frozenset("EQUVW")
"""Letters beside M98 that are meant as values: no motion has them, and M98 hands nothing over."""


class Calls:
    """Carries out the words that call and return."""

    def __init__(self, flow: Flow, by: Controller) -> None:
        self.flow = flow
        self.modal: Modal | None = None
        self.repeats_in_number = by.option("repeats_in_program_number", False)

    def program(self, numbers: Numbers, word: str) -> None:
        """M98 P L: another program, L times."""
        number = whole(self._number(numbers, word), "the number of a program")
        values = sorted(numbers.keys() & VALUES)
        if values:
            raise RefusedError(f"{word} with {', '.join(values)}", "it hands no values over: write G65 in its place")
        times = numbers.pop("L", None)
        flow = self.flow
        if times is None and self.repeats_in_number and number > 9999 and str(number) not in flow.main.layout.programs:
            times, number = number // 10_000, number % 10_000
        flow.call(str(number), 1.0 if times is None else times)

    def here(self, numbers: Numbers, word: str) -> None:
        """M97 P L: from the block N up to M99."""
        number = whole(self._number(numbers, word), "the number of a block")
        self.flow.call_here(number, numbers.pop("L", 1.0))

    def _number(self, numbers: Numbers, word: str) -> float:
        if "P" not in numbers:
            raise BlockError(f"{word} needs what it calls as P: write it like {word} P1000")
        return numbers.pop("P")

    def back(self, numbers: Numbers, word: str) -> None:
        """M99, or M99 P to a block of the caller."""
        number = numbers.pop("P", None)
        flow = self.flow
        in_main = len(flow.frames) == 1
        flow.leave()
        if number is not None:
            flow.ended = False
            flow.goto(number)
        elif in_main:
            flow.ended = True

    def macro(self, arguments: list[tuple[str, Node]], word: str) -> Missing | None:
        """G65 P L and arguments; what is called where there is no such program."""
        number, times, local = self._arguments(arguments, word)
        if self.flow.files.find(self.flow.frame.text, number, sub=False) is None:
            return Missing(f"{word} P{number}", local)
        self.flow.call(number, times, local)
        return None

    def modal_macro(self, arguments: list[tuple[str, Node]], word: str) -> Missing | None:
        """G66 P L and arguments: from now on behind each motion of this program."""
        number, times, local = self._arguments(arguments, word)
        if self.flow.files.find(self.flow.frame.text, number, sub=False) is None:
            return Missing(f"{word} P{number}", local)
        self.modal = Modal(number, times, local, len(self.flow.frames))
        return None

    def behind_motion(self) -> None:
        """Run the macro that G66 asked for."""
        if self.modal is not None and len(self.flow.frames) == self.modal.depth:
            self.flow.call(self.modal.number, self.modal.times, self.modal.local, kept=True)

    def modal_off(self, numbers: Numbers, word: str) -> None:
        """G67."""
        self.modal = None

    def _arguments(self, arguments: list[tuple[str, Node]], word: str) -> tuple[str, float, dict[Key, float | None]]:
        """Number, times and local variables of a call."""
        local: dict[Key, float | None] = {}
        number, times, last = None, 1.0, 3
        for letter, node in arguments:
            value = value_of(node, self.flow.variables)
            if letter == "P":
                number = value
            elif letter == "L":
                times = 1.0 if value is None else value
            elif letter in "IJK":
                last = self._next(last, "IJK".index(letter))
                local[last] = value
            elif letter in ARGUMENTS:
                local[ARGUMENTS[letter]] = value
            elif letter not in NO_ARGUMENTS:
                raise BlockError(f"{letter} is no argument of a macro: remove it")
        if number is None:
            raise BlockError(f"{word} needs the macro's number as P: write it like {word} P1000 A1.5")
        return str(whole(number, "the number of a macro")), times, local

    @staticmethod
    def _next(last: int, place: int) -> int:
        """Variable of I, J or K: of the same set where it comes behind the last one, else of the next set."""
        wanted = last - last % 3 + 1 + place if last > 3 else 4 + place
        while wanted <= last:
            wanted += 3
        if wanted > 33:
            raise BlockError("I, J and K stand more than ten times in a macro call: use fewer")
        return wanted

"""Loops of O-words: `while`, `do`, `repeat`, `break` and `continue`.

LinuxCNC's interpreter keeps of a loop that is left in its middle that it was left (`interp_o_word.cc`: `doing_break`,
`doing_continue`, `repeat_count`), and another loop may then run too rarely or too often. A `break` that it passes over
on its way to the end of the loop counts too. Its manual says nothing of that: where it would happen, reading ends.
"""

from __future__ import annotations

from typing import NoReturn

from toolpace.programs.reading.gcode.program.files import Text
from toolpace.programs.reading.language.expressions import BlockError

MOST_REPEATS = 1_000_000


class Loops:
    """The loops of a run, and what is kept of those that were left."""

    def __init__(self) -> None:
        self.rounds: dict[tuple[Text, int], int] = {}
        """Rounds left of each `repeat` that has begun, by its file and line."""
        self.broken = 0
        """Line of a `break` of a `while` loop, which the interpreter takes for one of the next `do` loop; 0: none."""
        self.continued = 0
        """Line of a `continue` of a `do` loop, which it takes for one of the next other loop that ends; 0: none."""

    def following(self, kind: str, text: Text, line: int, value: float) -> int:
        """Index of the line behind an O-word in a line (index), whose condition or count comes to a value.

        Raises BlockError.
        """
        layout = text.layout
        if kind in ("break", "continue"):
            return self._leave(kind, text, line)
        partner = layout.partner_of(line)
        if kind == "while":
            return self._end_do(partner, line, value) if partner < line else self._begin_while(text, line, value)
        if kind == "repeat":
            return self._begin_repeat(text, line, value)
        if kind == "endrepeat":
            return self._end_repeat(text, partner, line)
        return partner if kind == "endwhile" else line + 1

    def _begin_while(self, text: Text, line: int, held: float) -> int:
        if held:
            return line + 1
        self.continued = 0
        self._pass_over(text, line, line)
        return text.layout.partner_of(line) + 1

    def _end_do(self, begin: int, line: int, held: float) -> int:
        if held and self.broken:
            _other(f"do loop ends after one round, for the break in line {self.broken}")
        self.broken = 0
        return begin + 1 if held else line + 1

    def _begin_repeat(self, text: Text, line: int, value: float) -> int:
        for _, kind in text.layout.left.get(line, []):
            raise BlockError(f"a {kind.lower()} of a repeat loop stands in it: they are of while and do loops")
        if (text, line) in self.rounds:
            _other("repeat has the rounds that were left when it was left, or called, in its middle")
        if not -MOST_REPEATS <= value <= MOST_REPEATS:
            raise BlockError(f"repeat [{value:g}]: {MOST_REPEATS} rounds are the most")
        times = round(value)  # halves to the even one, as LinuxCNC's `round_to_int`
        if times > 0:
            self.rounds[text, line] = times
            return line + 1
        self.continued = 0
        return text.layout.partner_of(line) + 1

    def _end_repeat(self, text: Text, begin: int, line: int) -> int:
        left = self.rounds.pop((text, begin), 1) - 1
        if left > 0:
            self.rounds[text, begin] = left
            return begin + 1
        if self.continued:
            _other(f"repeat begins again, for the continue in line {self.continued}")
        return line + 1

    def _leave(self, kind: str, text: Text, line: int) -> int:
        layout = text.layout
        loop = layout.end.get(line)
        if loop is None:
            raise BlockError(f"{kind} stands in no loop of its name: write the loop around it")
        end, of_do = layout.partner_of(loop), loop in layout.do
        if kind == "continue":
            self.continued = line + 1 if of_do else 0
            self._pass_over(text, loop, line)
            return end
        if self.continued and not of_do:
            _other(f"break goes round again, for the continue in line {self.continued}")
        self.broken = 0 if of_do else line + 1
        return end + 1

    def _pass_over(self, text: Text, loop: int, line: int) -> None:
        """Go on from a line to the end of a loop."""
        breaks = [at for at, kind in text.layout.left.get(loop, []) if kind == "BREAK" and at > line]
        self.broken = breaks[0] + 1 if breaks else self.broken


def _other(what: str) -> NoReturn:
    """Raise BlockError where the interpreter goes another way than its manual says."""
    raise BlockError(f"in LinuxCNC's interpreter this {what}: leave loops by their conditions, not in their middle")

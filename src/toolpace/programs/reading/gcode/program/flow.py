"""Program flow: jumps, loops, subprograms.

LinuxCNC's interpreter keeps of a loop that is left in its middle that it was left (`interp_o_word.cc`: `doing_break`,
`doing_continue`, `repeat_count`), and another loop may then run too rarely or too often. A `break` that it passes over
on its way to the end of the loop counts too. Its manual says nothing of that: where it would happen, reading ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NoReturn

from toolpace.programs.reading import flow
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.flow import MAIN, CallStack
from toolpace.programs.reading.gcode.program.expressions import Node, value_of, whole
from toolpace.programs.reading.gcode.program.statements import Files, Statement, Text
from toolpace.programs.reading.gcode.program.variables import Key, Variables
from toolpace.programs.reading.source import Source

DEEPEST = 64.0
"""Calls within each other, where a control does not say: it allows four to ten; more calls itself without end."""
MOST_REPEATS = 1_000_000
"""Of a call, and rounds of `repeat`."""
Locals = dict[Key, float | None]
"""Local variables of a call."""


@dataclass(kw_only=True)
class Frame(flow.Frame):
    """A program or subprogram that is being run."""

    text: Text
    fresh: Locals | None = None
    """Local variables with which each run begins."""
    saved: Callable[[], None] | None = None
    """Restores the modes that were saved at this level."""
    restores: bool = False
    """Whether it does so on return."""
    arrived: int = -1
    """The branch that a false condition led to, until it is run."""


class Flow:
    """The stack of frames."""

    def __init__(
        self, source: Source, variables: Variables, deepest: float = DEEPEST, *, to_tape_end: bool = False
    ) -> None:
        """deepest: calls within each other. to_tape_end: what stands behind a second % is not looked for."""
        self.variables = variables
        self.files = Files(source, to_tape_end)
        self.main = self.files.main
        self.frames = CallStack(Frame(kind=MAIN, text=self.main), {"": (int(deepest), "")})
        self.loops = Loops()
        self.defined: set[tuple[Text, int]] = set()
        """Subprograms that were come to outside calls."""
        self.ended = False

    @property
    def frame(self) -> Frame:
        """The innermost."""
        return self.frames[-1]

    def fail(self, message: str) -> NoReturn:
        """Raise a ProgramError at the line at hand."""
        self.frame.text.source.fail(message, self.frame.next)

    # Calls

    def call(
        self,
        name: str,
        times: float = 1.0,
        local: Locals | None = None,
        *,
        sub: bool = False,
        kept: bool = False,
    ) -> None:
        """Run a program of a name, so often, with local variables of its own where they are given.

        kept: what it sets of them stays in `local`.
        """
        found = self.files.find(self.frame.text, name, sub)
        if found is None:
            where = "in this file, nor in a file beside it"
            self.fail(f"O{name} is called, and is not {where}: give it with the program, or write its blocks out")
        self._enter(*found, times, local, kept=kept)

    def call_here(self, number: int, times: float) -> None:
        """Run from a sequence number of this file up to M99."""
        text = self.frame.text
        line = text.layout.label(number, -1)
        if line is None:
            self.fail(f"N{number} is called, and is not in the file: correct the number")
        self._enter(text, line, times, None)

    def _enter(
        self, text: Text, line: int, times: float, local: Locals | None, *, kept: bool = False
    ) -> None:
        runs = flow.times(times, "L", MOST_REPEATS, least=0)
        if runs == 0:
            return
        caller = self.frame
        at = caller.called_at or (caller.next if text is not caller.text else 0)
        frame = Frame(text=text, next=line, begin=line, again=runs - 1, called_at=at, fresh=local)
        self.frames.enter(frame, "a program")
        if local is not None:
            frame.at_return.append(partial(setattr, self.variables, "local", self.variables.local))
            self.variables.local = local if kept else dict(local)

    def leave(self) -> None:
        """Return from the innermost call; in the main program the end."""
        frame = self.frame
        if len(self.frames) == 1 and not frame.again:
            self.ended = True
        elif self.frames.leave() is None:
            if frame.fresh is not None:
                self.variables.local = dict(frame.fresh)
        elif frame.restores and frame.saved is not None:
            frame.saved()

    # Jumps

    def goto(self, number: float) -> None:
        """Go on at a sequence number."""
        frame = self.frame
        line = frame.text.layout.label(whole(number, "the number behind GOTO"), frame.next - 1)
        if line is None:
            self.fail(f"there is no block N{number:g} to go to: correct the number")
        frame.next = line

    def value(self, node: Node | None) -> float:
        """What a condition or a number comes to; empty counts as zero."""
        return (value_of(node, self.variables) or 0.0) if node is not None else 0.0

    def run(self, statement: Statement) -> None:
        """Do what a statement says."""
        kind, line = statement.kind, self.frame.next - 1
        layout = self.frame.text.layout if statement.name else None
        if layout is not None and line in layout.taken:
            first = layout.taken[line] + 1
            self.fail(f"O{statement.name} {kind}: its label stands in line {first} already: take another")
        if kind == "goto":
            self.goto(self.value(statement.value))
        elif kind == "if goto":
            if self.value(statement.value):
                self.goto(self.value(statement.label))
        elif kind == "while do":
            partner = self.frame.text.layout.partner_of(line)
            crossed = self.frame.text.layout.crossed.get(line)
            if crossed is not None:
                self.fail(f"DO{statement.name} crosses the loop of line {crossed + 1}: end the inner within the outer")
            if not self.value(statement.value):
                self.frame.next = partner + 1
        elif kind == "end":
            self.frame.next = self.frame.text.layout.partner_of(line)
        elif kind == "call":
            self._call_sub(statement)
        elif kind in ("return", "endsub"):
            if len(self.frames) == 1:
                self.fail(f"O{statement.name} {kind} stands in no subprogram that was called: write sub before it")
            self._result(statement)
            self.leave()
        elif kind == "sub":
            if layout is not None and line in layout.within:
                self.fail(f"O{statement.name} sub holds another, or stands in one: write them one behind the other")
            if (self.frame.text, line) in self.defined:
                self.fail(f"O{statement.name} sub is come to twice: write it behind the end, or before the loop")
            self.defined.add((self.frame.text, line))
            self.frame.next = self.frame.text.layout.partner_of(line) + 1
        elif kind in ("if", "elseif", "else", "endif"):
            self._branch(statement, line)
        else:
            value = self.value(statement.value)
            self.frame.next = self.loops.following(kind, self.frame.text, line, value)

    def _call_sub(self, statement: Statement) -> None:
        most = self.variables.locals_to
        if len(statement.arguments) > most:
            self.fail(f"a call with {len(statement.arguments)} arguments: {most} are the most")
        local: Locals = dict.fromkeys(range(1, most + 1), 0.0)
        for number, node in enumerate(statement.arguments, start=1):
            local[number] = self.value(node)
        name = statement.name
        if statement.number is not None:
            name = str(whole(self.value(statement.number), "the number of a subprogram"))
        self.call(name, 1.0, local, sub=True)

    def _result(self, statement: Statement) -> None:
        returned = statement.value is not None
        self.variables.common["_VALUE"] = self.value(statement.value) if returned else 0.0
        self.variables.common["_VALUE_RETURNED"] = float(returned)

    def _branch(self, statement: Statement, line: int) -> None:
        layout, frame = self.frame.text.layout, self.frame
        if statement.kind == "endif":
            self.frame.text.layout.partner_of(line)
            return
        if statement.kind != "if" and line not in layout.nesting.end:
            self.fail(f"O{statement.name} {statement.kind} belongs to no if: write one with its number or name")
        arrived, frame.arrived = frame.arrived == line, -1
        if statement.kind != "if" and not arrived:
            # the branch before was run: go behind the last one
            frame.next = layout.nesting.end.get(line, line) + 1
        elif statement.kind != "else" and not self.value(statement.value):
            following = layout.nesting.following.get(line)
            if following is None:
                self.fail(f"O{statement.name} {statement.kind} has no endif: write one")
            frame.next = frame.arrived = following


class Loops:
    """The loops of a run, and what is kept of those that were left."""

    def __init__(self) -> None:
        self.repeats_left: dict[tuple[Text, int], int] = {}
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
        if (text, line) in self.repeats_left:
            _other("repeat has the rounds that were left when it was left, or called, in its middle")
        if not -MOST_REPEATS <= value <= MOST_REPEATS:
            raise BlockError(f"repeat [{value:g}]: {MOST_REPEATS} rounds are the most")
        times = round(value)  # halves to the even one, as LinuxCNC's `round_to_int`
        if times > 0:
            self.repeats_left[text, line] = times
            return line + 1
        self.continued = 0
        return text.layout.partner_of(line) + 1

    def _end_repeat(self, text: Text, begin: int, line: int) -> int:
        left = self.repeats_left.pop((text, begin), 1) - 1
        if left > 0:
            self.repeats_left[text, begin] = left
            return begin + 1
        if self.continued:
            _other(f"repeat begins again, for the continue in line {self.continued}")
        return line + 1

    def _leave(self, kind: str, text: Text, line: int) -> int:
        layout = text.layout
        loop = layout.loop.get(line)
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

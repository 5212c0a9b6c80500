"""Program flow: jumps, loops, subprograms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

from toolpace.programs.reading.gcode.program.expressions import Node, value_of, whole
from toolpace.programs.reading.gcode.program.files import Files, Text
from toolpace.programs.reading.gcode.program.loops import MOST_REPEATS, Loops
from toolpace.programs.reading.gcode.program.statements import Statement
from toolpace.programs.reading.gcode.program.variables import Key, Variables
from toolpace.programs.reading.source import Source

DEEPEST = 64.0
"""Calls within each other, where a control does not say: it allows four to ten; more calls itself without end."""


@dataclass(slots=True)
class Frame:
    """A program or subprogram that is being run."""

    text: Text
    next: int = 0
    """Index of the line that comes next."""
    called_at: int = 0
    """Line of the main file that stands for this frame's lines; 0 where they are its own."""
    begin: int = 0
    again: int = 0
    """How often it is still to be run after this time."""
    outer: dict[Key, float | None] | None = None
    """Local variables of the caller, where it has others; else None."""
    fresh: dict[Key, float | None] | None = None
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
        self.variables, self.deepest = variables, int(deepest)
        self.files = Files(source, to_tape_end)
        self.main = self.files.main
        self.frames = [Frame(self.main)]
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
        given: dict[Key, float | None] | None = None,
        *,
        sub: bool = False,
        kept: bool = False,
    ) -> None:
        """Run a program of a name, so often, with local variables of its own where they are given.

        kept: what it sets of them stays in `given`.
        """
        found = self.files.find(self.frame.text, name, sub)
        if found is None:
            where = "in this file, nor in a file beside it"
            self.fail(f"O{name} is called, and is not {where}: give it with the program, or write its blocks out")
        self._enter(*found, times, given, kept=kept)

    def call_here(self, number: int, times: float) -> None:
        """Run from a sequence number of this file up to M99."""
        text = self.frame.text
        line = text.layout.label(number, -1)
        if line is None:
            self.fail(f"N{number} is called, and is not in the file: correct the number")
        self._enter(text, line, times, None)

    def _enter(
        self, text: Text, line: int, times: float, given: dict[Key, float | None] | None, *, kept: bool = False
    ) -> None:
        if not 0 <= times <= MOST_REPEATS or times != int(times):
            self.fail(f"L{times:g} counts calls: write a whole number from 1 to {MOST_REPEATS}")
        if times == 0:
            return
        if len(self.frames) > self.deepest:
            self.fail(f"calls are nested more than {self.deepest} deep: does a program call itself?")
        frame = self.frame
        at = frame.called_at or (frame.next if text is not frame.text else 0)
        outer = None if given is None else self.variables.local
        if given is not None:
            self.variables.local = given if kept else dict(given)
        self.frames.append(Frame(text, line, at, line, int(times) - 1, outer, given))

    def leave(self) -> None:
        """Return from the innermost call; in the main program the end."""
        frame = self.frame
        if frame.again:
            frame.again -= 1
            frame.next = frame.begin
            if frame.fresh is not None:
                self.variables.local = dict(frame.fresh)
            return
        if len(self.frames) == 1:
            self.ended = True
            return
        self.frames.pop()
        if frame.outer is not None:
            self.variables.local = frame.outer
        if frame.restores and frame.saved is not None:
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
        given: dict[Key, float | None] = dict.fromkeys(range(1, most + 1), 0.0)
        for number, node in enumerate(statement.arguments, start=1):
            given[number] = self.value(node)
        name = statement.name
        if statement.number is not None:
            name = str(whole(self.value(statement.number), "the number of a subprogram"))
        self.call(name, 1.0, given, sub=True)

    def _result(self, statement: Statement) -> None:
        returned = statement.value is not None
        self.variables.common["_VALUE"] = self.value(statement.value) if returned else 0.0
        self.variables.common["_VALUE_RETURNED"] = float(returned)

    def _branch(self, statement: Statement, line: int) -> None:
        layout, frame = self.frame.text.layout, self.frame
        if statement.kind == "endif":
            self.frame.text.layout.partner_of(line)
            return
        if statement.kind != "if" and line not in layout.end:
            self.fail(f"O{statement.name} {statement.kind} belongs to no if: write one with its number or name")
        arrived, frame.arrived = frame.arrived == line, -1
        if statement.kind != "if" and not arrived:
            # the branch before was run: go behind the last one
            frame.next = layout.end.get(line, line) + 1
        elif statement.kind != "else" and not self.value(statement.value):
            following = layout.branch.get(line)
            if following is None:
                self.fail(f"O{statement.name} {statement.kind} has no endif: write one")
            frame.next = frame.arrived = following

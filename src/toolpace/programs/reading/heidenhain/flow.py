"""Program flow: labels, calls, repetitions, jumps, other programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters
from toolpace.programs.reading.heidenhain.klartext.program import Program, beside
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.language.flow import CALL, MAIN, CallStack, Frame

PROGRAM = "program"
DEEPEST = {CALL: (19, ", which no control takes"), PROGRAM: (30, ", which no control takes")}
"""Calls of subprograms, and of programs, within each other: the most of any control (19 and 19 on TNC 640, 8 and 30 on
iTNC 530; Klartext manuals, "Nesting depth")."""


GOES_ON_COUNTING = (
    "a section that a jump left before its last repetition goes on counting where it was, when it is entered again"
)


class Section(NamedTuple):
    """A section that is being repeated."""

    left: int
    """How often its end still goes back."""
    first: int = 0
    """Index of its first block."""
    left_early: bool = False
    """Whether a jump led out of it since."""


@dataclass(kw_only=True)
class Part(Frame):
    """The main program, one that is called, or a subprogram."""

    program: Program
    repeats: dict[int, Section] = field(default_factory=dict)
    """Sections that are being repeated in it, by their blocks `CALL LBL .. REP`."""


class Flow:
    """Which block is next."""

    def __init__(
        self, program: Program, findings: Findings, state: State, parameters: Parameters, block_delete: bool
    ) -> None:
        self.findings, self.main = findings, program
        self.state, self.parameters, self.block_delete = state, parameters, block_delete
        self.frames = CallStack(Part(kind=MAIN, program=program), DEEPEST)
        self.programs: dict[str, Program] = {program.source.name: program}
        self.passed: set[tuple[str, int]] = set()
        """Jumps that nothing decided, and that were passed."""

    @property
    def program(self) -> Program:
        """The one whose blocks are executed."""
        return self.frames[-1].program

    def line(self, line: int) -> int:
        """The line of the main program at which a block of this line is executed."""
        return self.frames[-1].called_at or line

    def behind(self, label: str) -> int:
        """Index of the block behind a label. Raises BlockError."""
        index = self.program.labels.get(label)
        if index is None:
            raise BlockError(f"there is no LBL {label} in this program: correct the name of the label")
        return index

    def undecided(self) -> None:
        """A jump hangs on a parameter without a value: go on behind it once, to find what else is not read."""
        place = self.program.source.name, self.frames[-1].next
        self.state.ended = self.state.ended or place in self.passed
        self.passed.add(place)

    def call(self, label: str, line: int) -> None:
        """Run from a label to LBL 0, and come back."""
        index = self.behind(label)
        if index < len(self.program.blocks) and self.program.blocks[index].text.startswith("END"):
            # shops leave a program so: whether the control ends it or stops with an alarm, nothing moves any more
            self.findings.assumed(f"CALL LBL {label}, which stands before END PGM, ends the program")
            self.frames[-1].next = index
            return
        part = Part(program=self.program, next=index, called_at=self.frames[-1].called_at)
        self.frames.enter(part, f"LBL {label}")

    def repeat(self, label: str, times: int) -> None:
        """Go back to a label `times` more times, then go on."""
        part = self.frames[-1]
        block = part.next - 1
        section = part.repeats.get(block) or Section(times)
        if section.left_early:
            self.findings.assumed(GOES_ON_COUNTING)
        if section.left > 0:
            part.next = self.behind(label)
            part.repeats[block] = Section(section.left - 1, part.next)
        else:
            part.repeats.pop(block, None)

    def jump(self, label: str) -> None:
        """Go on behind a label, also out of sections that are not repeated to their end. Raises BlockError."""
        part = self.frames[-1]
        part.next = self.behind(label)
        for block, section in part.repeats.items():
            if not section.first <= part.next <= block:
                part.repeats[block] = section._replace(left_early=True)

    def call_program(self, name: str, line: int) -> None:
        """Run another file, and come back. Raises BlockError, ProgramError."""
        found = self.programs.get(name)
        if found is None:
            source = beside(self.program.source, name)
            if source is None:
                cure = "put the file into the folder of this program, or write its blocks in place of the call"
                self.findings.refused(f"CALL PGM {name}", self.line(line), cure)
                return
            found = self.programs[name] = Program(source, self.findings, self.block_delete)
        self.frames.enter(Part(kind=PROGRAM, program=found, called_at=self.line(line)), name)
        self.frames[-1].at_return.append(self._give_back())
        self.parameters.local = {}

    def _give_back(self) -> Callable[[], None]:
        """Brings the local parameters and the units of the program at hand back."""
        parameters, state = self.parameters, self.state
        kept = parameters.local, state.unit, state.feed_unit

        def give_back() -> None:
            parameters.local, state.unit, state.feed_unit = kept

        return give_back

    def lines_beside(self) -> int:
        """Lines of the programs that were called."""
        return sum(len(each.source.lines) for each in self.programs.values() if each is not self.main)

    def end_label(self) -> None:
        """LBL 0: back from a subprogram; nothing where it was met in line."""
        if self.frames[-1].kind == CALL:
            self.frames.leave()

    def end_program(self) -> None:
        """END PGM, or the end of the file: back to the program that called, or the end. Raises BlockError."""
        kind = self.frames[-1].kind
        if kind == CALL:
            raise BlockError("a subprogram that was called reaches the end of the program: end it with LBL 0")
        if kind == MAIN:
            self.state.ended = True
        else:
            self.frames.leave()

"""Program flow: labels, calls, repetitions, jumps, other programs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters
from toolpace.programs.reading.heidenhain.klartext.program import Program, beside
from toolpace.programs.reading.heidenhain.state import State

MOST_LABELS, MOST_PROGRAMS = 19, 30
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


@dataclass
class Call:
    """A call that is under way."""

    program: Program
    """That calls."""
    back: int
    """Block with which it goes on."""
    line: int
    """Of the call, in the main program."""
    other: bool = False
    """Whether it called another program."""
    repeats: dict[int, Section] = field(default_factory=dict)
    """Sections that are being repeated in the part that was called, by their blocks `CALL LBL .. REP`."""
    local: dict[str, float] = field(default_factory=dict)
    units: tuple[float, float] = (0.0, 0.0)
    """Local parameters and units of the program that calls."""


class Flow:
    """Which block is next."""

    def __init__(
        self, program: Program, findings: Findings, state: State, parameters: Parameters, block_delete: bool
    ) -> None:
        self.program, self.findings, self.main = program, findings, program
        self.state, self.parameters, self.block_delete = state, parameters, block_delete
        self.at = 0
        """Index of the next block."""
        self.calls: list[Call] = []
        self.repeats: dict[int, Section] = {}
        self.programs: dict[str, Program] = {program.source.name: program}
        self.passed: set[tuple[str, int]] = set()
        """Jumps that nothing decided, and that were passed."""

    def line(self, line: int) -> int:
        """The line of the main program at which a block of this line is executed."""
        return next((call.line for call in self.calls if call.other), line)

    def to(self, label: str) -> None:
        """Go on behind a label. Raises BlockError."""
        index = self.program.labels.get(label)
        if index is None:
            raise BlockError(f"there is no LBL {label} in this program: correct the name of the label")
        self.at = index

    def undecided(self) -> None:
        """A jump hangs on a parameter without a value: go on behind it once, to find what else is not read."""
        place = self.program.source.name, self.at
        self.state.ended = self.state.ended or place in self.passed
        self.passed.add(place)

    def call(self, label: str, line: int) -> None:
        """Run from a label to LBL 0, and come back."""
        made = Call(self.program, self.at, self.line(line))
        self.to(label)
        if self.at < len(self.program.blocks) and self.program.blocks[self.at].text.startswith("END"):
            # shops leave a program so: whether the control ends it or stops with an alarm, nothing moves any more
            self.findings.assumed(f"CALL LBL {label}, which stands before END PGM, ends the program")
            return
        self._push(made)

    def repeat(self, label: str, times: int) -> None:
        """Go back to a label `times` more times, then go on."""
        repeats = self.calls[-1].repeats if self.calls else self.repeats
        block = self.at - 1
        section = repeats.get(block) or Section(times)
        if section.left_early:
            self.findings.assumed(GOES_ON_COUNTING)
        if section.left > 0:
            self.to(label)
            repeats[block] = Section(section.left - 1, self.at)
        else:
            repeats.pop(block, None)

    def jump(self, label: str) -> None:
        """Go on behind a label, also out of sections that are not repeated to their end. Raises BlockError."""
        self.to(label)
        repeats = self.calls[-1].repeats if self.calls else self.repeats
        for block, section in repeats.items():
            if not section.first <= self.at <= block:
                repeats[block] = section._replace(left_early=True)

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
        units = self.state.unit, self.state.feed_unit
        self._push(Call(self.program, self.at, self.line(line), True, {}, self.parameters.local, units))
        self.program, self.at, self.parameters.local = found, 0, {}

    def lines_beside(self) -> int:
        """Lines of the programs that were called."""
        return sum(len(each.source.lines) for each in self.programs.values() if each is not self.main)

    def _push(self, call: Call) -> None:
        alike = sum(each.other == call.other for each in self.calls)
        most, what = (MOST_PROGRAMS, "programs") if call.other else (MOST_LABELS, "subprograms")
        if alike >= most:
            raise BlockError(
                f"more than {most} calls of {what} within each other, which no control takes: does one call itself?"
            )
        self.calls.append(call)

    def end_label(self) -> None:
        """LBL 0: back from a subprogram; nothing where it was met in line."""
        if self.calls and not self.calls[-1].other:
            self.at = self.calls.pop().back

    def end_program(self) -> None:
        """END PGM, or the end of the file: back to the program that called, or the end. Raises BlockError."""
        if not self.calls:
            self.state.ended = True
            return
        call = self.calls.pop()
        if not call.other:
            raise BlockError("a subprogram that was called reaches the end of the program: end it with LBL 0")
        self.program, self.at, self.parameters.local = call.program, call.back, call.local
        self.state.unit, self.state.feed_unit = call.units

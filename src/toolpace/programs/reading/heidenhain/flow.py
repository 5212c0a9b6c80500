"""Program flow: labels, calls, repetitions and jumps, and the functions FN of Q parameters."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.flow import CALL, MAIN, CallStack, Frame
from toolpace.programs.reading.heidenhain.contour.straight_lines import Step
from toolpace.programs.reading.heidenhain.parameters import Parameters, UnsetError, evaluate, formula, named
from toolpace.programs.reading.heidenhain.program import Program, beside, label_of
from toolpace.programs.reading.heidenhain.state import State

PROGRAM = "program"
DEEPEST = {CALL: (19, ", which no control takes"), PROGRAM: (30, ", which no control takes")}
"""Calls of subprograms, and of programs, within each other: the most of any control (19 and 19 on TNC 640, 8 and 30 on
iTNC 530; Klartext manuals, "Nesting depth")."""


GOES_ON_COUNTING = (
    "a section that a jump left before its last repetition goes on counting where it was, when it is entered again"
)
_LABEL = re.compile(r"(?:\"([^\"]*)\"|([0-9]+))")
_NAME = r"(?:LBL\s*)?(?:\"([^\"]*)\"|(QS[0-9]+)|(Q[LR]?[0-9]+)|([0-9]+))"
_CALL = re.compile(_NAME + r"(?:\s*REP\s*([0-9]+|Q[LR]?[0-9]+)(?:\s*/\s*[0-9]+)?)?")
_FUNCTION = re.compile(r"([0-9]+)\s*:\s*(.*)")
_RESULT = re.compile(r"(Q[LR]?[0-9]+)\s*=\s*(.+)")
_TEST = re.compile(r"EQU|NE(?!G)|GT|LT")
SELECTS = "write what the table holds: shifts as CYCL DEF 7, places as blocks with M99"
MOST_REPEATS = 65534
"""Of a program section (TNC 640, "Input format and unit of TNC functions")."""
ALARM = 14
RAISED = "the program stops itself with this error: correct what it tests before"
MESSAGES = (15, 16, 19, 20, 29, 38)
"""FN that print, send, and wait for the machine: no motion."""


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


class Jumps:
    """Compiles what changes the order of blocks."""

    def __init__(self, flow: Flow, parameters: Parameters, control: Control) -> None:
        self.flow, self.parameters, self.control = flow, parameters, control
        self.selected = ""
        """Name of the program that SEL PGM chose."""

    def label(self, text: str) -> Step:
        """LBL: 0 ends a subprogram. Raises BlockError."""
        found = _LABEL.fullmatch(text)
        if found is None:
            raise BlockError("LBL needs a number or a name in quotation marks: write one")
        return self.flow.end_label if label_of(found) == "0" else (lambda: None)

    def target(self, found: re.Match[str]) -> str:
        """The label that is meant, as it stands now."""
        if found[1] is not None:
            return found[1]
        if found[2]:
            return self.parameters.text(found[2])
        return f"{self.parameters.get(found[3]):g}" if found[3] else found[4].lstrip("0") or "0"

    def call(self, text: str) -> Step:
        """CALL LBL, CALL PGM. Raises BlockError."""
        if text.startswith("PGM"):
            name = text[3:].strip()
            if not name:
                raise BlockError("CALL PGM needs the name of a program: write it")
            return lambda: self.flow.call_program(name, self.control.line)
        if text == "SELECTED PGM":
            return self.call_selected
        found = _CALL.fullmatch(text) if text.startswith("LBL") else None
        if found is None:
            cure = "write CALL LBL with a label, or CALL PGM with the name of a file"
            return lambda: self.control.refuse(f"CALL {text[:20]}", cure)
        times = found[5]
        if times is None:
            return lambda: self.flow.call(self.target(found), self.control.line)
        count = formula(times, self.parameters)

        def run() -> None:
            value = evaluate(count)
            if value != int(value) or not 0 <= value <= MOST_REPEATS:
                raise BlockError(f"REP {value:g} must be a whole number from 0 to {MOST_REPEATS}: correct it")
            self.flow.repeat(self.target(found), int(value))

        return run

    def select(self, text: str) -> Step:
        """SEL PGM: the program that CALL SELECTED PGM runs; other tables are refused."""
        name = text[3:].strip()
        if not text.startswith("PGM") or not name:
            return lambda: self.control.refuse(f"SEL {text[:20]}", SELECTS)

        def run() -> None:
            self.selected = name

        return run

    def call_selected(self) -> None:
        """CALL SELECTED PGM. Raises BlockError."""
        if not self.selected:
            raise BlockError("no program is selected here: write SEL PGM before its call")
        self.flow.call_program(self.selected, self.control.line)

    def function(self, text: str) -> Step:
        """FN. Raises BlockError."""
        found = _FUNCTION.fullmatch(text)
        if found is None:
            raise BlockError("FN needs its number and a colon: write FN 0: Q1 = +5")
        number, rest = int(found[1]), found[2].strip()
        if number <= 8 or number == 13:
            result = _RESULT.fullmatch(rest)
            if result is None:
                raise BlockError(f"FN {number} gives a Q parameter: write FN {number}: Q1 = ..")
            name, value = named(result[1]), formula(result[2], self.parameters)
            return lambda: self.parameters.assign(name, lambda: evaluate(value))
        if number <= 12:
            return self.jump(number, rest)
        if number == ALARM:
            return self.alarm(rest)
        if number in MESSAGES:
            return lambda: self.control.findings.ignored(f"FN {number}")
        cure = "write the value that it gives as Q1 = .., or leave it out where nothing comes back"
        parameter = re.search(r"Q[LR]?[0-9]+(?=\s*=)", rest)

        def refuse() -> None:
            self.control.refuse(f"FN {number}", cure)
            if parameter:
                self.parameters.forget(parameter[0])

        return refuse

    def alarm(self, text: str) -> Step:
        """FN 14: ERROR = 1000; the control stops with it."""

        def run() -> None:
            self.control.refuse(f"FN {ALARM}: {text[:20]}", RAISED)
            self.flow.state.ended = True

        return run

    def jump(self, number: int, text: str) -> Step:
        """FN 9 to 12: IF a EQU b GOTO LBL."""
        condition, _, label = text.partition("GOTO")
        found = _TEST.search(condition)
        name = re.fullmatch(_NAME, label.strip())
        if found is None or name is None or not text.startswith("IF"):
            raise BlockError(f"FN {number} is written IF +Q1 EQU +Q2 GOTO LBL 5: correct it")
        left = formula(condition[len("IF") : found.start()], self.parameters)
        right, test = formula(condition[found.end() :], self.parameters), found[0]

        def run() -> None:
            try:
                a, b = evaluate(left), evaluate(right)
            except UnsetError:
                self.flow.undecided()
                raise
            if (test == "EQU" and a == b) or (test == "NE" and a != b) or (test == "GT" and a > b) or (
                test == "LT" and a < b
            ):  # fmt: skip
                self.flow.jump(self.target(name))

        return run

"""The reader of Klartext programs, block by block: statements by their first word, compiled once to steps."""

from __future__ import annotations

import re
from collections.abc import Callable

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.arcs import ArcError
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import CornerError
from toolpace.programs.reading.control.feed import FeedRules
from toolpace.programs.reading.control.state import Rules
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import OFFSETS_UNSAID
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.contour.approach import Approaches, Form
from toolpace.programs.reading.heidenhain.contour.circles import Circles, Polar
from toolpace.programs.reading.heidenhain.contour.lines import SingleAxis, SurfaceLines, corner
from toolpace.programs.reading.heidenhain.contour.straight_lines import Motion, Step
from toolpace.programs.reading.heidenhain.cycles import Cycles
from toolpace.programs.reading.heidenhain.drilling import Holes
from toolpace.programs.reading.heidenhain.flow import Flow, Jumps
from toolpace.programs.reading.heidenhain.frames import Frames
from toolpace.programs.reading.heidenhain.functions import ModeFunctions
from toolpace.programs.reading.heidenhain.machine import MachineFunctions
from toolpace.programs.reading.heidenhain.parameters import Parameters, UnsetError, evaluate, formula, named
from toolpace.programs.reading.heidenhain.patterns import Patterns
from toolpace.programs.reading.heidenhain.program import Program
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.heidenhain.tilting import Tilting
from toolpace.programs.reading.heidenhain.tools import Tools
from toolpace.programs.reading.heidenhain.words import AXES, VALUE, PathWords, path_words, signed
from toolpace.programs.reading.options import PROGRAM, ReadOptions
from toolpace.programs.reading.source import Source

_FIRST = re.compile(r"[A-Z]+|\*")
_HEADER = re.compile(r"PGM\s+(.*?)\s*(MM|INCH|IN)?$")
_ASSIGNMENT = re.compile(r"(Q[LR]?[0-9]+)\s*=\s*(.+)")
_TEXT = re.compile(r"(?:DECLARE\s+STRING\s+)?(QS[0-9]+)\s*=\s*\"([^\"]*)\"")
_SIZE = re.compile(r"R?\s*(" + VALUE + ")")
TENTH, WHOLE = "tenth", "inch"
"""Units of F in programs in inches: 0.1 inch a minute is the control's own; inch a minute is what NX's post writes."""
LONGEST = 4096
"""Characters of a block; cycles need a few hundred, and expressions on longer ones might take long."""
UNKNOWN = "no statement of Klartext that is read: correct it, or leave it out if it moves nothing"
UNSET = "it has no value here: set it in the program, or as a variable on the set-up sheet"
RADIUS = "it is the radius of the tool: give the tool of TOOL CALL on the set-up sheet"


class Statements:
    """Compiles blocks."""

    def __init__(
        self, control: Control, state: State, parameters: Parameters, flow: Flow, controller: Controller, follow: bool
    ) -> None:
        self.control, self.state, self.parameters, self.controller = control, state, parameters, controller
        self.findings = control.findings
        self.frames = frames = Frames(control)
        self.motion = motion = Motion(control, state, frames, follow)
        self.circles = circles = Circles(control, state, motion)
        polar, surface = Polar(circles), SurfaceLines(control, state, motion)
        self.single_axis = SingleAxis(motion)
        self.approaches = approaches = Approaches(circles, polar)
        self.holes = holes = Holes(control, state)
        self.machine = machine = MachineFunctions(control, state, motion, frames, holes, flow, controller)
        self.patterns = patterns = Patterns(control, holes, motion, parameters)
        tilting = Tilting(control, frames, machine, parameters)
        cycles = Cycles(control, frames, tilting, holes, patterns, parameters, controller)
        jumps = Jumps(flow, parameters, control)
        tools = Tools(control, state, frames, parameters)
        functions = ModeFunctions(control, machine, frames, cycles, parameters)
        self.flow = flow
        self.by_word: dict[str, Callable[[str], Step]] = {
            "L": lambda text: self.path(text, motion.line),
            "LN": lambda text: self.path(text, surface.line),
            "C": lambda text: self.path(text, circles.about_pole),
            "CC": lambda text: self.path(text, circles.pole),
            "CR": lambda text: self.path(text, circles.of_radius),
            "CT": lambda text: self.path(text, circles.tangent_arc),
            "LP": lambda text: self.path(text, polar.polar_line),
            "CP": lambda text: self.path(text, polar.polar_arc),
            "CTP": lambda text: self.path(text, polar.polar_tangent),
            "APPR": self.shaped(approaches.approach),
            "DEP": self.shaped(approaches.departure),
            "RND": self.corner("RND"),
            "CHF": self.corner("CHF"),
            "M": lambda text: self.path("M" + text, motion.line),
            "STOP": self.stop,
            "BEGIN": self.begin,
            "END": lambda _: flow.end_program,
            "LBL": jumps.label,
            "CALL": jumps.call,
            "FN": jumps.function,
            "SEL": jumps.select,
            "TOOL": self.tool(tools),
            "BLK": tools.blank,
            "CYCL": self.cycle(cycles),
            "GLOBAL": cycles.define_general,
            "PATTERN": lambda text: patterns.compile(text),
            "PLANE": tilting.compile,
            "FUNCTION": functions.function,
            "TRANS": functions.trans,
            "PRESET": functions.preset,
            "DECLARE": lambda text: self.assign("DECLARE " + text),
            "*": self.heading,
        }

    def compile(self, text: str) -> Step:
        """The step of a block. Raises BlockError."""
        if len(text) > LONGEST:
            raise BlockError(f"the block has {len(text)} characters, at most {LONGEST} are read: divide it")
        found = _FIRST.match(text)
        word = found[0] if found else ""
        rest = text[len(word) :].strip()
        if word in self.by_word:
            return self.by_word[word](rest)
        if word in ("Q", "QL", "QR", "QS"):
            return self.assign(text)
        if word.removeprefix("I") in AXES:
            return self.path(text, self.single_axis.line)
        for name in (word, " ".join(text.split()[:2])):
            if name in self.controller.ignored:
                return lambda: self.findings.ignored(name)
        shown = word or text[:20]
        cure = self.controller.refused.get(word, UNKNOWN)
        return lambda: self.findings.refused(shown, self.flow.line(self.control.line), cure)

    # Motion

    def path(self, text: str, make: Callable[..., Step]) -> Step:
        """A block of words, with its M functions before and behind it."""
        words = path_words(text, self.parameters)
        if not words.functions:
            return self.called(make(words)) if words.axes else make(words)
        before, after, place = self.machine.compile(words)
        step = make(words) if not place else self.machine.in_machine(words)
        if place == "untilted":
            step = self.machine.untilted(make(words))
        calls = any(function == self.machine.call for function in after)
        if words.axes and not place and not calls:
            step = self.called(step)

        def run() -> None:
            for function in before:
                function()
            step()
            for function in after:
                function()

        return run

    def called(self, step: Step) -> Step:
        """With the cycle behind it, where M89 calls it everywhere."""
        state, call = self.state, self.holes.call

        def run() -> None:
            everywhere = state.calls_everywhere
            step()
            if everywhere:
                call()

        return run

    def shaped(self, make: Callable[[Form, PathWords], Step]) -> Callable[[str], Step]:
        """APPR and DEP: the form comes first."""

        def made(text: str) -> Step:
            form, rest = Form.of(text)
            return self.path(rest, lambda words: make(form, words))

        return made

    def corner(self, name: str) -> Callable[[str], Step]:
        """RND and CHF with their size; R may be missing."""

        def made(text: str) -> Step:
            found = _SIZE.match(text)
            size = signed(found[1], self.parameters) if found else None
            words = path_words(text[found.end() :] if found else text, self.parameters)
            return corner(self.motion, name, words, size)

        return made

    def stop(self, text: str) -> Step:
        """STOP, with M functions."""
        inner = self.path(text, self.motion.line)

        def run() -> None:
            inner()
            self.control.stop()

        return run

    # All else

    def begin(self, text: str) -> Step:
        """BEGIN PGM: the units of the program."""
        found = _HEADER.fullmatch(text)
        if found is None:
            raise BlockError("BEGIN PGM needs a name and MM or INCH: write them")
        unit = found[2] or "MM"
        choice = self.controller.option("inch_feed", "header")
        whole = choice == WHOLE or (choice == "header" and unit == "IN")

        def run() -> None:
            self.state.unit = self.state.feed_unit = MILLIMETRE if unit == "MM" else INCH
            if unit != "MM":
                self.state.feed_unit = INCH if whole else 0.1 * INCH
                shown = "inches" if whole else "tenths of an inch"
                self.findings.assumed(f"F is in {shown} a minute (option inch_feed of the controller's file)")

        return run

    def tool(self, tools: Tools) -> Callable[[str], Step]:
        """TOOL CALL and TOOL DEF."""

        def made(text: str) -> Step:
            if text.startswith("CALL"):
                return tools.compile(text[4:])
            if text.startswith("DEF"):
                return lambda: tools.defined(text[3:])
            raise BlockError("TOOL is followed by CALL or DEF: write one of both")

        return made

    def cycle(self, cycles: Cycles) -> Callable[[str], Step]:
        """CYCL DEF and CYCL CALL."""

        def made(text: str) -> Step:
            if text.startswith("DEF"):
                return cycles.compile(text[3:].strip())
            if not text.startswith("CALL"):
                raise BlockError("CYCL is followed by DEF or CALL: write one of both")
            rest = text[4:].strip()
            kind = "PAT" if rest.startswith("PAT") else "POS" if rest.startswith("POS") else ""
            forms = {"PAT": self.patterns.at_places, "POS": self.patterns.at_place, "": lambda _: self.holes.call}
            return self.path(rest[len(kind) :], forms[kind])

        return made

    def assign(self, text: str) -> Step:
        """Q1 = formula, QS1 = "text"."""
        parameters = self.parameters
        if written := _TEXT.fullmatch(text):
            name, content = written[1], written[2]
            return lambda: parameters.texts.update({name: content})
        found = _ASSIGNMENT.fullmatch(text)
        if found is None:
            cure = "write Q1 = with a formula of numbers and Q parameters"
            return lambda: self.findings.refused(text[:20], self.control.line, cure)
        name, value = named(found[1]), formula(found[2], parameters)
        return lambda: parameters.assign(name, lambda: evaluate(value))

    def heading(self, text: str) -> Step:
        """`* -`: the name of what follows."""
        name = text.lstrip("-* ").strip()
        return lambda: self.control.operations.begin(name=name)


class HeidenhainReader:
    """One reading of one program; `executed` does it."""

    def __init__(
        self,
        source: Source,
        machine: Kinematics | None,
        controller: Controller,
        options: ReadOptions,
        findings: Findings,
    ) -> None:
        self.source, self.options, self.findings = source, options, findings
        rules = Rules(
            feed=FeedRules(turning=controller.option("feed_when_turning", "vector"), kept=False),
            fixed_where_switched=controller.option("part_frame_where_switched", False),
        )
        self.control = Control(source, machine, controller, options, findings, rules)
        self.state = State(shortest=controller.option("shortest_rotary", False))
        parameters = Parameters(options.setup.variables)
        program = Program(source, findings, options.block_delete)
        self.flow = Flow(program, findings, self.state, parameters, options.block_delete)
        self.control.effort.lines_beside = self.flow.lines_beside
        follow = options.compensation == PROGRAM
        self.statements = Statements(self.control, self.state, parameters, self.flow, controller, follow)

    def executed(self) -> Control:
        """The control, with every block executed. Raises ProgramError."""
        self._first_preset()
        flow, state = self.flow, self.state
        while not state.ended:
            frame = flow.frames[-1]
            program, at = frame.program, frame.next
            if at < len(program.blocks):
                frame.next = at + 1
                self._execute(program, at)
            elif len(flow.frames) > 1:
                self._execute_end(program)
            else:
                self.source.must_be_ended("END PGM, M2 nor M30")
                break
        self.statements.approaches.refuse()
        self.statements.motion.corners.refuse()
        self.findings.raise_if_refused(self.source, self.options.skip_unknown)
        return self.control

    def _execute(self, program: Program, at: int) -> None:
        block = program.blocks[at]
        line = block.line if program is self.flow.main else self.flow.line(block.line)
        self.control.begin_block(line)
        try:
            program.step(at, self.statements.compile)()
        except (BlockError, ArcError, CornerError) as error:
            program.source.fail(str(error), block.line)
        except UnsetError as error:
            name = str(error)
            self.statements.motion.corners.waiting = None  # the block that it waits for is this one
            if name:
                self.findings.refused(name, line, RADIUS if name == "Q108" else UNSET)

    def _execute_end(self, program: Program) -> None:
        try:
            self.flow.end_program()
        except BlockError as error:
            program.source.fail(str(error), len(program.source.lines))

    def _first_preset(self) -> None:
        """The preset that is active before the program names one: the only one of the set-up sheet, or its stand-in."""
        offsets = list(self.options.setup.offsets)
        if not offsets:
            self.findings.assumed(OFFSETS_UNSAID)
        if len(offsets) == 1:
            self.control.set_offset(offsets[0])
            self.findings.assumed(f"offset {offsets[0]} is active before the program names one")

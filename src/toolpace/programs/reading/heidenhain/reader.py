"""The reader of Klartext programs, block by block."""

from __future__ import annotations

from toolpace.programs.reading.arcs import ArcError
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import CornerError
from toolpace.programs.reading.control.feed import FeedRules
from toolpace.programs.reading.control.state import Rules
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import OFFSETS_UNSAID
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.flow import Flow
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError, Parameters, UnsetError
from toolpace.programs.reading.heidenhain.klartext.program import Program
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.heidenhain.statements import Statements
from toolpace.programs.reading.options import PROGRAM, ReadOptions
from toolpace.programs.reading.source import Source

UNSET = "it has no value here: set it in the program, or as a variable on the set-up sheet"
RADIUS = "it is the radius of the tool: give the tool of TOOL CALL on the set-up sheet"


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

"""The reader of word-address programs, block by block."""

from __future__ import annotations

import re

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.arcs import ArcError
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import CornerError
from toolpace.programs.reading.control.feed import FeedRules
from toolpace.programs.reading.control.state import Rules
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.gcode.execute import Executor
from toolpace.programs.reading.gcode.modal import FREE, Modal, System
from toolpace.programs.reading.gcode.program.blocks import Block, Compiler
from toolpace.programs.reading.gcode.program.expressions import value_of
from toolpace.programs.reading.gcode.program.flow import Flow, Frame
from toolpace.programs.reading.gcode.program.statements import Statement
from toolpace.programs.reading.gcode.program.variables import Variables
from toolpace.programs.reading.gcode.program.words import RefusedError, plain_words
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source
from toolpace.programs.reading.splines import CurveError

MOST_KEPT = 5000
"""Lines that are kept taken apart: those of loops come again, those of long programs do not."""
MACROS = ("macro call", "modal macro call")
ALARM, PAUSE = 3000, 3006
SWITCHES = (3001, 3002, 3003, 3004)
"""Clocks, and what the operator may interrupt ("#3003, #3004: automatic operation control"): they move nothing."""
RAISED = "the program stops itself with this alarm: correct what it tests before"
_BEHIND_NUMBER = re.compile(r"[0-9]++[ \t]*+([A-Z][ \t]*+[-+.0-9#\[].*)")
"""Words behind the number of a program are a block of it ("O2200 G68 X0 Y0 G91 R45.0", B-63944EN-2)."""
_CODE = re.compile(r"[ \t]*+/?[0-9]?[ \t]*+(?:N[ \t]*+[0-9]++[ \t]*+)?[GXYZ][ \t]*+[-+.#\[0-9]", re.IGNORECASE)


class WordAddressReader:
    """One reading of one program; `executed` does it."""

    def __init__(
        self,
        source: Source,
        machine: Kinematics | None,
        controller: Controller,
        options: ReadOptions,
        findings: Findings,
    ) -> None:
        self.source, self.controller, self.options, self.findings = source, controller, options, findings
        by = controller.option
        feed = FeedRules(
            turning=by("turning", "xyz"),
            inverse_seconds=by("inverse_seconds", False),
            kept=by("feed_kept", False),
            forgotten=by("feed_mode_forgets_feed", False),
        )
        rules = Rules(feed, by("tip_frame_where_switched", False))
        self.control = Control(source, machine, controller, options, findings, rules)
        self.inches = by("units", "mm") == "inch"
        """Whether lengths are inches before the program says their unit."""
        self.state = Modal(
            unit=INCH if self.inches else MILLIMETRE,
            to_initial=by("cycles_go_back_to_initial", True),
            switched_tip_mode=by("tip_mode_at_start", False),
        )
        if self.state.switched_tip_mode:
            self.control.set_tip_mode(True)
        self.variables = Variables(
            options.setup.variables,
            System(
                self.control,
                self.state,
                named=by("named_system_variables", False),
                offset_group=int(by("offset_group", 14.0)),
            ),
            locals_to=int(by("local_variables", 33.0)),
            empty_locals=by("empty_variables", True),
            system_from=int(by("system_variables_from", 1000.0)),
            letter=by("variable_letter", "#"),
            last=int(by("last_variable", 999_999.0)),
            free=FREE if by("named_system_variables", False) else frozenset(),
        )
        if by("local_variables_begin_at_zero", False):
            self.variables.local = dict.fromkeys(range(1, self.variables.locals_to + 1), 0.0)
        self.rs274 = by("rs274_checks", False)
        self.flow = Flow(source, self.variables, by("deepest_calls", 64.0), to_tape_end=self.rs274)
        self.control.effort.lines_beside = self.flow.files.lines_beside
        self.compiler = Compiler(controller, deletes=options.block_delete)
        self.executor = Executor(self.control, self.state, self.flow, controller, options)
        self.fanuc = by("fanuc_checks", False)
        """Whether blocks are refused that Fanuc stops with an alarm."""
        self.assignments_last = by("assignments_last", False)
        """Whether the values of a block are those before it sets variables."""
        self.blocks: dict[str, Block] = {}
        self.tape_line, self.tape_closed = 0, False

    def executed(self) -> Control:
        """The control, with every block executed. Raises ProgramError."""
        flow, state = self.flow, self.state
        flow.frame.next = self._first_line()
        while not (state.ended or flow.ended or self.tape_closed):
            frame = flow.frame
            lines = frame.text.source.lines
            if frame.next >= len(lines):
                if len(flow.frames) == 1:
                    break
                flow.leave()
                continue
            text = lines[frame.next]
            frame.next += 1
            if "%" in text and text.lstrip().startswith("%"):
                self._tape(frame)
                continue
            self._line(frame, text)
        self.executor.close()
        self._refuse_cut_off()
        if not state.unit_said:
            taken, other = ("inches", "mm") if self.inches else ("millimetres", "inch")
            self.findings.assumed(
                f'the program does not say its unit of lengths (G20, G21): they are {taken} (units = "{other}" in the '
                "controller's file takes the others)"
            )
        self.findings.raise_if_refused(self.source, self.options.skip_unknown, self.options.lenient)
        return self.control

    def _first_line(self) -> int:
        """Index of the line with which the program begins: text before the first % is none of it.

        To LinuxCNC only a % in the first line that is not empty begins a program.
        """
        if self.rs274:
            return next((index for index, text in enumerate(self.source.lines) if text.strip()), 0)
        for index, text in enumerate(self.source.lines):
            if text.lstrip().startswith("%"):
                return index
            if _CODE.match(text):
                return 0
        return 0

    def _tape(self, frame: Frame) -> None:
        """% opens the program, and closes it; in a file that is called it is passed over."""
        if frame.text is not self.flow.main:
            return
        if len(self.flow.frames) > 1:
            self.source.fail("the subprogram that is executed here ends without M99: write it", frame.next)
        if self.tape_line or self.control.effort.blocks:
            self.tape_closed = True
            if self.rs274 and not self.tape_line:
                self.findings.stops("% that ends what none begins", frame.next, "write M2, or % before the program too")
        else:
            self.tape_line = frame.next
            if self.rs274 and any(line.strip() for line in self.source.lines[: frame.next - 1]):
                self.findings.stops("a comment before %", 1, "write it behind: % begins the program")

    def _line(self, frame: Frame, text: str) -> None:
        line = frame.called_at or frame.next
        self.control.line = line
        fail = frame.text.source.fail
        number = frame.next
        try:
            block = self.blocks.get(text)
            if block is None:
                block = self._compiled(text)
            for alarm in block.alarms:
                self.findings.stops(alarm.what, line, alarm.cure)
            if block.aborts:
                fail(f"the program ends itself here: {block.aborts}", number)
            if block.empty and not block.name:
                return
            self._block(block, line)
        except RefusedError as error:
            if block is not None and block.statement is not None:
                fail(str(error), number)  # where the program goes from here is not known
            self.findings.refused(error.word, line, error.cure)
        except (BlockError, ArcError, CurveError, CornerError) as error:
            fail(str(error), number)

    def _compiled(self, text: str) -> Block:
        if len(self.blocks) >= MOST_KEPT:
            self.blocks.clear()
        block = self.blocks[text] = self.compiler.block(text)
        return block

    def _block(self, block: Block, line: int) -> None:
        if block.name:
            self.control.operations.begin(name=block.name)
        if block.empty:
            return
        if block.deleted:
            self.findings.skipped["/"] += self.options.block_delete
            if self.options.block_delete:
                return
        self.control.begin_block(line)
        if block.statement is not None:
            self._statement(block.statement)
            return
        if block.codes:
            block = self._resolved(block)
        if self.state.in_data and not any(action.meaning == "end of data" for action in block.actions):
            self.findings.ignored("data of G10")
            return
        if block.refused:
            for word, cure in block.refused:
                self.findings.refused(word, line, cure)
            return
        if self.fanuc and block.assignments and (block.fixed or block.computed or block.actions):
            raise BlockError("a variable is set beside other words, which stops with an alarm (PS0127): use two blocks")
        values = [(place.key(self.variables), value_of(node, self.variables)) for place, node in block.assignments]
        if not self.assignments_last:
            self._assign(values)
        macro = next((action for action in block.actions if action.meaning in MACROS), None)
        if macro is not None:
            self.executor.macros.call(block, macro.word, modal=macro.meaning == "modal macro call")
        elif block.fixed or block.computed or block.actions or block.ignored:
            moves = len(self.control.moves)
            self.executor.execute(block)
            if self.executor.calls.modal is not None and len(self.control.moves) > moves:
                self.executor.calls.behind_motion()
        if self.assignments_last:
            self._assign(values)

    def _resolved(self, block: Block) -> Block:
        """The block with its G and M words worked out."""
        made = Block(block.text, fixed=block.fixed, computed=block.computed, whole=block.whole)
        made.actions, made.ignored, made.refused = list(block.actions), list(block.ignored), list(block.refused)
        made.assignments, made.arguments = block.assignments, block.arguments
        made.words = list(block.words)
        for letter, node in block.codes:
            value = value_of(node, self.variables)
            if value is not None:
                self.compiler.code(made, letter, round(value, 6))
        self.compiler.arrange(made)
        for alarm in made.alarms:
            if alarm not in block.alarms:
                self.findings.stops(alarm.what, self.control.line, alarm.cure)
        return made

    def _assign(self, values: list[tuple[int | str, float | None]]) -> None:
        variables = self.variables
        for key, value in values:
            if key == ALARM and variables.is_system(key):
                self.findings.refused(f"#{ALARM}={value or 0:g}", self.control.line, RAISED)
                self.state.ended = True
            elif key == PAUSE and variables.is_system(key):
                self.control.stop()
            elif key in SWITCHES and variables.is_system(key):
                self.findings.ignored(variables.text(key))
            elif variables.is_system(key):
                self.findings.refused(
                    variables.text(key),
                    self.control.line,
                    "it is set, and belongs to the controller: set offsets with G10 or G52, or on the set-up sheet",
                )
            else:
                variables.set(key, value)

    def _statement(self, statement: Statement) -> None:
        if statement.kind in ("header", "output"):
            self.findings.ignored("O" if statement.kind == "header" else "output")
            words = _BEHIND_NUMBER.match(statement.name)
            if words and (plain_words(words[1]) or "#" in words[1] or "[" in words[1]):
                self._block(self._compiled(words[1]), self.control.line)
        elif statement.kind == "if then":
            if self.flow.value(statement.value):
                self._assign([(a.key(self.variables), value_of(b, self.variables)) for a, b in statement.assignments])
        else:
            self.flow.run(statement)

    def _refuse_cut_off(self) -> None:
        state = self.state
        if state.ended or self.flow.ended or self.tape_closed:
            return
        if self.tape_line:
            self.source.fail(
                "the program is cut off: % opens it here, but neither %, M2 nor M30 ends it; export it again",
                self.tape_line,
            )
        if self.rs274:
            self.findings.stops("the end without M2, M30 or %", len(self.source.lines), "write M2 as the last block")
        if not state.at_home:
            self.source.must_be_ended("M2, M30 nor %")

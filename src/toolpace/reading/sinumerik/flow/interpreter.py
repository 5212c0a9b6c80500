"""Executes routines block by block: jumps, loops, calls. What a block itself does is the affair of its actions.

Calls and repetitions are frames of one list, never Python's own stack: a program that calls itself without end is told
by the number of its levels, and one that loops without end by the number of its blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from toolpace.reading.sinumerik.flow.memory import Local, Store
from toolpace.reading.sinumerik.flow.routines import Library, Routine, StructureFault
from toolpace.reading.sinumerik.syntax.blocks import Block, Call, Flow
from toolpace.reading.sinumerik.syntax.values import Compiled, Unread, Value, ValueFault, above, equal, real, whole
from toolpace.reading.source import Source

DEEPEST = 60
"""Levels of calls and repetitions; the control has 16."""
MOST_TIMES = 9999
"""Times of P."""
SKIPPED = "/"
LOOPS = ("FOR", "WHILE", "LOOP", "REPEAT")
ENDS = ("ENDFOR", "ENDWHILE", "ENDLOOP", "UNTIL")


class Actions(Protocol):
    """What blocks do beside flow."""

    def begin(self, line: int) -> None:
        """A block of this line comes next."""

    def execute(self, block: Block) -> bool:
        """Do what a block says; whether it programmed an axis of the path. Raises Unread, ValueFault."""

    def perform(self, call: Call, arguments: list[Value | None]) -> bool:
        """Do a cycle or a command with arguments; False where it is none. Raises Unread, ValueFault."""

    def saved(self) -> Any:
        """The modes, for a subprogram that saves them."""

    def restore(self, state: Any) -> None:
        """Modes as they were."""

    def ignored(self, word: str) -> None:
        """Count a word that moves nothing."""

    def refuse(self, word: str, line: int, cure: str) -> None:
        """Note a word that is not read."""


@dataclass
class Frame:
    """A routine that is being executed, or a part of it that is repeated."""

    routine: Routine
    at: int
    end: int
    start: int = 0
    left: int = 1
    local: Local | None = None
    """Variables of the caller, where this is a call."""
    state: Any = None
    """Modes of the caller, where the subprogram saves them."""
    modal: bool = False
    """Whether MCALL made this call: blocks within make none."""
    line: int = 0
    """Line of the caller, for routines of other files."""


@dataclass
class Interpreter:
    """One run of a program."""

    source: Source
    library: Library
    actions: Actions
    memory: Store
    block_delete: bool = True
    ended: bool = field(default=False, init=False)
    modal: tuple[Call, list[Value | None]] | None = field(default=None, init=False)
    """What MCALL asked for, with its arguments."""
    stack: list[Frame] = field(default_factory=list, init=False)

    def run(self) -> None:
        """Execute the main program."""
        main = self.library.main
        self.stack = [Frame(main, 0, len(main.lines))]
        while self.stack:
            frame = self.stack[-1]
            if frame.at >= frame.end:
                self._leave(frame)
                continue
            index = frame.at
            frame.at += 1
            head, block = frame.routine.read(index)
            if not head.rest and not head.label:
                continue
            if head.skip and self.block_delete:
                self.actions.ignored(SKIPPED)
                continue
            line = frame.line or frame.routine.first + index
            self.actions.begin(line)
            try:
                if block.fault:
                    raise ValueFault(block.fault)
                if block.flow is not None:
                    self._flow(block.flow, frame, index)
                elif self.actions.execute(block) and self.modal is not None and not frame.modal:
                    self._modal_call()
            except ValueFault as error:
                where = f"{frame.routine.file} line {index + 1}: " if frame.routine.file else ""
                self.source.fail(where + str(error), line)
            except StructureFault as error:
                self.source.fail(str(error), frame.line or frame.routine.first + error.index)
            except Unread as error:
                self.actions.refuse(error.word, line, error.cure)
                kind = "" if block.flow is None else block.flow.kind
                if kind in ("IF", "WHILE", "FOR"):
                    frame.at = frame.routine.partners[index] + 1  # what cannot be decided is left out

    def end(self) -> None:
        """Leave the subprogram at hand; of the main program all (M30, M17, RET)."""
        while self.stack:
            frame = self.stack[-1]
            frame.at, frame.left = frame.end, 1
            self._leave(frame)
            if frame.local is not None:
                return
        self.ended = True

    def _leave(self, frame: Frame) -> None:
        frame.left -= 1
        if frame.left > 0:
            frame.at = frame.start
            return
        self.stack.pop()
        if frame.local is not None:
            self.memory.local = frame.local
        if frame.state is not None:
            self.actions.restore(frame.state)

    def _modal_call(self) -> None:
        assert self.modal is not None
        call, arguments = self.modal
        if not self.actions.perform(call, arguments):
            self.call(call, arguments, modal=True)

    def call(self, call: Call, arguments: list[Value | None], *, modal: bool = False) -> None:
        """Begin a subprogram. Raises Unread where there is none of that name."""
        routine = self.library.find(call.name)
        if routine is None:
            raise Unread(
                call.name, "it is no word that is read, and no subprogram of this file or beside it: add its file"
            )
        times = 1 if call.times is None else whole(call.times(self.memory))
        if not 0 <= times <= MOST_TIMES:
            raise ValueFault(f"{call.name} P{times}: a count goes from 0 to {MOST_TIMES}")
        if times:
            outer = self.memory.local
            line = self.stack[-1].line if self.stack else 0
            if routine.file and not line:
                line = self.stack[-1].routine.first + self.stack[-1].at - 1
            inside = modal or any(frame.modal for frame in self.stack[-1:])
            self._push(Frame(routine, 0, len(routine.lines), 0, times, outer, None, inside, line))
            self.memory.local = {}
            self._bind(routine, arguments)

    def _push(self, frame: Frame) -> None:
        if len(self.stack) >= DEEPEST:
            raise ValueFault(f"calls are more than {DEEPEST} levels deep: does {frame.routine.name} call itself?")
        self.stack.append(frame)

    def _bind(self, routine: Routine, arguments: list[Value | None]) -> None:
        """Give the parameters of PROC, which stands first in the routine, their values."""
        frame = self.stack[-1]
        for index in range(len(routine.lines)):
            head, block = routine.read(index)
            if head.rest:
                break
        else:
            return
        if block.flow is None or block.flow.kind != "PROC":
            if arguments:
                raise ValueFault(f"{routine.name} takes no arguments, it has no PROC with parameters: remove them")
            return
        names = block.flow.names
        if names[-1] == "SAVE" and len(names) % 2 == 0:
            frame.state, names = self.actions.saved(), names[:-1]
        if len(arguments) > len(names) // 2:
            raise ValueFault(f"{routine.name} takes {len(names) // 2} arguments, not {len(arguments)}: correct them")
        for k, (kind, name) in enumerate(zip(names[1::2], names[2::2])):
            variable = self.memory.define(name, kind)
            given = arguments[k] if k < len(arguments) else None
            default = block.flow.values[k]
            value = given if given is not None or default is None else default(self.memory)
            if value is not None:
                variable.set((), value, name)

    # Words of flow

    def _flow(self, flow: Flow, frame: Frame, index: int) -> None:
        kind = flow.kind
        if kind in ("GOTOF", "GOTOB", "GOTO", "GOTOC"):
            if self._holds(flow.values):
                self._jump(kind, flow.names[0], frame, index)
        elif kind == "GOTOS":
            if self._holds(flow.values):
                frame.at = 0
        elif kind in ("IF", "WHILE"):
            if not self._holds(flow.values):
                frame.at = frame.routine.partners[index] + 1
        elif kind in ("ELSE", "LOOP", "REPEAT", "ENDLOOP", "ENDWHILE"):
            self._passed(kind, frame, index)
        elif kind == "UNTIL":
            if not self._holds(flow.values):
                frame.at = frame.routine.partners[index] + 1
        elif kind in ("FOR", "ENDFOR"):
            self._for(flow, frame, index)
        elif kind == "CASE":
            self._case(flow, frame, index)
        elif kind in ("REPEAT label", "REPEATB label", "CALL BLOCK"):
            self._repeat(flow, frame, index)
        elif kind == "DEF":
            self._define(flow)
        elif kind in ("RET", "ENDPROC"):
            self.end()
        else:
            self._calls(flow)

    def _holds(self, condition: tuple[Compiled | None, ...]) -> bool:
        return not condition or condition[0] is None or bool(real(condition[0](self.memory)))

    def _jump(self, kind: str, label: str, frame: Frame, index: int) -> None:
        target = frame.routine.target(kind, label, index)
        if target is not None:
            while not frame.start <= target < frame.end:
                # a jump out of a part that is repeated ends its repetition
                self.stack.pop()
                frame = self.stack[-1]
            frame.at = target
        elif kind != "GOTOC":
            direction = {"GOTOF": " below", "GOTOB": " above"}.get(kind, "")
            raise ValueFault(f"there is no label {label}{direction} to jump to: write it, or correct its name")

    def _passed(self, kind: str, frame: Frame, index: int) -> None:
        partner = frame.routine.partners[index]
        if kind == "ELSE":
            frame.at = partner + 1
        elif kind in ENDS:
            frame.at = partner

    def _for(self, flow: Flow, frame: Frame, index: int) -> None:
        if flow.kind == "ENDFOR":
            start = frame.routine.partners[index]
            opening = frame.routine.read(start)[1].flow
            assert opening is not None
            place = self._variable(opening)
            value: Value = real(self._value(opening, place)) + 1.0
            frame.at = start
        else:
            start, opening = index, flow
            place = self._variable(flow)
            assert flow.values[0] is not None
            value = flow.values[0](self.memory)
        self.memory.assign(opening.names[0], place, value)
        last = opening.values[1]
        assert last is not None
        beyond = above(value, last(self.memory))
        frame.at = (frame.routine.partners[start] if beyond else start) + 1

    def _variable(self, flow: Flow) -> tuple[Value, ...]:
        return tuple(index(self.memory) for index in flow.values[2:] if index is not None)

    def _value(self, flow: Flow, place: tuple[Value, ...]) -> Value:
        if flow.names[0] == "R":
            return self.memory.r.get(whole(place[0]), 0.0)
        return self.memory.variable(flow.names[0], ())

    def _case(self, flow: Flow, frame: Frame, index: int) -> None:
        chosen, *values = flow.values
        assert chosen is not None
        found = chosen(self.memory)
        for k, value in enumerate(values):
            if value is None or equal(value(self.memory), found):
                self._jump(flow.names[2 * k], flow.names[2 * k + 1], frame, index)
                return

    def _repeat(self, flow: Flow, frame: Frame, index: int) -> None:
        first = frame.routine.target("GOTO" if flow.kind == "CALL BLOCK" else "GOTOB", flow.names[0], index)
        first = frame.routine.target("GOTO", flow.names[0], index) if first is None else first
        if first is None:
            raise ValueFault(f"there is no label {flow.names[0]} to repeat from: write it, or correct its name")
        end = first + 1 if flow.kind == "REPEATB label" else index
        if len(flow.names) > 1:
            last = frame.routine.target("GOTOF", flow.names[1], first - 1)
            if last is None:
                raise ValueFault(f"there is no label {flow.names[1]} behind {flow.names[0]}: write it, or correct it")
            end = last + 1
        elif flow.kind == "REPEAT label":
            end = self._to_end_label(frame.routine, first, index)
        times = 1 if flow.values[0] is None else whole(flow.values[0](self.memory))
        if not 0 <= times <= MOST_TIMES:
            raise ValueFault(f"P={times}: a count of repetitions goes from 0 to {MOST_TIMES}")
        if times and first < end:
            self._push(Frame(frame.routine, first, end, first, times, None, None, frame.modal, frame.line))

    @staticmethod
    def _to_end_label(routine: Routine, first: int, index: int) -> int:
        ends = [place for place in routine.labels.get("ENDLABEL", []) if place > first]
        return ends[0] if ends else max(index, first)

    def _define(self, flow: Flow) -> None:
        kind, *rest = flow.names
        values = list(flow.values)
        for name, count in zip(rest[::2], rest[1::2]):
            sizes = [values.pop(0) for _ in range(int(count))]
            start = values.pop(0)
            made = self.memory.define(name, kind, tuple(whole(size(self.memory)) for size in sizes if size is not None))
            if start is not None and not sizes:
                made.set((), start(self.memory), name)

    def _calls(self, flow: Flow) -> None:
        if flow.kind == "PROC" or flow.kind == "EXTERN":
            self.actions.ignored(flow.kind)
        elif flow.kind == "MCALL" and flow.call is None:
            self.modal = None
        elif flow.kind == "ENDIF" or flow.kind == "ENDLABEL":
            return
        elif flow.call is None:
            raise Unread("a synchronous action (WHEN, ID=)", "what it does happens in its own time: remove it")
        else:
            arguments = [None if a is None else a(self.memory) for a in flow.call.arguments]
            if flow.kind == "MCALL":
                self.modal = flow.call, arguments
            else:
                self.call(flow.call, arguments)

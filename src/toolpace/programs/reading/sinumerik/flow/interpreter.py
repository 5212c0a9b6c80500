"""The execution of routines, block by block."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.flow import CALL, MAIN, CallStack
from toolpace.programs.reading.sinumerik.flow.jumps import DEEPEST, Frame, Jumps, times_of
from toolpace.programs.reading.sinumerik.flow.memory import Store, Variable
from toolpace.programs.reading.sinumerik.flow.routines import Library, Routine, StructureFault
from toolpace.programs.reading.sinumerik.syntax.blocks import Block, Call, Flow
from toolpace.programs.reading.sinumerik.syntax.expressions import Named
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value, whole
from toolpace.programs.reading.source import Source

SKIPPED = "/"
LATE = "DEF behind blocks that do something defines all the same (controls stop there: alarm 14500)"
DECLARATIONS = ("DEF", "PROC", "EXTERN")


class Actions(Protocol):
    """What blocks do beside flow."""

    def begin(self, line: int) -> None:
        """A block of this line comes next."""

    def execute(self, block: Block) -> bool:
        """Do what a block says; whether it programmed an axis of the path. Raises Unread, BlockError."""

    def perform(self, call: Call, arguments: list[Value | None]) -> bool:
        """Do a cycle or a command with arguments; False where it is none. Raises Unread, BlockError."""

    modal: tuple[Call, list[Value | None]] | None
    """What MCALL asked for, with its arguments."""

    def saved(self) -> Callable[[], None]:
        """What brings the modes back as they are, for a subprogram that saves them."""

    def ignored(self, word: str) -> None:
        """Count a word that moves nothing."""

    def assume(self, sentence: str) -> None:
        """Say what is taken for granted."""

    def refuse(self, word: str, line: int, cure: str) -> None:
        """Note a word that is not read."""


@dataclass
class Interpreter:
    """One run of a program."""

    source: Source
    library: Library
    actions: Actions
    memory: Store
    block_delete: bool = True
    ended: bool = field(default=False, init=False)
    stack: CallStack[Frame] = field(init=False)
    jumps: Jumps = field(init=False)

    def __post_init__(self) -> None:
        main = self.library.main
        self.stack = CallStack(Frame(kind=MAIN, routine=main, end=len(main.lines)), DEEPEST)
        self.jumps = Jumps(self.stack, self.memory)

    def run(self) -> None:
        """Execute the main program."""
        self._check(self.library.main)
        while self.stack:
            frame = self.stack[-1]
            if frame.next >= frame.end:
                self.stack.leave()
                continue
            index = frame.next
            frame.next += 1
            head, said = frame.routine.read(index)
            if not head.rest and not head.label:
                continue
            if head.skip and head.rest[:1].isdigit():
                self.source.fail(
                    "levels of / are 0 to 9 (alarm 14060): correct it", frame.called_at or frame.routine.first + index
                )
            if head.skip and self.block_delete:
                self.actions.ignored(SKIPPED)
                continue
            block, self.memory.literals = said
            line = frame.called_at or frame.routine.first + index
            self.actions.begin(line)
            try:
                if block.fault:
                    raise BlockError(block.fault)
                if block.flow is None or block.flow.kind not in DECLARATIONS:
                    frame.begun = frame.begun or bool(head.rest)
                elif frame.begun and block.flow.kind == "DEF":
                    self.actions.assume(LATE)
                if block.flow is not None:
                    if not self.jumps.apply(block.flow, frame, index):
                        self._call_of(block.flow)
                elif self.actions.execute(block) and self.actions.modal is not None and not frame.modal:
                    self._modal_call()
            except BlockError as error:
                where = f"{frame.routine.file} line {index + 1}: " if frame.routine.file else ""
                self.source.fail(where + str(error), line)
            except Unread as error:
                self.actions.refuse(error.word, line, error.cure)
                kind = "" if block.flow is None else block.flow.kind
                if kind in ("IF", "WHILE", "FOR"):
                    frame.next = frame.routine.nesting.following[index] + 1  # what cannot be decided is left out

    def _check(self, routine: Routine, line: int = 0) -> None:
        """ProgramError where the choices and loops of a routine have no partners."""
        try:
            routine.check()
        except StructureFault as error:
            where = f"{routine.file} line {error.index + 1}: " if routine.file else ""
            self.source.fail(where + str(error), line or routine.first + error.index)

    def end(self) -> None:
        """Leave the subprogram at hand; of the main program all (M30, M17, RET)."""
        while self.stack:
            frame = self.stack[-1]
            if frame.kind == CALL:
                frame.next = frame.end  # a call with P may begin again
                return
            self.stack.pop()
        self.ended = True

    def _modal_call(self) -> None:
        assert self.actions.modal is not None
        call, arguments = self.actions.modal
        if not self.actions.perform(call, arguments):
            self.call(call, arguments, modal=True)

    def call(self, call: Call, arguments: list[Value | None], *, modal: bool = False) -> None:
        """Begin a subprogram. Raises Unread where there is none of that name."""
        routine = self.library.find(call.name)
        if routine is None:
            raise Unread(
                call.name, "it is no word that is read, and no subprogram of this file or beside it: add its file"
            )
        again = 0 if call.times is None else times_of(whole(call.times(self.memory)), call.name) - 1
        caller = self.stack[-1] if self.stack else None  # MCALL behind the motion of a block with M30
        line = 0 if caller is None else caller.called_at
        if caller is not None and routine.file and not line:
            line = caller.routine.first + caller.next - 1
        self._check(routine, line)
        frame = Frame(routine=routine, end=len(routine.lines), again=again, outer=self.memory.local, called_at=line)
        frame.modal = modal or (caller is not None and caller.modal)
        self.stack.enter(frame, routine.name)
        frame.at_return.append(partial(setattr, self.memory, "local", frame.outer))
        self.memory.local = {}
        self._bind(routine, call, arguments)

    def _bind(self, routine: Routine, call: Call, arguments: list[Value | None]) -> None:
        """Give the parameters of PROC, which stands first in the routine, their values; those of VAR, the variables."""
        frame = self.stack[-1]
        for index in range(len(routine.lines)):
            head, said = routine.read(index)
            if head.rest:
                break
        else:
            return
        flow = said.block.flow
        if flow is None or flow.kind != "PROC":
            if arguments:
                raise BlockError(f"{routine.name} takes no arguments, it has no PROC with parameters: remove them")
            return
        names = flow.names
        if names[-1] == "SAVE" and len(names) % 2 == 0:
            names = names[:-1]
            frame.at_return.append(self.actions.saved())
        if len(arguments) > len(names) // 2:
            raise BlockError(f"{routine.name} takes {len(names) // 2} arguments, not {len(arguments)}: correct them")
        for k, (kind, name) in enumerate(zip(names[1::2], names[2::2])):
            named = call.arguments[k] if k < len(call.arguments) else None
            handed = frame.outer.get(named.name) if isinstance(named, Named) else None
            if kind.startswith("VAR ") and named is not None:
                self.memory.local[name] = _referred(handed, kind.removeprefix("VAR "), name)
                continue
            if handed is not None and handed.sizes:
                raise BlockError(f"{name} is one value, and is handed an array: write VAR before its type in PROC")
            variable = self.memory.define(name, kind.removeprefix("VAR "))
            argument = arguments[k] if k < len(arguments) else None
            default = flow.values[k]
            value = argument if argument is not None or default is None else default(self.memory)
            if value is not None:
                variable.set((), value, name)

    def _call_of(self, flow: Flow) -> None:
        """PROC, EXTERN, MCALL, CALL, EXTCALL, and what else is no jump."""
        if flow.kind in ("PROC", "EXTERN"):
            self.actions.ignored(flow.kind)
        elif flow.kind in ("RET", "ENDPROC"):
            self.end()
        elif flow.kind == "MCALL" and flow.call is None:
            self.actions.modal = None
        elif flow.call is None:
            raise Unread("a synchronous action (WHEN, ID=)", "what it does happens in its own time: remove it")
        else:
            arguments = values_of(flow.call, self.memory, arrays=flow.kind != "MCALL")
            if flow.kind == "MCALL":
                self.actions.modal = flow.call, arguments
            else:
                self.call(flow.call, arguments)


def values_of(call: Call, memory: Store, *, arrays: bool) -> list[Value | None]:
    """Values of the arguments of a call, None for each that is left out.

    arrays: whole arrays, which only subprograms take, are None too: they are handed over by name.
    """
    found: list[Value | None] = []
    for argument in call.arguments:
        variable = memory.local.get(argument.name) if arrays and isinstance(argument, Named) else None
        whole_array = variable is not None and bool(variable.sizes)
        found.append(None if argument is None or whole_array else argument(memory))
    return found


def _referred(handed: Variable | None, kind: str, name: str) -> Variable:
    """The variable that a parameter of VAR stands for (Programming Manual Job Planning, "Call by reference").

    Raises BlockError where something else is handed over, or one of another type.
    """
    if handed is None:
        raise BlockError(f"{name} is a parameter of VAR: hand over a variable of DEF, and no value or expression")
    if handed.kind != kind:
        raise BlockError(f"{name} is of type {kind} and stands for a variable of type {handed.kind}: correct one")
    return handed

"""Jumps, choices, loops, repetitions, and DEF: which block of a routine is next."""

from __future__ import annotations

from dataclasses import dataclass, field

from toolpace.programs.reading import flow as language
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.flow import CALL, PART, CallStack, times
from toolpace.programs.reading.sinumerik.flow.memory import Local, Store
from toolpace.programs.reading.sinumerik.flow.routines import Routine
from toolpace.programs.reading.sinumerik.syntax.blocks import Flow
from toolpace.programs.reading.sinumerik.syntax.values import Compiled, Row, Value, above, equal, real, whole

DEEPEST = {CALL: (15, " (alarm 14012)"), "": (59, "")}
"""Calls within each other (Job Planning, "Subprogram nesting": 16 levels with the main program), and repetitions."""
MOST_TIMES, TIMES_ALARM = 9999, " (alarm 14013)"
"""Of P."""


@dataclass(kw_only=True)
class Frame(language.Frame):
    """A routine that is being executed, or a part of it that is repeated."""

    routine: Routine
    end: int
    outer: Local = field(default_factory=dict)
    """Variables of the caller."""
    modal: bool = False
    """Whether MCALL made this call: blocks within make none."""
    begun: bool = False
    """Whether a block has been executed that declares nothing."""
    defined: dict[str, int] = field(default_factory=dict)
    """Index of the line of each DEF, by name."""


class Jumps:
    """Decides which block is next."""

    def __init__(self, stack: CallStack[Frame], memory: Store) -> None:
        self.stack, self.memory = stack, memory

    def apply(self, flow: Flow, frame: Frame, index: int) -> bool:
        """Carry out a block of flow; False where it is none of these. Raises BlockError, StructureFault, Unread."""
        kind = flow.kind
        if kind in ("GOTOF", "GOTOB", "GOTO", "GOTOC"):
            if self._holds(flow.values):
                self._jump(kind, flow.names[0], frame, index)
        elif kind == "GOTOS":
            if self._holds(flow.values):
                self._go(0, frame)
        elif kind in ("IF", "WHILE", "UNTIL"):
            # UNTIL goes back where its condition does not hold, IF and WHILE go on behind their ends
            if not self._holds(flow.values):
                nesting = frame.routine.nesting
                frame.next = (nesting.partner if kind == "UNTIL" else nesting.following)[index] + 1
        elif kind in ("ELSE", "LOOP", "REPEAT", "ENDLOOP", "ENDWHILE"):
            self._passed(kind, frame, index)
        elif kind in ("FOR", "ENDFOR"):
            self._for(flow, frame, index)
        elif kind == "CASE":
            self._case(flow, frame, index)
        elif kind in ("REPEAT label", "REPEATB label", "CALL BLOCK"):
            self._repeat(flow, frame, index)
        elif kind == "DEF":
            self._define(flow, frame, index)
        else:
            return kind in ("ENDIF", "ENDLABEL")
        return True

    def _holds(self, condition: tuple[Compiled | None, ...]) -> bool:
        return not condition or condition[0] is None or bool(real(condition[0](self.memory)))

    def _jump(self, kind: str, label: str, frame: Frame, index: int) -> None:
        target = frame.routine.target(kind, label, index)
        if target is not None:
            self._go(target, frame)
        elif kind != "GOTOC":
            direction = {"GOTOF": " below", "GOTOB": " above"}.get(kind, "")
            raise BlockError(f"there is no label {label}{direction} to jump to: write it, or correct its name")

    def _go(self, target: int, frame: Frame) -> None:
        while not frame.begin <= target < frame.end:
            # a jump out of a part that is repeated ends its repetition
            self.stack.pop()
            frame = self.stack[-1]
        frame.next = target

    def _passed(self, kind: str, frame: Frame, index: int) -> None:
        nesting = frame.routine.nesting
        if kind == "ELSE":
            frame.next = nesting.following[index] + 1
        elif kind in ("ENDLOOP", "ENDWHILE"):
            frame.next = nesting.partner[index]

    def _for(self, flow: Flow, frame: Frame, index: int) -> None:
        if flow.kind == "ENDFOR":
            start = frame.routine.nesting.partner[index]
            opening = frame.routine.read(start)[1].block.flow
            assert opening is not None
            place = self._variable(opening)
            value: Value = real(self._value(opening, place)) + 1.0
            frame.next = start
        else:
            start, opening = index, flow
            place = self._variable(flow)
            assert flow.values[0] is not None
            value = flow.values[0](self.memory)
        self.memory.assign(opening.names[0], place, value)
        last = opening.values[1]
        assert last is not None
        beyond = above(value, last(self.memory))
        frame.next = (frame.routine.nesting.partner[start] if beyond else start) + 1

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
            raise BlockError(f"there is no label {flow.names[0]} to repeat from: write it, or correct its name")
        end = first + 1 if flow.kind == "REPEATB label" else index
        if len(flow.names) > 1:
            last = frame.routine.target("GOTOF", flow.names[1], first - 1)
            if last is None:
                raise BlockError(f"there is no label {flow.names[1]} behind {flow.names[0]}: write it, or correct it")
            end = last + 1
        elif flow.kind == "REPEAT label":
            end = self._to_end_label(frame.routine, first, index)
        count = flow.values[0]
        again = 0 if count is None else times_of(whole(count(self.memory)), flow.names[0]) - 1
        if first < end:
            part = Frame(kind=PART, next=first, begin=first, end=end, again=again, routine=frame.routine)
            part.modal, part.called_at = frame.modal, frame.called_at
            self.stack.enter(part, frame.routine.name or "the program")

    @staticmethod
    def _to_end_label(routine: Routine, first: int, index: int) -> int:
        ends = [place for place in routine.labels.all("ENDLABEL") if place > first]
        if ends and routine.read(ends[0])[0].rest.strip():
            raise BlockError(
                "ENDLABEL: beside other words: whether they are repeated is not told; write it in a block of its own"
            )
        return ends[0] if ends else max(index, first)

    def _define(self, flow: Flow, frame: Frame, index: int) -> None:
        kind, *rest = flow.names
        values = list(flow.values)
        for name, count in zip(rest[::2], rest[1::2]):
            sizes = [values.pop(0) for _ in range(int(count))]
            start = values.pop(0)
            if frame.defined.setdefault(name, index) != index:
                raise BlockError(f"{name} is defined twice (alarm 12170): remove one DEF of it")
            made = self.memory.define(name, kind, tuple(whole(size(self.memory)) for size in sizes if size is not None))
            if start is not None:
                value = start(self.memory)
                if sizes and not isinstance(value, Row):
                    raise BlockError(f"is the value of {name} for all elements, or for the first? Write REP() or SET()")
                made.set((0,) * len(sizes), value, name)


def times_of(value: int, name: str) -> int:
    """How often a subprogram or a part is executed. Raises BlockError."""
    return times(value, f"{name} P=", MOST_TIMES, TIMES_ALARM)

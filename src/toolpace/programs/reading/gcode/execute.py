"""The execution of a block: its words in the controller's order."""

from __future__ import annotations

from collections.abc import Callable

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.compensation import FORBIDDEN_FUNCTIONS, Compensation
from toolpace.programs.reading.gcode.frames.frames import Frames
from toolpace.programs.reading.gcode.frames.planes import MEANINGS, Planes
from toolpace.programs.reading.gcode.functions import Functions, IdleWords, Modes, SavedModes
from toolpace.programs.reading.gcode.holes import KINDS, Holes
from toolpace.programs.reading.gcode.least_input_increment import count_increments, round_values
from toolpace.programs.reading.gcode.machine_moves import MachineMoves
from toolpace.programs.reading.gcode.modal import ARCS, Modal
from toolpace.programs.reading.gcode.motion import MotionReader
from toolpace.programs.reading.gcode.program import alarms
from toolpace.programs.reading.gcode.program.blocks import Block
from toolpace.programs.reading.gcode.program.calls import ARGUMENTS, Calls, Missing
from toolpace.programs.reading.gcode.program.expressions import value_of
from toolpace.programs.reading.gcode.program.flow import Flow
from toolpace.programs.reading.gcode.program.words import (
    GROUP_OF,
    LENGTHS,
    Handler,
    Numbers,
    RefusedError,
    bounded,
    increment,
    near_whole,
)
from toolpace.programs.reading.gcode.splines import SPLINES, Splines
from toolpace.programs.reading.gcode.surface_holes import SurfaceHoles
from toolpace.programs.reading.gcode.tools import Tools
from toolpace.programs.reading.options import ReadOptions

AS_WRITTEN = (
    "numbers without a decimal point are whole millimetres, inches or degrees "
    '(whole_numbers = "least increment" in the controller\'s file counts them otherwise)'
)
SMOOTHNESS = "G187"
"""Of Haas: E tells how far corners may be rounded, none that it is as the control's settings say."""
WHOLE = frozenset("HLT")
"""Letters of which LinuxCNC takes what is next to a whole number for it."""
MOTIONS = ("rapid", "feed", *ARCS)
PASSED = ("S", "T", "H", "D")
"""Spindle speed and tool numbers: counted, since nothing moves by them."""
FREE = ("P", "Q", "E", "L", "R", "K", "I", "J")
"""Letters that belong to a word of their block that moves nothing."""
LENGTHS_OF_MACROS = frozenset("IJK").union(ARGUMENTS) - frozenset("DHMST")
"""Arguments that are no whole numbers by their letter."""
NO_MACRO = (
    "its blocks are neither in this file nor in one beside it: give them with the program; where it measures and comes "
    "back to where it began, --skip-unknown passes over it"
)


class Executor:
    """The words of blocks, and what each makes the control do."""

    def __init__(self, control: Control, state: Modal, flow: Flow, by: Controller, options: ReadOptions) -> None:
        self.control, self.state, self.variables = control, state, flow.variables
        self.motion = MotionReader(control, state, by)
        self.holes = Holes(control, state, self.motion, by)
        self.splines = Splines(control, state, self.motion)
        self.modes = Modes(control, state, self.holes, by)
        self.calls = Calls(flow, by)
        self.least_increment = by.option("whole_numbers", "as written") == "least increment"
        self.rounds = by.option("values_are_rounded", False)
        """Whether values of expressions are rounded to the least increment of their word."""
        self.variables.increment = lambda letter: increment(letter, state.unit)
        self.variables.say = control.findings.assumed
        self.rs274 = by.option("rs274_checks", False)
        self.planner_by_r = by.option("planner_by_r", False)
        self.whole_varies = by.option("whole_numbers_vary", False)
        self.indexed = by.option("indexed_words", False)
        self.macros = Macros(control, state, self.motion, self.calls, by)
        self.after: Callable[[], None] | None = None
        """What is left to do behind the motion of the block."""
        self.pattern = ""
        """The word of this block that lays a pattern of holes."""
        frames = Frames(control, state, by)
        self.machine_moves = MachineMoves(control, state, self.motion, frames, by)
        self.planes = Planes(control, state, frames, self.variables, by)
        self.tools = Tools(control, state, by)
        self.compensation = Compensation(control, state, options, by)
        self.handlers: dict[str, Handler] = self.compensation.guarded(
            self.modes.handlers()
            | self.tools.handlers()
            | self.compensation.handlers()
            | frames.handlers()
            | SavedModes(control, state, frames, flow).handlers()
            | {meaning: self._spline(meaning) for meaning in SPLINES}
            | self.machine_moves.handlers()
            | self.planes.handlers()
            | Functions(control, state, flow.variables).handlers()
            | SurfaceHoles(control, state, self.motion).handlers()
            | IdleWords(control.findings).handlers()
            | {
                "hole circle": self._hole_circle,
                "hole arc": self._hole_circle,
                "modal macro off": self.calls.modal_off,
                "call program": self.calls.program,
                "call here": self.calls.here,
                "return": self.calls.back,
                "program stop": self._program_stop,
                "end": self._end,
                "end of nurbs": self._end_of_nurbs,
            }
        )

    def execute(self, block: Block) -> None:
        """Execute the words of a block. Raises BlockError, ArcError, ProgramError."""
        state, control, actions, handlers = self.state, self.control, block.actions, self.handlers
        state.stop_here = state.in_machine = state.at_home = state.cycle_word = False
        if self.planes.blocks and not any(action.meaning in MEANINGS for action in actions):
            self.planes.need_whole()
        numbers = self._numbers(block)
        moves, corner = len(control.moves), self.motion.corners.waiting
        if self.rs274:
            self._refuse_unused(block, numbers)
            if control.stage is not None:
                self._refuse_functions(block)
        if actions:
            if self.splines.opened is not None:
                self.splines.close()
            motions = [action.meaning for action in actions if action.meaning in MOTIONS]
            state.arc_here = (motions[0] if motions else state.motion) in ARCS
            own_cycle = any(action.meaning in KINDS for action in actions)
            state.drills_here = own_cycle or (not motions and state.cycle is not None)
        for action in actions[: block.before_feed]:
            handlers[action.meaning](numbers, action.word)
        number = numbers.pop("F", None) if numbers else None
        if number == 0.0 and control.feed.mode != INVERSE:
            control.feed.value = None  # an error of the first motion at feed only
        elif number is not None:
            control.feed.set(number, state.unit, control.line)
        if "S" in numbers:
            if numbers["S"] < 0.0:
                raise BlockError(f"S{numbers['S']:g} is below zero: M3 and M4 tell the way the spindle turns")
            control.turn_spindle(numbers["S"] / 60.0)
            control.moves.switch()
        if "T" in numbers:
            if self.rs274 and not (numbers["T"] >= 0.0 and numbers["T"] == int(numbers["T"])):
                raise BlockError(f"T{numbers['T']:g} is no number of a tool: write a whole one, from 0")
            state.next_tool = f"{numbers['T']:g}"
        self.after, self.pattern = None, ""
        for action in actions[block.before_feed :]:
            handlers[action.meaning](numbers, action.word)
        if "H" in numbers and not any(action.meaning in ("call program", "call here") for action in actions):
            self.tools.number_alone(numbers)
        for word in block.ignored:
            control.findings.ignored(word)
            if word == SMOOTHNESS:
                control.moves.ask(tip=numbers.get("E", 0.0) * state.unit)
            if word.startswith("M"):
                control.moves.switch()
        if numbers or (state.cycle_word and self.rs274):
            if block.ignored:
                self._idle(numbers)
            self._rest(numbers, number, bool(block.ignored or actions))
        if corner is not None and actions and self.motion.corners.waiting is corner:
            self.motion.corners.refuse()  # a block that does not move it stops with an alarm (051)
        if state.stop_here:
            control.stop()
        elif state.exact_stop:
            control.moves.stop_by_mode()
        if self.after is not None:
            self.after()
        if control.stage is not None:
            self.compensation.behind_block(moves)

    def _refuse_functions(self, block: Block) -> None:
        """What LinuxCNC's interpreter refuses under compensation, and switches before a G40 of the block."""
        for word in (*block.ignored, *(action.word for action in block.actions)):
            if word in FORBIDDEN_FUNCTIONS:
                self.compensation.refuse(word)

    def _refuse_unused(self, block: Block, numbers: Numbers) -> None:
        """Take letters that no word uses out of a block of LinuxCNC, each with an alarm; and see what is in force."""
        state = self.state
        for letter in numbers.keys() & WHOLE | ({"P"} if "G10" in block.words and "P" in numbers else set()):
            numbers[letter] = near_whole(numbers[letter], 1e-4)
        if not numbers.keys() <= alarms.PLAIN or not alarms.NEEDED.keys().isdisjoint(block.words):
            letters = numbers.keys() - ({"R"} if self.planner_by_r and "G64" in block.words else set())
            for letter, alarm in alarms.of_letters(letters, block.words, state.motion_word):
                numbers.pop(letter, None)
                self.control.findings.stops(alarm.what, self.control.line, alarm.cure)
        alarms.refuse_motionless(numbers.keys(), block.words, state.motion_word)
        for meaning, word in block.actions:
            if GROUP_OF[meaning] in ("motion", "end of cycle"):
                state.motion_word = word

    def _numbers(self, block: Block) -> Numbers:
        """The words of a block with their values."""
        numbers, state = dict(block.fixed), self.state
        for letter, node in block.computed:
            value = value_of(node, self.variables)
            if value is not None:
                numbers[letter] = bounded(value)
        if self.rounds and block.computed:
            round_values(numbers, block, state)
        state.whole = block.whole
        if block.computed or state.reckoned:
            state.reckoned = frozenset(letter for letter, _ in block.computed)
        if block.whole and self.least_increment:
            count_increments(numbers, block, state, self.holes.repeats)
        elif self.whole_varies and block.whole & LENGTHS:
            self.control.findings.assumed(AS_WRITTEN)
        numbers.pop("N", None)
        return numbers

    def _rest(self, numbers: Numbers, number: float | None, free: bool) -> None:
        """What no word of the block has taken: the motion, and letters that mean nothing for it."""
        state, control, slots = self.state, self.control, self.control.slots
        if "D" in numbers:
            self.compensation.choose(numbers["D"])
        for letter in PASSED:
            if numbers.pop(letter, None) is not None:
                control.findings.ignored(letter)
        if state.in_machine:
            self.machine_moves.in_machine(numbers, rapid=state.motion in (None, "rapid"))
        elif state.cycle is not None:
            if state.scaled and "Q" in numbers:
                numbers.clear()
                raise RefusedError("Q of a cycle in scaled coordinates", "it is not scaled: end the scale before (G50)")
            dwell = numbers.pop("P", None)
            if self.pattern:
                numbers["I"], numbers["J"] = numbers.get("I", 0.0), numbers.get("J", 0.0)
                self.holes.on_circle(numbers, each=self.pattern == "G71")
                return
            self.holes.execute(numbers, None if dwell is None else self.modes.seconds(dwell))
            return
        if state.motion in SPLINES:
            self.splines.execute(numbers, number)
            return
        if not any(letter in slots or letter in "XYZABCUVW" for letter in numbers):
            self._without_axes(numbers, free)
        if numbers:
            self.motion.execute(numbers, number, control.line)

    def _idle(self, numbers: Numbers) -> None:
        """Letters of a word that moves nothing, beside a motion that does not need them (G187 P1 E.01)."""
        if self.rs274:  # of M67 and M68
            for letter in "EQ" if self.state.motion in ARCS else "E":
                numbers.pop(letter, None)
        if self.state.cycle is None and self.state.motion not in ARCS:
            for letter in "PQE":
                numbers.pop(letter, None)

    def _without_axes(self, numbers: Numbers, free: bool) -> None:
        """Letters beside which no axis stands: of a full circle, of an idle word, or a mistake."""
        circle = self.state.motion in ARCS and any(letter in numbers for letter in "IJKR")
        if circle or (self.state.vectors and any(letter in numbers for letter in "IJK")):
            return
        for letter in FREE if free or self.indexed else ():
            if numbers.pop(letter, None) is not None:
                self.control.findings.ignored(letter)

    def _hole_circle(self, numbers: Numbers, word: str) -> None:
        """Haas G70 and G71: the cycle in force on a circle about the place at hand. Its lathes turn with them."""
        if numbers.keys() & {"P", "Q", "U", "W", "D"}:
            numbers.clear()
            raise RefusedError(
                word, "with P, Q, U, W or D it is a cycle of turning: only programs for milling are read"
            )
        if self.state.cycle is None:
            raise BlockError(f"{word} drills with the cycle in force: write one before it, with L0 for its own hole")
        self.pattern = word

    def close(self) -> None:
        """The program ends: what waits for a further block is not to come."""
        self.splines.close()
        self.planes.need_whole()
        self.motion.corners.refuse()

    def _spline(self, meaning: str) -> Handler:
        return lambda numbers, word: self.splines.begin(meaning)

    def _end_of_nurbs(self, numbers: Numbers, word: str) -> None:
        self.state.motion = None

    def _program_stop(self, numbers: Numbers, word: str) -> None:
        def stop() -> None:
            self.compensation.pause()
            self.control.stop()

        self.after = stop

    def _end(self, numbers: Numbers, word: str) -> None:
        self.after = self.compensation.pause
        self.state.ended = True


class Macros:
    """Carries out G65 and G66."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader, calls: Calls, by: Controller) -> None:
        self.control, self.state, self.motion, self.calls, self.controller = control, state, motion, calls, by
        self.least_increment = by.option("whole_numbers", "as written") == "least increment"

    def call(self, block: Block, word: str, *, modal: bool) -> None:
        """G65 and G66. Raises RefusedError where what is called is not at hand, and moves in no way that is known."""
        if self.least_increment and block.whole & LENGTHS_OF_MACROS:
            raise RefusedError("arguments of a macro without a point", "what they count goes by their letter: write it")
        missing = (self.calls.modal_macro if modal else self.calls.macro)(block.arguments, word)
        if missing is None:
            return
        if missing.word in self.controller.ignored:
            self.control.findings.ignored(missing.word)
        elif self.controller.meanings.get(missing.word) == "feed":
            self._protected(missing)
        else:
            raise RefusedError(missing.word, NO_MACRO)

    def _protected(self, missing: Missing) -> None:
        """Probing's way between its measurements: straight to X, Y, Z, at the feed F that it is given."""
        state, control, arguments = self.state, self.control, missing.local
        before = state.motion, control.feed.value, control.feed.turn
        found = {letter: arguments.get(ARGUMENTS[letter]) for letter in "XYZ"}
        feed = arguments.get(ARGUMENTS["F"])
        if feed is not None:
            control.feed.set(feed, state.unit, control.line)
        state.motion = "feed"
        self.motion.execute({key: value for key, value in found.items() if value is not None}, None, control.line)
        state.motion, control.feed.value, control.feed.turn = before

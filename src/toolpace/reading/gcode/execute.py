"""Executes blocks: their words in the order in which a controller acts on them."""

from __future__ import annotations

from collections.abc import Callable

from toolpace.reading.control.control import Control
from toolpace.reading.control.feed import INVERSE, PER_MINUTE, PER_REVOLUTION
from toolpace.reading.controllers.controller import Controller
from toolpace.reading.gcode.blocks import Block, Compiler
from toolpace.reading.gcode.calls import Calls
from toolpace.reading.gcode.expressions import value_of
from toolpace.reading.gcode.flow import Flow
from toolpace.reading.gcode.frames import Frames, Numbers
from toolpace.reading.gcode.holes import KINDS, Holes
from toolpace.reading.gcode.modal import Modal
from toolpace.reading.gcode.motion import MotionReader
from toolpace.reading.gcode.places import Places
from toolpace.reading.gcode.surface_holes import SurfaceHoles
from toolpace.reading.gcode.tools import Tools
from toolpace.reading.gcode.variables import Variables
from toolpace.reading.gcode.words import WordError
from toolpace.reading.options import ReadOptions
from toolpace.units import INCH, MILLIMETRE

Handler = Callable[[Numbers, str], None]
LENGTHS = frozenset("XYZABCUVWIJRQ")
"""Letters whose numbers are lengths or angles, and may count least increments where they have no point."""
LEAST = {MILLIMETRE: 0.001, INCH: 0.0001}
"""Least increment of a length, by unit; of angles it is always the first."""
PASSED = ("S", "T", "H", "D")
"""Spindle speed and tool numbers: counted, since nothing moves by them."""
FREE = ("P", "Q", "E", "L", "R", "H", "D", "S", "K", "I", "J")
"""Letters that belong to a word of their block that moves nothing."""


class Executor:
    """The words of blocks, and what each makes the control do."""

    def __init__(
        self, control: Control, state: Modal, flow: Flow, compiler: Compiler, by: Controller, options: ReadOptions
    ) -> None:
        self.control, self.state, self.flow, self.compiler = control, state, flow, compiler
        self.variables: Variables = flow.variables
        self.motion = MotionReader(control, state, by)
        self.frames = Frames(control, state, by.option("scale_of_whole", 1.0))
        self.places = Places(control, state, self.motion, self.frames, self.variables, by)
        self.holes = Holes(control, state, self.motion, by)
        self.surface_holes = SurfaceHoles(control, state, self.motion)
        self.tools = Tools(control, state, options)
        self.calls = Calls(flow, by)
        self.least_increment = by.option("whole_numbers", "as written") == "least increment"
        self.whole_varies = by.option("whole_numbers_vary", False)
        self.dwell_whole: float = by.option("dwell_whole_s", 1.0)
        self.dwell_point: float = by.option("dwell_point_s", 1.0)
        self.cycles_apart = by.option("cycles_are_a_group", False)
        self.indexed = by.option("indexed_words", False)
        self.whole: frozenset[str] = frozenset()
        self.handlers = self._modes() | self._actions()

    def _modes(self) -> dict[str, Handler]:
        state, control, tools, frames = self.state, self.control, self.tools, self.frames

        def setting(name: str, value: object) -> Handler:
            return lambda numbers, word: setattr(state, name, value)

        def feed_mode(mode: str) -> Handler:
            return lambda numbers, word: control.feed.set_mode(mode)

        return {
            "inverse time": feed_mode(INVERSE),
            "feed per minute": feed_mode(PER_MINUTE),
            "feed per revolution": feed_mode(PER_REVOLUTION),
            "inch": setting("unit", INCH),
            "millimetre": setting("unit", MILLIMETRE),
            "plane XY": setting("plane", 0),
            "plane ZX": setting("plane", 1),
            "plane YZ": setting("plane", 2),
            "absolute": setting("absolute", True),
            "incremental": setting("absolute", False),
            "arc centre absolute": setting("arc_absolute", True),
            "arc centre incremental": setting("arc_absolute", False),
            "exact stop mode": setting("exact_stop", True),
            "continuous path": self._continuous,
            "to initial level": setting("to_initial", True),
            "to R level": setting("to_initial", False),
            "polar": self._polar,
            "cartesian": setting("polar", False),
            "compensation": tools.compensation,
            "compensation off": tools.compensation_off,
            "tool length": tools.length,
            "tip mode": tools.tip_mode,
            "tip mode that stands": tools.tip_mode_that_stands,
            "tool vector mode": tools.vector_mode,
            "length off": tools.length_off,
            "stop": tools.stop,
            "tool change": tools.change,
            "tip mode on": tools.switch_on,
            "tip mode off": tools.switch_off,
            "work offset": frames.indexed_offset if self.indexed else frames.work_offset,
            "numbered offset": frames.numbered_offset,
            "no offset": frames.no_offset,
            "scale": frames.scale,
            "scale off": frames.scale_off,
            "mirror": frames.mirror,
            "mirror off": frames.mirror_off,
            "rotate": frames.rotate,
            "rotation off": frames.rotation_off,
            "exact stop": setting("stop_here", True),
            "machine coordinates": setting("in_machine", True),
        }

    def _actions(self) -> dict[str, Handler]:
        places, frames, surface, calls = self.places, self.frames, self.surface_holes, self.calls
        motions = ("rapid", "feed", "arc clockwise", "arc counter-clockwise")
        return {
            "tilt plane": places.tilt_plane,
            "carried frame": places.carried_frame,
            "tilt by axes": places.tilt_by_axes,
            "turn to plane": places.turn_to_plane,
            "dwell": self._dwell,
            "reference": places.reference,
            "second reference": places.second_reference,
            "from reference": places.from_reference,
            "machine rapid": places.machine_rapid,
            "set offset": frames.set_offset,
            "local shift": frames.local_shift,
            "set position": frames.set_position,
            "clear position": frames.clear_position,
            "suspend position": frames.suspend_position,
            "restore position": frames.restore_position,
            "datum": frames.datum,
            "datum added": frames.datum_added,
            "define drill": surface.drill,
            "define peck": surface.peck,
            "define tap": surface.tap,
            "define bore": surface.bore,
            "define bore and stop": surface.bore_and_stop,
            "run cycle": surface.run,
            **{meaning: self._motion(meaning) for meaning in motions},
            **{meaning: self._cycle(meaning) for meaning in KINDS},
            "end cycle": self._end_cycle,
            "call program": calls.program,
            "call here": calls.here,
            "return": calls.back,
            "program stop": self._program_stop,
            "end": self._end,
        }

    # Blocks

    def execute(self, block: Block) -> None:
        """Execute the words of a block. Raises WordError, ArcError, ProgramError."""
        state, control = self.state, self.control
        numbers = self._numbers(block)
        actions = block.actions
        state.stop_here = state.in_machine = state.at_home = False
        self.cycle_word = False
        handlers = self.handlers
        for action in actions[: block.before_feed]:
            handlers[action.meaning](numbers, action.word)
        number = numbers.pop("F", None)
        if number is not None:
            control.feed.set(number, state.unit, control.line)
        if "S" in numbers:
            control.feed.spindle = numbers["S"] / 60.0
        if "T" in numbers:
            state.next_tool = f"{numbers['T']:g}"
        self.after: Callable[[], None] | None = None
        for action in actions[block.before_feed :]:
            handlers[action.meaning](numbers, action.word)
        for word in block.ignored:
            control.findings.ignored(word)
        if numbers:
            self._rest(numbers, number, bool(block.ignored) or bool(actions))
        if state.stop_here or state.exact_stop:
            control.stop()
        if self.after is not None:
            self.after()

    def _numbers(self, block: Block) -> Numbers:
        """The words of a block with their values."""
        numbers = dict(block.fixed)
        for letter, node in block.computed:
            value = value_of(node, self.variables)
            if value is not None:
                numbers[letter] = value
        self.whole = block.whole
        if self.whole and (self.least_increment or self.whole_varies):
            self._whole_numbers(numbers)
        numbers.pop("N", None)
        return numbers

    def _whole_numbers(self, numbers: Numbers) -> None:
        least = LEAST[self.state.unit]
        counted = self.whole & LENGTHS
        for letter in counted:
            if self.least_increment:
                numbers[letter] *= 0.001 if letter in "ABC" else least
        if counted and not self.least_increment:
            self.control.findings.assumed(
                "numbers without a decimal point are whole millimetres, inches or degrees "
                '(whole_numbers = "least increment" in the controller\'s file counts them otherwise)'
            )

    def _rest(self, numbers: Numbers, number: float | None, free: bool) -> None:
        """What no word of the block has taken: the motion, and letters that mean nothing for it."""
        state, control = self.state, self.control
        for letter in PASSED:
            if numbers.pop(letter, None) is not None:
                control.findings.ignored(letter)
        if state.in_machine:
            self.places.in_machine(numbers, rapid=state.motion in (None, "rapid"))
        elif state.cycle is not None:
            dwell = numbers.pop("P", None)
            seconds = None if dwell is None else self._seconds("P", dwell)
            self.holes.execute(numbers, seconds, self.cycle_word)
            return
        slots, along = control.slots, self.motion.along
        if numbers and not any(letter in slots or letter in "XYZABCUVW" or letter == along for letter in numbers):
            self._without_axes(numbers, free)
        if numbers:
            self.motion.execute(numbers, number, control.line)

    def _without_axes(self, numbers: Numbers, free: bool) -> None:
        """Letters beside which no axis stands: of a full circle, of an idle word, or a mistake."""
        circle = self.state.motion in ("arc clockwise", "arc counter-clockwise")
        if circle and any(letter in numbers for letter in "IJKR"):
            return
        if self.state.vectors and any(letter in numbers for letter in "IJK"):
            return
        for letter in FREE if free or self.indexed else ():
            if numbers.pop(letter, None) is not None:
                self.control.findings.ignored(letter)

    # Modes that are more than a value

    def _motion(self, meaning: str) -> Handler:
        def chosen(numbers: Numbers, word: str) -> None:
            self.state.motion, self.state.cycle = meaning, None

        return chosen

    def _cycle(self, meaning: str) -> Handler:
        def chosen(numbers: Numbers, word: str) -> None:
            if self.state.cycle is None:
                self.holes.begin()
            self.state.cycle = meaning
            self.cycle_word = self.holes.drills_again
            if not self.cycles_apart:
                self.state.motion = None

        return chosen

    def _end_cycle(self, numbers: Numbers, word: str) -> None:
        self.state.cycle = None
        if not self.cycles_apart:
            self.state.motion = None

    def _continuous(self, numbers: Numbers, word: str) -> None:
        self.state.exact_stop = False
        if self.state.motion in ("arc clockwise", "arc counter-clockwise") and "P" in numbers:
            return  # P counts the turns of the arc too
        if (numbers.pop("P", None) is not None) | (numbers.pop("Q", None) is not None):
            # the tolerance of the path is given to the fit, not by the program
            self.control.tolerance(f"{word} P")

    def _polar(self, numbers: Numbers, word: str) -> None:
        self.state.polar, self.state.pole = True, {}

    def _seconds(self, letter: str, value: float) -> float:
        return value * (self.dwell_whole if letter in self.whole or letter not in "PXU" else self.dwell_point)

    def _dwell(self, numbers: Numbers, word: str) -> None:
        for letter, by in (("P", None), ("X", 1.0), ("U", 1.0), ("F", 1.0)):
            if letter in numbers:
                value = numbers.pop(letter)
                self.control.dwell(self._seconds("P", value) if by is None else value)
                break
        else:
            raise WordError(f"{word} needs its time as P in seconds: write it like {word} P0.5")
        if any(letter in "XYZABCUVW" for letter in numbers):
            raise WordError(f"{word} takes its time alone: write the motion in a block of its own")

    def _program_stop(self, numbers: Numbers, word: str) -> None:
        self.after = self.control.stop

    def _end(self, numbers: Numbers, word: str) -> None:
        self.state.ended = True

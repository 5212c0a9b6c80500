"""M functions, by the controller's file."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import NamedTuple

from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import PER_MINUTE, PER_REVOLUTION, SENSES
from toolpace.programs.reading.control.machine_moves import direction_on_part, retract, straight_in_machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import TURN
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import Motion, Step
from toolpace.programs.reading.heidenhain.drilling import Holes
from toolpace.programs.reading.heidenhain.flow import Flow
from toolpace.programs.reading.heidenhain.frames import Frames
from toolpace.programs.reading.heidenhain.parameters import Value, evaluate
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.heidenhain.words import Function, PathWords, code_of

UNKNOWN = "leave it out if it moves nothing, or name it under `ignored` in the controller's file"
UNTILTED = (
    "M130: X, Y and Z are the linear axes as without the plane (under M128 the tip), and what was programmed in the "
    "plane does not count"
)
MOST_FUNCTIONS = 4
"""Of a block (TNC 640 Klartext, "Entering miscellaneous functions M"; iTNC 530 takes two)."""


class Functions(NamedTuple):
    """The M functions of a block."""

    before: list[Step]
    after: list[Step]
    place: str
    """In which coordinates the block is: "machine", "untilted", or "" for the program's."""


OF_CORNERS = ("M97", "M98")
OF_HEIDENHAIN = frozenset((0, 1, 2, 3, 4, 5, 6, 8, 9, 13, 14, 30))
"""M functions up to M88 that the control itself has (TNC 640, Klartext, "M functions"); others are the builder's."""


class MachineFunctions:
    """Compiles M functions by their meanings."""

    def __init__(
        self,
        control: Control,
        state: State,
        motion: Motion,
        frames: Frames,
        holes: Holes,
        flow: Flow,
        controller: Controller,
    ) -> None:
        self.control, self.state, self.motion, self.frames = control, state, motion, frames
        self.holes, self.flow, self.controller = holes, flow, controller
        self.builder = controller.option("builder_functions", "ignored")
        self.at_start: dict[str, Callable[[Function], Step]] = {
            "tip mode on": lambda _: lambda: self.tip_mode(True),
            "shortest rotary on": lambda _: lambda: self.shortest(True),
            "feed per revolution": lambda _: lambda: self.feed_mode(True),
            "reduce rotary": self.reduced,
            "retract": self.retracted,
            "noted": self.noted,
            "look ahead": lambda function: lambda: motion.compensation.look_ahead(function.words.get("LA")),
            "tilting axes": lambda function: lambda: tilting_axes(control, function.words),
        }
        self.at_end: dict[str, Callable[[Function], Step]] = {
            "tip mode off": lambda _: lambda: self.tip_mode(False),
            "shortest rotary off": lambda _: lambda: self.shortest(False),
            "feed per minute": lambda _: lambda: self.feed_mode(False),
            "stop": lambda _: control.stop,
            "end": lambda _: self.end,
            "cycle call": lambda _: self.call,
            "cycle call everywhere": lambda _: self.call_everywhere,
        }

    def compile(self, words: PathWords) -> Functions:
        """Steps of the M functions of a block. Raises BlockError."""
        made = Functions([], [], "")
        if len(words.functions) > MOST_FUNCTIONS:
            raise BlockError(f"more than {MOST_FUNCTIONS} M functions in one block: divide it")
        for function in words.functions:
            if not isinstance(function.code, float):
                made.before.append(self.refused("M with a Q parameter", "write the number of the M function"))
                continue
            word = f"M{code_of(function)}"
            meaning = self.controller.meanings.get(word, "")
            if meaning in ("machine coordinates", "untilted coordinates"):
                made = made._replace(place=meaning.split()[0])
                if meaning.startswith("machine") and word != "M91":
                    made.before.append(self.noted(function))
            elif meaning in self.at_start:
                made.before.append(self.at_start[meaning](function))
            elif meaning in self.at_end:
                made.after.append(self.at_end[meaning](function))
            else:
                made.before.append(self.other(word))
        return made

    def other(self, word: str) -> Step:
        """A function without a meaning for motion, or one that is refused."""
        findings = self.control.findings
        if word in OF_CORNERS:
            return lambda: self.corner(word)
        if word in self.controller.ignored:
            return lambda: self.passed(word)
        if word in self.controller.refused:
            return self.refused(word, self.controller.refused[word])
        code = int(word[1:])
        if self.builder == "ignored" and not (code in OF_HEIDENHAIN or 89 <= code <= 149):
            said = f"{word} is a function of the machine's builder, taken to move nothing"

            def run() -> None:
                findings.ignored(word)
                findings.assumed(said)

            return run
        return self.refused(word, UNKNOWN)

    def passed(self, word: str) -> None:
        """A function that moves nothing; what it does to the spindle counts for the cut."""
        self.control.findings.ignored(word)
        if word in SENSES:
            self.control.turn_spindle(word=word)

    def corner(self, word: str) -> None:
        """M97 and M98, which change corners of a compensated contour, and nothing else."""
        if self.motion.compensation.follower is not None:
            self.control.refuse(word, "corners of a compensated contour are read as they are without it: remove it")
        else:
            self.control.findings.ignored(word)

    def refused(self, word: str, cure: str) -> Step:
        """A step that notes a refused word."""
        return lambda: self.control.refuse(word, cure)

    def noted(self, function: Function) -> Step:
        """A function that is taken in a certain way, which the controller's file tells under `options`."""
        word = f"M{code_of(function)}"
        said = self.controller.option(f"{word}_means", "taken to move nothing")
        return lambda: self.control.findings.assumed(f"{word}: {said}")

    def tip_mode(self, on: bool, centre: float = 0.0) -> None:
        """M128 and M129; also FUNCTION TCPM and its reset.

        centre: how far [m] above the tip the point of the tool is that the words name (REFPNT CENTER-CENTER: the
        centre of its corner radius); as if the tool were that much shorter.
        """
        self.state.tip_mode = on
        if not on:
            self.state.spatial = False
        elif any(abs(value) > ROUNDING for value in self.control.words[3:]):
            where = "stand here" if self.control.rules.fixed_where_switched else "are at zero"
            self.control.findings.assumed(f"M128 fixes X, Y, Z to the part as it lies where the tables {where}")
        self.control.set_tip_mode(on)
        if centre != self.state.centre:
            oversize = self.control.coordinates.oversize + self.state.centre - centre
            self.control.set_length(self.control.tool, oversize)
            self.state.centre = centre
        self.check_preset()

    def check_preset(self) -> None:
        """Refuse M128 where the preset shifts a rotary axis that carries the part.

        Whether the part is thought to be turned by that is a parameter of the machine (CfgPresetSettings,
        presetToAlignAxis). A datum shift of the program is a position of the axis ("M128 on tilting tables").
        """
        control = self.control
        if control.poses.machine is None or not self.state.tip_mode:
            return
        offset = control.datum.origin(control.coordinates.offset)[3:]
        if any(offset) and any(control.poses.carried(offset)):
            control.refuse(
                "M128 with a preset that shifts a rotary axis of the table",
                "parameters of the machine tell whether X and Y turn with it: set the shift to zero, and turn the part "
                "by CYCL DEF 10",
            )

    def spatial_angles(self, on: bool) -> None:
        """AXIS SPAT: A, B and C are angles in space; they are zero to begin with where the tool stands upright."""
        control, state = self.control, self.state
        if on and self.frames.mirrored:
            control.refuse("AXIS SPAT over a mirror of rotary axes", "mirror X, Y and Z only")
        state.spatial = on
        upright = direction_on_part(control, (0.0, 0.0, 1.0)) if on else []
        stands = on and math.dist(upright, control.poses.axis(control.placement.place(control.words)[3:])) < ROUNDING
        state.spatial_angles = [0.0 if stands else None] * 3

    def shortest(self, on: bool) -> None:
        """M126 and M127."""
        self.state.shortest = on

    def feed_mode(self, per_revolution: bool) -> None:
        """M136 and M137."""
        self.state.per_revolution = per_revolution
        self.control.feed.set_mode(PER_REVOLUTION if per_revolution else PER_MINUTE)

    def end(self) -> None:
        """M2, M30; not in a program that another calls (TNC 640 Klartext, "Any NC program as a subprogram")."""
        if self.flow.program is not self.flow.main:
            cure = "end it with END PGM, and pass over its subprograms with FN 9: IF +0 EQU +0 GOTO LBL 99"
            self.control.findings.refused("M2 or M30 in a called program", self.flow.line(self.control.line), cure)
        self.state.ended = True

    def call(self) -> None:
        """M99: the cycle here; where each block called it, for the last time."""
        self.holes.call()
        self.state.calls_everywhere = False

    def call_everywhere(self) -> None:
        """M89: the cycle here, and behind each positioning block."""
        self.holes.call()
        self.state.calls_everywhere = True

    def reduced(self, function: Function) -> Step:
        """M94: rotary words below a full turn; those named, or all."""
        control = self.control
        letters = list(function.words) or [name.upper() for name in control.poses.rotary_names]

        def run() -> None:
            if self.frames.mirrored:
                control.refuse("M94 of mirrored axes", "end the mirror before (CYCL DEF 8)")
                return
            wanted = {letter: control.words[control.slot(letter)] % TURN for letter in letters}
            control.set_position(wanted)
            self.frames.rotary = list(control.coordinates.turn)

        return run

    def retracted(self, function: Function) -> Step:
        """M140: back along the tool by MB, or to the end of travel."""
        words = function.words
        if "MAX" not in words and words.get("MB") is None:
            raise BlockError("M140 needs its way: write MB 50 or MB MAX")

        def run() -> None:
            by = words.get("MB")
            distance = None if by is None else evaluate(by) * self.state.unit
            if distance is not None and not 0.0 <= distance <= 100.0:
                raise BlockError("MB of M140 must be the length of the way back, above zero: correct it")
            feed = words.get("F")
            self.back(distance, feed)
            self.state.came_from = []

        return run

    def back(self, distance: float | None, feed: Value | None) -> None:
        """Retract at a feed of its own, or at rapid."""
        if feed is None:
            retract(self.control, distance, rapid=True)
            return
        with self.control.feed.held(*self.motion.speed_of(evaluate(feed))):
            retract(self.control, distance, rapid=False)

    def in_machine(self, words: PathWords) -> Step:
        """L with M91: machine coordinates, without offsets, frames and tool length."""
        axes = self.motion.resolved(words)

        def run() -> None:
            self.motion.compensation.take(words.side)
            rapid = self.motion.set_feed(words)
            if self.state.tip_mode:
                # "Before positioning with M91 or M92 and before a TOOL CALL block, reset M128" (TNC 620, "M128")
                self.control.refuse("M91 and M92 under M128", "write M129 or FUNCTION RESET TCPM before")
                return
            if any(axis[1] for axis in axes):
                self.control.refuse("incremental words with M91", "write absolute ones")
                return
            target, _ = self.motion.target(
                [(slot, False, value, unit) for slot, _, value, unit in axes], of_program=False
            )
            by_letter = {letter: target[axis[0]] for (letter, _, _), axis in zip(words.axes, axes)}
            straight_in_machine(self.control, by_letter, rapid=rapid)
            self.state.came_from = []

        return run

    def untilted(self, step: Step) -> Step:
        """L with M130: as if there were no tilted plane."""
        frames = self.frames

        def run() -> None:
            plane, within = frames.plane, frames.within
            if plane is None:
                step()
                return
            self.control.findings.assumed(UNTILTED)
            frames.plane, frames.within = None, type(within)()
            frames.apply()
            step()
            frames.plane, frames.within = plane, within
            frames.apply()
            self.state.came_from = []

        return run


def tilting_axes(control: Control, letters: Collection[str]) -> None:
    """M138: note that it changes nothing, or refuse it where it names some of the rotary axes only.

    "The TNC performs the above functions only in those tilting axes that you have defined using M138", without axes in
    all again (TNC 620 Conversational, "Selecting tilting axes: M138").
    """
    own = {name.upper() for name in control.poses.rotary_names}
    if letters and own - set(letters):
        cure = "leave it out: planes and M128 are read with all rotary axes of the machine"
        control.refuse("M138 with some of the rotary axes", cure)
    else:
        control.findings.ignored("M138")

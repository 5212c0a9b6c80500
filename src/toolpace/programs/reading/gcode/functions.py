"""Words without motion: modes, spindle, waiting for inputs, saved modes of LinuxCNC, and words that move nothing.

After LinuxCNC's manual, "M3, M4, M5 Spindle Control", "M19 Orient Spindle", "M66 Wait on Input", "M70 Save Modal
State", "M72 Restore Modal State" and "M73 Save and Autorestore Modal State".
"""

from __future__ import annotations

import math

from toolpace.common.units import DEGREE, INCH, MILLIMETRE, MINUTE
from toolpace.programs.commanded import BLENDED, EXACT_PATH, EXACT_STOP
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import INVERSE, PER_MINUTE, PER_REVOLUTION
from toolpace.programs.reading.control.moves import Joining
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.gcode.frames.frames import Frames
from toolpace.programs.reading.gcode.holes import KINDS, Holes
from toolpace.programs.reading.gcode.modal import ARCS, Modal
from toolpace.programs.reading.gcode.program.flow import Flow
from toolpace.programs.reading.gcode.program.variables import Variables
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError
from toolpace.programs.reading.languages import OSP

RESULT = 5399
"""Variable that has what was waited for."""
MODES = ("unit", "absolute", "arc_absolute", "plane", "exact_stop", "to_initial", "length_word", "turning")
"""Of `Modal`; the motion in force is not among them."""
SHIFTED_BY_TABLES = (
    "it shifts by tables of the control, which no set-up sheet has: let the CAM system shift the path, or remove it "
    "where they are zero"
)


class Modes:
    """Carries out the words of modes, and of dwells."""

    def __init__(self, control: Control, state: Modal, holes: Holes, by: Controller) -> None:
        self.control, self.state, self.holes = control, state, holes
        self.cycles_apart = by.option("cycles_are_a_group", False)
        self.rs274 = by.option("rs274_checks", False)
        self.planner_by_r = by.option("planner_by_r", False)
        self.dwell_whole: float = by.option("dwell_whole_s", 1.0)
        self.dwell_point: float = by.option("dwell_point_s", 1.0)
        self.fanuc = by.option("fanuc_checks", False)
        """Whether P of a dwell takes no point (alarm 007)."""

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        feed = self._feed
        return {
            "inverse time": feed(INVERSE),
            "feed per minute": feed(PER_MINUTE),
            "feed per revolution": feed(PER_REVOLUTION),
            "inch": self._unit(INCH),
            "millimetre": self._unit(MILLIMETRE),
            "plane XY": self._plane(0),
            "plane ZX": self._plane(1),
            "plane YZ": self._plane(2),
            "absolute": self._set("absolute", True),
            "incremental": self._set("absolute", False),
            "arc centre absolute": self._set("arc_absolute", True),
            "arc centre incremental": self._set("arc_absolute", False),
            "exact stop mode": self._exact,
            "continuous path": self._continuous,
            "to initial level": self._set("to_initial", True),
            "to R level": self._set("to_initial", False),
            "polar": self._polar,
            "cartesian": self._cartesian,
            "exact stop": self._set("stop_here", True),
            "machine coordinates": self._set("in_machine", True),
            "dwell": self._dwell,
            "settings": self._settings,
            **{meaning: self._motion(meaning) for meaning in ("rapid", "feed", *ARCS)},
            **{meaning: self._cycle(meaning) for meaning in KINDS},
            "end cycle": self._end_cycle,
        }

    def _settings(self, numbers: Numbers, word: str) -> None:
        """MillPlus G27, G28: I3= to I7= tell how ways follow each other."""
        for letter in [letter for letter in numbers if letter[0] == "I"]:
            del numbers[letter]
        if numbers.keys() & set("XYZABC"):
            numbers.clear()
            raise RefusedError(f"{word} with axes", "write the motion in a block of its own")
        self.control.findings.ignored(word)

    def _unit(self, unit: float) -> Handler:
        def set_unit(numbers: Numbers, word: str) -> None:
            if self._drills() and unit != self.state.unit:
                raise BlockError(f"{word} within a cycle changes what its words mean: end the cycle with G80 before it")
            if self.control.stage is not None and unit != self.state.unit:
                self.control.stage.other_motion(f"a change of the unit ({word})")
            self.state.unit, self.state.unit_said = unit, True

        return set_unit

    def _set(self, name: str, value: object) -> Handler:
        return lambda numbers, word: setattr(self.state, name, value)

    def _plane(self, plane: int) -> Handler:
        def set_plane(numbers: Numbers, word: str) -> None:
            stage = self.control.stage
            if stage is not None and stage.compensates and plane != self.state.plane:
                stage.other_motion(f"a change of the plane ({word})")
            self.state.plane = plane

        return set_plane

    def _feed(self, mode: str) -> Handler:
        return lambda numbers, word: self.control.feed.set_mode(mode)

    def _motion(self, meaning: str) -> Handler:
        def chosen(numbers: Numbers, word: str) -> None:
            self.state.motion, self.state.cycle = meaning, None

        return chosen

    def _cycle(self, meaning: str) -> Handler:
        def chosen(numbers: Numbers, word: str) -> None:
            if self.state.cycle is None:
                self.holes.begin()
            elif self.state.cycle != meaning:
                self.holes.change()
            self.state.cycle, self.state.cycle_word = meaning, True
            if not self.cycles_apart:
                self.state.motion = None

        return chosen

    def _end_cycle(self, numbers: Numbers, word: str) -> None:
        if self.rs274 and self.state.drills_here and self.state.motion_word != word:
            return  # beside another motion G80 counts for nothing
        self.state.cycle = None
        if not self.cycles_apart:
            self.state.motion = None

    def _exact(self, numbers: Numbers, word: str) -> None:
        self.state.exact_stop = True
        if self.rs274:
            self.control.moves.ask(tip=math.nan)
        self.control.moves.join(Joining(EXACT_STOP if word == "G61.1" else EXACT_PATH))

    def _continuous(self, numbers: Numbers, word: str) -> None:
        self.state.exact_stop = False
        unit = self.state.unit
        if self.planner_by_r and "R" in numbers and numbers.keys().isdisjoint("XYZABCUVWIJK"):
            self._smooth(numbers.pop("R"))
        tolerance = self._taken(numbers, "P", self.state.arc_here or self._drills())
        cam_tolerance = self._taken(numbers, "Q", self._drills())
        self.control.moves.join(
            Joining(
                BLENDED,
                math.inf if tolerance is None else tolerance * unit,
                math.nan if cam_tolerance is None else cam_tolerance * unit,
            )
        )
        if self.rs274:
            self.control.moves.ask(tip=math.nan if tolerance is None else tolerance * unit)
        if tolerance is not None or cam_tolerance is not None:
            # noted, and obeyed where that is asked for
            self.control.findings.ignored(f"{word} P")

    def _smooth(self, share: float) -> None:
        """R of G64: the planner without limit of jerk, or that with one and its share of speeds at corners."""
        self.control.moves.drive(smooth=min(max(share, 0.1), 1.0) if share > 0.0 else 0.0)

    def _drills(self) -> bool:
        return self.rs274 and self.state.drills_here

    @staticmethod
    def _taken(numbers: Numbers, letter: str, shared: bool) -> float | None:
        """The number of a letter, out of the block, where its motion does not share it."""
        if shared and not numbers.keys().isdisjoint("XYZABCUVWIJKR"):
            return numbers.get(letter)
        return numbers.pop(letter, None)

    def _cartesian(self, numbers: Numbers, word: str) -> None:
        if "H" in numbers:
            numbers.clear()
            raise RefusedError(f"{word} H", f"it is a work offset of Okuma's OSP, {OSP}")
        self.state.polar = False

    def _polar(self, numbers: Numbers, word: str) -> None:
        self.state.polar, self.state.pole = True, {}

    def seconds(self, value: float) -> float:
        """Time of a dwell's P [s]: in many controllers its unit goes by whether it has a point."""
        if "P" in self.state.whole or (self.fanuc and "P" in self.state.reckoned):
            return value * self.dwell_whole
        if value and self.dwell_whole != self.dwell_point and (self.fanuc or "P" in self.state.reckoned):
            said = "whose value is reckoned" if "P" in self.state.reckoned else "with a point (alarm 007 of Fanuc)"
            self.control.findings.assumed(f"P of a dwell {said} is in seconds")
        return value * self.dwell_point

    def _dwell(self, numbers: Numbers, word: str) -> None:
        letter = next((letter for letter in ("P" if self.rs274 else "PXUF") if letter in numbers), None)
        if letter is None:
            raise BlockError(f"{word} needs its time as P in seconds: write it like {word} P0.5")
        value = self._taken(numbers, letter, self.rs274 and (self.state.arc_here or self._drills())) or 0.0
        self.control.dwell(self.seconds(value) if letter == "P" else value)
        if any(letter in "XYZABCUVW" for letter in numbers) and not self.rs274:
            raise BlockError(f"{word} takes its time alone: write the motion in a block of its own")


class Functions:
    """Carries out M3, M4, M5, M19 and M66 of LinuxCNC."""

    def __init__(self, control: Control, state: Modal, variables: Variables) -> None:
        self.control, self.state, self.variables = control, state, variables

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {"turn spindle": self.turn, "orient spindle": self.orient, "wait for input": self.wait}

    def turn(self, numbers: Numbers, word: str) -> None:
        """M3, M4, M5."""
        self.state.turning = "" if word == "M5" else word
        self.control.turn_spindle(word=word)
        self.control.stop()

    def orient(self, numbers: Numbers, word: str) -> None:
        """M19 R P Q: to an angle, by a direction, within a time."""
        words = {letter: numbers.pop(letter) for letter in "RPQ" if letter in numbers}
        self._refuse_cycle(numbers, word, arcs=True)
        if not 0.0 <= words.get("R", 0.0) <= 360.0 or round(words.get("P", 0.0)) not in (0, 1, 2):
            raise BlockError(f"{word} takes an angle R from 0 to 360 and a direction P of 0, 1 or 2: correct them")
        if words.get("Q", 1.0) <= 0.0:
            raise BlockError(f"{word} Q is a time above zero: correct it")
        self.state.turning = ""
        self.control.stop()

    def wait(self, numbers: Numbers, word: str) -> None:
        """M66 P or E, L Q: for how long is not known, nor what is read."""
        shared = {"P": numbers["P"]} if self.state.arc_here and "P" in numbers else {}
        words = {letter: numbers.pop(letter) for letter in "PELQ" if letter in numbers}
        numbers |= shared  # of the turns of an arc too
        self._refuse_cycle(numbers, word)
        inputs = [words[letter] for letter in "PE" if letter in words]
        waits = round(words.get("L", 0.0))
        if len(inputs) != 1 or round(inputs[0]) < 0:
            raise BlockError(f"{word} waits for one input: write its number as P, or as E where it is analog")
        if waits and ("E" in words or words.get("Q", 0.0) <= 0.0):
            raise BlockError(f"{word} L{waits} waits for a digital input, Q seconds at most: write P, and Q above zero")
        self.variables.common.pop(RESULT, None)
        self.control.stop()

    def _refuse_cycle(self, numbers: Numbers, word: str, *, arcs: bool = False) -> None:
        """Raise BlockError where the motion of the block takes the same letters for something else."""
        state = self.state
        moves = not numbers.keys().isdisjoint("XYZABCUVWIJK")
        if moves and (state.drills_here or (arcs and state.arc_here)):
            raise BlockError(f"{word} and an arc or a cycle may take the same letters: write two blocks")


class SavedModes:
    """Carries out M70, M71, M72 and M73."""

    def __init__(self, control: Control, state: Modal, frames: Frames, flow: Flow) -> None:
        self.control, self.state, self.frames, self.flow = control, state, frames, flow
        self.offsets = frames.offsets

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "save modes": self.save,
            "save modes for return": self.save_for_return,
            "forget modes": self.forget,
            "restore modes": self.restore,
        }

    def save(self, numbers: Numbers, word: str) -> None:
        """M70."""
        control = self.control
        feed, coordinates = control.feed, control.coordinates
        modes = {name: getattr(self.state, name) for name in MODES}
        rates = feed.mode, feed.value, feed.turn, feed.unit, feed.spindle
        tool = coordinates.compensated, coordinates.length_of, coordinates.programmed
        offset, position_on = self.offsets.offset, self.frames.position_on
        joining = control.moves.joining

        def restore() -> None:
            for name, value in modes.items():
                setattr(self.state, name, value)
            feed.mode, feed.value, feed.turn, feed.unit = rates[:4]
            control.turn_spindle(rates[4])
            number = 0.0 if feed.value is None else feed.turn / DEGREE * (MINUTE if feed.mode == PER_MINUTE else 1.0)
            if feed.unit != self.state.unit or abs(number - round(number, 1)) > 1e-9:
                # its interpreter writes F anew, as a number of one decimal in the unit of the saved modes
                feed.value = None
            coordinates.compensated, coordinates.length_of, coordinates.programmed = tool
            control.moves.join(joining)
            if position_on != self.frames.position_on:
                self.frames.put_position(position_on)
            if offset != self.offsets.offset:
                self.offsets.take(offset)
            else:
                self.offsets.changed()

        self.flow.frame.saved = restore

    def save_for_return(self, numbers: Numbers, word: str) -> None:
        """M73: restored where this level returns."""
        self.save(numbers, word)
        self.flow.frame.restores = True

    def forget(self, numbers: Numbers, word: str) -> None:
        """M71."""
        self.flow.frame.saved = None

    def restore(self, numbers: Numbers, word: str) -> None:
        """M72."""
        restore = self.flow.frame.saved
        if restore is None:
            raise BlockError(f"{word} restores modes, and none were saved at this level: write M70 before it")
        restore()


class IdleWords:
    """Counts words that move nothing; what beside them might move is refused."""

    def __init__(self, findings: Findings) -> None:
        self.findings = findings

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {"limits": self.limits, "no motion": self.no_motion, "only off": self.only_off}

    def limits(self, numbers: Numbers, word: str) -> None:
        """Fanuc G22: X, Y, Z, I, J, K are corners of a zone that the axes may not enter."""
        numbers.clear()
        self.findings.ignored(word)

    def no_motion(self, numbers: Numbers, word: str) -> None:
        """A word that moves nothing on one control, and with axes moves on another (G8 of Fagor is an arc)."""
        if not numbers.keys().isdisjoint("XYZABCUVW"):
            numbers.clear()
            raise RefusedError(f"{word} beside axes", "some controls move by it otherwise: give --controller NAME")
        numbers.pop("P", None)
        self.findings.ignored(word)

    def only_off(self, numbers: Numbers, word: str) -> None:
        """A word whose P0 (or X0) switches off what is not read."""
        letter = "P" if "P" in numbers else "X"
        number = numbers.pop(letter, 0.0)
        if number:
            raise RefusedError(f"{word} {letter}{number:g}", SHIFTED_BY_TABLES)
        self.findings.ignored(word)

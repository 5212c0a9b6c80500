"""Modal words without motion."""

from __future__ import annotations

import math

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.commanded import BLENDED, EXACT_PATH, EXACT_STOP
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import INVERSE, PER_MINUTE, PER_REVOLUTION
from toolpace.programs.reading.control.moves import Joining
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.gcode.holes import KINDS, Holes
from toolpace.programs.reading.gcode.modal import ARCS, Modal
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError
from toolpace.programs.reading.language.expressions import BlockError
from toolpace.programs.reading.languages import OSP


class Modes:
    """Carries out the words of modes, and of dwells."""

    def __init__(self, control: Control, state: Modal, holes: Holes, by: Controller) -> None:
        self.control, self.state, self.holes = control, state, holes
        self.cycles_apart = by.option("cycles_are_a_group", False)
        self.rs274 = by.option("rs274_checks", False)
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
        if self.rs274 and "R" in numbers and numbers.keys().isdisjoint("XYZABCUVWIJK"):
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
        self.control.findings.assumed("R of G64 is a word of LinuxCNC 2.10, at which 2.9 stops")
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

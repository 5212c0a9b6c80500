"""Moves to reference points and in machine coordinates."""

from __future__ import annotations

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import reference, straight_in_machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.frames.frames import Frames
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.motion import MotionReader, turned_alone
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError


class MachineMoves:
    """Carries out G28, G29, G30, G53 and MillPlus' G74."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader, frames: Frames, by: Controller) -> None:
        self.control, self.state, self.motion, self.frames = control, state, motion, frames
        self.rs274 = by.option("rs274_checks", False)
        """Whether blocks are refused that LinuxCNC's interpreter refuses."""
        self.fanuc = by.option("fanuc_checks", False)
        """Whether blocks are refused that Fanuc stops with an alarm, or passes over."""
        self.all_axes = by.option("reference_without_axes_is_all", True)

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "reference": self.reference,
            "second reference": self.second_reference,
            "from reference": self.from_reference,
            "machine rapid": self.machine_rapid,
        }

    def _named(self, numbers: Numbers, word: str) -> Numbers:
        """Axis words, taken out of the block; the axes that the machine has. Raises RefusedError, ProgramError."""
        letters = [letter for letter in numbers if letter in "XYZABCUVW"]
        axes = {letter: numbers.pop(letter) for letter in letters}
        for letter in "UVW":
            if letter in axes and not self._moves(letter):
                raise RefusedError(
                    f"{word} {letter}",
                    "the machine has no such axis; on lathes it counts on X or Z, and turning is not read: remove it",
                )
        slots = self.control.slots
        absent = [letter for letter, value in axes.items() if letter not in slots]
        for letter in absent:
            value = axes.pop(letter)
            if value and letter != self.motion.along and self.control.poses.machine is not None:
                self.control.slot(letter)
        return axes

    def _moves(self, letter: str) -> bool:
        """Whether the machine has an axis of this letter."""
        return letter in self.control.slots or letter == self.motion.along or self.control.poses.machine is None

    def reference(self, numbers: Numbers, word: str) -> None:
        """G28: over the place that is named, at rapid, to the reference point with the axes that are named."""
        self._reference(1, numbers, word)

    def second_reference(self, numbers: Numbers, word: str) -> None:
        """G30: to the second reference point, or the one that P names."""
        number = numbers.pop("P", 2.0)
        if number not in (1.0, 2.0, 3.0, 4.0):
            raise BlockError(f"{word} P{number:g} is no reference point: write P2, P3 or P4")
        self._reference(int(number), numbers, word)

    def _reference(self, number: int, numbers: Numbers, word: str) -> None:
        control = self.control
        any_named = any(letter in numbers for letter in "XYZABCUVW")
        axes = self._named(numbers, word)
        if not axes and (any_named or not self.all_axes):
            control.findings.ignored(f"{word} of axes that the machine lacks" if any_named else f"{word} without axes")
            return
        if axes:
            target, named = self.motion.target(dict(axes), alone=True)
            if not turned_alone(control, self.state, target, rapid=True) and target != control.words:
                control.straight(target, named, rapid=True)
        self.state.between = list(control.words)
        self.state.level_by_machine |= not axes or "Z" in axes
        if self.rs274 and axes and self.frames.offsets.turned.get(self.frames.offsets.offset):
            self._reference_in_turned(number, list(axes))
        else:
            reference(control, number, list(axes))
        self.state.turned_in_plane |= not axes or not axes.keys().isdisjoint("ABC")
        self.state.at_home = True

    def _reference_in_turned(self, number: int, letters: list[str]) -> None:
        """LinuxCNC (`convert_home`): what is not named keeps its place in the program's turned coordinates."""
        control = self.control
        control.findings.used.references.setdefault(number)
        joints = control.datum.joints_of(control.datum.reference(number), control.placement.place(control.words))
        found, words = control.placement.words(joints), list(control.words)
        for letter in letters:
            words[control.slots[letter]] = found[control.slots[letter]]
        control.straight(words, 0, rapid=True)
        control.stop()

    def from_reference(self, numbers: Numbers, word: str) -> None:
        """G29: back, over the place over which the reference point was gone to."""
        control = self.control
        target, named = self.motion.target(self._named(numbers, word))
        if self.state.between is None:
            raise BlockError(f"{word} comes back over the place over which G28 went, and none did: write G28 before it")
        over = list(control.words)
        for slot, (present, wanted) in enumerate(zip(control.words, target)):
            over[slot] = self.state.between[slot] if present != wanted else present
        control.straight(over, named, rapid=True)
        control.straight(target, named, rapid=True)

    def in_machine(self, numbers: Numbers, *, rapid: bool) -> None:
        """Move to machine coordinates."""
        control, unit = self.control, self.state.unit
        if self.rs274 and (self.state.motion not in ("rapid", "feed") or not self.state.absolute):
            raise BlockError("G53 stands with G0 or G1, and under G90: write it like G90 G53 G0 Z0")
        if self.fanuc and not self.state.absolute:
            numbers.clear()
            raise RefusedError("G53 under G91", "the control passes it over there: write G90 G53")
        axes = self._named(numbers, "G53")
        slots = control.slots
        coordinates = {letter: value * (unit if slots[letter] < 3 else DEGREE) for letter, value in axes.items()}
        if coordinates:
            self.state.along = 0.0
            self.state.level_by_machine |= "Z" in coordinates
            self.state.turned_in_plane |= not coordinates.keys().isdisjoint("ABC")
            straight_in_machine(control, coordinates, rapid=rapid)

    def machine_rapid(self, numbers: Numbers, word: str) -> None:
        """MillPlus G74: to machine coordinates at rapid; L1 is a setting of its own."""
        numbers.pop("L", None)
        self.in_machine(numbers, rapid=True)

"""Moves to places of the machine: reference points, machine coordinates, and tilted planes that the axes turn to."""

from __future__ import annotations

import numpy as np

from toolpace.reading.control.control import Control
from toolpace.reading.control.joint_moves import reference, straight_in_machine
from toolpace.reading.control.tool_axis import plane_axis, rotary_for, turn_to_plane
from toolpace.reading.controllers.controller import Controller
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.affine import Matrix
from toolpace.reading.gcode.actions.frames import Frames
from toolpace.reading.gcode.actions.modal import Modal
from toolpace.reading.gcode.actions.motion import MotionReader
from toolpace.reading.gcode.program.variables import Variables
from toolpace.reading.gcode.program.words import Handler, Numbers, RefusedError, WordError
from toolpace.units import DEGREE


class Places:
    """Carries out G28, G29, G30, G53, G68.2, G53.1, G254 and MillPlus' G7 and G74."""

    def __init__(
        self, control: Control, state: Modal, motion: MotionReader, frames: Frames, variables: Variables, by: Controller
    ) -> None:
        self.control, self.state, self.motion, self.frames, self.variables = control, state, motion, frames, variables
        self.rs274 = by.option("rs274_checks", False)
        """Whether blocks are refused that LinuxCNC's interpreter refuses."""
        self.all_axes = by.option("reference_without_axes_is_all", True)

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "tilt plane": self.tilt_plane,
            "tilt plane by order": self.tilt_plane_by_order,
            "carried frame": self.carried_frame,
            "tilt by axes": self.tilt_by_axes,
            "turn to plane": self.turn_to_plane,
            "reference": self.reference,
            "second reference": self.second_reference,
            "from reference": self.from_reference,
            "machine rapid": self.machine_rapid,
        }

    def _named(self, numbers: Numbers) -> Numbers:
        """Axis words, taken out of the block; the axes that the machine has."""
        letters = [letter for letter in numbers if letter in "XYZABCUVW"]
        given = {letter: numbers.pop(letter) for letter in letters}
        slots = self.control.slots
        absent = [letter for letter, value in given.items() if letter not in slots]
        for letter in absent:
            value = given.pop(letter)
            if value and letter != self.motion.along and self.control.poses.machine is not None:
                self.control.slot(letter)
        return given

    def reference(self, numbers: Numbers, word: str) -> None:
        """G28: over the place that is named, at rapid, to the reference point with the axes that are named."""
        self._reference(1, numbers, word)

    def second_reference(self, numbers: Numbers, word: str) -> None:
        """G30: to the second reference point, or the one that P names."""
        number = numbers.pop("P", 2.0)
        if number not in (1.0, 2.0, 3.0, 4.0):
            raise WordError(f"{word} P{number:g} is no reference point: write P2, P3 or P4")
        self._reference(int(number), numbers, word)

    def _reference(self, number: int, numbers: Numbers, word: str) -> None:
        control = self.control
        given = self._named(numbers)
        if not given and not self.all_axes:
            control.findings.ignored(f"{word} without axes")
            return
        if given:
            target, named = self.motion.target(dict(given))
            if target != control.words:
                control.straight(target, named, rapid=True)
        self.state.between = list(control.words)
        if self.rs274 and given and self.frames.offsets.turned.get(self.frames.offsets.offset):
            self._reference_in_turned(number, list(given))
        else:
            reference(control, number, list(given))
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
        target, named = self.motion.target(self._named(numbers))
        if self.state.between is not None:
            over = list(control.words)
            for slot, (present, wanted) in enumerate(zip(control.words, target)):
                over[slot] = self.state.between[slot] if present != wanted else present
            control.straight(over, named, rapid=True)
        control.straight(target, named, rapid=True)

    def in_machine(self, numbers: Numbers, *, rapid: bool) -> None:
        """Move to machine coordinates."""
        control, unit = self.control, self.state.unit
        if self.rs274 and (self.state.motion not in ("rapid", "feed") or not self.state.absolute):
            raise WordError("G53 stands with G0 or G1, and under G90: write it like G90 G53 G0 Z0")
        given = self._named(numbers)
        slots = control.slots
        places = {letter: value * (unit if slots[letter] < 3 else DEGREE) for letter, value in given.items()}
        if places:
            self.state.along = 0.0
            straight_in_machine(control, places, rapid=rapid)

    def machine_rapid(self, numbers: Numbers, word: str) -> None:
        """MillPlus G74: to machine coordinates at rapid; L1 is a setting of its own."""
        numbers.pop("L", None)
        self.in_machine(numbers, rapid=True)

    # Tilted planes

    def tilt_plane(self, numbers: Numbers, word: str) -> None:
        """G68.2 X Y Z I J K: a plane through a point, by Euler angles about z, the new x and the new z."""
        if self._rolls(numbers):
            self.tilt_plane_by_order(numbers, word)
            return
        if any(letter in numbers for letter in "PQR"):
            raise RefusedError(f"{word} with P, Q or R", f"write its plane as {word} X Y Z I J K")
        self._need_machine(word)
        unit = self.state.unit
        at = affine.shift([numbers.pop(letter, 0.0) * unit for letter in "XYZ"])
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in "IJK"]
        turned = affine.turns((2, angles[0]), (0, angles[1]), (2, angles[2]))
        self.frames.tilt(affine.product(at, turned))

    @staticmethod
    def _rolls(numbers: Numbers) -> bool:
        """Whether they are P1 of Fanuc, turns about X, Y, Z by I, J, K, of which one alone is not zero.

        Of several, manuals and machines differ whether the axes turn with the plane.
        """
        rolls = numbers.get("P") == 1.0 and sum(numbers.get(letter, 0.0) != 0.0 for letter in "IJK") <= 1
        if rolls:
            del numbers["P"]
        return rolls

    def tilt_plane_by_order(self, numbers: Numbers, word: str) -> None:
        """Haas G268 X Y Z I J K Q: turns about the fixed axes X, Y, Z by I, J, K, in the order of the digits of Q."""
        self._need_machine(word)
        unit = self.state.unit
        at = affine.shift([numbers.pop(letter, 0.0) * unit for letter in "XYZ"])
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in "IJK"]
        order = numbers.pop("Q", None)
        if order is None and sum(angle != 0.0 for angle in angles) > 1:
            raise RefusedError(f"{word} without Q", "it tells the order of the turns: write Q123 with its angles")
        digits = f"{order or 123.0:g}"
        if sorted(digits) != ["1", "2", "3"]:
            raise RefusedError(f"{word} Q{digits}", "write each of X, Y, Z once, like Q123, with their angles")
        if sum(angle != 0.0 for angle in angles) > 1:
            self.control.findings.assumed(f"{word} turns about the fixed axes X, Y and Z, in the order of Q")
        turned = affine.IDENTITY
        for digit in digits:
            axis = int(digit) - 1
            turned = affine.product(affine.rotation(axis, angles[axis]), turned)
        self.frames.tilt(affine.product(at, turned))

    def turn_to_plane(self, numbers: Numbers, word: str) -> None:
        """G53.1: turn the rotary axes until the tool stands on the plane."""
        self._need_machine(word)
        numbers.pop("P", None)
        turn_to_plane(self.control)

    def carried_frame(self, numbers: Numbers, word: str) -> None:
        """Haas G254: coordinates parallel to the machine's, about the work offset as the table has carried it."""
        self._need_machine(word)
        self.frames.tilt(self._carried())

    def _carried(self) -> Matrix:
        control = self.control
        place = control.placement.place(control.words)
        _, columns, _ = control.poses.linear_map(place[3:])
        _, zero, _ = control.poses.linear_map([0.0] * len(place[3:]))
        made = columns @ np.linalg.inv(zero)
        return affine.linear(np.where(np.abs(made - np.round(made)) < 1e-13, np.round(made), made).tolist())

    def tilt_by_axes(self, numbers: Numbers, word: str) -> None:
        """MillPlus G7: turns about the fixed axes X, Y, Z by A5, B5, C5; L1=1 turns the axes, B7 and C7 are told."""
        control = self.control
        angles = [numbers.pop(letter, 0.0) * DEGREE for letter in ("A5", "B5", "C5")]
        turns_axes = numbers.pop("L1", 0.0) == 1.0
        x, y, z = (affine.rotation(axis, angle) for axis, angle in enumerate(angles))
        told = [letter for letter in ("A", "B", "C") if f"{letter}7" in numbers]
        if any(angles):
            self._need_machine(word)
        self.frames.tilt(affine.product(z, affine.product(y, x)))
        if told:
            wanted = rotary_for(control, plane_axis(control))
            for letter in told:
                key = round(numbers.pop(f"{letter}7"))
                self.variables.set(key, wanted[control.slot(letter) - 3] / DEGREE)
        if turns_axes and control.poses.machine is not None:
            turn_to_plane(control)

    def _need_machine(self, word: str) -> None:
        if self.control.poses.machine is None:
            raise WordError(f"{word} needs the machine: give --machine NAME (machine= in Python)")

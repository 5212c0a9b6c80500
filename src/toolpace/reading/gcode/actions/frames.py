"""Shifts, turns, scales and mirrors that a program lays over its coordinates, put together into one frame."""

from __future__ import annotations

from toolpace.reading.control.control import Control
from toolpace.reading.controllers.controller import Controller
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.affine import Matrix
from toolpace.reading.gcode.actions.modal import Modal
from toolpace.reading.gcode.actions.offsets import Offsets, given_axes
from toolpace.reading.gcode.program.words import Handler, Numbers, RefusedError, WordError
from toolpace.units import DEGREE

_NORMAL = (2, 1, 0)
"""Normal of the planes XY, ZX and YZ."""


class Frames:
    """Work offsets, local shifts (G52), positions (G92), rotations (G68), tilts (G68.2), scales and mirrors.

    Each acts in the coordinates made by those before it, in this order.
    """

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.factor_of_whole: float = by.option("scale_of_whole", 1.0)
        """What a whole P of scaling counts (0.001 where P1000 is life size)."""
        size = len(control.words)
        self.local = [0.0] * size
        self.position = [0.0] * size
        self.stored = self.position
        """The position that G92.3 restores."""
        self.position_on = False
        """Whether a position is in force, be it zero."""
        self.one_shift = by.option("local_shift_is_position", False)
        self.turned: Matrix | None = None
        self.tilted = False
        self.scaled: Matrix | None = None
        self.mirrored: Matrix | None = None
        self.indexed = by.option("indexed_words", False)
        self.offsets = Offsets(control, state, by, self.of_offset, self.apply)
        self.offsets.shifted = lambda: any(self.position[:2]) or any(self.local[:2])

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        offsets = self.offsets
        return {
            "work offset": offsets.indexed_offset if self.indexed else offsets.work_offset,
            "numbered offset": offsets.numbered_offset,
            "no offset": offsets.no_offset,
            "set offset": self.set_offset,
            "end of data": offsets.end_of_data,
            "local shift": self.local_shift,
            "set position": self.set_position,
            "clear position": self.clear_position,
            "suspend position": self.suspend_position,
            "restore position": self.restore_position,
            "datum": self.datum,
            "datum added": self.datum_added,
            "scale": self.scale,
            "scale off": self.scale_off,
            "mirror": self.mirror,
            "mirror off": self.mirror_off,
            "rotate": self.rotate,
            "rotation off": self.rotation_off,
        }

    def apply(self) -> None:
        """Hand the frame to the control."""
        made, turn = self.of_offset(self.offsets.offset)
        self.control.set_frame(made, tilted=self.tilted)
        if turn != self.control.coordinates.turn:
            self.control.set_rotary_shift(turn)

    def of_offset(self, name: str) -> tuple[Matrix, tuple[float, ...]]:
        """The frame in the coordinates of a work offset as the set-up sheet has it, and the rotary shift [rad]."""
        angle = self.offsets.turned.get(name, 0.0)
        inner = [a + b for a, b in zip(self.local, self.position)]
        outer = self.offsets.external
        if name in self.offsets.moved:
            outer = [a + b for a, b in zip(outer, self.offsets.moved[name])]
        total = [a + b for a, b in zip(outer, inner)]
        if angle:
            moved = affine.product(affine.shift(outer), affine.rotation(2, angle))
            made = affine.product(moved, affine.shift(inner))
        else:
            made = affine.shift(total) if any(total[:3]) else affine.IDENTITY
        for part in (self.turned, self.scaled, self.mirrored):
            if part is not None:
                made = part if made is affine.IDENTITY else affine.product(made, part)
        return made, tuple(total[3:])

    # Shifts

    def set_offset(self, numbers: Numbers, word: str) -> None:
        """G10: work offsets; to Haas P0 of L2 is the shift of G52."""
        if self.offsets.of_zero == "local" and numbers.get("L") == 2.0 and numbers.get("P") == 0.0:
            numbers.pop("L")
            numbers.pop("P")
            for letter, value in given_axes(self.control, self.state, numbers).items():
                slot = self.control.slots[letter]
                self.local[slot] = value if self.state.absolute else self.local[slot] + value
            self.apply()
        else:
            self.offsets.set_offset(numbers, word)

    def local_shift(self, numbers: Numbers, word: str) -> None:
        """G52: in place of the one before, of the axes named; LinuxCNC has one shift for G52 and G92."""
        shift = list(self.position if self.one_shift else self.local)
        for letter, value in self._given(numbers, word).items():
            shift[self.control.slots[letter]] = value
        if self.one_shift:
            self.position = self.stored = shift
            self.position_on = True
        else:
            self.local = shift
        self.apply()

    def _given(self, numbers: Numbers, word: str) -> Numbers:
        """Axis words, of which the controller may need one."""
        if self.one_shift and not any(letter in numbers for letter in "XYZABCUVW"):
            raise WordError(f"{word} names no axis: write it like {word} X0 Y0")
        return given_axes(self.control, self.state, numbers)

    def datum(self, numbers: Numbers, word: str) -> None:
        """MillPlus G93: the datum, in the coordinates of the work offset; axes that are not named keep theirs."""
        self.turned, self.tilted = None, False
        self.local_shift(numbers, word)

    def datum_added(self, numbers: Numbers, word: str) -> None:
        """MillPlus G92: a shift of the datum from where it is."""
        for letter, value in given_axes(self.control, self.state, numbers).items():
            self.local[self.control.slots[letter]] += value
        self.apply()

    def set_position(self, numbers: Numbers, word: str) -> None:
        """G92: the place where the machine is gets these words."""
        given = self._given(numbers, word)
        if (self.turned or self.scaled or self.mirrored) and given:
            raise RefusedError(f"{word} in turned or scaled coordinates", "end those before it")
        self.position = self.stored = list(self.position)
        for letter, value in given.items():
            slot = self.control.slots[letter]
            self.position[slot] += self.control.words[slot] - value
        self.position_on = True
        self.apply()

    def clear_position(self, numbers: Numbers, word: str) -> None:
        """G92.1."""
        self.position = self.stored = [0.0] * len(self.position)
        self.position_on = False
        self.apply()

    def suspend_position(self, numbers: Numbers, word: str) -> None:
        """G92.2."""
        self.put_position(False)
        self.apply()

    def restore_position(self, numbers: Numbers, word: str) -> None:
        """G92.3."""
        self.put_position(True)
        self.apply()

    def put_position(self, on: bool) -> None:
        """The stored position in force, or none; the frame is not handed on yet."""
        self.position, self.position_on = self.stored if on else [0.0] * len(self.stored), on

    # Turns, scales, mirrors

    def rotate(self, numbers: Numbers, word: str) -> None:
        """G68: turn the plane about a point, that where the machine is unless X, Y tell another, by R [deg]."""
        if any(letter in numbers for letter in "IJK"):
            raise RefusedError(f"{word} with I, J, K", "it turns about a vector: write G68.2, or points")
        if "R" not in numbers:
            raise WordError(f"{word} needs its angle as R: write it like {word} X0 Y0 R30")
        if self.tilted:
            raise RefusedError(
                f"{word} in a tilted plane", "turn the plane by its own angles (the last of them turns it in itself)"
            )
        normal = _NORMAL[self.state.plane]
        angle = numbers.pop("R") * DEGREE
        about = self._about(numbers)
        about[normal] = 0.0
        back = [-value for value in about]
        self._only_linear(numbers, word)
        turn = affine.product(affine.rotation(normal, angle), affine.shift(back))
        self.turned, self.tilted = affine.product(affine.shift(about), turn), False
        self.apply()

    def _about(self, numbers: Numbers) -> list[float]:
        """A point of X, Y, Z; of those that are not named, the place where the machine is."""
        point = self.control.words[:3]
        for slot, letter in enumerate("XYZ"):
            if letter in numbers:
                value = numbers.pop(letter) * self.state.unit
                point[slot] = value if self.state.absolute else point[slot] + value
        return point

    @staticmethod
    def _only_linear(numbers: Numbers, word: str) -> None:
        """A rotary word that is left in the block of a turn, a scale or a mirror is none of a motion."""
        for letter in "ABCUVW":
            if letter in numbers:
                numbers.clear()
                raise RefusedError(
                    f"{word} with {letter}", "it acts on X, Y and Z here: let the CAM system write the other axes so"
                )

    def rotation_off(self, numbers: Numbers, word: str) -> None:
        """G69."""
        self.turned, self.tilted = None, False
        self.apply()

    def tilt(self, frame: Matrix) -> None:
        """Lay the coordinates into a tilted plane."""
        if self.turned is not None and not self.tilted:
            raise RefusedError("a tilted plane in turned coordinates (G68)", "end the turn before it: write G69")
        self.turned, self.tilted = (None, False) if frame == affine.IDENTITY else (frame, True)
        self.apply()

    def scale(self, numbers: Numbers, word: str) -> None:
        """G51: by P, or by I, J, K along the axes, about X, Y, Z."""
        common = numbers.pop("P", None)
        factors = [numbers.pop(letter, None) for letter in "IJK"]
        if common is None and not any(factors):
            raise WordError(f"{word} needs its factor as P, or I, J and K: write it like {word} X0 Y0 P0.5")
        chosen = [self._factor(factor if factor is not None else common) for factor in factors]
        if not all(chosen):
            raise WordError(f"{word} by zero leaves nothing: correct the factor")
        self.scaled = self._about_point(affine.scaling(chosen), numbers)
        self._only_linear(numbers, word)
        self.apply()

    def _factor(self, given: float | None) -> float:
        if given is None:
            return 1.0
        return given * self.factor_of_whole if given == int(given) else given

    def _about_point(self, frame: Matrix, numbers: Numbers) -> Matrix:
        about = self._about(numbers)
        back = affine.shift([-value for value in about])
        return affine.product(affine.shift(about), affine.product(frame, back))

    def scale_off(self, numbers: Numbers, word: str) -> None:
        """G50."""
        self.scaled = None
        self.apply()

    def mirror(self, numbers: Numbers, word: str) -> None:
        """G51.1: the named axes turn round at the positions named."""
        named = [letter for letter in "XYZ" if letter in numbers]
        signs = [-1.0 if letter in named else 1.0 for letter in "XYZ"]
        places = [numbers.pop(letter, 0.0) * self.state.unit for letter in "XYZ"]
        self._only_linear(numbers, word)
        made = affine.product(affine.shift([2.0 * place for place in places]), affine.scaling(signs))
        self.mirrored = made if self.mirrored is None else affine.product(self.mirrored, made)
        self.apply()

    def mirror_off(self, numbers: Numbers, word: str) -> None:
        """G50.1."""
        for letter in "XYZABC":
            numbers.pop(letter, None)
        self.mirrored = None
        self.apply()

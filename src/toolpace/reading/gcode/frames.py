"""Shifts, turns, scales and mirrors that a program lays over its coordinates, put together into one frame."""

from __future__ import annotations

from toolpace.reading.control import affine
from toolpace.reading.control.affine import Matrix
from toolpace.reading.control.control import Control
from toolpace.reading.gcode.modal import Modal
from toolpace.reading.gcode.words import WordError
from toolpace.units import DEGREE

Numbers = dict[str, float]
_NORMAL = (2, 1, 0)
"""Normal of the planes XY, ZX and YZ."""


class Frames:
    """Work offsets, local shifts (G52), positions (G92), rotations (G68), tilts (G68.2), scales and mirrors.

    Each acts in the coordinates made by those before it, in this order.
    """

    def __init__(self, control: Control, state: Modal, factor_of_whole: float) -> None:
        """factor_of_whole: what a whole P of scaling counts (0.001 where P1000 is life size)."""
        self.control, self.state, self.factor_of_whole = control, state, factor_of_whole
        size = len(control.words)
        self.offset = ""
        self.moved: dict[str, list[float]] = {}
        """How far the program has moved each work offset (3 + rotary) [m, rad]."""
        self.base: dict[str, float] = {}
        """Machine coordinates that stand for the origin of the part, where no set-up sheet tells them."""
        self.local = [0.0] * size
        self.position = [0.0] * size
        self.kept: list[float] | None = None
        """The position that G92.2 put aside."""
        self.turned: Matrix | None = None
        self.tilted = False
        self.scaled: Matrix | None = None
        self.mirrored: Matrix | None = None

    def apply(self) -> None:
        """Hand the frame to the control."""
        control = self.control
        shifts = [self.moved.get(self.offset), self.local, self.position]
        total = [sum(parts) for parts in zip(*(shift for shift in shifts if shift is not None))]
        made = affine.shift(total) if any(total[:3]) else affine.IDENTITY
        for part in (self.turned, self.scaled, self.mirrored):
            if part is not None:
                made = part if made is affine.IDENTITY else affine.product(made, part)
        control.set_frame(made, tilted=self.tilted)
        if tuple(total[3:]) != control.turn:
            control.set_rotary_shift(tuple(total[3:]))

    # Work offsets

    def work_offset(self, numbers: Numbers, word: str) -> None:
        """G54 to G59.3."""
        self._take_offset(word)

    def numbered_offset(self, numbers: Numbers, word: str) -> None:
        """G54.1 P, G154 P."""
        if "P" not in numbers:
            raise WordError(f"{word} needs the number of its offset as P: write it like {word} P1")
        self._take_offset(f"{word} P{numbers.pop('P'):g}")

    def indexed_offset(self, numbers: Numbers, word: str) -> None:
        """MillPlus: I tells the line of the table."""
        index = numbers.pop("I", None)
        self._take_offset(word if index is None else f"{word} I{index:g}")

    def no_offset(self, numbers: Numbers, word: str) -> None:
        """The stand-in of an offset."""
        self._take_offset("")

    def _take_offset(self, name: str) -> None:
        control = self.control
        if not control.setup.offsets and name:
            control.findings.assumed("without a set-up sheet the origin of the part stands for every work offset")
        self.offset = name
        control.set_offset(name)
        self.apply()

    def set_offset(self, numbers: Numbers, word: str) -> None:
        """G10 L2 and L20: where an offset is, or what the place where the machine is shall be called in it."""
        kind, number = numbers.pop("L", 0.0), int(numbers.pop("P", 0.0))
        if kind not in (2.0, 20.0):
            raise WordError(f"{word} L{kind:g} is not read: L2 and L20 are; let the set-up sheet tell tools and data")
        name = self.offset or "G54"
        if number or not self.offset:
            name = self._offset_name(number, kind) if number else name
        if self.offset == "":
            self.offset = name
        if kind == 20.0 and name != self.offset:
            raise WordError(f"{word} L20 of {name}, which is not in force, is not read: write {name} before it")
        if "R" in numbers and numbers.pop("R"):
            raise WordError(f"{word} with R turns the offset: give the turn with G68, or let the CAM system apply it")
        moved = self.moved.setdefault(name, [0.0] * len(self.local))
        given = self._given(numbers)
        for letter, value in given.items():
            slot = self.control.slots[letter]
            if kind == 20.0:
                moved[slot] += self.control.words[slot] - value
            elif not self.state.absolute:
                moved[slot] += value
            else:
                sheet = self.control.setup.offsets.get(name)
                zero = sheet.get(letter, 0.0) if sheet else self.base.setdefault(letter, value)
                moved[slot] = value - zero
        if kind == 2.0 and not self.control.setup.offsets:
            self.control.findings.assumed(f"the first offsets that {word} L2 sets are where the part's origin is")
        self.apply()

    def _offset_name(self, number: int, kind: float) -> str:
        if kind == 20.0 and self.offset[:4] in ("G54.", "G154"):
            return f"{self.offset.split(' ')[0]} P{number}"
        if not 1 <= number <= 9:
            raise WordError(f"P{number} is no work offset: write P1 (G54) to P9 (G59.3)")
        return ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")[number - 1]

    # Shifts

    def _given(self, numbers: Numbers) -> Numbers:
        """Axis words, taken out of the block, in SI units."""
        slots, unit = self.control.slots, self.state.unit
        given: Numbers = {}
        for letter in [letter for letter in numbers if letter in slots or letter in "ABCUVW"]:
            value = numbers.pop(letter)
            if letter in slots:
                given[letter] = value * (unit if slots[letter] < 3 else DEGREE)
            elif letter in "ABC" and value:
                self.control.slot(letter)
        return given

    def local_shift(self, numbers: Numbers, word: str) -> None:
        """G52: in place of the one before, of the axes named."""
        for letter, value in self._given(numbers).items():
            self.local[self.control.slots[letter]] = value
        self.apply()

    def datum(self, numbers: Numbers, word: str) -> None:
        """MillPlus G93: the datum, in the coordinates of the work offset; axes that are not named keep theirs."""
        self.turned, self.tilted = None, False
        self.local_shift(numbers, word)

    def datum_added(self, numbers: Numbers, word: str) -> None:
        """MillPlus G92: a shift of the datum from where it is."""
        for letter, value in self._given(numbers).items():
            self.local[self.control.slots[letter]] += value
        self.apply()

    def set_position(self, numbers: Numbers, word: str) -> None:
        """G92: the place where the machine is gets these words."""
        given = self._given(numbers)
        if (self.turned or self.scaled or self.mirrored) and given:
            raise WordError(f"{word} in turned, tilted or scaled coordinates is not read: end those before it")
        for letter, value in given.items():
            slot = self.control.slots[letter]
            self.position[slot] += self.control.words[slot] - value
        self.apply()

    def clear_position(self, numbers: Numbers, word: str) -> None:
        """G92.1."""
        self.position, self.kept = [0.0] * len(self.position), None
        self.apply()

    def suspend_position(self, numbers: Numbers, word: str) -> None:
        """G92.2."""
        self.kept, self.position = list(self.position), [0.0] * len(self.position)
        self.apply()

    def restore_position(self, numbers: Numbers, word: str) -> None:
        """G92.3."""
        if self.kept is not None:
            self.position = list(self.kept)
        self.apply()

    # Turns, scales, mirrors

    def rotate(self, numbers: Numbers, word: str) -> None:
        """G68: turn the plane about a point, that where the machine is unless X, Y tell another, by R [deg]."""
        if any(letter in numbers for letter in "IJK"):
            raise WordError(f"{word} with I, J, K turns about a vector, which is not read: write G68.2, or points")
        if "R" not in numbers:
            raise WordError(f"{word} needs its angle as R: write it like {word} X0 Y0 R30")
        normal = _NORMAL[self.state.plane]
        angle = numbers.pop("R") * DEGREE
        about = self._about(numbers)
        about[normal] = 0.0
        back = [-value for value in about]
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

    def rotation_off(self, numbers: Numbers, word: str) -> None:
        """G69."""
        self.turned, self.tilted = None, False
        self.apply()

    def tilt(self, frame: Matrix) -> None:
        """Lay the coordinates into a tilted plane."""
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
        made = affine.product(affine.shift([2.0 * place for place in places]), affine.scaling(signs))
        self.mirrored = made if self.mirrored is None else affine.product(self.mirrored, made)
        self.apply()

    def mirror_off(self, numbers: Numbers, word: str) -> None:
        """G50.1."""
        for letter in "XYZ":
            numbers.pop(letter, None)
        self.mirrored = None
        self.apply()

"""Work offsets: the active one, and the program's changes of each."""

from __future__ import annotations

from collections.abc import Callable

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import Numbers, RefusedError

FrameOf = Callable[[str], tuple[Matrix, tuple[float, ...]]]
RADII = (12.0, 13.0)
"""Kinds of G10 that set the radius of a tool and its wear: compensation by it is refused then."""
DATA = (50.0, 52.0)
"""Kinds of G10 that begin a table of the controller's parameters (Fanuc B-63944EN, chapter 16.2, "Programmable
parameter input")."""


class Offsets:
    """Carries out G54 to G59.3, G54.1 P, G154 P and G10 L2, L20."""

    def __init__(
        self, control: Control, state: Modal, by: Controller, frame_of: FrameOf, changed: Callable[[], None]
    ) -> None:
        """frame_of: the program's own frame in an offset, and its rotary shift. changed: coordinates have moved."""
        self.control, self.state, self.frame_of, self.changed = control, state, frame_of, changed
        self.offset: str = by.option("first_offset", "")
        if self.offset in control.setup.offsets:
            control.set_offset(self.offset)
        self.always_absolute = by.option("offsets_are_absolute", False)
        self.plain = by.option("rs274_checks", False)
        """Whether P beside G54 is of another word."""
        self.turns = by.option("offsets_turn", False)
        self.of_zero = by.option("offset_zero", "in force")
        """What P0 of G10 L2 names: the offset in force, that which is added to all, or the local shift (G52)."""
        self.extended: str = by.option("extended_offsets", "")
        """Offsets that G10 L20 tells, by their number; "": it calls the place where the machine is (LinuxCNC)."""
        self.moved: dict[str, list[float]] = {}
        """How far the program has moved each work offset (3 + rotary) [m, rad]."""
        self.turned: dict[str, float] = {}
        """By how much it has turned each about Z [rad]."""
        self.shifted: Callable[[], bool] = lambda: False
        """Whether the program shifts its coordinates within the offset."""
        self.need_plain: Callable[[str], None] = lambda word: None
        """Refuses to move the offset in force where other coordinates stand in it."""
        self.external = [0.0] * len(control.words)
        """By how much it has moved all of them (3 + rotary) [m, rad]."""
        self.base: dict[str, float] = {}
        """Machine coordinates that stand for the origin of the part, where no set-up sheet tells them."""

    def work_offset(self, numbers: Numbers, word: str) -> None:
        """G54 to G59.3; Fanuc's G54 P3 is G54.1 P3."""
        number = numbers.pop("P", None) if word == "G54" and not self.plain else None
        self.take(word if number is None else f"G54.1 P{self._number(number, word):g}")

    def numbered_offset(self, numbers: Numbers, word: str) -> None:
        """G54.1 P, G154 P."""
        if "P" not in numbers:
            raise BlockError(f"{word} needs the number of its offset as P: write it like {word} P1")
        self.take(f"{word} P{self._number(numbers.pop('P'), word):g}")

    def _number(self, number: float, word: str) -> float:
        """Of an extended offset: Fanuc has 300 at most, Haas 99. Raises BlockError."""
        most = 99 if self.extended == "G154" else 300
        if number != int(number) or not 1 <= number <= most:
            raise BlockError(f"{word} P{number:g} is no offset: write P1 to P{most}")
        return number

    def indexed_offset(self, numbers: Numbers, word: str) -> None:
        """MillPlus: I tells the line of the table; with axes the block may write into it."""
        index = numbers.pop("I", None)
        if numbers.keys() & set("XYZABC"):
            numbers.clear()
            raise RefusedError(f"{word} with X, Y, Z, A, B or C", "write the motion in a block of its own")
        self.take(word if index is None else f"{word} I{index:g}")

    def no_offset(self, numbers: Numbers, word: str) -> None:
        """The stand-in of an offset."""
        self.take("")

    def take(self, name: str) -> None:
        """Put an offset in force."""
        name = self._on_sheet(name)
        if name != self.offset:
            self.need_plain(name)
        self.offset = name
        self.control.set_offset(self.offset)
        self.changed()

    def set_offset(self, numbers: Numbers, word: str) -> None:
        """G10 L2 and L20: where an offset is, or what the place where the machine is shall be called in it.

        L20 is LinuxCNC's word for the latter; where there are extended offsets, it is L2 of those.
        """
        without = "P" not in numbers
        kind, number = numbers.pop("L", 0.0), numbers.pop("P", 0.0)
        if kind in RADII:
            numbers.clear()
            self.state.programmed_radii.add(number)
            self.control.findings.ignored(f"{word} L{kind:g}")
            return
        if kind in DATA:
            self._data(numbers, f"{word} L{kind:g}")
            return
        if kind not in (2.0, 20.0):
            raise RefusedError(f"{word} L{kind:g}", "L2 and L20 are read: let the set-up sheet tell tools and data")
        if kind == 20.0 and self.extended and number < 1.0:
            raise BlockError(f"{word} L20 needs the number of an offset {self.extended} as P: write it like L20 P1 X0")
        if kind == 20.0 and self.extended:
            self._number(number, f"{word} L20")
        if number != int(number) or (without and (self.always_absolute or self.of_zero != "in force")):
            raise BlockError(f"P{number:g} of {word} is the number of an offset: write a whole number")
        if number == 0.0 and kind == 2.0 and self.of_zero == "external":
            self._move_all(numbers, word)
            return
        if kind == 20.0 and self.extended:
            name, kind = self._on_sheet(f"{self.extended} P{number:g}"), 2.0
        else:
            name = self._offset_name(int(number), kind) if number else self.offset or "G54"
        if self.offset == "":
            self.offset = name
        if name == self.offset:
            self.need_plain(word)
        if "R" in numbers:
            self._turn(name, numbers.pop("R"), kind, word)
        self._put(name, kind, numbers, word)

    def _put(self, name: str, kind: float, numbers: Numbers, word: str) -> None:
        """Move an offset to the values of the axes given, or by kind 20 so that the place here has them."""
        moved = self.moved.setdefault(name, [0.0] * len(self.control.words))
        axes = axis_words(self.control, self.state, numbers)
        if self.control.setup.offsets and name not in self.control.setup.offsets:
            self._add(name, axes, word)
        if kind == 20.0:
            self._call_here(name, axes)
        else:
            for letter, value in axes.items():
                slot = self.control.slots[letter]
                moved[slot] = self._moved_to(name, letter, value, moved[slot])
            if not self.control.setup.offsets:
                self.control.findings.assumed(f"the first offsets that {word} L2 sets are where the part's origin is")
        self.changed()

    def _add(self, name: str, axes: Numbers, word: str) -> None:
        """An offset that is not on the sheet, which tells others."""
        self.control.add_offset(name)
        missing = [letter for letter in "XYZ" if letter not in axes]
        if missing:
            self.control.findings.assumed(
                f"{name} is not on the set-up sheet: {', '.join(missing)}, which {word} does not set, "
                "are at the machine's zero"
            )

    def _move_all(self, numbers: Numbers, word: str) -> None:
        """P0: the offset that is added to all others; before, it is zero."""
        self.need_plain(word)
        for letter, value in axis_words(self.control, self.state, numbers).items():
            slot = self.control.slots[letter]
            self.external[slot] = value if self.state.absolute else self.external[slot] + value
        self.control.findings.assumed(f"the external offset is zero until {word} L2 P0 sets it")
        self.changed()

    def _turn(self, name: str, angle: float, kind: float, word: str) -> None:
        """R of G10 L2."""
        if kind == 20.0:
            raise BlockError(f"{word} L20 takes no R: turn the offset with {word} L2")
        if angle and not self.turns:
            raise RefusedError(f"{word} with R", "it turns the offset: write G68, or let the CAM system apply it")
        if name == self.offset and angle * DEGREE != self.turned.get(name, 0.0) and self.shifted():
            raise RefusedError(
                f"{word} with R while G92 or G52 shifts",
                "LinuxCNC's interpreter then takes other places for axes that are not named: write G92.1 before it",
            )
        self.turned[name] = angle * DEGREE

    def _moved_to(self, name: str, letter: str, value: float, before: float) -> float:
        """How far an offset is moved that is set to a value [m, rad], along one axis."""
        if not self.state.absolute and not self.always_absolute:
            return before + value
        sheet = self.control.setup.offsets.get(name)
        zero = sheet.get(letter, 0.0) if sheet is not None else self.base.setdefault(letter, value)
        return value - zero

    def _call_here(self, name: str, axes: Numbers) -> None:
        """Move an offset, in force or not, so that the place where the machine is has the words given in it."""
        frame, turn = self.frame_of(name)
        present = self.control.words_in(name, frame, turn)
        off = [0.0] * len(present)
        for letter, value in axes.items():
            slot = self.control.slots[letter]
            off[slot] = present[slot] - value
        off[:3] = affine.direct(affine.rotation(2, self.turned.get(name, 0.0)), off[:3])
        self.moved[name] = [a + b for a, b in zip(self.moved[name], off)]

    def _data(self, numbers: Numbers, word: str) -> None:
        """G10 L50 and L52: what follows up to G11 are parameters of the controller, N their numbers."""
        numbers.clear()
        self.state.in_data = True
        self.control.findings.assumed(f"the parameters of the controller that {word} sets change no motion")

    def end_of_data(self, numbers: Numbers, word: str) -> None:
        """G11."""
        self.state.in_data = False

    def _on_sheet(self, name: str) -> str:
        """Of the two names of an offset of Haas, G110 and G154 P1, the one on the set-up sheet."""
        if self.extended != "G154":
            return name
        digits = name.removeprefix("G154 P") if name.startswith("G154 P") else name[1:]
        number = int(digits) if digits.isdecimal() else 0
        number = number if name.startswith("G154 P") else number - 109
        if not 1 <= number <= 20:
            return name
        short = f"G{109 + number}"
        return short if short in self.control.setup.offsets else f"G154 P{number}"

    def _offset_name(self, number: int, kind: float) -> str:
        if kind == 20.0 and self.offset.startswith("G54.1 "):
            return f"G54.1 P{number}"
        most, last = (9, "G59.3") if self.of_zero == "in force" else (6, "G59")
        if not 1 <= number <= most:
            raise BlockError(f"P{number} is no work offset: write P1 (G54) to P{most} ({last})")
        return ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")[number - 1]


def axis_words(control: Control, state: Modal, numbers: Numbers) -> Numbers:
    """Axis words, taken out of the block, in SI units."""
    slots, unit = control.slots, state.unit
    found: Numbers = {}
    for letter in [letter for letter in numbers if letter in slots or letter in "ABCUVW"]:
        value = numbers.pop(letter)
        if letter in slots:
            found[letter] = value * (unit if slots[letter] < 3 else DEGREE)
        elif letter in "ABC" and value:
            control.slot(letter)
    return found

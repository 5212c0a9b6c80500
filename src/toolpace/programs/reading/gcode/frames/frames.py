"""The frame of a program: shifts, rotations, scales, mirrors, tilted planes."""

from __future__ import annotations

from toolpace.programs.reading.arcs import PLANE_ACROSS, ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.frames.offsets import Offsets, axis_words
from toolpace.programs.reading.gcode.frames.transforms import Transforms
from toolpace.programs.reading.gcode.modal import Modal
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, RefusedError


class Frames:
    """Work offsets, local shifts (G52), positions (G92), rotations (G68), tilts (G68.2), scales and mirrors.

    Each acts in the coordinates made by those before it, in this order.
    """

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        size = len(control.words)
        self.local = [0.0] * size
        self.position = [0.0] * size
        self.stored = self.position
        """The position that G92.3 restores."""
        self.position_on = False
        """Whether a position is in force, be it zero."""
        self.one_shift = by.option("local_shift_is_position", False)
        self.transforms = Transforms(control, state, by)
        self.plane: Matrix | None = None
        """The tilted plane in force."""
        self.indexed = by.option("indexed_words", False)
        self.offsets = Offsets(control, state, by, self.of_offset, self.apply)
        self.offsets.shifted = lambda: any(self.position[:2]) or any(self.local[:2])
        if not self.indexed:
            self.offsets.need_plain = self._need_plain

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
            "rotate": self.rotate,
            "rotation off": self.rotation_off,
            **self.transforms.handlers(self._transformed),
        }

    def apply(self) -> None:
        """Hand the frame to the control."""
        made, turn = self.of_offset(self.offsets.offset)
        self.control.set_frame(made, tilted=self.plane is not None)
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
        for part in (self.plane, self.transforms.matrix):
            if part is not None and part is not affine.IDENTITY:
                made = part if made is affine.IDENTITY else affine.product(made, part)
        return made, tuple(total[3:])

    # Shifts

    def set_offset(self, numbers: Numbers, word: str) -> None:
        """G10: work offsets; to Haas P0 of L2 is the shift of G52."""
        if self.offsets.of_zero == "local" and numbers.get("L") == 2.0 and numbers.get("P") == 0.0:
            numbers.pop("L")
            numbers.pop("P")
            self._need_plain(word)
            for letter, value in axis_words(self.control, self.state, numbers).items():
                slot = self.control.slots[letter]
                self.local[slot] = value if self.state.absolute else self.local[slot] + value
            self.apply()
        else:
            self.offsets.set_offset(numbers, word)

    def local_shift(self, numbers: Numbers, word: str) -> None:
        """G52: in place of the one before, of the axes named; LinuxCNC has one shift for G52 and G92."""
        shift = list(self.position if self.one_shift else self.local)
        for letter, value in self._axes(numbers, word).items():
            shift[self.control.slots[letter]] = value
        if shift != (self.position if self.one_shift else self.local):
            self._need_plain(word)
        if self.one_shift:
            self.position = self.stored = shift
            self.position_on = True
        else:
            self.local = shift
        self.apply()

    def _axes(self, numbers: Numbers, word: str) -> Numbers:
        """Axis words, of which the controller may need one."""
        if self.one_shift and not any(letter in numbers for letter in "XYZABCUVW"):
            raise BlockError(f"{word} names no axis: write it like {word} X0 Y0")
        return axis_words(self.control, self.state, numbers)

    def datum(self, numbers: Numbers, word: str) -> None:
        """MillPlus G93: the datum, in the coordinates of the work offset; axes that are not named keep theirs."""
        self.plane = None
        self.local_shift(numbers, word)

    def datum_added(self, numbers: Numbers, word: str) -> None:
        """MillPlus G92: a shift of the datum from where it is."""
        for letter, value in axis_words(self.control, self.state, numbers).items():
            self.local[self.control.slots[letter]] += value
        self.apply()

    def set_position(self, numbers: Numbers, word: str) -> None:
        """G92: the place where the machine is gets these words."""
        axes = self._axes(numbers, word)
        if axes:
            self._need_plain(word)
        self.position = self.stored = list(self.position)
        for letter, value in axes.items():
            slot = self.control.slots[letter]
            self.position[slot] += self.control.words[slot] - value
        self.position_on = True
        self.apply()

    def clear_position(self, numbers: Numbers, word: str) -> None:
        """G92.1."""
        if any(self.position):
            self._need_plain(word)
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

    # Turns, scales, mirrors, planes

    def rotate(self, numbers: Numbers, word: str) -> None:
        """G68: turn the plane about a point by R [deg]."""
        if "R" not in numbers:
            raise BlockError(f"{word} needs its angle as R: write it like {word} X0 Y0 R30")
        if self.plane is not None:
            raise RefusedError(
                f"{word} in a tilted plane", "turn the plane by its own angles (the last of them turns it in itself)"
            )
        if self.state.turned_plane not in (None, self.state.plane):
            raise RefusedError(f"{word} in another plane than the turn in force", "end that turn before: write G69")
        before = self.control.words[:3]
        about_tool = any(letter in numbers for letter in "IJK")
        if about_tool:
            self.transforms.turn_about_tool(numbers, word)
        else:
            self.transforms.turn(numbers, word)
            self.state.turned_plane = self.state.plane
        self.apply()
        normal = 2 if about_tool else PLANE_ACROSS[self.state.plane]
        inside = [slot for slot in range(3) if slot != normal]
        if any(abs(before[slot] - self.control.words[slot]) > ROUNDING for slot in inside):
            self.state.not_alone = (inside[0], inside[1])

    def rotation_off(self, numbers: Numbers, word: str) -> None:
        """G69."""
        self.transforms.turn_off()
        self.plane = self.state.not_alone = self.state.turned_plane = None
        self.apply()

    def tilt(self, frame: Matrix | None, word: str = "a tilted plane") -> None:
        """Lay the coordinates into a tilted plane, in place of the one before; None ends it."""
        if self.transforms.turned is not None:
            raise RefusedError("a tilted plane in turned coordinates (G68)", "end the turn before it: write G69")
        if self.transforms.any:
            raise RefusedError(f"{word} in scaled or mirrored coordinates", "end those before it: write G50, G50.1")
        coordinates = self.control.coordinates
        begun = coordinates.fixed_at if coordinates.tip_mode and self.plane is None else None
        if frame is not None and begun is not None and any(self.control.poses.carried(begun)):
            raise RefusedError(
                f"{word} in tool-centre-point mode that began with the table turned",
                "controls differ in where the plane is then: write G49 before it",
            )
        self.plane, self.state.turned_in_plane = frame, False
        self.apply()

    def _transformed(self, numbers: Numbers, word: str) -> None:
        self.state.scaled = self.transforms.scaled is not None
        self.apply()

    def _need_plain(self, word: str) -> None:
        """Refuse to move the origin in which mirrors, scales, turns or a plane stand.

        "In coordinate system rotation mode, G codes [...] for changing the coordinate system (G52 to G59, G92, etc.)
        must not be specified" (B-63944EN-2, and so of the programmable mirror image): the centre may go with it or
        stay.
        """
        if self.transforms.any or self.plane is not None:
            raise RefusedError(
                f"{word} in turned, scaled, mirrored or tilted coordinates",
                "controls differ in whether their centre goes with it: end those before it (G69, G50, G50.1)",
            )

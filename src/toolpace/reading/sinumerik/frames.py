"""Frames that a program sets: TRANS, ROT, SCALE, MIRROR and their additive kin, settable offsets, tilted planes.

The chain (Function Manual Basic Functions, K2): settable offset, then the frame of a tilted plane, then the
programmed frame. TRANS, ROT, ROTS, SCALE and MIRROR replace the whole programmed frame; ATRANS and its kin append.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.reading.control.control import Control
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.reading.sinumerik.given import Words, number
from toolpace.reading.sinumerik.state import State
from toolpace.reading.sinumerik.syntax import frame_functions
from toolpace.reading.sinumerik.syntax.values import Axis, Unread, Value, ValueFault, real, whole
from toolpace.units import DEGREE

PROGRAMMED = ("TRANS", "ROT", "ROTS", "SCALE", "MIRROR", "ATRANS", "AROT", "AROTS", "ASCALE", "AMIRROR")
SETTABLE = {0: "G500", **{k: f"G{53 + k}" for k in range(1, 5)}, **{k: f"G{500 + k}" for k in range(5, 100)}}
"""Names of the settable offsets by their number in $P_UIFR."""


class Saved(NamedTuple):
    """Frames at a point of the program."""

    linear: Matrix
    coarse: list[float]
    fine: list[float]
    plane: Matrix
    tilted: bool
    offset: int
    coarse_turn: list[float]
    fine_turn: list[float]


class Frames:
    """The frames in force, and the settable ones that the program wrote."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.linear: Matrix = IDENTITY
        """Rotation, scale and mirror of the programmed frame."""
        self.coarse, self.fine = [0.0] * 3, [0.0] * 3
        """Shifts of TRANS (or G58) and of ATRANS (or G59) [m], in the coordinates before the rotation."""
        self.plane: Matrix = IDENTITY
        """Of CYCLE800."""
        self.tilted = False
        self.settable: dict[int, Matrix] = {}
        self.offset = 0
        self.coarse_turn, self.fine_turn = ([0.0] * len(control.poses.rotary) for _ in range(2))
        """The same of rotary words [rad]."""

    def programmed(self) -> Matrix:
        """The programmed frame."""
        shift = [a + b for a, b in zip(self.coarse, self.fine)]
        return affine.product(affine.shift(shift), self.linear)

    def put(self) -> None:
        """Hand the whole chain to the control."""
        chain = affine.product(self._written(), self.plane)
        whole_frame = affine.product(chain, self.programmed())
        self.control.set_frame(IDENTITY if whole_frame == IDENTITY else whole_frame, tilted=self.tilted)
        turn = tuple(a + b for a, b in zip(self.coarse_turn, self.fine_turn))
        if self.control.coordinates.turn != turn:
            self.control.set_rotary_shift(turn)

    def _written(self) -> Matrix:
        """The settable offset as the program wrote it, seen from the first that it wrote: that is where the part is."""
        found = self.settable.get(self.offset)
        first = next(iter(self.settable.values()), IDENTITY)
        return IDENTITY if found is None or found == first else affine.product(affine.inverse(first), found)

    def select(self, place: int) -> None:
        """Make a settable offset the one in force, 0: none."""
        self.offset = place
        self.control.set_offset(SETTABLE[place] if place else "")
        self.put()

    def clear(self) -> None:
        """No programmed frame."""
        self.linear, self.coarse, self.fine = IDENTITY, [0.0] * 3, [0.0] * 3
        self.coarse_turn, self.fine_turn = ([0.0] * len(self.coarse_turn) for _ in range(2))

    def program(self, code: str, words: Words, state: State) -> None:
        """TRANS X10, AROT Z30, ...: the words of its block. Raises ValueFault."""
        kind = code[1:] if code[0] == "A" else code
        if code == kind:
            self.clear()
        if kind == "TRANS":
            self._shift(words, state, additive=code != kind)
        else:
            made = self._turned(kind, words, state)
            for letter in self._rotary(words):
                raise Unread(f"{code} with {letter}", "it acts on X, Y and Z here: let the CAM system write the rest")
            self.linear = affine.product(self.linear, made)
        self.put()

    def _shift(self, words: Words, state: State, *, additive: bool) -> None:
        by = [(number(words, letter, 0.0) or 0.0) * state.unit for letter in "XYZ"]
        if additive:
            # a new list: saved frames keep theirs
            self.fine = [a + b for a, b in zip(self.fine, affine.direct(self.linear, by))]
        else:
            self.coarse = by
        for letter, place in self._rotary(words).items():
            value = (number(words, letter, 0.0) or 0.0) * DEGREE
            if additive:
                self.fine_turn = _with(self.fine_turn, place, self.fine_turn[place] + value)
            else:
                self.coarse_turn = _with(self.coarse_turn, place, value)

    def _rotary(self, words: Words) -> dict[str, int]:
        """Rotary letters of a block, and the place of each among the rotary words."""
        return {letter: slot - 3 for letter, slot in self.control.slots.items() if slot >= 3 and letter in words}

    def _turned(self, kind: str, words: Words, state: State) -> Matrix:
        if kind == "MIRROR":
            return frame_functions.mirror([letter for letter in "XYZ" if words.pop(letter, None) is not None])
        angle = number(words, "RPL")
        if angle is not None and kind in ("ROT", "ROTS"):
            return affine.rotation((2, 1, 0)[state.plane], angle * DEGREE)
        values = {letter: value for letter in "XYZ" if (value := number(words, letter)) is not None}
        if kind == "SCALE":
            return frame_functions.scale(values)
        return frame_functions.rotation(values) if kind == "ROT" or len(values) < 2 else solid(values)

    def axis_shift(self, code: str, words: Words, state: State) -> None:
        """G58 and G59: the coarse or the fine shift of the axes that are named (K2: axial replacement)."""
        part = list(self.coarse if code == "G58" else self.fine)
        for slot, letter in enumerate("XYZ"):
            value = number(words, letter)
            if value is not None:
                part[slot] = value * state.unit
        coarse = code == "G58"
        turns = self.coarse_turn if coarse else self.fine_turn
        for letter, place in self._rotary(words).items():
            turns = _with(turns, place, (number(words, letter, 0.0) or 0.0) * DEGREE)
        if coarse:
            self.coarse, self.coarse_turn = part, turns
        else:
            self.fine, self.fine_turn = part, turns
        self.put()

    def write(self, index: tuple[Value, ...], value: Value, unit: float) -> None:
        """$P_UIFR[n]=frame, $P_UIFR[n, X, TR]=5: they act at the next G54. Raises ValueFault."""
        place = whole(index[0]) if index else 1
        if place not in SETTABLE:
            raise ValueFault(f"$P_UIFR[{place}] does not exist: 0 is G500, 1 to 4 are G54 to G57, 5 to 99 G505 to G599")
        if self.control.setup.offsets:
            raise Unread("$P_UIFR", "the set-up sheet says where the offsets are: remove them there, or this here")
        self.control.findings.assumed("the first settable offset that the program writes is the origin of the part")
        if len(index) < 2:
            if not isinstance(value, tuple) or isinstance(value, Axis):
                raise ValueFault("$P_UIFR[n] is a frame: assign one, like CTRANS(X,10)")
            self.settable[place] = value
            return
        axis, part = index[1], index[2] if len(index) > 2 else None
        letter = axis.letter if isinstance(axis, Axis) else ""
        if not isinstance(part, str) or letter not in frame_functions.SLOTS:
            raise Unread("$P_UIFR[n, axis, part]", "its axis or its part is not read: use X, Y, Z and TR")
        if part != "TR":
            raise Unread(f"$P_UIFR[n, axis, {part}]", "of the parts of a frame TR is read: write the whole frame")
        present = self.settable.get(place, IDENTITY)
        slot = frame_functions.SLOTS[letter]
        by = [real(value) * unit - present[slot][3] if k == slot else 0.0 for k in range(3)]
        self.settable[place] = affine.product(affine.shift(by), present)

    def saved(self) -> Saved:
        """What a subprogram with SAVE gives back."""
        return Saved(
            self.linear, self.coarse, self.fine, self.plane, self.tilted, self.offset, self.coarse_turn, self.fine_turn
        )  # fmt: skip

    def restore(self, state: Saved) -> None:
        """Frames as they were."""
        self.linear, self.plane, self.tilted = state.linear, state.plane, state.tilted
        self.coarse, self.fine = list(state.coarse), list(state.fine)
        self.coarse_turn, self.fine_turn = list(state.coarse_turn), list(state.fine_turn)
        self.select(state.offset)


def _with(values: list[float], place: int, value: float) -> list[float]:
    """A new list, with another value at a place: saved frames keep theirs."""
    return [value if k == place else each for k, each in enumerate(values)]


def solid(degrees: dict[str, float]) -> Matrix:
    """ROTS: a plane by the angles of its intersections with two planes of the coordinates [deg].

    X, Y: the new X axis lies in the old ZX plane; Z, X: the new Z axis in the old YZ plane; Y, Z: the new Y axis in
    the old XY plane (K2, frame rotations with solid angles).
    """
    if len(degrees) != 2:
        raise ValueFault("ROTS takes two angles: X and Y, Y and Z, or Z and X")
    missing = next(slot for slot in range(3) if "XYZ"[slot] not in degrees)
    first, second = (missing + 1) % 3, (missing + 2) % 3
    a, b = degrees["XYZ"[first]] * DEGREE, degrees["XYZ"[second]] * DEGREE
    along, across = [0.0] * 3, [0.0] * 3
    along[first], along[missing] = math.cos(b), -math.sin(b)
    across[second], across[missing] = math.cos(a), math.sin(a)
    normal = _unit(_cross(along, across))
    columns = {first: along, second: _cross(normal, along), missing: normal}
    return affine.linear([[columns[column][row] for column in range(3)] for row in range(3)])


def _cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _unit(a: list[float]) -> list[float]:
    size = math.hypot(*a)
    if size < 1e-9:
        raise ValueFault("these angles of ROTS span no plane: correct them")
    return [value / size for value in a]

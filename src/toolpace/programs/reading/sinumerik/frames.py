"""Frames: TRANS, ROT, SCALE, MIRROR and additive forms, settable offsets, tilted planes.

The chain (Function Manual Basic Functions, K2): settable offset, then the frame of a tilted plane, then the
programmed frame. TRANS, ROT, ROTS, SCALE and MIRROR replace the whole programmed frame; ATRANS and its kin append.
"""

from __future__ import annotations

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_ACROSS
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import (
    SLOTS,
    Axis,
    Unread,
    Value,
    mirror,
    real,
    rotation,
    scale,
    solid,
    whole,
)
from toolpace.programs.reading.sinumerik.word_values import Words, number

PROGRAMMED = ("TRANS", "ROT", "ROTS", "SCALE", "MIRROR", "ATRANS", "AROT", "AROTS", "ASCALE", "AMIRROR")
SETTABLE = {0: "G500", **{k: f"G{53 + k}" for k in range(1, 5)}, **{k: f"G{500 + k}" for k in range(5, 100)}}
"""Names of the settable offsets by their number in $P_UIFR."""
ENDS_ATRANS = (
    "TRANS ends the shift of ATRANS before it, as it deletes old instructions; a table of the manuals (at G58, G59) "
    "has it unchanged"
)
NOT_SAVED = ("control", "state", "settable", "origin", "moves_before", "in_force")
"""What a subprogram with SAVE does not give back: the control, and data of the settable offsets."""


class Frames:
    """The frames in force, and the settable ones that the program wrote."""

    def __init__(self, control: Control, state: State) -> None:
        self.control, self.state = control, state
        self.linear: Matrix = IDENTITY
        """Rotation, scale and mirror of the programmed frame."""
        self.coarse, self.fine = [0.0] * 3, [0.0] * 3
        """Shifts of TRANS (or G58) and of ATRANS (or G59) [m], in the coordinates before the rotation."""
        self.assigned = False
        """Whether $P_PFRAME was assigned as a whole: which part of its shift is the fine one is not told."""
        self.plane: Matrix = IDENTITY
        """Of CYCLE800."""
        self.tilted = False
        self.turned_to: list[float] | None = None
        """Rotary joints that the plane of CYCLE800 was reckoned for [rad]; None where it turned none (_DIR 0)."""
        self.plane_axis: list[float] = []
        """(3,) Z of that plane on the part."""
        self.tool: Matrix = IDENTITY
        """Of TOROT: the system frame before the programmed one (K2, "TOROT and TOFRAME")."""
        self.tool_bound = False
        """Whether that one may go with the programmed frame: it was turned, or TOFRAME wrote it there."""
        self.settable: dict[int, Matrix] = {}
        self.origin: Matrix | None = None
        """Where the part is: the settable offset that the program wrote first, as it was when it moved; None before."""
        self.moves_before = 0
        """Moves when it wrote it."""
        self.offset = 0
        self.selected = False
        """Whether the program has named a settable offset."""
        self.in_force: tuple[int, Matrix] = (0, IDENTITY)
        """The settable offset, and all frames upon it, as they were put last."""
        self.coarse_turn, self.fine_turn = ([0.0] * len(control.poses.rotary) for _ in range(2))
        """The same of rotary words [rad]."""

    @property
    def turns_words(self) -> bool:
        """Whether it shifts rotary words, which its matrix does not tell."""
        return any(self.coarse_turn) or any(self.fine_turn)

    def programmed(self) -> Matrix:
        """The programmed frame."""
        shift = [a + b for a, b in zip(self.coarse, self.fine)]
        return affine.product(affine.shift(shift), self.linear)

    def put(self) -> None:
        """Hand the whole chain to the control."""
        chain = affine.product(affine.product(self._written(), self.plane), self.tool)
        whole_frame = affine.product(chain, self.programmed())
        if self.in_force != (self.offset, whole_frame):
            self.in_force = self.offset, whole_frame
            self.state.other_coordinates()
        self.control.set_frame(IDENTITY if whole_frame == IDENTITY else whole_frame, tilted=self.tilted)
        turn = tuple(a + b for a, b in zip(self.coarse_turn, self.fine_turn))
        if self.control.coordinates.turn != turn:
            self.control.set_rotary_shift(turn)

    def _written(self) -> Matrix:
        """The settable offset as the program wrote it, seen from the first that it wrote: that is where the part is."""
        found = self.settable.get(self.offset)
        first = next(iter(self.settable.values()), IDENTITY) if self.origin is None else self.origin
        return IDENTITY if found is None or found == first else affine.product(affine.inverse(first), found)

    def select(self, place: int) -> None:
        """Make a settable offset the one in force, 0: none.

        G500 counts from the machine's zero where the set-up sheet tells other offsets ("deactivation of all settable
        offsets", Programming Manual Fundamentals, "Settable work offset"); without, the part's origin stands for all.
        """
        self.offset, self.selected = place, True
        offsets = self.control.setup.offsets
        if not place and offsets and SETTABLE[0] not in offsets:
            self.control.add_offset(SETTABLE[0])
        self.control.set_offset(SETTABLE[place] if place or offsets else "")
        self.put()

    def clear(self) -> None:
        """No programmed frame."""
        self.linear, self.coarse, self.fine, self.assigned = IDENTITY, [0.0] * 3, [0.0] * 3, False
        self.coarse_turn, self.fine_turn = ([0.0] * len(self.coarse_turn) for _ in range(2))

    def _replace(self, code: str) -> None:
        """Clear the programmed frame; Unread where a frame of TOROT was reckoned upon it."""
        if self.tool_bound:
            raise Unread(f"{code} after TOROT", "the frame that TOROT turned goes with it: write TOROTOF before")
        self.clear()

    def turn_before_programmed(self, turn: Matrix, *, bound: bool = False) -> None:
        """Turn the coordinates in force about their origin, by a frame before the programmed one (TOROT)."""
        programmed = self.programmed()
        about = affine.product(affine.product(programmed, turn), affine.inverse(programmed))
        self.tool = IDENTITY if turn == IDENTITY and self.tool == IDENTITY else affine.product(self.tool, about)
        self.tool_bound = self.tool != IDENTITY and (bound or programmed != IDENTITY)
        self.put()

    def end_tool_frame(self, code: str) -> None:
        """TOROTOF, PAROTOF. Raises Unread where a plane of CYCLE800 is in force, which they may take apart."""
        if self.tilted:
            raise Unread(f"{code} in a plane of CYCLE800", "it may take parts of the plane away: write CYCLE800()")
        if code != "PAROTOF" and self.tool != IDENTITY:
            self.tool, self.tool_bound = IDENTITY, False
            self.put()

    def program(self, code: str, words: Words) -> None:
        """TRANS X10, AROT Z30, ...: the words of its block. Raises BlockError."""
        for letter, word in words.items():
            if word.form not in ("", "AC"):
                raise BlockError(f"{letter}={word.form}() of {code}: write the number alone")
        kind = code[1:] if code[0] == "A" else code
        if code == kind:
            if code == "TRANS" and any(self.fine) and words:
                self.control.findings.assumed(ENDS_ATRANS)
            self._replace(code)
        if kind == "TRANS":
            self._shift(words, additive=code != kind)
        else:
            made = self._turned(kind, words)
            for letter in self._rotary(words):
                raise Unread(f"{code} with {letter}", "it acts on X, Y and Z here: let the CAM system write the rest")
            self.linear = affine.product(self.linear, made)
        self.put()

    def _shift(self, words: Words, *, additive: bool) -> None:
        by = [(number(words, letter, 0.0) or 0.0) * self.state.unit for letter in "XYZ"]
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

    def _turned(self, kind: str, words: Words) -> Matrix:
        if kind == "MIRROR":
            return mirror([letter for letter in "XYZ" if words.pop(letter, None) is not None])
        angle = number(words, "RPL")
        if angle is not None and kind in ("ROT", "ROTS"):
            return affine.rotation(PLANE_ACROSS[self.state.plane], angle * DEGREE)
        values = {letter: value for letter in "XYZ" if (value := number(words, letter)) is not None}
        if kind == "SCALE":
            return scale(values)
        return rotation(values) if kind == "ROT" or len(values) < 2 else solid(values)

    def axis_shift(self, code: str, words: Words) -> None:
        """G58 and G59: the coarse or the fine shift of the axes that are named (K2: axial replacement)."""
        if self.assigned:
            raise Unread(f"{code} after $P_PFRAME=", "which part of its shift is the fine one is not told: write TRANS")
        part = list(self.coarse if code == "G58" else self.fine)
        for slot, letter in enumerate("XYZ"):
            value = number(words, letter)
            if value is not None:
                part[slot] = value * self.state.unit
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
        """$P_UIFR[n]=frame, $P_UIFR[n, X, TR]=5: they act at the next G54. Raises BlockError."""
        place = whole(index[0]) if index else 1
        if place not in SETTABLE:
            raise BlockError(f"$P_UIFR[{place}] does not exist: 0 is G500, 1 to 4 are G54 to G57, 5 to 99 G505 to G599")
        if self.control.setup.offsets:
            raise Unread("$P_UIFR", "the set-up sheet says where the offsets are: remove them there, or this here")
        self.control.findings.assumed("the first settable offset that the program writes is the origin of the part")
        moves = len(self.control.moves)
        if not self.settable:
            self.moves_before = moves
        elif self.origin is None and moves > self.moves_before:
            self.origin = next(iter(self.settable.values()))
        if len(index) < 2:
            self.settable[place] = _frame("$P_UIFR[n]", value)
            return
        slot, _ = _shifted_axis("$P_UIFR[n, ", index[1:], ("TR",))
        present = self.settable.get(place, IDENTITY)
        by = [real(value) * unit - present[slot][3] if k == slot else 0.0 for k in range(3)]
        self.settable[place] = affine.product(affine.shift(by), present)

    def write_programmed(self, index: tuple[Value, ...], value: Value, unit: float) -> None:
        """$P_PFRAME=frame, $P_PFRAME[X, TR]=5: in force at once (K2, "$P_PFRAME"). Raises BlockError, Unread."""
        if index:
            slot, part = _shifted_axis("$P_PFRAME[", index, ("TR", "FI"))
            if part == "TR":
                self.coarse = _with(self.coarse, slot, real(value) * unit)
            else:
                self.fine = _with(self.fine, slot, real(value) * unit)
        else:
            made = _frame("$P_PFRAME", value)
            self._replace("$P_PFRAME=")
            self.assigned = True
            self.coarse = [row[3] for row in made]
            self.linear = affine.linear([row[:3] for row in made])
        self.put()

    def saved(self) -> dict[str, object]:
        """What a subprogram with SAVE gives back; no list of it is changed in place."""
        return {name: value for name, value in vars(self).items() if name not in NOT_SAVED}

    def restore(self, saved: dict[str, object]) -> None:
        """Frames as they were."""
        for name, value in saved.items():
            setattr(self, name, value)
        if self.selected:
            self.select(self.offset)
        else:
            self.control.set_offset("")
            self.put()


def _with(values: list[float], place: int, value: float) -> list[float]:
    """A new list, with another value at a place: saved frames keep theirs."""
    return [value if k == place else each for k, each in enumerate(values)]


def _frame(name: str, value: Value) -> Matrix:
    if not isinstance(value, tuple) or isinstance(value, Axis):
        raise BlockError(f"{name} is a frame: assign one, like CTRANS(X,10)")
    return value


def _shifted_axis(name: str, index: tuple[Value, ...], parts: tuple[str, ...]) -> tuple[int, str]:
    """The slot of an axis whose shift a program sets, and which: [X, TR] the coarse one, [X, FI] the fine one."""
    axis, part = index[0], index[1] if len(index) > 1 else None
    letter = axis.letter if isinstance(axis, Axis) else ""
    if not isinstance(part, str) or letter not in SLOTS:
        raise Unread(f"{name}axis, part]", "its axis or its part is not read: use X, Y, Z and TR")
    if part not in parts:
        readable = " and ".join(parts)
        raise Unread(f"{name}axis, {part}]", f"of the parts of a frame {readable} is read: write the whole frame")
    return SLOTS[letter], part

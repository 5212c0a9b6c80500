"""Motion blocks: lines, arcs, helices, and turns of rotary axes in a tilted plane.

Rotary words in a tilted plane turn their axes alone, and X, Y, Z wait until the tool stands on the plane. Nothing
follows a turn there unless tool-centre-point mode is on, as nothing follows that of G53.1. Where the plane is when the
tool has been turned off it is not told ("cancel G254 before any rotary motion", Haas UMC, G254).
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import PLANE_ACROSS, ROUNDING, Arc
from toolpace.programs.reading.control.control import FARTHEST, Control
from toolpace.programs.reading.control.corners import ROUND, SIDES, Corners
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.control.machine_moves import (
    ROUNDED,
    direction_on_part,
    plane_axis,
    repeats_rotary,
    rotary_for,
    turn_joints,
)
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.kinematics import TURN
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.circles import ArcReader
from toolpace.programs.reading.gcode.modal import ARCS, Modal
from toolpace.programs.reading.gcode.program.words import NO_EXPONENT, RefusedError

TOOL_VECTOR = ("I1", "J1", "K1")
"""The tool's direction under G141 of MillPlus."""
RAPID = (
    "G0 along the tool and aside in one block is taken to be straight; by its positioning logic the control may go "
    "along the tool first or last"
)
_USES = {
    "P": "dwells, calls or arcs (turns)",
    "Q": "cycles",
    **dict.fromkeys("IJKR", "arcs (G2, G3)"),
}
REPEATED = "rotary words in a tilted plane that repeat the positions with three decimals are taken for them"


class MotionReader:
    """Turns axis words into moves, from the state the controller is in."""

    def __init__(self, control: Control, state: Modal, controller: Controller) -> None:
        self.source, self.control, self.state = control.source, control, state
        self.rotary = controller.option("rotary", "as written")
        self.rotary_varies = controller.option("rotary_varies", False)
        self.arcs = ArcReader(control, state, controller)
        self.straight_without_centre = controller.option("arc_without_centre", "refused") == "straight"
        self.by_radius = controller.option("inverse_time_by_radius", False)
        self.fanuc = controller.option("fanuc_checks", False)
        """Whether blocks are refused that Fanuc stops with an alarm."""
        self.along = controller.option("letter_along_tool", "")
        self.stated: list[float] = []
        """(3,) X, Y, Z of the block as stated [m]."""
        self.corners = Corners(control, "it is read between two straight lines of the plane: write the corner out")
        self.rapids_vary = controller.option("rapids_vary", False)
        """Whether the control may go along the tool before or after it goes aside."""
        self.start_is_rapid = controller.option("starts_with_rapid", False)

    def execute(self, numbers: dict[str, float], number: float | None, line: int) -> None:
        """Move to the axis words of a block."""
        state, control = self.state, self.control
        motion = self._motion()
        arc_words = {}
        if motion in ARCS:
            arc_words = {letter: numbers.pop(letter) for letter in (*"IJKRP", "B5") if letter in numbers}
            if self.straight_without_centre and not arc_words:
                motion = "feed"
        if self.fanuc and state.vectors and any(letter in numbers for letter in "ABC"):
            raise BlockError("a rotary word under G43.5 stops with an alarm (PS5421): write I, J, K, or use G43.4")
        vector = {letter: numbers.pop(letter, 0.0) for letter in "IJK"} if self._has_vector(numbers) else None
        if not state.absolute and not len(control.moves):
            # distances start somewhere: at zero, as on a controller that was never told its place
            control.begin_here()
        corner = self._corner(numbers)
        before = control.words
        start = self._stated() if state.stands else before
        target, named = self.target(numbers, alone=True)
        if vector is not None:
            target[3:] = self._rotary_of(vector)
        if motion in ARCS and turns(control, target):
            refuse()
        if turned_alone(control, state, target, rapid=motion == "rapid"):
            return
        if motion in ARCS:
            if self.fanuc and state.turned_plane not in (None, state.plane):
                raise BlockError("an arc in another plane than that of G68 stops with an alarm: write G69 before it")
            arc = self.arcs.arc(arc_words, start, self.stated if state.stands else target)
            if state.stands:
                arc = self._carried(arc, target)
            if number is not None and self.by_radius:
                number *= arc.r0 / max(arc.length(), 1e-12)
            self.corners.refuse()
            control.arc(target, named, arc, number)
        else:
            if motion == "rapid" and number is not None and control.feed.mode == INVERSE:
                control.findings.ignored("F with G0 under G93")
            if self.corners.waiting is not None:
                if motion == "rapid" and self.fanuc:
                    self.corners.refuse()
                self.corners.before(target, state.plane)
            if motion == "rapid" and self.rapids_vary:
                self._say_of_rapid(before, target)
            control.straight(target, named, rapid=motion == "rapid", number=number)
        if corner is not None:
            self.corners.put(*corner, before if motion == "feed" else [])

    def _say_of_rapid(self, before: list[float], target: list[float]) -> None:
        """Say how a rapid is taken that goes along the tool and aside in one block."""
        along = PLANE_ACROSS[self.state.plane]
        moved = [abs(a - b) > ROUNDING for a, b in zip(before, target)]
        if len(self.control.moves) and moved[along] and sum(moved) > 1:
            self.control.findings.assumed(RAPID)

    def _corner(self, numbers: dict[str, float]) -> tuple[str, str, float] | None:
        """Name, kind and size [m] of the corner that a block asks for at its end."""
        for word, kind in ((",R", ROUND), (",C", SIDES)):
            if word in numbers:
                return word, kind, numbers.pop(word) * self.state.unit
        return None

    def _motion(self) -> str:
        motion = self.state.motion
        if motion is None:
            if not self.start_is_rapid:
                raise BlockError("axis words without a motion: write G0, G1, G2 or G3 before them")
            self.control.findings.assumed("motions before the first G0 or G1 are rapids")
            motion = self.state.motion = "rapid"
        return motion

    def target(self, numbers: dict[str, float], *, alone: bool = False) -> tuple[list[float], int]:
        """Words (3 + rotary) [m, rad] that a block moves to, and bits of the X, Y, Z that it names.

        alone: whether rotary words may turn their axes alone, in a tilted plane.
        """
        state, control = self.state, self.control
        slots, unit, absolute = control.slots, state.unit, state.absolute
        target = list(control.words)
        if state.stands or state.along:
            target[:3] = self._stated()
        if state.polar:
            self._from_polar(numbers, target)
        named = 0
        along = state.along
        for letter, value in numbers.items():
            slot = slots.get(letter)
            if not -FARTHEST <= value <= FARTHEST:
                raise BlockError(f"{letter}{value:g} is beyond {FARTHEST:g}: correct the number")
            if slot is None:
                if letter != self.along:
                    self._refuse_word(letter)
                along = value * unit if absolute else along + value * unit
                self._say_along()
            elif slot < 3:
                named |= 1 << slot
                target[slot] = value * unit if absolute else target[slot] + value * unit
            else:
                present = target[slot]
                turned = value * DEGREE if absolute else present + value * DEGREE
                if absolute and abs(turned - present) > 0.5 * TURN:
                    turned = self._rotary(turned, present, value)
                target[slot] = turned
        if named & 4:
            state.level_by_machine = False
        if state.not_alone is not None and named:
            self._need_both(named)
        if state.stands or along or state.along:
            self.stated, state.along = target[:3], along
            target[:3] = self._moved(target)
        if control.coordinates.tilted:
            if not alone and turns(control, target):
                refuse()
            need_on_plane(control, state, target)
        return target, named

    def _need_both(self, named: int) -> None:
        """Refuse to move one axis of a plane that was turned (G68) beside its centre, before both are named."""
        assert self.state.not_alone is not None
        first, second = self.state.not_alone
        both = named >> first & named >> second & 1
        if not both and self.state.absolute and named & (1 << first | 1 << second):
            raise RefusedError(
                "one axis alone behind G68",
                f"controls differ in where the other is: name {'XYZ'[first]} and {'XYZ'[second]} in the first motion",
            )
        if both:
            self.state.not_alone = None

    def _rotary(self, turned: float, present: float, value: float) -> float:
        """A rotary position more than half a turn away, by the rule of the controller."""
        if self.rotary == "shortest":
            return present + math.remainder(turned - present, TURN)
        if self.rotary_varies:
            self.control.findings.assumed(
                "rotary words are positions as written: turns of more than 180 degrees are made, not shortened"
            )
        return turned

    # Coordinates that are not those of the control

    def _turn_and_way(self, rotary: list[float]) -> tuple[Floats, Floats]:
        """Turn (3, 3) from words that stand to those of the control, and (3,) the way of 1 along the tool."""
        control = self.control
        if control.poses.machine is None:
            return np.eye(3), np.array([0.0, 0.0, 1.0])
        _, columns, axis = control.poses.linear_map(rotary)
        way: Floats = axis if control.placement.tip_mode else np.linalg.solve(columns, axis).astype(np.float64)
        if not self.state.stands:
            return np.eye(3), way
        _, zero, _ = control.poses.linear_map([0.0] * len(rotary))
        return columns @ np.linalg.inv(zero), way

    def _carried(self, arc: Arc, target: list[float]) -> Arc:
        """An arc in coordinates that stand, in those of the control."""
        if target[3:] != self.control.words[3:]:
            raise BlockError("an arc cannot turn the rotary axes here: let the CAM system write lines")
        turn, _ = self._turn_and_way(target[3:])
        a, b, c = (tuple(row) for row in turn.tolist())
        turned = ((*a, 0.0), (*b, 0.0), (*c, 0.0))
        centre, u, w, rise = (affine.direct(turned, vector) for vector in (arc.centre, arc.u, arc.w, arc.rise))
        return Arc(centre, u, w, arc.r0, arc.r1, arc.sweep, rise)

    def _stated(self) -> list[float]:
        """X, Y, Z as they were stated, where they are not those of the control."""
        words = self.control.words
        turn, way = self._turn_and_way(words[3:])
        found: list[float] = np.linalg.solve(turn, np.array(words[:3]) - self.state.along * way).tolist()
        return found

    def _moved(self, target: list[float]) -> list[float]:
        """Coordinates (3,) of the control, of words that stand while the table turns, or go along the tool."""
        turn, way = self._turn_and_way(target[3:])
        found: list[float] = (turn @ np.array(target[:3]) + self.state.along * way).tolist()
        return found

    def _say_along(self) -> None:
        self.control.findings.assumed(f"{self.along} moves along the tool axis, away from the part where positive")

    def _from_polar(self, numbers: dict[str, float], present: list[float]) -> None:
        """Replace radius and angle by the coordinates of the plane; G91 adds to the angle, about the same pole.

        "Specifying angles with incremental commands and a polar radius with absolute commands" (B-63944EN, "Polar
        coordinate command (G15, G16)"): G81 X100 Y30, then G91 Y120 and Y120.
        """
        state = self.state
        first, second = ("XY", "ZX", "YZ")[state.plane]
        if first not in numbers and second not in numbers:
            return
        if not state.absolute and first in numbers:
            raise BlockError("a polar radius under G91 is not read: write it under G90")
        before = {} if state.absolute else state.pole
        state.pole |= {x: numbers[x] + before.get(x, 0.0) for x in (first, second) if x in numbers}
        if first not in state.pole or second not in state.pole:
            raise RefusedError(
                "G16 without a radius or an angle", f"what is left out is not sure: write {first} and {second}"
            )
        radius, angle = state.pole.get(first, 0.0), state.pole.get(second, 0.0) * DEGREE
        for letter, value in ((first, radius * math.cos(angle)), (second, radius * math.sin(angle))):
            slot = self.control.slots[letter]
            numbers[letter] = value if state.absolute else value - present[slot] / state.unit

    def _has_vector(self, numbers: dict[str, float]) -> bool:
        return self.state.vectors and any(letter in numbers for letter in "IJK")

    def _rotary_of(self, vector: dict[str, float]) -> list[float]:
        """Rotary words of a tool axis, which is in the program's coordinates as the tip is (A-79348E, G43.5)."""
        size = math.hypot(*vector.values())
        if size < 1e-6:
            raise BlockError("the tool axis I, J, K is zero: give the direction from the tip to the spindle")
        return rotary_for(self.control, direction_on_part(self.control, list(vector.values())))

    def _refuse_word(self, letter: str) -> None:
        if letter in TOOL_VECTOR:
            raise RefusedError(
                f"{letter}= of G141",
                "in which coordinates the tool's direction stands while the table turns is not known here: write the "
                "positions of the rotary axes (A, B, C)",
            )
        if letter in _USES:
            raise BlockError(f"{letter} has no use in this block, it belongs to {_USES[letter]}: remove it")
        if letter in "ABC" or (letter in "UVW" and self.control.poses.machine is not None):
            self.control.slot(letter)
        if letter == "E":
            raise BlockError(NO_EXPONENT)
        raise BlockError(f"word {letter} is not known here and might move something: remove it")


def turned_alone(control: Control, state: Modal, target: list[float], *, rapid: bool) -> bool:
    """Turn the rotary axes alone to words (3 + rotary), where a plane rules; False where nothing is to be turned.

    Raises RefusedError where X, Y or Z move too.
    """
    if not turns(control, target):
        return False
    if target[:3] != control.words[:3]:
        refuse()
    turn_joints(control, target[3:], rapid=rapid)
    state.turned_in_plane = True
    return True


def turns(control: Control, target: list[float]) -> bool:
    """Whether words (3 + rotary) turn axes in a plane; where they repeat a position they become it."""
    if not _rules(control) or target[3:] == control.words[3:]:
        return False
    return not repeats_rotary(control, target, REPEATED)


def refuse() -> None:
    """Raises RefusedError."""
    raise RefusedError("rotary words beside a motion in a tilted plane", "turn the axes in a block before")


def need_on_plane(control: Control, state: Modal, target: list[float]) -> None:
    """RefusedError where X, Y, Z would move in a plane that the program has turned the tool off."""
    if not state.turned_in_plane or not _rules(control) or target[:3] == control.words[:3]:
        return
    axis = control.poses.axis(control.placement.place(control.words)[3:])
    if math.dist(axis, plane_axis(control)) > ROUNDED:
        raise RefusedError(
            "X, Y, Z in a tilted plane that the tool was turned off",
            "where the plane is then is not sure: end it before the turn (G69, G255 or G269), and tell it again",
        )


def _rules(control: Control) -> bool:
    """Whether a plane rules, and nothing follows a turn."""
    coordinates = control.coordinates
    return coordinates.tilted and not coordinates.tip_mode and control.poses.machine is not None

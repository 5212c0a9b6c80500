"""Tool vectors of blocks (A3, A2), frames along the tool (TOROT), and planes that the tool is turned to."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.common.units import DEGREE
from toolpace.programs.reading.arcs import ROUNDING
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.machine_moves import (
    THERE,
    direction_on_part,
    repeats_rotary,
    rotary_for,
    turn_joints,
)
from toolpace.programs.reading.control.unroll import AXIS_GAP
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix, cross
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.state import EULER, GREAT_CIRCLE, RPY, VIRTUAL, State
from toolpace.programs.reading.sinumerik.syntax.values import Unread
from toolpace.programs.reading.sinumerik.word_values import Words, number

VECTOR, ANGLES = ("A3", "B3", "C3"), ("A2", "B2", "C2")
OF_VECTOR, DIRECTION_WORDS = frozenset(VECTOR), frozenset((*VECTOR, *ANGLES))
OF_TWO_GROUPS = (
    "ORIWKS or ORIMKS asks for another way between tool vectors than ORIVECT or ORIAXES: the last counts (MD21104)"
)
MOST_HALVINGS = 10
"""Of the way between two tool vectors."""
BOTH, X_IN_ZX, Y_IN_YZ = "2000", "2001", "2002"
"""Values of $SC_TOFRAME_MODE (SD42980): the new X axis is as far from the old ZX plane as the new Y axis from the old
YZ plane; the new X axis lies in the old ZX plane; the new Y axis lies in the old YZ plane."""
REPEATED = "rotary words in a plane of CYCLE800 that repeat its positions with three decimals are taken for them"


class Vectors:
    """Reads tool vectors and moves to them."""

    def __init__(self, control: Control, state: State) -> None:
        self.control, self.state = control, state
        self._reached: tuple[list[float], list[float]] = [], []
        """Rotary joints at the end of the last tool vector, and that vector."""

    @staticmethod
    def names_a_direction(words: Words) -> bool:
        """Whether words have a tool vector."""
        return not DIRECTION_WORDS.isdisjoint(words)

    def taken(self, words: Words) -> list[float] | None:
        """The tool axis (3,) on the part that the words ask for; None where they ask for none."""
        if len(words) == 0 or not self.names_a_direction(words):
            return None
        if not self.control.coordinates.tip_mode:
            raise BlockError("tool vectors (A3=, A2=) need TRAORI: switch it on before them")
        if not OF_VECTOR.isdisjoint(words):
            vector = [number(words, address) or 0.0 for address in VECTOR]
        else:
            a, b, c = ((number(words, address) or 0.0) * DEGREE for address in ANGLES)
            vector = self._by_angles(a, b, c)
        if math.hypot(*vector) < 1e-6:
            raise BlockError("the tool vector is zero: give the direction from the tip to the spindle")
        return direction_on_part(self.control, vector)

    def _by_angles(self, a: float, b: float, c: float) -> list[float]:
        """The tool axis (3,) by A2, B2, C2 [rad], of a vector that was along Z.

        Job Planning tells ORIRPY as C2 about Z, B2 about the new Y, A2 about the newest X; NC Programming 12/2019 calls
        it "rotation sequence XYZ", and ORIRPY2 "ZYX". Both are the same where but one angle tilts the tool. Raises
        Unread.
        """
        upright = (0.0, 0.0, 1.0)
        if self.state.angles == VIRTUAL:
            raise Unread("A2, B2 or C2 under ORIVIRT1 or ORIVIRT2", "their axes are data of the machine: write A3=")
        if self.state.angles == EULER:
            return list(affine.direct(affine.turns((2, a), (0, b), (2, c)), upright))
        found = affine.direct(affine.turns((2, c), (1, b), (0, a)), upright)
        if math.dist(found, affine.direct(affine.turns((0, a), (1, b), (2, c)), upright)) > ROUNDING:
            if self.state.angles != RPY:
                raise Unread("ORIRPY2 with several angles", "their order is not told: write A3=, B3=, C3=")
            self.control.findings.assumed(
                "ORIRPY turns by C2 about Z, by B2 about the new Y, by A2 about the newest X (newer manuals say XYZ)"
            )
        return list(found)

    def rotary(self, vector: list[float]) -> list[float]:
        """Rotary words for a tool axis on the part."""
        return rotary_for(self.control, vector)

    def straight(
        self, target: list[float], named: int, vector: list[float], *, rapid: bool, number: float | None
    ) -> None:
        """Move straight, while the tool turns in the plane of both vectors, or the rotary axes in proportion."""
        control = self.control
        start = list(control.words)
        if self.state.of_frames and self.state.of_axes and self.state.of_frames != self.state.of_axes:
            control.findings.assumed(OF_TWO_GROUPS)
        if rapid or self.state.turning != GREAT_CIRCLE or control.poses.machine is None:
            control.straight([*target[:3], *self.rotary(vector)], named, rapid=rapid, number=number)
            return
        shift = control.placement.shift or (0.0,) * len(start[3:])
        joints = [a + b for a, b in zip(start[3:], shift)]
        first = self._reached[1] if self._reached[0] == joints else control.poses.axis(joints)
        pieces = self._pieces(first, vector, start[3:])
        for k, (share, rotary) in enumerate(pieces):
            place = [a + share * (b - a) for a, b in zip(start[:3], target[:3])]
            before = pieces[k - 1][0] if k else 0.0
            part = None if number is None else number / (share - before)
            control.straight([*(target[:3] if share == 1.0 else place), *rotary], named, rapid=rapid, number=part)
        self._reached = [a + b for a, b in zip(control.words[3:], shift)], vector

    def _pieces(self, first: list[float], last: list[float], rotary: list[float]) -> list[tuple[float, list[float]]]:
        """Shares of the way with their rotary words, so close that the axes in proportion stay on the great circle.

        Begins with the whole way and halves what strays; a stack in place of recursion keeps the order.
        """
        control = self.control
        shift = control.placement.shift or (0.0,) * len(rotary)
        if sum(x * y for x, y in zip(first, last)) < -1.0 + ROUNDING:
            raise BlockError("the tool vector is opposite to the one before: no plane holds its way; write one between")
        done: list[tuple[float, list[float]]] = []
        begin, here = 0.0, list(rotary)
        ends = [(1.0, 0)]
        while ends:
            share, halved = ends[-1]
            axis = last if share == 1.0 else between(first, last, share)
            wanted, fault = control.orientation.rotary(axis, [x + y for x, y in zip(here, shift)])
            if fault:
                raise BlockError(fault)
            words = [x - y for x, y in zip(wanted, shift)]
            turned = sum(abs(y - x) for x, y in zip(here, words))
            # each way leaves its chord by at most the square of the turn over eight: below this both are one
            apart = halved < MOST_HALVINGS and turned * turned > 4.0 * AXIS_GAP
            if apart and self._strays(first, last, (begin + share) / 2, here, words):
                ends.append(((begin + share) / 2, halved + 1))
                ends[-2] = (share, halved + 1)
                continue
            done.append((share, words))
            begin, here = share, words
            ends.pop()
        return done

    def _strays(
        self, first: list[float], last: list[float], share: float, here: list[float], words: list[float]
    ) -> bool:
        """Whether rotary words halfway between two are off the great circle at its share."""
        shift = self.control.placement.shift or (0.0,) * len(words)
        middle = self.control.poses.axis([(x + y) / 2 + z for x, y, z in zip(here, words, shift)])
        return math.dist(middle, between(first, last, share)) > AXIS_GAP


def between(a: list[float], b: list[float], share: float) -> list[float]:
    """The unit vector at a share of the great circle from a to b (Shoemake 1985, slerp)."""
    angle = 2.0 * math.asin(min(math.dist(a, b) / 2.0, 1.0))
    if angle < ROUNDING:
        return [x + share * (y - x) for x, y in zip(a, b)]
    sine = math.sin(angle)
    first, second = math.sin((1.0 - share) * angle) / sine, math.sin(share * angle) / sine
    return [first * x + second * y for x, y in zip(a, b)]


def along(direction: Sequence[float], rule: str = BOTH) -> Matrix:
    """The turn of coordinates that brings their Z axis to a unit vector (3,), with X and Y as a rule has them.

    Raises BlockError where the rule tells no X or Y.
    """
    x, y, z = direction
    if rule == BOTH:
        # X and Y are equally far from the old planes when the turn is the least one: its axis lies in the old XY plane
        if 1.0 + z < ROUNDING:
            raise BlockError("the tool points against Z: no frame along it is told; turn the frame with ROT before")
        rows = [
            [1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), x],
            [-x * y / (1.0 + z), 1.0 - y * y / (1.0 + z), y],
            [-x, -y, z],
        ]
        return affine.linear(rows)
    size = math.hypot(x, z) if rule == X_IN_ZX else math.hypot(y, z)
    if size < ROUNDING:
        raise BlockError("the tool lies along an axis of the old frame: X and Y of a frame along it are not told")
    if rule == X_IN_ZX:
        first = [z / size, 0.0, -x / size]
        second = cross(direction, first)
    else:
        second = [0.0, z / size, -y / size]
        first = cross(second, direction)
    return affine.linear([[first[k], second[k], direction[k]] for k in range(3)])


def turn_along_tool(control: Control, frames: Frames, state: State, rule: str, *, bound: bool = False) -> None:
    """TOROT: turn the frame in force about its origin until Z lies along the tool (Function Manual K2, TOROT).

    Without a transformation or a tilted plane the tool stands along Z already ("if no toolholder is active, the Z
    direction is the old one"). Raises Unread.
    """
    if state.plane:
        raise Unread("TOROT under G18 or G19", "the direction of the tool is another there: write G17")
    placement = control.placement
    if not placement.tip_mode:
        return
    columns = [[row[k] for row in placement.matrix] for k in range(3)]
    if math.dist(cross(columns[0], columns[1]), columns[2]) > ROUNDING or abs(math.hypot(*columns[0]) - 1.0) > ROUNDING:
        raise Unread("TOROT in a scaled or mirrored frame", "end the scale or the mirror before")
    axis = control.poses.axis(placement.place(control.words)[3:])
    direction = [sum(a * b for a, b in zip(column, axis)) for column in columns]
    if math.dist(direction, (0.0, 0.0, 1.0)) < ROUNDING:
        frames.turn_before_programmed(IDENTITY)
        return
    if min(abs(direction[0]), abs(direction[1])) > ROUNDING:
        control.findings.assumed(f"TOROT: X and Y of the frame are as $SC_TOFRAME_MODE = {rule} has them (SD42980)")
    frames.turn_before_programmed(along(direction, rule), bound=bound)


def need_turned(control: Control, frames: Frames) -> None:
    """Unread where X, Y and Z would move in a plane while the rotary axes are not where it is reckoned for.

    The control keeps those positions in its frames, whatever the axes do (K2, "TCARR"), unless TRAORI is on. With
    _DIR 0 it turns no axis: the program does, and the first positions that bring the tool square to the plane count.
    """
    if not frames.tilted or control.coordinates.tip_mode or control.poses.machine is None:
        return
    present = control.placement.place(control.words)[3:]
    if frames.turned_to is None:
        if math.dist(control.poses.axis(present), frames.plane_axis) > THERE:
            raise Unread(
                "X, Y, Z in a plane of CYCLE800 that the tool is not turned to (_DIR 0)",
                "turn the rotary axes before, or write _DIR 1 or -1",
            )
        frames.turned_to = present
    if any(abs(math.remainder(a - b, 2.0 * math.pi)) > THERE for a, b in zip(present, frames.turned_to)):
        raise Unread(
            "X, Y, Z in a plane of CYCLE800 whose rotary axes have moved since",
            "the control's plane stays where it was: write CYCLE800 again, or TRAORI",
        )


def turned_alone(control: Control, frames: Frames, state: State, target: list[float], named: int) -> bool:
    """Turn the rotary axes alone to words (3 + rotary), in a plane without TRAORI, where nothing follows them.

    named: bits of X, Y, Z in the block. False where the block turns none; Unread where it moves others too.
    """
    if not frames.tilted or control.coordinates.tip_mode:
        return False
    if repeats_rotary(control, target, REPEATED):
        need_turned(control, frames)
        return False
    if named or state.motion not in ("G0", "G1"):
        raise Unread("rotary words beside X, Y, Z in a plane of CYCLE800", "turn the axes in a block before")
    turn_joints(control, target[3:], rapid=state.motion == "G0")
    return True

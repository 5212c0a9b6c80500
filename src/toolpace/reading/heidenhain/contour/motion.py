"""Straight blocks: L, LN, and what turns with them. Compiled once, executed often."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

from toolpace.reading.control.control import Control
from toolpace.reading.control.feed import PER_MINUTE, PER_REVOLUTION
from toolpace.reading.control.joint_moves import turn_joints
from toolpace.reading.control.tool_axis import direction_on_part, rotary_for
from toolpace.reading.coordinates import affine
from toolpace.reading.coordinates.orientation import near
from toolpace.reading.heidenhain.contour.compensation import Compensation
from toolpace.reading.heidenhain.frames import Frames, spatial
from toolpace.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.reading.heidenhain.klartext.parameters import LARGEST, BlockError
from toolpace.reading.heidenhain.klartext.words import PathWords
from toolpace.reading.heidenhain.state import State
from toolpace.units import DEGREE, MINUTE

Step = Callable[[], None]
Axis = tuple[int, bool, Value, float]
"""Column of the words, whether incremental, value, and its unit [m or rad]."""
TURNING = {
    "vector": "F of a block that turns without M128 is millimetres and degrees as one length a minute",
    "xyz": "F of a block that turns without M128 is the way of X, Y, Z a minute",
}
"""What is said of `feed_when_turning`."""
OTHER_FEEDS = {
    "FZ": "write F or FU, a length a turn, in place of a length a tooth",
    "FT": "write F in place of the time of a block",
    "FMAXT": "write FMAX in place of the time of a rapid",
}


class CornerLayer(Protocol):
    """What a motion asks of `corners`."""

    def lay(self, target: list[float]) -> None:
        """Lay the corner before the straight way to the target begins."""

    def refuse(self) -> None:
        """Note that the corner at hand is not read."""


class ApproachLayer(Protocol):
    """What a motion asks of `approaches`."""

    @property
    def waiting(self) -> object:
        """The approach whose contour is to come, if any."""

    def lay(self, way: list[float]) -> None:
        """A contour begins in this direction, where the approach that waits ends."""

    def refuse(self) -> None:
        """No contour came."""


class Motion:
    """Straight motion and feed."""

    def __init__(self, control: Control, state: State, frames: Frames, follow_contour: bool) -> None:
        self.control, self.state, self.frames = control, state, frames
        self.compensation = Compensation(control, state, follow_contour, self.approach_waits)
        self.corners: CornerLayer | None = None
        """What lays a corner before the line behind it."""
        self.approaches: ApproachLayer | None = None
        """What lays an approach before the contour behind it."""

    # Words

    def resolved(self, words: PathWords) -> list[Axis]:
        """Axis words with their columns and units; of one letter that stands twice, an error."""
        found: list[Axis] = []
        for letter, incremental, value in words.axes:
            slot = self.control.slot(letter)
            if any(axis[0] == slot for axis in found):
                raise BlockError(f"{letter} stands twice in one block: remove one")
            found.append((slot, incremental, value, self.state.unit if slot < 3 else DEGREE))
        return found

    def target(self, axes: list[Axis]) -> tuple[list[float], int]:
        """Words (3 + rotary) at the end of a block, and the bits of X, Y, Z that it names."""
        words, named = list(self.control.words), 0
        for slot, incremental, value, unit in axes:
            figure = value if isinstance(value, float) else value()
            if not -LARGEST <= figure <= LARGEST:
                raise BlockError(f"a coordinate of {figure:.6g} is beyond any machine: check its figures")
            figure *= unit
            words[slot] = words[slot] + figure if incremental else figure
            if slot < 3:
                named |= 1 << slot
            elif self.state.shortest and not incremental:
                words[slot] = self.shorter(slot, words[slot])
        return words, named

    def shorter(self, slot: int, angle: float) -> float:
        """The rotary word plus the whole turns that make the shortest way within travel [rad]."""
        control = self.control
        machine, shift = control.poses.machine, control.placement.shift
        assert machine is not None
        low, high = machine.travel[control.poses.rotary[slot - 3]]
        added = shift[slot - 3] if shift else 0.0
        found = near(angle + added, control.words[slot] + added, float(low), float(high))
        return angle if found is None else found - added

    # Feed

    def set_feed(self, words: PathWords) -> bool:
        """Take the F of a block; returns whether it is a rapid."""
        word = words.feed_word
        if not word or word == "FMAX":
            return word == "FMAX"
        if word in OTHER_FEEDS:
            self.control.findings.refused(word, self.control.line, OTHER_FEEDS[word])
            return False
        if word == "FAUTO":
            if self.state.tool_feed is None:
                raise BlockError("FAUTO takes the F of TOOL CALL, which has none: write one there, or F here")
            self.feed(self.state.tool_feed)
        elif words.feed is not None:
            self.feed(evaluate(words.feed), per_revolution=word == "FU" or self.state.per_revolution)
        return False

    def feed(self, number: float, per_revolution: bool = False) -> None:
        """Put F in force."""
        self.control.feed.set_mode(PER_REVOLUTION if per_revolution else PER_MINUTE)
        self.control.feed.set(number, self.state.feed_unit, self.control.line)

    def speed_of(self, number: float) -> tuple[float, float]:
        """F as a speed [m/s] and a rotation in place [rad/s]. Raises BlockError."""
        if not 0.0 < number <= 1e9:
            raise BlockError(f"feed F{number:g} must be above zero (and at most 1e9): correct F")
        return number * self.state.feed_unit / MINUTE, number * DEGREE / MINUTE

    # Blocks

    def line(self, words: PathWords) -> Step:
        """L with its axis words, feed and compensation."""
        slots = self.control.slots
        absent = [letter for letter, _, _ in words.axes if letter in "ABC" and letter not in slots]
        present = replace(words, axes=[axis for axis in words.axes if axis[0] not in absent])
        axes, side, plain = self.resolved(present), words.side, words.feed_word in ("", "FMAX")
        angles = [axis for axis in words.axes if axis[0] in "ABC"]
        self.only(words, "L", ())
        rapid = words.feed_word == "FMAX"
        turns = bool(absent) or any(axis[0] > 2 for axis in axes)

        def run() -> None:
            if side:
                self.compensation.take(side)
            fast = rapid if plain else self.set_feed(words)
            if not axes and not absent:
                return
            if self.state.spatial and self.state.tip_mode and angles:
                target, named = self.target([axis for axis in axes if axis[0] < 3])
                self.straight([*target[:3], *self.rotary_of_angles(angles)], named, fast)
                return
            if absent:
                self.control.slot(absent[0])
            target, named = self.target(axes)
            if turns and self.frames.plane is not None:
                self.turning(target, named, fast)
            elif turns and named and not fast and not self.state.tip_mode:
                self.control.findings.assumed(TURNING[self.control.rules.feed.turning])
                self.straight(target, named, fast)
            else:
                self.straight(target, named, fast)

        return run

    def rotary_of_angles(self, angles: Sequence[tuple[str, bool, Value]]) -> list[float]:
        """Rotary words of spatial angles; one that the block leaves out is that of the last. Raises BlockError."""
        told = list(self.state.spatial_angles)
        for letter, incremental, value in angles:
            figure = (value if isinstance(value, float) else value()) * DEGREE
            before = told["ABC".index(letter)] if incremental else 0.0
            told["ABC".index(letter)] = None if before is None else before + figure
        self.state.spatial_angles = told
        a, b, c = told
        if a is None or b is None or c is None:
            missing = ", ".join(letter for letter, angle in zip("ABC", told) if angle is None)
            raise BlockError(
                f"under AXIS SPAT the block tells no {missing}, and the tool did not stand upright where TCPM was "
                "switched on: write A, B and C in the first block that turns"
            )
        axis = direction_on_part(self.control, affine.direct(spatial(a, b, c), (0.0, 0.0, 1.0)))
        return rotary_for(self.control, axis)

    def straight(self, target: list[float], named: int, rapid: bool) -> None:
        """Move straight, and remember from where."""
        control, state = self.control, self.state
        self.contour_begins([target[k] - control.words[k] for k in range(3)])
        if state.corner is not None:
            if rapid or self.corners is None:
                self.refuse_corner()
            else:
                self.corners.lay(target)
        before = control.words
        control.straight(target, named, rapid=rapid)
        state.came_from, state.came_by = before, None

    def approach_waits(self) -> bool:
        """Whether an approach waits for its contour."""
        return self.approaches is not None and self.approaches.waiting is not None

    def contour_begins(self, way: list[float]) -> None:
        """A motion in this direction (3,) comes next."""
        if self.approaches is not None and self.approach_waits():
            self.approaches.lay(way)

    def refuse_corner(self) -> None:
        """A corner that waits for a straight line, before a motion that is none."""
        if self.state.corner is not None and self.corners is not None:
            self.corners.refuse()

    def turning(self, target: list[float], named: int, rapid: bool) -> None:
        """A block that turns, in a tilted plane."""
        control, state = self.control, self.state
        if state.tip_mode or named:
            self.straight(target, named, rapid)
        else:
            # without M128 the linear axes stand still while rotary axes turn, also in a tilted plane
            turn_joints(control, target[3:], rapid=rapid)
            state.came_from = []

    def normal_line(self, words: PathWords) -> Step:
        """LN: the tip goes straight, the tool to the direction TX TY TZ; NX NY NZ is the way out of the part."""
        axes = self.resolved(words)
        self.only(words, "LN", ("NX", "NY", "NZ", "TX", "TY", "TZ"))
        given = [words.others.get(name) for name in ("TX", "TY", "TZ")]
        normals = [words.others.get(name) for name in ("NX", "NY", "NZ")]

        def run() -> None:
            control, line = self.control, self.control.line
            self.compensation.take(words.side)
            if control.stage is not None and control.stage.compensates:
                raise BlockError("LN under RL or RR, compensation in space, is not read: let the CAM system compensate")
            rapid = self.set_feed(words)
            target, named = self.target(axes)
            tool = [0.0 if value is None else evaluate(value) for value in given]
            if any(value is not None for value in given):
                if not self.state.tip_mode:
                    control.findings.refused("TX TY TZ without M128", line, "write M128 or FUNCTION TCPM before")
                    return
                length = math.hypot(*tool)
                if not 1e-6 < length < 1e6:
                    raise BlockError("TX TY TZ is no direction: give the one from the tip to the spindle")
                target[3:] = rotary_for(control, direction_on_part(control, [value / length for value in tool]))
            elif any(value is not None for value in normals) and self.state.tip_mode:
                control.findings.refused("NX NY NZ without TX TY TZ", line, "write the tool's direction TX TY TZ too")
                return
            rows = len(control.moves)
            self.straight(target, named, rapid)
            out = [0.0 if value is None else evaluate(value) for value in normals]
            if len(control.moves) > rows and 1e-6 < math.hypot(*out) < 1e6:
                x, y, z = direction_on_part(control, [value / math.hypot(*out) for value in out])
                control.moves.normals[len(control.moves) - 1] = x, y, z

        return run

    def only(self, words: PathWords, name: str, allowed: tuple[str, ...]) -> None:
        """Refuse a block with words that its kind does not have."""
        for other, value in words.others.items():
            if other == "S" and isinstance(value, float):
                continue
            if other not in allowed:
                raise BlockError(f"{other} is no word of {name}: check its spelling, or remove it")

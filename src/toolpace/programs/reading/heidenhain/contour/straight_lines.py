"""Straight blocks L, their feed, and the compensation of the tool's radius: R0, RL, RR."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

from toolpace.common.units import DEGREE, MINUTE
from toolpace.programs.reading.arcs import PLANE_ACROSS
from toolpace.programs.reading.compensation.stage import ACROSS, ARC, Rules
from toolpace.programs.reading.compensation.tool_centre_path import Follower, follow, leave
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import ROUND, Corners
from toolpace.programs.reading.control.feed import PER_MINUTE, PER_REVOLUTION, PER_TOOTH
from toolpace.programs.reading.control.machine_moves import direction_on_part, rotary_for, turn_joints
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.kinematics import near
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.frames import Frames, spatial
from toolpace.programs.reading.heidenhain.parameters import LARGEST, Value, evaluate
from toolpace.programs.reading.heidenhain.state import OF_AXIS, State
from toolpace.programs.reading.heidenhain.words import PathWords

LENGTHENED = {"R+": 1.0, "R-": -1.0}
"""What makes the way of one axis longer or shorter by the tool's radius."""
UNKNOWN = (
    "the tool's radius is not known: write it on the set-up sheet ([tools.N] radius), give --compensation program "
    "where the contour is the tool's centre, or write R0"
)
RULES = Rules(ARC, ACROSS, most_idle=2, gouge="the control stops with an error")
"""TNC 640, Klartext, "Tool radius compensation": an arc at outside corners, the ways' intersection at inside ones, and
across the contour at its ends; how many blocks across the plane it looks over is not said."""
Step = Callable[[], None]
Axis = tuple[int, bool, Value, float]
"""Column of the words, whether incremental, value, and its unit [m or rad]."""
UPRIGHT = 3e-5
"""By how much a unit vector may miss the normal of its plane: posts write angles with three decimals [rad]."""
TURNING = {
    "vector": "F of a block that turns without M128 is millimetres and degrees as one length a minute",
    "xyz": "F of a block that turns without M128 is the way of X, Y, Z a minute",
}
"""What is said of `feed_when_turning`."""
NOT_TURNED = (
    "a block moves X, Y or Z in a tilted plane that the rotary axes are not turned to, without M128: its words are the "
    "tip in the plane all the same"
)
OF_CORNERS = "write it as L and CR blocks: it is read between two straight lines in the plane of the tool axis"
OTHER_FEEDS = {
    "FT": "write F in place of the time of a block",
    "FMAXT": "write FMAX in place of the time of a rapid",
}


class Compensation:
    """Begins and ends compensation as the words of blocks say."""

    def __init__(self, control: Control, state: State, as_programmed: bool, approach_waits: Callable[[], bool]) -> None:
        """as_programmed: whether the contour is the way. approach_waits: whether APPR waits for its contour."""
        self.control, self.state = control, state
        self.as_programmed, self.approach_waits = as_programmed, approach_waits

    @property
    def follower(self) -> Follower | None:
        """What goes beside the contour now."""
        stage = self.control.stage
        return stage if isinstance(stage, Follower) else None

    def take(self, side: str) -> None:
        """R0, RL, RR, or none. Raises BlockError."""
        follower = self.follower
        if side in LENGTHENED:
            raise BlockError(f"{side} belongs to a block of one axis, like X+50 {side}: write RL or RR here")
        before, self.state.side = self.state.side, side or self.state.side
        if side in ("", "R0"):
            if side and follower is not None:
                leave(follower)
                self.state.looks_ahead = 0
        elif follower is not None:
            if before != side:
                raise BlockError(f"{side} changes the side of the tool while it compensates: write R0 before it")
        elif not self.approach_waits() and (radius := self.radius()):
            self.begin(radius)

    def radius(self) -> float:
        """How far beside the contour the centre goes [m]. Raises BlockError."""
        return 0.0 if self.state.side == "R0" else self.of_tool(self.state.side)

    def of_tool(self, side: str) -> float:
        """Radius of the tool in the spindle, with DR, for a word that compensates it [m]. Raises BlockError."""
        control = self.control
        if self.as_programmed:
            control.findings.assumed(f"{side}: the programmed contour is the way of the tool's centre")
            return 0.0
        tool = control.setup.tool(control.tool)
        if tool is None or tool.radius is None:
            control.refuse(side, UNKNOWN)
            return 0.0
        found = tool.radius + self.state.radius_oversize
        if found < 0.0:
            raise BlockError(f"the radius of the tool and DR come to {found * 1e3:.6g} mm: correct them")
        return found

    def begin(self, radius: float) -> None:
        """Go beside the contour from here on."""
        side = 1 if self.state.side == "RL" else -1
        rules = replace(RULES, looks_ahead=self.state.looks_ahead)
        follow(self.control, side, radius, PLANE_ACROSS[self.state.tool_axis], rules)

    def look_ahead(self, elements: Value | None) -> None:
        """M120 with LA: loops of the way are left out; without it, or with 0, they are not."""
        self.control.findings.ignored("M120")
        self.state.looks_ahead = 0 if elements is None else int(evaluate(elements))
        if self.follower is not None:
            self.follower.rules = replace(self.follower.rules, looks_ahead=self.state.looks_ahead)


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
        self.corners = Corners(control, OF_CORNERS, refuses_empty=True)
        self.approaches: ApproachLayer | None = None
        """What lays an approach before the contour behind it."""
        self.seen_upright: tuple[float, ...] | None = None
        """Rotary words at which the tool was last held against the plane in force."""

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

    def target(self, axes: list[Axis], *, of_program: bool = True) -> tuple[list[float], int]:
        """Words (3 + rotary) at the end of a block, and the bits of X, Y, Z that it names.

        of_program: in the program's coordinates, where a mirror of rotary axes counts, not in the machine's.
        """
        words, named = list(self.control.words), 0
        mirrored = self.frames.mirrored if of_program else ()
        for slot, incremental, value, unit in axes:
            if slot in self.state.beside:
                if incremental:
                    raise BlockError("an incremental way behind R+ or R- has no sure beginning: write an absolute one")
                self.state.beside.discard(slot)
            figure = value if isinstance(value, float) else value()
            if not -LARGEST <= figure <= LARGEST:
                raise BlockError(f"a coordinate of {figure:.6g} is beyond any machine: check its figures")
            figure *= -unit if slot in mirrored else unit
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
            self.control.refuse(word, OTHER_FEEDS[word])
            return False
        if word == "FAUTO":
            self.feed(self.automatic())
        elif words.feed is not None:
            usual = PER_REVOLUTION if self.state.per_revolution else PER_MINUTE
            self.feed(evaluate(words.feed), {"FU": PER_REVOLUTION, "FZ": PER_TOOTH}.get(word, usual))
        return False

    def automatic(self) -> float:
        """The F of TOOL CALL, which FAUTO takes. Raises BlockError."""
        if self.state.tool_feed is None:
            raise BlockError("FAUTO takes the F of TOOL CALL, which has none: write one there, or F here")
        return self.state.tool_feed

    def feed(self, number: float, mode: str = PER_MINUTE) -> None:
        """Put F in force."""
        self.control.feed.set_mode(mode)
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
        spatial_angles = list(self.state.spatial_angles)
        for letter, incremental, value in angles:
            figure = (value if isinstance(value, float) else value()) * DEGREE
            before = spatial_angles["ABC".index(letter)] if incremental else 0.0
            spatial_angles["ABC".index(letter)] = None if before is None else before + figure
        self.state.spatial_angles = spatial_angles
        a, b, c = spatial_angles
        if a is None or b is None or c is None:
            missing = ", ".join(letter for letter, angle in zip("ABC", spatial_angles) if angle is None)
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
        if rapid:
            self.corners.refuse()
        elif self.corners.waiting is not None:
            if self.corners.waiting.kind == ROUND:
                self.need_even_scale(*OF_AXIS[state.tool_axis])
            self.corners.before(target, PLANE_ACROSS[state.tool_axis])
        if self.frames.plane is not None and not state.tip_mode:
            self.say_where_not_turned(target)
        before = control.words
        control.straight(target, named, rapid=rapid)
        state.came_from, state.came_by = before, None

    def approach_waits(self) -> bool:
        """Whether an approach waits for its contour."""
        return self.approaches is not None and self.approaches.waiting is not None

    def say_where_not_turned(self, target: list[float]) -> None:
        """Say what is assumed where the tool does not stand upright on the plane at the end of a block."""
        control, at = self.control, tuple(target[3:])
        if control.poses.machine is None or at == self.seen_upright:
            return
        axis = control.poses.axis(control.placement.place(target)[3:])
        if math.dist(axis, self.frames.normal()) > UPRIGHT:
            control.findings.assumed(NOT_TURNED)
        self.seen_upright = at

    def contour_begins(self, way: list[float]) -> None:
        """A motion in this direction (3,) comes next."""
        if self.approaches is not None and self.approach_waits():
            self.approaches.lay(way)

    def turning(self, target: list[float], named: int, rapid: bool) -> None:
        """A block that turns, in a tilted plane."""
        control, state = self.control, self.state
        if state.tip_mode or named:
            self.straight(target, named, rapid)
        else:
            # without M128 the linear axes stand still while rotary axes turn, also in a tilted plane
            turn_joints(control, target[3:], rapid=rapid)
            state.came_from = []

    def need_even_scale(self, first: int, second: int) -> None:
        """Raise BlockError where an arc lies in a plane that is scaled unevenly.

        "Coordinate axes sharing coordinates for arcs must be enlarged or reduced by the same factor" (TNC 620 Cycle
        Programming, "Axis-specific scaling (cycle 26)").
        """
        if self.frames.before.uneven(first, second) or self.frames.within.uneven(first, second):
            raise BlockError("an arc in axes that CYCL DEF 26 scales differently: give both the same factor")

    def only(self, words: PathWords, name: str, allowed: tuple[str, ...]) -> None:
        """Refuse a block with words that its kind does not have."""
        for other, value in words.others.items():
            if other == "S" and isinstance(value, float):
                continue
            if other not in allowed:
                raise BlockError(f"{other} is no word of {name}: check its spelling, or remove it")

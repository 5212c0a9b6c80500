"""Straight blocks beside L: LN with a surface normal, one axis with R+ or R-, and the corners RND and CHF."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from toolpace.programs.reading.compensation.tool_centre_path import is_scaled
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.corners import ROUND, SIDES
from toolpace.programs.reading.control.machine_moves import direction_on_part, rotary_for
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.contour.straight_lines import LENGTHENED, Motion, Step
from toolpace.programs.reading.heidenhain.parameters import Value, evaluate
from toolpace.programs.reading.heidenhain.state import State
from toolpace.programs.reading.heidenhain.words import PathWords


class SurfaceLines:
    """Compiles LN."""

    def __init__(self, control: Control, state: State, motion: Motion) -> None:
        self.control, self.state, self.motion = control, state, motion

    def line(self, words: PathWords) -> Step:
        """LN: the tip goes straight, the tool to the direction TX TY TZ; NX NY NZ is the way out of the part, and the
        direction of the tool where that is not told.

        "If no tool orientation is programmed in the LN block, the TNC maintains the tool perpendicular to the workpiece
        contour" under M128; "if you have not activated M128, the TNC ignores the direction vector T" (iTNC 530
        Conversational, "Face milling: 3-D compensation with and without tool orientation").
        """
        motion = self.motion
        axes = motion.resolved(words)
        motion.only(words, "LN", ("NX", "NY", "NZ", "TX", "TY", "TZ"))
        tools = [words.others.get(name) for name in ("TX", "TY", "TZ")]
        normals = [words.others.get(name) for name in ("NX", "NY", "NZ")]
        has_tool, has_normal = (any(value is not None for value in vector) for vector in (tools, normals))

        def run() -> None:
            control = self.control
            motion.compensation.take(words.side)
            if control.stage is not None and control.stage.compensates:
                raise BlockError("LN under RL or RR, compensation in space, is not read: let the CAM system compensate")
            rapid = motion.set_feed(words)
            if has_normal and self.state.oversize:
                control.refuse(
                    "NX NY NZ with an oversize of TOOL CALL",
                    "the control moves the tool along the normal by DL, DR and DR2: let the CAM system do that, and "
                    "call the tool without them",
                )
            if has_normal and self.state.path_is_contour:
                # "the control references the 3-D radius compensation to the entire tool radius R + DR and the corner
                # radius R2 + DR2" (TNC 640 Klartext, "Interpretation of the programmed path")
                control.refuse(
                    "NX NY NZ under FUNCTION PROG PATH IS CONTOUR",
                    "the control moves the tool along the normal by its radii: let the CAM system do that, and write "
                    "FUNCTION PROG PATH IS OFF",
                )
            target, named = motion.target(axes)
            normal, tool = direction_of("NX NY NZ", normals), direction_of("TX TY TZ", tools)
            upright = tool if has_tool else normal
            if upright and self.state.tip_mode:
                target[3:] = rotary_for(control, direction_on_part(control, upright))
                self.state.spatial_angles = [None] * 3
            elif has_tool:
                control.findings.assumed("TX TY TZ of LN without M128 turns no axis: the control ignores it")
            rows = len(control.moves)
            motion.straight(target, named, rapid)
            if len(control.moves) > rows and normal:
                x, y, z = direction_on_part(control, normal)
                control.moves.normals[len(control.moves) - 1] = x, y, z

        return run


def direction_of(name: str, components: Sequence[Value | None]) -> list[float]:
    """Unit vector (3,) of components, where any is given; else empty. Raises BlockError where it has no length."""
    if all(value is None for value in components):
        return []
    vector = [0.0 if value is None else evaluate(value) for value in components]
    length = math.hypot(*vector)
    if not 1e-6 < length < 1e6:
        raise BlockError(f"{name} is no direction: its length is {length:g}, write the components of a unit vector")
    return [value / length for value in vector]


class SingleAxis:
    """Compiles them."""

    def __init__(self, motion: Motion) -> None:
        self.motion, self.control, self.state = motion, motion.control, motion.state

    def line(self, words: PathWords) -> Step:
        """A block that begins with an axis. Raises BlockError.

        "The programmed tool path is shortened (R-) or lengthened (R+) by the tool radius", for movements of one axis
        in the working plane (TNC 407, Programming: "Shortening or lengthening single-axis movements").
        """
        side = words.side
        if side not in LENGTHENED:
            return self.motion.line(words)
        if len(words.axes) != 1 or words.axes[0][1]:
            raise BlockError(f"{side} is read in blocks of one axis with an absolute coordinate, like X+50 {side}")
        letter, _, value = words.axes[0]
        slot = self.control.slot(letter)

        def compensated() -> float:
            control, state = self.control, self.state
            if self.motion.compensation.follower is not None:
                raise BlockError(f"{side} stands under RL or RR: write R0 before it")
            if slot > 2 or slot == state.tool_axis:
                raise BlockError(f"{side} compensates in the working plane, and {letter} is none of its axes: write R0")
            if is_scaled(control):
                raise BlockError(f"{side} in scaled coordinates is not read: write the end of the way with R0")
            goal = evaluate(value) * state.unit
            way, radius = goal - control.words[slot], self.motion.compensation.of_tool(side)
            if side == "R-" and abs(way) <= radius:
                raise BlockError(f"the way of {letter} is not longer than the tool's radius: write its end with R0")
            state.beside.add(slot)
            return (goal + LENGTHENED[side] * math.copysign(radius, way)) / state.unit

        return self.motion.line(replace(words, axes=[(letter, False, compensated)], side=""))


def corner(motion: Motion, name: str, words: PathWords, size: Value | None) -> Step:
    """RND R5, CHF 5, with a feed of its own. Raises BlockError."""
    if size is None:
        raise BlockError(f"{name} needs its size: write {name} {'R5' if name == 'RND' else '5'}")
    if words.axes or words.feed_word not in ("", "F"):
        raise BlockError(f"{name} has a size and F only: remove the other words")

    def run() -> None:
        control, state, corners = motion.control, motion.state, motion.corners
        if corners.waiting is not None:
            raise BlockError(f"{name} behind {corners.waiting.name}: one of them stands between two lines, remove one")
        length = evaluate(size) * state.unit
        feed = None if words.feed is None else motion.speed_of(evaluate(words.feed))
        came_from = [] if state.came_by is not None else state.came_from
        corners.put(name, ROUND if name == "RND" else SIDES, length, came_from, feed)
        if not came_from or len(control.moves) < 2:
            corners.refuse()

    return run

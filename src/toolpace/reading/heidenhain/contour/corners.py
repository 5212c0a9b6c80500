"""RND and CHF: corners between two straight lines, rounded or cut."""

from __future__ import annotations

import math
from contextlib import nullcontext

from toolpace.reading.arcs import plane_arc
from toolpace.reading.heidenhain.contour.motion import Motion, Step
from toolpace.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.reading.heidenhain.klartext.parameters import BlockError
from toolpace.reading.heidenhain.klartext.words import PathWords
from toolpace.reading.heidenhain.state import ARC_PLANE, OF_AXIS, Corner

SAME = 1e-9
"""Coordinates closer than this [m, rad] are one."""
CURE = "write it as L and CR blocks: it is read between two straight lines in the plane of the tool axis"


class Corners:
    """Waits for the line behind a corner, and lays the corner."""

    def __init__(self, motion: Motion) -> None:
        self.motion, self.control, self.state = motion, motion.control, motion.state
        motion.corners = self

    def compile(self, name: str, words: PathWords, size: Value | None) -> Step:
        """RND R5, CHF 5, with a feed of its own. Raises BlockError."""
        if size is None:
            raise BlockError(f"{name} needs its size: write {name} {'R5' if name == 'RND' else '5'}")
        if words.axes or words.feed_word not in ("", "F"):
            raise BlockError(f"{name} has a size and F only: remove the other words")

        def run() -> None:
            control, state = self.control, self.state
            length = evaluate(size) * state.unit
            if not 0.0 <= length <= 100.0:
                raise BlockError(f"the size of {name} must be a length from 0 on: correct it")
            feed = None if words.feed is None else self.motion.speed_of(evaluate(words.feed))
            state.corner = Corner(name, length, feed, len(control.moves), control.line)
            if not state.came_from or state.came_by is not None or len(control.moves) < 2:
                self.refuse()

        return run

    def refuse(self) -> None:
        """Note that the corner at hand is not read."""
        corner, self.state.corner = self.state.corner, None
        if corner is not None:
            self.control.findings.refused(corner.name, corner.line, CURE)

    def lay(self, target: list[float]) -> None:
        """Lay the corner before the straight way to the target (3 + rotary) begins. Raises BlockError."""
        state, control, corner = self.state, self.control, self.state.corner
        assert corner is not None
        before, at = state.came_from, control.words
        first, second = OF_AXIS[state.tool_axis]
        if corner.moves != len(control.moves) or not before:
            self.refuse()  # something else has moved in between
            return
        others = [k for k in range(len(at)) if k not in (first, second)]
        if any(abs(at[k] - before[k]) > SAME or abs(at[k] - target[k]) > SAME for k in others):
            self.refuse()
            return
        state.corner = None
        along, ahead = ((b[first] - a[first], b[second] - a[second]) for a, b in ((before, at), (at, target)))
        lengths = math.hypot(*along), math.hypot(*ahead)
        turn = math.atan2(along[0] * ahead[1] - along[1] * ahead[0], along[0] * ahead[0] + along[1] * ahead[1])
        if min(lengths) < SAME or abs(turn) < 1e-9 or not corner.size:
            return
        cut = corner.size * (math.tan(abs(turn) / 2.0) if corner.name == "RND" else 1.0)
        if cut > min(lengths) + SAME:
            raise BlockError(
                f"the {corner.name} before this block takes {cut * 1e3:.6g} mm of both lines, and the shorter one has "
                f"{min(lengths) * 1e3:.6g} mm: make it smaller"
            )
        start, end = list(at), list(at)
        for k, axis in enumerate((first, second)):
            start[axis] -= along[k] * cut / lengths[0]
            end[axis] += ahead[k] * cut / lengths[1]
        control.shorten(start)
        with control.feed.held(*corner.feed) if corner.feed else nullcontext():
            if corner.name == "CHF":
                control.straight(end, 0, rapid=False)
            else:
                side = math.copysign(corner.size, turn)
                centre = list(start[:3])
                centre[first] -= along[1] * side / lengths[0]
                centre[second] += along[0] * side / lengths[0]
                control.arc(end, 0, plane_arc(start, end, centre, ARC_PLANE[state.tool_axis], turn < 0.0))

"""RND and CHF: rounded and chamfered corners."""

from __future__ import annotations

from toolpace.programs.reading.control.corners import ROUND, SIDES, Corner, CornerError, lay
from toolpace.programs.reading.heidenhain.contour.motion import Motion, Step
from toolpace.programs.reading.heidenhain.klartext.expressions import Value, evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError
from toolpace.programs.reading.heidenhain.klartext.words import PathWords
from toolpace.programs.reading.heidenhain.state import ARC_PLANE, OF_AXIS

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
            if state.corner is not None:
                raise BlockError(f"{name} behind {state.corner.name}: one of them stands between two lines, remove one")
            length = evaluate(size) * state.unit
            if not 0.0 <= length <= 100.0:
                raise BlockError(f"the size of {name} must be a length from 0 on: correct it")
            feed = None if words.feed is None else self.motion.speed_of(evaluate(words.feed))
            came_from = [] if state.came_by is not None else state.came_from
            kind = ROUND if name == "RND" else SIDES
            state.corner = Corner(name, kind, length, came_from, len(control.moves), control.line, feed)
            if not came_from or len(control.moves) < 2:
                self.refuse()

        return run

    def refuse(self) -> None:
        """Note that the corner at hand is not read."""
        corner, self.state.corner = self.state.corner, None
        if corner is not None:
            self.control.findings.refused(corner.name, corner.line, CURE)

    def lay(self, target: list[float]) -> None:
        """Lay the corner before the straight way to the target (3 + rotary) begins. Raises BlockError."""
        state, corner = self.state, self.state.corner
        assert corner is not None
        if corner.kind == ROUND:
            self.motion.need_even_scale(*OF_AXIS[state.tool_axis])
        try:
            laid = lay(self.control, corner, target, ARC_PLANE[state.tool_axis])
        except CornerError as error:
            raise BlockError(str(error)) from None
        if not laid:
            self.refuse()
        state.corner = None

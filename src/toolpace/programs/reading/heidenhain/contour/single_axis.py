"""Blocks of one axis: X+50, whose way R+ makes longer by the tool's radius, and R- shorter."""

from __future__ import annotations

import math
from dataclasses import replace

from toolpace.programs.reading.compensation.ends import is_scaled
from toolpace.programs.reading.heidenhain.contour.compensation import LENGTHENED
from toolpace.programs.reading.heidenhain.contour.motion import Motion, Step
from toolpace.programs.reading.heidenhain.klartext.expressions import evaluate
from toolpace.programs.reading.heidenhain.klartext.parameters import BlockError
from toolpace.programs.reading.heidenhain.klartext.words import PathWords


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

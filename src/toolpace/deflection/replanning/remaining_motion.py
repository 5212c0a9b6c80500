"""The remaining motion from an instant on, unchanged."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.motion.laws.chain import ChainLaw, LawPiece
from toolpace.motion.laws.law import TimeLaw
from toolpace.path.axis_run import AxisRun


class RemainingMotion(AxisRun):
    """The rest of a run from where its law is at a time."""

    def __init__(self, base: AxisRun, law: TimeLaw, begin: float) -> None:
        """`begin` is the time on the law's clock [s]."""
        self.base, self.law, self.begin = base, law, begin
        self.s0, self.s1 = float(np.clip(law.at(np.array([begin]))[0, 0], base.s0, base.s1)), base.s1
        self.breaks, self.hints = base.breaks[base.breaks > self.s0], base.hints[base.hints > self.s0]
        self.dwell, self.blocks, self.smooth_cap = base.dwell, base.blocks, base.smooth_cap
        self.tool_length = base.tool_length

    def rest(self) -> TimeLaw:
        """The law of it."""
        return ChainLaw([LawPiece(self.law, self.begin, self.law.duration)])

    def evaluate(self, s: Floats) -> Floats:
        return self.base.evaluate(s)

    def speed_cap(self, s: Floats) -> Floats:
        return self.base.speed_cap(s)

    def block_at(self, s: Floats) -> Ints:
        return self.base.block_at(s)


class Stretch(AxisRun):
    """A run between its start and a place, for a planner that shall look no further."""

    def __init__(self, base: AxisRun, end: float) -> None:
        self.base, self.s0, self.s1 = base, base.s0, end
        self.breaks, self.hints = base.breaks[base.breaks < end], base.hints[base.hints < end]
        self.tool_length = base.tool_length

    def evaluate(self, s: Floats) -> Floats:
        return self.base.evaluate(s)

    def speed_cap(self, s: Floats) -> Floats:
        return self.base.speed_cap(s)

    def block_at(self, s: Floats) -> Ints:
        return self.base.block_at(s)

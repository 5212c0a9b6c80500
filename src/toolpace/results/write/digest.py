"""What the folder of a plan holds of its set-points, gathered block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING

from toolpace.motion.files.compact_set_points import CompactWriter
from toolpace.motion.setpoints import Block, SetPointSource, each_block

if TYPE_CHECKING:
    from toolpace.results.report.charts import Curves


class SetPointDigest:
    """The way of the tip, and where they are wanted the packed set-points and the curves of the report.

    Takes the set-points block by block, in any order and in any thread.
    """

    def __init__(self, packed: CompactWriter | None = None, curves: Curves | None = None) -> None:
        self.packed, self.curves = packed, curves
        self._lengths: dict[int, float] = {}

    @classmethod
    def of(
        cls, source: SetPointSource, packed: CompactWriter | None = None, curves: Curves | None = None
    ) -> SetPointDigest:
        """That of all set-points."""
        digest = cls(packed, curves)
        each_block(source, (digest.take,))
        return digest

    def take(self, block: Block) -> None:
        """Look at a block."""
        if block.near.has_tool:
            begin = block.begin - block.first
            self._lengths[block.begin] = float(block.near.tip_steps[begin : begin + block.end - block.begin].sum())
        for each in (self.packed, self.curves):
            if each is not None:
                each.take(block)

    @property
    def length(self) -> float:
        """Of the way of the tip [m]."""
        return sum(self._lengths[begin] for begin in sorted(self._lengths))

"""F, and the dwell G4."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from toolpace.common.units import MILLIMETRE
from toolpace.programs.reading.control.feed import INVERSE
from toolpace.programs.reading.sinumerik.run import Run
from toolpace.programs.reading.sinumerik.syntax.values import ValueFault, real
from toolpace.programs.reading.sinumerik.word_values import Words, number

MOST_SHARE = 2.0
"""Of OVR."""


class FeedWords:
    """Reads F and G4."""

    def __init__(self, run: Run) -> None:
        self.control, self.state, self.findings = run.control, run.state, run.findings
        self.share = 1.0
        """OVR: what is made of F."""

    def dwell(self, words: Words) -> None:
        """G4 F2 or G4 S3: seconds, or turns of the spindle; F and S in force stay."""
        seconds, turns = number(words, "F"), number(words, "S")
        if words:
            raise ValueFault(f"G4 beside {next(iter(words))}: write G4 in a block of its own (alarm 12120)")
        if seconds is None and turns is None:
            raise ValueFault("G4 needs its time: write G4 F2 for seconds, or G4 S3 for turns of the spindle")
        if seconds is None and turns is not None:
            if self.control.feed.spindle <= 0.0:
                raise ValueFault("G4 S counts turns of the spindle: write its speed S before it, or G4 F2")
            seconds = turns / self.control.feed.spindle
        self.control.dwell(seconds or 0.0)

    def override(self, words: Words) -> None:
        """OVR: the share of F [percent] that feed motions have from here on. Raises ValueFault."""
        share = (number(words, "OVR") or 0.0) / 100.0
        if not 0.0 < share <= MOST_SHARE:
            raise ValueFault(f"OVR={share * 100.0:g} is the share of F in percent: write more than 0, 200 at most")
        feed, changed = self.control.feed, share / self.share
        if feed.value is not None:
            feed.value, feed.turn = feed.value * changed, feed.turn * changed
        if self.state.inverse is not None:
            self.state.inverse *= changed
        self.share = share

    @contextmanager
    def of_block(self, words: Words) -> Iterator[None]:
        """FB: the feed of one block, behind which F holds again (NC Programming, 7: non-modal feed)."""
        if "FB" not in words:
            yield
            return
        feed = self.control.feed
        before = feed.value, feed.turn, feed.unit
        words["F"] = words.pop("FB")
        self.feed(words)
        yield
        feed.value, feed.turn, feed.unit = before

    def feed(self, words: Words) -> None:
        """F: under G700 and G710 in the unit of lengths, under G70 and G71 in the base unit of the control."""
        value = real(words.pop("F").value)
        feed, state = self.control.feed, self.state
        if feed.mode == INVERSE:
            if not 0.0 < value <= 1e9:
                raise ValueFault(f"feed F{value:g} must be above zero: correct F")
            state.inverse = value * self.share
            return
        if state.feed_unit is None and state.base_unit is None and state.unit != MILLIMETRE:
            self.findings.assumed("F under G70 is in inches: the base unit of the control is the program's")
        feed.set(value * self.share, state.unit_of_control(), self.control.line)

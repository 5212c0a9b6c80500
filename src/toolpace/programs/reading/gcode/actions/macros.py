"""Macro calls, and replacements for probing macros."""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.gcode.actions.modal import Modal
from toolpace.programs.reading.gcode.actions.motion import MotionReader
from toolpace.programs.reading.gcode.program.blocks import Block
from toolpace.programs.reading.gcode.program.calls import ARGUMENTS, Calls, Missing
from toolpace.programs.reading.gcode.program.words import RefusedError

LENGTHS_OF_MACROS = frozenset("IJK").union(ARGUMENTS) - frozenset("DHMST")
"""Arguments that are no whole numbers by their letter."""
NO_MACRO = (
    "its blocks are neither in this file nor in one beside it: give them with the program; where it measures and comes "
    "back to where it began, --skip-unknown passes over it"
)


class Macros:
    """Carries out G65 and G66."""

    def __init__(self, control: Control, state: Modal, motion: MotionReader, calls: Calls, by: Controller) -> None:
        self.control, self.state, self.motion, self.calls, self.controller = control, state, motion, calls, by
        self.least_increment = by.option("whole_numbers", "as written") == "least increment"

    def call(self, block: Block, word: str, *, modal: bool) -> None:
        """G65 and G66. Raises RefusedError where what is called is not at hand, and moves in no way that is known."""
        if self.least_increment and block.whole & LENGTHS_OF_MACROS:
            raise RefusedError("arguments of a macro without a point", "what they count goes by their letter: write it")
        missing = (self.calls.modal_macro if modal else self.calls.macro)(block.arguments, word)
        if missing is None:
            return
        if missing.word in self.controller.ignored:
            self.control.findings.ignored(missing.word)
        elif self.controller.meanings.get(missing.word) == "feed":
            self._protected(missing)
        else:
            raise RefusedError(missing.word, NO_MACRO)

    def _protected(self, missing: Missing) -> None:
        """Probing's way between its measurements: straight to X, Y, Z, at the feed F that it is given."""
        state, control, given = self.state, self.control, missing.given
        before = state.motion, control.feed.value, control.feed.turn
        found = {letter: given.get(ARGUMENTS[letter]) for letter in "XYZ"}
        feed = given.get(ARGUMENTS["F"])
        if feed is not None:
            control.feed.set(feed, state.unit, control.line)
        state.motion = "feed"
        self.motion.execute({key: value for key, value in found.items() if value is not None}, None, control.line)
        state.motion, control.feed.value, control.feed.turn = before

"""M70 to M73 of LinuxCNC: saved modal states.

After its manual, "M70 Save Modal State", "M72 Restore Modal State" and "M73 Save and Autorestore Modal State".
"""

from __future__ import annotations

from toolpace.common.units import DEGREE, MINUTE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.feed import PER_MINUTE
from toolpace.programs.reading.gcode.actions.frames.frames import Frames
from toolpace.programs.reading.gcode.actions.modal import Modal
from toolpace.programs.reading.gcode.program.flow import Flow
from toolpace.programs.reading.gcode.program.words import Handler, Numbers, WordError

MODES = ("unit", "absolute", "arc_absolute", "plane", "exact_stop", "to_initial", "length_word", "turning")
"""Of `Modal`; the motion in force is not among them."""


class SavedModes:
    """Carries out M70, M71, M72 and M73."""

    def __init__(self, control: Control, state: Modal, frames: Frames, flow: Flow) -> None:
        self.control, self.state, self.frames, self.flow = control, state, frames, flow
        self.offsets = frames.offsets

    def handlers(self) -> dict[str, Handler]:
        """What carries out each meaning."""
        return {
            "save modes": self.save,
            "save modes for return": self.save_for_return,
            "forget modes": self.forget,
            "restore modes": self.restore,
        }

    def save(self, numbers: Numbers, word: str) -> None:
        """M70."""
        control = self.control
        feed, coordinates = control.feed, control.coordinates
        modes = {name: getattr(self.state, name) for name in MODES}
        rates = feed.mode, feed.value, feed.turn, feed.unit, feed.spindle
        tool = coordinates.compensated, coordinates.length_of, coordinates.told
        offset, position_on = self.offsets.offset, self.frames.position_on
        joining = control.moves.joining

        def restore() -> None:
            for name, value in modes.items():
                setattr(self.state, name, value)
            feed.mode, feed.value, feed.turn, feed.unit, feed.spindle = rates
            number = 0.0 if feed.value is None else feed.turn / DEGREE * (MINUTE if feed.mode == PER_MINUTE else 1.0)
            if feed.unit != self.state.unit or abs(number - round(number, 1)) > 1e-9:
                # its interpreter writes F anew, as a number of one decimal in the unit of the saved modes
                feed.value = None
            coordinates.compensated, coordinates.length_of, coordinates.told = tool
            control.moves.join(joining)
            if position_on != self.frames.position_on:
                self.frames.put_position(position_on)
            if offset != self.offsets.offset:
                self.offsets.take(offset)
            else:
                self.offsets.changed()

        self.flow.frame.saved = restore

    def save_for_return(self, numbers: Numbers, word: str) -> None:
        """M73: restored where this level returns."""
        self.save(numbers, word)
        self.flow.frame.restores = True

    def forget(self, numbers: Numbers, word: str) -> None:
        """M71."""
        self.flow.frame.saved = None

    def restore(self, numbers: Numbers, word: str) -> None:
        """M72."""
        restore = self.flow.frame.saved
        if restore is None:
            raise WordError(f"{word} restores modes, and none were saved at this level: write M70 before it")
        restore()

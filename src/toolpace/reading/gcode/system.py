"""Variables that the controller itself sets: where the machine is, and what is in force."""

from __future__ import annotations

from toolpace.reading.control.control import Control
from toolpace.reading.gcode.actions.modal import Modal
from toolpace.reading.gcode.program.variables import Key
from toolpace.units import DEGREE, INCH

_MOTIONS = {"rapid": 0.0, "feed": 1.0, "arc clockwise": 2.0, "arc counter-clockwise": 3.0}
_AXES = "XYZABCUVW"
_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


class System:
    """Reads system variables by number (Fanuc, LinuxCNC) or name (LinuxCNC)."""

    def __init__(self, control: Control, state: Modal, *, named: bool) -> None:
        """named: whether they are those of LinuxCNC; else of Fanuc."""
        self.control, self.state, self.named = control, state, named

    def __call__(self, key: Key) -> float | None:
        """The value; None where it is not known."""
        if isinstance(key, str):
            return self._by_name(key) if self.named else None
        if self.named:
            if 5420 <= key <= 5428:
                return self._coordinate(_AXES[key - 5420])
            return self._of_linuxcnc(key)
        for first in (5000, 5040):
            if first < key <= first + 9:
                slots = sorted(self.control.slots.items(), key=lambda item: item[1])
                place = key - first - 1
                return self._coordinate(slots[place][0]) if place < len(slots) else None
        return self._modal(key)

    def _coordinate(self, letter: str) -> float | None:
        slot = self.control.slots.get(letter)
        if slot is None:
            return 0.0
        return self.control.words[slot] / (self.state.unit if slot < 3 else DEGREE)

    def _of_linuxcnc(self, key: int) -> float | None:
        if key == 5220:
            offset = self.control.coordinates.offset
            return float(_OFFSETS.index(offset) + 1) if offset in _OFFSETS else 1.0
        if key == 5400:
            return float(self.control.tool) if self.control.tool.isdigit() else 0.0
        return None

    def _modal(self, key: int) -> float | None:
        state = self.state
        inch = state.unit == INCH
        known: dict[int, float | None] = {
            4001: _MOTIONS.get(state.motion or ""),
            4002: (17.0, 18.0, 19.0)[state.plane],
            4003: 90.0 if state.absolute else 91.0,
            4006: 20.0 if inch else 21.0,
            4010: 98.0 if state.to_initial else 99.0,
            4111: float(state.length_word) if state.length_word else 0.0,
            4120: float(state.next_tool) if state.next_tool else 0.0,
        }
        return known.get(key)

    def _by_name(self, name: str) -> float | None:
        if len(name) == 2 and name[0] == "_" and name[1] in _AXES:
            return self._coordinate(name[1])
        inch = self.state.unit == INCH
        known = {
            "_METRIC": float(not inch),
            "_IMPERIAL": float(inch),
            "_ABSOLUTE": float(self.state.absolute),
            "_INCREMENTAL": float(not self.state.absolute),
            "_COORD_SYSTEM": None,
            "_CURRENT_TOOL": float(self.control.tool) if self.control.tool.isdigit() else 0.0,
            "_VALUE": 0.0,
            "_VALUE_RETURNED": 0.0,
            "_TASK": 0.0,
        }
        return known.get(name)

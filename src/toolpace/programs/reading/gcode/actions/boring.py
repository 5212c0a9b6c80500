"""Bores with an oriented spindle: where the tool stands beside the axis of its hole on its way in and out."""

from __future__ import annotations

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.gcode.actions.modal import Modal
from toolpace.programs.reading.gcode.program.words import RefusedError, WordError

DIRECTIONS = {"first": (0, 1.0), "first negative": (0, -1.0), "second": (1, 1.0), "second negative": (1, -1.0)}
"""Of a shift Q: which axis of the plane, and its sign (parameters 5101#4, #5 and 5148 of Fanuc, Setting 27 of Haas)."""
PLANE = ((0, 1), (2, 0), (1, 2))
"""First and second axis of the planes XY, ZX and YZ."""
STILL = 1e-12


class BoringShift:
    """The shift of G76, G87 (Fanuc) and G77 (Haas): Q in a direction of the control's, else I, J and K."""

    def __init__(self, control: Control, state: Modal, by: Controller) -> None:
        self.control, self.state = control, state
        self.axis, self.sign = DIRECTIONS[by.option("boring_shift", "first")]

    def beside(self, hole: list[float], words: dict[str, float]) -> list[float] | None:
        """The place (3 + rotary) beside the hole; None where the words of the cycle tell no shift.

        Raises WordError for Q below zero, RefusedError in turned, scaled or mirrored coordinates.
        """
        q, unit = words.get("Q", 0.0), self.state.unit
        if q < 0.0:
            raise WordError("Q is the shift of a boring tool and has no sign: write it above zero")
        found, plane = list(hole), PLANE[self.state.plane]
        if q:
            found[plane[self.axis]] += self.sign * q * unit
            self.control.findings.assumed(
                f"Q shifts a boring tool along {'+' if self.sign > 0 else '-'}{'XYZ'[plane[self.axis]]} of the "
                "coordinates in force (boring_shift in the controller's file: parameters 5101 and 5148 of Fanuc, "
                "Setting 27 of Haas)"
            )
        else:
            for slot in plane:
                found[slot] += words.get("IJK"[slot], 0.0) * unit
        if found == hole:
            return None
        self._need_plain()
        return found

    def _need_plain(self) -> None:
        """The spindle is oriented in the machine: what is turned or mirrored is not the direction of its tool."""
        frame, tilted = self.control.coordinates.frame, self.control.coordinates.tilted
        if not tilted and any(abs(frame[i][j] - (i == j)) > STILL for i in range(3) for j in range(3)):
            raise RefusedError(
                "the shift of an oriented tool in turned, scaled or mirrored coordinates",
                "its direction is that of the spindle: end those before the cycle (G69, G50, G50.1)",
            )

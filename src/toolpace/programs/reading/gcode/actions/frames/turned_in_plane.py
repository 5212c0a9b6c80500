"""Rotary words in a tilted plane: they turn their axes alone, and X, Y, Z wait until the tool stands on the plane.

Nothing follows a turn there unless tool-centre-point mode is on, as nothing follows that of G53.1. Where the plane is
when the tool has been turned off it is not told ("cancel G254 before any rotary motion", Haas UMC, G254).
"""

from __future__ import annotations

import math

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.joint_moves import turn_joints
from toolpace.programs.reading.control.tool_axis import plane_axis
from toolpace.programs.reading.gcode.actions.modal import Modal
from toolpace.programs.reading.gcode.program.words import RefusedError

SAME = 1e-6
"""Most distance from a rotary position, or a direction, that counts as being there [rad]."""
ROUNDED = 1.2e-5
"""Of a position that a post repeats with three decimals of a degree [rad]."""
REPEATED = "rotary words in a tilted plane that repeat the positions with three decimals are taken for them"


def turned_alone(control: Control, state: Modal, target: list[float], *, rapid: bool) -> bool:
    """Turn the rotary axes alone to words (3 + rotary), where a plane rules; False where nothing is to be turned.

    Raises RefusedError where X, Y or Z move too.
    """
    if not turns(control, target):
        return False
    if target[:3] != control.words[:3]:
        refuse()
    turn_joints(control, target[3:], rapid=rapid)
    state.turned_in_plane = True
    return True


def turns(control: Control, target: list[float]) -> bool:
    """Whether words (3 + rotary) turn axes in a plane; where they repeat a position they become it."""
    if not _rules(control) or target[3:] == control.words[3:]:
        return False
    off = max(abs(a - b) for a, b in zip(target[3:], control.words[3:]))
    if off > ROUNDED:
        return True
    if off > SAME:
        control.findings.assumed(REPEATED)
    target[3:] = control.words[3:]
    return False


def refuse() -> None:
    """Raises RefusedError."""
    raise RefusedError("rotary words beside a motion in a tilted plane", "turn the axes in a block before")


def need_on_plane(control: Control, state: Modal, target: list[float]) -> None:
    """RefusedError where X, Y, Z would move in a plane that the program has turned the tool off."""
    if not state.turned_in_plane or not _rules(control) or target[:3] == control.words[:3]:
        return
    axis = control.poses.axis(control.placement.place(control.words)[3:])
    if math.dist(axis, plane_axis(control)) > ROUNDED:
        raise RefusedError(
            "X, Y, Z in a tilted plane that the tool was turned off",
            "where the plane is then is not sure: end it before the turn (G69, G255 or G269), and tell it again",
        )


def _rules(control: Control) -> bool:
    """Whether a plane rules, and nothing follows a turn."""
    coordinates = control.coordinates
    return coordinates.tilted and not coordinates.tip_mode and control.poses.machine is not None

"""The rotary positions that a CYCLE800 plane requires."""

from __future__ import annotations

import math

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.joint_moves import turn_joints
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread

SAME = 1e-6
"""Most distance from a rotary position, or a direction, that counts as being there [rad]."""
ROUNDED = 1.2e-5
"""Of a position that a post repeats with three decimals of a degree [rad]."""
REPEATED = "rotary words in a plane of CYCLE800 that repeat its positions with three decimals are taken for them"


def need_turned(control: Control, frames: Frames) -> None:
    """Unread where X, Y and Z would move in a plane while the rotary axes are not where it is reckoned for.

    The control keeps those positions in its frames, whatever the axes do (K2, "TCARR"), unless TRAORI is on. With
    _DIR 0 it turns no axis: the program does, and the first positions that bring the tool square to the plane count.
    """
    if not frames.tilted or control.coordinates.tip_mode or control.poses.machine is None:
        return
    present = control.placement.place(control.words)[3:]
    if frames.turned_to is None:
        if math.dist(control.poses.axis(present), frames.plane_axis) > SAME:
            raise Unread(
                "X, Y, Z in a plane of CYCLE800 that the tool is not turned to (_DIR 0)",
                "turn the rotary axes before, or write _DIR 1 or -1",
            )
        frames.turned_to = present
    if not near([math.remainder(a - b, 2.0 * math.pi) for a, b in zip(present, frames.turned_to)], [0.0, 0.0], SAME):
        raise Unread(
            "X, Y, Z in a plane of CYCLE800 whose rotary axes have moved since",
            "the control's plane stays where it was: write CYCLE800 again, or TRAORI",
        )


def turned_alone(control: Control, frames: Frames, state: State, target: list[float], named: int) -> bool:
    """Turn the rotary axes alone to words (3 + rotary), in a plane without TRAORI, where nothing follows them.

    named: bits of X, Y, Z in the block. False where the block turns none; Unread where it moves others too.
    """
    if not frames.tilted or control.coordinates.tip_mode:
        return False
    if near(target[3:], control.words[3:], ROUNDED):
        if not near(target[3:], control.words[3:], SAME):
            control.findings.assumed(REPEATED)
        target[3:] = control.words[3:]
        need_turned(control, frames)
        return False
    if named or state.motion not in ("G0", "G1"):
        raise Unread("rotary words beside X, Y, Z in a plane of CYCLE800", "turn the axes in a block before")
    turn_joints(control, target[3:], rapid=state.motion == "G0")
    return True


def near(first: list[float], second: list[float], most: float) -> bool:
    """Whether rotary positions are no farther apart than that [rad]."""
    return all(abs(a - b) <= most for a, b in zip(first, second))

"""Frames along the tool: TOROT and relatives."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.programs.reading.sinumerik.frames import Frames
from toolpace.programs.reading.sinumerik.state import State
from toolpace.programs.reading.sinumerik.syntax.values import Unread, ValueFault, cross

BOTH, X_IN_ZX, Y_IN_YZ = "2000", "2001", "2002"
"""Values of $SC_TOFRAME_MODE (SD42980): the new X axis is as far from the old ZX plane as the new Y axis from the old
YZ plane; the new X axis lies in the old ZX plane; the new Y axis lies in the old YZ plane."""
SAME = 1e-9
"""Between directions that are one."""


def along(direction: Sequence[float], rule: str = BOTH) -> Matrix:
    """The turn of coordinates that brings their Z axis to a unit vector (3,), with X and Y as a rule has them.

    Raises ValueFault where the rule tells no X or Y.
    """
    x, y, z = direction
    if rule == BOTH:
        # X and Y are equally far from the old planes when the turn is the least one: its axis lies in the old XY plane
        if 1.0 + z < SAME:
            raise ValueFault("the tool points against Z: no frame along it is told; turn the frame with ROT before")
        rows = [
            [1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), x],
            [-x * y / (1.0 + z), 1.0 - y * y / (1.0 + z), y],
            [-x, -y, z],
        ]
        return affine.linear(rows)
    size = math.hypot(x, z) if rule == X_IN_ZX else math.hypot(y, z)
    if size < SAME:
        raise ValueFault("the tool lies along an axis of the old frame: X and Y of a frame along it are not told")
    if rule == X_IN_ZX:
        first = [z / size, 0.0, -x / size]
        second = cross(direction, first)
    else:
        second = [0.0, z / size, -y / size]
        first = cross(second, direction)
    return affine.linear([[first[k], second[k], direction[k]] for k in range(3)])


def turn_along_tool(control: Control, frames: Frames, state: State, rule: str, *, bound: bool = False) -> None:
    """TOROT: turn the frame in force about its origin until Z lies along the tool (Function Manual K2, TOROT).

    Without a transformation or a tilted plane the tool stands along Z already ("if no toolholder is active, the Z
    direction is the old one"). Raises Unread.
    """
    if state.plane:
        raise Unread("TOROT under G18 or G19", "the direction of the tool is another there: write G17")
    placement = control.placement
    if not placement.tip_mode:
        return
    columns = [[row[k] for row in placement.matrix] for k in range(3)]
    if math.dist(cross(columns[0], columns[1]), columns[2]) > SAME or abs(math.hypot(*columns[0]) - 1.0) > SAME:
        raise Unread("TOROT in a scaled or mirrored frame", "end the scale or the mirror before")
    axis = control.poses.axis(placement.place(control.words)[3:])
    direction = [sum(a * b for a, b in zip(column, axis)) for column in columns]
    if math.dist(direction, (0.0, 0.0, 1.0)) < SAME:
        frames.turn_before_programmed(IDENTITY)
        return
    if min(abs(direction[0]), abs(direction[1])) > SAME:
        control.findings.assumed(f"TOROT: X and Y of the frame are as $SC_TOFRAME_MODE = {rule} has them (SD42980)")
    frames.turn_before_programmed(along(direction, rule), bound=bound)

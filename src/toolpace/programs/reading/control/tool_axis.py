"""The tool axis of a program as rotary words, and turns of the tool to a tilted plane."""

from __future__ import annotations

import math
from collections.abc import Sequence

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.joint_moves import turn_joints
from toolpace.programs.reading.coordinates import affine

UNEVEN = 1e-9
"""By what share scales along X, Y and Z may differ and count as one."""


def rotary_for(
    control: Control,
    axis: list[float],
    sign: int = 0,
    *,
    first: tuple[int, int] | None = None,
    else_other: bool = False,
) -> list[float]:
    """Rotary words that bring the tool to an axis (3,) on the part, the nearest to where the machine is.

    sign: of the two solutions the one with the second rotary joint below (-1) or above (1) zero; 0: either.
    else_other: where that one is out of travel, the other. first: the rotary joints in the order in which each turns as
    little as it can; None: the sum of squares counts. Raises ProgramError.
    """
    placement = control.placement
    present = placement.place(control.words)[3:]
    wanted, fault = control.orientation.rotary(axis, present, sign, first, else_other=else_other)
    if fault:
        control.source.fail(fault, control.line)
    shift = placement.shift or (0.0,) * len(wanted)
    return [a - b for a, b in zip(wanted, shift)]


def plane_axis(control: Control) -> list[float]:
    """The direction (3,) on the part that the tool has when it stands upright on the plane of the frame."""
    return direction_on_part(control, (0.0, 0.0, 1.0))


def direction_on_part(control: Control, direction: Sequence[float]) -> list[float]:
    """A direction (3,) of the program's coordinates as a unit vector on the part; zero stays zero."""
    placement = control.placement if control.placement.tip_mode else control.coordinates.on_part()
    lengths = [math.hypot(*(row[column] for row in placement.matrix)) for column in range(3)]
    if max(lengths) - min(lengths) > UNEVEN * max(lengths):
        control.source.fail(
            "a direction of the tool in coordinates that are scaled unevenly: controls differ in whether it is scaled "
            "too; end the scale before, or scale the path in the CAM system",
            control.line,
        )
    found = affine.direct(placement.matrix, direction)
    length = math.hypot(*found) or 1.0
    return [value / length for value in found]


def turn_to_plane(
    control: Control,
    *,
    follow: bool = False,
    rapid: bool = True,
    sign: int = 0,
    first: tuple[int, int] | None = None,
    else_other: bool = False,
) -> None:
    """Turn the rotary joints until the tool stands upright on the plane of the frame.

    follow: the tip keeps its place on the part; else the linear joints keep theirs.
    """
    wanted = rotary_for(control, plane_axis(control), sign, first=first, else_other=else_other)
    if follow:
        control.straight([*control.words[:3], *wanted], 0, rapid=rapid)
    else:
        turn_joints(control, wanted, rapid=rapid)

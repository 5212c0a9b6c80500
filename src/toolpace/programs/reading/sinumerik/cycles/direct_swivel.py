"""CYCLE800 with rotary axis positions."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.units import DEGREE
from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.coordinates import affine
from toolpace.programs.reading.coordinates.affine import IDENTITY, Matrix
from toolpace.programs.reading.sinumerik.orientation.rotary_order import in_order
from toolpace.programs.reading.sinumerik.orientation.tool_frame import SAME, along
from toolpace.programs.reading.sinumerik.syntax.values import Unread
from toolpace.programs.reading.sinumerik.word_values import Arguments

_CURE = "let the CAM system write the plane axis by axis (_MODE 57)"


def positions(arguments: Arguments, control: Control) -> list[float]:
    """Rotary words [rad] of _A and _B, the positions of the first and the second rotary axis. Raises Unread."""
    if control.placement.shift:
        raise Unread("CYCLE800 with rotary axes given directly, which an offset shifts", _CURE)
    if arguments.number(9):
        raise Unread("CYCLE800 with a third rotary axis given directly (_C)", _CURE)
    wanted = [0.0, 0.0]
    for place, column in enumerate(in_order(control)):
        wanted[column] = arguments.number(7 + place) * DEGREE
    return wanted


def turned_with_axes(rotary: list[float], control: Control) -> Matrix:
    """The turn of coordinates whose Z is the tool at rotary positions [rad], and whose X and Y are the machine's.

    "The tool axis is aligned in the Z direction. You can derive the resulting direction of the X and Y axis by
    traversing the axes" (Operating Manual Milling, "Swiveling plane"). A head keeps X and Y where it turns about an
    axis across the tool, as TOROT has them; else they are not told. Raises Unread.
    """
    poses = control.poses
    carried = poses.carried(rotary)
    _, upright, _ = poses.linear_map([0.0] * len(rotary))
    _, columns, _ = poses.linear_map(carried)
    table = columns @ np.linalg.inv(upright)
    of_head = [k for k, (a, b) in enumerate(zip(rotary, carried)) if a != b]
    if not of_head:
        turn = table
    else:
        if len(of_head) > 1 or not _across_tool(control, of_head[0]):
            raise Unread("CYCLE800 with axes of a head given directly", f"X and Y there are not told: {_CURE}")
        direction = table.T @ np.array(poses.axis(rotary))
        turn = table @ np.array([row[:3] for row in along(direction.tolist())])
    control.findings.assumed(
        "CYCLE800 with rotary axes given directly (_MODE 192): X and Y of the plane are those of the machine there"
    )
    return IDENTITY if np.allclose(turn, np.eye(3), atol=1e-15) else affine.linear(turn.tolist())


def _across_tool(control: Control, joint: int) -> bool:
    """Whether a rotary joint of the head turns about an axis square to the tool: it carries the tool in a plane."""
    found = []
    for angle in (0.0, 0.7, 1.4):
        alone = [0.0] * len(control.poses.rotary)
        alone[joint] = angle
        found.append(control.poses.axis(alone))
    return abs(float(np.linalg.det(found))) < SAME and math.dist(found[0], found[1]) > SAME

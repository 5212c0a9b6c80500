"""Nodes by simpler means: matrices of frames, curves of arcs, holes as strokes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.one_program import frames
from testbed.one_program.motion import Circle
from testbed.one_program.nodes import Arc, Dwell, Frame, Holes, Line, Stop
from toolpace.common.arrays import Floats

NORMAL = (2, 1, 0)
AXES = ((0, 1), (2, 0), (1, 2))
"""First and second axis of the planes XY, ZX, YZ."""
SAME = 1e-10


def matrix_of(node: Frame) -> Floats:
    """The frame (4, 4) of a node."""
    if node.kind == "shift":
        return frames.shift(node.value)
    if node.kind == "turn":
        return frames.about(int(node.value[0]), float(node.value[1]))
    return frames.scaled(node.value)


def circle_of(node: Arc, start: Floats) -> Circle:
    """The curve of an arc from a place (3,), in the coordinates that the node is in."""
    first, second = AXES[node.plane]
    normal = NORMAL[node.plane]
    centre = np.array(node.centre)
    centre[normal] = start[normal]
    u = start - centre
    axis = np.eye(3)[normal] * (1.0 if node.left else -1.0)
    w = np.cross(axis, u)
    spoke = node.to - centre
    spoke[normal] = 0.0
    sweep = float(np.arctan2(spoke @ w, spoke @ u) % (2.0 * np.pi))
    over = np.hypot(*(node.to - start)[[first, second]]) < SAME
    sweep = 2.0 * np.pi * ((1.0 if over else sweep / (2.0 * np.pi)) + node.turns)
    rise = np.zeros(3)
    rise[normal] = node.to[normal] - start[normal]
    return Circle(centre, u, w, sweep, rise)


def drilled(node: Holes, level: float) -> Iterator[Line | Dwell | Stop]:
    """The strokes of all holes, from a height."""
    back = node.top if node.to_top else level
    for x, y in node.places:
        for z, speed in ((level, 0.0), (node.top, 0.0)):
            yield Line(np.array([x, y, z]), speed)
        for z, speed in strokes(node):
            yield Line(np.array([x, y, z]), speed)
        if node.seconds:
            yield Dwell(node.seconds)
        if node.kind == "tap":
            yield Stop()
        if node.kind in ("tap", "bore", "bore and dwell"):
            yield Line(np.array([x, y, node.top]), node.speed)
        yield Line(np.array([x, y, back]), 0.0)
        level = back


def strokes(node: Holes) -> Iterator[tuple[float, float]]:
    """Heights, and speeds to them, from the top to the bottom."""
    depth = node.peck
    while node.peck and depth < node.top - node.bottom - 1e-9:
        yield node.top - depth, node.speed
        if node.kind == "peck":
            yield node.top, 0.0
        yield node.top - depth + node.clearance, 0.0
        depth += node.peck
    yield node.bottom, node.speed

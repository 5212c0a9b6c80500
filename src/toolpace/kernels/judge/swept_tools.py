"""Which points of space tools have been at: solids of revolution, at poses of a motion."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

HEIGHT, RADIUS, SINE, COSINE, CURVATURE = 0, 1, 2, 3, 4
"""Of a piece of a meridian where it begins: height above the tip and radius [m], sine and cosine of the angle between
the axis and the normal; and its curvature [1/m], 0 of a line."""

GROUP = 32
"""Poses that a point is far from at once."""


class Solids(NamedTuple):
    """k solids of revolution."""

    pieces: Floats
    """(p, 5) of all meridians, each from the tip upwards."""
    first: Ints
    """(k + 1,) the first piece of each, and the number of all."""
    reach: Floats
    """(k,) height of their upper ends [m]."""
    widest: Floats
    """(k,) their largest radius [m]."""


class ToolPoses(NamedTuple):
    """n poses of solids."""

    tip: Floats
    """(n, 3) [m]"""
    axis: Floats
    """(n, 3)"""
    solid: Ints
    """(n,) from 0 on."""


@jit()
def holds(solids: Solids, solid: int, height: float, square: float, margin: float) -> bool:
    """Whether a point at a height above the tip and a squared distance from the axis is in a solid, deeper than a
    margin [m]."""
    if height <= margin or height >= solids.reach[solid] or square >= solids.widest[solid] ** 2:
        return False
    k = solids.first[solid]
    while k + 1 < solids.first[solid + 1] and solids.pieces[k + 1, HEIGHT] <= height:
        k += 1
    piece = solids.pieces[k]
    up, sine = height - piece[HEIGHT], piece[SINE]
    if piece[CURVATURE] > 0.0:
        cosine = piece[COSINE] - piece[CURVATURE] * up
        radius = piece[RADIUS] + (math.sqrt(max(1.0 - cosine * cosine, 0.0)) - sine) / piece[CURVATURE]
    else:
        radius = piece[RADIUS] + up * piece[COSINE] / max(sine, 1e-12)
    inside: bool = radius > margin and square < (radius - margin) ** 2
    return inside


@jit()
def was_at(place: Floats, k: int, poses: ToolPoses, solids: Solids, margin: float) -> bool:
    """Whether the solid in pose k holds a point (3,)."""
    height, square = from_pose(place, k, poses)
    inside: bool = holds(solids, poses.solid[k], height, square, margin)
    return inside


@jit()
def from_pose(place: Floats, k: int, poses: ToolPoses) -> tuple[float, float]:
    """How far a point (3,) is along the axis of pose k from its tip [m], and its squared distance from that axis."""
    x, y, z = place[0] - poses.tip[k, 0], place[1] - poses.tip[k, 1], place[2] - poses.tip[k, 2]
    height = x * poses.axis[k, 0] + y * poses.axis[k, 1] + z * poses.axis[k, 2]
    return height, x * x + y * y + z * z - height * height


@jit()
def groups(poses: ToolPoses, solids: Solids) -> Floats:
    """(m, 3) of each GROUP of poses in their order, seen from its middle one: by how much a point that any of them
    holds can be further from the axis than the widest of solids, below the tip, and above their ends [m]."""
    count = (len(poses.tip) + GROUP - 1) // GROUP
    found, longest, widest = np.zeros((count, 3)), solids.reach.max(), solids.widest.max()
    for g in range(count):
        begin, end = g * GROUP, min((g + 1) * GROUP, len(poses.tip))
        middle = (begin + end) // 2
        for k in range(begin, end):
            off, turn = 0.0, 0.0
            for c in range(3):
                off += (poses.tip[k, c] - poses.tip[middle, c]) ** 2
                turn += (poses.axis[k, c] - poses.axis[middle, c]) ** 2
            room = math.sqrt(off) + math.sqrt(turn) * (longest + widest)
            found[g, 0] = max(found[g, 0], room + solids.widest[poses.solid[k]])
            found[g, 1] = max(found[g, 1], room)
            found[g, 2] = max(found[g, 2], room + solids.reach[poses.solid[k]])
    return found


@jit()
def reached(place: Floats, poses: ToolPoses, of_groups: Floats, solids: Solids, margin: float) -> Bools:
    """(k,) which points (k, 3) a solid has been at in any of the poses, looked at in this order; of_groups: what
    `groups` finds of these."""
    found = np.zeros(len(place), dtype=np.bool_)
    last = -1
    for i in range(len(place)):
        # the pose that reached the point before most likely reached this one
        if last >= 0 and was_at(place[i], last, poses, solids, margin):
            found[i] = True
            continue
        for g in range(len(of_groups)):
            begin, end = g * GROUP, min((g + 1) * GROUP, len(poses.tip))
            height, square = from_pose(place[i], (begin + end) // 2, poses)
            if height < -of_groups[g, 1] or height > of_groups[g, 2] or square > of_groups[g, 0] ** 2:
                continue
            for k in range(begin, end):
                if was_at(place[i], k, poses, solids, margin):
                    found[i] = True
                    last = k
                    break
            if found[i]:
                break
    return found

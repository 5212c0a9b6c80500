"""The overlap of two segments, each at half its acceleration."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    ACCELERATION,
    ARC,
    ASKED,
    BEGIN,
    BLOCK,
    CENTRE,
    CORNER,
    END,
    ENDING,
    FIXED,
    KIND,
    KINK_AFTER,
    KINK_BEFORE,
    LENGTH,
    OF_RADIUS,
    OVERLAPPED,
    OVERLAPS,
    TOLERANCE,
    Blocks,
    acceleration_of,
)
from toolpace.kernels.linuxcnc.vectors import ORIGIN, Vector, along, dot, from_to, of_block, unit

LEAST_ANGLE = 1e-3
"""Between the ways of two segments, for a tolerance to count."""


@jit()
def overlap_speeds(b: Blocks, q: Floats, k: int, new: int, goal: float, goal_new: float) -> tuple[float, float, float]:
    """Speeds at which both overlap at most, and the speed through the corner."""
    a, a_new = acceleration_of(q, k), acceleration_of(q, new)
    v, v_new = min(peak_speed(q, k, a), goal), min(peak_speed(q, new, a_new), goal_new)
    longest = min(q[k, LENGTH] / v, q[new, LENGTH] / v_new)
    time = min(longest, max(v / a, v_new / a_new))
    v, v_new = min(v, time * a), min(v_new, time * a_new)
    j, j_new = int(q[k, BLOCK]), int(q[new, BLOCK])
    turn = dot(of_block(b, j, END), start_of(b, q, new, j_new))
    theta = 0.5 * math.acos(max(-1.0, min(1.0, -turn)))
    if q[k, TOLERANCE] > 0.0 and math.cos(theta) > math.sin(LEAST_ANGLE):
        near = 2.0 * math.sqrt(a * q[k, TOLERANCE] / math.cos(theta))
        v, v_new = min(v, near), min(v_new, near)
    return v, v_new, math.sin(theta) * 0.5 * (v + v_new)


@jit(inline=True)
def peak_speed(q: Floats, k: int, acceleration: float) -> float:
    """Of a segment from rest to rest; half of it may still be cut where its length is not final."""
    return math.sqrt(acceleration * q[k, LENGTH] * (1.0 if q[k, FIXED] else 0.5))


@jit(inline=True)
def start_of(b: Blocks, q: Floats, k: int, j: int) -> Vector:
    """Direction in which a segment accelerates at its start: an arc inwards, too."""
    if q[k, KIND] != ARC:
        return of_block(b, j, BEGIN)
    share = 1.0 - max(q[k, KINK_AFTER], q[k, KINK_BEFORE])
    if q[k, OVERLAPS] or q[k, ENDING] == OVERLAPPED:
        share *= 0.5
    inwards = unit(from_to(of_block(b, j, CORNER), of_block(b, j, CENTRE)))
    curved = (0.5 * q[k, ASKED]) ** 2 / b.figures[j, OF_RADIUS]
    return unit(along(along(ORIGIN, q[k, ACCELERATION] * share, of_block(b, j, BEGIN)), curved, inwards))

"""Rotary positions at the pole, where the tool axis does not determine the first rotary joint."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.branches import SLACK, TURN, wrapped
from toolpace.kernels.kinematics.chain import second_angle, turn
from toolpace.kernels.kinematics.geometry import U1


@jit()
def step(tip: Floats, i: int) -> float:
    """Way of the tip to point i."""
    x, y, z = tip[i, 0] - tip[i - 1, 0], tip[i, 1] - tip[i - 1, 1], tip[i, 2] - tip[i - 1, 2]
    return math.sqrt(x * x + y * y + z * z)


@jit()
def beside(rotary: Floats, joint: int, before: int, after: int, travel: Floats) -> float:
    """Position of a joint at the point before, else at the one after, else as near to zero as it can be."""
    near: float = min(max(0.0, travel[joint, 0]), travel[joint, 1])
    if before >= 0:
        near = rotary[before, joint]
    elif after < len(rotary):
        near = rotary[after, joint]
    return near


@jit()
def turn_first(tip: Floats, begin: int, end: int, travel: Floats, rotary: Floats) -> None:
    """The first joint over the poles begin ... end - 1, in proportion to the way of the tip."""
    before = beside(rotary, 0, begin - 1, end, travel)
    after = rotary[end, 0] if end < len(rotary) else before
    length = 0.0
    for i in range(begin + 1, end):
        length += step(tip, i)
    along = 0.0
    for i in range(begin, end):
        if i > begin:
            along += step(tip, i)
        if end - begin == 1:
            share = 0.5
        elif length > 0.0:
            share = along / length
        else:
            share = (i - begin) / (end - begin - 1)
        rotary[i, 0] = before + share * (after - before)


@jit()
def into_travel(angle: float, low: float, high: float, tolerance: float) -> float:
    """The angle a turn further on if it is within travel there; at the end of travel if it is that near."""
    if angle < low - SLACK and angle + TURN <= high:
        angle += TURN
    elif angle > high + SLACK and angle - TURN >= low:
        angle -= TURN
    if low - tolerance <= angle < low:
        return low
    if high < angle <= high + tolerance:
        return high
    return angle


@jit()
def settle_poles(
    frame: Floats, axis: Floats, tip: Floats, pole: Bools, travel: Floats, tolerance: float, rotary: Floats
) -> None:
    """Fill in `rotary` (n, 2) at poles (n,), the rest being given.

    The first joint turns over each stretch of poles in proportion to the way of the tip, from its value
    before to its value after; the second brings the tool axis as near as it can, which is exact at the pole
    itself.
    """
    n = len(pole)
    back = np.empty(3)
    begin = 0
    while begin < n:
        if not pole[begin]:
            begin += 1
            continue
        end = begin
        while end < n and pole[end]:
            end += 1
        turn_first(tip, begin, end, travel, rotary)
        for i in range(begin, end):
            turn(frame[U1], -math.sin(rotary[i, 0]), math.cos(rotary[i, 0]), axis[i], back)
            near = beside(rotary, 1, i - 1, end, travel)
            angle = near + wrapped(second_angle(frame, back) - near)
            rotary[i, 1] = into_travel(angle, travel[1, 0], travel[1, 1], tolerance)
        begin = end

"""Rotary positions at the pole, where the tool axis leaves the first rotary joint free."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.kinematics.branches import SLACK, TURN, wrapped
from toolpace.kernels.kinematics.chain import second_angle, turn


@jit()
def step(tip: Any, i: int) -> float:
    """Way of the tip to point i."""
    x, y, z = tip[i, 0] - tip[i - 1, 0], tip[i, 1] - tip[i - 1, 1], tip[i, 2] - tip[i - 1, 2]
    return math.sqrt(x * x + y * y + z * z)


@jit()
def settle_poles(frame: Any, axis: Any, tip: Any, pole: Any, travel: Any, tolerance: float, rotary: Any) -> None:
    """Fill in `rotary` (n, 2) at poles (n,), the rest being given.

    The first joint turns over each stretch of poles in proportion to the way of the tip, from its value
    before to its value after; the second brings the tool axis as near as it can, which is exact at the pole
    itself.
    """
    n = len(pole)
    back = np.empty(3)
    start = 0
    while start < n:
        if not pole[start]:
            start += 1
            continue
        end = start
        while end < n and pole[end]:
            end += 1
        if start > 0:
            before = rotary[start - 1, 0]
        elif end < n:
            before = rotary[end, 0]
        else:
            before = min(max(0.0, travel[0, 0]), travel[0, 1])
        after = rotary[end, 0] if end < n else before
        length = 0.0
        for i in range(start + 1, end):
            length += step(tip, i)
        along = 0.0
        for i in range(start, end):
            if i > start:
                along += step(tip, i)
            if end - start == 1:
                share = 0.5
            elif length > 0.0:
                share = along / length
            else:
                share = (i - start) / (end - start - 1)
            rotary[i, 0] = before + share * (after - before)
        for i in range(start, end):
            turn(frame[0], -math.sin(rotary[i, 0]), math.cos(rotary[i, 0]), axis[i], back)
            angle = second_angle(frame, back)
            if i > 0:
                near = rotary[i - 1, 1]
            elif end < n:
                near = rotary[end, 1]
            else:
                near = min(max(0.0, travel[1, 0]), travel[1, 1])
            angle = near + wrapped(angle - near)
            low = travel[1, 0]
            high = travel[1, 1]
            if angle < low - SLACK and angle + TURN <= high:
                angle += TURN
            elif angle > high + SLACK and angle - TURN >= low:
                angle -= TURN
            if low - tolerance <= angle < low:
                angle = low
            elif high < angle <= high + tolerance:
                angle = high
            rotary[i, 1] = angle
        start = end

"""Final speeds of segments, planned backwards from the end of the queue."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.linuxcnc.blocks import (
    DONE,
    ENDING,
    FINAL,
    FIXED,
    KINK,
    LENGTH,
    OVERLAPPING,
    PEAK,
    SPLIT,
    TANGENT,
    TOP,
    Control,
    acceleration_of,
    most_speed,
)

SHORTEST = 1.02
"""Cycles of the shortest segment."""
PEAKS = 4
"""Peaks of the plan behind which looking back ends."""
BEGUN = 0.25
"""Share of a segment that is done from which on its end is not planned anew."""


@jit()
def look_back(q: Floats, head: int, tail: int, control: Control) -> None:
    """Plan final speeds from the end of the queue backwards, as deep as the control looks ahead."""
    peaks = 0
    past = False
    for x in range(1, control.depth + 2):
        s = tail - x
        k = s - 1
        if k < head:
            return
        if q[k, ENDING] != TANGENT:
            if past:
                return
            past = True
            continue
        if q[k, DONE] >= BEGUN * q[k, LENGTH] or q[k, SPLIT] or q[k, OVERLAPPING]:
            return
        if q[s, FIXED]:
            plan_end(q, k, s, control)
        else:
            # up to half of the last segment may still be cut: stop in the middle of it
            half = math.sqrt(acceleration_of(q, s) * q[s, LENGTH])
            q[k, FINAL] = min(q[k, TOP], min(half, most_speed(q, s, control, control.override)))
            q[s, FINAL] = 0.0
        if q[s, PEAK]:
            peaks += 1
        if peaks > PEAKS:
            return


@jit(inline=True)
def plan_end(q: Floats, k: int, s: int, control: Control) -> None:
    """Most final speed of segment k from which the next, s, gets down to its own."""
    speed = math.sqrt(q[s, FINAL] ** 2 + 2.0 * acceleration_of(q, s) * q[s, LENGTH])
    most = min(q[s, TOP], q[k, TOP])
    if q[k, KINK] >= 0.0:
        most = min(most, q[k, KINK])
    if speed >= most:
        speed = most
        q[k, PEAK] = 1.0
    q[k, FINAL] = speed
    q[s, TOP] = min(q[s, TOP], q[s, LENGTH] / (SHORTEST * control.cycle))

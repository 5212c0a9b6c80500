"""A move from rest to the first set-point, well within all limits."""

from __future__ import annotations

import math

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits

SHARE = 0.25
"""Of each limit that the move uses at most: nobody gains by a fast one."""
PEAKS = (1.875, 10.0 / math.sqrt(3.0), 60.0)
"""Largest slope, second and third derivative of 10 u^3 - 15 u^4 + 6 u^5 on 0 to 1."""


def approach(start: Floats, end: Floats, limits: Limits, period: float) -> Floats:
    """Rows (n, m) every `period` [s] from `start` (m,) to just before `end` (m,), all joints on one straight line; none
    where both are the same."""
    way = np.abs(end - start)
    if not way.any():
        return np.empty((0, len(start)))
    seconds = 0.0
    kinds = (limits.velocity, limits.acceleration, limits.jerk)
    for order, (limit, peak) in enumerate(zip(kinds, PEAKS), start=1):
        seconds = max(seconds, float(((peak * way / (SHARE * limit)) ** (1.0 / order)).max()))
    steps = max(math.ceil(seconds / period), 1)
    u = np.arange(steps) / steps
    rows: Floats = start + (u**3 * (10.0 - 15.0 * u + 6.0 * u**2))[:, None] * (end - start)
    return rows

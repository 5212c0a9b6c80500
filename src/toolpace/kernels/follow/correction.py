"""The correction: each joint on the quickest way to its aim, within the share of the limits that is kept for it."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.jerk_limited import approach
from toolpace.kernels.follow.layout import (
    AIM,
    CORRECTION,
    FEED_SHARE,
    FEED_SOON,
    JOINTS,
    LEVER,
    PERIOD,
    PLACE,
    SCRATCH,
    SHARE,
    TAU,
    TIP_PER_LINEAR,
)
from toolpace.kernels.follow.path import cell_at
from toolpace.kernels.jit import jit


@jit()
def correct(piece: Floats, state: Floats) -> None:
    """Move the correction for one period towards its aim."""
    feed = piece[cell_at(piece, state[TAU]) + FEED_SOON] * piece[FEED_SHARE]
    place = piece[PLACE : PLACE + 5].view(np.int64)
    limits = state[SCRATCH : SCRATCH + 3]
    for k in range(JOINTS):
        j = place[k]
        limits[0] = min(piece[SHARE + j], feed / (piece[LEVER] if k < 2 else piece[TIP_PER_LINEAR]))
        limits[1], limits[2] = piece[SHARE + JOINTS + j], piece[SHARE + 2 * JOINTS + j]
        of_joint = state[CORRECTION + 4 * j : CORRECTION + 4 * j + 4]
        approach(of_joint, state[AIM + j], limits, piece[PERIOD])


@jit()
def speed_of_correction(piece: Floats, state: Floats) -> float:
    """Most that the correction now adds to the speed of the tip [m/s]."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    linear, turning = 0.0, 0.0
    for k in range(JOINTS):
        speed = state[CORRECTION + 4 * place[k] + 1]
        if k < 2:
            turning += abs(speed) * piece[LEVER]
        else:
            linear += speed * speed
    speed_of_tip: float = math.sqrt(linear) * piece[TIP_PER_LINEAR] + turning
    return speed_of_tip

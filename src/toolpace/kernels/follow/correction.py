"""The correction of each joint: the fastest motion to its target within its share of the limits."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.follow.jerk_limited import approach
from toolpace.kernels.follow.layout import (
    AIM,
    CORRECTION,
    FEED,
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
    TURNING_SOON,
)
from toolpace.kernels.follow.path import cell_at
from toolpace.kernels.jit import jit

MOST_SHARE = 0.9
"""Share of the pace up to which the feed takes it off: the tool always goes on."""


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
def feed_of_correction(piece: Floats, state: Floats) -> float:
    """Share of the pace that keeps the feed: the correction moves, and carried by a turning workpiece it adds to the
    speed of the tip in proportion to the pace."""
    cell = cell_at(piece, state[TAU])
    moving = motion_of_tip(piece, state, 1) / piece[cell + FEED]
    carried = motion_of_tip(piece, state, 0) * piece[cell + TURNING_SOON]
    share: float = min(moving + carried / (1.0 + carried), MOST_SHARE)
    return share


@jit()
def motion_of_tip(piece: Floats, state: Floats, order: int) -> float:
    """Most motion of the tip [m] or speed [m/s] for the correction's value or its derivative of first order."""
    place = piece[PLACE : PLACE + 5].view(np.int64)
    linear, turning = 0.0, 0.0
    for k in range(JOINTS):
        own = state[CORRECTION + 4 * place[k] + order]
        if k < 2:
            turning += abs(own) * piece[LEVER]
        else:
            linear += own * own
    motion: float = math.sqrt(linear) * piece[TIP_PER_LINEAR] + turning
    return motion

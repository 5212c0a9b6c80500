"""Rotary joints that the optimisation does not move: those that the program only positions.

A cutter that goes along X, Y and Z is not to be swung for the little time that is gained by it: brakes hold the joint,
and at a pole what the tool axis does not feel is half a turn. Where the program turns a joint while it cuts, the joint
may turn in its ways through the air as well.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.path.fit.polyline import Polyline
from toolpace.planning.path_and_pace.segment import SLOT, slots_of

STILL = 1e-6
"""Turn of a joint on the way to a point of the program below which it stands still [tolerances]."""


def standing_still(line: Polyline, rapid: Bools, breaks: Floats) -> Bools:
    """(slots, 2) whether a rotary joint stays as it is in a slot: no cut of the run turns it, nor anything in all cells
    of the slot. `rapid` (k,) says which ways of the run are rapids, `breaks` (cells + 1,) are in tolerances."""
    turns = np.abs(np.diff(line.turn, axis=0)) > STILL
    # a run of nothing but rapids may be a program that tells no feeds
    cuts = ~rapid if not rapid.all() else np.ones_like(rapid)
    only_positioned = ~np.any(turns & cuts[:, None], axis=0)
    turned = np.concatenate([np.zeros((1, 2), dtype=np.int64), np.cumsum(turns, axis=0)])
    slot, last = np.arange(slots_of(breaks)), len(breaks) - 1
    low, high = breaks[np.clip(slot - SLOT + 1, 0, last)], breaks[np.clip(slot + 1, 0, last)]
    before = np.clip(np.searchsorted(line.s, low, side="right") - 1, 0, len(turns))
    after = np.clip(np.searchsorted(line.s, high, side="left"), 0, len(turns))
    return np.asarray(only_positioned & (turned[after] == turned[before]))

"""Of places put close together, those that a curve takes: a path is fitted best to few points."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints

CHUNK = 64
"""Of so many places one is kept in any case; a power of two."""


def needed(way: Floats, value: Floats, fixed: Bools, straight: float) -> Ints:
    """The places (k,) of n along a way [m] between which a value (n, d) is within `straight` of a straight line.

    All that are `fixed` are among them, both ends too. Between two of these, or in a CHUNK, every place is kept, or
    every second, fourth, ...: as few as do.
    """
    at = np.arange(len(way))
    corner = fixed | (at % CHUNK == 0) | (at == at[-1])
    corners = np.flatnonzero(corner)
    chunk = np.minimum(np.searchsorted(corners, at, side="right") - 1, len(corners) - 2)
    first, last = corners[chunk], corners[chunk + 1]
    stride = np.ones(len(corners) - 1, dtype=np.int64)
    for wider in 2 ** np.arange(1, CHUNK.bit_length()):
        before = first + (at - first) // wider * wider
        after = np.minimum(before + wider, last)
        whole = way[after] - way[before]
        share = (way - way[before]) / np.where(whole > 0.0, whole, 1.0)
        off = value - value[before] - share[:, None] * (value[after] - value[before])
        worst = np.maximum.reduceat(np.sqrt((off**2).sum(axis=1)), corners[:-1])
        stride[(worst <= straight) & (stride == wider // 2)] = wider
    return np.flatnonzero(corner | ((at - first) % stride[chunk] == 0))

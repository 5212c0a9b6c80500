"""Arrays in tiles: the values of TILE points side by side in memory.

A loop over the places of a tile, its lanes, does the same for each of them, which vector instructions do for several at
once. An array (points, ...) becomes (tiles, ..., TILE); the last tile is partly empty.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

TILE = 64


@jit()
def tiled(values: Floats) -> Floats:
    """(tiles, width, TILE) of values (points, width); zeros beyond the last point."""
    points, width = values.shape
    out = np.zeros(((points + TILE - 1) // TILE, width, TILE))
    for p in range(points):
        for i in range(width):
            out[p // TILE, i, p % TILE] = values[p, i]
    return out


@jit(reorder=True)
def advance(dual: Floats, step: Floats, go: float) -> None:
    """Go the share `go` of the steps of multipliers (k,)."""
    for i in range(len(dual)):
        dual[i] += go * step[i]

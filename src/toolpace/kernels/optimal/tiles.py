"""Arrays in tiles: of what belongs to points, the values of TILE points side by side in memory.

A loop over the places of a tile, its lanes, does the same for each of them, which vector instructions do for several at
once. An array (points, ...) becomes (tiles, ..., TILE); the last tile is partly empty.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit

TILE = 64


@jit()
def tiled(values: Any) -> Any:
    """(tiles, width, TILE) of values (points, width); zeros beyond the last point."""
    points, width = values.shape
    out = np.zeros(((points + TILE - 1) // TILE, width, TILE))
    for p in range(points):
        for i in range(width):
            out[p // TILE, i, p % TILE] = values[p, i]
    return out


@jit(reorder=True)
def advance(dual: Any, step: Any, go: Any) -> Any:
    """Go the share `go` of the multipliers' steps."""
    values, steps = dual.reshape(-1), step.reshape(-1)
    for i in range(len(values)):
        values[i] += go * steps[i]

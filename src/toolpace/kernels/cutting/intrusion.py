"""How deep a convex solid of revolution is in the material of a stock."""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats
from toolpace.kernels.cutting.dexels import Field
from toolpace.kernels.cutting.removal import near_box, row_part, Shadow, widest_of
from toolpace.kernels.cutting.revolution import A, ARC, B, WIDEST, Z0, Z1, chord
from toolpace.kernels.jit import jit

BLOCK = 16
"""Rays along each side of a block."""


class Blocks(NamedTuple):
    """Between which places the rays of each block of 16 x 16 have material."""

    first: Floats
    """(4,) number of the first block along x, y, z, and of all; whole numbers."""
    low: Floats
    high: Floats


@jit()
def blocks_of(field: Field, blocks: Blocks) -> None:
    """Work out the blocks of a field."""
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        across = (field.count[u] + BLOCK - 1) // BLOCK
        for iv in range(field.count[v]):
            for iu in range(field.count[u]):
                block = int(blocks.first[d]) + (iv // BLOCK) * across + iu // BLOCK
                node = field.first[d] + iv * field.count[u] + iu
                if field.low[node] <= field.high[node]:
                    blocks.low[block] = min(blocks.low[block], field.low[node])
                    while field.next[node] >= 0:
                        node = field.next[node]
                    blocks.high[block] = max(blocks.high[block], field.high[node])


@jit()
def depth_within(pieces: Floats, rho: float, z: float) -> float:
    """Distance of a point within a solid from its surface."""
    nearest = min(z - pieces[0, Z0], pieces[len(pieces) - 1, Z1] - z)
    for k in range(len(pieces)):
        if pieces[k, Z0] <= z <= pieces[k, Z1]:
            a, b, arc = pieces[k, A], pieces[k, B], pieces[k, ARC]
            if arc == 0.0:
                nearest = min(nearest, (a + b * z - rho) / math.sqrt(1.0 + b * b))
            elif rho > a:
                nearest = min(nearest, arc - math.sqrt((rho - a) ** 2 + (z - b) ** 2))
    return nearest

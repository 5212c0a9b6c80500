"""The rays of a field, seen from a lattice of points."""

from __future__ import annotations

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.cutting.dexels import Field
from toolpace.kernels.jit import jit


@jit()
def mark_inside(field: Field, columns: Ints, rows: Ints, heights: Floats, inside: Bools) -> None:
    """Which points (columns, rows, heights) are in material, by the rays along z."""
    for i in range(len(columns)):
        for j in range(len(rows)):
            node = field.first[2] + rows[j] * field.cells[0] + columns[i]
            k = 0
            while node >= 0 and field.low[node] <= field.high[node]:
                while k < len(heights) and heights[k] < field.low[node]:
                    k += 1
                while k < len(heights) and heights[k] <= field.high[node]:
                    inside[i, j, k] = True
                    k += 1
                node = field.following[node]


@jit()
def ends_between(field: Field, rays: Ints, low: Floats, high: Floats, places: Floats) -> None:
    """For rays (n,) the first end of an interval between two places; the middle of them where there is none."""
    for k in range(len(rays)):
        node = rays[k]
        places[k] = 0.5 * (low[k] + high[k])
        while node >= 0 and field.low[node] <= field.high[node]:
            if low[k] <= field.low[node] <= high[k]:
                places[k] = field.low[node]
                break
            if low[k] <= field.high[node] <= high[k]:
                places[k] = field.high[node]
                break
            node = field.following[node]

"""The surface of a stock as a closed mesh, by surface nets (Gibson, Constrained elastic surface nets, 1998).

A lattice of points stands on the rays. Where the side changes between two neighbours, the ray tells the place. Each
cube of eight points that are not all on one side gets a vertex, in the middle of these places; each pair of neighbours
on different sides gets a quadrilateral between the four cubes about it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats, Ints

if TYPE_CHECKING:
    from toolpace.kernels.cutting.dexels import Field


def triangles(field: Field, points: int) -> Floats:
    """The surface as triangles (n, 3, 3) [m], counterclockwise seen from outside; none where no material is left.

    points: of the lattice along the longest side, at most as many as the stock has cells. What is thinner than their
    distance may be missing; edges are bevelled by about half of it.
    """
    from toolpace.kernels.cutting.lattice import ends_between, mark_inside

    stride = max(math.ceil(int(field.cells.max()) / max(points, 2)), 1)
    cells = [np.arange(min(stride // 2, n - 1), n, stride) for n in field.cells]
    at = [field.origin[d] + field.step[d] * (cells[d] + 0.5) for d in range(3)]
    shape = tuple(len(each) + 2 for each in cells)
    inside = np.zeros(shape, np.bool_)
    found = np.zeros(tuple(len(each) for each in cells), np.bool_)
    mark_inside(field, cells[0], cells[1], at[2], found)
    inside[1:-1, 1:-1, 1:-1] = found
    # one layer of air about it; its points stand a cell outside
    places = [np.concatenate([[x[0] - stride * h], x, [x[-1] + stride * h]]) for x, h in zip(at, field.step)]
    cubes, corners, quads = [], [], []
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        edge = np.argwhere(np.diff(inside, axis=d))
        low, high = places[d][edge[:, d]], places[d][edge[:, d] + 1]
        rays = field.first[d] + cells[v][edge[:, v] - 1] * field.cells[u] + cells[u][edge[:, u] - 1]
        where = np.empty((len(edge), 3))
        ends = np.empty(len(edge))
        ends_between(field, rays, low, high, ends)
        where[:, d], where[:, u], where[:, v] = ends, places[u][edge[:, u]], places[v][edge[:, v]]
        about = np.repeat(edge[:, None], 4, axis=1)
        about[:, [1, 2], u] -= 1
        about[:, [2, 3], v] -= 1
        ids = np.ravel_multi_index(tuple(np.moveaxis(about, 2, 0)), shape)
        # the four cubes are counterclockwise about d, as the corners are to be where the solid ends along d
        leaves = inside[tuple(edge.T)]
        quads.append(np.where(leaves[:, None], ids, ids[:, ::-1]))
        cubes.append(ids.ravel())
        corners.append(np.repeat(where, 4, axis=0))
    return _meshed(np.concatenate(cubes), np.concatenate(corners), np.concatenate(quads))


def _meshed(cubes: Ints, corners: Floats, quads: Ints) -> Floats:
    """Triangles of quadrilaterals (n, 4) between cubes, each with its vertex in the middle of its corners."""
    names, which, counts = np.unique(cubes, return_inverse=True, return_counts=True)
    vertex = np.stack([np.bincount(which, corners[:, d], len(names)) for d in range(3)], axis=1) / counts[:, None]
    square = vertex[np.searchsorted(names, quads)]
    # split along the shorter diagonal
    first = np.linalg.norm(square[:, 0] - square[:, 2], axis=1) <= np.linalg.norm(square[:, 1] - square[:, 3], axis=1)
    square = np.where(first[:, None, None], square, np.roll(square, -1, axis=1))
    return np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])

"""The surface of a triangle mesh: joined at its vertices, its open edges, and turned outward.

A surface is closed where each edge belongs to an even number of triangles; turned alike, its edges are passed once in
each direction. Rays through it (in the three directions of the axes) then enter and leave in turn. Where a ray enters
twice, two bodies overlap: that is their union. Where it leaves what it has not entered, the surface passes through
itself inside out, or a body in it is turned inward, and nobody can tell what is meant.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError

JOIN = 1e-6
"""Vertices nearer than this part of the mesh's size are one, where those that are equal leave it open."""
RAYS = 61
"""Along each side of the grids of rays that look for what is inside out."""
THINNEST = 1e-6
"""Of the mesh's size: what is thinner is rounding."""
MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
"""Odd numbers of 64 bits that spread the bits of what they are multiplied by (those of xxHash)."""
FOLD = np.uint64(29)
"""Bits that are zero where a coordinate was of 32 bits in the file."""
PIECE = 1_000_000
"""Of corners and triangles that are worked out at once: a large mesh leaves little room for what comes between."""
PAIRS = 4_000_000
"""Of rays and triangles that are worked out at once."""


class Joined(NamedTuple):
    """Triangles that share their vertices."""

    points: Floats
    """(m, 3)"""
    faces: Ints
    """(n, 3) those that have three different vertices."""
    gap: float
    """How far joined vertices were apart; 0 where equal ones are enough for a closed surface."""
    open: Ints
    """(k, 2) ends of the edges that belong to an odd number of faces."""


def joined_vertices(corners: npt.NDArray[np.floating[Any]], scale: float = 1.0) -> Joined:
    """Triangles (k, 3, 3) by the vertices that they share, times `scale`."""
    points, faces = _joined(corners)
    points *= scale
    still_open = open_edges(faces)
    size = float((points.max(axis=0) - points.min(axis=0)).max())
    if not len(still_open) or not size > 0.0:
        return Joined(points, faces, 0.0, still_open)
    coarse, joined = _near_ones_joined(points, faces, JOIN * size)
    left = open_edges(joined)
    if len(joined) and not len(left):
        return Joined(coarse, joined, JOIN * size, left)
    return Joined(points, faces, 0.0, still_open)


def _near_ones_joined(points: Floats, faces: Ints, distance: float) -> tuple[Floats, Ints]:
    """Vertices and faces, where points (m, 3) within a distance of each other are one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    a, b = cKDTree(points).query_pairs(distance, output_type="ndarray").T
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(len(points), len(points)))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return points[first], _with_three(label.astype(np.int64)[faces])


def _joined(corners: npt.NDArray[np.floating[Any]]) -> tuple[Floats, Ints]:
    """Vertices and faces; corners (k, 3, 3) that are equal are one vertex."""
    flat = corners.reshape(-1, 3)
    # numbers of 64 bits are sorted in a fraction of the time of rows; two rows hardly ever have one number
    number = np.zeros(len(flat), dtype=np.uint64)
    for begin in range(0, len(flat), PIECE):
        # minus zero is zero
        for k in range(3):
            bits = (flat[begin : begin + PIECE, k] + 0.0).astype(np.float64).view(np.uint64)
            number[begin : begin + PIECE] ^= (bits ^ (bits >> FOLD)) * MIXERS[k]
    first, inverse = _alike(number)
    points = np.asarray(flat[first] + 0.0, dtype=np.float64)
    for begin in range(0, len(flat), PIECE):
        if (points[inverse[begin : begin + PIECE]] != flat[begin : begin + PIECE]).any():
            exact = np.ascontiguousarray(flat + 0.0, dtype=np.float64)
            _, first, inverse = np.unique(exact.view("V24").ravel(), return_index=True, return_inverse=True)
            points = exact[first]
            break
    return points, _with_three(inverse.reshape(-1, 3))


def _alike(number: npt.NDArray[np.uint64]) -> tuple[Ints, Ints]:
    """One of each of the different numbers (k,), and for every number (n,) which of the k it is: as np.unique, but by a
    faster sort, which is not stable."""
    order = np.argsort(number)
    ordered = number[order]
    fresh = np.concatenate([[True], ordered[1:] != ordered[:-1]]) if len(number) else np.zeros(0, dtype=np.bool_)
    inverse = np.empty(len(number), dtype=np.int64)
    inverse[order] = np.cumsum(fresh) - 1
    return order[fresh], inverse


def _with_three(faces: Ints) -> Ints:
    """Those faces (n, 3) that have three different vertices."""
    a, b, c = faces.T
    different: Bools = (a != b) & (b != c) & (c != a)
    return faces if different.all() else faces[different]


def _edges(faces: Ints) -> Ints:
    """(3 n,) a number for each edge of faces (n, 3), even where it goes from its lower to its higher vertex: half of it
    is that of its two ends, in either direction. Edge k of face i is number k n + i."""
    count = int(faces.max(initial=0)) + 1
    number = np.empty((3, len(faces)), dtype=np.int64)
    for k in range(3):
        start, end = faces[:, k], faces[:, (k + 1) % 3]
        number[k] = 2 * (np.minimum(start, end) * count + np.maximum(start, end)) + (start > end)
    return number.ravel()


def _even_and_alike(faces: Ints) -> tuple[bool, bool]:
    """Whether each edge of faces (n, 3) belongs to an even number of them, and is passed as often in one direction as
    in the other."""
    number = np.sort(_edges(faces))
    edge = number >> 1
    heads = np.flatnonzero(np.diff(edge, prepend=-1))
    if (np.diff(np.append(heads, len(edge))) % 2).any():
        return False, False
    sign = 1 - 2 * (number & 1).astype(np.int8)
    return True, not np.add.reduceat(sign, heads, dtype=np.int64).any() if len(heads) else True


def open_edges(faces: Ints) -> Ints:
    """Ends (k, 2) of the edges that belong to an odd number of faces (n, 3)."""
    if _even_and_alike(faces)[0]:
        return np.zeros((0, 2), dtype=np.int64)
    _, first, count = np.unique(_edges(faces) >> 1, return_index=True, return_counts=True)
    corner, face = np.divmod(first[count % 2 == 1], len(faces))
    return np.stack([faces[face, corner], faces[face, (corner + 1) % 3]], axis=1)


@dataclass(frozen=True)
class Outward:
    """Triangles (n, 3, 3) turned outward, and what was done for it."""

    triangles: Floats
    notes: list[str]


def outward(points: Floats, faces: Ints, name: str) -> Outward:
    """Turn the faces of a closed surface outward. Raises UsageError where it cannot be told what is inside."""
    notes = []
    turned = _turned_alike(faces, name)
    if turned is not faces:
        notes.append(f"{name}: triangles that were turned against their neighbours are turned back")
    volume = signed_volume(points, turned)
    size = float((points.max(axis=0) - points.min(axis=0)).max())
    if abs(volume) <= THINNEST * size**3:
        raise UsageError(f"{name}: has no volume; export a body in place of a surface")
    if volume < 0.0:
        turned = turned[:, ::-1]
        notes.append(f"{name}: was turned inside out, and is turned back")
    triangles = points[turned]
    overlap, inside_out = crossed(triangles)
    if inside_out is not None:
        at = ", ".join(f"{value * 1e3:.6g}" for value in inside_out)
        raise UsageError(
            f"{name}: passes through itself inside out at {at} mm; repair the body (union of its parts) and export it"
        )
    if overlap:
        notes.append(f"{name}: has parts that overlap, and is taken as their union")
    return Outward(triangles, notes)


def signed_volume(points: Floats, faces: Ints) -> float:
    """Of a closed surface whose faces are turned alike: above zero where they are turned outward."""
    total = 0.0
    for begin in range(0, len(faces), PIECE):
        a, b, c = (points[faces[begin : begin + PIECE, k]] - points[faces[0, 0]] for k in range(3))
        total += float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
    return total


def _turned_alike(faces: Ints, name: str) -> Ints:
    """The faces, turned so that each edge is passed as often in one direction as in the other."""
    if _even_and_alike(faces)[1]:
        return faces
    number = _edges(faces)
    order = np.argsort(number >> 1, kind="stable")
    heads = np.flatnonzero(np.diff(number[order] >> 1, prepend=-1))
    flip = _flips(len(faces), order, heads, 1 - 2 * (number & 1))
    if flip is None:
        raise UsageError(
            f"{name}: its triangles are turned against each other, and cannot all be turned alike; export it again"
        )
    return np.where(flip[:, None], faces[:, ::-1], faces)


def _flips(count: int, order: Ints, heads: Ints, sign: Ints) -> Bools | None:
    """(n,) which faces to turn, the fewer of each body; None where that cannot be told: more than two at an edge, or a
    one-sided surface.

    order: edges (3 n,) sorted by their ends; heads: the first of each; sign: the direction in which each is passed.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if (np.diff(np.append(heads, len(order))) != 2).any():
        return None
    one, other = order[heads], order[heads + 1]
    a, b, unlike = one % count, other % count, (sign[one] == sign[other]).astype(np.int64)
    # each face stands twice, as it is and turned; what goes with what is connected
    rows = np.concatenate([a, a + count])
    columns = np.concatenate([b + count * unlike, b + count * (1 - unlike)])
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(2 * count, 2 * count))
    _, label = connected_components(graph, directed=False)
    as_it_is, turned = label[:count], label[count:]
    if (as_it_is == turned).any():
        return None
    flip = as_it_is > turned
    body = np.minimum(as_it_is, turned)
    most = np.bincount(body, weights=flip) * 2.0 > np.bincount(body)
    flipped: Bools = flip ^ most[body]
    return flipped


def crossed(triangles: Floats) -> tuple[bool, Floats | None]:
    """Whether bodies overlap, and a place (3,) where a surface (n, 3, 3) is inside out; None where it is not."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    thin = THINNEST * float((high - low).max())
    overlap = False
    for d in range(3):
        pieces = range(0, len(triangles), PIECE)
        hits = [_hits(triangles[begin : begin + PIECE], d, low, high) for begin in pieces]
        ray, along, way = (np.concatenate(each) for each in zip(*hits))
        order = np.lexsort((-way, np.round(along / thin), ray))
        ray, along, depth = ray[order], along[order], np.cumsum(way[order])
        thick = (ray[1:] == ray[:-1]) & (np.diff(along) > thin)
        overlap = overlap or bool((thick & (depth[:-1] > 1)).any())
        if len(found := np.flatnonzero(thick & (depth[:-1] < 0))):
            place = np.zeros(3)
            place[d] = 0.5 * (along[found[0]] + along[found[0] + 1])
            across = [(d + 1) % 3, (d + 2) % 3]
            place[across] = _ray_places(low[across], high[across])[np.arange(2), np.divmod(ray[found[0]], RAYS)]
            return overlap, place
    return overlap, None


def _ray_places(low: Floats, high: Floats) -> Floats:
    """(2, RAYS) where rays pass, across them: beside what people's figures are likely to be."""
    share = (np.arange(RAYS) + np.array([[np.pi / 7.0], [np.e / 5.0]])) / (RAYS + 0.1)
    places: Floats = low[:, None] + (high - low)[:, None] * share
    return places


def _hits(triangles: Floats, d: int, low: Floats, high: Floats) -> tuple[Ints, Floats, Ints]:
    """Where rays along d pass triangles: number of the ray, place along it, and 1 where it enters, else -1."""
    across = [(d + 1) % 3, (d + 2) % 3]
    places = _ray_places(low[across], high[across])
    first, last = np.empty((len(triangles), 2), np.int64), np.empty((len(triangles), 2), np.int64)
    for k, axis in enumerate(across):
        a, b, c = triangles[:, :, axis].T
        first[:, k] = np.searchsorted(places[k], np.minimum(np.minimum(a, b), c))
        last[:, k] = np.searchsorted(places[k], np.maximum(np.maximum(a, b), c), side="right")
    size = np.maximum(last - first, 0)
    pairs = size[:, 0] * size[:, 1]
    met = np.flatnonzero(pairs)
    ends = np.cumsum(pairs[met])
    found: list[tuple[Ints, Floats, Ints]] = [(np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.int64))]
    begin = 0
    while begin < len(met):
        done = ends[begin - 1] if begin else 0
        end = max(int(np.searchsorted(ends, done + PAIRS, side="right")), begin + 1)
        chosen = met[begin:end]
        face = np.repeat(chosen, pairs[chosen])
        number = np.arange(len(face)) - np.repeat(ends[begin:end] - pairs[chosen] - done, pairs[chosen])
        i, j = (first[face] + np.stack(np.divmod(number, size[face, 1]), axis=1)).T
        found.append(_passed(triangles[face], d, np.stack([places[0, i], places[1, j]], axis=1), i * RAYS + j))
        begin = end
    ray, along, way = (np.concatenate(each) for each in zip(*found))
    return ray, along, way


def _passed(triangles: Floats, d: int, at: Floats, ray: Ints) -> tuple[Ints, Floats, Ints]:
    """Of pairs of a triangle (n, 3, 3) and a ray at (n, 2): those that meet, as `_hits` returns them."""
    flat = triangles[:, :, [(d + 1) % 3, (d + 2) % 3]]
    edges = [_beside(flat[:, (k + 1) % 3], flat[:, (k + 2) % 3], at) for k in range(3)]
    left = np.stack([side for side, _ in edges], axis=1)
    met = left.all(axis=1) | ~left.any(axis=1)
    weight = np.stack([value for _, value in edges], axis=1)[met]
    total = weight.sum(axis=1)
    flat_on = total == 0.0
    share = weight / np.where(flat_on, 1.0, total)[:, None]
    share[flat_on] = 1.0 / 3.0
    along = np.einsum("ij,ij->i", share, triangles[met][:, :, d])
    return ray[met], along, np.where(left[met, 0], -1, 1)


def _beside(start: Floats, end: Floats, at: Floats) -> tuple[Bools, Floats]:
    """Whether a place (n, 2) is left of an edge, and twice the area between them.

    Worked out from the lower end for both triangles at an edge, so that rounding never lets a ray slip between them.
    """
    up = (start[:, 0] < end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] < end[:, 1]))
    low, high = np.where(up[:, None], start, end), np.where(up[:, None], end, start)
    area = (high[:, 0] - low[:, 0]) * (at[:, 1] - low[:, 1]) - (high[:, 1] - low[:, 1]) * (at[:, 0] - low[:, 0])
    return np.where(up, area >= 0.0, area < 0.0), np.where(up, area, -area)


def box_triangles(low: Floats, high: Floats) -> Floats:
    """(12, 3, 3) of the box between two corners (3,), counterclockwise seen from outside."""
    # stock and finished part have the same ones, so that rays round alike where faces coincide
    corner, found = np.array([low, high]), []
    for d in range(3):
        square = np.empty((2, 4, 3))
        square[:, :, d] = corner[:, d, None]
        square[:, :, d - 2] = corner[[0, 1, 1, 0], d - 2]
        square[:, :, d - 1] = corner[[0, 0, 1, 1], d - 1]
        square[0] = square[0, ::-1]
        found += [square[:, [0, 1, 2]], square[:, [0, 2, 3]]]
    return np.concatenate(found)

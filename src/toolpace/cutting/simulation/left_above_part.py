"""What is left above the finished part: volume, and where it is how high.

cast the finished part into the rays of the stock that is left
material of each ray that is outside of the part             volume; both ends are places of its surface
distance of these places from the part                       height
neighbouring places that are too high                        a region, its volume
the highest places of a region                               height, exactly from the mesh

The height is the distance from the finished part, so that in a corner of two walls it is that from the nearer one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints

if TYPE_CHECKING:
    from toolpace.cutting.stock.dexels import DexelStock

NEIGHBOURS = 4
"""Cells within which two places are of one region, about."""
STEEP = 0.5
"""Cosine of the angle between a ray and the normal of the part: one of three directions has 0.577 at least."""
SURE = 3.0
"""Cells beyond which the nearest of the part's places on rays tells the distance within a tenth of a cell."""
HIGHEST = 4
"""Places of a region whose distance is worked out from the mesh: within a cell each may be the highest."""
MOST_REGIONS = 200
"""Regions that are told, the highest first: the volume is that of all."""
BEYOND = 10.0
"""Farther than any part is wide [m]."""


@dataclass(frozen=True, eq=False)
class LeftRegion:
    """Neighbouring material that is too high above the finished part."""

    height: float
    """The largest distance from the part [m]."""
    place: Floats
    """(3,) where that is, in the frame of the part [m]."""
    foot: Floats
    """(3,) the place of the part that is nearest to it [m]."""
    volume: float
    """[m3]"""


@dataclass(frozen=True, eq=False)
class LeftAbovePart:
    """All that is left above the finished part."""

    volume: float
    """[m3]"""
    height: float
    """The largest distance from the part [m]."""
    tolerance: float
    """Height from which a region is too high [m]."""
    regions: tuple[LeftRegion, ...]
    """The highest first."""


def left_above_part(left: DexelStock, part: Floats, tolerance: float) -> LeftAbovePart:
    """What is left of a stock above a finished part, a closed mesh (n, 3, 3) [m].

    The heights of regions are exact at their places, which are on the rays: the highest place of all is within a cell
    of one of them.
    """
    finished = left.on_same_rays(part)
    segments = outside(left.intervals(), finished.intervals())
    direction = np.searchsorted(left.field.first, segments.ray, side="right") - 1
    volumes = (segments.end - segments.begin) * (np.prod(left.field.step) / left.field.step)[direction] / 3.0
    places = left.places_on(np.tile(segments.ray, 2), np.concatenate([segments.begin, segments.end]))
    length = np.tile(segments.end - segments.begin, 2)
    # along a ray, the place at one end of a segment is so far from the part where the other end is on it
    gaps = np.where(np.concatenate([segments.part_at_end, segments.part_at_begin]), length, np.inf)
    heights = _heights(finished, places, gaps, tolerance)
    regions = _regions(places, heights, volumes, part, tolerance, left.resolution)
    low = float(heights[heights <= tolerance].max(initial=0.0))
    return LeftAbovePart(float(volumes.sum()), regions[0].height if regions else low, tolerance, regions)


class Segments(NamedTuple):
    """Parts of k rays."""

    ray: Ints
    begin: Floats
    """(k,) [m]"""
    end: Floats
    part_at_begin: Bools
    """(k,) whether the part ends there."""
    part_at_end: Bools


def outside(material: tuple[Ints, Floats, Floats], finished: tuple[Ints, Floats, Floats]) -> Segments:
    """Of intervals of material (ray, begin, end) what is in none of the finished part."""
    ray = np.concatenate([material[0], material[0], finished[0], finished[0]])
    at = np.concatenate([*material[1:], *finished[1:]])
    change = np.repeat([1, -1, -2, 2], [len(material[0])] * 2 + [len(finished[0])] * 2)
    order = np.lexsort((at, ray))
    ray, at, change = ray[order], at[order], change[order]
    # 1 in material outside of the part, below zero in the part, 0 in air
    state = np.cumsum(change)
    there = np.flatnonzero((state[:-1] == 1) & (at[1:] > at[:-1]) & (ray[1:] == ray[:-1]))
    return Segments(ray[there], at[there], at[there + 1], change[there] == 2, change[there + 1] == -2)


def _heights(finished: DexelStock, places: Floats, gaps: Floats, tolerance: float) -> Floats:
    """(k,) distances of places (k, 3) from the part [m], as the rays tell them: above edges within a cell.

    gaps: (k,) way to the part along the ray [m]; inf where it does not lead there.
    """
    from scipy.spatial import cKDTree

    heights: Floats = np.minimum(np.maximum(-finished.depths(places, BEYOND), 0.0), gaps)
    rays, begin, end = finished.intervals()
    high = np.flatnonzero(heights > tolerance)
    if not len(high) or not len(rays):
        return heights
    surface = finished.places_on(np.tile(rays, 2), np.concatenate([begin, end]))
    nearest = cKDTree(surface).query(places[high])[0]
    # the four rays about a place tell its distance from a plane; another wall may be nearer
    heights[high] = np.minimum(heights[high], nearest)
    # a ray that meets the part askew, or not at all, tells little of a thin layer, and another ray sees it better
    sure = (heights[high] >= STEEP * gaps[high]) | (nearest > SURE * finished.resolution)
    heights[high[~sure]] = 0.0
    return heights


def nearest_on_mesh(place: Floats, triangles: Floats, most: float) -> Floats:
    """The place (3,) of a mesh (n, 3, 3) that is nearest to a place (3,), not farther than about `most` [m]."""
    beyond = np.maximum(triangles.min(axis=1) - place, place - triangles.max(axis=1))
    near = triangles[np.linalg.norm(np.maximum(beyond, 0.0), axis=1) <= most]
    near = near if len(near) else triangles
    a, b, c = (near[:, k] for k in range(3))
    # on an edge, or straight below within the triangle
    found = []
    for start, end in ((a, b), (b, c), (c, a)):
        way = end - start
        share = np.einsum("ij,ij->i", place - start, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-300)
        found.append(start + np.clip(share, 0.0, 1.0)[:, None] * way)
    normal = np.cross(b - a, c - a)
    size = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    below = place - (np.einsum("ij,ij->i", place - a, normal) / size)[:, None] * normal
    sides = [
        np.einsum("ij,ij->i", np.cross(end - start, below - start), normal) for start, end in ((a, b), (b, c), (c, a))
    ]
    found.append(below[np.min(sides, axis=0) >= 0.0])
    feet = np.concatenate(found)
    foot: Floats = feet[np.argmin(np.linalg.norm(feet - place, axis=1))]
    return foot


def _regions(
    places: Floats, heights: Floats, volumes: Floats, part: Floats, tolerance: float, cell: float
) -> tuple[LeftRegion, ...]:
    """Regions of places (2 k, 3), both ends of k segments, that are too high; from their heights (2 k,) within a cell,
    and from volumes (k,) of the segments."""
    from scipy.ndimage import label

    high = np.flatnonzero(heights > tolerance)
    if not len(high):
        return ()
    low = places[high].min(axis=0)
    voxel = np.floor((places - low) / (NEIGHBOURS * cell)).astype(np.int64)
    taken = np.zeros(voxel[high].max(axis=0) + 1, dtype=np.bool_)
    taken[tuple(voxel[high].T)] = True
    labels, count = label(taken, structure=np.ones((3, 3, 3)))
    near = ((voxel >= 0) & (voxel < taken.shape)).all(axis=1)
    which = np.where(near, labels[tuple(np.where(near[:, None], voxel, 0).T)], 0)
    of_segment = np.maximum(*which.reshape(2, -1))
    sums = np.bincount(of_segment, volumes, count + 1)[1:]
    order = high[np.lexsort((-heights[high], which[high]))]
    first = np.searchsorted(which[order], np.arange(1, count + 2))
    found = []
    for k in np.argsort(-heights[order[first[:-1]]])[:MOST_REGIONS].tolist():
        tops = order[first[k] : min(first[k] + HIGHEST, first[k + 1])]
        feet = np.array([nearest_on_mesh(places[at], part, heights[at] + cell) for at in tops])
        exact = np.linalg.norm(places[tops] - feet, axis=1)
        best = int(np.argmax(exact))
        found.append(LeftRegion(float(exact[best]), places[tops[best]], feet[best], float(sums[k])))
    return tuple(sorted((each for each in found if each.height > tolerance), key=lambda region: -region.height))

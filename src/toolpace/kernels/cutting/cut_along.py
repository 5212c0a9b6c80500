"""Cutting a stock along poses, and the contact at each station before its surroundings are cut."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.contact import Arcs, Slices, contact
from toolpace.kernels.cutting.dexels import FREE_COUNT, Field
from toolpace.kernels.cutting.intrusion import Blocks, deepest
from toolpace.kernels.cutting.removal import cut_at, widest_of
from toolpace.kernels.cutting.thickest_chip import AXIS, FEED, LEFT, MOTION, TIP, TURNING
from toolpace.kernels.jit import jit

LAG = 2.0
"""Cells that cutting is behind the pose that is looked at. The rays about a point of the tool's surface are then as
they were before the tool came, and what it moves into is thick beside what rays tell."""

AT, CUT, ARCS = 0, 1, 2
"""Places of the progress: poses looked at, poses cut, arcs written."""


class Poses(NamedTuple):
    """m poses in the order of the motion."""

    tip: Floats
    axis: Floats
    travel: Floats
    """(m,) the way so far of the tool's point that moves the most."""
    station: Ints
    """(m,) the station that the pose is on the way to."""
    low: Floats
    """(m,) lowest height above the tip at which the tool may meet the stock."""
    high: Floats
    """(m,) highest one; below `low` where it cannot."""
    look: Ints
    """(m,) 1 where the pose is that of the station itself, 0 between stations."""


class Found(NamedTuple):
    """What stations are told, n of each."""

    feed: Floats
    """(n, 3) unit vectors of the feed across the axis, in."""
    last_arc: Ints
    """(n,) number of arcs up to and with this station."""
    removed: Floats
    penetration: Floats
    """(n, 2) of what is above the edge, by part."""
    width: Floats
    depth: Floats
    top: Floats
    flat: Floats
    chip_share: Floats
    """(n,) of the way of the tip, by which the surface moves outward in material at most."""


class Above(NamedTuple):
    """Solids above the edge, that cut nothing."""

    pieces: Floats
    first: Ints
    """(k + 1,) pieces of solid j are first[j] to first[j + 1]."""
    part: Ints
    """(k,) the column of `Found.penetration` that the solid belongs to."""
    blocks: Blocks
    cover: Floats
    """(1, 6) and `place` (3,): room to work in."""
    place: Floats


@jit()
def rays_met(field: Field, radius: float, axis: Floats, z0: float, z1: float) -> int:
    """At most how many rays a tool meets between two heights."""
    if z0 > z1:
        return 0
    met = 0
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        wide = int((abs(axis[u]) * (z1 - z0) + 2.0 * radius) / field.step[u]) + 2
        high = int((abs(axis[v]) * (z1 - z0) + 2.0 * radius) / field.step[v]) + 2
        met += min(wide, field.cells[u]) * min(high, field.cells[v])
    return met


@jit()
def pose_at(poses: Poses, k: int, feed: Floats, pose: Floats) -> None:
    """Write the pose k (6, 3), and the motion to it from the one before it."""
    tip, axis, before = poses.tip[k], poses.axis[k], poses.axis[k - 1]
    pose[MOTION:] = 0.0
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        left = axis[u] * feed[v] - axis[v] * feed[u]
        step, turn = tip[d] - poses.tip[k - 1, d], before[u] * axis[v] - before[v] * axis[u]
        pose[TIP, d], pose[AXIS, d], pose[FEED, d], pose[LEFT, d] = tip[d], axis[d], feed[d], left
        pose[MOTION, 0] += step * left
        pose[MOTION, 1] += step * feed[d]
        pose[MOTION, 2] += step * axis[d]
        pose[TURNING, 0] += turn * left
        pose[TURNING, 1] += turn * feed[d]


@jit()
def cut_next(field: Field, pieces: Floats, above: Above, poses: Poses, found: Found, progress: Ints) -> bool:
    """Cut at the next pose that is not, and look at what is above the edge there; False where free nodes run out."""
    k = progress[CUT]
    tip, axis, i = poses.tip[k], poses.axis[k], poses.station[k]
    low, high = poses.low[k], poses.high[k]
    if rays_met(field, widest_of(pieces), axis, low, high) > field.pool[FREE_COUNT]:
        return False
    found.removed[i] += cut_at(field, pieces, tip, axis, low, high)
    if poses.look[k] == 1:
        for j in range(len(above.part)):
            solid, part = above.pieces[above.first[j] : above.first[j + 1]], above.part[j]
            found.penetration[i, part] = deepest(
                field, above.blocks, solid, above.cover, tip, axis, found.penetration[i, part], above.place
            )
    progress[CUT] += 1
    return True


@jit()
def cut_along(
    field: Field, pieces: Floats, above: Above, slices: Slices, poses: Poses, found: Found, arcs: Arcs, progress: Ints,
    cell: float, least: float, until: int,
) -> bool:
    """Go on from `progress` to the pose `until`, and cut all where that is the end; True then.

    Returns False where room for arcs or free nodes run out. Poses are cut once the motion is `LAG` cells further.
    """
    pose, space = np.empty((6, 3)), np.empty((2, 6))
    room = 64 * len(slices.z)
    while progress[AT] < until:
        k = progress[AT]
        behind = poses.travel[k] - LAG * cell
        while progress[CUT] < k and poses.travel[progress[CUT]] <= behind:
            if not cut_next(field, pieces, above, poses, found, progress):
                return False
        if poses.look[k] == 1:
            if progress[ARCS] + room > len(arcs.slice):
                return False
            i = poses.station[k]
            low, high = poses.low[k], poses.high[k]
            if k > 0 and low <= high:
                pose_at(poses, k, found.feed[i], pose)
                (
                    progress[ARCS], found.width[i], found.depth[i], found.top[i], found.flat[i], found.chip_share[i]
                ) = contact(field, pieces, pose, slices, low, high, arcs, progress[ARCS], cell, least, space)
            found.last_arc[i] = progress[ARCS]
        progress[AT] += 1
    while until == len(poses.travel) and progress[CUT] < until:
        if not cut_next(field, pieces, above, poses, found, progress):
            return False
    return True

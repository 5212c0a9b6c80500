"""Cutting a stock along poses, and the contact at each station before its surroundings are cut."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.contact import AXIS, FEED, LEFT, MOTION, TIP, TURNING, Arcs, Slices, contact
from toolpace.kernels.cutting.dexels import FREE_COUNT, Field
from toolpace.kernels.cutting.removal import cut_at, near_box, widest_of
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
    look: Ints
    """(m,) 1 where the pose is that of the station itself, 0 between stations."""


class Found(NamedTuple):
    """What stations are told, n of each."""

    feed: Floats
    """(n, 3) unit vectors of the feed across the axis, in."""
    last_arc: Ints
    """(n,) number of arcs up to and with this station."""
    removed: Floats
    width: Floats
    depth: Floats
    flat: Floats


@jit()
def rays_met(field: Field, pieces: Floats, tip: Floats, axis: Floats) -> int:
    """At most how many rays a tool meets at a pose."""
    radius = widest_of(pieces)
    z0, z1 = near_box(field, pieces, tip, axis, radius)
    if z0 > z1:
        return 0
    met = 0
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        wide = int((abs(axis[u]) * (z1 - z0) + 2.0 * radius) / field.step[u]) + 2
        high = int((abs(axis[v]) * (z1 - z0) + 2.0 * radius) / field.step[v]) + 2
        met += min(wide, field.count[u]) * min(high, field.count[v])
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
def cut_along(
    field: Field, pieces: Floats, slices: Slices, poses: Poses, found: Found, arcs: Arcs, progress: Ints,
    cell: float, least: float, last: int,
) -> bool:
    """Go on along the poses from `progress`, to the end where it returns True.

    Returns False where room for arcs or free nodes run out. Poses are cut once the motion is `LAG` cells further;
    with `last`, all.
    """
    pose = np.empty((6, 3))
    radius = widest_of(pieces)
    room = 64 * len(slices.z)
    while progress[AT] < len(poses.travel):
        k = progress[AT]
        behind = poses.travel[k] - LAG * cell
        while progress[CUT] < k and poses.travel[progress[CUT]] <= behind:
            c = progress[CUT]
            if rays_met(field, pieces, poses.tip[c], poses.axis[c]) > field.pool[FREE_COUNT]:
                return False
            found.removed[poses.station[c]] += cut_at(field, pieces, poses.tip[c], poses.axis[c])
            progress[CUT] += 1
        if poses.look[k] == 1:
            if progress[ARCS] + room > len(arcs.slice):
                return False
            i = poses.station[k]
            low, high = near_box(field, pieces, poses.tip[k], poses.axis[k], radius)
            if k > 0 and low <= high:
                pose_at(poses, k, found.feed[i], pose)
                progress[ARCS], found.width[i], found.depth[i], found.flat[i] = contact(
                    field, pose, slices, low, high, arcs, progress[ARCS], cell, least
                )
            found.last_arc[i] = progress[ARCS]
        progress[AT] += 1
    while last == 1 and progress[CUT] < len(poses.travel):
        c = progress[CUT]
        if rays_met(field, pieces, poses.tip[c], poses.axis[c]) > field.pool[FREE_COUNT]:
            return False
        found.removed[poses.station[c]] += cut_at(field, pieces, poses.tip[c], poses.axis[c])
        progress[CUT] += 1
    return True

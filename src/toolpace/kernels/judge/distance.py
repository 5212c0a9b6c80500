"""Where a row of poses lies along a polyline of poses, both in order: a walk that never looks back far.

A pose is six numbers: the tip divided by the tip tolerance, then the tool axis divided by the axis tolerance.
A distance of 1 is therefore the tolerance, in either half, and the length along the polyline (`place`) counts
turning like travel, so that a rotation in place has length.
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

SLACK = 3.0
"""How far back along the polyline a pose may be matched from the furthest match so far [tolerances]."""
AHEAD = 2.0
"""How far beyond the first near enough place a nearer one is looked for: two tolerances span the ball of
radius 1."""


@jit()
def _near(pose: Floats, a: Floats, b: Floats, bend: Floats, least: float, weight: float) -> tuple[float, float, float]:
    """The place u in [least, 1] on the way from a to b nearest to the pose, and the tip and axis distances
    there.

    The way is the chord less u (1 - u) / 2 times `bend`, the second difference of the row that a and b come
    from. `weight` is that of the axis; a negative one asks for the distances at u = `least`.
    """
    u = least
    if weight >= 0.0:
        square = 0.0
        along = 0.0
        for i in range(6):
            w = 1.0 if i < 3 else weight
            d = b[i] - a[i]
            square += w * d * d
            along += w * d * (pose[i] - a[i])
        u = along / square if square > 0.0 else 1.0
        u = min(max(u, least), 1.0)
    tip = 0.0
    axis = 0.0
    for i in range(6):
        d = pose[i] - a[i] - u * (b[i] - a[i]) + 0.5 * u * (1.0 - u) * bend[i]
        if i < 3:
            tip += d * d
        else:
            axis += d * d
    return u, math.sqrt(tip), math.sqrt(axis)


@jit()
def _nearest(pose: Floats, a: Floats, b: Floats, bend: Floats, least: float) -> tuple[float, float, float]:
    """Nearest by the tip where the axis is then near enough too; else where the larger of the two is least.

    Both distances are convex along a straight way, so that their maximum has one minimum, between the place
    nearest by the tip and the one nearest by the axis.
    """
    u, tip, axis = _near(pose, a, b, bend, least, 0.01)
    if max(tip, axis) <= 1.0:
        return u, tip, axis
    v, tip_v, axis_v = _near(pose, a, b, bend, least, 100.0)
    if max(tip_v, axis_v) < max(tip, axis):
        u, tip, axis, v = v, tip_v, axis_v, u
    if max(tip, axis) > 8.0:
        return u, tip, axis
    low, high = min(u, v), max(u, v)
    for _ in range(24):
        third = (high - low) / 3.0
        if third < 1e-9:
            break
        left, tip_l, axis_l = _near(pose, a, b, bend, low + third, -1.0)
        right, tip_r, axis_r = _near(pose, a, b, bend, high - third, -1.0)
        if max(tip_l, axis_l) < max(tip_r, axis_r):
            high = right
            if max(tip_l, axis_l) < max(tip, axis):
                u, tip, axis = left, tip_l, axis_l
        else:
            low = left
            if max(tip_r, axis_r) < max(tip, axis):
                u, tip, axis = right, tip_r, axis_r
    return u, tip, axis


@jit()
def match(
    poses: Floats,
    line: Floats,
    bends: Floats,
    place: Floats,
    segment: Ints,
    fraction: Floats,
    tip_distance: Floats,
    axis_distance: Floats,
) -> int:
    """Match poses (n, 6) in order to a polyline (m, 6) with bends (m - 1, 6) and running length `place` (m,).

    Writes, for each pose, the segment, the fraction of it, and the two distances [tolerances]. Returns the
    number of poses that found no place within 1. Time is linear in n + m as long as the two belong together,
    and bounded by a multiple of it where they do not.
    """
    n, last = len(poses), len(line) - 2
    top = 0.0
    start = 0
    lost = 0
    budget = 20 * (n + last + 2)
    for k in range(n):
        step = 0.0
        if k > 0:
            for i in range(6):
                step += (poses[k, i] - poses[k - 1, i]) ** 2
            step = math.sqrt(step)
        low = max(top - SLACK, 0.0)
        limit = top + 10.0 * step + 10.0
        while start < last and place[start + 1] < low:
            start += 1
        best = np.inf
        best_segment, best_u, best_tip, best_axis = start, 0.0, np.inf, np.inf
        found = False
        j = start
        while j <= last:
            if place[j] > limit:
                # Nothing near enough in the stretch that the step can reach. A small miss is a deviation
                # here; a large one means that a part was left out: look further ahead.
                if found or best <= 20.0 or budget <= 0:
                    break
                budget -= 1
            length = place[j + 1] - place[j]
            least = (low - place[j]) / length if low > place[j] and length > 0.0 else 0.0
            u, tip, axis = _nearest(poses[k], line[j], line[j + 1], bends[j], min(least, 1.0))
            worse = max(tip, axis)
            if worse < best:
                best, best_segment, best_u, best_tip, best_axis = worse, j, u, tip, axis
            if worse <= 1.0 and not found:
                found = True
                limit = place[j] + u * length + AHEAD
            j += 1
            if worse > 4.0:
                # Distance changes no faster than place: this much of the polyline cannot be near.
                beyond = place[j] + 0.5 * (worse - 1.0)
                while j < last and place[j + 1] < beyond and place[j + 1] <= limit:
                    j += 1
        segment[k], fraction[k] = best_segment, best_u
        tip_distance[k], axis_distance[k] = best_tip, best_axis
        if not found:
            lost += 1
        top = max(top, place[best_segment] + best_u * (place[best_segment + 1] - place[best_segment]))
    return lost


@jit()
def largest_between(low: Floats, high: Floats, place: Floats, value: Floats, out: Floats) -> None:
    """The largest value (m,) of the segments that touch [low_k, high_k]; segment j spans place[j] to place[j
    + 1]."""
    start = 0
    for k in range(len(low)):
        while start > 0 and place[start] >= low[k]:
            start -= 1
        while start < len(value) - 1 and place[start + 1] < low[k]:
            start += 1
        most = value[start]
        j = start + 1
        while j < len(value) and place[j] <= high[k]:
            most = max(most, value[j])
            j += 1
        out[k] = most


@jit()
def thinned(row: Floats, spacing: float, out: Ints) -> int:
    """Indices of a part of a row (n, 6) that moves on by `spacing` each, and both ends; returns how many.

    A pose left out lies within `spacing` of its kept predecessor; a kept pose is followed by its successor
    at once where that is further away than `spacing`, so that a coarse row is kept whole.
    """
    count = 1
    out[0] = 0
    for k in range(1, len(row)):
        square = 0.0
        for i in range(6):
            square += (row[k, i] - row[out[count - 1], i]) ** 2
        if square >= spacing * spacing or k == len(row) - 1:
            out[count] = k
            count += 1
    return count

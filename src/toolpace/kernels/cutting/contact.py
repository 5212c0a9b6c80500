"""Where the surface of a tool moves into material: the arcs of its slices, and the flat of its end.

A point of the surface is at height z of the axis, at the radius r(z), in the direction cos(phi) left + sin(phi) feed
from the axis. Between two poses it moves by the motion of the tip and the turning of the axis; where it moves outward,
material that is there is cut.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.dexels import Field, depth_at
from toolpace.kernels.jit import jit

TURN = 2.0 * math.pi
HALVINGS = 7
LEAST_CHIP = 1e-3
"""Of the motion of the tip: where the surface moves outward by less, it slides."""
MOST_SAMPLES = 720
"""Of a slice."""


class Slices(NamedTuple):
    """The tool's surface by slices along the axis, at their middles; and its flat end."""

    z: Floats
    radius: Floats
    across: Floats
    """Of the outward normal, across the axis."""
    along: Floats
    """Of the outward normal, along the axis."""
    flat: float
    """Radius of the flat end; 0: none."""
    height: float


class Pose(NamedTuple):
    """A pose of the tool, and the motion to it."""

    tip: Floats
    axis: Floats
    feed: Floats
    left: Floats
    motion: Floats
    """(3,) of the tip along left, feed and axis."""
    turning: Floats
    """(2,) turning of the axis [rad] about left and feed."""


class Arcs(NamedTuple):
    """Room for arcs."""

    slice: Ints
    entry: Floats
    exit: Floats


@jit()
def depth_on(field: Field, pose: Pose, z: float, radius: float, phi: float, most: float) -> float:
    """Depth in material of a point of the tool."""
    a, b = radius * math.cos(phi), radius * math.sin(phi)
    return depth_at(
        field,
        pose.tip[0] + z * pose.axis[0] + a * pose.left[0] + b * pose.feed[0],
        pose.tip[1] + z * pose.axis[1] + a * pose.left[1] + b * pose.feed[1],
        pose.tip[2] + z * pose.axis[2] + a * pose.left[2] + b * pose.feed[2],
        most,
    )


@jit()
def outward(pose: Pose, z: float, radius: float, across: float, along: float) -> tuple[float, float]:
    """Between which angles a slice moves outward; the second is not above the first where it does not."""
    lever = z * across - radius * along
    constant = along * pose.motion[2]
    cosine = across * pose.motion[0] - lever * pose.turning[1]
    sine = across * pose.motion[1] - lever * pose.turning[0]
    size = math.sqrt(cosine * cosine + sine * sine)
    total = abs(pose.motion[0]) + abs(pose.motion[1]) + abs(pose.motion[2])
    total += z * (abs(pose.turning[0]) + abs(pose.turning[1]))
    if constant + size <= LEAST_CHIP * total or total == 0.0:
        return 0.0, 0.0
    if constant >= size:
        return 0.0, TURN
    middle, half = math.atan2(sine, cosine), math.acos(-constant / size)
    return middle - half, middle + half


@jit()
def border(
    field: Field, pose: Pose, z: float, radius: float, inside: float, outside: float, most: float
) -> float:
    """The angle between one in material and one outside at which the depth is zero."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        if depth_on(field, pose, z, radius, middle, most) > 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


@jit()
def slice_arcs(
    field: Field, pose: Pose, slices: Slices, j: int, arcs: Arcs, count: int, cell: float, least: float
) -> tuple[int, float]:
    """Write the arcs of a slice behind the first `count`: how many there are then, and the angle of the deepest place
    (nan: there is none). Arcs nowhere deeper than `least` are left out."""
    z, radius = slices.z[j], slices.radius[j]
    begin, end = outward(pose, z, radius, slices.across[j], slices.along[j])
    best, deepest = math.nan, least
    if end <= begin:
        return count, best
    samples = min(max(int(math.ceil(radius * (end - begin) / cell)), 12), MOST_SAMPLES)
    width, most = (end - begin) / samples, 2.0 * cell
    whole = end - begin >= TURN
    first = count
    entry, top, before = math.nan, -most, begin
    for k in range(samples):
        phi = begin + (k + 0.5) * width
        depth = depth_on(field, pose, z, radius, phi, most)
        if depth > deepest:
            best, deepest = phi, depth
        if depth > 0.0:
            if math.isnan(entry):
                entry = begin if k == 0 else border(field, pose, z, radius, phi, before, most)
                top = depth
            top = max(top, depth)
        elif not math.isnan(entry):
            if top > least and count < len(arcs.slice):
                arcs.slice[count], arcs.entry[count] = j, entry
                arcs.exit[count] = border(field, pose, z, radius, before, phi, most)
                count += 1
            entry = math.nan
        before = phi
    if not math.isnan(entry) and top > least and count < len(arcs.slice):
        arcs.slice[count], arcs.entry[count], arcs.exit[count] = j, entry, end
        count += 1
        # of a whole turn, the last arc goes on as the first
        if whole and count - first > 1 and arcs.entry[first] == begin:
            arcs.entry[first] = arcs.entry[count - 1] - TURN
            count -= 1
    for k in range(first, count):
        turns = math.floor(arcs.entry[k] / TURN) * TURN
        arcs.entry[k] -= turns
        arcs.exit[k] = min(arcs.exit[k] - turns, arcs.entry[k] + TURN)
    return count, best


@jit()
def flat_share(field: Field, pose: Pose, radius: float, cell: float, least: float) -> float:
    """The share of the flat end, by area, that moves into material."""
    rings = min(max(int(math.ceil(radius / cell)), 2), 24)
    found = 0.0
    for ring in range(rings):
        r = radius * (ring + 0.5) / rings
        samples = min(max(int(math.ceil(TURN * r / cell)), 6), 96)
        inside = 0
        for k in range(samples):
            phi = TURN * (k + 0.5) / samples
            # turning about left moves what is ahead downwards, turning about the feed what is on the left upwards
            down = -pose.motion[2] + r * (pose.turning[0] * math.sin(phi) - pose.turning[1] * math.cos(phi))
            if down > LEAST_CHIP * (abs(pose.motion[0]) + abs(pose.motion[1])):
                inside += depth_on(field, pose, 0.0, r, phi, 2.0 * cell) > least
        found += (2 * ring + 1) * inside / samples
    return found / (rings * rings)


@jit()
def height_of_border(
    field: Field, pose: Pose, slices: Slices, j: int, k: int, phi: float, most: float
) -> float:
    """The height between slice j, in material at an angle, and slice k beside it, not in it there, of the border."""
    inside, outside = 0.0, 1.0
    for _ in range(HALVINGS):
        share = 0.5 * (inside + outside)
        z = slices.z[j] + share * (slices.z[k] - slices.z[j])
        radius = slices.radius[j] + share * (slices.radius[k] - slices.radius[j])
        if depth_on(field, pose, z, radius, phi, most) > 0.0:
            inside = share
        else:
            outside = share
    return slices.z[j] + 0.5 * (inside + outside) * (slices.z[k] - slices.z[j])


@jit()
def near_slice(field: Field, pose: Pose, z: float, radius: float) -> bool:
    """Whether a slice may be within the box of the stock."""
    for d in range(3):
        middle = pose.tip[d] + z * pose.axis[d]
        if middle + radius < field.origin[d]:
            return False
        if middle - radius > field.origin[d] + field.step[d] * field.count[d]:
            return False
    return True


@jit()
def contact(
    field: Field, pose: Pose, slices: Slices, arcs: Arcs, count: int, cell: float, least: float
) -> tuple[int, float, float, float]:
    """Write the arcs of a pose: how many there are then; width, depth, and the share of the flat end."""
    last, most = len(slices.z) - 1, 2.0 * cell
    lowest, highest = -1, -1
    low_phi, high_phi = 0.0, 0.0
    width = 0.0
    for j in range(last + 1):
        if not near_slice(field, pose, slices.z[j], slices.radius[j]):
            continue
        first = count
        count, phi = slice_arcs(field, pose, slices, j, arcs, count, cell, least)
        if count > first:
            if lowest < 0:
                lowest, low_phi = j, phi
            highest, high_phi = j, phi
            left, right = -2.0, 2.0
            for k in range(first, count):
                a, b = arcs.entry[k], arcs.exit[k]
                left, right = max(left, math.cos(a), math.cos(b)), min(right, math.cos(a), math.cos(b))
                if a <= math.pi <= b or b >= 3.0 * math.pi:
                    right = -1.0
                if b >= TURN:
                    left = 1.0
            width = max(width, slices.radius[j] * (left - right))
    depth = 0.0
    if lowest >= 0:
        low, high = slices.z[lowest] - 0.5 * slices.height, slices.z[highest] + 0.5 * slices.height
        if lowest > 0:
            low = height_of_border(field, pose, slices, lowest, lowest - 1, low_phi, most)
        if highest < last:
            high = height_of_border(field, pose, slices, highest, highest + 1, high_phi, most)
        depth = high - low
    flat = flat_share(field, pose, slices.flat, cell, least) if slices.flat > 0.0 else 0.0
    return count, width, depth, flat

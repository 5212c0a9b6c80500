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
TIP, AXIS, FEED, LEFT, MOTION, TURNING = 0, 1, 2, 3, 4, 5
"""Rows of a pose (6, 3): of the tool, and of the motion to it along left, feed and axis: of the tip, and the turning of
the axis [rad] about left and feed. One array: a record of arrays costs time at each call."""
LEAST_CHIP = 1e-3
"""Of the motion of the tip: where the surface moves outward by less, it slides."""
LEAST_SAMPLES, MOST_SAMPLES = 12, 720
"""Of the part of a slice that moves outward."""
APART = 2.0
"""Cells between two places that are looked at, at least: a contact that is narrower may not be seen."""
FAR = 3.0
"""Cells beyond which depths are cut off."""
FULL = 1.0 - 1e-9
"""Share of the radius from which a cut reaches the side of the tool."""
SURE = 0.5
"""Share of a depth within which there is no border."""
EDGE = 0.5
"""Slices by which a corner is taken to be higher than it is seen: rays see an edge of the stock half a cell too low."""
ABOVE = 1.5
"""Slices above the last arc within which its ends are thought to meet."""


class Slices(NamedTuple):
    """The tool's surface by slices along the axis, at their middles; and its flat end."""

    z: Floats
    radius: Floats
    across: Floats
    """Of the outward normal, across the axis."""
    along: Floats
    """Of the outward normal, along the axis."""
    next_radius: Floats
    """In the middle of the next slice."""
    flat: float
    """Radius of the flat end; 0: none."""
    height: float


class Arcs(NamedTuple):
    """Room for arcs."""

    slice: Ints
    entry: Floats
    exit: Floats


@jit(inline=True)
def depth_on(
    field: Field, pose: Floats, z: float, radius: float, phi: float, most: float, ahead: int
) -> tuple[float, int]:
    """Depth in material of a point of the tool, and the direction that counted; see `depth_at`."""
    a, b = radius * math.cos(phi), radius * math.sin(phi)
    return depth_at(
        field,
        pose[TIP, 0] + z * pose[AXIS, 0] + a * pose[LEFT, 0] + b * pose[FEED, 0],
        pose[TIP, 1] + z * pose[AXIS, 1] + a * pose[LEFT, 1] + b * pose[FEED, 1],
        pose[TIP, 2] + z * pose[AXIS, 2] + a * pose[LEFT, 2] + b * pose[FEED, 2],
        most,
        ahead,
    )


@jit(inline=True)
def motion_outward(pose: Floats, z: float, radius: float, across: float, along: float) -> tuple[float, float, float]:
    """How far the surface of a slice moves outward: a constant, and what goes with cosine and sine of the angle."""
    lever = z * across - radius * along
    cosine = across * pose[MOTION, 0] - lever * pose[TURNING, 1]
    sine = across * pose[MOTION, 1] + lever * pose[TURNING, 0]
    return along * pose[MOTION, 2], cosine, sine


@jit()
def outward(pose: Floats, z: float, radius: float, across: float, along: float) -> tuple[float, float]:
    """Between which angles a slice moves outward; the second is not above the first where it does not."""
    constant, cosine, sine = motion_outward(pose, z, radius, across, along)
    size = math.sqrt(cosine * cosine + sine * sine)
    total = abs(pose[MOTION, 0]) + abs(pose[MOTION, 1]) + abs(pose[MOTION, 2])
    total += z * (abs(pose[TURNING, 0]) + abs(pose[TURNING, 1]))
    if constant + size <= LEAST_CHIP * total or total == 0.0:
        return 0.0, 0.0
    if constant >= size:
        return 0.0, TURN
    middle, half = math.atan2(sine, cosine), math.acos(-constant / size)
    return middle - half, middle + half


@jit()
def farthest_outward(pose: Floats, slices: Slices, j: int, entry: float, leave: float) -> tuple[float, float]:
    """The angle of an arc of slice j at which the surface moves outward the farthest, and how far."""
    constant, cosine, sine = motion_outward(pose, slices.z[j], slices.radius[j], slices.across[j], slices.along[j])
    crest = math.atan2(sine, cosine)
    crest += TURN * round((0.5 * (entry + leave) - crest) / TURN)
    phi = min(max(crest, entry), leave)
    return phi, constant + cosine * math.cos(phi) + sine * math.sin(phi)


@jit()
def height_of_border(
    field: Field, pose: Floats, slices: Slices, j: int, k: int, phi: float, most: float
) -> float:
    """The height between slice j, in material at an angle, and slice k beside it, not in it there, of the border."""
    inside, outside, ahead = 0.0, 1.0, 0
    for _ in range(HALVINGS):
        share = 0.5 * (inside + outside)
        z = slices.z[j] + share * (slices.z[k] - slices.z[j])
        radius = slices.radius[j] + share * (slices.radius[k] - slices.radius[j])
        depth, ahead = depth_on(field, pose, z, radius, phi, most, ahead)
        if depth > 0.0:
            inside = share
        else:
            outside = share
    height: float = slices.z[j] + 0.5 * (inside + outside) * (slices.z[k] - slices.z[j])
    return height


@jit()
def outward_up_to_border(
    field: Field, pose: Floats, slices: Slices, j: int, phi: float, far: float, most: float
) -> float:
    """How far the surface moves outward at an angle of slice j, or between it and one beside it, up to where material
    ends: of a ball the thickest chip is at the upper border of its cut, which is seldom the middle of a slice."""
    for k in range(max(j - 1, 0), min(j + 1, len(slices.z) - 1) + 1):
        if k == j:
            continue
        beside = farthest_outward(pose, slices, k, phi, phi)[1]
        if beside > far:
            border = height_of_border(field, pose, slices, j, k, phi, most)
            here = farthest_outward(pose, slices, j, phi, phi)[1]
            far = max(far, here + (border - slices.z[j]) / (slices.z[k] - slices.z[j]) * (beside - here))
    return far


@jit()
def border(
    field: Field, pose: Floats, z: float, radius: float, inside: float, outside: float, most: float, ahead: int
) -> float:
    """The angle between one in material and one outside at which the depth is zero."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        depth, ahead = depth_on(field, pose, z, radius, middle, most, ahead)
        if depth > 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


@jit()
def slice_arcs(
    field: Field, pose: Floats, slices: Slices, j: int, arcs: Arcs, count: int, cell: float, least: float
) -> tuple[int, float]:
    """Write the arcs of a slice behind the first `count`: how many there are then, and the angle of the deepest place
    (nan: there is none). Arcs nowhere deeper than `least` are left out."""
    z, radius = slices.z[j], slices.radius[j]
    begin, end = outward(pose, z, radius, slices.across[j], slices.along[j])
    best, deepest = math.nan, least
    if end <= begin:
        return count, best
    shortest = min(max(APART * cell / max(radius, cell), (end - begin) / MOST_SAMPLES), (end - begin) / LEAST_SAMPLES)
    whole, most = end - begin >= TURN, FAR * cell
    first = count
    entry, top, before = math.nan, -most, begin
    phi, ahead = begin + 0.5 * shortest, 0
    while phi < end:
        depth, ahead = depth_on(field, pose, z, radius, phi, most, ahead)
        if depth > deepest:
            best, deepest = phi, depth
        if depth > 0.0:
            if math.isnan(entry):
                entry = begin if before == begin else border(field, pose, z, radius, phi, before, most, ahead)
                top = depth
            top = max(top, depth)
        elif not math.isnan(entry):
            if top > least and count < len(arcs.slice):
                arcs.slice[count], arcs.entry[count] = j, entry
                arcs.exit[count] = border(field, pose, z, radius, before, phi, most, ahead)
                count += 1
            entry = math.nan
        before = phi
        # no border is nearer than the depth; near edges the depth is not that sure
        phi += max(shortest, SURE * abs(depth) / max(radius, cell))
    if not math.isnan(entry) and top > least and count < len(arcs.slice):
        arcs.slice[count], arcs.entry[count], arcs.exit[count] = j, entry, end
        count += 1
        # of a whole turn, the last arc goes on as the first
        if whole and count - first > 1 and arcs.entry[first] == begin:
            arcs.entry[first] = arcs.entry[count - 1] - TURN
            count -= 1
    for k in range(first, count):
        # what is below zero by rounding is zero
        turns = math.floor(arcs.entry[k] / TURN + 1e-12) * TURN
        arcs.entry[k] = max(arcs.entry[k] - turns, 0.0)
        arcs.exit[k] = min(arcs.exit[k] - turns, arcs.entry[k] + TURN)
    return count, best


@jit()
def flat_contact(
    field: Field, pose: Floats, radius: float, cell: float, least: float
) -> tuple[float, float, float]:
    """The share of the flat end, by area, that moves into material, and how far that reaches to the left of the axis
    and to the right of it (below zero)."""
    rings = min(max(math.ceil(radius / cell), 2), 24)
    found, left, right, ahead = 0.0, -radius, radius, 0
    if -pose[MOTION, 2] + radius * (abs(pose[TURNING, 0]) + abs(pose[TURNING, 1])) <= 0.0:
        return found, left, right
    for ring in range(rings):
        r = radius * (ring + 0.5) / rings
        samples = min(max(math.ceil(TURN * r / cell), 6), 96)
        inside = 0
        for k in range(samples):
            phi = TURN * (k + 0.5) / samples
            # turning about left moves what is ahead downwards, turning about the feed what is on the left upwards
            down = -pose[MOTION, 2] + r * (pose[TURNING, 0] * math.sin(phi) - pose[TURNING, 1] * math.cos(phi))
            if down > LEAST_CHIP * (abs(pose[MOTION, 0]) + abs(pose[MOTION, 1])):
                depth, ahead = depth_on(field, pose, 0.0, r, phi, FAR * cell, ahead)
                if depth > least:
                    inside += 1
                    reach = (r + 0.5 * radius / rings) * math.cos(phi)
                    left, right = max(left, reach), min(right, reach)
        found += (2 * ring + 1) * inside / samples
    return found / (rings * rings), left, right


@jit()
def arc_holding(arcs: Arcs, first: int, count: int, j: int, phi: float) -> int:
    """The arc of slice j that holds an angle, from the first of a pose; -1: there is none."""
    for k in range(first, count):
        if arcs.slice[k] == j and (phi - arcs.entry[k]) % TURN <= arcs.exit[k] - arcs.entry[k]:
            return k
    return -1


@jit()
def end_near(arcs: Arcs, k: int, is_entry: bool, phi: float) -> float:
    """Where an arc begins or ends, in the turn that is the nearest to an angle."""
    end: float = arcs.entry[k] if is_entry else arcs.exit[k]
    return end + TURN * round((phi - end) / TURN)


@jit()
def outward_at_corner(
    field: Field, pose: Floats, slices: Slices, arcs: Arcs, first: int, count: int, top: int, most: float
) -> float:
    """How far the surface moves outward where an end of the uppermost arc, continued, meets the upper border of the
    cut; 0 where they do not meet near.

    At an edge of the stock, where one surface ends at another, the thickest chip of a ball is in that corner. The end
    is continued from the arc below, the upper border from two places within the arc.
    """
    j, far, width = arcs.slice[top], 0.0, arcs.exit[top] - arcs.entry[top]
    middle = 0.5 * (arcs.entry[top] + arcs.exit[top])
    below = arc_holding(arcs, first, count, j - 1, middle)
    if below < 0 or j + 1 == len(slices.z) or arc_holding(arcs, first, count, j + 1, middle) >= 0:
        return far
    for is_entry in (True, False):
        end = arcs.entry[top] if is_entry else arcs.exit[top]
        lean = end - end_near(arcs, below, is_entry, end)
        inward = 0.25 * width if is_entry else -0.25 * width
        near = (height_of_border(field, pose, slices, j, j + 1, end + inward, most) - slices.z[j]) / slices.height
        away = (height_of_border(field, pose, slices, j, j + 1, end + 2.0 * inward, most) - slices.z[j]) / slices.height
        rise = (away - near) / inward
        meets = 1.0 - rise * lean
        if meets <= 0.0:
            continue
        x = (near - rise * inward) / meets
        if 0.0 <= x <= ABOVE:
            x += EDGE
            phi = end + x * lean
            here = farthest_outward(pose, slices, j, phi, phi)[1]
            far = max(far, here + x * (farthest_outward(pose, slices, j + 1, phi, phi)[1] - here))
    return far


@jit()
def outward_at_bend(pose: Floats, slices: Slices, arcs: Arcs, first: int, count: int, low: int) -> float:
    """How far the surface moves outward where an end of an arc and that of the arc above it are on two borders that
    meet between both; 0 where they do not.

    Each border is continued straight: from the arc below this one, and from the one above the next.
    """
    j, far = arcs.slice[low], 0.0
    below = arc_holding(arcs, first, count, j - 1, 0.5 * (arcs.entry[low] + arcs.exit[low]))
    if below < 0:
        return far
    for high in range(first, count):
        middle = 0.5 * (arcs.entry[high] + arcs.exit[high])
        if arcs.slice[high] != j + 1 or arc_holding(arcs, first, count, j, middle) != low:
            continue
        for above in range(first, count):
            middle = 0.5 * (arcs.entry[above] + arcs.exit[above])
            if arcs.slice[above] != j + 2 or arc_holding(arcs, first, count, j + 1, middle) != high:
                continue
            for is_entry in (True, False):
                end = arcs.entry[low] if is_entry else arcs.exit[low]
                rises = end - end_near(arcs, below, is_entry, end)
                upper = end_near(arcs, high, is_entry, end)
                falls = upper - end_near(arcs, above, is_entry, end)
                x = (upper + falls - end) / (rises + falls) if rises + falls != 0.0 else -1.0
                if 0.0 <= x <= 1.0:
                    phi = end + x * rises
                    here = farthest_outward(pose, slices, j, phi, phi)[1]
                    far = max(far, here + x * (farthest_outward(pose, slices, j + 1, phi, phi)[1] - here))
    return far


@jit()
def contact(
    field: Field, pose: Floats, slices: Slices, low: float, high: float, arcs: Arcs, count: int, cell: float,
    least: float,
) -> tuple[int, float, float, float, float]:
    """Write the arcs of a pose between two heights: how many there are then; width, depth, share of the flat end, and
    how far its surface moves outward in material at most, over the way of the tip."""
    last, most = len(slices.z) - 1, FAR * cell
    lowest, highest = -1, -1
    low_phi, high_phi = 0.0, 0.0
    # of the highest slice so far: width in its middle, and by how much it is wider in the middle of the next one
    width, middle, growth = 0.0, 0.0, 0.0
    # where the surface moves outward the farthest
    farthest, steepest, steepest_phi, begin = 0.0, -1, 0.0, count
    bottom = max(int(low / slices.height - 0.5), 0)
    for j in range(bottom, min(int(high / slices.height + 0.5), last) + 1):
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
                angle, far = farthest_outward(pose, slices, j, a, b)
                if far > farthest:
                    farthest, steepest, steepest_phi = far, k, angle
            middle = slices.radius[j] * (left - right)
            width = max(width, middle)
            # where it reaches the side of the tool, it grows with the tool
            sides = (1.0 if left > FULL else 0.0) + (1.0 if right < -FULL else 0.0)
            growth = max(slices.next_radius[j] - slices.radius[j], 0.0) * sides
    depth = 0.0
    if lowest >= 0:
        low, high = slices.z[lowest] - 0.5 * slices.height, slices.z[highest] + 0.5 * slices.height
        if lowest > 0:
            low = height_of_border(field, pose, slices, lowest, lowest - 1, low_phi, most)
        if highest < last:
            high = height_of_border(field, pose, slices, highest, highest + 1, high_phi, most)
        depth = high - low
        share = (high - slices.z[highest]) / slices.height
        width = max(width, middle + growth * min(max(share, 0.0), 1.0))
    flat = 0.0
    if slices.flat > 0.0:
        flat, left, right = flat_contact(field, pose, slices.flat, cell, least)
        width = max(width, left - right)
    step = math.sqrt(pose[MOTION, 0] ** 2 + pose[MOTION, 1] ** 2 + pose[MOTION, 2] ** 2)
    if steepest < 0 or step == 0.0:
        return count, width, depth, flat, 0.0
    j = arcs.slice[steepest]
    farthest = outward_up_to_border(field, pose, slices, j, steepest_phi, farthest, most)
    # only where the tool widens upwards more is taken there
    if j > 1 and slices.across[j - 1] < slices.across[j]:
        farthest = max(farthest, outward_at_corner(field, pose, slices, arcs, begin, count, steepest, most))
        farthest = max(farthest, outward_at_bend(pose, slices, arcs, begin, count, steepest))
        lower = arc_holding(arcs, begin, count, j - 1, 0.5 * (arcs.entry[steepest] + arcs.exit[steepest]))
        if lower >= 0:
            farthest = max(farthest, outward_at_bend(pose, slices, arcs, begin, count, lower))
    return count, width, depth, flat, farthest / step

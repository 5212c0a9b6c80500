"""Where the surface of a tool moves into material: the arcs of its slices, and the flat of its end.

A point of the surface is at height z of the axis, at the radius r(z), in the direction cos(phi) left + sin(phi) feed
from the axis. Between two poses it moves by the motion of the tip and the turning of the axis; where it moves outward,
material that is there is cut.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.dexels import UNKNOWN, Field, depth_at, depth_at_edge
from toolpace.kernels.cutting.revolution import radius_at
from toolpace.kernels.cutting.thickest_chip import (
    FAR,
    MOTION,
    REACH,
    TURNING,
    motion_outward,
    place_on,
    thickest,
)
from toolpace.kernels.jit import jit

TURN = 2.0 * math.pi
HALVINGS = 7
LEAST_CHIP = 1e-3
"""Of the motion of the tip: where the surface moves outward by less, it slides."""
LEAST_SAMPLES, MOST_SAMPLES = 12, 720
"""Of the part of a slice that moves outward."""
APART = 2.0
"""Cells between two places that are looked at, at least: a contact that is narrower may not be seen."""
FULL = 1.0 - 1e-9
"""Share of the radius from which a cut reaches the side of the tool."""
SLIM = 1e-6
"""Angle [rad] within which an arc ends where the surface begins to move outward, or inward."""
BESIDE = 0.1
"""Cells beside an end of an arc at which it is looked whether an edge moves it."""
SURE = 0.5
"""Share of a depth within which there is no border."""


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
    foot: Floats
    """(4,) z, radius, across and along close above the tip: what is cut less deep than half a slice is seen there."""
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
    x, y, w = place_on(pose, z, radius, phi)
    return depth_at(field, x, y, w, most, ahead)


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
def farthest_outward(
    pose: Floats, z: float, radius: float, across: float, along: float, entry: float, leave: float
) -> tuple[float, float]:
    """The angle of an arc of a slice at which the surface moves outward the farthest, and how far."""
    constant, cosine, sine = motion_outward(pose, z, radius, across, along)
    crest = math.atan2(sine, cosine)
    crest += TURN * round((0.5 * (entry + leave) - crest) / TURN)
    phi = min(max(crest, entry), leave)
    return phi, constant + cosine * math.cos(phi) + sine * math.sin(phi)


@jit()
def height_of_border(
    field: Field, pieces: Floats, pose: Floats, inside: float, outside: float, phi: float, most: float
) -> float:
    """The height of the border, between one in material at an angle and one outside."""
    ahead = 0
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        depth, ahead = depth_on(field, pose, middle, radius_at(pieces, middle)[0], phi, most, ahead)
        if depth > 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


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
    field: Field, pose: Floats, z: float, radius: float, across: float, along: float, j: int, arcs: Arcs, count: int,
    cell: float, least: float,
) -> int:
    """Write the arcs of slice j, seen at a height, behind the first `count`: how many there are then. Arcs nowhere
    deeper than `least` are left out."""
    begin, end = outward(pose, z, radius, across, along)
    if end <= begin:
        return count
    shortest = min(max(APART * cell / max(radius, cell), (end - begin) / MOST_SAMPLES), (end - begin) / LEAST_SAMPLES)
    whole, most = end - begin >= TURN, FAR * cell
    first = count
    entry, top, before = math.nan, -most, begin
    phi, ahead = begin + 0.5 * shortest, 0
    while phi < end:
        depth, ahead = depth_on(field, pose, z, radius, phi, most, ahead)
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
    return count


@jit()
def end_at_edge(
    field: Field, pose: Floats, z: float, radius: float, end: float, outwards: float, most: float, cell: float,
    room: Floats,
) -> float:
    """Where an arc ends that ends at an angle by straight lines between rays: at an edge of the stock up to a cell
    further out or in.

    outwards: 1 or -1, the sense in which it leaves material; most: angle by which it may be moved.
    """
    for side in (outwards, -outwards):
        # further out an edge holds material, further in it holds none
        low, high = (0.0, UNKNOWN) if side == outwards else (-UNKNOWN, 0.0)
        near, far = 0.0, most
        share = min(BESIDE * cell / (max(radius, cell) * most), 1.0)
        for _ in range(HALVINGS):
            middle = near + share * (far - near)
            x, y, w = place_on(pose, z, radius, end + side * middle)
            if low < depth_at_edge(field, x, y, w, REACH * cell, room) < high:
                near = middle
            elif near == 0.0:
                break
            else:
                far = middle
            share = 0.5
        if near > 0.0:
            return end + side * 0.5 * (near + far)
    return end


@jit()
def ends_at_edges(
    field: Field, pose: Floats, z: float, radius: float, across: float, along: float, arcs: Arcs, first: int,
    count: int, cell: float, room: Floats,
) -> None:
    """Move the ends of the arcs of a slice to edges of the stock, up to a cell and as far as the surface moves outward:
    of the lowest and the highest slice, which are close to edges that go around the tool."""
    begin, end = outward(pose, z, radius, across, along)
    for k in range(first, count):
        width = arcs.exit[k] - arcs.entry[k]
        if width >= TURN - SLIM:
            continue
        most = min(cell / max(radius, cell), 0.25 * width)
        before, behind = (arcs.entry[k] - begin) % TURN, (end - arcs.exit[k]) % TURN
        if k > first:
            before = min(before, (arcs.entry[k] - arcs.exit[k - 1]) % TURN)
        if k + 1 < count:
            behind = min(behind, (arcs.entry[k + 1] - arcs.exit[k]) % TURN)
        if SLIM < before < TURN - SLIM:
            arcs.entry[k] = end_at_edge(field, pose, z, radius, arcs.entry[k], -1.0, min(most, before), cell, room)
        if SLIM < behind < TURN - SLIM:
            arcs.exit[k] = end_at_edge(field, pose, z, radius, arcs.exit[k], 1.0, min(most, behind), cell, room)
        turns = math.floor(arcs.entry[k] / TURN) * TURN
        arcs.entry[k], arcs.exit[k] = arcs.entry[k] - turns, arcs.exit[k] - turns


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
def contact(
    field: Field, pieces: Floats, pose: Floats, slices: Slices, low: float, high: float, arcs: Arcs, count: int,
    cell: float, least: float, room: Floats,
) -> tuple[int, float, float, float, float, float]:
    """Write the arcs of a pose between two heights: how many there are then; width, depth, upper end of the cut, share
    of the flat end, and how far its surface moves outward in material at most, over the way of the tip."""
    last, most = len(slices.z) - 1, FAR * cell
    lowest, highest = -1, -1
    low_phi, high_phi, low_z, high_z = 0.0, 0.0, 0.0, 0.0
    # of the highest slice so far: width in its middle, and by how much it is wider in the middle of the next one
    width, middle, growth = 0.0, 0.0, 0.0
    # where the surface moves outward the farthest: how far, angle, height and arc
    farthest, farthest_phi, farthest_z, steepest = 0.0, 0.0, 0.0, -1
    lowest_count, of_highest = count, count
    bottom = max(int(low / slices.height - 0.5), 0)
    for j in range(bottom, min(int(high / slices.height + 0.5), last) + 1):
        first = count
        z, radius, across, along = slices.z[j], slices.radius[j], slices.across[j], slices.along[j]
        count = slice_arcs(field, pose, z, radius, across, along, j, arcs, count, cell, least)
        if j == 0 and count == first:
            z, radius, across, along = slices.foot[0], slices.foot[1], slices.foot[2], slices.foot[3]
            count = slice_arcs(field, pose, z, radius, across, along, j, arcs, count, cell, least)
        if count > first:
            if lowest < 0:
                ends_at_edges(field, pose, z, radius, across, along, arcs, first, count, cell, room)
                lowest_count = count
            left, right, longest, phi = -2.0, 2.0, -1.0, 0.0
            for k in range(first, count):
                a, b = arcs.entry[k], arcs.exit[k]
                if b - a > longest:
                    # there rays see one surface above and below: ends of arcs may be at edges
                    longest, phi = b - a, 0.5 * (a + b)
                left, right = max(left, math.cos(a), math.cos(b)), min(right, math.cos(a), math.cos(b))
                if a <= math.pi <= b or b >= 3.0 * math.pi:
                    right = -1.0
                if b >= TURN:
                    left = 1.0
                angle, far = farthest_outward(pose, z, radius, across, along, a, b)
                if far > farthest:
                    farthest, farthest_phi, farthest_z, steepest = far, angle, z, k
            if lowest < 0:
                lowest, low_phi, low_z = j, phi, z
            highest, high_phi, high_z, of_highest = j, phi, z, first
            middle = radius * (left - right)
            width = max(width, middle)
            # where it reaches the side of the tool, it grows with the tool
            sides = (1.0 if left > FULL else 0.0) + (1.0 if right < -FULL else 0.0)
            growth = max(slices.next_radius[j] - slices.radius[j], 0.0) * sides
    depth, top = 0.0, 0.0
    if of_highest >= lowest_count:
        z, radius, across = slices.z[highest], slices.radius[highest], slices.across[highest]
        along = slices.along[highest]
        ends_at_edges(field, pose, z, radius, across, along, arcs, of_highest, count, cell, room)
        for k in range(of_highest, count):
            angle, far = farthest_outward(pose, z, radius, across, along, arcs.entry[k], arcs.exit[k])
            if far > farthest or k == steepest:
                farthest, farthest_phi, farthest_z, steepest = far, angle, z, k
    if lowest >= 0:
        low, top = slices.z[lowest] - 0.5 * slices.height, slices.z[highest] + 0.5 * slices.height
        if lowest > 0:
            low = height_of_border(field, pieces, pose, low_z, slices.z[lowest - 1], low_phi, most)
        if high_z < slices.z[highest] or highest < last:
            outside = slices.z[highest + 1] if high_z == slices.z[highest] else slices.z[highest]
            top = height_of_border(field, pieces, pose, high_z, outside, high_phi, most)
        depth = top - low
        share = (top - slices.z[highest]) / slices.height
        width = max(width, middle + growth * min(max(share, 0.0), 1.0))
    flat = 0.0
    if slices.flat > 0.0:
        flat, left, right = flat_contact(field, pose, slices.flat, cell, least)
        width = max(width, left - right)
    step = math.sqrt(pose[MOTION, 0] ** 2 + pose[MOTION, 1] ** 2 + pose[MOTION, 2] ** 2)
    if steepest < 0 or step == 0.0:
        return count, width, depth, top, flat, 0.0
    arc = arcs.entry[steepest], arcs.exit[steepest]
    # angles of an arc are within one turn
    farthest_phi += TURN * round((0.5 * (arc[0] + arc[1]) - farthest_phi) / TURN)
    farthest = thickest(field, pieces, pose, farthest_z, slices.height, arc, farthest_phi, farthest, cell, room)
    return count, width, depth, top, flat, farthest / step

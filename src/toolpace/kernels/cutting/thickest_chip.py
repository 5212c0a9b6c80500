"""The thickest chip of a pose: how far the tool's surface moves outward in material at most.

On a tool that widens, the surface moves outward the more the higher it is, up to the border of what is cut; where two
surfaces of the stock meet, the most is in the corner of both. Slices tell both to half of their height only.

    from the slice and the angle with the most, over the angles at which a place above may have more:
        up the meridian to the border, by bisection
    about the best of some angles: the most of these borders, by sections of an interval
"""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.cutting.dexels import UNKNOWN, Field, depth_at, depth_at_edge
from toolpace.kernels.cutting.revolution import radius_at
from toolpace.kernels.jit import jit

TURN = 2.0 * math.pi
TIP, AXIS, FEED, LEFT, MOTION, TURNING = 0, 1, 2, 3, 4, 5
"""Rows of a pose (6, 3): of the tool, and of the motion to it along left, feed and axis: of the tip, and the turning of
the axis [rad] about left and feed. One array: a record of arrays costs time at each call."""
FAR = 3.0
"""Cells beyond which depths are cut off."""
REACH = 8.0
"""The same beside edges, where surfaces are continued."""
NEAR = 1.0
"""Cells outside of the stock, as straight lines between rays tell it, within which an edge may hold a point."""
ABOVE = 1.5
"""Slices from the one with the most within which the border is."""
AROUND = 1.5
"""Cells beside the arc of that slice within which the corner is."""
HALVINGS = 7
FIRST, SECTIONS = 6, 8
"""Angles at which the border is looked at first, and how often the interval about the best is cut."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
WIDENS = 1e-6
"""Least share of the motion by which a slice moves outward more than another."""


@jit(inline=True)
def motion_outward(pose: Floats, z: float, radius: float, across: float, along: float) -> tuple[float, float, float]:
    """How far the surface of a slice moves outward: a constant, and what goes with cosine and sine of the angle."""
    lever = z * across - radius * along
    cosine = across * pose[MOTION, 0] - lever * pose[TURNING, 1]
    sine = across * pose[MOTION, 1] + lever * pose[TURNING, 0]
    return along * pose[MOTION, 2], cosine, sine


@jit()
def outward_at(pieces: Floats, pose: Floats, z: float, phi: float) -> float:
    """How far the surface moves outward at a height and an angle."""
    radius, across, along = radius_at(pieces, z)
    constant, cosine, sine = motion_outward(pose, z, radius, across, along)
    return constant + cosine * math.cos(phi) + sine * math.sin(phi)


@jit(inline=True)
def place_on(pose: Floats, z: float, radius: float, phi: float) -> tuple[float, float, float]:
    """A point of the tool at a height, a radius and an angle."""
    a, b = radius * math.cos(phi), radius * math.sin(phi)
    return (
        pose[TIP, 0] + z * pose[AXIS, 0] + a * pose[LEFT, 0] + b * pose[FEED, 0],
        pose[TIP, 1] + z * pose[AXIS, 1] + a * pose[LEFT, 1] + b * pose[FEED, 1],
        pose[TIP, 2] + z * pose[AXIS, 2] + a * pose[LEFT, 2] + b * pose[FEED, 2],
    )


@jit()
def in_material(field: Field, pieces: Floats, pose: Floats, z: float, phi: float, cell: float, room: Floats) -> bool:
    """Whether the surface is in material at a height and an angle, up to the edges of the stock."""
    x, y, w = place_on(pose, z, radius_at(pieces, z)[0], phi)
    depth = depth_at(field, x, y, w, FAR * cell, 0)[0]
    if depth > 0.0 or depth < -NEAR * cell:
        return depth > 0.0
    at_edge: float = depth_at_edge(field, x, y, w, REACH * cell, room)
    return 0.0 < at_edge < UNKNOWN


@jit()
def outward_at_border(
    field: Field, pieces: Floats, pose: Floats, z: float, end: float, phi: float, cell: float, room: Floats
) -> float:
    """How far the surface moves outward at an angle, where material ends from a height on towards another; 0 where
    none is met."""
    inside, outside = z, end
    if not in_material(field, pieces, pose, inside, phi, cell, room):
        # the corner may be beside the slice
        inside = 0.5 * (z + end)
        if not in_material(field, pieces, pose, inside, phi, cell, room):
            outside, inside = z, z - 0.5 * (end - z)
            if inside < pieces[0, 0] or not in_material(field, pieces, pose, inside, phi, cell, room):
                return 0.0
    if in_material(field, pieces, pose, outside, phi, cell, room):
        return outward_at(pieces, pose, outside, phi)
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        if in_material(field, pieces, pose, middle, phi, cell, room):
            inside = middle
        else:
            outside = middle
    return outward_at(pieces, pose, outside, phi)


@jit()
def thickest(
    field: Field, pieces: Floats, pose: Floats, z: float, height: float, arc: tuple[float, float], phi: float,
    most: float, cell: float, room: Floats,
) -> float:
    """How far the surface moves outward in material at most, from the slice with the most, at a height: its arc, the
    angle, and how far it moves there."""
    low, high = max(z - height, pieces[0, 0]), min(z + height, pieces[len(pieces) - 1, 1])
    gain = outward_at(pieces, pose, high, phi) - outward_at(pieces, pose, low, phi)
    if abs(gain) < WIDENS * most:
        return most
    end = z + ABOVE * height if gain > 0.0 else z - ABOVE * height
    end = min(max(end, pieces[0, 0]), pieces[len(pieces) - 1, 1])
    # no angle counts at which not even the end of the way up has more
    radius, across, along = radius_at(pieces, end)
    constant, cosine, sine = motion_outward(pose, end, radius, across, along)
    size = math.hypot(cosine, sine)
    if constant + size <= most:
        return most
    crest = math.atan2(sine, cosine)
    crest += TURN * round((phi - crest) / TURN)
    reach = math.acos(max((most - constant) / size, -1.0)) if size > 0.0 else math.pi
    beside = AROUND * cell / max(radius, cell)
    first, last = max(crest - reach, arc[0] - beside), min(crest + reach, arc[1] + beside)
    if last <= first:
        return most
    best, at, step = most, phi, (last - first) / FIRST
    for k in range(FIRST):
        angle = first + (k + 0.5) * step
        far = outward_at_border(field, pieces, pose, z, end, angle, cell, room)
        if far > best:
            best, at = far, angle
    first, last = max(at - step, first), min(at + step, last)
    left, right = last - GOLDEN * (last - first), first + GOLDEN * (last - first)
    of_left = outward_at_border(field, pieces, pose, z, end, left, cell, room)
    of_right = outward_at_border(field, pieces, pose, z, end, right, cell, room)
    for _ in range(SECTIONS):
        best = max(best, of_left, of_right)
        if of_left > of_right or (of_left == of_right and at < left):
            last, right, of_right = right, left, of_left
            left = last - GOLDEN * (last - first)
            of_left = outward_at_border(field, pieces, pose, z, end, left, cell, room)
        else:
            first, left, of_left = left, right, of_right
            right = first + GOLDEN * (last - first)
            of_right = outward_at_border(field, pieces, pose, z, end, right, cell, room)
    return max(best, of_left, of_right)

"""What an engaged cutter takes over a turn: means and peaks of forces, and what deflection leaves on the surface."""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.forces import (
    ARM,
    AXIS,
    FEED,
    STRAIGHT,
    TIP,
    TURN,
    WEIGHTED,
    Arcs,
    Edge,
    Teeth,
    Work,
    chip_of,
    half_width,
    turn_of,
    workspace,
)
from toolpace.kernels.jit import jit

RESULTANT, MOMENT, DEFLECTION, THICKNESS, PEAKS = 6, 7, 8, 9, 10
"""Columns of the peaks that are no channel: largest resultant, bending moment at the holder, deflection of the tip, and
thickness of the chip; and how many columns there are."""
BELIEVED = 0.75
"""Share of what two straight lines add to a peak between two angles: beside a rounded peak they meet above it."""
SURFACE = math.radians(4.0)
"""How near the end of an arc must be to where the chip is nothing for the edge to leave a surface there [rad]."""


@jit()
def summit(values: Floats, k: int) -> float:
    """The largest of values (n,) around a turn, whose largest is value k, between the angles too.

    Where an arc begins or ends, force has a kink, mostly between two angles. Straight lines from both sides meet there,
    by the lesser slope of the last two steps each.
    """
    n = len(values)
    best = values[k]
    for left in range(k - 1, k + 1):
        rise = min(values[left % n] - values[(left - 1) % n], values[(left - 1) % n] - values[(left - 2) % n])
        right = (left + 1) % n
        fall = min(values[right] - values[(left + 2) % n], values[(left + 2) % n] - values[(left + 3) % n])
        if rise > 0.0 and fall > 0.0:
            share = (values[right] + fall - values[left % n]) / (rise + fall)
            if 0.0 < share < 1.0:
                best = max(best, values[k] + BELIEVED * (values[left % n] + rise * share - values[k]))
    return best


@jit()
def peaks_of(peak: Floats, sums: Floats) -> None:
    """The largest of each over a turn (PEAKS,), with its sign where it may have one."""
    peak[:] = 0.0
    values = np.empty(len(sums))
    for channel in range(WEIGHTED):
        highest = 0
        for k in range(1, len(sums)):
            if abs(sums[k, channel]) > abs(sums[highest, channel]):
                highest = k
        sign = 1.0 if sums[highest, channel] >= 0.0 else -1.0
        for k in range(len(sums)):
            values[k] = sign * sums[k, channel]
        peak[channel] = sign * summit(values, highest)
    for column in range(RESULTANT, DEFLECTION + 1 if sums.shape[1] > WEIGHTED else RESULTANT + 1):
        at = FEED if column == RESULTANT else WEIGHTED + 2 * (ARM if column == MOMENT else TIP)
        highest = 0
        for k in range(len(sums)):
            square = sums[k, at] * sums[k, at] + sums[k, at + 1] * sums[k, at + 1]
            if column == RESULTANT:
                square += sums[k, AXIS] * sums[k, AXIS]
            values[k] = math.sqrt(square)
            if values[k] > values[highest]:
                highest = k
        peak[column] = summit(values, highest)


@jit()
def deflection_at(bent: Floats, sums: Floats, place: float, node: Floats, height: float, straight: bool) -> None:
    """How far the tool bends along feed and normal (2,) [m] at a height; place: the angle in steps between angles."""
    below = round(place) if straight else math.floor(place)
    share = 0.0 if straight else place - below
    bent[:] = 0.0
    for q in range(3):
        a, b = node[(q + 1) % 3], node[(q + 2) % 3]
        lagrange = (height - a) * (height - b) / ((node[q] - a) * (node[q] - b))
        for side in range(2):
            at = WEIGHTED + 2 * (TIP + q) + side
            low, high = sums[below % len(sums), at], sums[(below + 1) % len(sums), at]
            bent[side] += lagrange * (low + share * (high - low))


@jit()
def surface_left(
    left: Floats, work: Work, edge: Edge, teeth: Teeth, arcs: Arcs, i: int, motion: Floats, origin: float
) -> None:
    """What station i leaves on the surface (4,): the least [m] and its height on the tool, the most and its height.

    A surface is generated where the motion is along the surface of the tool: where the thickness of the chip falls to
    nothing at an end of an arc. Of all teeth the one that reaches furthest leaves it. nan where none is.
    """
    chip, bent = np.empty(5), np.empty(2)
    step = TURN / len(work.terms)
    for a in range(arcs.first[i], arcs.first[i + 1]):
        if arcs.slice[a] >= len(edge.first) - 2:
            continue
        for p in range(edge.first[arcs.slice[a]], edge.first[arcs.slice[a] + 1]):
            chip_of(chip, edge, p, motion)
            half = half_width(chip[3], chip[2])
            if half == 0.0 or half == math.pi:
                continue
            for side in range(-1, 2, 2):
                # the place of this side in the turn in which the arc begins, or ends
                place, end = chip[4] + side * half, arcs.entry[a] if side < 0 else arcs.exit[a]
                place += TURN * round((end - place) / TURN)
                inside = min(max(place, arcs.entry[a]), arcs.exit[a])
                if abs(inside - place) > SURFACE:
                    continue
                least = np.inf
                sine, cosine = edge.sine[p] * math.sin(place), edge.sine[p] * math.cos(place)
                for tooth in range(1 if teeth.share.shape[1] == 1 else len(teeth.angle)):
                    angle = inside + edge.lag[p] - teeth.angle[tooth] - origin
                    straight = edge.span[p] < STRAIGHT
                    deflection_at(bent, work.sums, angle / step, edge.node, edge.height[p], straight)
                    reach = teeth.runout * math.cos(teeth.runout_angle - teeth.angle[tooth] + edge.lag[p])
                    least = min(least, -(bent[0] * sine + bent[1] * cosine) - edge.sine[p] * reach)
                if not least >= left[0]:
                    left[0], left[1] = least, edge.height[p]
                if not least <= left[2]:
                    left[2], left[3] = least, edge.height[p]


@jit()
def loads(
    mean: Floats, peak: Floats, left: Floats, edge: Edge, teeth: Teeth, arcs: Arcs, motion: Floats, cells: int
) -> None:
    """Mean (n, channels), peaks (n, PEAKS) and what is left (n, 4), of n stations with motions (n, 4) per tooth."""
    work = workspace(edge, teeth, cells)
    for i in range(len(motion)):
        left[i] = np.nan
        peak[i] = 0.0
        mean[i] = 0.0
        if arcs.first[i + 1] == arcs.first[i] and arcs.bottom[i] <= 0.0:
            continue
        # where the tip comes into material the force jumps: one of the angles is there
        origin = arcs.entry[arcs.first[i]] if arcs.first[i + 1] > arcs.first[i] else 0.0
        thickest = turn_of(work, edge, teeth, arcs, i, motion[i], origin)
        mean[i] = work.mean
        peaks_of(peak[i], work.sums)
        peak[i, THICKNESS] = thickest
        if edge.weight.shape[1] > 0:
            surface_left(left[i], work, edge, teeth, arcs, i, motion[i], origin)


@jit()
def turns(out: Floats, edge: Edge, teeth: Teeth, arcs: Arcs, motion: Floats, stations: Ints) -> None:
    """The forces (m, cells, channels) of some stations over a turn."""
    work = workspace(edge, teeth, out.shape[1])
    for m in range(len(stations)):
        turn_of(work, edge, teeth, arcs, stations[m], motion[stations[m]], 0.0)
        out[m] = work.sums

"""Forces of the engaged edges of a milling cutter over its turn, station by station, linear in the feed.

Engin and Altintas, Mechanics and dynamics of general milling cutters, part I, International Journal of Machine Tools
and Manufacture 41 (2001); Lee and Altintas, Prediction of ball-end milling forces from orthogonal cutting data,
ibid. 36 (1996); runout by Kline and DeVor, International Journal of Machine Tool Design and Research 23 (1983).

An edge is a row of points, each standing for a piece of the meridian of the tool. At the angle phi it takes a chip of

    h = P sin(phi) + Q cos(phi) - C = Re(H exp(i phi)) - C,    H = Q - i P

the component of the motion per tooth along the normal of the tool's surface. With the force across the axis as a
complex number, normal + i feed, a chip of S h + D takes

    (S h + D) K exp(i phi) + E exp(i phi)    K per thickness of the chip, E of the edge

While a point is in material that is a sum of 1, exp(i theta) and exp(2 i theta), theta the angle of the first tooth at
the tip. So what a point adds to the force of all is told by its terms, added where it enters and taken off where it
leaves: the work does not grow with the angles between. Terms are summed so; channels are what they come to.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

FEED, NORMAL, AXIS, TORQUE, AREA, LENGTH, WEIGHTED = 0, 1, 2, 3, 4, 5, 6
"""Channels: the force along feed, normal and axis; torque; area of the chips; engaged edge, as width of the chips; then
for each weight of the points the forces along feed and normal, weighted."""
ARM, TIP = 0, 1
"""Weights of a point: how far the holder is above it; deflection at the three nodes, from the tip upwards, by a force
at the point. Without a holder there are none."""
LENGTH_TERM, ACROSS_TERMS = 9, 10
"""Terms: three each (by 1, cosine, sine) of force along the axis, torque and area, one of the edge, six (real and
imaginary part by 1, exp(i theta), exp(2 i theta)) of the force across, and six for each of its weights."""
STRAIGHT = 1e-9
"""Lag over a point below which an edge counts as straight [rad]."""
RAMP = math.sin(math.radians(3.0))
"""Sine of the slope of a motion downwards from which the flat end cuts with the whole force of its edge. Below it the
force falls with the square of the slope: the end only rubs where a plane is rounded by a micrometre."""
TURN = 2.0 * math.pi


class Edge(NamedTuple):
    """The points of one edge, p of them, ordered by slice; the flat end of the tool is the last slice."""

    first: Ints
    """(slices + 1,) points of slice j are first[j] to first[j + 1]."""
    height: Floats
    """(p,) above the tip [m]."""
    radius: Floats
    """(p,) [m]"""
    sine: Floats
    """(p,) of the angle between the axis and the normal of the surface."""
    cosine: Floats
    lag: Floats
    """(p,) angle by which it is behind the tip of the edge [rad]."""
    span: Floats
    """(p,) difference of the lag between both ends of its piece [rad]."""
    width: Floats
    """(p,) length of its piece of the meridian [m]."""
    force: Floats
    """(p, 6) per thickness of the chip [N/m] and constant [N]: tangential, outwards, along the axis."""
    weight: Floats
    """(p, w) see ARM."""
    node: Floats
    """(3,) heights at which the deflection is told [m]."""


class Teeth(NamedTuple):
    """The teeth, n of them; angles are signed by the sense in which the tool turns."""

    angle: Floats
    """(n,) of each, from the first [rad]."""
    share: Floats
    """(n, m) feed from the 1st, 2nd, ... tooth ahead to it, in feeds per tooth; m is 1 where all teeth are alike."""
    runout: float
    """[m]"""
    runout_angle: float
    """[rad]"""
    sense: float
    """1 where the tool turns clockwise, seen from the spindle, -1 where it does not."""
    slope: float
    """1 where the part of the forces that is proportional to the speed is counted, else 0."""
    constant: float
    """1 where the part that is constant is counted, else 0."""


class Arcs(NamedTuple):
    """An engagement; see cutting/engagement/table.py."""

    first: Ints
    slice: Ints
    entry: Floats
    exit: Floats
    share: Floats
    """Of the height of its slice that is in material, of each arc."""
    bottom: Floats


class Work(NamedTuple):
    """What is summed over a turn of k angles."""

    terms: Floats
    """(k, t) by how much the sums grow from the angle before; nothing between two stations."""
    circle: Floats
    """(k, 2) cosine and sine of each angle."""
    carried: Floats
    """(t,) the sums before the first angle."""
    point: Floats
    """(t,) the terms of one point."""
    mean: Floats
    """(channels,) integrals over a turn."""
    sums: Floats
    """(m, channels) by angle: of a pitch where all teeth are alike (k is a multiple of m), else of a turn (k = m)."""


@jit()
def workspace(edge: Edge, teeth: Teeth, cells: int) -> Work:
    """Room for a turn; cells: angles of a pitch where all teeth are alike, else of a turn."""
    weights = edge.weight.shape[1]
    terms, channels = ACROSS_TERMS + 6 * (1 + weights), WEIGHTED + 2 * weights
    turn = cells * len(teeth.angle) if teeth.share.shape[1] == 1 else cells
    circle = np.empty((turn, 2))
    for k in range(turn):
        circle[k, 0], circle[k, 1] = math.cos(k * TURN / turn), math.sin(k * TURN / turn)
    sums = np.zeros((cells, channels))
    return Work(np.zeros((turn, terms)), circle, np.zeros(terms), np.zeros(terms), np.zeros(channels), sums)


@jit(inline=True)
def half_width(amplitude: float, level: float) -> float:
    """Angle from its crest at which a cosine of an amplitude is at a level: 0 where it is below, pi where above."""
    if level >= amplitude:
        return 0.0
    if level <= -amplitude:
        return math.pi
    if level == 0.0:
        return 0.5 * math.pi
    return math.acos(level / amplitude)


@jit()
def chip_of(chip: Floats, edge: Edge, p: int, motion: Floats) -> None:
    """P, Q, C, amplitude and angle of the crest (5,) of a point.

    motion: (4,) per tooth: across, along [m], turn of the axis along feed and normal.
    """
    chip[0], chip[1], chip[2] = edge.sine[p] * motion[0], 0.0, edge.cosine[p] * motion[1]
    if motion[2] != 0.0 or motion[3] != 0.0:
        lever = edge.height[p] * edge.sine[p] + edge.radius[p] * edge.cosine[p]
        chip[0] += lever * motion[2]
        chip[1] = lever * motion[3]
    chip[3], chip[4] = chip[0], 0.5 * math.pi
    if chip[1] != 0.0 or chip[0] < 0.0:
        chip[3], chip[4] = math.hypot(chip[0], chip[1]), math.atan2(chip[0], chip[1])


@jit()
def terms_of_point(
    out: Floats, edge: Edge, p: int, teeth: Teeth, chip: Floats, shift: complex, share: float, rest: float, scale: float
) -> None:
    """The terms of a point with a chip of `share` times its thickness and `rest`; `scale` is of its edge force.

    shift: exp(-i lag) of the lag behind the first tooth at the tip.
    """
    slope, constant = teeth.slope * share, teeth.constant * scale
    wave = complex(chip[1], -chip[0]) * shift
    level = teeth.constant * rest - slope * chip[2]
    for k in range(3):
        # force along the axis, torque, area of the chips
        per_chip, of_edge = edge.width[p], 0.0
        if k == 0:
            per_chip, of_edge = edge.force[p, 2], edge.force[p, 5]
        elif k == 1:
            per_chip, of_edge = edge.force[p, 0] * edge.radius[p], edge.force[p, 3] * edge.radius[p]
        out[3 * k] = per_chip * level + of_edge * constant
        out[3 * k + 1] = per_chip * slope * wave.real
        out[3 * k + 2] = -per_chip * slope * wave.imag
    out[LENGTH_TERM] = edge.width[p] * constant
    per_chip_across = complex(edge.force[p, 1], -teeth.sense * edge.force[p, 0])
    of_edge_across = complex(edge.force[p, 4], -teeth.sense * edge.force[p, 3])
    still = 0.5 * slope * per_chip_across * complex(chip[1], chip[0])
    once = (level * per_chip_across + constant * of_edge_across) * shift
    twice = 0.5 * slope * per_chip_across * wave * shift
    for w in range(edge.weight.shape[1] + 1):
        weight = 1.0 if w == 0 else edge.weight[p, w - 1]
        at = ACROSS_TERMS + 6 * w
        out[at], out[at + 1] = weight * still.real, weight * still.imag
        out[at + 2], out[at + 3] = weight * once.real, weight * once.imag
        out[at + 4], out[at + 5] = weight * twice.real, weight * twice.imag


@jit()
def add_channels(out: Floats, terms: Floats, one: float, once: complex, twice: complex) -> None:
    """Add to channels what terms come to, with values of 1, exp(i theta) and exp(2 i theta), or integrals of them."""
    out[AXIS] += terms[0] * one + terms[1] * once.real + terms[2] * once.imag
    out[TORQUE] += terms[3] * one + terms[4] * once.real + terms[5] * once.imag
    out[AREA] += terms[6] * one + terms[7] * once.real + terms[8] * once.imag
    out[LENGTH] += terms[LENGTH_TERM] * one
    for w in range((len(terms) - ACROSS_TERMS) // 6):
        at = ACROSS_TERMS + 6 * w
        real = terms[at] * one + terms[at + 2] * once.real - terms[at + 3] * once.imag
        real += terms[at + 4] * twice.real - terms[at + 5] * twice.imag
        imaginary = terms[at + 1] * one + terms[at + 2] * once.imag + terms[at + 3] * once.real
        imaginary += terms[at + 4] * twice.imag + terms[at + 5] * twice.real
        feed = FEED if w == 0 else WEIGHTED + 2 * (w - 1)
        out[feed] += imaginary
        out[feed + 1] += real


@jit(inline=True)
def grow(work: Work, k: int, by: float) -> None:
    """Have the sums grow from angle k on by a share of the terms of the point."""
    turn = len(work.terms)
    wraps = k // turn
    row = work.terms[k - wraps * turn]
    for t in range(len(row)):
        row[t] += by * work.point[t]
    if wraps != 0:
        for t in range(len(row)):
            work.carried[t] -= wraps * by * work.point[t]


@jit(inline=True)
def add_at(work: Work, k: int, angle: float, share: float) -> None:
    """Add a share of the point at angle k of the sums, as it is with the first tooth at an angle next to that."""
    once = complex(math.cos(angle), math.sin(angle))
    add_channels(work.sums[k % len(work.sums)], work.point, share, share * once, share * (once * once))


@jit(inline=True)
def enter(work: Work, place: float, half: float, by: float) -> None:
    """Have the point come in (by = 1) or go out (-1) at a place, over a span; both in steps between angles."""
    before = 0.0
    for k in range(math.floor(place - half) + 1, math.ceil(place + half) + 1):
        share = min((k - place + half) / (2.0 * half), 1.0)
        grow(work, k, by * (share - before))
        before = share


@jit()
def add_piece(work: Work, span: float, begin: float, end: float, jumps_in: bool, jumps_out: bool) -> None:
    """Add the point, in material while the first tooth is between two angles; span: of the lag over its piece.

    jumps_in, jumps_out: whether it comes from and goes to air there, not only to the chip of another tooth.
    """
    step = TURN / len(work.terms)
    one0, one1 = complex(math.cos(begin), math.sin(begin)), complex(math.cos(end), math.sin(end))
    once, twice = (one1 - one0) * complex(0.0, -1.0), (one1 * one1 - one0 * one0) * complex(0.0, -0.5)
    add_channels(work.mean, work.point, end - begin, once, twice)
    first, last, half = begin / step, end / step, 0.5 * span / step
    if span > STRAIGHT:
        if math.floor(first - half) + 1 >= last + half:  # all of it is between two angles: the nearer takes its most
            middle = 0.5 * (first + last)
            add_at(work, round(middle), middle * step, min(0.5 * (last - first) / half, 1.0))
        else:
            enter(work, first, half, 1.0)
            enter(work, last, half, -1.0)
        return
    grow(work, math.ceil(first), 1.0)
    grow(work, math.ceil(last), -1.0)
    if end - begin < TURN - STRAIGHT:
        # a straight edge comes in at once: the angle next to that takes the force at that very place
        if jumps_in and first - math.ceil(first) + 1 <= 0.5:
            add_at(work, math.ceil(first) - 1, begin, 1.0)
        if jumps_out and math.ceil(last) - last < 0.5:
            add_at(work, math.ceil(last), end, 1.0)


@jit()
def add_chip(
    work: Work, span: float, lag: float, chip: Floats, inner: float, outer: float, arc: tuple[float, float],
    from_air: bool,
) -> float:  # fmt: skip
    """Add the point in an arc (entry, exit), where it is between two angles from the crest of its chip.

    from_air: whether it cuts nothing beyond the outer angle. The thickest chip there.
    """
    thickest = 0.0
    crest = chip[4]
    turn = math.floor((arc[0] - crest - outer) / TURN)
    for k in range(turn, turn + 3):
        for side in range(-1, 2, 2):
            if inner > 0.0:
                low, high = (crest - outer, crest - inner) if side < 0 else (crest + inner, crest + outer)
            elif side < 0:
                low, high = crest - outer, crest + outer
            else:
                continue
            low, high = low + k * TURN, high + k * TURN
            jumps_in, jumps_out = from_air and (inner == 0.0 or side < 0), from_air and (inner == 0.0 or side > 0)
            if outer >= math.pi:  # a chip all around has no end
                if inner == 0.0:
                    if k > turn:
                        continue
                    low, high = arc
                elif side < 0:
                    jumps_in = False
                else:
                    jumps_out = False
            if arc[0] > low:
                low, jumps_in = arc[0], True
            if arc[1] < high:
                high, jumps_out = arc[1], True
            if high <= low:
                continue
            add_piece(work, span, low + lag, high + lag, jumps_in, jumps_out)
            nearest = crest + TURN * round((0.5 * (low + high) - crest) / TURN)
            off = min(max(nearest, low), high) - nearest
            thickest = max(thickest, (chip[3] * math.cos(off) if off != 0.0 else chip[3]) - chip[2])
    return thickest


@jit()
def add_point(work: Work, edge: Edge, p: int, teeth: Teeth, motion: Floats, arc: tuple[float, float], share: float,
              scale: float, origin: float, chip: Floats, reach: Floats) -> float:  # fmt: skip
    """Add a share of a point, of all teeth, that is in material in an arc (entry, exit); the thickness of its chip.

    Of the chips that each tooth ahead would leave the thinnest is cut: over the thickness h of an even chip they are
    lines, of which the lowest is followed from where all are above nothing.
    """
    chip_of(chip, edge, p, motion)
    thickest, most, others = 0.0, chip[3] - chip[2], teeth.share.shape[1]
    if most <= 0.0:
        return thickest
    for tooth in range(1 if others == 1 else len(teeth.angle)):
        lag = edge.lag[p] - teeth.angle[tooth] - origin
        shift = complex(math.cos(lag), -math.sin(lag))
        least = -chip[3] - chip[2]
        h, from_air = max(least, 0.0), True
        for m in range(others):
            reach[m] = 0.0
            if teeth.runout != 0.0:
                ahead = teeth.angle[(tooth + m + 1) % len(teeth.angle)]
                own = math.cos(teeth.runout_angle - teeth.angle[tooth] + edge.lag[p])
                reach[m] = edge.sine[p] * teeth.runout * (own - math.cos(teeth.runout_angle - ahead + edge.lag[p]))
            h = max(h, -reach[m] / teeth.share[tooth, m])
        while h < most or (from_air and h == most):
            # the lowest line just after h, and where the next one crosses it
            lowest, upto = 0, most
            for m in range(1, others):
                gap = (teeth.share[tooth, m] - teeth.share[tooth, lowest]) * h + reach[m] - reach[lowest]
                if gap < -1e-12 * most:
                    lowest = m
            for m in range(lowest):
                cross = (reach[m] - reach[lowest]) / (teeth.share[tooth, lowest] - teeth.share[tooth, m])
                if cross > h:
                    upto = min(upto, cross)
            terms_of_point(work.point, edge, p, teeth, chip, shift, teeth.share[tooth, lowest], reach[lowest], scale)
            work.point[:] *= share
            # from the crest of the chip outwards its thickness falls from `upto` to h
            outer = half_width(chip[3], h + chip[2]) if h > least else math.pi
            inner = half_width(chip[3], upto + chip[2]) if upto < most else 0.0
            thick = add_chip(work, edge.span[p], lag, chip, inner, outer, arc, from_air)
            thickest = max(thickest, thick * teeth.share[tooth, lowest] + reach[lowest])
            h, from_air = upto, False
    return thickest


@jit()
def turn_of(work: Work, edge: Edge, teeth: Teeth, arcs: Arcs, i: int, motion: Floats, origin: float) -> float:
    """The forces of station i over a turn and their mean, in the workspace; the thickest chip.

    origin: angle of the first tooth at the tip at which the turn begins.
    """
    work.carried[:] = 0.0
    work.mean[:] = 0.0
    work.sums[:] = 0.0
    chip, reach = np.empty(5), np.empty(teeth.share.shape[1])
    thickest, flat = 0.0, len(edge.first) - 2
    for a in range(arcs.first[i], arcs.first[i + 1]):
        if arcs.slice[a] < flat:
            for p in range(edge.first[arcs.slice[a]], edge.first[arcs.slice[a] + 1]):
                arc, share = (arcs.entry[a], arcs.exit[a]), arcs.share[a]
                thickest = max(thickest, add_point(work, edge, p, teeth, motion, arc, share, 1.0, origin, chip, reach))
    if arcs.bottom[i] > 0.0 and motion[1] < 0.0:
        # that part of the flat end is taken as a sector ahead
        arc = 0.5 * math.pi - math.pi * arcs.bottom[i], 0.5 * math.pi + math.pi * arcs.bottom[i]
        scale = min(1.0, (motion[1] / (RAMP * math.hypot(motion[0], motion[1]))) ** 2)
        for p in range(edge.first[flat], edge.first[flat + 1]):
            thickest = max(thickest, add_point(work, edge, p, teeth, motion, arc, 1.0, scale, origin, chip, reach))
    alike = teeth.share.shape[1] == 1
    work.mean[:] *= len(teeth.angle) / TURN if alike else 1.0 / TURN
    running = work.carried
    # what is left of its edge by rounding is nothing; where the constant part is not counted all angles are looked at
    least = 1e-9 * edge.width.min() * teeth.constant - (1.0 - teeth.constant)
    for k in range(len(work.terms)):
        for t in range(len(running)):
            running[t] += work.terms[k, t]
            work.terms[k, t] = 0.0
        if running[LENGTH_TERM] <= least:  # nothing is in material
            continue
        once = complex(work.circle[k, 0], work.circle[k, 1])
        add_channels(work.sums[k % len(work.sums)], running, 1.0, once, once * once)
    return thickest

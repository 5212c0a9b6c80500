"""A solid as three grids of rays along x, y and z, each ray with its sorted intervals of material (tri-dexels).

Benouamer and Michelucci, Bridging the gap between CSG and Brep via a triple ray representation (1997). The ends of
intervals are exact; a surface is known as well as the rays that cross it at the steepest angle know it. Memory grows
with the surface. An interval is a node; the first node of a ray has the number of the ray, further ones come from a
pool. Rays of direction d lie in the middle of the cells across d, row by row.

What is called in the innermost loops takes the arrays one by one: a record of arrays costs time at each call.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

FREE, FREE_COUNT = 0, 1
"""Places of `Field.pool`."""
STEEPEST = 1.5
"""Cells by which the ends of two neighbouring rays differ at most where both are on one surface: any surface is flatter
than that as one of three directions sees it."""
UNKNOWN = 1e9
"""Depth [m] where rays do not tell one."""


class Field(NamedTuple):
    """The rays of a box of cells."""

    origin: Floats
    """(3,) lowest corner of the box."""
    step: Floats
    """(3,) of the cells."""
    cells: Ints
    """(3,) how many there are along x, y and z."""
    first: Ints
    """(4,) number of the first ray along x, y, z, and of all."""
    low: Floats
    """(nodes,) where an interval begins; above `high` for a first node without material."""
    high: Floats
    """(nodes,)"""
    following: Ints
    """(nodes,) the next node of the ray, or of what is free; -1: none."""
    pool: Ints
    """(2,) first free node, and how many there are."""


@jit(inline=True)
def put_behind(
    lows: Floats, highs: Floats, following: Ints, pool: Ints, node: int, low: float, high: float
) -> None:
    """Put an interval behind a node; there must be a free node."""
    new = pool[FREE]
    pool[FREE] = following[new]
    pool[FREE_COUNT] -= 1
    lows[new], highs[new] = low, high
    following[new] = following[node]
    following[node] = new


@jit(inline=True)
def give_back(following: Ints, pool: Ints, node: int) -> None:
    """Give a node back to the pool."""
    following[node] = pool[FREE]
    pool[FREE] = node
    pool[FREE_COUNT] += 1


@jit()
def subtract(
    lows: Floats, highs: Floats, following: Ints, pool: Ints, ray: int, low: float, high: float, shortest: float
) -> tuple[float, float]:
    """Take the material between two places out of a ray: length and first moment of what is taken.

    What is left shorter than `shortest` is taken too. Needs one free node.
    """
    length, moment = 0.0, 0.0
    node, before = ray, -1
    if lows[ray] > highs[ray]:
        return length, moment
    while node >= 0:
        begin, end, after = lows[node], highs[node], following[node]
        if begin >= high:
            break
        if end > low:
            left, right = low - begin > shortest, end - high > shortest
            a = low if left else begin
            b = high if right else end
            length += b - a
            moment += 0.5 * (b - a) * (a + b)
            if left and right:
                put_behind(lows, highs, following, pool, node, high, end)
                highs[node] = low
                break
            if left:
                highs[node] = low
            elif right:
                lows[node] = high
            elif before >= 0:
                following[before] = after
                give_back(following, pool, node)
                node = after
                continue
            elif after >= 0:
                lows[node], highs[node], following[node] = lows[after], highs[after], following[after]
                give_back(following, pool, after)
                continue
            else:
                lows[node], highs[node] = 1.0, 0.0
                break
        before, node = node, after
    return length, moment


@jit()
def add(lows: Floats, highs: Floats, following: Ints, pool: Ints, ray: int, low: float, high: float) -> None:
    """Put material between two places of a ray, merged with what it touches. Needs one free node."""
    if lows[ray] > highs[ray]:
        lows[ray], highs[ray] = low, high
        return
    node, before = ray, -1
    while node >= 0 and highs[node] < low:
        before, node = node, following[node]
    if node < 0:
        put_behind(lows, highs, following, pool, before, low, high)
    elif high < lows[node]:
        put_behind(lows, highs, following, pool, node, lows[node], highs[node])
        lows[node], highs[node] = low, high
    else:
        lows[node], highs[node] = min(lows[node], low), max(highs[node], high)
        after = following[node]
        while after >= 0 and lows[after] <= highs[node]:
            highs[node] = max(highs[node], highs[after])
            following[node] = following[after]
            give_back(following, pool, after)
            after = following[node]


@jit()
def lengths(field: Field) -> tuple[float, float, float]:
    """Volume as seen by the rays along x, y and z."""
    found = (0.0, 0.0, 0.0)
    for d in range(3):
        total = 0.0
        for ray in range(field.first[d], field.first[d + 1]):
            node = ray
            while node >= 0:
                if field.high[node] > field.low[node]:
                    total += field.high[node] - field.low[node]
                node = field.following[node]
        total *= field.step[(d + 1) % 3] * field.step[(d + 2) % 3]
        found = (total if d == 0 else found[0], total if d == 1 else found[1], total if d == 2 else found[2])
    return found


@jit(inline=True)
def depth_on_ray(field: Field, ray: int, place: float, most: float) -> float:
    """How deep a place is in the material of a ray, along it; below zero outside; `most` at most either way."""
    node = ray
    gap = most
    if field.low[ray] > field.high[ray]:
        return -most
    while node >= 0:
        low, high = field.low[node], field.high[node]
        if place < low:
            outside: float = -min(gap, low - place)
            return outside
        if place <= high:
            inside: float = min(most, place - low, high - place)
            return inside
        gap = min(most, place - high)
        node = field.following[node]
    return -gap


@jit()
def depth_at(field: Field, x: float, y: float, z: float, most: float, ahead: int) -> tuple[float, int]:
    """Depth of a point in material, below zero outside; exact for a plane, within a cell at edges; `most` at most.

    In each direction the depth along the four rays about the point is interpolated. For a plane this is linear, and
    the four differ the least where the rays cross it at the steepest angle: that direction counts. Rays that do not
    come to their end within `most` tell on which side the point is, and no more.

    Looks in direction `ahead` first, and in no other where the rays cross steeply there. Returns the depth and the
    direction that counted.
    """
    at = (x, y, z)
    score, best, steep, which = math.inf, -most, 1.0, ahead
    for d in range(3):
        outside = max(field.origin[d] - at[d], at[d] - field.origin[d] - field.step[d] * field.cells[d])
        if outside >= 0.0:
            depth: float = -min(outside, most)
            return depth, ahead
    for k in range(3):
        d = (ahead + k) % 3
        u, v = (d + 1) % 3, (d + 2) % 3
        fu = min(max((at[u] - field.origin[u]) / field.step[u] - 0.5, 0.0), field.cells[u] - 1.0)
        fv = min(max((at[v] - field.origin[v]) / field.step[v] - 0.5, 0.0), field.cells[v] - 1.0)
        iu, iv = int(fu), int(fv)
        ju, jv = min(iu + 1, field.cells[u] - 1), min(iv + 1, field.cells[v] - 1)
        fu, fv = fu - iu, fv - iv
        row, above = field.first[d] + iv * field.cells[u], field.first[d] + jv * field.cells[u]
        a = depth_on_ray(field, row + iu, at[d], most)
        b = depth_on_ray(field, row + ju, at[d], most)
        c = depth_on_ray(field, above + iu, at[d], most)
        e = depth_on_ray(field, above + ju, at[d], most)
        low, high = min(a, b, c, e), max(a, b, c, e)
        # all inside or all outside, one of them far: the side is sure, which is more than a mixture tells, and less
        # than a plane
        spread = high - low
        rank = 1.5 * most if (low > 0.0 and high >= most) or (high < 0.0 and low <= -most) else spread
        if rank < score:
            score, which = rank, d
            best = (1.0 - fv) * ((1.0 - fu) * a + fu * b) + fv * ((1.0 - fu) * c + fu * e)
            steep = 1.0
            if rank == spread:
                slope_u = ((1.0 - fv) * (b - a) + fv * (e - c)) / field.step[u]
                slope_v = ((1.0 - fu) * (c - a) + fu * (e - b)) / field.step[v]
                steep = 1.0 / math.sqrt(1.0 + slope_u * slope_u + slope_v * slope_v)
                if spread <= field.step[u]:
                    break
    return best * steep, which


@jit(inline=True)
def continued(near: float, second: float, third: float, share: float, jump: float) -> float:
    """A depth beyond the nearest of three in a row, as far as they are of one surface; UNKNOWN of one alone."""
    if abs(near - second) > jump:
        return UNKNOWN
    slope = near - second
    bend = slope - (second - third) if abs(second - third) <= jump else 0.0
    return near + share * (slope + 0.5 * (1.0 + share) * bend)


@jit(inline=True)
def about_kink(row: Floats, share: float, jump: float) -> float:
    """A depth between the middle two of six in a row: that of the surfaces on both sides, continued to where they meet,
    where that is more than a straight line tells; past a jump, that of the nearer one, if the other is air."""
    b, c = row[2], row[3]
    left, right = continued(b, row[1], row[0], share, jump), continued(c, row[4], row[5], 1.0 - share, jump)
    if b - c > jump:
        return left if abs(b) < abs(c) else UNKNOWN
    if c - b > jump:
        return right if abs(c) <= abs(b) else UNKNOWN
    between: float = b + (c - b) * share
    if left < UNKNOWN and right < UNKNOWN:
        between = max(between, min(left, right))
    return between


@jit()
def depth_at_edge(field: Field, x: float, y: float, z: float, most: float, room: Floats) -> float:
    """Depth of a point in material where two surfaces meet at an edge that stands out; UNKNOWN at the foot of a wall.

    Linear interpolation rounds edges off by up to half a cell. So in each direction the surfaces are continued from
    the rays beyond the four about the point (Harten, ENO schemes with subcell resolution, Journal of Computational
    Physics 83 (1989)). The point is in material where it is behind all surfaces: the least of the depths along the rays
    counts, of directions whose rays come to an end near. `room`: (2, 6) to work in.
    """
    at = (x, y, z)
    row, rows = room[0], room[1]
    least, sure = UNKNOWN, 0.999 * most
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        jump = STEEPEST * field.step[d]
        fu = (at[u] - field.origin[u]) / field.step[u] - 0.5
        fv = (at[v] - field.origin[v]) / field.step[v] - 0.5
        iu, iv = math.floor(fu), math.floor(fv)
        for k in range(6):
            j = iv + k - 2
            if 0 <= j < field.cells[v]:
                first = field.first[d] + j * field.cells[u]
                for m in range(6):
                    i = iu + m - 2
                    row[m] = depth_on_ray(field, first + i, at[d], most) if 0 <= i < field.cells[u] else -most
                rows[k] = about_kink(row, fu - iu, jump)
            else:
                rows[k] = -most
        depth = about_kink(rows, fv - iv, jump)
        if abs(depth) < sure:
            least = min(least, depth)
    return least


@jit()
def depths_at(field: Field, points: Floats, most: float, into: Floats) -> None:
    """`depth_at` of points (n, 3)."""
    for k in range(len(points)):
        into[k], _ = depth_at(field, points[k, 0], points[k, 1], points[k, 2], most, 0)

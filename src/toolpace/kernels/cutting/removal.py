"""What a convex solid of revolution takes out of a stock at a pose."""

from __future__ import annotations

import math
from typing import NamedTuple

from toolpace.kernels.arrays import Floats
from toolpace.kernels.cutting.dexels import Field, subtract
from toolpace.kernels.cutting.revolution import ARC, WIDEST, Z0, Z1, A, B, chord, nearest_normal
from toolpace.kernels.jit import jit

SHORTEST = 1e-6
"""Intervals shorter than this part of a cell are no material: they are rounding."""
MOST_PARTS = 100
"""Parts of a removed interval over which the normal is integrated."""


class Shadow(NamedTuple):
    """The part of the tool's axis whose tool may be within the stock's box, seen along a direction."""

    u: float
    """Where it begins, across the direction."""
    v: float
    du: float
    """To where it ends."""
    dv: float
    radius: float


@jit()
def widest_of(pieces: Floats) -> float:
    """The largest radius of a solid."""
    widest = 0.0
    for k in range(len(pieces)):
        widest = max(widest, pieces[k, WIDEST])
    return widest


@jit()
def widest_between(pieces: Floats, z0: float, z1: float) -> float:
    """The largest radius of a solid between two heights."""
    widest = 0.0
    for k in range(len(pieces)):
        low, high = max(z0, pieces[k, Z0]), min(z1, pieces[k, Z1])
        if low <= high:
            a, b, arc = pieces[k, A], pieces[k, B], pieces[k, ARC]
            if arc == 0.0:
                widest = max(widest, a + b * low, a + b * high)
            else:
                off = min(max(b, low), high) - b
                widest = max(widest, a + math.sqrt(max(arc * arc - off * off, 0.0)))
    return widest


@jit()
def near_box(field: Field, pieces: Floats, tip: Floats, axis: Floats, radius: float) -> tuple[float, float]:
    """Heights along the axis between which the tool may be within the stock's box; none: the first is above."""
    low, high = pieces[0, Z0], pieces[len(pieces) - 1, Z1]
    for d in range(3):
        reach = radius * math.sqrt(max(1.0 - axis[d] * axis[d], 0.0))
        least = field.origin[d] - reach - tip[d]
        most = field.origin[d] + field.step[d] * field.cells[d] + reach - tip[d]
        if abs(axis[d]) < 1e-12:
            if least > 0.0 or most < 0.0:
                return 1.0, 0.0
        else:
            a, b = least / axis[d], most / axis[d]
            low, high = max(low, min(a, b)), min(high, max(a, b))
    return low, high


@jit(inline=True)
def row_part(shadow: Shadow, v: float) -> tuple[float, float]:
    """The part of the row at v that is within the shadow: two circles and the strip between them."""
    low, high = math.inf, -math.inf
    for end in range(2):
        off = v - shadow.v - end * shadow.dv
        inside = shadow.radius * shadow.radius - off * off
        if inside >= 0.0:
            reach = math.sqrt(inside)
            middle = shadow.u + end * shadow.du
            low, high = min(low, middle - reach), max(high, middle + reach)
    length = math.sqrt(shadow.du * shadow.du + shadow.dv * shadow.dv)
    if length > 0.0 and abs(shadow.dv) > 1e-9 * length:
        for side in range(-1, 2, 2):
            share = (v - shadow.v - side * shadow.radius * shadow.du / length) / shadow.dv
            if 0.0 <= share <= 1.0:
                u = shadow.u - side * shadow.radius * shadow.dv / length + share * shadow.du
                low, high = min(low, u), max(high, u)
    return low, high


@jit()
def squared_normal(
    pieces: Floats, off: float, base: float, lean: float, begin: float, length: float, apart: float
) -> float:
    """Integral over a part of a ray of the square of the component along it of the nearest surface's normal.

    By two Gauss points in each part of at most `apart`: the normal turns along a ray that grazes, and jumps at edges.
    """
    parts = min(max(math.ceil(length / apart), 1), MOST_PARTS)
    width, total = length / parts, 0.0
    for k in range(2 * parts):
        t = begin + width * (k // 2 + 0.5 + (0.28867513459481287 if k % 2 else -0.28867513459481287))
        z = base + t * lean
        rho = math.sqrt(max(off + t * t - z * z, 0.0))
        across, along = nearest_normal(pieces, rho, z)
        part = along * lean + (across * (t - z * lean) / rho if rho > 0.0 else 0.0)
        total += part * part
    return 0.5 * width * total


@jit()
def cut_at(field: Field, pieces: Floats, tip: Floats, axis: Floats, z0: float, z1: float) -> float:
    """Take the solid at a pose out of the stock: the volume taken. Needs a free node for each ray that it meets.

    Above the height z1 and below z0 it meets no material.

    Each direction sees the whole volume, but those that graze the surface see it in jumps. At each ray the square of
    the normal's component along it counts; over the three directions these sum up to one.
    """
    z0, z1 = max(z0, pieces[0, Z0]), min(z1, pieces[len(pieces) - 1, Z1])
    if z0 > z1:
        return 0.0
    begin, end = 0, len(pieces)
    while pieces[begin, Z1] < z0:
        begin += 1
    while pieces[end - 1, Z0] > z1:
        end -= 1
    radius, pieces = widest_between(pieces, z0, z1), pieces[begin:end]
    lows, highs, following, pool = field.low, field.high, field.following, field.pool
    volume = 0.0
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        su, sv, lean = field.step[u], field.step[v], axis[d]
        first_u, first_ray, across, tip_u, tip_d = field.origin[u], field.first[d], field.cells[u], tip[u], tip[d]
        axis_u, axis_v = axis[u], axis[v]
        shadow = Shadow(
            tip[u] + z0 * axis[u], tip[v] + z0 * axis[v], (z1 - z0) * axis[u], (z1 - z0) * axis[v], radius
        )
        top, bottom = max(shadow.v, shadow.v + shadow.dv) + radius, min(shadow.v, shadow.v + shadow.dv) - radius
        begin = max(math.ceil((bottom - field.origin[v]) / sv - 0.5), 0)
        end = min(math.floor((top - field.origin[v]) / sv - 0.5), field.cells[v] - 1)
        # between which places along the rays the tool is at all; without material an interval ends before it begins
        reach = radius * math.sqrt(max(1.0 - lean * lean, 0.0))
        nearest = tip_d + min(z0 * lean, z1 * lean) - reach
        farthest = tip_d + max(z0 * lean, z1 * lean) + reach
        seen = 0.0
        for iv in range(begin, end + 1):
            at_v = field.origin[v] + (iv + 0.5) * sv
            low, high = row_part(shadow, at_v)
            if low > high:
                continue
            wv = at_v - tip[v]
            left = max(math.ceil((low - field.origin[u]) / su - 0.5), 0)
            right = min(math.floor((high - field.origin[u]) / su - 0.5), field.cells[u] - 1)
            for iu in range(left, right + 1):
                ray = first_ray + iv * across + iu
                node = ray
                while node >= 0 and highs[node] <= nearest:
                    node = following[node]
                if node < 0 or lows[node] >= farthest:
                    continue
                wu = first_u + (iu + 0.5) * su - tip_u
                off, base = wu * wu + wv * wv, wu * axis_u + wv * axis_v
                first, last = chord(pieces, off, base, lean)
                while node >= 0 and highs[node] - tip_d <= first:
                    node = following[node]
                if node < 0 or lows[node] - tip_d >= last or first >= last:
                    continue
                # by halves: what is taken near one end of the chord has the normal of that end
                middle = 0.5 * (first + last)
                for half in range(2):
                    low, high = (first, middle) if half == 0 else (middle, last)
                    if low < high:
                        length, moment = subtract(
                            lows, highs, following, pool, ray, low + tip_d, high + tip_d, SHORTEST * su
                        )
                        if length > 0.0:
                            t = moment / length - tip_d
                            seen += squared_normal(pieces, off, base, lean, t - 0.5 * length, length, 0.5 * su)
        volume += seen * su * sv
    return volume

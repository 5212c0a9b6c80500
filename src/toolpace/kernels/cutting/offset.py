"""A solid of rays grown or shrunk by a ball."""

from __future__ import annotations

import math

from toolpace.kernels.cutting.dexels import FREE_COUNT, Field, add, subtract
from toolpace.kernels.jit import jit


@jit()
def reach_of(d: int, di: float, dj: float, distance: float, field: Field) -> float:
    """How far along a ray in direction d the offset of what lies so many cells across reaches; below zero: not at all.

    What a ray sees may lie up to a cell beside it: the ball is moved by that much across the ray.
    """
    su, sv = field.step[(d + 1) % 3], field.step[(d + 2) % 3]
    across = math.sqrt((di * su) ** 2 + (dj * sv) ** 2) - math.sqrt(su * su + sv * sv)
    if across > distance:
        return -1.0
    if across <= 0.0:
        return distance
    return math.sqrt(distance * distance - across * across)


@jit()
def grow(source: Field, target: Field, d: int, distance: float, ray: int) -> int:
    """Put the offset of rays along d from `ray` on into a field whose cells begin `shift` cells further down.

    Returns the ray at which free nodes ran out, or the end of the rays.
    """
    u, v = (d + 1) % 3, (d + 2) % 3
    nu, mu, mv = source.cells[u], target.cells[u], target.cells[v]
    shift_u = round((source.origin[u] - target.origin[u]) / source.step[u])
    shift_v = round((source.origin[v] - target.origin[v]) / source.step[v])
    far_u = math.ceil(distance / source.step[u]) + 2
    far_v = math.ceil(distance / source.step[v]) + 2
    lows, highs, following, pool = target.low, target.high, target.following, target.pool
    while ray < source.first[d + 1]:
        if target.pool[FREE_COUNT] < 64 * (2 * far_u + 1) * (2 * far_v + 1):
            return ray
        row, column = (ray - source.first[d]) // nu, (ray - source.first[d]) % nu
        node = ray
        while node >= 0 and source.low[node] < source.high[node]:
            for dj in range(-far_v, far_v + 1):
                for di in range(-far_u, far_u + 1):
                    i, j = column + shift_u + di, row + shift_v + dj
                    if 0 <= i < mu and 0 <= j < mv:
                        reach = reach_of(d, di, dj, distance, source)
                        if reach >= 0.0:
                            low, high = source.low[node] - reach, source.high[node] + reach
                            add(lows, highs, following, pool, target.first[d] + j * mu + i, low, high)
            node = source.following[node]
        ray += 1
    return ray


@jit()
def shrink(source: Field, target: Field, d: int, distance: float, ray: int) -> int:
    """Take the offset of the air along rays of d from `ray` on out of a copy; returns as `grow` does."""
    u, v = (d + 1) % 3, (d + 2) % 3
    nu, nv = source.cells[u], source.cells[v]
    far_u = math.ceil(distance / source.step[u]) + 2
    far_v = math.ceil(distance / source.step[v]) + 2
    lows, highs, following, pool = target.low, target.high, target.following, target.pool
    while ray < target.first[d + 1]:
        if target.pool[FREE_COUNT] < 64 * (2 * far_u + 1) * (2 * far_v + 1):
            return ray
        row, column = (ray - target.first[d]) // nu, (ray - target.first[d]) % nu
        if target.low[ray] < target.high[ray]:
            for dj in range(-far_v, far_v + 1):
                for di in range(-far_u, far_u + 1):
                    reach = reach_of(d, di, dj, distance, source)
                    if reach < 0.0:
                        continue
                    i, j = column + di, row + dj
                    begin = -math.inf
                    if 0 <= i < nu and 0 <= j < nv:
                        node = source.first[d] + j * nu + i
                        while node >= 0:
                            if source.low[node] < source.high[node]:
                                end = source.low[node] + reach
                                subtract(lows, highs, following, pool, ray, begin - reach, end, 0.0)
                                begin = source.high[node]
                            node = source.following[node]
                    subtract(lows, highs, following, pool, ray, begin - reach, math.inf, 0.0)
        ray += 1
    return ray

"""How deep a convex solid of revolution is in the material of a stock."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.dexels import Field
from toolpace.kernels.cutting.removal import Shadow, near_box, widest_of
from toolpace.kernels.cutting.revolution import ARC, WIDEST, Z0, Z1, A, B, chord
from toolpace.kernels.jit import jit

BLOCK = 16
"""Rays along each side of a block."""


class Blocks(NamedTuple):
    """Between which places the rays of each block of 16 x 16 have material."""

    first: Ints
    """(4,) number of the first block along x, y, z, and of all."""
    low: Floats
    high: Floats


@jit()
def blocks_of(field: Field, blocks: Blocks) -> None:
    """Work out the blocks of a field."""
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        across = (field.cells[u] + BLOCK - 1) // BLOCK
        for iv in range(field.cells[v]):
            for iu in range(field.cells[u]):
                block = blocks.first[d] + (iv // BLOCK) * across + iu // BLOCK
                node = field.first[d] + iv * field.cells[u] + iu
                if field.low[node] <= field.high[node]:
                    blocks.low[block] = min(blocks.low[block], field.low[node])
                    while field.following[node] >= 0:
                        node = field.following[node]
                    blocks.high[block] = max(blocks.high[block], field.high[node])


@jit()
def depth_within(pieces: Floats, rho: float, z: float) -> float:
    """Distance of a point within a convex solid from its surface.

    The nearest place may be on a piece at other heights. A cone, continued, holds the whole solid, so that its distance
    counts at any height; that of an arc counts where the nearest place is on the arc itself.
    """
    nearest: float = min(z - pieces[0, Z0], pieces[len(pieces) - 1, Z1] - z)
    for k in range(len(pieces)):
        a, b, arc = pieces[k, A], pieces[k, B], pieces[k, ARC]
        if arc == 0.0:
            nearest = min(nearest, (a + b * z - rho) / math.sqrt(1.0 + b * b))
        elif rho > a:
            out = math.sqrt((rho - a) ** 2 + (z - b) ** 2)
            if pieces[k, Z0] <= b + arc * (z - b) / out <= pieces[k, Z1]:
                nearest = min(nearest, arc - out)
    return nearest


@jit()
def deepest_on_ray(
    field: Field, pieces: Floats, ray: int, begin: float, end: float, off: float, base: float, lean: float, tip: float
) -> tuple[float, float]:
    """How deep the solid's chord from begin to end, along a ray, is in its material, and at which place."""
    depth, place = 0.0, 0.0
    node = ray
    while node >= 0 and field.low[node] <= field.high[node]:
        low, high = max(field.low[node] - tip, begin), min(field.high[node] - tip, end)
        if low < high:
            # the distance from the surface of a convex solid has one peak along a ray, mostly near the middle
            for k in range(3):
                t = low if k == 0 else high if k == 1 else min(max(0.5 * (begin + end), low), high)
                z = base + t * lean
                found = depth_within(pieces, math.sqrt(max(off + t * t - z * z, 0.0)), z)
                if found > depth:
                    depth, place = found, t + tip
        node = field.following[node]
    return depth, place


@jit()
def deepest(
    field: Field, blocks: Blocks, pieces: Floats, cover: Floats, tip: Floats, axis: Floats, best: float, at: Floats
) -> float:
    """How deep the solid at a pose is in material, or `best` if that is more; `at` (3,) becomes the deepest place.

    cover: room for a cylinder (1, 6) about the solid. It is wider by half the diagonal of a block, so that a ray in the
    middle of a block meets it where any ray of the block meets the solid.
    """
    bottom_of, top_of = pieces[0, Z0], pieces[len(pieces) - 1, Z1]
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        su, sv = field.step[u], field.step[v]
        half = 0.5 * BLOCK * math.sqrt(su * su + sv * sv)
        radius, longer = widest_of(pieces) + half, half * math.sqrt(max(1.0 - axis[d] * axis[d], 0.0))
        cover[0, Z0], cover[0, Z1], cover[0, A], cover[0, WIDEST] = bottom_of - longer, top_of + longer, radius, radius
        z0, z1 = near_box(field, cover, tip, axis, radius)
        if z0 > z1:
            continue
        shadow = Shadow(
            tip[u] + z0 * axis[u], tip[v] + z0 * axis[v], (z1 - z0) * axis[u], (z1 - z0) * axis[v], radius
        )
        across = (field.cells[u] + BLOCK - 1) // BLOCK
        upward = (field.cells[v] + BLOCK - 1) // BLOCK
        bottom, top = min(shadow.v, shadow.v + shadow.dv) - radius, max(shadow.v, shadow.v + shadow.dv) + radius
        begin_v = max(int((bottom - field.origin[v]) / (BLOCK * sv) - 1.0), 0)
        end_v = min(int((top - field.origin[v]) / (BLOCK * sv) + 1.0), upward)
        for bv in range(begin_v, end_v):
            wv = field.origin[v] + (bv + 0.5) * BLOCK * sv - tip[v]
            left, right = min(shadow.u, shadow.u + shadow.du) - radius, max(shadow.u, shadow.u + shadow.du) + radius
            begin_u = max(int((left - field.origin[u]) / (BLOCK * su) - 1.0), 0)
            end_u = min(int((right - field.origin[u]) / (BLOCK * su) + 1.0), across)
            for bu in range(begin_u, end_u):
                block = blocks.first[d] + bv * across + bu
                if blocks.low[block] > blocks.high[block]:
                    continue
                wu = field.origin[u] + (bu + 0.5) * BLOCK * su - tip[u]
                low, high = chord(cover, wu * wu + wv * wv, wu * axis[u] + wv * axis[v], axis[d])
                if low >= high or low + tip[d] > blocks.high[block] or high + tip[d] < blocks.low[block]:
                    continue
                best = deepest_in_block(field, pieces, tip, axis, d, bu, bv, best, at)
    return best


@jit()
def deepest_in_block(
    field: Field, pieces: Floats, tip: Floats, axis: Floats, d: int, bu: int, bv: int, best: float, at: Floats
) -> float:
    """The larger of `best` and what the rays of a block find; where it is larger, `at` becomes its place."""
    u, v = (d + 1) % 3, (d + 2) % 3
    for iv in range(bv * BLOCK, min((bv + 1) * BLOCK, field.cells[v])):
        at_v = field.origin[v] + (iv + 0.5) * field.step[v]
        wv = at_v - tip[v]
        for iu in range(bu * BLOCK, min((bu + 1) * BLOCK, field.cells[u])):
            ray = field.first[d] + iv * field.cells[u] + iu
            if field.low[ray] > field.high[ray]:
                continue
            at_u = field.origin[u] + (iu + 0.5) * field.step[u]
            wu = at_u - tip[u]
            off, base = wu * wu + wv * wv, wu * axis[u] + wv * axis[v]
            begin, end = chord(pieces, off, base, axis[d])
            if begin < end:
                depth, place = deepest_on_ray(field, pieces, ray, begin, end, off, base, axis[d], tip[d])
                if depth > best:
                    best = depth
                    at[u], at[v], at[d] = at_u, at_v, place
    return best


@jit()
def deepest_along(
    field: Field, blocks: Blocks, pieces: Floats, tips: Floats, axes: Floats, depths: Floats, at: Floats
) -> None:
    """`deepest` of poses: tips, axes (n, 3); depths (n,) and places (n, 3) change where it is deeper."""
    cover = np.zeros((1, 6))
    for k in range(len(tips)):
        depths[k] = deepest(field, blocks, pieces, cover, tips[k], axes[k], depths[k], at[k])

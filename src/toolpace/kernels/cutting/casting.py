"""Rays cast through a solid: the crossings of a triangle mesh, and the chords of a solid of revolution."""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.cutting.dexels import Field, add
from toolpace.kernels.cutting.revolution import chord
from toolpace.kernels.jit import jit


@jit()
def left_of(au: float, av: float, bu: float, bv: float, pu: float, pv: float) -> bool:
    """Whether a point is left of an edge from a to b, or on it where the edge goes up.

    The two triangles at an edge come to opposite answers for every point, those on the edge too: the product is worked
    out from the same end for both.
    """
    up = au < bu or (au == bu and av < bv)
    if up:
        return (bu - au) * (pv - av) - (bv - av) * (pu - au) >= 0.0
    return (au - bu) * (pv - bv) - (av - bv) * (pu - bu) < 0.0


@jit()
def crossings(field: Field, triangles: Floats, d: int, offset: Ints, places: Floats, ways: Ints) -> None:
    """Where rays along d cross triangles (n, 3, 3): counted by ray, or written.

    offset (rays + 1,) is where the crossings of each ray are written: it is moved on. Where `places` is empty, they
    are counted there instead. ways: 1 where the ray enters the solid, -1 where it leaves it.
    """
    u, v = (d + 1) % 3, (d + 2) % 3
    su, sv, nu, nv = field.step[u], field.step[v], field.cells[u], field.cells[v]
    ou, ov = field.origin[u], field.origin[v]
    for k in range(len(triangles)):
        au, av, at = triangles[k, 0, u], triangles[k, 0, v], triangles[k, 0, d]
        bu, bv, bt = triangles[k, 1, u], triangles[k, 1, v], triangles[k, 1, d]
        cu, cv, ct = triangles[k, 2, u], triangles[k, 2, v], triangles[k, 2, d]
        area = (bu - au) * (cv - av) - (bv - av) * (cu - au)
        if area == 0.0:
            continue
        way = -1 if area > 0.0 else 1
        if area < 0.0:
            bu, bv, bt, cu, cv, ct = cu, cv, ct, bu, bv, bt
            area = -area
        below, above = min(at, bt, ct), max(at, bt, ct)
        first_u = max(math.ceil((min(au, bu, cu) - ou) / su - 0.5), 0)
        last_u = min(math.floor((max(au, bu, cu) - ou) / su - 0.5), nu - 1)
        first_v = max(math.ceil((min(av, bv, cv) - ov) / sv - 0.5), 0)
        last_v = min(math.floor((max(av, bv, cv) - ov) / sv - 0.5), nv - 1)
        for iv in range(first_v, last_v + 1):
            pv = ov + (iv + 0.5) * sv
            for iu in range(first_u, last_u + 1):
                pu = ou + (iu + 0.5) * su
                if left_of(au, av, bu, bv, pu, pv) and left_of(bu, bv, cu, cv, pu, pv) and left_of(
                    cu, cv, au, av, pu, pv
                ):
                    ray = iv * nu + iu
                    if len(places) > 0:
                        weight_b = ((pu - au) * (cv - av) - (pv - av) * (cu - au)) / area
                        weight_c = ((bu - au) * (pv - av) - (bv - av) * (pu - au)) / area
                        place = at + weight_b * (bt - at) + weight_c * (ct - at)
                        places[offset[ray]] = min(max(place, below), above)
                        ways[offset[ray]] = way
                    offset[ray] += 1


@jit()
def fill(field: Field, d: int, offset: Ints, places: Floats, ways: Ints) -> int:
    """Put material where the winding number is above zero; crossings of ray k are at offset[k] to offset[k + 1].

    Returns how many rays do not leave what they enter: none in a closed mesh. Needs free nodes for all crossings.
    """
    lows, highs, following, pool = field.low, field.high, field.following, field.pool
    wrong = 0
    for k in range(len(offset) - 1):
        begin, end = offset[k], offset[k + 1]
        for i in range(begin + 1, end):  # few: sorted by insertion
            place, way = places[i], ways[i]
            j = i
            while j > begin and (places[j - 1] > place or (places[j - 1] == place and ways[j - 1] < way)):
                places[j], ways[j] = places[j - 1], ways[j - 1]
                j -= 1
            places[j], ways[j] = place, way
        winding, entered = 0, 0.0
        for i in range(begin, end):
            if winding == 0 and ways[i] > 0:
                entered = places[i]
            winding += ways[i]
            if winding < 0:
                break
            if winding == 0 and places[i] > entered:
                add(lows, highs, following, pool, field.first[d] + k, entered, places[i])
        if winding != 0:
            wrong += 1
    return wrong


@jit()
def fill_revolved(field: Field, pieces: Floats, tip: Floats, axis: Floats) -> None:
    """Put a convex solid of revolution into an empty field."""
    lows, highs, following, pool = field.low, field.high, field.following, field.pool
    for d in range(3):
        u, v = (d + 1) % 3, (d + 2) % 3
        for iv in range(field.cells[v]):
            wv = field.origin[v] + (iv + 0.5) * field.step[v] - tip[v]
            for iu in range(field.cells[u]):
                wu = field.origin[u] + (iu + 0.5) * field.step[u] - tip[u]
                low, high = chord(pieces, wu * wu + wv * wv, wu * axis[u] + wv * axis[v], axis[d])
                if low < high:
                    ray = field.first[d] + iv * field.cells[u] + iu
                    add(lows, highs, following, pool, ray, low + tip[d], high + tip[d])

"""Rows in tiles and their multipliers, for problem and relaxation.

A row bounds value = r . (z, z', z'') + shift from above and below: by 1 for acceleration, by the limit of its point for
jerk, each relaxed by an amount of its kind. With its slacks, up = limit + extra - value and down = limit + extra +
value, go the multipliers above and below. Sums and peaks are kept lane by lane, and gathered at the end.

In a tile the values of TILE points lie side by side in memory. A loop over the places of a tile, its lanes, does the
same for each of them, which vector instructions do for several at once. An array (points, ...) becomes
(tiles, ..., TILE); the last tile is partly empty.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit

TILE = 64
"""Points of a tile: eight times what the widest vector instructions take."""
BACK_OFF = 0.99
"""Share of the way to where a first slack or multiplier would vanish that a step goes, for problem and relaxation."""
MOST_FALL = 0.6
"""Most of z at a point that a step may take away: where z falls far, the tangents of 1 / sqrt(z) mislead."""
Z, Z1, Z2, LIMIT, FALL, EXTRA, EXTRA_JERK = range(7)
"""State of a point or knot: z, z', z'', the limit of its jerk rows, the negative slope of 1 / sqrt(z), and by how much
its rows of acceleration and of jerk are relaxed."""
STATES = 7
BOUND, RELAXED, SLOPE, COMMON, FIRST, SHIFT = range(0, 12, 2)
"""Of the rows of a tile, those of acceleration, and next to it those of jerk: limit, its relief, its negative slope,
and what a step and the predictor's do to both slacks alike; last the constant of the row at hand."""
BOUNDS = 11


class RowTiles(NamedTuple):
    """The rows of points in tiles, with the states of the points and the multipliers of the rows."""

    points: int
    """How many there are: the last tile is partly empty."""
    rows: Floats
    """(tiles, r, 3, TILE) those of acceleration, then those of jerk, divided by their limits; r as many as the tile has
    that has most."""
    kept: Ints
    """(tiles, 2) how many of acceleration and of jerk each tile has."""
    at: Floats
    """(tiles, STATES, TILE) states of the points."""
    dual: Floats
    """(tiles, r, 2, TILE) multipliers above and below."""
    shift: Floats
    """(tiles, r, TILE) constants of the rows; empty where all are zero."""


class RowSteps(NamedTuple):
    """The steps of predictor and corrector, point by point and row by row."""

    affine: Floats
    """(tiles, 4, TILE) the predictor's, of z, z', z'' and wait."""
    change: Floats
    """(tiles, 4, TILE) the corrector's."""
    dual: Floats
    """(tiles, r, 2, TILE) the corrector's, of the multipliers."""


@jit()
def tiled(values: Floats) -> Floats:
    """(tiles, width, TILE) of values (points, width); zeros beyond the last point."""
    points, width = values.shape
    out = np.zeros(((points + TILE - 1) // TILE, width, TILE))
    for p in range(points):
        for i in range(width):
            out[p // TILE, i, p % TILE] = values[p, i]
    return out


@jit(reorder=True)
def advance(dual: Floats, step: Floats, go: float) -> None:
    """Go the share `go` of the steps of multipliers (k,)."""
    for i in range(len(dual)):
        dual[i] += go * step[i]


@jit(inline=True)
def in_tiles(rows: Floats, shift: Floats, wanted: Bools) -> RowTiles:
    """The rows (points, 2 m, 3) that are wanted (tiles, 2 m) in tiles, states and multipliers still zero; with their
    constants (points, 2 m), if there are any."""
    points, count = rows.shape[0], rows.shape[1]
    tiles, most = len(wanted), 0
    for t in range(tiles):
        most = max(most, int(np.count_nonzero(wanted[t])))
    of_tiles, kept = np.zeros((tiles, most, 3, TILE)), np.zeros((tiles, 2), dtype=np.int64)
    shifts = np.zeros((tiles if len(shift) > 0 else 0, most, TILE))
    for t in range(tiles):
        first, last = t * TILE, min((t + 1) * TILE, points)
        for i in range(count):
            if wanted[t, i]:
                at = kept[t, 0] + kept[t, 1]
                kept[t, 2 * i // count] += 1
                for p in range(first, last):
                    for d in range(3):
                        of_tiles[t, at, d, p - first] = rows[p, i, d]
                    if len(shift) > 0:
                        shifts[t, at, p - first] = shift[p, i]
    return RowTiles(points, of_tiles, kept, np.zeros((tiles, STATES, TILE)), np.zeros((tiles, most, 2, TILE)), shifts)


@jit(inline=True)
def all_wanted(rows: Floats) -> Bools:
    """(tiles, 2 m) all of the rows (points, 2 m, 3)."""
    return np.ones(((len(rows) + TILE - 1) // TILE, rows.shape[1]), dtype=np.bool_)


@jit()
def rows_in(tiles: RowTiles) -> int:
    """How many rows there are."""
    count = 0
    for t in range(len(tiles.kept)):
        count += min(TILE, tiles.points - t * TILE) * (tiles.kept[t, 0] + tiles.kept[t, 1])
    return count


@jit(inline=True)
def steps_of(rows: RowTiles) -> RowSteps:
    """Room for the steps."""
    tiles = len(rows.rows)
    return RowSteps(np.zeros((tiles, 4, TILE)), np.zeros((tiles, 4, TILE)), np.zeros_like(rows.dual))


@jit(reorder=True)
def set_bounds(at: Floats, lanes: int, out: Floats) -> None:
    """Set limit, relief and slope of the rows of a tile from its states (7, TILE)."""
    for p in range(lanes):
        out[BOUND, p], out[BOUND + 1, p] = 1.0, at[LIMIT, p]
        out[RELAXED, p], out[RELAXED + 1, p] = at[EXTRA, p], at[EXTRA_JERK, p]
        out[SLOPE, p], out[SLOPE + 1, p] = 0.0, at[FALL, p]
        out[SHIFT, p] = 0.0


@jit(reorder=True)
def set_shift(tiles: RowTiles, t: int, i: int, lanes: int, out: Floats) -> None:
    """Set the constant of the row i of a tile, where rows have constants."""
    if len(tiles.shift) > 0:
        for p in range(lanes):
            out[SHIFT, p] = tiles.shift[t, i, p]


@jit(reorder=True)
def set_common(at: Floats, change: Floats, column: int, lanes: int, out: Floats) -> None:
    """Set what a change (4, TILE) of z, z', z'' and wait does to both slacks of the rows of a tile alike."""
    for p in range(lanes):
        out[column, p] = -at[EXTRA, p]
        out[column + 1, p] = change[3, p] - at[FALL, p] * change[0, p] - at[EXTRA_JERK, p]


@jit(reorder=True)
def start(tiles: RowTiles, centre: float) -> None:
    """Multipliers that make every product of slack and multiplier equal to `centre`."""
    points, rows, kept, at, dual, _ = tiles
    bounds = np.empty((BOUNDS, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, points - t * TILE)
        set_bounds(at[t], lanes, bounds)
        for i in range(kept[t, 0] + kept[t, 1]):
            kind = 0 if i < kept[t, 0] else 1
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                value = (
                    rows[t, i, 0, p] * at[t, Z, p] + rows[t, i, 1, p] * at[t, Z1, p] + rows[t, i, 2, p] * at[t, Z2, p]
                ) + bounds[SHIFT, p]
                room = bounds[BOUND + kind, p] + bounds[RELAXED + kind, p]
                dual[t, i, 0, p] = centre / (room - value)
                dual[t, i, 1, p] = centre / (room + value)


FALLS, GROWS, LINEAR, SQUARE = range(4)
"""Of a lane, in a predictor: largest relative falls and growths of slacks; sums of slack times multiplier times such a
change or its square."""


@jit(inline=True)
def share_left(gap: float, falls: float, grows: float, linear: float, square: float) -> float:
    """Share of the gap that is left after the longest predictor's step, primal and dual apart.

    From what the predictor does to the slacks. Without centring the relative changes of a slack and of its multiplier
    sum to -1, so that the slacks tell all.
    """
    go, go_dual = min(1.0, 1.0 / falls), min(1.0, 1.0 / (1.0 + grows))
    return 1.0 + (go * linear - go_dual * (gap + linear) - go * go_dual * (square + linear)) / gap


@jit(inline=True)
def product_aimed_at(gap: float, products: int, left: float) -> float:
    """What the corrector aims at for every product of slack and multiplier: the smaller, the less of the gap is left.

    Mehrotra's third power of that share, of the mean product.
    """
    return gap / products * max(min(left, 1.0) ** 3, 1e-8)


LOSS, LOSS_DUAL, STEP_UP, STEP_DOWN = range(4)
"""Of a lane, in a corrector: largest relative losses of slack and of multiplier; steps of the multipliers of a row."""


@jit(reorder=True)
def correct(tiles: RowTiles, steps: RowSteps, centre: float) -> tuple[float, float]:
    """Set the steps of the multipliers that go with the corrector's change of z, z', z'' and wait.

    Returns the largest relative losses of slack and of multiplier.
    """
    points, rows, kept, at, dual, _ = tiles
    affine, change, step = steps
    bounds, lane = np.empty((BOUNDS, TILE)), np.zeros((4, TILE))
    for t in range(len(rows)):
        lanes = min(TILE, points - t * TILE)
        set_bounds(at[t], lanes, bounds)
        set_common(at[t], change[t], COMMON, lanes, bounds)
        set_common(at[t], affine[t], FIRST, lanes, bounds)
        for i in range(kept[t, 0] + kept[t, 1]):
            kind = 0 if i < kept[t, 0] else 1
            set_shift(tiles, t, i, lanes, bounds)
            for p in range(lanes):
                r0, r1, r2 = rows[t, i, 0, p], rows[t, i, 1, p], rows[t, i, 2, p]
                value = r0 * at[t, Z, p] + r1 * at[t, Z1, p] + r2 * at[t, Z2, p] + bounds[SHIFT, p]
                move = r0 * change[t, 0, p] + r1 * change[t, 1, p] + r2 * change[t, 2, p]
                first = r0 * affine[t, 0, p] + r1 * affine[t, 1, p] + r2 * affine[t, 2, p]
                common, common_first = bounds[COMMON + kind, p], bounds[FIRST + kind, p]
                room = bounds[BOUND + kind, p] + bounds[RELAXED + kind, p]
                up, down, above, below = room - value, room + value, dual[t, i, 0, p], dual[t, i, 1, p]
                inverse, inverse_dual = 1.0 / (up * down), centre / (above * below)
                inverse_up, inverse_down = inverse * down, inverse * up
                change_up, change_down = (common - move) * inverse_up, (common + move) * inverse_down
                before_up, before_down = (common_first - first) * inverse_up, (common_first + first) * inverse_down
                grow_up = inverse_dual * below * inverse_up + before_up * (1.0 + before_up) - change_up - 1.0
                grow_down = inverse_dual * above * inverse_down + before_down * (1.0 + before_down) - change_down - 1.0
                lane[STEP_UP, p], lane[STEP_DOWN, p] = above * grow_up, below * grow_down
                lane[LOSS, p] = max(lane[LOSS, p], max(-change_up, -change_down))
                lane[LOSS_DUAL, p] = max(lane[LOSS_DUAL, p], max(-grow_up, -grow_down))
            for p in range(lanes):
                step[t, i, 0, p], step[t, i, 1, p] = lane[STEP_UP, p], lane[STEP_DOWN, p]
    return float(lane[LOSS].max()), float(lane[LOSS_DUAL].max())

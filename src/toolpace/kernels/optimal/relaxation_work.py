"""The state of the relaxation's iteration, and its steps.

A knot has up to four rows of its own, as slacks that shall not be negative, and multipliers for them:

    CAP    cap - z                              FLOOR  z - low                                     with a range
    WAIT   the wait itself, with rows only      CHORD  chord(z) - 1 / sqrt(z) - wait               with a range and rows

All arrays are worked on in place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Bools, Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.dual import KnotRows
from toolpace.kernels.optimal.multipliers import STATES, TILE, RowSteps, RowTiles, all_wanted, in_tiles, steps_of
from toolpace.kernels.optimal.newton import System, system_of

CAP, WAIT, FLOOR, CHORD = range(4)
"""Own rows of a knot."""
RELIEF_CAP, RELIEF_ACCELERATION, RELIEF_FLOOR, RELIEF_CHORD = range(4)
"""Columns of a relief; a wait needs none."""


class OwnRows(NamedTuple):
    """What the own rows of the knots are."""

    active: Bools
    """(n, 4) which of them a knot has."""
    low: Floats
    """(n,) least z, 0 where unknown."""
    cap: Floats
    """(n,) most z."""
    chord: Floats
    """(n, 2) height and fall of the line through 1 / sqrt(z) at low and cap."""
    relief: Floats
    """(n, 4) of cap, acceleration rows, floor and chord: by how much they are relaxed at first."""


class KnotStates(NamedTuple):
    """Where the iteration is at the knots, and what their own rows are there."""

    at: Floats
    """(n, STATES) as in `multipliers`; the limit of the jerk rows is pace and wait together."""
    wait: Floats
    """(n,) as a pace."""
    slack: Floats
    """(n, 4) of the own rows, relief included."""
    slope: Floats
    """(n, 4) derivative of the slack by z."""
    relaxed: Floats
    """(n, 4) the part of the slack that is relief."""
    dual: Floats
    """(n, 4) multipliers of the own rows."""


class Waits(NamedTuple):
    """What is known of the waits once they are eliminated, and what pulls at them."""

    mean: Floats
    """(n, 3) change of a wait for a change of z, z', z''."""
    stiff: Floats
    """(n,) second derivative by a wait."""
    pull: Floats
    """(n,) first derivative."""
    centring: Floats
    """(n,) what the corrector's is less, times the product of slack and multiplier that is aimed at."""
    second: Floats
    """(n,) what it is less by the second-order terms."""


class KnotSteps(NamedTuple):
    """The steps of predictor and corrector at the knots."""

    affine: Floats
    """(n, 4) the predictor's, of z, z', z'' and wait."""
    change: Floats
    """(n, 4) the corrector's."""
    dual: Floats
    """(n, 4) the corrector's, of the multipliers of the own rows."""


class Points(NamedTuple):
    """What the points know of their knots' waits, and the knots of theirs."""

    knot: Ints
    """(points,) knot of each point."""
    mean: Floats
    """(tiles, 3, TILE) change of the wait for a change of z, z', z''."""
    of_wait: Floats
    """(points, 4) what its jerk rows add to the second derivatives by the wait."""


class Work(NamedTuple):
    """The problem by knots and by rows in tiles, where the iteration is, and what a step of it works on."""

    knots: KnotRows
    own: OwnRows
    states: KnotStates
    waits: Waits
    points: Points
    tiles: RowTiles
    system: System
    knot_steps: KnotSteps
    row_steps: RowSteps


@jit(inline=True)
def work_of(knots: KnotRows, low: Floats, cap: Floats, relief: Floats) -> Work:
    """Room for the iteration."""
    n, tiles = len(low), in_tiles(knots.rows, knots.shift, all_wanted(knots.rows))
    own, points = own_rows_of(knots, low, cap, relief), points_of(knots, tiles)
    states, waits, system = states_of(n), waits_of(n), system_of(n + 2)
    knot_steps, row_steps = knot_steps_of(n), steps_of(tiles)
    return Work(knots, own, states, waits, points, tiles, system, knot_steps, row_steps)


@jit(inline=True)
def own_rows_of(knots: KnotRows, low: Floats, cap: Floats, relief: Floats) -> OwnRows:
    """The own rows of knots with z from low to cap (n,)."""
    n, first = len(low), knots.first
    own = OwnRows(np.empty((n, 4), dtype=np.bool_), low, cap, np.zeros((n, 2)), relief)
    active, chord = own.active, own.chord
    for k in range(n):
        with_rows = first[k] < first[k + 1]
        active[k, CAP], active[k, WAIT] = True, with_rows
        active[k, FLOOR], active[k, CHORD] = low[k] > 0.0, low[k] > 0.0 and with_rows
        if active[k, CHORD]:
            a, b = np.sqrt(low[k]), np.sqrt(cap[k])
            chord[k, 1] = 1.0 / (a * b * (a + b))
            chord[k, 0] = 1.0 / a + chord[k, 1] * low[k]
    return own


@jit(inline=True)
def states_of(n: int) -> KnotStates:
    """Room for the states of n knots; multipliers zero."""
    at, slack, slope = np.empty((n, STATES)), np.empty((n, 4)), np.empty((n, 4))
    return KnotStates(at, np.empty(n), slack, slope, np.empty((n, 4)), np.zeros((n, 4)))


@jit(inline=True)
def waits_of(n: int) -> Waits:
    """Room for what is known of n waits."""
    return Waits(np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n), np.empty(n))


@jit(inline=True)
def knot_steps_of(n: int) -> KnotSteps:
    """Room for the steps of n knots."""
    return KnotSteps(np.empty((n, 4)), np.empty((n, 4)), np.zeros((n, 4)))


@jit(inline=True)
def count_of(own: OwnRows) -> int:
    """How many own rows there are."""
    count = 0
    for k in range(len(own.active)):
        for i in range(4):
            count += own.active[k, i]
    return count


@jit(inline=True)
def points_of(knots: KnotRows, tiles: RowTiles) -> Points:
    """The points of the knots."""
    points = Points(
        np.empty(tiles.points, dtype=np.int64), np.zeros((len(tiles.rows), 3, TILE)), np.empty((tiles.points, 4))
    )
    for k in range(len(knots.weight)):
        points.knot[knots.first[k] : knots.first[k + 1]] = k
    return points

"""Limit rows of path and speed law at the stations of a segment, and the Newton system of its interior-point method.

At each place the change of the path and the pace are described by few numbers: value and derivatives 1 to 3 by time of
the five coordinates of the change, and those up to the second of the pace. Rows depend on these, and through them on
the unknowns of a cell: y[8 l + c] is derivative l of column c, of which 5 is the pace; 6 and 7 are padding, so that all
loops are as long as the vectors of a processor.

The unknowns of the slots follow each other, six a slot, and each cell has six neighbouring slots: row i of the band
(unknowns, 36) holds the entries (i, i), (i, i + 1) to (i, i + 35).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit

SLOT = 6
"""Slots of a cell, and unknowns of a slot: five of the path, the last of the pace."""
PACE = 5
PAD = 8
VALUES = 4 * PAD
"""Of a place."""
WIDTH = SLOT * SLOT
"""Unknowns of a cell."""


class Places(NamedTuple):
    """Where limits are rows: n places, of a machine with m linear and rotary joints."""

    first: Ints
    """(n,) the first slot of the place's cell."""
    basis: Floats
    """(n, 4, 6) derivatives 0 to 3 by t of the functions of the path."""
    pace: Floats
    """(n, 3, 4) derivatives 0 to 2 by t of those of the pace."""
    moved: Floats
    """(n, 4, m, 5) the joints' derivative by the coordinates of the change, and its derivatives 1 to 3 by t."""
    joints: Floats
    """(n, 3, m) velocity, acceleration and jerk of the joints before any change."""
    feed: Floats
    """(n,) ds/dt over what feeds allow."""
    limits: Floats
    """(3, m) of velocity, acceleration and jerk."""


class Felt(NamedTuple):
    """What is felt at the places with some change."""

    z: Floats
    """(n, 3) of the pace, with derivatives 1 and 2 by t."""
    joints: Floats
    """(n, 3, m) velocity, acceleration and jerk of the joints at the pace before."""
    used: Floats
    """(n, 3 m + 1) acceleration, jerk and velocity over their limits, and ds/dt over its own."""


class Balls(NamedTuple):
    """Where the path is held to the program: k places, a ball each for tip and turn."""

    first: Ints
    """(k,) the first slot of the place's cell."""
    start: Ints
    """(cells + 1,) the first place of each cell."""
    basis: Floats
    """(k, 6)"""
    metric: Floats
    """(k, 5, 5) of both balls."""


@jit(reorder=True)
def tell(places: Places, n: int, x: Floats, y: Floats) -> None:
    """Overwrite y (32,) by what coefficients x (slots, 6) are at place n."""
    first = places.first[n]
    y[:] = 0.0
    for order in range(4):
        for k in range(SLOT):
            share = places.basis[n, order, k]
            for c in range(PACE):
                y[PAD * order + c] += share * x[first + k, c]
    for order in range(3):
        for k in range(4):
            y[PAD * order + PACE] += places.pace[n, order, k] * x[first + k + 1, PACE]


@jit(reorder=True)
def feel(places: Places, x: Floats, felt: Felt) -> None:
    """Overwrite what is felt with coefficients x (slots, 6)."""
    m = places.limits.shape[1]
    y = np.empty(VALUES)
    for n in range(len(places.first)):
        tell(places, n, x, y)
        z0, z1, z2 = 1.0 + y[PACE], y[PAD + PACE], y[2 * PAD + PACE]
        felt.z[n, 0], felt.z[n, 1], felt.z[n, 2] = z0, z1, z2
        root = np.sqrt(z0)
        for j in range(m):
            first, second, third = places.joints[n, 0, j], places.joints[n, 1, j], places.joints[n, 2, j]
            for c in range(PACE):
                m0, m1 = places.moved[n, 0, j, c], places.moved[n, 1, j, c]
                m2, m3 = places.moved[n, 2, j, c], places.moved[n, 3, j, c]
                d0, d1, d2, d3 = y[c], y[PAD + c], y[2 * PAD + c], y[3 * PAD + c]
                first += m1 * d0 + m0 * d1
                second += m2 * d0 + 2.0 * m1 * d1 + m0 * d2
                third += m3 * d0 + 3.0 * (m2 * d1 + m1 * d2) + m0 * d3
            felt.joints[n, 0, j], felt.joints[n, 1, j], felt.joints[n, 2, j] = first, second, third
            jerk = third * z0 + 1.5 * second * z1 + 0.5 * first * z2
            felt.used[n, j] = (second * z0 + 0.5 * first * z1) / places.limits[1, j]
            felt.used[n, m + j] = jerk * root / places.limits[2, j]
            felt.used[n, 2 * m + j] = first * root / places.limits[0, j]
        felt.used[n, 3 * m] = places.feed[n] * root


@jit(reorder=True)
def slopes(places: Places, felt: Felt, n: int, g: Floats) -> None:
    """Overwrite g (3 m + 1, 32) by the derivatives of the rows of place n by what tells it; its padding stays zero."""
    m = places.limits.shape[1]
    z0, z1, z2 = felt.z[n, 0], felt.z[n, 1], felt.z[n, 2]
    root, half = np.sqrt(z0), 0.5 / z0
    for j in range(m):
        velocity, acceleration = root / places.limits[0, j], 1.0 / places.limits[1, j]
        jerk = root / places.limits[2, j]
        by_a, by_j, by_v = g[j], g[m + j], g[2 * m + j]
        for c in range(PACE):
            m0, m1 = places.moved[n, 0, j, c], places.moved[n, 1, j, c]
            m2, m3 = places.moved[n, 2, j, c], places.moved[n, 3, j, c]
            by_a[c] = acceleration * (z0 * m2 + 0.5 * z1 * m1)
            by_a[PAD + c] = acceleration * (2.0 * z0 * m1 + 0.5 * z1 * m0)
            by_a[2 * PAD + c] = acceleration * z0 * m0
            by_j[c] = jerk * (z0 * m3 + 1.5 * z1 * m2 + 0.5 * z2 * m1)
            by_j[PAD + c] = jerk * (3.0 * z0 * m2 + 3.0 * z1 * m1 + 0.5 * z2 * m0)
            by_j[2 * PAD + c] = jerk * (3.0 * z0 * m1 + 1.5 * z1 * m0)
            by_j[3 * PAD + c] = jerk * z0 * m0
            by_v[c] = velocity * m1
            by_v[PAD + c] = velocity * m0
        first, second, third = felt.joints[n, 0, j], felt.joints[n, 1, j], felt.joints[n, 2, j]
        by_a[PACE], by_a[PAD + PACE] = acceleration * second, 0.5 * acceleration * first
        by_j[PACE] = jerk * third + half * felt.used[n, m + j]
        by_j[PAD + PACE], by_j[2 * PAD + PACE] = 1.5 * jerk * second, 0.5 * jerk * first
        by_v[PACE] = half * felt.used[n, 2 * m + j]
    g[3 * m, PACE] = half * felt.used[n, 3 * m]


@jit(reorder=True)
def move_rows(places: Places, felt: Felt, move: Floats, rows: Floats) -> None:
    """Overwrite rows (n, 3 m + 1) by how they change with a move (slots, 6), to the first order."""
    y = np.empty(VALUES)
    g = np.zeros((rows.shape[1], VALUES))
    for n in range(len(rows)):
        tell(places, n, move, y)
        slopes(places, felt, n, g)
        for r in range(rows.shape[1]):
            total = 0.0
            for k in range(VALUES):
                total += g[r, k] * y[k]
            rows[n, r] = total


@jit(reorder=True)
def spread(places: Places, n: int, wide: Floats) -> None:
    """Overwrite wide (4, 6, 6) by the derivatives 0 to 3 at place n of what multiplies slot k, column c; what is not
    touched stays zero."""
    for order in range(4):
        for k in range(SLOT):
            for c in range(PACE):
                wide[order, k, c] = places.basis[n, order, k]
    for order in range(3):
        for k in range(4):
            wide[order, k + 1, PACE] = places.pace[n, order, k]


@jit(reorder=True)
def row_of_cell(g: Floats, wide: Floats, share: float, out: Floats) -> None:
    """Overwrite out (36,) by a share of a row g (32,) of a place, by the unknowns of its cell."""
    for k in range(SLOT):
        for c in range(SLOT):
            total = 0.0
            for order in range(4):
                total += g[PAD * order + c] * wide[order, k, c]
            out[SLOT * k + c] = share * total


@jit(reorder=True)
def add_ball(basis: Floats, moment: Floats, block: Floats) -> None:
    """Add the moment (5, 5) of a place of the tube, its basis (6,) on either side, to the block (36, 36)."""
    for k in range(SLOT):
        for c in range(PACE):
            row = block[SLOT * k + c]
            for other in range(k, SLOT):
                pair = basis[k] * basis[other]
                for d in range(PACE):
                    row[SLOT * other + d] += pair * moment[c, d]


@jit()
def matrix(
    places: Places, felt: Felt, weight: Floats, bend: Floats, balls: Balls, moment: Floats, band: Floats
) -> None:
    """Add the Newton matrix to the band (unknowns, 36).

    weight (n, 3 m + 1) of the squared rows, bend (n,) of the squared pace, moment (k, 5, 5) of the balls.
    """
    cells = len(balls.start) - 1
    each, count = len(places.first) // cells, weight.shape[1]
    rows = np.empty((each * (count + 1), WIDTH))
    block = np.empty((WIDTH, WIDTH))
    wide = np.zeros((4, SLOT, SLOT))
    g = np.zeros((count + 1, VALUES))
    g[count, PACE] = 1.0
    for cell in range(cells):
        for k in range(each):
            n = each * cell + k
            spread(places, n, wide)
            slopes(places, felt, n, g)
            for r in range(count):
                row_of_cell(g[r], wide, np.sqrt(weight[n, r]), rows[k * (count + 1) + r])
            row_of_cell(g[count], wide, np.sqrt(bend[n]), rows[k * (count + 1) + count])
        np.dot(rows.T, rows, block)
        for k in range(balls.start[cell], balls.start[cell + 1]):
            add_ball(balls.basis[k], moment[k], block)
        first = SLOT * places.first[each * cell]
        for k in range(WIDTH):
            for other in range(k, WIDTH):
                band[first + k, other - k] += block[k, other]


@jit(reorder=True)
def gradient(
    places: Places, felt: Felt, force: Floats, pull: Floats, balls: Balls, push: Floats, out: Floats
) -> None:
    """Add the gradient to out (slots, 6).

    force (n, 3 m + 1) on the rows, pull (n,) on the pace itself, push (k, 5) on the path where it is held.
    """
    y = np.empty(VALUES)
    g = np.zeros((force.shape[1], VALUES))
    wide = np.zeros((4, SLOT, SLOT))
    for n in range(len(force)):
        spread(places, n, wide)
        slopes(places, felt, n, g)
        y[:] = 0.0
        y[PACE] = pull[n]
        for r in range(force.shape[1]):
            share = force[n, r]
            for k in range(VALUES):
                y[k] += share * g[r, k]
        for order in range(4):
            for k in range(SLOT):
                row = out[places.first[n] + k]
                for c in range(SLOT):
                    row[c] += wide[order, k, c] * y[PAD * order + c]
    for n in range(len(push)):
        for k in range(SLOT):
            row = out[balls.first[n] + k]
            for c in range(PACE):
                row[c] += balls.basis[n, k] * push[n, c]

"""Newton matrix and gradient of a segment, from the rows of its stations and the balls of its tube.

The unknowns of the slots follow each other, six a slot, and each cell has six neighbouring slots: row i of the band
(unknowns, 36) holds the entries (i, i), (i, i + 1) to (i, i + 35).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.path_and_pace.stations import PACE, PAD, SLOT, TOLD, Felt, Places, slopes

WIDTH = SLOT * SLOT
"""Unknowns of a cell."""


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
    places: Places, felt: Felt, weight: Floats, bend: Floats, balls: Balls, moment: Floats, low: int, band: Floats
) -> None:
    """Add the Newton matrix to the band (unknowns, 36), from slot `low` on.

    weight (n, 3 m + 1) of the squared rows, bend (n,) of the squared pace, moment (k, 5, 5) of the balls.
    """
    cells = len(balls.start) - 1
    each, count = len(places.first) // cells, weight.shape[1]
    rows = np.empty((each * (count + 1), WIDTH))
    block = np.empty((WIDTH, WIDTH))
    wide = np.zeros((4, SLOT, SLOT))
    g = np.zeros((count + 1, TOLD))
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
        first = SLOT * (places.first[each * cell] - low)
        for k in range(WIDTH):
            for other in range(k, WIDTH):
                band[first + k, other - k] += block[k, other]


@jit(reorder=True)
def gradient(
    places: Places, felt: Felt, force: Floats, pull: Floats, balls: Balls, push: Floats, low: int, out: Floats
) -> None:
    """Add the gradient to out (slots, 6), from slot `low` on.

    force (n, 3 m + 1) on the rows, pull (n,) on the pace itself, push (k, 5) on the path where it is held.
    """
    y = np.empty(TOLD)
    g = np.zeros((force.shape[1], TOLD))
    wide = np.zeros((4, SLOT, SLOT))
    for n in range(len(force)):
        spread(places, n, wide)
        slopes(places, felt, n, g)
        y[:] = 0.0
        y[PACE] = pull[n]
        for r in range(force.shape[1]):
            share = force[n, r]
            for k in range(TOLD):
                y[k] += share * g[r, k]
        for order in range(4):
            for k in range(SLOT):
                row = out[places.first[n] - low + k]
                for c in range(SLOT):
                    row[c] += wide[order, k, c] * y[PAD * order + c]
    for n in range(len(push)):
        for k in range(SLOT):
            row = out[balls.first[n] - low + k]
            for c in range(PACE):
                row[c] += balls.basis[n, k] * push[n, c]

"""The smoothing spline, of least roughness plus squared deviation, from samples; the system of equations behind it.

A sample has six neighbouring coefficients of g coordinates, the first of them number `first`; unknown (coefficient i,
coordinate c) has number i g + c.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.fit.band import empty, factor, solve
from toolpace.kernels.jit import jit


class Roughness(NamedTuple):
    """What is minimised."""

    third: Floats
    """(cells, 3, 6) rows that integrate the squared third derivative; see `quintic_spline.third_rows`."""
    weight: Floats
    """(g,) of each coordinate."""


class Samples(NamedTuple):
    """Where a spline is compared with its target."""

    first: Ints
    """(m,) first coefficient that matters."""
    rows: Floats
    """(m, 6) basis values."""
    target: Floats
    """(m, g)"""
    metric: Floats
    """(m, g, g) squares of deviations."""


class Tube(NamedTuple):
    """How far the spline may be from its target."""

    radius: Floats
    """(m,)"""
    pull: Floats
    """(m,) weight of the squared deviation beside the roughness: what keeps the Newton matrix regular."""


class Free(NamedTuple):
    """The coefficients low ... high - 1 are free, the others stay."""

    low: int
    high: int


@jit()
def least_squares(rough: Roughness, samples: Samples, x: Floats, free: Free) -> bool:
    """Minimise the roughness plus the squared deviations in the free coefficients of x (n, g); the others stay."""
    third, weight = rough
    first, rows, target, metric = samples
    low, high = free
    g = x.shape[1]
    n = high - low
    band = empty(n * g, 6 * g)
    scatter_roughness(band, third, weight, low)
    scatter_samples(band, first, rows, metric, low)
    if not factor(band):
        return False
    ignored = np.empty(len(third))
    step = np.empty(n * g)
    value = np.empty((len(first), g))
    off = np.empty(g)
    # the second solution takes away the rounding of the first
    for _ in range(2):
        rough_gradient(third, weight, x, low, n, step, ignored)
        gather(first, rows, x, value)
        for j in range(len(first)):
            for c in range(g):
                off[c] = value[j, c] - target[j, c]
            for c in range(g):
                value[j, c] = 0.0
                for d in range(g):
                    value[j, c] += metric[j, c, d] * off[d]
        scatter(first, rows, value, low, n, step)
        solve(band, step)
        for k in range(n):
            for c in range(g):
                x[low + k, c] -= step[k * g + c]
    return True


@jit()
def scatter_roughness(band: Floats, third: Floats, weight: Floats, low: int) -> None:
    """Overwrite the Newton band by the roughness of the free coefficients low, low + 1, ..."""
    g = len(weight)
    n = band.shape[0] // g - 6
    band[:] = 0.0
    for i in range(max(0, low - 5), min(len(third), low + n)):
        base = i - low
        for a in range(max(0, -base), min(6, n - base)):
            for b in range(max(0, -base), a + 1):
                product = 0.0
                for k in range(3):
                    product += third[i, k, a] * third[i, k, b]
                for c in range(g):
                    band[(base + b) * g + c, (a - b) * g] += weight[c] * product


@jit(reorder=True)
def scatter_samples(band: Floats, first: Ints, rows: Floats, moment: Floats, low: int) -> None:
    """Add B_j' M_j B_j of each sample, M_j = moment[j] (g, g), to the Newton band.

    The samples of a cell add up before they go there: 21 products of two basis values with each entry of M_j.
    """
    g = moment.shape[1]
    n = band.shape[0] // g - 6
    pair = np.empty(21)
    total = np.zeros((3, 3, 21))
    for j in range(len(first)):
        k = 0
        for a in range(6):
            for b in range(a + 1):
                pair[k] = rows[j, a] * rows[j, b]
                k += 1
        for c in range(g):
            for d in range(c + 1):
                share = moment[j, c, d]
                line = total[c, d]
                for k in range(21):
                    line[k] += share * pair[k]
        if j + 1 < len(first) and first[j + 1] == first[j]:
            continue
        base = first[j] - low
        begin = max(0, -base)
        end = min(6, n - base)
        for b in range(begin, end):
            for d in range(g):
                line = band[(base + b) * g + d]
                for c in range(d, g):
                    line[c - d] += total[c, d, b * (b + 1) // 2 + b]
                for a in range(b + 1, end):
                    k = a * (a + 1) // 2 + b
                    for c in range(g):
                        line[(a - b) * g + c - d] += total[max(c, d), min(c, d), k]
        total[:] = 0.0


@jit()
def gather(first: Ints, rows: Floats, x: Floats, out: Floats) -> None:
    """B_j x for each sample into out (m, g)."""
    for j in range(len(first)):
        for c in range(x.shape[1]):
            total = 0.0
            for k in range(6):
                total += rows[j, k] * x[first[j] + k, c]
            out[j, c] = total


@jit()
def scatter(first: Ints, rows: Floats, values: Floats, low: int, n: int, out: Floats) -> None:
    """Add sum_j B_j' values_j to out (n * g,), for the free coefficients low ... low + n - 1."""
    g = values.shape[1]
    for j in range(len(first)):
        base = first[j] - low
        for a in range(max(0, -base), min(6, n - base)):
            for c in range(g):
                out[(base + a) * g + c] += rows[j, a] * values[j, c]


@jit()
def rough_gradient(third: Floats, weight: Floats, x: Floats, low: int, n: int, out: Floats, value: Floats) -> None:
    """Overwrite out (n * g,) by the gradient of the roughness, and value (cells,) by its share of each cell in reach.

    By way of the third derivatives, whose squares do not cancel where the product of x with the band would.
    """
    g = len(weight)
    out[:] = 0.0
    for i in range(max(0, low - 5), min(len(third), low + n)):
        base = i - low
        value[i] = 0.0
        for k in range(3):
            for c in range(g):
                bend = 0.0
                for a in range(6):
                    bend += third[i, k, a] * x[i + a, c]
                value[i] += 0.5 * weight[c] * bend * bend
                bend *= weight[c]
                for a in range(max(0, -base), min(6, n - base)):
                    out[(base + a) * g + c] += third[i, k, a] * bend

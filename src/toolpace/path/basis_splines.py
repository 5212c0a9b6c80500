"""The B-splines that are not zero at a place, with derivatives: de Boor, A Practical Guide to Splines, chapter X.

In arrays, and to the bit what scipy.interpolate.BSpline gives; that import takes half as long as a short plan.
"""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats, Ints


def cells_of(knots: Floats, degree: int, at: Floats) -> Ints:
    """(n,) the cell k of each place, knots[k] <= at < knots[k + 1]; of a place outside the first or last one.

    knots (m,) not falling, at (n,).
    """
    cell = np.searchsorted(knots, at, side="right") - 1
    return np.asarray(np.clip(cell, degree, len(knots) - degree - 2), dtype=np.int64)


def nonzero_basis(knots: Floats, degree: int, cell: Ints, at: Floats, order: int = 0) -> Floats:
    """(n, degree + 1) a derivative of the B-splines cell - degree to cell, at places (n,) in cells (n,).

    The cells are not empty: then no difference of knots is zero.
    """
    basis = np.zeros((degree + 1, len(at)))
    basis[0] = 1.0
    for j in range(1, degree + 1):
        lower = basis[:j].copy()
        basis[0] = 0.0
        for n in range(1, j + 1):
            right, left = knots[cell + n], knots[cell + n - j]
            if j <= degree - order:
                weight = lower[n - 1] / (right - left)
                basis[n - 1] += weight * (right - at)
                basis[n] = weight * (at - left)
            else:
                weight = j * lower[n - 1] / (right - left)
                basis[n - 1] -= weight
                basis[n] = weight
    return np.ascontiguousarray(basis.T)


def spline_values(knots: Floats, coefficients: Floats, degree: int, at: Floats, order: int = 0) -> Floats:
    """(n, ...) a derivative of the spline with coefficients (m - degree - 1, ...) over knots (m,) at places (n,)."""
    cell = cells_of(knots, degree, at)
    basis = nonzero_basis(knots, degree, cell, at, order)
    value = np.zeros((len(at), *coefficients.shape[1:]))
    for k in range(degree + 1):
        weight = basis[:, k].reshape(-1, *[1] * (coefficients.ndim - 1))
        value += coefficients[cell - degree + k] * weight
    return value

"""Bounds of polynomial pieces from their control points (convex hull property)."""

from __future__ import annotations

from math import comb

import numpy as np

from toolpace.common.arrays import Floats


def second_derivative_bounds(powers: Floats, width: Floats) -> Floats:
    """(n,) most |P''| on each of n pieces (n, degree + 1, 3), in powers of u from 0 to `width` (n,).

    The largest control point of P'' in Bernstein form.
    """
    degree = powers.shape[1] - 1
    if degree < 2:
        return np.zeros(len(powers))
    second = [k * (k - 1) * powers[:, k] * width[:, None] ** (k - 2) for k in range(2, degree + 1)]
    most = np.zeros(len(powers))
    for j in range(degree - 1):
        control = sum(comb(j, k) / comb(degree - 2, k) * second[k] for k in range(j + 1))
        most = np.maximum(most, np.linalg.norm(control, axis=1))
    return most

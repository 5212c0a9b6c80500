"""Clamped cubic B-splines at their knots: three coefficients a knot.

coefficients   c_0   c_1   c_2   c_3  ...  c_n+1
knots            x_0   x_1   x_2  ...  x_n-1           knot k is touched by c_k, c_k+1, c_k+2
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit


@jit()
def basis_at_knots(x: Floats) -> Floats:
    """Values and two derivatives of the three basis functions at each knot.

    x (n,) increasing. Returns (n, 3, 3): row d gives the d-th derivative at knot k from c_k, c_k+1, c_k+2.
    """
    n = len(x)
    knots = np.empty(n + 6)
    knots[:3] = x[0]
    copy(x, knots[3:])
    knots[n + 3 :] = x[n - 1]
    basis = np.zeros((n, 3, 3))
    for k in range(n):
        left, here, right = knots[k + 2], knots[k + 3], knots[k + 4]
        slope0 = 3.0 / (right - knots[k + 1])
        slope1 = 3.0 / (knots[k + 5] - left)
        curve = 2.0 / (right - left)
        weight = (here - left) / (right - left)
        basis[k, 2, 0] = curve * slope0
        basis[k, 2, 1] = -curve * (slope0 + slope1)
        basis[k, 2, 2] = curve * slope1
        basis[k, 1, 0] = -(1.0 - weight) * slope0
        basis[k, 1, 1] = (1.0 - weight) * slope0 - weight * slope1
        basis[k, 1, 2] = weight * slope1
        basis[k, 0, 0] = (1.0 - weight) * (right - here) / (right - knots[k + 1])
        basis[k, 0, 2] = weight * (here - left) / (knots[k + 5] - left)
        basis[k, 0, 1] = 1.0 - basis[k, 0, 0] - basis[k, 0, 2]
    return basis


@jit()
def basis_between(x: Floats, cell: Ints, place: Floats) -> Floats:
    """Values and two derivatives of the four basis functions (k, 3, 4) at places (k,) in cells (k,) between knots (n,).

    Row d gives the d-th derivative from c_j, c_j+1, c_j+2, c_j+3 of cell j, in which the third is constant.
    """
    ends = basis_at_knots(x)
    out = np.empty((len(place), 3, 4))
    for p in range(len(place)):
        j = cell[p]
        h, length = place[p] - x[j], x[j + 1] - x[j]
        for i in range(4):
            z0, z1, z2 = (ends[j, 0, i], ends[j, 1, i], ends[j, 2, i]) if i < 3 else (0.0, 0.0, 0.0)
            third = ((ends[j + 1, 2, i - 1] if i > 0 else 0.0) - z2) / length
            out[p, 2, i] = z2 + h * third
            out[p, 1, i] = z1 + h * (z2 + h / 2.0 * third)
            out[p, 0, i] = z0 + h * (z1 + h / 2.0 * (z2 + h / 3.0 * third))
    return out


@jit()
def at_knots(basis: Floats, c: Floats) -> Floats:
    """Value and two derivatives (n, 3) at the knots of the spline with coefficients c (n + 2,)."""
    n = len(basis)
    out = np.empty((n, 3))
    for k in range(n):
        for d in range(3):
            out[k, d] = basis[k, d, 0] * c[k] + basis[k, d, 1] * c[k + 1] + basis[k, d, 2] * c[k + 2]
    return out


@jit()
def control_points(x: Floats) -> Floats:
    """Greville abscissae (n + 2,): where each coefficient of the spline over the knots x (n,) has its say."""
    n = len(x)
    out = np.empty(n + 2)
    for i in range(n + 2):
        total = 0.0
        for k in range(i - 2, i + 1):
            total += x[min(max(k, 0), n - 1)]
        out[i] = total / 3.0
    return out


@jit()
def on_finer_knots(x: Floats, cells: Floats, finer: Floats) -> Floats:
    """Coefficients (m + 2,) over the knots `finer` (m,), which hold all of x (n,), of the spline with these cells.

    `cells` (n - 1, 4) are its pieces as powers of s - x[k]. A coefficient is the blossom of a piece at three
    consecutive knots (Ramshaw, 1989).
    """
    n, m = len(x), len(finer)
    out = np.empty(m + 2)
    k = 0
    for i in range(m + 2):
        middle = finer[min(max(i - 1, 0), m - 1)]
        while k < n - 2 and x[k + 1] <= middle:
            k += 1
        u = finer[min(max(i - 2, 0), m - 1)] - x[k]
        v = middle - x[k]
        w = finer[min(i, m - 1)] - x[k]
        a = cells[k]
        out[i] = a[0] + a[1] * (u + v + w) / 3.0 + a[2] * (u * v + v * w + w * u) / 3.0 + a[3] * u * v * w
    return out

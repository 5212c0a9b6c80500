"""Quintic B-splines: basis functions, roughness, pieces as polynomials.

A spline over the knots t[0..n+5] (first and last knot six-fold) has n coefficients; in the cell [t[i], t[i+1]) the
six basis functions i - 5 ... i differ from zero. Evaluation goes through the pieces: Horner's rule in the cell.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit


@jit()
def basis(t: Floats, i: int, x: float, order: int, out: Floats) -> None:
    """Derivative `order` of the six basis functions of cell i at x into out[:6].

    Cox and de Boor's recursion up to degree 5 - order, then that of the derivative (de Boor 1978, X(8) and X(12)).
    """
    low = 5 - order
    out[0] = 1.0
    for p in range(1, low + 1):
        carried = 0.0
        for k in range(p):
            right = t[i + k + 1]
            left = t[i + 1 - p + k]
            share = out[k] / (right - left)
            out[k] = carried + (right - x) * share
            carried = (x - left) * share
        out[p] = carried
    for p in range(low + 1, 6):
        carried = 0.0
        for k in range(p):
            share = p * out[k] / (t[i + k + 1] - t[i + 1 - p + k])
            out[k] = carried - share
            carried = share
        out[p] = carried


@jit()
def cells(t: Floats, x: Floats) -> Ints:
    """Index i of the cell [t[i], t[i+1]) of each of the ascending x; the last knot belongs to the last cell."""
    last = len(t) - 7
    out = np.empty(len(x), np.int64)
    i = 5
    for j in range(len(x)):
        while i < last and x[j] >= t[i + 1]:
            i += 1
        out[j] = i
    return out


@jit()
def basis_rows(t: Floats, x: Floats) -> tuple[Ints, Floats]:
    """First coefficient (m,) and the six basis values (m, 6) at each of the ascending x."""
    first = cells(t, x)
    rows = np.empty((len(x), 6))
    for j in range(len(x)):
        basis(t, first[j], x[j], 0, rows[j])
        first[j] -= 5
    return first, rows


@jit()
def third_rows(t: Floats) -> Floats:
    """Rows (cells, 3, 6) whose products with the coefficients, squared and summed, integrate (d3/ds3)^2 in a cell.

    The integrand is of degree four in a cell: three Gauss points are exact.
    """
    n = len(t) - 6
    out = np.empty((n - 5, 3, 6))
    place = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
    weight = np.sqrt(np.array([5.0, 8.0, 5.0]) / 18.0)
    for i in range(5, n):
        h = t[i + 1] - t[i]
        for g in range(3):
            basis(t, i, 0.5 * (t[i] + t[i + 1] + place[g] * h), 3, out[i - 5, g])
            share = np.sqrt(h) * weight[g]
            for k in range(6):
                out[i - 5, g, k] *= share
    return out


@jit()
def pieces(t: Floats, x: Floats) -> Floats:
    """Taylor coefficients (cells, 6, d) at the left end of each cell, of the spline with coefficients x (n, d)."""
    n, d = x.shape
    out = np.zeros((n - 5, 6, d))
    row = np.empty(6)
    for i in range(5, n):
        factor = 1.0
        for order in range(6):
            if order > 0:
                factor /= order
            basis(t, i, t[i], order, row)
            for k in range(6):
                for c in range(d):
                    out[i - 5, order, c] += factor * row[k] * x[i - 5 + k, c]
    return out


@jit()
def jets(breaks: Floats, coefficients: Floats, s: Floats) -> Floats:
    """Values and derivatives 1 to 3, (4, n, d), of a piecewise quintic at s (n,): at a break those of its right.

    Ascending s are found in constant time each, others by bisection.
    """
    d = coefficients.shape[2]
    last = len(breaks) - 2
    out = np.empty((4, len(s), d))
    i = 0
    for j in range(len(s)):
        if s[j] < breaks[i] or (i < last and s[j] >= breaks[i + 1]):
            if i < last - 1 and s[j] >= breaks[i + 1] and s[j] < breaks[i + 2]:
                i += 1
            else:
                low, high = 0, last
                while low < high:
                    middle = (low + high + 1) // 2
                    if s[j] >= breaks[middle]:
                        low = middle
                    else:
                        high = middle - 1
                i = low
        u = s[j] - breaks[i]
        for c in range(d):
            c0 = coefficients[i, 0, c]
            c1 = coefficients[i, 1, c]
            c2 = coefficients[i, 2, c]
            c3 = coefficients[i, 3, c]
            c4 = coefficients[i, 4, c]
            c5 = coefficients[i, 5, c]
            out[0, j, c] = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
            out[1, j, c] = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))
            out[2, j, c] = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))
            out[3, j, c] = 6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)
    return out


@jit()
def values(breaks: Floats, coefficients: Floats, s: Floats) -> Floats:
    """Values (n, d) of a piecewise quintic at the ascending s (n,)."""
    d = coefficients.shape[2]
    last = len(breaks) - 2
    out = np.empty((len(s), d))
    i = 0
    for j in range(len(s)):
        while i < last and s[j] >= breaks[i + 1]:
            i += 1
        u = s[j] - breaks[i]
        for c in range(d):
            total = coefficients[i, 5, c]
            for order in range(4, -1, -1):
                total = coefficients[i, order, c] + u * total
            out[j, c] = total
    return out


@jit()
def recast(breaks: Floats, coefficients: Floats, t: Floats) -> Floats:
    """Coefficients (n, d) over the finer knots t of a spline given by its pieces: knots put in change no value.

    The coefficient is the blossom of a piece in its support at the five inner knots (Ramshaw 1987).
    """
    n, d = len(t) - 6, coefficients.shape[2]
    last = len(breaks) - 2
    out = np.empty((n, d))
    symmetric = np.empty(6)
    share = np.array([1.0, 5.0, 10.0, 10.0, 5.0, 1.0])
    i = 0
    for k in range(n):
        cell = k + 2
        for other in (3, 1, 4, 0, 5):
            if not t[cell + 1] > t[cell]:
                cell = k + other
        x = 0.5 * (t[cell] + t[cell + 1])
        while i > 0 and x < breaks[i]:
            i -= 1
        while i < last and x >= breaks[i + 1]:
            i += 1
        symmetric[:] = 0.0
        symmetric[0] = 1.0
        for a in range(5):
            for m in range(a + 1, 0, -1):
                symmetric[m] += (t[k + 1 + a] - breaks[i]) * symmetric[m - 1]
        for c in range(d):
            out[k, c] = 0.0
            for m in range(6):
                out[k, c] += coefficients[i, m, c] * symmetric[m] / share[m]
    return out


@jit()
def thin(s: Floats, spacing: float) -> Floats:
    """Some of the ascending s, the first and the last among them, each at least `spacing` from the one before."""
    out = np.empty(len(s))
    out[0] = s[0]
    n = 1
    for j in range(1, len(s) - 1):
        if s[j] >= out[n - 1] + spacing and s[len(s) - 1] - s[j] >= 0.5 * spacing:
            out[n] = s[j]
            n += 1
    out[n] = s[len(s) - 1]
    return out[: n + 1].copy()

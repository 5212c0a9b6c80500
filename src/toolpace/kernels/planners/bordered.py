"""Banded positive definite matrices with two full columns: Cholesky factorisation in place.

[ H  E ] [x]   [b]        H (n, n) banded, stored by rows (n, width + 1): entry d of row i is H[i, i - width + d]
[ E' D ] [w] = [c]        E (n, 2), D (2, 2)
"""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit(reorder=True)
def factor(band: Floats) -> int:
    """Overwrite a band (n, width + 1) by its Cholesky factor. Returns 0, or the 1-based row that is not positive."""
    n, width = len(band), band.shape[1] - 1
    for i in range(n):
        row = band[i]
        for j in range(max(i - width, 0), i):
            other = band[j]
            # both rows begin at the column where the later one does
            shift = i - j
            first = max(i - width, 0)
            total = row[j - i + width]
            for k in range(first - i + width, j - i + width):
                total -= row[k] * other[k + shift]
            row[j - i + width] = total / other[width]
        total = row[width]
        for k in range(width):
            total -= row[k] * row[k]
        if not total > 0.0:
            return i + 1
        row[width] = math.sqrt(total)
    return 0


@jit(reorder=True)
def solve(band: Floats, b: Floats) -> None:
    """Overwrite b (n,) by the solution, given the factor of `factor`."""
    n, width = len(band), band.shape[1] - 1
    for i in range(n):
        total = b[i]
        for k in range(max(width - i, 0), width):
            total -= band[i, k] * b[i - width + k]
        b[i] = total / band[i, width]
    for i in range(n - 1, -1, -1):
        b[i] /= band[i, width]
        for k in range(max(width - i, 0), width):
            b[i - width + k] -= band[i, k] * b[i]


@jit()
def solve_bordered(band: Floats, border: Floats, corner: Floats, b: Floats, c: Floats, work: Floats) -> int:
    """Overwrite b (n,) and c (2,) by the solution, and the matrix by what is made of it; work (2, n).

    Returns 0, or what `factor` says.
    """
    bad = factor(band)
    if bad:
        return bad
    n = len(b)
    solve(band, b)
    for d in range(2):
        for i in range(n):
            work[d, i] = border[i, d]
        solve(band, work[d])
    for d in range(2):
        for i in range(n):
            c[d] -= border[i, d] * b[i]
            for e in range(2):
                corner[d, e] -= border[i, d] * work[e, i]
    det = corner[0, 0] * corner[1, 1] - corner[0, 1] * corner[1, 0]
    if not det > 0.0:
        return n + 1
    first = (corner[1, 1] * c[0] - corner[0, 1] * c[1]) / det
    c[1] = (corner[0, 0] * c[1] - corner[1, 0] * c[0]) / det
    c[0] = first
    for i in range(n):
        b[i] -= work[0, i] * c[0] + work[1, i] * c[1]
    return 0

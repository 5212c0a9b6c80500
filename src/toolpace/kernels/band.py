"""Symmetric banded systems: Cholesky factor and solution, rows stored from the first of the band to the diagonal."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from toolpace.kernels.jit import jit

Floats = npt.NDArray[np.float64]


@jit(reorder=True)
def factor(a: Floats) -> bool:
    """Replace the lower band a (n, w), entry [r, w - 1 - r + c] for (r, c), by its Cholesky factor.

    The diagonal of the factor is stored inverted. Rows that depend on earlier ones within rounding are held still;
    False where a diagonal entry is not positive.
    """
    n, w = a.shape
    for r in range(n):
        start = max(0, r - w + 1)
        row = a[r]
        shift = w - 1 - r
        for c in range(start, r):
            other = a[c]
            begin = max(start, c - w + 1)
            length = c - begin
            p = begin + shift
            q = begin + w - 1 - c
            total = row[c + shift]
            for k in range(length):
                total -= row[p + k] * other[q + k]
            row[c + shift] = total * other[w - 1]
        total = row[w - 1]
        least = 1e-15 * total
        for k in range(start + shift, w - 1):
            total -= row[k] * row[k]
        if not total > least:
            if not least > 0.0:
                return False
            total = 1e100  # lost to rounding: this unknown stays where it is
        row[w - 1] = 1.0 / np.sqrt(total)
    return True


@jit(reorder=True)
def solve(a: Floats, b: Floats) -> None:
    """Replace b (n,) by the solution, with the factor a of `factor`."""
    n, w = a.shape
    for r in range(n):
        start = max(0, r - w + 1)
        shift = w - 1 - r
        total = b[r]
        for c in range(start, r):
            total -= a[r, c + shift] * b[c]
        b[r] = total * a[r, w - 1]
    for r in range(n - 1, -1, -1):
        value = b[r] * a[r, w - 1]
        b[r] = value
        start = max(0, r - w + 1)
        shift = w - 1 - r
        for c in range(start, r):
            b[c] -= a[r, c + shift] * value

"""Symmetric positive definite matrices with seven diagonals: LDL' without pivoting, in place.

Stored as four rows (4, n): the diagonal, and the entries (i, i + 1), (i, i + 2) and (i, i + 3).
"""

from __future__ import annotations

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit()
def factor(matrix: Floats) -> int:
    """Factor in place. Returns 0, or the 1-based index of the first pivot that is not positive."""
    n = matrix.shape[1]
    diagonal, first, second, third = matrix[0], matrix[1], matrix[2], matrix[3]
    for i in range(n):
        pivot = diagonal[i]
        if not pivot > 0.0:
            return i + 1
        inverse = 1.0 / pivot
        low1, low2, low3 = first[i] * inverse, second[i] * inverse, third[i] * inverse
        if i + 1 < n:
            diagonal[i + 1] -= low1 * first[i]
            first[i + 1] -= low1 * second[i]
            second[i + 1] -= low1 * third[i]
        if i + 2 < n:
            diagonal[i + 2] -= low2 * second[i]
            first[i + 2] -= low2 * third[i]
        if i + 3 < n:
            diagonal[i + 3] -= low3 * third[i]
        diagonal[i], first[i], second[i], third[i] = inverse, low1, low2, low3
    return 0


@jit()
def solve(factors: Floats, b: Floats) -> None:
    """Overwrite b (n,) by the solution, given the factors of `factor`."""
    n = factors.shape[1]
    inverse, low1, low2, low3 = factors[0], factors[1], factors[2], factors[3]
    for i in range(n):
        if i + 1 < n:
            b[i + 1] -= low1[i] * b[i]
        if i + 2 < n:
            b[i + 2] -= low2[i] * b[i]
        if i + 3 < n:
            b[i + 3] -= low3[i] * b[i]
    for i in range(n - 1, -1, -1):
        value = b[i] * inverse[i]
        if i + 1 < n:
            value -= low1[i] * b[i + 1]
        if i + 2 < n:
            value -= low2[i] * b[i + 2]
        if i + 3 < n:
            value -= low3[i] * b[i + 3]
        b[i] = value

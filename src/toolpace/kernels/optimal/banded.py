"""Symmetric positive definite matrices with five or seven diagonals: LDL' without pivoting, in place.

Stored as three or four rows (w, n): the diagonal, the entries (i, i + 1), the entries (i, i + 2), and so on.
"""

from __future__ import annotations

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit


@jit()
def factor(matrix: Floats) -> int:
    """Factor in place. Returns 0, or the 1-based index of the first pivot that is not positive."""
    if len(matrix) == 3:
        return _factor_five(matrix)
    return _factor_seven(matrix)


@jit(inline=True)
def _factor_five(matrix: Floats) -> int:
    """Factor (3, n) in place."""
    n = matrix.shape[1]
    diagonal, first, second = matrix[0], matrix[1], matrix[2]
    for i in range(n):
        pivot = diagonal[i]
        if not pivot > 0.0:
            return i + 1
        inverse = 1.0 / pivot
        low1, low2 = first[i] * inverse, second[i] * inverse
        if i + 1 < n:
            diagonal[i + 1] -= low1 * first[i]
            first[i + 1] -= low1 * second[i]
        if i + 2 < n:
            diagonal[i + 2] -= low2 * second[i]
        diagonal[i], first[i], second[i] = inverse, low1, low2
    return 0


@jit(inline=True)
def _factor_seven(matrix: Floats) -> int:
    """Factor (4, n) in place."""
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
    if len(factors) == 3:
        _solve_five(factors, b)
    else:
        _solve_seven(factors, b)


@jit(inline=True)
def _solve_five(factors: Floats, b: Floats) -> None:
    """Solve with the factors (3, n)."""
    n = factors.shape[1]
    inverse, low1, low2 = factors[0], factors[1], factors[2]
    for i in range(n):
        if i + 1 < n:
            b[i + 1] -= low1[i] * b[i]
        if i + 2 < n:
            b[i + 2] -= low2[i] * b[i]
    for i in range(n - 1, -1, -1):
        value = b[i] * inverse[i]
        if i + 1 < n:
            value -= low1[i] * b[i + 1]
        if i + 2 < n:
            value -= low2[i] * b[i + 2]
        b[i] = value


@jit(inline=True)
def _solve_seven(factors: Floats, b: Floats) -> None:
    """Solve with the factors (4, n)."""
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

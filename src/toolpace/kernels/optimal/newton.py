"""Newton systems over the coefficients of a cubic spline, and the LDL' factors of their matrices.

A point sees three coefficients at a knot, and four inside a cell, through its basis: row d gives the d-th derivative of
z there. So a Newton matrix has seven diagonals, stored as four rows (4, n): the diagonal, and the entries (i, i + 1),
(i, i + 2) and (i, i + 3). It is factored in place without pivoting. At an end at rest the two outermost coefficients
are tied to each other, at an end in motion both are fixed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit

REST, MOVING = 0, 1


class Ends(NamedTuple):
    """How a run starts and ends: what ties or gives the two outermost coefficients on either side."""

    end: Ints
    """(2,) REST or MOVING."""
    ratio: Floats
    """(2,) c_1 / c_0 and c_n-2 / c_n-1, where that end is at rest."""
    fixed: Floats
    """(4,) c_0, c_1, c_n-2 and c_n-1, where that end is in motion."""


class System(NamedTuple):
    """A Newton system over n coefficients, and what a predictor and a corrector make of its right-hand side."""

    matrix: Floats
    """(4, n) its diagonals; after `factor_tied` its factors."""
    spare: Floats
    """(4, n) the matrix as it was before it was factored."""
    rhs: Floats
    """(n,) the predictor's right-hand side: for a centring of zero."""
    centring: Floats
    """(n,) what the corrector's is less, times the product of slack and multiplier that is aimed at."""
    second: Floats
    """(n,) what it is less by the second-order terms that the predictor revealed."""
    direction: Floats
    """(n,) a right-hand side; solved, the step of the coefficients."""


@jit(inline=True)
def system_of(n: int) -> System:
    """Room for the system of n coefficients."""
    matrix, spare, rhs, centring = np.empty((4, n)), np.empty((4, n)), np.empty(n), np.empty(n)
    return System(matrix, spare, rhs, centring, np.empty(n), np.empty(n))


@jit()
def add_curvature(
    basis: Floats, p: int, k: int, curvature: tuple[float, float, float, float, float, float], matrix: Floats
) -> None:
    """Add to the matrix the second derivatives by (z, z', z'') of the point p, whose coefficients begin at k.

    They are 00, 01, 02, 11, 12, 22.
    """
    m00, m01, m02, m11, m12, m22 = curvature
    for i in range(3):
        e0, e1, e2 = basis[p, 0, i], basis[p, 1, i], basis[p, 2, i]
        t0 = e0 * m00 + e1 * m01 + e2 * m02
        t1 = e0 * m01 + e1 * m11 + e2 * m12
        t2 = e0 * m02 + e1 * m12 + e2 * m22
        for j in range(i, 3):
            matrix[j - i, k + i] += t0 * basis[p, 0, j] + t1 * basis[p, 1, j] + t2 * basis[p, 2, j]


@jit()
def add_curvature_inside(
    basis: Floats, p: int, k: int, curvature: tuple[float, float, float, float, float, float], matrix: Floats
) -> None:
    """The same by the fourth coefficient of the point."""
    m00, m01, m02, m11, m12, m22 = curvature
    e0, e1, e2 = basis[p, 0, 3], basis[p, 1, 3], basis[p, 2, 3]
    t0 = e0 * m00 + e1 * m01 + e2 * m02
    t1 = e0 * m01 + e1 * m11 + e2 * m12
    t2 = e0 * m02 + e1 * m12 + e2 * m22
    for i in range(4):
        matrix[3 - i, k + i] += t0 * basis[p, 0, i] + t1 * basis[p, 1, i] + t2 * basis[p, 2, i]


@jit()
def add_slope(basis: Floats, p: int, k: int, slope: tuple[float, float, float], vector: Floats) -> None:
    """Add to the vector the first derivatives by (z, z', z'') of the point p, whose coefficients begin at k."""
    g0, g1, g2 = slope
    for i in range(3):
        vector[k + i] += basis[p, 0, i] * g0 + basis[p, 1, i] * g1 + basis[p, 2, i] * g2


@jit(inline=True)
def tie_matrix(matrix: Floats, ends: Ends) -> None:
    """Take the coefficients that an end fixes out of the Newton matrix.

    At rest c_1 = ratio[0] c_0, so c_0 is eliminated; in motion c_0 and c_1 are given. The last two likewise.
    """
    diagonal, first = matrix[0], matrix[1]
    width, n = matrix.shape
    if ends.end[0] == REST:
        a = 1.0 / ends.ratio[0]
        diagonal[1] += 2.0 * a * first[0] + a * a * diagonal[0]
        for i in range(2, width):
            matrix[i - 1, 1] += a * matrix[i, 0]
    else:
        _take_out(matrix, 1)
    _take_out(matrix, 0)
    if ends.end[1] == REST:
        a = 1.0 / ends.ratio[1]
        diagonal[n - 2] += 2.0 * a * first[n - 2] + a * a * diagonal[n - 1]
        for i in range(2, width):
            matrix[i - 1, n - 1 - i] += a * matrix[i, n - 1 - i]
    else:
        _take_out(matrix, n - 2)
    _take_out(matrix, n - 1)


@jit(inline=True)
def _take_out(matrix: Floats, k: int) -> None:
    """Make row and column k those of the identity."""
    width, n = matrix.shape
    matrix[0, k] = 1.0
    for i in range(1, width):
        if k + i < n:
            matrix[i, k] = 0.0
        if k - i >= 0:
            matrix[i, k - i] = 0.0


@jit()
def tie_vector(b: Floats, ends: Ends) -> None:
    """The same elimination for a right-hand side or a gradient (n,)."""
    n = len(b)
    b[1] = b[1] + b[0] / ends.ratio[0] if ends.end[0] == REST else 0.0
    b[n - 2] = b[n - 2] + b[n - 1] / ends.ratio[1] if ends.end[1] == REST else 0.0
    b[0] = b[n - 1] = 0.0


@jit()
def factor_tied(system: System, ends: Ends) -> bool:
    """Tie the matrix and factor it in place; where rounding spoils a pivot, with a diagonal raised by just enough.

    Returns whether it could be factored.
    """
    matrix, spare = system.matrix, system.spare
    tie_matrix(matrix, ends)
    copy(matrix.reshape(-1), spare.reshape(-1))
    raised = 1e-13
    while factor(matrix) != 0:
        if raised > 1e-4:
            return False
        copy(spare.reshape(-1), matrix.reshape(-1))
        for k in range(matrix.shape[1]):
            matrix[0, k] *= 1.0 + raised
        raised *= 30.0
    return True


@jit(inline=True)
def _solve_tied(system: System, ends: Ends) -> None:
    """Overwrite the right-hand side in `direction` by the Newton step, with the coefficients that the ends tie."""
    direction = system.direction
    n = len(direction)
    tie_vector(direction, ends)
    solve(system.matrix, direction)
    if ends.end[0] == REST:
        direction[0] = direction[1] / ends.ratio[0]
    if ends.end[1] == REST:
        direction[n - 1] = direction[n - 2] / ends.ratio[1]


@jit(inline=True)
def aim_at_optimum(system: System, ends: Ends) -> None:
    """Set the predictor's direction: straight at the optimum."""
    copy(system.rhs, system.direction)
    _solve_tied(system, ends)


@jit(inline=True)
def aim_at_centre(system: System, ends: Ends, centre: float) -> None:
    """Set the corrector's direction: at products of slack and multiplier of `centre`, with the second-order terms."""
    copy(system.rhs - centre * system.centring - system.second, system.direction)
    _solve_tied(system, ends)


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

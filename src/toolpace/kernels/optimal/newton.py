"""Newton systems over the coefficients of a cubic spline.

A point sees three coefficients at a knot, and four inside a cell, through its basis: row d gives the d-th derivative of
z there. So a Newton matrix has seven diagonals, stored as (4, n) for `banded`. At an end at rest
the two outermost coefficients are tied to each other, at an end in motion both are given.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.banded import factor, solve

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

"""Newton systems over the coefficients of a cubic spline: sums over points, and the ends of a run.

A point at knot k sees the coefficients k, k + 1, k + 2 through its basis (3, 3): row d gives the d-th derivative of z
there. So a Newton matrix has five diagonals, stored as (3, n) for `pentadiagonal`. At an end at rest
the two outermost coefficients are tied to each other, at an end in motion both are given.
"""

from __future__ import annotations

from typing import Any

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.pentadiagonal import factor, solve

REST, MOVING = 0, 1


@jit()
def add_curvature(
    basis: Any, p: Any, k: Any, m00: Any, m01: Any, m02: Any, m11: Any, m12: Any, m22: Any, matrix: Any
) -> Any:
    """Add to the matrix the second derivatives by (z, z', z'') of the point p at knot k."""
    for i in range(3):
        e0, e1, e2 = basis[p, 0, i], basis[p, 1, i], basis[p, 2, i]
        t0 = e0 * m00 + e1 * m01 + e2 * m02
        t1 = e0 * m01 + e1 * m11 + e2 * m12
        t2 = e0 * m02 + e1 * m12 + e2 * m22
        for j in range(i, 3):
            matrix[j - i, k + i] += t0 * basis[p, 0, j] + t1 * basis[p, 1, j] + t2 * basis[p, 2, j]


@jit()
def add_slope(basis: Any, p: Any, k: Any, g0: Any, g1: Any, g2: Any, vector: Any) -> Any:
    """Add to the vector the first derivatives by (z, z', z'') of the point p at knot k."""
    for i in range(3):
        vector[k + i] += basis[p, 0, i] * g0 + basis[p, 1, i] * g1 + basis[p, 2, i] * g2


@jit()
def tie_matrix(matrix: Any, end: Any, ratio: Any) -> Any:
    """Take the coefficients that an end fixes out of the Newton matrix.

    At rest c_1 = ratio[0] c_0, so c_0 is eliminated; in motion c_0 and c_1 are given. The last two likewise.
    """
    diagonal, first, second = matrix[0], matrix[1], matrix[2]
    n = len(diagonal)
    if end[0] == REST:
        a = 1.0 / ratio[0]
        diagonal[1] += 2.0 * a * first[0] + a * a * diagonal[0]
        first[1] += a * second[0]
    else:
        diagonal[1], first[1], second[1] = 1.0, 0.0, 0.0
    diagonal[0], first[0], second[0] = 1.0, 0.0, 0.0
    if end[1] == REST:
        a = 1.0 / ratio[1]
        diagonal[n - 2] += 2.0 * a * first[n - 2] + a * a * diagonal[n - 1]
        first[n - 3] += a * second[n - 3]
    else:
        diagonal[n - 2], first[n - 3], second[n - 4] = 1.0, 0.0, 0.0
    diagonal[n - 1], first[n - 2], second[n - 3] = 1.0, 0.0, 0.0


@jit()
def tie_vector(b: Any, end: Any, ratio: Any) -> Any:
    """The same elimination for a right-hand side or a gradient."""
    n = len(b)
    b[1] = b[1] + b[0] / ratio[0] if end[0] == REST else 0.0
    b[n - 2] = b[n - 2] + b[n - 1] / ratio[1] if end[1] == REST else 0.0
    b[0] = b[n - 1] = 0.0


@jit()
def factor_tied(matrix: Any, end: Any, ratio: Any, spare: Any) -> Any:
    """Tie the matrix and factor it in place; where rounding spoils a pivot, with a diagonal raised by just enough."""
    tie_matrix(matrix, end, ratio)
    spare[:] = matrix
    raised = 1e-13
    while factor(matrix) != 0:
        if raised > 1e-4:
            return False
        matrix[:] = spare
        matrix[0] *= 1.0 + raised
        raised *= 30.0
    return True


@jit()
def solve_tied(factors: Any, end: Any, ratio: Any, direction: Any) -> Any:
    """Overwrite a right-hand side by the Newton direction, with the coefficients that the ends tie."""
    n = len(direction)
    tie_vector(direction, end, ratio)
    solve(factors, direction)
    if end[0] == REST:
        direction[0] = direction[1] / ratio[0]
    if end[1] == REST:
        direction[n - 1] = direction[n - 2] / ratio[1]

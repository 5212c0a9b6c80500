"""Factorisation and solution of symmetric banded systems. Row c holds (c, c), (c, c + 1), ... of the upper band.

Behind the n rows of a system lie as many rows of padding as the band is wide, so that no loop need end early: with a
length known to the compiler the inner loops become vector instructions without remainders, thrice as fast.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.copy import copy
from toolpace.kernels.jit import jit


def factor_of_width(w: int) -> Callable[[Floats], bool]:
    """`factor` for bands of width w."""

    @jit(reorder=True)
    def run(a: Floats) -> bool:
        n = len(a) - w
        a[n:] = 0.0
        a[n:, 0] = 1.0
        least = 1e-15 * a[:, 0]
        u = np.zeros(2 * w + 1)
        v = np.zeros(2 * w + 1)
        for c in range(0, n, 2):
            first, second = a[c], a[c + 1]
            pivot = first[0]
            if not pivot > least[c]:
                if not least[c] > 0.0:
                    return False
                pivot = 1e100  # lost to rounding: this unknown stays where it is
            inverse_u = 1.0 / pivot
            for k in range(w):
                u[k] = first[k]
            share = u[1] * inverse_u
            for k in range(w):
                second[k] -= share * u[k + 1]
            pivot = second[0]
            if not pivot > least[c + 1]:
                if not least[c + 1] > 0.0:
                    return False
                pivot = 1e100
            inverse_v = 1.0 / pivot
            for k in range(w):
                v[k] = second[k]
            first[0] = inverse_u
            second[0] = inverse_v
            for k in range(2, w + 1):
                share_u = u[k] * inverse_u
                share_v = v[k - 1] * inverse_v
                row = a[c + k]
                for q in range(w):
                    row[q] -= share_u * u[k + q] + share_v * v[k + q - 1]
        return True

    return run


def solve_of_width(w: int) -> Callable[[Floats, Floats], None]:
    """`solve` for bands of width w."""

    @jit(reorder=True)
    def run(a: Floats, b: Floats) -> None:
        n = len(b)
        x = np.zeros(n + w)
        copy(b, x)
        for c in range(n):
            row = a[c]
            share = x[c] * row[0]
            for k in range(1, w):
                x[c + k] -= share * row[k]
        x[n:] = 0.0
        for c in range(n - 1, -1, -1):
            row = a[c]
            total = x[c]
            for k in range(1, w):
                total -= row[k] * x[c + k]
            x[c] = total * row[0]
        copy(x[:n], b)

    return run


factor_6, factor_12, factor_18 = factor_of_width(6), factor_of_width(12), factor_of_width(18)
solve_6, solve_12, solve_18 = solve_of_width(6), solve_of_width(12), solve_of_width(18)


@jit()
def empty(n: int, w: int) -> Floats:
    """Room for the band of a system of n unknowns, of width 6, 12 or 18."""
    return np.empty((n + w, w))


@jit()
def factor(a: Floats) -> bool:
    """Replace a band by U in A = U' D^-1 U, where D is the diagonal of U and is stored inverted.

    Rows that depend on earlier ones within rounding are held still; False where a diagonal entry is not positive.
    """
    w = a.shape[1]
    if w == 18:
        return factor_18(a)
    if w == 12:
        return factor_12(a)
    return factor_6(a)


@jit()
def solve(a: Floats, b: Floats) -> None:
    """Replace b (n,) by the solution, with the factor a of `factor`."""
    w = a.shape[1]
    if w == 18:
        solve_18(a, b)
    elif w == 12:
        solve_12(a, b)
    else:
        solve_6(a, b)

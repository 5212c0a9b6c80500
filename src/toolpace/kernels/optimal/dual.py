"""The dual function of the optimal planner's problem: a lower bound from any multipliers.

Where relaxing what is not convex in the problem of `solver` (see `relaxation`) gives
good multipliers, `dual_value` turns any multipliers, good or bad, into a bound of the problem itself. The derivation is
in docs/design/bound.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.newton import REST

UNIT = 2.0**-53
"""Largest relative error of one rounding."""


@jit()
def lowest(kappa: Any, theta: Any, low: Any, high: Any) -> Any:
    """The least of kappa / sqrt(z) + theta z over low <= z <= high, low < z where low is zero."""
    if low > 0.0:
        best = min(kappa / np.sqrt(low) + theta * low, kappa / np.sqrt(high) + theta * high)
    elif kappa < 0.0:
        return -np.inf
    else:
        best = kappa / np.sqrt(high) + theta * high
        if kappa == 0.0:
            best = min(best, 0.0)
    if kappa > 0.0 and theta > 0.0:
        z = (0.5 * kappa / theta) ** (2.0 / 3.0)
        if low < z < high:
            best = min(best, kappa / np.sqrt(z) + theta * z)
    return best


@jit()
def least_terms(kappa: Any, theta: Any, low: Any, high: Any, out: Any) -> Any:
    """out (n,): `lowest` of every knot."""
    for k in range(len(out)):
        out[k] = lowest(kappa[k], theta[k], low[k], high[k])


@jit()
def range_beyond(kappa: Any, theta: Any, low: Any, high: Any, wanted: Any, upper: Any) -> Any:
    """The longest end of the range from low to high in which kappa / sqrt(z) + theta z is at least `wanted`.

    Its inner border: z from there to high (`upper`), or from low to there; nan where there is none. By bisection.
    """
    near, far = (high, low) if upper else (max(low, 1e-9 * high), high)
    if (lowest(kappa, theta, near, high) if upper else lowest(kappa, theta, low, near)) < wanted:
        return np.nan
    for _ in range(40):
        middle = np.sqrt(near * far)
        value = lowest(kappa, theta, middle, high) if upper else lowest(kappa, theta, low, middle)
        if value >= wanted:
            near = middle
        else:
            far = middle
    return near


@jit()
def _transposed(basis: Any, end: Any, ratio: Any, b: Any, sign: Any) -> Any:
    """Overwrite b (n,) by the solution of A' x = b, A the values at the knots of the free coefficients.

    Knot k owns coefficient k + 1; at an end in motion the outermost knot owns none, and its entry is left at zero.
    `sign` -1 solves with the signs of the neighbours turned: A is totally positive, so that its inverse has the
    signs of a chess board, and that solution for b >= 0 is |A^-1|' b.
    """
    n = len(b)
    low = 0 if end[0] == REST else 1
    high = n - 1 if end[1] == REST else n - 2
    diagonal = np.empty(n)
    for k in range(low, high + 1):
        diagonal[k] = basis[k, 0, 1]
        if k == 0:
            diagonal[k] += basis[k, 0, 0] / ratio[0]
        if k == n - 1:
            diagonal[k] += basis[k, 0, 2] / ratio[1]
    for k in range(low, high):
        # row k of A' has basis[k + 1, 0, 0] to the right, row k + 1 has basis[k, 0, 2] to the left
        factor = sign * basis[k, 0, 2] / diagonal[k]
        diagonal[k + 1] -= factor * sign * basis[k + 1, 0, 0]
        b[k + 1] -= factor * b[k]
    for k in range(high, low - 1, -1):
        if k < high:
            b[k] -= sign * basis[k + 1, 0, 0] * b[k + 1]
        b[k] /= diagonal[k]
    for k in range(n):
        if k < low or k > high:
            b[k] = 0.0


@jit()
def gather(first: Any, weight: Any, low: Any, rows: Any, dual: Any, end: Any, terms: Any) -> Any:
    """What the multipliers of each knot's rows come to: all that `value_of` needs of them, linear in them.

    Parameters as of `dual_value`, and the number of terms that `value_of` will be told. The multipliers of jerk of a
    knot are lowered where they outweigh the time and z may come close to zero. Returns (n, 8): sums of multipliers
    times the rows' three columns, the same with all signs positive, and those of acceleration and of jerk alone.
    """
    n, count = len(weight), rows.shape[1]
    half = count // 2
    out = np.zeros((n, 8))
    # more than `value_of` charges: kappa shall stay positive there, in a mean of two such results too
    rounding = 8.0 * (terms + 12) * UNIT
    for k in range(n):
        reverse = 0.0
        for p in range(first[k], first[k + 1]):
            for i in range(half, count):
                reverse += dual[p, i, 0] + dual[p, i, 1]
        share = 1.0
        given = (k == 0 and end[0] != REST) or (k == n - 1 and end[1] != REST)
        if not (given or low[k] > 0.0) and reverse > weight[k] * (1.0 - rounding):
            share = weight[k] * (1.0 - 2.0 * rounding) / reverse
        out[k, 7] = share * reverse
        for p in range(first[k], first[k + 1]):
            for i in range(count):
                up, down = dual[p, i, 0], dual[p, i, 1]
                if i < half:
                    out[k, 6] += up + down
                else:
                    up, down = share * up, share * down
                for d in range(3):
                    out[k, d] += (up - down) * rows[p, i, d]
                    out[k, 3 + d] += (up + down) * abs(rows[p, i, d])
    return out


@jit()
def value_of(
    basis: Any, weight: Any, price: Any, low: Any, high: Any, gathered: Any, terms: Any, end: Any, ratio: Any,
    fixed: Any,
) -> Any:  # fmt: skip
    """The bound, kappa and theta (see `dual_value`) from what `gather` returns; at most so many terms are in a sum."""
    n = len(weight)
    force, size = price.copy(), np.abs(price)
    kappa = np.empty(n)
    total = 0.0
    scale = 0.0
    rounding = 8.0 * (terms + 4) * UNIT
    for k in range(n):
        reverse = gathered[k, 7]
        kappa[k] = weight[k] - reverse - rounding * max(weight[k], reverse)
        total -= gathered[k, 6]
        scale += gathered[k, 6]
        for j in range(3):
            b0, b1, b2 = basis[k, 0, j], basis[k, 1, j], basis[k, 2, j]
            force[k + j] += b0 * gathered[k, 0] + b1 * gathered[k, 1] + b2 * gathered[k, 2]
            size[k + j] += abs(b0) * gathered[k, 3] + abs(b1) * gathered[k, 4] + abs(b2) * gathered[k, 5]
    points = 2.0 * (terms + 8)
    first_knot, last_knot = 0, n - 1
    theta, error = np.empty(n), np.empty(n)
    if end[0] == REST:
        force[1] += force[0] / ratio[0]
        size[1] += size[0] / ratio[0]
    else:
        first_knot = 1
        total += force[0] * fixed[0] + force[1] * fixed[1]
        scale += points * (size[0] * abs(fixed[0]) + size[1] * abs(fixed[1]))
    if end[1] == REST:
        force[n] += force[n + 1] / ratio[1]
        size[n] += size[n + 1] / ratio[1]
    else:
        last_knot = n - 2
        total += force[n] * fixed[2] + force[n + 1] * fixed[3]
        scale += points * (size[n] * abs(fixed[2]) + size[n + 1] * abs(fixed[3]))
    theta[:] = force[1 : n + 1]
    _transposed(basis, end, ratio, theta, 1.0)
    # rounding of the right-hand side and of the solution, which is backward stable entry by entry
    for k in range(first_knot, last_knot + 1):
        back = basis[k, 0, 1] * abs(theta[k])
        if k == 0:
            back += basis[k, 0, 0] / ratio[0] * abs(theta[k])
        if k == n - 1:
            back += basis[k, 0, 2] / ratio[1] * abs(theta[k])
        if k > first_knot:
            back += basis[k - 1, 0, 2] * abs(theta[k - 1])
        if k < last_knot:
            back += basis[k + 1, 0, 0] * abs(theta[k + 1])
        error[k] = UNIT * (2.0 * points * size[k + 1] + 16.0 * back)
    _transposed(basis, end, ratio, error, -1.0)
    for k in range(first_knot, last_knot + 1):
        value = lowest(kappa[k], theta[k] - 2.0 * error[k], low[k], high[k])
        total += value
        scale += abs(value)
    if end[0] != REST:
        shift = theta[1] * basis[1, 0, 0] * fixed[1] if last_knot >= 1 else 0.0
        value = kappa[0] / np.sqrt(fixed[0])
        total += value - shift
        scale += abs(value) + points * abs(shift)
        if last_knot >= 1:
            total -= 2.0 * error[1] * abs(basis[1, 0, 0] * fixed[1])
    if end[1] != REST:
        shift = theta[n - 2] * basis[n - 2, 0, 2] * fixed[2] if last_knot >= first_knot else 0.0
        value = kappa[n - 1] / np.sqrt(fixed[3])
        total += value - shift
        scale += abs(value) + points * abs(shift)
        if last_knot >= first_knot:
            total -= 2.0 * error[n - 2] * abs(basis[n - 2, 0, 2] * fixed[2])
    return total - (n * (terms + 4)) * UNIT * scale, kappa, theta


@jit()
def dual_value(
    basis: Any, first: Any, weight: Any, price: Any, low: Any, high: Any, rows: Any, dual: Any, end: Any, ratio: Any,
    fixed: Any,
) -> Any:  # fmt: skip
    """A lower bound of sum weight / sqrt(z) + price . c over all feasible c with low <= z <= high at the knots.

    Parameters: basis (n, 3, 3) of the knots; first (n + 1,) point of each knot; weight, low, high (n,); price
    (n + 2,) of the coefficients; rows (points, 2 m, 3) as in `speed.maximise_speed`; dual (points, 2 m, 2) any
    multipliers >= 0; end, ratio (2,) as there; fixed (4,) the two outermost coefficients on either side, where that
    end is in motion.
    The multipliers of jerk of a knot are lowered where they outweigh the time and z may come close to zero. Rounding
    is charged: the result holds for the arrays as they are given. Returns the bound, kappa (n,) and theta (n,): what
    remains of the time's weight at a knot, and the price of z there.
    """
    most = 0
    for k in range(len(weight)):
        most = max(most, first[k + 1] - first[k])
    terms = rows.shape[1] * most
    gathered = gather(first, weight, low, rows, dual, end, terms)
    return value_of(basis, weight, price, low, high, gathered, terms, end, ratio, fixed)

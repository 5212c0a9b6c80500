"""The dual function of the optimal planner's problem: a lower bound from any multipliers.

Where relaxing what is not convex in the problem of `solver` (see `relaxation`) gives
good multipliers, `dual_value` turns any multipliers, good or bad, into a bound of the problem itself. The derivation is
in docs/design/bound.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.newton import REST, Ends

UNIT = 2.0**-53
"""Largest relative error of one rounding."""
GATHERED = 9
"""Sums that `gather` makes of a knot."""
HALVINGS = 100
"""Of a range, until it is one of rounding."""


class KnotRows(NamedTuple):
    """A problem by knots: minimise the sum of weight / sqrt(z) + price . c within the rows."""

    basis: Floats
    """(n, 3, 3) z, z', z'' at knot k from the coefficients k, k + 1, k + 2; row d gives the d-th derivative."""
    first: Ints
    """(n + 1,) first point of each knot; one has as many points as there are sides of it, or none."""
    weight: Floats
    """(n,) of the pace 1 / sqrt(z)."""
    price: Floats
    """(n + 2,) of the coefficients."""
    rows: Floats
    """(points, 2 m, 3) the first m of acceleration, the others of jerk, divided by their limits."""
    ends: Ends
    shift: Floats = np.empty((0, 0))
    """(points, 2 m) constants of the rows; empty where all are zero."""
    root: Floats = np.empty((0, 0))
    """(points, 2 m) coefficients of sqrt(z) in the rows, for the dual function alone; empty where all are zero."""


@jit()
def lowest(kappa: float, theta: float, low: float, high: float) -> float:
    """The least of kappa / sqrt(z) + theta z over low <= z <= high, low < z where low is zero."""
    best: float
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
def lowest_with_root(kappa: float, theta: float, root: float, low: float, high: float) -> float:
    """The least of kappa / sqrt(z) + theta z + root sqrt(z) over low <= z <= high, as `lowest` has it without a root.

    With x = sqrt(z) its slope has the sign of g(x) = 2 theta x^3 + root x^2 - kappa. Where kappa is positive g begins
    below zero; its first zero, if there is one, is a least place, and a further one a largest. The ranges of z that
    `lowest` is for have no root: low is zero.
    """
    if root == 0.0 or low > 0.0 or kappa < 0.0:
        return lowest(kappa, theta, low, high) if root == 0.0 else -np.inf
    top = np.sqrt(high)
    best = float(kappa / top + theta * high + root * top)
    if kappa == 0.0:
        best = min(best, 0.0)
    # up to its largest value, or without end, g grows from where it is above -kappa
    reach = min(top, -root / (3.0 * theta)) if theta < 0.0 and root > 0.0 else top
    near, far = 0.0, reach
    if 2.0 * theta * far**3 + root * far**2 > kappa:
        for _ in range(HALVINGS):
            middle = 0.5 * (near + far)
            if 2.0 * theta * middle**3 + root * middle**2 > kappa:
                far = middle
            else:
                near = middle
        if far > 0.0:
            best = min(best, kappa / far + theta * far**2 + root * far)
    return best


@jit()
def least_terms(kappa: Floats, theta: Floats, low: Floats, high: Floats, out: Floats) -> None:
    """out (n,): `lowest` of every knot."""
    for k in range(len(out)):
        out[k] = lowest(kappa[k], theta[k], low[k], high[k])


@jit()
def range_beyond(kappa: float, theta: float, low: float, high: float, wanted: float, upper: bool) -> float:
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
def _transposed(basis: Floats, ends: Ends, b: Floats, sign: float) -> None:
    """Overwrite b (n,) by the solution of A' x = b, A the values at the knots of the free coefficients.

    Knot k owns coefficient k + 1; at an end in motion the outermost knot owns none, and its entry is left at zero.
    `sign` -1 solves with the signs of the neighbours turned: A is totally positive, so that its inverse has the
    signs of a chess board, and that solution for b >= 0 is |A^-1|' b.
    """
    n, ratio = len(b), ends.ratio
    low, high = _owning(ends, n)
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


@jit(inline=True)
def _owning(ends: Ends, n: int) -> tuple[int, int]:
    """First and last of n knots that own a coefficient."""
    return 0 if ends.end[0] == REST else 1, n - 1 if ends.end[1] == REST else n - 2


@jit()
def gather(knots: KnotRows, low: Floats, dual: Floats, terms: int) -> Floats:
    """What the multipliers of each knot's rows come to: all that `value_of` needs of them, linear in them.

    Parameters as of `dual_value`, and the number of terms that `value_of` will be told. The multipliers of jerk of a
    knot are lowered where they outweigh the time and z may come close to zero. Returns (n, GATHERED): sums of
    multipliers times the rows' three columns, the same with all signs positive, those of acceleration alone less those
    times constants, of jerk alone, and times the coefficients of sqrt(z).
    """
    first, weight, rows, end = knots.first, knots.weight, knots.rows, knots.ends.end
    n, count = len(weight), rows.shape[1]
    half, shifted, rooted = count // 2, len(knots.shift) > 0, len(knots.root) > 0
    out = np.zeros((n, GATHERED))
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
                if shifted:
                    out[k, 6] -= (up - down) * knots.shift[p, i]
                if rooted:
                    out[k, 8] += (up - down) * knots.root[p, i]
                for d in range(3):
                    out[k, d] += (up - down) * rows[p, i, d]
                    out[k, 3 + d] += (up + down) * abs(rows[p, i, d])
    return out


@jit()
def value_of(knots: KnotRows, low: Floats, high: Floats, gathered: Floats, terms: int) -> tuple[float, Floats, Floats]:
    """The bound, kappa and theta (see `dual_value`) from what `gather` returns; at most so many terms are in a sum.

    Of the rows nothing else is asked for: they may be missing.
    """
    ends, n = knots.ends, len(knots.weight)
    kappa, force, size = _forces(knots, gathered, terms)
    entries = 2.0 * (terms + 8)
    total = scale = 0.0
    for k in range(n):
        total -= gathered[k, 6]
        scale += abs(gathered[k, 6])
    given, rounded = _tie(ends, force, size)
    total, scale = total + given, scale + entries * rounded
    theta = force[1 : n + 1].copy()
    _transposed(knots.basis, ends, theta, 1.0)
    error = _errors(knots, theta, size, entries)
    first_knot, last_knot = _owning(ends, n)
    for k in range(first_knot, last_knot + 1):
        value = lowest_with_root(kappa[k], theta[k] - 2.0 * error[k], gathered[k, 8], low[k], high[k])
        total += value
        scale += abs(value)
    for side in range(2):
        if ends.end[side] == REST:
            continue
        # the outermost knot, whose z is given, and the coefficient given that its neighbour sees too
        outer, inner, column = (0, 1, 0) if side == 0 else (n - 1, n - 2, 2)
        value = kappa[outer] / np.sqrt(ends.fixed[3 * side]) + gathered[outer, 8] * np.sqrt(ends.fixed[3 * side])
        if last_knot >= first_knot:
            seen, neighbour = knots.basis[inner, 0, column], ends.fixed[1 + side]
            shift = theta[inner] * seen * neighbour
            total -= 2.0 * error[inner] * abs(seen * neighbour)
        else:
            shift = 0.0
        total += value - shift
        scale += abs(value) + entries * abs(shift)
    return total - (n * (terms + 4)) * UNIT * scale, kappa, theta


@jit(inline=True)
def _forces(knots: KnotRows, gathered: Floats, terms: int) -> tuple[Floats, Floats, Floats]:
    """kappa (n,) less what rounding may have added; price (n + 2,) of the coefficients, and the same of absolutes."""
    basis, weight, n = knots.basis, knots.weight, len(knots.weight)
    kappa, force, size = np.empty(n), knots.price.copy(), np.abs(knots.price)
    rounding = 8.0 * (terms + 4) * UNIT
    for k in range(n):
        reverse = gathered[k, 7]
        kappa[k] = weight[k] - reverse - rounding * max(weight[k], reverse)
        for j in range(3):
            b0, b1, b2 = basis[k, 0, j], basis[k, 1, j], basis[k, 2, j]
            force[k + j] += b0 * gathered[k, 0] + b1 * gathered[k, 1] + b2 * gathered[k, 2]
            size[k + j] += abs(b0) * gathered[k, 3] + abs(b1) * gathered[k, 4] + abs(b2) * gathered[k, 5]
    return kappa, force, size


@jit(inline=True)
def _tie(ends: Ends, force: Floats, size: Floats) -> tuple[float, float]:
    """Add the outermost coefficients' force and size to their neighbours' at ends at rest.

    Returns what the coefficients add that ends in motion give, and the sum of its absolutes.
    """
    total = scale = 0.0
    for side in range(2):
        # the coefficient outside and the one inside
        outer, inner = (0, 1) if side == 0 else (len(force) - 1, len(force) - 2)
        if ends.end[side] == REST:
            force[inner] += force[outer] / ends.ratio[side]
            size[inner] += size[outer] / ends.ratio[side]
        else:
            one, two = ends.fixed[3 * side], ends.fixed[1 + side]
            total += force[outer] * one + force[inner] * two
            scale += size[outer] * abs(one) + size[inner] * abs(two)
    return total, scale


@jit(inline=True)
def _errors(knots: KnotRows, theta: Floats, size: Floats, entries: float) -> Floats:
    """(n,) how far off theta (n,) may be by rounding.

    That of the right-hand side and of the solution, which is backward stable entry by entry.
    """
    basis, ends, n = knots.basis, knots.ends, len(theta)
    first_knot, last_knot = _owning(ends, n)
    error = np.empty(n)
    for k in range(first_knot, last_knot + 1):
        back = basis[k, 0, 1] * abs(theta[k])
        if k == 0:
            back += basis[k, 0, 0] / ends.ratio[0] * abs(theta[k])
        if k == n - 1:
            back += basis[k, 0, 2] / ends.ratio[1] * abs(theta[k])
        if k > first_knot:
            back += basis[k - 1, 0, 2] * abs(theta[k - 1])
        if k < last_knot:
            back += basis[k + 1, 0, 0] * abs(theta[k + 1])
        error[k] = UNIT * (2.0 * entries * size[k + 1] + 16.0 * back)
    _transposed(basis, ends, error, -1.0)
    return error


@jit()
def dual_value(knots: KnotRows, low: Floats, high: Floats, dual: Floats) -> tuple[float, Floats, Floats]:
    """A lower bound of sum weight / sqrt(z) + price . c over all feasible c with low <= z <= high at the knots.

    Parameters: low, high (n,); dual (points, 2 m, 2) any multipliers >= 0.
    The multipliers of jerk of a knot are lowered where they outweigh the time and z may come close to zero. Rounding
    is charged: the result holds for the arrays as they are given. Returns the bound, kappa (n,) and theta (n,): what
    remains of the time's weight at a knot, and the price of z there.
    """
    most = 0
    for k in range(len(knots.weight)):
        most = max(most, knots.first[k + 1] - knots.first[k])
    terms = knots.rows.shape[1] * most
    return value_of(knots, low, high, gather(knots, low, dual, terms), terms)

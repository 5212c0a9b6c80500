"""Joint splines within their rows, by a barrier method on banded matrices with two full columns.

least: rows, coefficients strictly within u
  repeat with more and more weight on what is to be least
      Newton's steps to the middle of what is left
  until the weight leaves little, or u is low enough, or is known to stay above 1

Source: Boyd, Vandenberghe, Convex Optimization, 2004, section 11.3: in the middle at weight t the least is at most
M / t away, M the number of rows. Its Newton systems are solved by Cholesky factorisation in place:

[ H  E ] [x]   [b]        H (n, n) banded, stored by rows (n, width + 1): entry d of row i is H[i, i - width + d]
[ E' D ] [w] = [c]        E (n, 2), D (2, 2)
"""

from __future__ import annotations

import math

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.planners.joint_spline_barrier import Rows, Work, add_joints, add_tip, barrier, place_of

RISE = 40.0
"""By how much the weight grows from round to round."""
STEPS = 40
"""Newton's steps of one round at most."""
MIDDLE = 0.3
"""Newton's decrement, squared and halved, at which the middle is reached."""
SURE = 1e-5
"""Gap of u at which it is known on which side of 1 it is."""
NARROW = 1e-13
"""Added to the diagonal, relative: as much as rounding takes from it."""


@jit()
def count_rows(rows: Rows, with_tip: int) -> float:
    """How many logarithms there are."""
    steps, total = rows.base.shape[1], 2.0
    for f in range(4):
        for i in range(rows.ratio.shape[1]):
            if rows.ratio[f, i] > 0.0:
                total += 2.0 * (steps - 3 + f)
    return total + (2.0 * (steps - 2) if with_tip else 0.0)


@jit()
def direction(
    rows: Rows, y: Floats, late: float, u: float, weight: float, least_late: int, with_tip: int, work: Work
) -> float:
    """Newton's step, to `work.slope` and `work.end_slope`; returns its decrement squared, or -1 where there is none."""
    for part in (work.band, work.border, work.corner):
        part[:] = 0.0
    work.slope[:] = 0.0
    work.end_slope[:] = 0.0
    add_joints(rows, y, u, with_tip, work)
    if with_tip:
        add_tip(rows, y, u, work)
    if rows.latest > rows.earliest:
        low, high = 1.0 / (late - rows.earliest), 1.0 / (rows.latest - late)
        work.end_slope[0] += high - low + weight * least_late
        work.corner[0, 0] += low * low + high * high
    else:
        work.border[:, 0], work.corner[0, :], work.corner[:, 0] = 0.0, 0.0, 0.0
        work.end_slope[0], work.corner[0, 0] = 0.0, 1.0
    if least_late:
        work.border[:, 1], work.corner[1, :], work.corner[:, 1] = 0.0, 0.0, 0.0
        work.end_slope[1], work.corner[1, 1] = 0.0, 1.0
    else:
        work.end_slope[1] += weight
    slope, end_slope = work.slope.copy(), work.end_slope.copy()
    work.band[:, -1] *= 1.0 + NARROW
    if solve_bordered(work.band, work.border, work.corner, work.slope, work.end_slope, work.spare):
        return -1.0
    decrement: float = end_slope[0] * work.end_slope[0] + end_slope[1] * work.end_slope[1]
    for i in range(len(slope)):
        decrement += slope[i] * work.slope[i]
    return decrement


@jit()
def moved(rows: Rows, y: Floats, work: Work, share: float, with_tip: int, out: Floats) -> None:
    """The coefficients after a share of Newton's step, to `out`."""
    steps, joints = rows.base.shape[1], y.shape[1]
    for i in range(joints):
        for k in range(3):
            out[k, i] = y[k, i]
            out[steps + k, i] = y[steps + k, i] - share * work.end_slope[0] * rows.drift[k, i]
        for k in range(3, steps):
            out[k, i] = y[k, i] - share * work.slope[place_of(k, i, steps, joints, with_tip)]


@jit()
def centre(rows: Rows, y: Floats, at: Floats, weight: float, least_late: int, with_tip: int, work: Work) -> int:
    """Go to the middle at a weight: y and at = (late, u) in place. Returns Newton's steps taken, -1 if stuck."""
    trial = np.empty_like(y)
    for step in range(STEPS):
        decrement = direction(rows, y, at[0], at[1], weight, least_late, with_tip, work)
        if decrement < 0.0:
            return -1
        if decrement <= 2.0 * MIDDLE:
            return step
        here = barrier(rows, y, at[0], at[1], with_tip) + weight * (at[0] * least_late if least_late else at[1])
        share = 1.0
        while True:
            moved(rows, y, work, share, with_tip, trial)
            late, u = at[0] - share * work.end_slope[0], at[1] - share * work.end_slope[1]
            there = barrier(rows, trial, late, u, with_tip) + weight * (late * least_late if least_late else u)
            if there <= here - 0.1 * share * decrement:
                break
            share *= 0.5
            if share < 1e-9:
                return -1
        y[:] = trial
        at[0], at[1] = late, u
        if not least_late and u < 0.0:
            return -1
    return STEPS


@jit()
def least(rows: Rows, y: Floats, at: Floats, least_late: int, enough: float, gap: float, with_tip: int) -> int:
    """Bring u below `enough` or within `gap` of its least, or `late` within `gap` of its own: y and at in place.

    `least_late` is 1 where `late` shall be least, -1 where it shall be most, else 0.

    y (N + 3, m) and at = (late, u) are strictly within the rows. Returns the number of Newton's steps.
    """
    steps, joints = rows.base.shape[1], y.shape[1]
    n = (steps - 3) * joints
    width = 4 * joints - 1 if with_tip else 3
    band, border, corner = np.empty((n, width + 1)), np.empty((n, 2)), np.empty((2, 2))
    work = Work(band, border, corner, np.empty(n), np.empty(2), np.empty((2, n)))
    many = count_rows(rows, with_tip)
    span = rows.latest - rows.earliest if least_late else at[1]
    weight, total = many / span, 0
    while True:
        taken = centre(rows, y, at, weight, least_late, with_tip, work)
        if taken < 0:
            return total
        total += taken
        left = many / weight
        if least_late:
            if left <= gap:
                return total
        elif at[1] <= enough or at[1] - 1.5 * left > 1.0 or (left <= gap and at[1] <= 1.0) or left <= SURE:
            return total
        weight *= RISE


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

"""The rows of limits, travel and feed for joints as cubic splines of time.

coefficients   y_0  y_1  y_2 | y_3  ...  y_N-1 | y_N  y_N+1  y_N+2         N steps, with constant jerk in each
               start           free              end, moves with `late`

With the motion of constant acceleration from the start taken off, and the scale of each joint, the divided differences
of y are the control points of velocity, the accelerations at the knots and the jerks of the steps: of order 1, 2 and 3.
A spline lies within the hull of its control points, so that the limits hold at all times where they hold for these.

Each row asks |base + ratio * difference| <= u; of the feed, |base + map . difference| <= u for vectors of the tip.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit


class Rows(NamedTuple):
    """What is asked of m joints on N steps."""

    stencil: Floats
    """(4, N, 4) weights of the coefficients k to k + 3 in the differences of order 0 to 3 at k."""
    base: Floats
    """(4, N, m) of position, velocity, acceleration, jerk, over the limit."""
    ratio: Floats
    """(4, m) of a difference of y over the limit; 0 where there is none."""
    drift: Floats
    """(3, m) by how much the coefficients of the end change as it lies later."""
    tip_base: Floats
    """(N, 3) velocity of the tip over the feed."""
    tip_map: Floats
    """(N, 3, m) of y[k + 1] - y[k]; all zero where no feed holds."""
    earliest: float
    latest: float
    """Range of `late`; it stands where both are the same."""


class Work(NamedTuple):
    """Room for the second derivatives of a barrier, see `interior_point.solve_bordered`, and for the first."""

    band: Floats
    border: Floats
    corner: Floats
    slope: Floats
    end_slope: Floats
    """(2,) by `late` and by u."""
    spare: Floats


@jit()
def place_of(k: int, i: int, steps: int, joints: int, coupled: int) -> int:
    """Place of the free coefficient k of joint i among all: by time where the feed couples joints, else by joint."""
    return (k - 3) * joints + i if coupled else i * (steps - 3) + k - 3


@jit()
def row_value(rows: Rows, y: Floats, f: int, k: int, i: int) -> float:
    """Value over limit of one row."""
    total = 0.0
    for d in range(f + 1):
        total += rows.stencil[f, k, d] * y[k + d, i]
    value: float = rows.base[f, k, i] + rows.ratio[f, i] * total
    return value


@jit()
def tip_value(rows: Rows, y: Floats, k: int, out: Floats) -> float:
    """Velocity of the tip over the feed, to `out` (3,); returns its square."""
    square = 0.0
    for d in range(3):
        out[d] = rows.tip_base[k, d]
        for i in range(y.shape[1]):
            out[d] += rows.tip_map[k, d, i] * (y[k + 1, i] - y[k, i])
        square += out[d] * out[d]
    return square


@jit()
def most_used(rows: Rows, y: Floats, with_tip: int) -> float:
    """The largest of all rows."""
    worst, out = 0.0, np.empty(3)
    for f in range(4):
        for i in range(y.shape[1]):
            if rows.ratio[f, i] > 0.0:
                for k in range(3 - f, rows.base.shape[1]):
                    worst = max(worst, abs(row_value(rows, y, f, k, i)))
    if with_tip:
        for k in range(2, rows.base.shape[1]):
            worst = max(worst, math.sqrt(tip_value(rows, y, k, out)))
    return worst


@jit()
def barrier(rows: Rows, y: Floats, late: float, u: float, with_tip: int) -> float:
    """Minus the sum of the logarithms of what is left; inf where nothing is."""
    total, product, out = 0.0, 1.0, np.empty(3)
    if rows.latest > rows.earliest:
        if not rows.earliest < late < rows.latest:
            return np.inf
        product = (late - rows.earliest) * (rows.latest - late)
    for f in range(4):
        for i in range(y.shape[1]):
            if rows.ratio[f, i] > 0.0:
                for k in range(3 - f, rows.base.shape[1]):
                    value = row_value(rows, y, f, k, i)
                    if not abs(value) < u:
                        return np.inf
                    product *= (u - value) * (u + value)
                    if not 1e-100 < product < 1e100:
                        total -= math.log(product)
                        product = 1.0
    if with_tip:
        for k in range(2, rows.base.shape[1]):
            left = u * u - tip_value(rows, y, k, out)
            if not left > 0.0:
                return np.inf
            total -= math.log(left)
    return total - math.log(product)


@jit()
def add_row(work: Work, places: Ints, weights: Floats, second: float, cross: float, first: float, count: int) -> None:
    """One row's part of both derivatives: its last weight is that of `late`, u is beside it."""
    band, border, corner = work.band, work.border, work.corner
    width, of_late = band.shape[1] - 1, weights[count]
    for p in range(count):
        a, w = places[p], weights[p]
        work.slope[a] += first * w
        border[a, 0] += second * w * of_late
        border[a, 1] += cross * w
        for q in range(count):
            if places[q] <= a:
                band[a, places[q] - a + width] += second * w * weights[q]
    work.end_slope[0] += first * of_late
    corner[0, 0] += second * of_late * of_late
    corner[0, 1] += cross * of_late
    corner[1, 0] += cross * of_late


@jit()
def add_joints(rows: Rows, y: Floats, u: float, coupled: int, work: Work) -> None:
    """The part of limits and travel."""
    steps, joints = rows.base.shape[1], y.shape[1]
    places, weights = np.empty(4, dtype=np.int64), np.empty(5)
    for f in range(4):
        for i in range(joints):
            ratio = rows.ratio[f, i]
            if ratio == 0.0:
                continue
            for k in range(3 - f, steps):
                value = row_value(rows, y, f, k, i)
                low, high = 1.0 / (u + value), 1.0 / (u - value)
                count, of_late = 0, 0.0
                for d in range(f + 1):
                    weight = ratio * rows.stencil[f, k, d]
                    if k + d >= steps:
                        of_late += weight * rows.drift[k + d - steps, i]
                    elif k + d >= 3:
                        places[count] = place_of(k + d, i, steps, joints, coupled)
                        weights[count] = weight
                        count += 1
                weights[count] = of_late
                add_row(work, places, weights, low * low + high * high, low * low - high * high, high - low, count)
                work.end_slope[1] -= low + high
                work.corner[1, 1] += low * low + high * high


@jit()
def add_tip(rows: Rows, y: Floats, u: float, work: Work) -> None:
    """The part of the feed: -log(u^2 - |w|^2), w the velocity of the tip over the feed."""
    steps, joints = rows.base.shape[1], y.shape[1]
    out, columns = np.empty(3), np.empty((3, 2 * joints + 1))
    places, weights = np.empty(2 * joints, dtype=np.int64), np.empty(2 * joints + 1)
    for k in range(2, steps):
        inverse = 1.0 / (u * u - tip_value(rows, y, k, out))
        count = 0
        columns[:, 2 * joints] = 0.0
        for d in range(2):
            for i in range(joints):
                sign = 2.0 * d - 1.0
                if k + d >= steps:
                    for e in range(3):
                        columns[e, 2 * joints] += sign * rows.tip_map[k, e, i] * rows.drift[k + d - steps, i]
                elif k + d >= 3:
                    places[count] = place_of(k + d, i, steps, joints, 1)
                    for e in range(3):
                        columns[e, count] = sign * rows.tip_map[k, e, i]
                    count += 1
        # 2 I / left along each direction, and 4 w w' / left^2 along the velocity
        for e in range(3):
            for p in range(count):
                weights[p] = columns[e, p]
            weights[count] = columns[e, 2 * joints]
            add_row(work, places, weights, 2.0 * inverse, 0.0, 2.0 * out[e] * inverse, count)
        for p in range(count + 1):
            column = p if p < count else 2 * joints
            weights[p] = out[0] * columns[0, column] + out[1] * columns[1, column] + out[2] * columns[2, column]
        add_row(work, places, weights, 4.0 * inverse * inverse, -4.0 * u * inverse * inverse, 0.0, count)
        work.end_slope[1] -= 2.0 * u * inverse
        work.corner[1, 1] += 4.0 * u * u * inverse * inverse - 2.0 * inverse

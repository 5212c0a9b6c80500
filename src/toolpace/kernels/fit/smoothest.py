"""The smoothest spline in a tube: a primal-dual interior-point method on banded matrices.

    minimise    1/2 sum_d w_d (x_d' R x_d + sum_j p_j (B_j x_d - y_jd)^2)
    subject to  (B_j x - y_j)' G_j (B_j x - y_j) <= radius_j^2

over the coefficients x (n, g) of a quintic spline, with B_j its six basis values at sample j. Each sample couples six
coefficients of g coordinates, so the Newton matrix is banded with 6 g entries a row, and a step costs O(n).
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.fit.assemble import gather, rough_gradient, scatter, scatter_roughness, scatter_samples
from toolpace.kernels.fit.band import empty, factor, solve
from toolpace.kernels.jit import jit

SEGMENT = 32
INFEASIBLE = 5e-3
"""Share of the squared radius by which a sample may be outside at the end: half as much of the radius."""


@jit()
def least_squares(
    third: Floats,
    weight: Floats,
    first: Ints,
    rows: Floats,
    target: Floats,
    metric: Floats,
    x: Floats,
    low: int,
    high: int,
) -> bool:
    """The smoothing spline: minimise the roughness plus the squared deviations in x[low:high]; the others stay."""
    g = x.shape[1]
    free = high - low
    band = empty(free * g, 6 * g)
    scatter_roughness(band, third, weight, low)
    scatter_samples(band, first, rows, metric, low)
    if not factor(band):
        return False
    ignored = np.empty(len(third))
    step = np.empty(free * g)
    value = np.empty((len(first), g))
    off = np.empty(g)
    for _ in range(2):
        rough_gradient(third, weight, x, low, free, step, ignored)
        gather(first, rows, x, value)
        for j in range(len(first)):
            for c in range(g):
                off[c] = value[j, c] - target[j, c]
            for c in range(g):
                value[j, c] = 0.0
                for d in range(g):
                    value[j, c] += metric[j, c, d] * off[d]
        scatter(first, rows, value, low, free, step)
        solve(band, step)
        x[low:high] -= step.reshape((free, g))
    return True


@jit()
def smoothest(
    third: Floats,
    weight: Floats,
    first: Ints,
    rows: Floats,
    target: Floats,
    metric: Floats,
    pull: Floats,
    radius: Floats,
    x: Floats,
    low: int,
    high: int,
    floor: Floats,
    accuracy: float,
    max_steps: int,
) -> tuple[int, float, float]:
    """Improve the coefficients low ... high - 1 of x (n, g) in place; the others stay.

    Samples are those that touch a free coefficient; those that touch others too may stay as far outside the tube as
    they are, for it may not be in the power of the free ones to change that. Mehrotra's predictor and corrector,
    with the curvature of the balls in the corrector. Returns the number of steps (negative where it got stuck), the
    roughness and the duality gap. It ends where in every stretch of SEGMENT cells the gap is below `accuracy` times
    the roughness of the stretch and its neighbours, plus the `floor` (cells,): one sharp corner has more roughness
    than all of the rest, and must not be the measure of it.
    """
    m, g = target.shape
    n = high - low
    band = empty(n * g, 6 * g)
    gradient = np.empty(n * g)
    right = np.empty(n * g)
    step = np.zeros((len(x), g))
    r = np.empty((m, g))
    q = np.empty((m, g))
    move = np.zeros((m, g))
    moment = np.empty((m, g, g))
    work = np.empty((m, g))
    h = np.empty(m)
    slack = np.empty(m)
    lam = np.empty(m)
    d_slack = np.zeros(m)
    d_lam = np.zeros(m)
    share = np.empty(m)
    widened = radius.copy()

    count = len(third) // SEGMENT + 1
    cell_value = np.zeros(len(third))
    rough_part = np.empty(count + 2)
    gap_part = np.empty(count)
    mu = 0.0
    value = 0.0
    gap = 0.0
    for iteration in range(max_steps):
        rough_gradient(third, weight, x, low, n, gradient, cell_value)
        gather(first, rows, x, r)
        rough_part[:] = 0.0
        for i in range(len(third)):
            rough_part[i // SEGMENT + 1] += cell_value[i] + floor[i] / accuracy
        for j in range(m):
            for c in range(g):
                r[j, c] -= target[j, c]
                rough_part[first[j] // SEGMENT + 1] += 0.5 * weight[c] * pull[j] * r[j, c] ** 2
            h[j] = -0.5 * widened[j] ** 2
            for c in range(g):
                q[j, c] = 0.0
                for d in range(g):
                    q[j, c] += metric[j, c, d] * r[j, d]
                h[j] += 0.5 * q[j, c] * r[j, c]
        value = np.sum(rough_part)
        if iteration == 0:
            mu = value / m
            for j in range(m):
                if (first[j] < low or first[j] + 6 > high) and h[j] > 0.0:
                    widened[j] = np.sqrt(radius[j] ** 2 + 2.002 * h[j])
                    h[j] -= 0.5 * (widened[j] ** 2 - radius[j] ** 2)
                slack[j] = max(-h[j], 0.05 * widened[j] ** 2)
                lam[j] = mu / slack[j]
        worst = 0.0
        mu = 0.0
        gap_part[:] = 0.0
        for j in range(m):
            worst = max(worst, h[j] / widened[j] ** 2)
            mu += slack[j] * lam[j]
            gap_part[first[j] // SEGMENT] += max(slack[j], -h[j]) * lam[j]
        gap = mu
        mu /= m
        top = 0.0
        for i in range(n * g):
            top = max(top, abs(gradient[i]))
        for j in range(m):
            for c in range(g):
                work[j, c] = lam[j] * q[j, c] + weight[c] * pull[j] * r[j, c]
        scatter(first, rows, work, low, n, gradient)
        residual = 0.0
        for i in range(n * g):
            residual = max(residual, abs(gradient[i]))
        open_gap = 0.0
        for i in range(count):
            allowed = rough_part[i] + rough_part[i + 1] + rough_part[i + 2]
            open_gap = max(open_gap, gap_part[i] / allowed)
        residual += 0.0 * gap  # a nan is passed over by max, but not by a sum
        # below a hundredth of the gap asked for, what is left of the residual is rounding
        even = residual <= 0.05 * top or open_gap <= 0.01 * accuracy
        if worst <= INFEASIBLE and open_gap <= accuracy and even:
            return iteration, value, gap
        if not (worst < np.inf and residual < np.inf and open_gap > 1e-9 * accuracy):
            return -1 - iteration, value, gap  # rounding has the better of it, or there is no way into the tube

        for j in range(m):
            ratio = lam[j] / slack[j]
            for c in range(g):
                for d in range(g):
                    moment[j, c, d] = lam[j] * metric[j, c, d] + ratio * q[j, c] * q[j, d]
                moment[j, c, c] += weight[c] * pull[j]
        scatter_roughness(band, third, weight, low)
        scatter_samples(band, first, rows, moment, low)
        if not factor(band):
            return -1 - iteration, value, gap

        sigma = 0.0
        length = 1.0
        for phase in range(2):
            bent = phase == 1 and sigma < 1.0
            for j in range(m):
                excess = h[j] + slack[j]
                centre = sigma * mu - slack[j] * lam[j]
                bend = 0.0
                if bent:
                    for c in range(g):
                        work[j, c] = 0.0
                        for d in range(g):
                            work[j, c] += metric[j, c, d] * move[j, d]
                        bend += 0.5 * work[j, c] * move[j, c]
                    excess += bend * length * length
                    centre -= d_slack[j] * d_lam[j] * length * length
                share[j] = (centre + lam[j] * excess) / slack[j]
                for c in range(g):
                    twist = d_lam[j] * work[j, c] * length * length if bent else 0.0
                    work[j, c] = share[j] * q[j, c] + twist
                d_slack[j] = -excess
            right[:] = gradient
            scatter(first, rows, work, low, n, right)
            solve(band, right)
            for i in range(n):
                for c in range(g):
                    step[low + i, c] = -right[i * g + c]
            gather(first, rows, step, move)
            length = 1.0
            for j in range(m):
                along = 0.0
                for c in range(g):
                    along += q[j, c] * move[j, c]
                d_slack[j] -= along
                d_lam[j] = share[j] + lam[j] / slack[j] * along
                if d_slack[j] < 0.0:
                    length = min(length, -slack[j] / d_slack[j])
                if d_lam[j] < 0.0:
                    length = min(length, -lam[j] / d_lam[j])
            if phase == 0:
                after = 0.0
                for j in range(m):
                    after += (slack[j] + length * d_slack[j]) * (lam[j] + length * d_lam[j])
                # a gap that is small enough waits for the way into the tube
                sigma = max((after / (m * mu)) ** 3, 1e-4) if open_gap > 0.1 * accuracy else 1.0
        length = min(1.0, 0.99 * length)
        for i in range(low, high):
            for c in range(g):
                x[i, c] += length * step[i, c]
        for j in range(m):
            slack[j] += length * d_slack[j]
            lam[j] += length * d_lam[j]
    return max_steps, value, gap

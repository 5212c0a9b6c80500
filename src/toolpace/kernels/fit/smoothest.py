"""The smoothest spline in a tube, by a banded primal-dual interior-point method.

    minimise    1/2 sum_d w_d (x_d' R x_d + sum_j p_j (B_j x_d - y_jd)^2)
    subject to  (B_j x - y_j)' G_j (B_j x - y_j) <= radius_j^2

over the coefficients x (n, g) of a quintic spline, with B_j its six basis values at sample j. Each sample couples six
coefficients of g coordinates, so the Newton matrix is banded with 6 g entries a row, and a step costs O(n).

    start                slacks and multipliers; the tube wider where the coefficients that stay hold the spline outside
    until the gap is small in every stretch, and the samples are inside:
        residuals        how far the samples are off and outside, the gradient
        stretches        the roughness against which the gap is measured
        share_out        what each sample shall have of the gap
        measure          duality gap, infeasibility and residual of the optimality condition
        factor_newton    the Newton matrix
        take_step        predict: the step to a gap of zero, and how far it could be taken
        centre           from that, the gap to aim for
        take_step        correct: the step to this gap, with the curvature that the predictor met
        advance          coefficients, slacks and multipliers

The m samples have the deviation r = B x - y, the force q = G r, the excess h = (q'r - radius^2) / 2 <= 0 of the
constraint, a slack and a multiplier. Linearised about them, with d for what a step changes,

    h + q'(B dx) + slack + dslack = 0        slack dmultiplier + multiplier dslack = aim - slack multiplier

and with the slacks and multipliers eliminated the Newton matrix has the roughness, the pull and the moments
multiplier G + multiplier / slack q q' of the samples.

The path to the optimum is a weighted one (Jansen, Roos, Terlaky, Vial, Primal-dual target-following algorithms for
linear programming, 1996): the products aimed for are as uneven as the square root of the roughness of the stretch.
With equal products all stretches wait for the smoothest: its gap is small enough when that of a corner is 10^10 times
smaller than it need be. With products as uneven as the roughness itself the corner's error shows beside it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.copy import copy
from toolpace.kernels.fit.band import empty, factor, solve
from toolpace.kernels.fit.smoothing_spline import (
    Free,
    Roughness,
    Samples,
    Tube,
    gather,
    rough_gradient,
    scatter,
    scatter_roughness,
    scatter_samples,
)
from toolpace.kernels.jit import jit

INFEASIBLE = 5e-3
"""Share of the squared radius by which a sample may be outside at the end: half as much of the radius."""
ROUNDING = 1e-9
"""Gap, as a share of the accuracy, below which what goes on is rounding."""
SEGMENT = 32
"""Cells of a stretch in which the duality gap is measured against the roughness."""


class Iterate(NamedTuple):
    """Where the method stands."""

    off: Floats
    """(m, g) deviation of the samples."""
    force: Floats
    """(m, g) metric times deviation."""
    excess: Floats
    """(m,) half the square of the deviation less that of the radius."""
    slack: Floats
    """(m,)"""
    multiplier: Floats
    """(m,)"""
    share: Floats
    """(m,) of the product of slack and multiplier that is aimed for; 1 in the mean."""
    gradient: Floats
    """(n g,) of the roughness; from `measure` on that of the Lagrangian."""
    work: Floats
    """(m, g) what each sample adds to the gradient."""
    rough: Floats
    """(cells,) roughness of each cell."""
    moment: Floats
    """(m, g, g) what each sample adds to the Newton matrix."""


class Step(NamedTuple):
    """What a step changes."""

    x: Floats
    """(len(x), g) coefficients."""
    move: Floats
    """(m, g) deviation of the samples."""
    slack: Floats
    """(m,)"""
    multiplier: Floats
    """(m,)"""
    right: Floats
    """(n g,) right side of the Newton system, then its solution."""
    work: Floats
    """(m, g) its share of each sample."""


class Measure(NamedTuple):
    """How far the method has come."""

    gap: float
    mu: float
    """Mean product of slack and multiplier."""
    outside: float
    """Largest excess over squared radius."""
    top: float
    """Largest entry of the gradient of the roughness."""
    residual: float
    """Largest entry of the gradient of the Lagrangian."""
    open_gap: float
    """Largest gap of a stretch over the roughness of it and its neighbours."""


@jit()
def new_iterate(m: int, g: int, n: int, cells: int) -> Iterate:
    """Room for m samples of g coordinates, n free coefficients."""
    return Iterate(
        np.empty((m, g)), np.empty((m, g)), np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(n * g),
        np.empty((m, g)), np.zeros(cells), np.empty((m, g, g)),
    )  # fmt: skip


@jit()
def new_step(m: int, g: int, n: int, coefficients: int) -> Step:
    """Room for m samples of g coordinates, n free coefficients."""
    return Step(
        np.zeros((coefficients, g)), np.zeros((m, g)), np.zeros(m), np.zeros(m), np.empty(n * g), np.empty((m, g))
    )


@jit()
def smoothest(
    rough: Roughness,
    samples: Samples,
    tube: Tube,
    x: Floats,
    free: Free,
    floor: Floats,
    accuracy: float,
    max_steps: int,
) -> tuple[int, float, float]:
    """Improve the free coefficients of x (n, g) in place; the others stay.

    Samples are those that touch a free coefficient; those that touch others too may stay as far outside the tube as
    they are, for it may not be in the power of the free ones to change that. Mehrotra's predictor and corrector,
    with the curvature of the balls in the corrector. Returns the number of steps (negative where it got stuck), the
    roughness and the duality gap. It ends where in every stretch of SEGMENT cells the gap is below `accuracy` times
    the roughness of the stretch and its neighbours, plus the `floor` (cells,): one sharp corner has more roughness
    than all of the rest, and must not be the measure of it.
    """
    m, g = samples.target.shape
    n = free.high - free.low
    band = empty(n * g, 6 * g)
    now = new_iterate(m, g, n, len(rough.third))
    step = new_step(m, g, n, len(x))
    radius = tube.radius.copy()
    value = gap = 0.0
    length, residual = 0.0, np.inf
    for iteration in range(max_steps):
        residuals(rough, samples, tube.pull, radius, x, free, now)
        part = stretches(rough, samples, tube.pull, floor, accuracy, now)
        value = np.sum(part)
        share_out(samples.first, part, now.share)
        if iteration == 0:
            start(samples, radius, free, value / m, now)
        at = measure(rough.weight, samples, tube.pull, radius, part, free, now)
        gap = at.gap
        # what a full step does not halve is rounding, and so is the residual below a hundredth of the gap asked for
        rounding = (length == 1.0 and at.residual > 0.5 * residual) or at.open_gap <= 0.01 * accuracy
        even = at.residual <= 0.05 * at.top or rounding
        residual = at.residual
        if at.outside <= INFEASIBLE and at.open_gap <= accuracy and even:
            return iteration, value, gap
        if not (at.outside < np.inf and at.residual < np.inf and at.open_gap > ROUNDING * accuracy):
            return -1 - iteration, value, gap  # rounding has the better of it, or there is no way into the tube
        if not factor_newton(rough, samples, tube.pull, free, now, band):
            return -1 - iteration, value, gap
        length = take_step(samples, band, free, now, 0.0, 0.0, step)
        # a gap that is small enough waits for the way into the tube
        share = centre(now, step, length, at.mu) if at.open_gap > 0.1 * accuracy else 1.0
        length = take_step(samples, band, free, now, share * at.mu, length if share < 1.0 else 0.0, step)
        advance(min(1.0, 0.99 * length), step, free, x, now)
    return max_steps, value, gap


@jit()
def residuals(
    rough: Roughness, samples: Samples, pull: Floats, radius: Floats, x: Floats, free: Free, now: Iterate
) -> None:
    """Roughness and its gradient; deviation, force and excess of the samples at radius (m,)."""
    off, force, excess = now.off, now.force, now.excess
    metric, target = samples.metric, samples.target
    g = x.shape[1]
    rough_gradient(rough.third, rough.weight, x, free.low, free.high - free.low, now.gradient, now.rough)
    gather(samples.first, samples.rows, x, off)
    for j in range(len(excess)):
        for c in range(g):
            off[j, c] -= target[j, c]
        excess[j] = -0.5 * radius[j] ** 2
        for c in range(g):
            force[j, c] = 0.0
            for d in range(g):
                force[j, c] += metric[j, c, d] * off[j, d]
            excess[j] += 0.5 * force[j, c] * off[j, c]


@jit()
def stretches(rough: Roughness, samples: Samples, pull: Floats, floor: Floats, accuracy: float, now: Iterate) -> Floats:
    """Roughness of each stretch, and what pulls there; a stretch of nothing before the first and behind the last.

    The `floor` (cells,) counts as so much roughness that it leaves room for a gap of its size.
    """
    off = now.off
    part = np.zeros(len(floor) // SEGMENT + 3)
    for i in range(len(floor)):
        part[i // SEGMENT + 1] += now.rough[i] + floor[i] / accuracy
    for j in range(len(pull)):
        for c in range(off.shape[1]):
            part[samples.first[j] // SEGMENT + 1] += 0.5 * rough.weight[c] * pull[j] * off[j, c] ** 2
    return part


@jit()
def share_out(first: Ints, part: Floats, share: Floats) -> None:
    """What each sample (m,) shall have of the gap, 1 in the mean: the square root of the roughness that its stretch and
    the neighbours have for each of its samples; part (stretches + 2,) of `stretches`."""
    count = np.zeros(len(part) - 2)
    for j in range(len(first)):
        count[first[j] // SEGMENT] += 1.0
    whole = 0.0
    for j in range(len(first)):
        k = first[j] // SEGMENT
        share[j] = np.sqrt((part[k] + part[k + 1] + part[k + 2]) / count[k])
        whole += share[j]
    for j in range(len(first)):
        share[j] *= len(first) / whole


@jit()
def start(samples: Samples, radius: Floats, free: Free, mu: float, now: Iterate) -> None:
    """Slacks and multipliers with products of their share of mu.

    Samples outside that touch a coefficient that stays get a radius with room for where they are, and a little more.
    """
    first, excess = samples.first, now.excess
    for j in range(len(radius)):
        if (first[j] < free.low or first[j] + 6 > free.high) and excess[j] > 0.0:
            before = radius[j]
            radius[j] = np.sqrt(before**2 + 2.002 * excess[j])
            excess[j] -= 0.5 * (radius[j] ** 2 - before**2)
        now.slack[j] = max(-excess[j], 0.05 * radius[j] ** 2)
        now.multiplier[j] = mu * now.share[j] / now.slack[j]


@jit()
def measure(
    weight: Floats, samples: Samples, pull: Floats, radius: Floats, part: Floats, free: Free, now: Iterate
) -> Measure:
    """Duality gap, infeasibility, and the gradient of the Lagrangian; part (stretches + 2,) of `stretches`."""
    first, work = samples.first, now.work
    slack, multiplier, excess, gradient = now.slack, now.multiplier, now.excess, now.gradient
    m = len(radius)
    gaps = np.zeros(len(part) - 2)
    outside = 0.0
    gap = 0.0
    for j in range(m):
        outside = max(outside, excess[j] / radius[j] ** 2)
        gap += slack[j] * multiplier[j]
        gaps[first[j] // SEGMENT] += max(slack[j], -excess[j]) * multiplier[j]
    top = 0.0
    for i in range(len(gradient)):
        top = max(top, abs(gradient[i]))
    for j in range(m):
        for c in range(len(weight)):
            work[j, c] = multiplier[j] * now.force[j, c] + weight[c] * pull[j] * now.off[j, c]
    scatter(first, samples.rows, work, free.low, free.high - free.low, gradient)
    residual = 0.0
    for i in range(len(gradient)):
        residual = max(residual, abs(gradient[i]))
    residual += 0.0 * gap  # a nan is passed over by max, but not by a sum
    open_gap = 0.0
    for i in range(len(gaps)):
        open_gap = max(open_gap, gaps[i] / (part[i] + part[i + 1] + part[i + 2]))
    return Measure(gap, gap / m, outside, top, residual, open_gap)


@jit()
def factor_newton(rough: Roughness, samples: Samples, pull: Floats, free: Free, now: Iterate, band: Floats) -> bool:
    """Factor the Newton matrix into the band; False where it is not positive definite."""
    weight, moment, force, metric = rough.weight, now.moment, now.force, samples.metric
    g = len(weight)
    for j in range(len(pull)):
        multiplier = now.multiplier[j]
        ratio = multiplier / now.slack[j]
        for c in range(g):
            for d in range(g):
                moment[j, c, d] = multiplier * metric[j, c, d] + ratio * force[j, c] * force[j, d]
            moment[j, c, c] += weight[c] * pull[j]
    scatter_roughness(band, rough.third, weight, free.low)
    scatter_samples(band, samples.first, samples.rows, moment, free.low)
    return factor(band)


@jit()
def aim(metric: Floats, now: Iterate, product: float, bent: float, step: Step) -> None:
    """What each sample adds to the right side of the Newton system, for its share of a `product` of slack and
    multiplier.

    Where `bent` is above zero, the second order of a step so long as this share of the one before is taken along: the
    curvature of the ball in the excess and the force, and the product of the changes of slack and multiplier.
    """
    work, move, d_slack, d_multiplier = step.work, step.move, step.slack, step.multiplier
    slack, multiplier, force, excess = now.slack, now.multiplier, now.force, now.excess
    m, g = force.shape
    for j in range(m):
        lack = excess[j] + slack[j]
        centre = product * now.share[j] - slack[j] * multiplier[j]
        bend = 0.0
        if bent > 0.0:
            for c in range(g):
                work[j, c] = 0.0
                for d in range(g):
                    work[j, c] += metric[j, c, d] * move[j, d]
                bend += 0.5 * work[j, c] * move[j, c]
            lack += bend * bent * bent
            centre -= d_slack[j] * d_multiplier[j] * bent * bent
        share = (centre + multiplier[j] * lack) / slack[j]
        for c in range(g):
            twist = d_multiplier[j] * work[j, c] * bent * bent if bent > 0.0 else 0.0
            work[j, c] = share * force[j, c] + twist
        d_slack[j] = -lack
        d_multiplier[j] = share


@jit()
def take_step(
    samples: Samples, band: Floats, free: Free, now: Iterate, product: float, bent: float, step: Step
) -> float:
    """The step to products `product` (see `aim`), and what share of it keeps slacks and multipliers above zero."""
    low, high = free
    slack, multiplier, force = now.slack, now.multiplier, now.force
    d_slack, d_multiplier, right = step.slack, step.multiplier, step.right
    m, g = force.shape
    aim(samples.metric, now, product, bent, step)
    copy(now.gradient, right)
    scatter(samples.first, samples.rows, step.work, low, high - low, right)
    solve(band, right)
    for i in range(high - low):
        for c in range(g):
            step.x[low + i, c] = -right[i * g + c]
    gather(samples.first, samples.rows, step.x, step.move)
    length = 1.0
    for j in range(m):
        along = 0.0
        for c in range(g):
            along += force[j, c] * step.move[j, c]
        d_slack[j] -= along
        d_multiplier[j] += multiplier[j] / slack[j] * along
        if d_slack[j] < 0.0:
            length = min(length, -slack[j] / d_slack[j])
        if d_multiplier[j] < 0.0:
            length = min(length, -multiplier[j] / d_multiplier[j])
    return length


@jit()
def centre(now: Iterate, step: Step, length: float, mu: float) -> float:
    """Mehrotra's rule: the share of mu to aim for, the cube of what a step of this length would leave of it."""
    m = len(now.slack)
    after = 0.0
    for j in range(m):
        after += (now.slack[j] + length * step.slack[j]) * (now.multiplier[j] + length * step.multiplier[j])
    share: float = max((after / (m * mu)) ** 3, 1e-4)
    return share


@jit()
def advance(length: float, step: Step, free: Free, x: Floats, now: Iterate) -> None:
    """Go this share of the step."""
    for i in range(free.low, free.high):
        for c in range(x.shape[1]):
            x[i, c] += length * step.x[i, c]
    for j in range(len(now.slack)):
        now.slack[j] += length * step.slack[j]
        now.multiplier[j] += length * step.multiplier[j]

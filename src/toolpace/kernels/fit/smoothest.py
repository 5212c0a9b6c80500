"""The smoothest spline in a tube, by a banded primal-dual interior-point method.

    minimise    1/2 sum_d w_d (x_d' R x_d + sum_j p_j (B_j x_d - y_jd)^2)
    subject to  (B_j x - y_j)' G_j (B_j x - y_j) <= radius_j^2

over the coefficients x (n, g) of a quintic spline, with B_j its six basis values at sample j. Each sample couples six
coefficients of g coordinates, so the Newton matrix is banded with 6 g entries a row, and a step costs O(n).

    start                slacks and multipliers; the tube wider where the coefficients that stay hold the spline outside
    until the gap is small in every stretch, and the samples are inside:
        residuals        how far the samples are off and outside, the gradient
        stretches        the roughness against which the gap is measured
        measure          duality gap, infeasibility and residual of the optimality condition
        factor_newton    the Newton matrix
        take_step        predict: the step to a gap of zero, and how far it could be taken
        centre           from that, the gap to aim for
        take_step        correct: the step to this gap, with the curvature that the predictor met
        advance          coefficients, slacks and multipliers
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.fit.band import empty
from toolpace.kernels.fit.iterate import new_iterate, new_step
from toolpace.kernels.fit.smoothest_steps import (
    advance,
    centre,
    factor_newton,
    measure,
    residuals,
    start,
    stretches,
    take_step,
)
from toolpace.kernels.fit.tube import Free, Roughness, Samples, Tube
from toolpace.kernels.jit import jit

INFEASIBLE = 5e-3
"""Share of the squared radius by which a sample may be outside at the end: half as much of the radius."""
ROUNDING = 1e-9
"""Gap, as a share of the accuracy, below which what goes on is rounding."""


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
    for iteration in range(max_steps):
        residuals(rough, samples, tube.pull, radius, x, free, now)
        part = stretches(rough, samples, tube.pull, floor, accuracy, now)
        value = np.sum(part)
        if iteration == 0:
            start(samples, radius, free, value / m, now)
        at = measure(rough.weight, samples, tube.pull, radius, part, free, now)
        gap = at.gap
        # below a hundredth of the gap asked for, what is left of the residual is rounding
        even = at.residual <= 0.05 * at.top or at.open_gap <= 0.01 * accuracy
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

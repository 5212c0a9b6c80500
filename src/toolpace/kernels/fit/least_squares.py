"""The smoothing spline: least roughness plus squared deviation."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.fit.assemble import gather, rough_gradient, scatter, scatter_roughness, scatter_samples
from toolpace.kernels.fit.band import empty, factor, solve
from toolpace.kernels.fit.tube import Free, Roughness, Samples
from toolpace.kernels.jit import jit


@jit()
def least_squares(rough: Roughness, samples: Samples, x: Floats, free: Free) -> bool:
    """Minimise the roughness plus the squared deviations in the free coefficients of x (n, g); the others stay."""
    third, weight = rough
    first, rows, target, metric = samples
    low, high = free
    g = x.shape[1]
    n = high - low
    band = empty(n * g, 6 * g)
    scatter_roughness(band, third, weight, low)
    scatter_samples(band, first, rows, metric, low)
    if not factor(band):
        return False
    ignored = np.empty(len(third))
    step = np.empty(n * g)
    value = np.empty((len(first), g))
    off = np.empty(g)
    # the second solution takes away the rounding of the first
    for _ in range(2):
        rough_gradient(third, weight, x, low, n, step, ignored)
        gather(first, rows, x, value)
        for j in range(len(first)):
            for c in range(g):
                off[c] = value[j, c] - target[j, c]
            for c in range(g):
                value[j, c] = 0.0
                for d in range(g):
                    value[j, c] += metric[j, c, d] * off[d]
        scatter(first, rows, value, low, n, step)
        solve(band, step)
        for k in range(n):
            for c in range(g):
                x[low + k, c] -= step[k * g + c]
    return True

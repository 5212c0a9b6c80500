"""The dual function of the continuous problem, over multipliers that are functions of the path parameter.

The integrals are sums over the points of Gauss' rule in cells of time; docs/design/bound.md has the derivation.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.dual import lowest


@jit()
def plain_value(k: Any, theta: Any, kappa: Any, cap: Any, size: Any, measure: Any) -> Any:
    """What a cell adds to the bound as it is: the least of kappa / sqrt(z) + theta z less `size`, integrated."""
    total = 0.0
    for g in range(theta.shape[1]):
        total += (lowest(kappa[k, g], theta[k, g], 0.0, cap[k, g]) - size[k, g]) * measure[k, g]
    return total


@jit()
def evened_value(
    first: Any, count: Any, joint: Any, theta: Any, kappa: Any, ideal: Any, cap: Any, size: Any, measure: Any,
    speed: Any, slope: Any, multiplier: Any, acceleration: Any, length: Any, rule: Any, integral: Any,
) -> Any:  # fmt: skip
    """What some cells add, theta made a multiple of `ideal` there by a further multiplier of one joint's acceleration.

    That multiplier v is zero at both ends; (q'' v - q' v') / (2 a) is what it adds to theta, so that
    (v / q')' = 2 a (theta - share ideal) / q'^2 gives it, and that it ends at zero gives the share.
    """
    points = theta.shape[1]
    top = bottom = 0.0
    for k in range(first, first + count):
        for g in range(points):
            weight = measure[k, g] / slope[k, g, joint] ** 2
            top += theta[k, g] * weight
            bottom += ideal[k, g] * weight
    share = top / bottom
    total = reached = 0.0
    rate = np.empty(points)
    for k in range(first, first + count):
        for g in range(points):
            excess = theta[k, g] - share * ideal[k, g]
            rate[g] = 2.0 * acceleration[joint] * excess / slope[k, g, joint] ** 2 * speed[k, g]
        for g in range(points):
            inner = reached
            for h in range(points):
                inner += length[k] * integral[g, h] * rate[h]
            own = multiplier[k, g, joint]
            cost = size[k, g] - abs(own) + abs(own + slope[k, g, joint] * inner)
            total += (lowest(kappa[k, g], share * ideal[k, g], 0.0, cap[k, g]) - cost) * measure[k, g]
        for h in range(points):
            reached += length[k] * rule[h] * rate[h]
    return total


@jit()
def best_value(
    counts: Any, theta: Any, kappa: Any, ideal: Any, cap: Any, size: Any, measure: Any, speed: Any, slope: Any,
    multiplier: Any, acceleration: Any, length: Any, rule: Any, integral: Any,
) -> Any:  # fmt: skip
    """The greatest sum over all ways to cut the cells into stretches of so many cells, plain or evened.

    Parameters: counts of cells, ascending; (cells, points) theta and kappa: prices of z and of the pace; ideal > 0:
    what theta should be like; cap: on z; size: sum of |multipliers| of acceleration; measure: weights ds; speed: ds/dt;
    (cells, points, joints) slope q' and multiplier of acceleration; acceleration (joints,): limits; length (cells,):
    time; rule (points,) and integral (points, points): weights on [0, 1], up to its end and up to each point.
    """
    cells, points, joints = slope.shape
    reach = np.empty((cells, joints))
    for k in range(cells):
        for j in range(joints):
            reach[k, j] = np.inf
            for g in range(points):
                reach[k, j] = min(reach[k, j], abs(slope[k, g, j]) / acceleration[j])
    best = np.full(cells + 1, -np.inf)
    best[0] = 0.0
    for k in range(cells):
        best[k + 1] = max(best[k + 1], best[k] + plain_value(k, theta, kappa, cap, size, measure))
        for count in counts:
            if k + count > cells:
                break
            joint, least = 0, -1.0
            for j in range(joints):
                worst = np.inf
                for i in range(k, k + count):
                    worst = min(worst, reach[i, j])
                if worst > least:
                    joint, least = j, worst
            if least > 0.0:
                value = evened_value(
                    k, count, joint, theta, kappa, ideal, cap, size, measure, speed, slope, multiplier, acceleration,
                    length, rule, integral,
                )  # fmt: skip
                if best[k] + value > best[k + count]:
                    best[k + count] = best[k] + value
    return best[cells]

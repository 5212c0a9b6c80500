"""The dual function of the continuous problem, over multipliers that are functions of the path parameter.

The integrals are sums over the points of Gauss' rule in cells of time; docs/design/bound.md has the derivation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats, Ints
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal.dual import lowest


class Cells(NamedTuple):
    """What the integrands are made of, at the points of the rule in every cell."""

    theta: Floats
    """(cells, points) price of z."""
    kappa: Floats
    """(cells, points) price of the pace."""
    ideal: Floats
    """(cells, points) > 0: what theta should be like."""
    cap: Floats
    """(cells, points) on z."""
    size: Floats
    """(cells, points) sum of the |multipliers| of acceleration."""
    measure: Floats
    """(cells, points) weights ds."""
    speed: Floats
    """(cells, points) ds/dt."""
    slope: Floats
    """(cells, points, joints) q'."""
    multiplier: Floats
    """(cells, points, joints) of acceleration."""
    length: Floats
    """(cells,) time."""


class Rule(NamedTuple):
    """Gauss' rule on [0, 1]."""

    weight: Floats
    """(points,) of the integral up to its end."""
    up_to: Floats
    """(points, points) of the integrals up to each point."""


@jit(inline=True)
def plain_value(k: int, cells: Cells) -> float:
    """What a cell adds to the bound as it is: the least of kappa / sqrt(z) + theta z less `size`, integrated."""
    theta, kappa, cap, size, measure = cells.theta, cells.kappa, cells.cap, cells.size, cells.measure
    total = 0.0
    for g in range(theta.shape[1]):
        total += (lowest(kappa[k, g], theta[k, g], 0.0, cap[k, g]) - size[k, g]) * measure[k, g]
    return total


@jit()
def evened_value(first: int, count: int, joint: int, cells: Cells, acceleration: Floats, rule: Rule) -> float:
    """What some cells add, theta made a multiple of `ideal` there by a further multiplier of one joint's acceleration.

    That multiplier v is zero at both ends; (q'' v - q' v') / (2 a) is what it adds to theta, so that
    (v / q')' = 2 a (theta - share ideal) / q'^2 gives it, and that it ends at zero gives the share.
    """
    theta, ideal, measure, slope, length = cells.theta, cells.ideal, cells.measure, cells.slope, cells.length
    kappa, cap, size, speed, multiplier = cells.kappa, cells.cap, cells.size, cells.speed, cells.multiplier
    weights, up_to = rule.weight, rule.up_to
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
                inner += length[k] * up_to[g, h] * rate[h]
            own = multiplier[k, g, joint]
            cost = size[k, g] - abs(own) + abs(own + slope[k, g, joint] * inner)
            total += (lowest(kappa[k, g], share * ideal[k, g], 0.0, cap[k, g]) - cost) * measure[k, g]
        for h in range(points):
            reached += length[k] * weights[h] * rate[h]
    return total


@jit()
def best_value(counts: Ints, cells: Cells, acceleration: Floats, rule: Rule) -> float:
    """The greatest sum over all ways to cut the cells into stretches of so many cells, plain or evened.

    Parameters: counts of cells, ascending; acceleration (joints,): limits.
    """
    number, points, joints = cells.slope.shape
    reach = np.empty((number, joints))
    for k in range(number):
        for j in range(joints):
            reach[k, j] = np.inf
            for g in range(points):
                reach[k, j] = min(reach[k, j], abs(cells.slope[k, g, j]) / acceleration[j])
    best = np.full(number + 1, -np.inf)
    best[0] = 0.0
    for k in range(number):
        best[k + 1] = max(best[k + 1], best[k] + plain_value(k, cells))
        for count in counts:
            if k + count > number:
                break
            joint, least = steepest(reach, k, count)
            if least > 0.0:
                value = evened_value(k, count, joint, cells, acceleration, rule)
                if best[k] + value > best[k + count]:
                    best[k + count] = best[k] + value
    return float(best[number])


@jit(inline=True)
def steepest(reach: Floats, k: int, count: int) -> tuple[int, float]:
    """The joint whose |q'| over its limit, in `reach` (cells, joints), is largest where it is least in a stretch."""
    joint, least = 0, -1.0
    for j in range(reach.shape[1]):
        worst = np.inf
        for i in range(k, k + count):
            worst = min(worst, reach[i, j])
        if worst > least:
            joint, least = j, worst
    return joint, least

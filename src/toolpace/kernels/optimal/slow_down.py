"""Where and how gently a motion is slowed down about the places that exceed a limit by little.

z is multiplied by 1 - d about such a place, and by less and less of it on a flank on either side: a polynomial of the
fifth degree over the time W. With f = sqrt(1 - d x), about 1 - d x / 2, the path is passed f times as fast, and

    acceleration changes by  q' f'              at most  SLOPE d |dq/dt| / W
    jerk by                  3 q'' f' + q' f''  at most  3 SLOPE d |d2q/dt2| / W + CURVATURE d |dq/dt| / W^2

beside what it loses. So a flank may be short where all joints have that much left of these limits.
"""

from __future__ import annotations

import numpy as np

from toolpace.kernels.arrays import Bools, Floats
from toolpace.kernels.jit import jit

SLOPE, CURVATURE = 0.94, 2.89
"""Half the largest slope and curvature of x^3 (10 - 15 x + 6 x^2) from 0 to 1."""
OF_WHAT_IS_LEFT = 0.25
"""Share of what a joint has left of a limit at the nodes that a flank may take: between the nodes less is left, and two
flanks may lie over each other."""
LEAST_LEFT = 5e-6
"""Share of a limit that it may take in any case."""
SHORTEST, WIDENING = 2.0, 1.5
"""Time of the shortest flank [ramp times], and by how much longer the next one is that is tried."""
FEWEST_CELLS, BEYOND = 4, 2
"""Of a flank, since the coefficients tell no shorter one, and how many beyond it they change."""
WIDEST, LOSS_A_RAMP = 20.0, 5e-6
"""Time of a flank that is taken whatever is left [ramp times], and most of z that is lost in one of these."""


@jit()
def slow_down(
    times: Floats, loss: Floats, motion: Floats, acceleration: Floats, jerk: Floats, ramp: float, strained: Bools
) -> tuple[Floats, Floats]:
    """Shares (n + 2,) of the coefficients of z that are left, and the time (n - 1,) that this costs, by cell [s].

    Parameters: times (n,) of the nodes; loss (n - 1,) share of z that is taken away in a cell, 0 in most; motion
    (3, n, m) |velocity|, |acceleration| and |jerk| of the joints at the nodes; limits (m,); ramp, time in which an
    acceleration builds up; strained (n - 1,) cells on which no flank shorter than the widest may lie. Cells next to
    each other are slowed down together; their cost is told at the first of them.
    """
    n = len(times)
    left, cost = np.ones(n + 2), np.zeros(n - 1)
    i = 0
    while i < n - 1:
        if not loss[i] > 0.0:
            i += 1
            continue
        # all four coefficients of a cell
        first, low, high, most = i, max(i - 1, 0), min(i + 2, n - 1), loss[i]
        while i < n - 1 and i - 1 <= high:
            if loss[i] > 0.0:
                high, most = min(i + 2, n - 1), max(most, loss[i])
            i += 1
        for k in range(low + 1, high):
            left[k + 1] *= 1.0 - most
        before = flank(times, low, -1, most, motion, acceleration, jerk, ramp, strained)
        after = flank(times, high, 1, most, motion, acceleration, jerk, ramp, strained)
        lower(times, low, -1, most, before, left)
        lower(times, high, 1, most, after, left)
        beside = min(before / 2.0, times[low] - times[0]) + min(after / 2.0, times[n - 1] - times[high])
        cost[first] = most / 2.0 * (times[high] - times[low] + beside)
    return left, cost


@jit()
def flank(
    times: Floats, node: int, way: int, loss: float, motion: Floats, acceleration: Floats, jerk: Floats, ramp: float,
    strained: Bools,
) -> float:  # fmt: skip
    """Time of the shortest flank from a node on, back (-1) or forth (1), that is gentle enough."""
    widest, width = ramp * max(WIDEST, loss / LOSS_A_RAMP), SHORTEST * ramp
    while width < widest:
        k, beyond, gentle = node, 0, True
        while gentle and 0 <= k < len(times) and beyond < BEYOND:
            gentle = is_gentle(k, loss, width, motion, acceleration, jerk)
            cell = k if way > 0 else k - 1
            gentle = gentle and not (0 <= cell < len(strained) and strained[cell])
            if abs(times[k] - times[node]) >= width:
                beyond += 1
            k += way
        if gentle and abs(k - node) >= FEWEST_CELLS + BEYOND:
            return width
        width *= WIDENING
    enough = times[min(max(node + way * FEWEST_CELLS, 0), len(times) - 1)]
    return float(max(widest, abs(enough - times[node])))


@jit()
def is_gentle(k: int, loss: float, width: float, motion: Floats, acceleration: Floats, jerk: Floats) -> bool:
    """Whether a flank over so much time takes little of what all joints have left at node k."""
    for j in range(motion.shape[2]):
        v, a, rate = motion[0, k, j], motion[1, k, j], loss / width
        by = SLOPE * v * rate
        if by > acceleration[j] * max(OF_WHAT_IS_LEFT * (1.0 - a / acceleration[j]), LEAST_LEFT):
            return False
        by = (3.0 * SLOPE * a + CURVATURE * v / width) * rate
        if by > jerk[j] * max(OF_WHAT_IS_LEFT * (1.0 - motion[2, k, j] / jerk[j]), LEAST_LEFT):
            return False
    return True


@jit()
def lower(times: Floats, node: int, way: int, loss: float, width: float, left: Floats) -> None:
    """Lower the coefficients (n + 2,) on a flank from a node on."""
    k = node
    while 0 <= k < len(times):
        x = 1.0 - abs(times[k] - times[node]) / width
        if x <= 0.0:
            break
        left[k + 1] *= 1.0 - loss * x * x * x * (10.0 - x * (15.0 - 6.0 * x))
        k += way

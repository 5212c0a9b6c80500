"""The reason why no second-order motion joins two end states: limit, joint, place."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import InfeasibleError
from toolpace.kernels.planners import reachability
from toolpace.machine.limits import Limits
from toolpace.path.axis_run import AxisRun
from toolpace.planning.second_order.problem import Cells

CURES = {
    reachability.UNREACHABLE: "arriving in motion, no state reaches the end; arrive more slowly",
    reachability.TOO_FAST: "starting in motion, it cannot slow down in time; start more slowly",
    reachability.TOO_SLOW: "the end asks for more speed than can be gathered; arrive more slowly",
}


def refusal(
    run: AxisRun, limits: Limits, cells: Cells, ends: tuple[float, float], status: int, node: int
) -> InfeasibleError:
    """The error of a solve that went wrong at a node; `ends` are the given z."""
    top = cells.top(*ends)
    if status == reachability.UNREACHABLE:
        low, high, k = reachability.backward(cells.arrays(top), ends[1])
        before, after = (0.0, float(top[k])), (float(low[k + 1]), float(high[k + 1]))
    else:
        k, x = march(cells, top, ends[0], slow=status == reachability.TOO_FAST)
        before, after = (x, x), (ends[1], ends[1]) if k == len(cells.at) - 1 else (0.0, float(top[k + 1]))
    ratio, joint = least_violation(cells, k, before, after)
    place = float(cells.nodes[k])
    block = int(run.block_at(np.array([place]))[0])
    where = f"s = {place:.9g}" + (f" (block {block})" if block else "")
    takes = f"takes {ratio:.4g} of the acceleration limit of {limits.joints[joint]}" if ratio > 1.0 else "is stuck"
    return InfeasibleError(f"no motion within velocity, feed, acceleration: it {takes} near {where}: {CURES[status]}")


def march(cells: Cells, top: Floats, x: float, slow: bool) -> tuple[int, float]:
    """As slowly (or fast) as the rows allow from z = x at the start: the cell where that ends, and z before it."""
    last = len(cells.at) - 1
    for k in range(last):
        rows = cells.rows(k).reshape(-1, 2)
        a, b = (rows * np.where(rows[:, 1:] < 0.0, -1.0, 1.0)).T
        if (np.abs(a * x)[b == 0.0] > 1.0).any():
            return k, x
        a, b = a[b > 0.0], b[b > 0.0]
        least = float(((-1.0 - a * x) / b).max(initial=0.0))
        most = min(float(top[k + 1]), float(((1.0 - a * x) / b).min(initial=np.inf)))
        if least > most:
            return k, x
        x = least if slow else most
    return last, x


def least_violation(cells: Cells, k: int, before: tuple[float, float], after: tuple[float, float]) -> tuple[float, int]:
    """The least peak acceleration over limit that a cell needs, z at its ends within the ranges; and its joint."""
    from scipy.optimize import linprog

    given = [value for low, high in (before, after) for value in (low, high if low == high else 0.0)]
    unit = max(given) or min(before[1], after[1])
    rows = cells.rows(k).reshape(-1, 2) * unit
    limit = np.concatenate([np.concatenate([rows, -rows]), np.full((2 * len(rows), 1), -1.0)], axis=1)
    bounds = [(low / unit, high / unit) for low, high in (before, after)]
    found = linprog([0.0, 0.0, 1.0], A_ub=limit, b_ub=np.zeros(len(limit)), bounds=[*bounds, (0.0, None)])
    if found.status != 0 or found.x is None:
        return 0.0, 0
    row = int(np.argmax(np.abs(found.ineqlin.marginals)))
    return float(found.x[2]), row % cells.q1.shape[1]

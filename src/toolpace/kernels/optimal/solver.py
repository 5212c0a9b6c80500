"""The core of the optimal planner: a primal-dual interior-point method for the speed along a path.

Unknown is z(s) = (ds/dt)^2, a cubic spline with coefficients c, judged at points that lie on its knots:

    minimise    sum_p w_p / sqrt(z_p)
    subject to  z_p <= cap_p                                             velocity, feed
                |r . (z, z', z'')_p| <= 1                                acceleration rows
                |r . (z, z', z'')_p| <= z_p^(-1/2)                       jerk rows

The right side of a jerk row is convex where it would have to be concave; its tangent at the current z lies below it,
so a Newton step that respects the tangent stays feasible, and no outer loop is needed. All rows of a point touch
three coefficients: they are collapsed into a 3 x 3 moment matrix in (z, z', z''), and the Newton matrix has five
diagonals. Predictor and corrector follow Mehrotra (1992). A start outside the constraints is met by `relief`, an
amount by which the rows of a point are relaxed; it shrinks to nothing with the steps taken.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import solver_rows
from toolpace.kernels.optimal.multipliers import LIMIT, STATES
from toolpace.kernels.optimal.newton import factor_tied, solve_tied, tie_vector
from toolpace.kernels.optimal.tiles import TILE, advance, tiled

OPTIMAL, STALLED, BROKEN = 0, 1, 2
BACK_OFF = 0.99
ROUNDING = 300.0
"""The gradient is a difference of large numbers: its tolerance, as a multiple of that of the gap."""


@jit()
def maximise_speed(
    basis: Any,
    node: Any,
    weight: Any,
    cap: Any,
    rows: Any,
    c: Any,
    relief: Any,
    end: Any,
    ratio: Any,
    spread: Any,
    tolerance: Any,
    most_steps: Any,
) -> Any:
    """Coefficients of the fastest z within the rows.

    Parameters: basis (points, 3, 3) and node (points,) tie a point to its coefficients; weight (points,) of the
    time; cap (points,) on z; rows (points, 2 m, 3), the first m of acceleration, the others of jerk, divided by
    their limits; c (n,) start with z > 0 at all points; relief (points, 3) of cap, acceleration and jerk rows,
    positive where the start breaks one; end (2,) REST or MOVING; ratio (2,) = c_1 / c_0 and c_n-2 / c_n-1 at ends
    at rest; spread, the first gap, and tolerance of gap and gradient, relative to the time.
    Returns c, status, steps, and gap and scaled gradient relative to the time.
    """
    points, count, n = rows.shape[0], rows.shape[1], len(c)
    products = points * (2 * count + 1)
    rows = tiled(rows.reshape(points, 3 * count)).reshape(-1, count, 3, TILE)
    weight, cap = tiled(weight.reshape(points, 1))[:, 0], tiled(cap.reshape(points, 1))[:, 0]
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    relief = tiled(relief)
    tiles = len(rows)
    at, affine, change = np.zeros((tiles, STATES, TILE)), np.zeros((tiles, 4, TILE)), np.zeros((tiles, 4, TILE))
    dual, step = np.zeros((tiles, count, 2, TILE)), np.zeros((tiles, count, 2, TILE))
    dual_cap, step_cap = np.zeros((tiles, TILE)), np.zeros((tiles, TILE))
    matrix, spare = np.empty((3, n)), np.empty((3, n))
    rhs, direction, gradient, centring, second = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    solver_rows.states(basis, node, c, relief, tau, at)
    time = 0.0
    for p in range(points):
        time += weight[p // TILE, p % TILE] * at[p // TILE, LIMIT, p % TILE]
    solver_rows.start(points, cap, rows, relief, tau, at, spread * time / products, dual, dual_cap)
    gap, residual = np.inf, np.inf
    for steps in range(most_steps):
        gap, time = solver_rows.newton_system(
            basis, node, weight, cap, rows, relief, tau, at, dual, dual_cap, matrix, rhs, gradient
        )
        tie_vector(gradient, end, ratio)
        residual = 0.0
        for i in range(n):
            residual += abs(gradient[i] * c[i])
        if gap < tolerance * time and residual < ROUNDING * tolerance * time and tau < 1e-9:
            return c, OPTIMAL, steps, gap / time, residual / time
        if not factor_tied(matrix, end, ratio, spare):
            return c, BROKEN, steps, gap / time, residual / time
        # predictor: straight at the optimum, to learn how far one can go
        direction[:] = rhs
        solve_tied(matrix, end, ratio, direction)
        solver_rows.spread(basis, node, direction, affine)
        left = solver_rows.predict(
            basis, node, cap, rows, relief, tau, at, dual, dual_cap, gap, affine, centring, second
        )
        centre = gap / products * max(min(left, 1.0) ** 3, 1e-8)
        # corrector: centred, with the second-order terms that the predictor revealed
        direction[:] = rhs - centre * centring - second
        solve_tied(matrix, end, ratio, direction)
        solver_rows.spread(basis, node, direction, change)
        loss, loss_dual = solver_rows.correct(
            points, cap, rows, relief, tau, at, dual, dual_cap, affine, change, centre, step, step_cap
        )
        go, go_dual = min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)
        if not (go > 0.0 and go_dual > 0.0):
            return c, BROKEN, steps, gap / time, residual / time
        c += go * direction
        advance(dual, step, go_dual)
        advance(dual_cap, step_cap, go_dual)
        tau *= 1.0 - go
        solver_rows.states(basis, node, c, relief, tau, at)
    return c, STALLED, most_steps, gap / time, residual / time

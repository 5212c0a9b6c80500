"""The solver of the optimal planner: a primal-dual interior-point method for the speed along a path.

Unknown is z(s) = (ds/dt)^2, a cubic spline with coefficients c, judged at points on its knots and between them:

    minimise    sum_p w_p / sqrt(z_p)
    subject to  z_p <= cap_p                                             velocity, feed
                |r . (z, z', z'')_p + shift| <= 1                        acceleration rows
                |r . (z, z', z'')_p + shift| <= z_p^(-1/2)               jerk rows

The right side of a jerk row is convex where it would have to be concave; its tangent at the current z lies below it,
so a Newton step that respects the tangent stays feasible, and no outer loop is needed. All rows of a point touch
three coefficients, or four between knots: they are collapsed into a 3 x 3 moment matrix in (z, z', z''), and the Newton
matrix has seven diagonals. Predictor and corrector follow Mehrotra (1992). A start outside the constraints is met by
`relief`, an amount by which the rows of a point are relaxed; it shrinks to nothing with the steps taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit
from toolpace.kernels.optimal import solver_rows
from toolpace.kernels.optimal.limit_rows import PointRows
from toolpace.kernels.optimal.multipliers import (
    BACK_OFF,
    RowSteps,
    RowTiles,
    advance,
    in_tiles,
    product_aimed_at,
    rows_in,
    steps_of,
)
from toolpace.kernels.optimal.newton import (
    Ends,
    System,
    aim_at_centre,
    aim_at_optimum,
    factor_tied,
    system_of,
    tie_vector,
)
from toolpace.kernels.optimal.solver_rows import Caps, caps_of

OPTIMAL, STALLED, BROKEN = 0, 1, 2
BALANCE = 0.1
"""Least share of the gradient that the gap keeps up with: where products of slack and multiplier run ahead of it, the
point comes to lie next to its limits long before it is the best there, and steps are short."""
STEEP = 0.3
"""Tolerance of the gradient, a difference of large numbers, as a multiple of the root of that of the gap."""
LOST = 1e6
"""Gap relative to the time from which there is no way back: there is no motion within the rows."""
RELIEVED = 1e-3
"""Share of the reliefs that may still stand at the end, as a multiple of the same tolerance."""


class Solution(NamedTuple):
    """What the method came to."""

    c: Floats
    """(n,) coefficients of z."""
    status: int
    steps: int
    gap: float
    """Relative to the time."""
    gradient: float
    """Scaled, relative to the time."""
    dual_cap: Floats
    """(tiles, TILE) multipliers of the caps."""
    dual_rows: Floats
    """(tiles, r, 2, TILE) of the rows that were not left out, above and below."""


@jit()
def maximise_speed(
    points: PointRows,
    ends: Ends,
    c: Floats,
    relief: Floats,
    spread: float,
    idle: float,
    tolerance: float,
    most_steps: int,
) -> Solution:
    """Coefficients of the fastest z within the rows.

    Parameters: c (n,) start with z > 0 at all points, overwritten by the result; relief (points, 3) of cap,
    acceleration and jerk rows, positive where the start breaks one; spread, the first gap, and tolerance of the gap,
    relative to the time; idle: rows of which the start uses less in a whole tile of points are left out.
    """
    tiles, caps = in_tiles(points.rows, points.shift, solver_rows.wanted(points, c, idle)), caps_of(points, relief)
    steps, system, gradient = steps_of(tiles), system_of(len(c)), np.empty(len(c))
    products = tiles.points + 2 * rows_in(tiles)
    tau = 1.0 if np.max(relief) > 0.0 else 0.0
    solver_rows.states(points, c, caps, tau, tiles.at)
    time = solver_rows.duration(tiles, caps)
    solver_rows.start(tiles, caps, tau, spread * time / products)
    gap, residual = np.inf, np.inf
    for number in range(most_steps):
        gap, time = solver_rows.newton_system(points, tiles, caps, tau, system, gradient)
        residual = _scaled(gradient, c, ends)
        flat = residual < STEEP * np.sqrt(tolerance) * time
        if gap < tolerance * time and flat and tau < RELIEVED * tolerance:
            return Solution(c, OPTIMAL, number, gap / time, residual / time, caps.dual, tiles.dual)
        if gap > LOST * time or not factor_tied(system, ends):
            return Solution(c, BROKEN, number, gap / time, residual / time, caps.dual, tiles.dual)
        left = _predictor(points, ends, tiles, caps, tau, steps, gap, system)
        centre = max(product_aimed_at(gap, products, left), BALANCE * residual / products)
        go, go_dual = _corrector(points, ends, tiles, caps, tau, steps, centre, system)
        if not (go > 0.0 and go_dual > 0.0):
            return Solution(c, BROKEN, number, gap / time, residual / time, caps.dual, tiles.dual)
        c += go * system.direction
        advance(tiles.dual.reshape(-1), steps.dual.reshape(-1), go_dual)
        advance(caps.dual.reshape(-1), caps.step.reshape(-1), go_dual)
        tau *= 1.0 - go
        solver_rows.states(points, c, caps, tau, tiles.at)
    return Solution(c, STALLED, most_steps, gap / time, residual / time, caps.dual, tiles.dual)


@jit(inline=True)
def _scaled(gradient: Floats, c: Floats, ends: Ends) -> float:
    """Size of the gradient (n,) by what the ends leave free, each entry scaled by its coefficient."""
    tie_vector(gradient, ends)
    residual = 0.0
    for i in range(len(c)):
        residual += abs(gradient[i] * c[i])
    return residual


@jit(inline=True)
def _predictor(
    points: PointRows, ends: Ends, tiles: RowTiles, caps: Caps, tau: float, steps: RowSteps, gap: float, system: System
) -> float:
    """Straight at the optimum, to learn how far one can go: returns the share of the gap that this leaves."""
    aim_at_optimum(system, ends)
    solver_rows.spread(points, system.direction, steps.affine)
    return solver_rows.predict(points, tiles, caps, tau, steps.affine, gap, system)


@jit(inline=True)
def _corrector(
    points: PointRows, ends: Ends, tiles: RowTiles, caps: Caps, tau: float, steps: RowSteps, centre: float,
    system: System,
) -> tuple[float, float]:  # fmt: skip
    """The step that is taken: centred, with the second-order terms that the predictor revealed.

    Returns how much of it can be gone by the coefficients, and by the multipliers.
    """
    aim_at_centre(system, ends, centre)
    solver_rows.spread(points, system.direction, steps.change)
    loss, loss_dual = solver_rows.correct(tiles, caps, tau, steps, centre)
    return min(1.0, BACK_OFF / loss), min(1.0, BACK_OFF / loss_dual)

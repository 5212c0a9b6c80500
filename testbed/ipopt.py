"""CasADi and IPOPT on exactly the project's discretisation: same nodes, spline, rows, caps, weights and ends.

IPOPT's tolerances are absolute, so everything is scaled: unknowns by the start (z next to rest is about 1e-9), rows by
their limits, the time by itself. Jerk rows are written (r . u) sqrt(z) within [-1, 1]; Hessians are exact and sparse.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
from scipy import sparse

from testbed.mesh_problem import mesh_problem
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.planning.optimal.problem import Problem
from toolpace.planning.optimal.solve import start_from
from toolpace.planning.planned_run import AT_REST, EndState

TOLERANCE = 1e-9
STARTS = (0.4, 0.1, 0.02)
"""Shares of the guess at which it starts, one after the other until one converges."""
SUCCEEDED = "Solve_Succeeded"
ANSWERED = (SUCCEEDED, "Solved_To_Acceptable_Level")


class Optimum(NamedTuple):
    """Where IPOPT came to an end on a mesh problem."""

    problem: Problem
    c: np.ndarray
    """Coefficients of z."""
    note: str
    """Its word for how it ended."""

    @property
    def answered(self) -> bool:
        """Whether it says that it found a minimum, to its own tolerance or nearly."""
        return self.note in ANSWERED

    @property
    def law(self) -> SplineLaw:
        """The motion."""
        return SplineLaw(self.problem.nodes, self.c, self.problem.rest)


def optimum(
    axis_path: AxisPath, limits: Limits, n: int, *, start: EndState = AT_REST, end: EndState = AT_REST
) -> Optimum:
    """The optimum of a path on the planner's mesh of n cells, from the first start that converges."""
    problem, s, z = mesh_problem(axis_path, limits, n, start, end)
    for share in STARTS:
        c, note = minimise(problem, start_from(problem, s, z, share))
        if note == SUCCEEDED:
            break
    return Optimum(problem, c, note)


def minimise(problem: Problem, first: np.ndarray) -> tuple[np.ndarray, str]:
    """Coefficients and IPOPT's word for how it ended."""
    count, n = len(problem.node), len(first)
    expand, offset = ends(problem, first)
    place = (np.repeat(np.arange(count), 4), (problem.first[:, None] + np.arange(4)).ravel())
    maps = [sparse.csc_matrix((problem.basis[:, d].ravel(), place), shape=(count, n)) for d in range(3)]
    y = ca.SX.sym("y", expand.shape[1])
    u = [dm(m @ expand) @ y + m @ offset for m in maps]
    floor = maps[0] @ first
    rows, half = problem.rows.copy(), problem.rows.shape[1] // 2
    if problem.lines is not None:
        rows[:, problem.lines.column] = 0.0
    value = [sum(column(rows[:, i, d]) * u[d] for d in range(3)) for i in range(2 * half)]
    root = ca.sqrt(u[0])
    over_speed = over_lines(problem, expand, y, offset, u) if problem.lines is not None else []
    g = [u[0] / floor] + value[:half] + [row * root for row in value[half:]] + over_speed
    time = ca.dot(ca.DM(problem.weight), 1.0 / root)
    scale = float((problem.weight / np.sqrt(floor)).sum())
    ones = np.ones(2 * half * count)
    solver = ca.nlpsol(
        "ipopt",
        "ipopt",
        {"x": y, "f": time / scale, "g": ca.vertcat(*g)},
        {
            "print_time": False,
            "ipopt": {
                "print_level": 0, "sb": "yes", "tol": TOLERANCE, "constr_viol_tol": TOLERANCE,
                "acceptable_tol": 10.0 * TOLERANCE, "bound_relax_factor": 0.0, "honor_original_bounds": "yes",
                "max_iter": 1000, "mu_strategy": "adaptive", "nlp_scaling_method": "none",
            },
        },
    )  # fmt: skip
    result = solver(
        x0=np.ones(expand.shape[1]),
        lbg=np.concatenate([np.full(count, 1e-6), -ones, np.full(count * len(over_speed), -np.inf)]),
        ubg=np.concatenate([problem.cap / floor, ones, np.zeros(count * len(over_speed))]),
    )
    return expand @ np.asarray(result["x"]).ravel() + offset, solver.stats()["return_status"]


def over_lines(
    problem: Problem, expand: sparse.csc_matrix, y: ca.SX, offset: np.ndarray, u: list[ca.SX]
) -> list[ca.SX]:
    """Rows whose limits depend on the speed, less these limits, as they are: not linear in z."""
    lines, count, n = problem.lines, len(problem.node), len(offset)
    place = (np.repeat(np.arange(count), 4), (problem.first[:, None] + np.arange(4)).ravel())
    ahead = sparse.csc_matrix((lines.ahead_of(problem.basis).ravel(), place), shape=(count, n))
    speed, speed_ahead = ca.sqrt(u[0]), ca.sqrt(dm(ahead @ expand) @ y + ahead @ offset)
    excess = []
    for k, is_jerk in enumerate(lines.is_jerk):
        limit = -ca.inf
        for height, fall in zip(lines.height[:, k].T, lines.fall[:, k].T):
            line = column(height) - column(fall) * (speed if is_jerk else speed_ahead)
            limit = ca.fmax(limit, line) if len(lines.height[0, k]) > 1 else line
        value = sum(column(lines.rows[:, k, d]) * u[d] for d in range(3))
        excess.append((value * speed if is_jerk else value) - limit)
    return excess


def column(values: np.ndarray) -> ca.DM:
    """A column of CasADi's."""
    return ca.DM(np.ascontiguousarray(values))


def ends(problem: Problem, first: np.ndarray) -> tuple[sparse.csc_matrix, np.ndarray]:
    """(n, free) matrix and (n,) offset: coefficients from the unknowns, which are one at the start point."""
    n = len(first)
    low, high = (1, 1) if problem.end[0] == 0 else (2, 2), (1, 1) if problem.end[1] == 0 else (2, 2)
    free = np.arange(low[0], n - high[0])
    rows, columns, values = list(free), list(range(len(free))), list(first[free])
    offset = np.zeros(n)
    for k, (one, two) in enumerate(((0, 1), (n - 1, n - 2))):
        if problem.end[k] == 0:
            rows.append(one)
            columns.append(0 if k == 0 else len(free) - 1)
            values.append(first[two] / problem.ratio[k])
        else:
            offset[one], offset[two] = first[one], first[two]
    return sparse.csc_matrix((values, (rows, columns)), shape=(n, len(free))), offset


def dm(matrix: sparse.spmatrix) -> ca.DM:
    """A CasADi matrix of a scipy one."""
    m = sparse.csc_matrix(matrix)
    m.sort_indices()
    pattern = ca.Sparsity(*m.shape, m.indptr.tolist(), m.indices.tolist())
    return ca.DM(pattern, m.data)

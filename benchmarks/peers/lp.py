"""A two-stage linear program in the manner of OpenCN, with scipy's HiGHS, on the project's own discretisation.

First as much z as velocity and acceleration allow, then again with jerk rows |r . u| <= 1 / sqrt(z of the first stage),
which are on the safe side as z stays below it. A linear program cannot minimise time: z is weighed by the derivative
of time at the project's first guess. Even so it may creep through a few nodes, which costs it little and time a lot.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from benchmarks.peers import Outcome, Stopwatch, failed, usage_of_law
from testbed.ipopt import ends
from testbed.mesh_problem import mesh_problem, objective
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.planning.optimal.solve import start_from

FLOOR = 1e-3
"""Least z, as a share of the guess."""


def solve(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """Both stages, from rest to rest."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    problem, s, z = mesh_problem(axis_path, limits, n)
    first = start_from(problem, s, z, 1.0)
    expand, _ = ends(problem, first)
    count, half = len(problem.node), problem.rows.shape[1] // 2
    place = (np.repeat(np.arange(count), 4), (problem.first[:, None] + np.arange(4)).ravel())
    shape = (count, len(first))
    maps = [sparse.csr_matrix((problem.basis[:, d].ravel(), place), shape=shape) @ expand for d in range(3)]
    scale = maps[0] @ np.ones(expand.shape[1])
    value = maps[0].multiply(1.0 / scale[:, None]).tocsr()
    rows = [sum(maps[d].multiply(problem.rows[:, i, d][:, None]) for d in range(3)).tocsr() for i in range(2 * half)]
    most = problem.cap / scale
    gain = np.asarray(value.multiply((problem.weight / np.sqrt(scale))[:, None]).sum(axis=0)).ravel()
    gain /= gain.max()
    blocks, bounds = [rows[i] for i in range(half)], [np.ones(count)] * half
    y = np.empty(0)
    for stage in range(2):
        if stage == 1:
            most = np.minimum(most, value @ y)
            root = np.sqrt(most * scale)
            blocks += [row.multiply(root[:, None]).tocsr() for row in rows[half:]]
            bounds += [np.ones(count)] * half
        matrix = sparse.vstack(blocks)
        limit = np.concatenate(bounds)
        result = linprog(
            -gain,
            A_ub=sparse.vstack([matrix, -matrix, value, -value]),
            b_ub=np.concatenate([limit, limit, most, np.full(count, -FLOOR * FLOOR)]),
            bounds=(None, None),
            method="highs-ipm",
        )
        if result.status != 0:
            return failed(watch(), f"stage {stage + 1}: {result.message}")
        y = result.x
    seconds = watch()
    c = expand @ y
    law = SplineLaw(problem.nodes, c, problem.rest)
    at_nodes, between = usage_of_law(run, limits, law)
    return Outcome(law.duration, seconds, at_nodes, between, True, "", objective(problem, c), len(law.nodes))

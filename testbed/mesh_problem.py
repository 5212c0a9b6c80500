"""The optimal planner's problem on a fixed mesh, as it is given to other solvers, and the time as it counts it."""

from __future__ import annotations

import numpy as np

from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.problem import Problem, discretise
from toolpace.planning.planned_run import AT_REST, EndState


def mesh_problem(
    axis_path: AxisPath,
    limits: Limits,
    n: int,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
) -> tuple[Problem, np.ndarray, np.ndarray]:
    """The discretised problem on exactly the planner's mesh of n cells, and the guess (s, z) that it starts from."""
    run = axis_path.runs[0]
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), n)
    return discretise(run, limits, nodes, start, end), rough.s, rough.z


def objective(problem: Problem, c: np.ndarray) -> float:
    """Time as the problem sums it over its nodes [s]."""
    z = np.einsum("pj,pj->p", problem.basis[:, 0], c[problem.first[:, None] + np.arange(4)])
    return float((problem.weight / np.sqrt(z)).sum())

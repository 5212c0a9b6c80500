"""toolpace itself, on a fixed mesh of n cells; `guarded` holds the limits between the nodes too."""

from __future__ import annotations

import numpy as np

from benchmarks.peers import Outcome, Stopwatch, failed, usage_of_law
from toolpace.axispath.axispath import AxisPath
from toolpace.errors import ToolpaceError
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import AT_REST, EndState
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.problem import Problem, discretise


def solve(axis_path: AxisPath, limits: Limits, n: int, *, guard: bool = False, judge: bool = True) -> Outcome:
    """The planner in one thread: mesh, rows and solution, from the bare callable."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    try:
        law, points = fastest_law(run, limits, cells=n, guard=guard)
    except ToolpaceError as error:
        return failed(watch(), str(error))
    seconds = watch()
    if not judge:
        return Outcome(law.duration, seconds, points=points)
    at_nodes, between = usage_of_law(run, limits, law)
    return Outcome(law.duration, seconds, at_nodes, between, points=points)


def guarded(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """The same with the guarantee between the nodes."""
    return solve(axis_path, limits, n, guard=True)


def mesh_problem(
    axis_path: AxisPath,
    limits: Limits,
    n: int,
    start: EndState = AT_REST,
    end: EndState = AT_REST,
) -> tuple[Problem, np.ndarray, np.ndarray]:
    """The discretised problem on exactly the mesh that `solve` uses, and the guess (s, z) it starts from."""
    run = axis_path.runs[0]
    nodes, rough = first_mesh(run, limits, (start.speed**2, end.speed**2), n)
    return discretise(run, limits, nodes, start, end), rough.s, rough.z


def objective(problem: Problem, c: np.ndarray) -> float:
    """Time as the problem sums it [s]."""
    z = np.einsum("pj,pj->p", problem.basis[:, 0], c[problem.node[:, None] + np.arange(3)])
    return float((problem.weight / np.sqrt(z)).sum())

"""Why z is a cubic spline: the same nodes and limits with a once differentiable quadratic one, both at their optimum.

    python -m benchmarks.splines        writes benchmarks/results/splines.md

In the quadratic spline z'' is constant in a cell, so jerk rows are needed at both ends of every cell. Neither is
guarded between the nodes here; the last column is what the guard makes of the cubic one.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.peers import Outcome, failed, ours, usage
from benchmarks.tables import Table, text
from testbed.cases import Case, fan, flank, paper_arc, random_case
from testbed.mesh_problem import mesh_problem
from toolpace.planning.optimal.problem import Problem

MESHES = (200, 1000)


def quadratic(case: Case, n: int) -> Outcome:
    """IPOPT's optimum with z a quadratic spline on our nodes, its values and slopes at the nodes the unknowns."""
    run, limits = case.run, case.limits
    problem, s, guess = mesh_problem(case.axis_path, limits, n)
    nodes = problem.nodes
    step, count = np.diff(nodes), len(nodes)
    z0 = 0.4 * np.interp(nodes, s, guess**0.75) ** (4.0 / 3.0)
    slope0 = np.gradient(z0, nodes)
    scale = np.abs(slope0) + z0 / (nodes[-1] - nodes[0])
    x = ca.SX.sym("x", 2 * count)
    z, slope = x[:count] * ca.DM(z0), x[count:] * ca.DM(scale)
    curve = (slope[1:] - slope[:-1]) / ca.DM(step)
    ties = [
        (z[1:] - z[:-1] - ca.DM(step / 2.0) * (slope[1:] + slope[:-1])) / ca.DM(z0[1:]),
        (slope[0] * 0.75 * problem.rest[0] - z[0]) / z0[0],
        (slope[-1] * 0.75 * problem.rest[1] + z[-1]) / z0[-1],
    ]
    rows = []
    right, left = run.evaluate(nodes), run.evaluate(np.nextafter(nodes, -np.inf))
    for j in range(len(limits)):
        for q, at in ((right, slice(0, count - 1)), (left, slice(1, count))):
            q1, q2, q3 = (ca.DM(q[k][at, j]) for k in (1, 2, 3))
            rows.append((q2 * z[at] + q1 * slope[at] / 2.0) / limits.acceleration[j])
            jerk = q3 * z[at] + 1.5 * q2 * slope[at] + 0.5 * q1 * curve
            rows.append(jerk * ca.sqrt(z[at]) / limits.jerk[j])
    tied = sum(e.numel() for e in ties)
    inside = np.ones(sum(e.numel() for e in rows))
    solver = ca.nlpsol(
        "ipopt", "ipopt", {"x": x, "f": time_of(problem, z), "g": ca.vertcat(*ties, *rows, x[:count])},
        {"print_time": False, "ipopt": {
            "print_level": 0, "sb": "yes", "tol": 1e-9, "max_iter": 1500, "mu_strategy": "adaptive",
            "nlp_scaling_method": "none", "bound_relax_factor": 0.0,
        }},
    )  # fmt: skip
    cap = np.full(count, np.inf)
    np.minimum.at(cap, problem.node, problem.cap)
    answer = solver(
        x0=np.concatenate([np.ones(count), slope0 / scale]),
        lbg=np.concatenate([np.zeros(tied), -inside, np.full(count, 1e-6)]),
        ubg=np.concatenate([np.zeros(tied), inside, cap / z0]),
    )
    if solver.stats()["return_status"] != "Solve_Succeeded":
        return failed(0.0, solver.stats()["return_status"])
    found = np.asarray(answer["x"]).ravel()
    value, rate = found[:count] * z0, found[count:] * scale

    def state(cell: np.ndarray, share: np.ndarray, at: np.ndarray) -> np.ndarray:
        d, bend = share * step[cell], (rate[cell + 1] - rate[cell]) / step[cell]
        v = np.sqrt(np.maximum(value[cell] + d * (rate[cell] + 0.5 * d * bend), 1e-15))
        return np.stack([at, v, (rate[cell] + d * bend) / 2.0, bend * v / 2.0])

    return Outcome(float(time_of(problem, ca.DM(value))), 0.0, *usage(run, limits, nodes, state))


def time_of(problem: Problem, z: ca.SX) -> ca.SX:
    """The time as the problem sums it."""
    weight = np.bincount(problem.node, problem.weight)
    return ca.dot(ca.DM(weight), 1.0 / ca.sqrt(z))


def main() -> None:
    """The table, on the terminal and in benchmarks/results."""
    heads = ["case", "n", "quadratic [s]", "usage between", "cubic [s]", "usage between", "cubic, guarded [s]"]
    table = Table("Quadratic and cubic spline of the squared speed on the same nodes", heads)
    for case in (flank(), fan(), paper_arc(), random_case(0), random_case(1)):
        for n in MESHES:
            q = quadratic(case, n)
            c, g = ours.solve(case.axis_path, case.limits, n), ours.guarded(case.axis_path, case.limits, n)
            cells = (q.duration, q.between, c.duration, c.between, g.duration)
            table.lines.append([case.name, str(n), *(text(v if np.isfinite(v) else None) for v in cells)])
    table.show()
    head = f"# Quadratic and cubic splines\n\n{written_by('python -m benchmarks.splines')}\n\n"
    (RESULTS / "splines.md").write_text(head + table.markdown())


if __name__ == "__main__":
    main()

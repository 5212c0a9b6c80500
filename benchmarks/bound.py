"""How far plans may be from the best possible, and what it costs to know: gap and CPU time over meshes.

python -m benchmarks.bound        writes benchmarks/results/bound.md
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks.__main__ import RESULTS
from benchmarks.paths import Case, all_cases
from benchmarks.tables import Table
from toolpace.plan.bound import Bound, bound_run
from toolpace.plan.optimal import plan_run

MESHES = (200, 1000, 5000, None)
"""Cells; None is the mesh that the planner chooses."""


def measure(case: Case, cells: int | None) -> tuple[Bound, int, float, float]:
    """The bound of the guarded plan, its mesh points, and the CPU time of plan and bound in one thread [s]."""
    began = time.thread_time()
    law, points = plan_run(case.run, case.limits, cells=cells)
    planned = time.thread_time()
    found = bound_run(case.run, case.limits, law)
    return found, points, planned - began, time.thread_time() - planned


def main() -> None:
    """The tables, on the terminal and in benchmarks/results."""
    cases = all_cases()
    measure(cases[-1], 200)
    heads = ["case", "n", "duration [s]", "lower bound [s]", "gap [%]", "steps", "bound / plan, time", "places"]
    table = Table("Lower bound of guarded plans, default mesh", heads)
    summary = Table("Over all cases", ["n", "gap, median [%]", "gap, worst [%]", "bound / plan, time, median", "worst"])
    for cells in MESHES:
        gaps, costs = [], []
        for case in cases:
            found, points, plan_time, bound_time = measure(case, cells)
            gaps.append(100.0 * found.gap)
            costs.append(bound_time / plan_time)
            if cells is None:
                where = ", ".join(f"{low:.3f}" for low, _, _ in found.places[:4])
                table.lines.append([
                    case.name, str(points), f"{found.duration:.6f}", f"{found.seconds:.6f}", f"{gaps[-1]:.4f}",
                    str(found.steps), f"{costs[-1]:.2f}", where,
                ])  # fmt: skip
        summary.lines.append([
            str(cells or "default"), f"{np.median(gaps):.4f}", f"{max(gaps):.4f}", f"{np.median(costs):.2f}",
            f"{max(costs):.2f}",
        ])  # fmt: skip
    for one in (summary, table):
        one.show()
    (RESULTS / "bound.md").write_text(summary.markdown() + "\n" + table.markdown())


if __name__ == "__main__":
    main()
